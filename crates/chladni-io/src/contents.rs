//! The content of files that were read, to be written to another.

use super::paths::shortened;
use super::{DatasetInfo, Document, Function, Shape};
use crate::limits::PATHS_LISTED;
use chladni_frf::{Finding, FrfSet, Geometry, Source};

/// The content of the files of one command together.
#[derive(Debug, Clone, Default)]
pub struct Contents {
    /// All FRFs, where there are any.
    pub frf: Option<FrfSet>,
    /// Nodes, lines and faces of files without FRFs; otherwise they are in `frf`.
    pub other_geometry: Geometry,
    /// Functions that are no FRFs of the set: time records, spectra, ...
    pub functions: Vec<Function>,
    /// Mode shapes and fields at nodes.
    pub shapes: Vec<Shape>,
    /// The files, in the order read.
    pub sources: Vec<Source>,
    /// Datasets of types that are not known, whose content is not here; `convert` names them.
    pub not_carried: Vec<String>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

impl Contents {
    /// Nodes, lines and faces.
    pub fn geometry(&self) -> &Geometry {
        self.frf
            .as_ref()
            .map_or(&self.other_geometry, |frf| &frf.geometry)
    }
}

/// The datasets of a document whose content is not carried on, equal ones in one sentence.
pub(super) fn not_carried(document: &Document) -> Vec<String> {
    let file = document.file.display();
    let mut numbered: Vec<(&DatasetInfo, usize)> = Vec::new();
    let mut paths: Vec<String> = Vec::new();
    for info in document.datasets.iter().filter(|info| info.left_behind) {
        match numbered
            .iter_mut()
            .find(|(first, _)| first.number == info.number)
        {
            _ if info.number.is_none() => paths.push(
                if info.name.starts_with("/model/") {
                    "/model"
                } else {
                    &info.name
                }
                .into(),
            ),
            Some((_, count)) => *count += 1,
            None => numbered.push((info, 1)),
        }
    }
    paths.dedup();
    let mut left: Vec<String> = numbered
        .into_iter()
        .map(|(info, count)| {
            let name = format!(
                "dataset {} ({})",
                info.number.unwrap_or_default(),
                info.name
            );
            let place = info
                .line
                .map_or_else(String::new, |line| format!(" in line {line}"));
            match count {
                1 => format!("{file}: {name}{place} is not carried over"),
                _ => format!(
                    "{file}: {name}: {count} of them, the first{place}, are not carried over"
                ),
            }
        })
        .collect();
    if !paths.is_empty() {
        left.push(format!(
            "{file}: not carried over: {}",
            shortened(&paths, PATHS_LISTED)
        ));
    }
    left
}

/// The word for a function type of dataset 58.
pub(super) fn function_name(function_type: i32) -> &'static str {
    match function_type {
        1 => "time",
        2 => "auto spectrum",
        3 => "cross spectrum",
        4 => "frf",
        5 => "transmissibility",
        6 => "coherence",
        7 => "auto correlation",
        8 => "cross correlation",
        9 => "power spectral density",
        10 => "energy spectral density",
        12 => "spectrum",
        18 => "mode indicator",
        26 => "multiple coherence",
        27 => "order",
        _ => "function",
    }
}
