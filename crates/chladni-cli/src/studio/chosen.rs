//! The model that renders: the fitted or opened one, with the modes that were added on the page and
//! without those that were dropped there. It is the one that the commands on the page write, to the
//! last byte, since weights name the checksum of their model.

use super::question::source_of_text;
use super::session::Session;
use crate::select::again;
use chladni_frf::{Error, ModalModel, Result, Selection, Source};
use chladni_io::{checksum_of_bytes, model_json, selection_from_toml};
use chladni_rfp::FitOptions;
use std::sync::Arc;

/// Name of the fitted model in the commands on the page.
pub(super) const MODEL: &str = "model.json";
/// The same of a fitted model with the modes that were added on the page.
const ADDED: &str = "added.json";
/// The selection that adds them.
const ADDED_TOML: &str = "added.toml";
/// Name of a model without the modes that were dropped on the page.
const SELECTED: &str = "selected.json";
/// The selection that drops them.
const SELECTION: &str = "selection.toml";

/// The content of the file that adds these modes, Hz; empty without any.
pub(super) fn added_toml(added_hz: &[f64]) -> String {
    let place = |hz: &f64| format!("{{frequency_hz = {hz:?}}}");
    let places: Vec<String> = added_hz.iter().map(place).collect();
    match places.is_empty() {
        true => String::new(),
        false => format!("add = [{}]\n", places.join(", ")),
    }
}

impl Session {
    /// The file of the fitted or opened model in the commands on the page.
    pub(super) fn model_file(&self, whole: &ModalModel) -> &str {
        match (self.opened_words(), whole.options.contains_key("added_hz")) {
            (Some(words), _) => words,
            (None, true) => ADDED,
            (None, false) => MODEL,
        }
    }

    /// The file of the model that renders, in the commands on the page.
    pub(super) fn chosen_file(&self, whole: &ModalModel, selection: &str) -> &str {
        match selection.is_empty() {
            true => self.model_file(whole),
            false => SELECTED,
        }
    }

    /// The command that adds modes, and the file that it reads; both empty where none is added.
    pub(super) fn add_command(&self, added_hz: &[f64]) -> [String; 2] {
        let toml = added_toml(added_hz);
        let command = match toml.is_empty() {
            true => String::new(),
            false => format!(
                "chladni select {MODEL} {ADDED_TOML} -o {ADDED} --measured {}",
                self.file_words
            ),
        };
        [command, toml]
    }

    /// A model without the modes that `selection` drops; it names its sources.
    ///
    /// # Errors
    /// Those of [`selected`]; a model that has no JSON.
    pub(super) fn chosen(
        &self,
        whole: &Arc<ModalModel>,
        selection: &str,
    ) -> Result<Arc<ModalModel>> {
        let mut model = selected(whole, selection)?;
        if !selection.is_empty() {
            let sources = [self.source_of(whole)?, source_of_text(SELECTION, selection)];
            Arc::make_mut(&mut model).source.extend(sources);
        }
        Ok(model)
    }

    /// The file of `model` as the source of weights: the opened one, or one that the commands on
    /// the page write.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Internal`] where it has no JSON.
    pub(super) fn chosen_source(&self, model: &ModalModel, selection: &str) -> Result<Source> {
        match selection.is_empty() {
            true => self.source_of(model),
            false => source_of_model(SELECTED, model),
        }
    }

    /// The file of the fitted or opened model.
    fn source_of(&self, whole: &ModalModel) -> Result<Source> {
        match &self.model_source {
            Some(opened) => Ok(opened.clone()),
            None => source_of_model(self.model_file(whole), whole),
        }
    }

    /// The fitted or opened model.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] before the first fit.
    pub(super) fn current_model(&self) -> Result<Arc<ModalModel>> {
        self.current()
            .ok_or_else(|| Error::bad_data("no model yet").help("fit first"))
    }
}

/// The model that a new fit with added modes gave, as the file of the command that adds them
/// holds it.
///
/// * `before`: the fit without them
/// * `options`: those of the new fit
///
/// # Errors
/// Those of the selection that adds them; [`chladni_frf::ErrorKind::Internal`] where a model has no
/// JSON.
pub(super) fn with_added(
    fitted: ModalModel,
    before: &ModalModel,
    options: &FitOptions,
) -> Result<ModalModel> {
    let after = again(fitted, before, options);
    let added = Selection::new(false, Vec::new()).adding(options.added_hz.clone());
    let mut model = added.carried(before, &after)?.apply(&after)?.model;
    model.source.extend([
        source_of_model(MODEL, before)?,
        source_of_text(ADDED_TOML, &added_toml(&options.added_hz)),
    ]);
    Ok(model)
}

/// A model without the modes that `selection` drops; the same one where it is empty.
///
/// # Errors
/// A selection that cannot be read, or names no mode of the model.
pub(super) fn selected(whole: &Arc<ModalModel>, selection: &str) -> Result<Arc<ModalModel>> {
    if selection.is_empty() {
        return Ok(whole.clone());
    }
    let picked = selection_from_toml(selection).and_then(|picked| picked.apply(whole));
    Ok(Arc::new(
        picked.map_err(|error| error.file(SELECTION))?.model,
    ))
}

fn source_of_model(file: &str, model: &ModalModel) -> Result<Source> {
    Ok(Source {
        file: file.into(),
        checksum: checksum_of_bytes(model_json(model)?.as_bytes()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_frequencies_are_read_back_to_the_last_bit() {
        for added in [vec![], vec![123.0], vec![0.1 + 0.2, 1e-9, 54.4]] {
            let toml = added_toml(&added);
            match added.is_empty() {
                true => assert_eq!(toml, ""),
                false => assert_eq!(selection_from_toml(&toml).unwrap().added_hz(), added),
            }
        }
    }
}
