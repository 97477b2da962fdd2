//! The files that a demonstration writes.

use crate::limits::SCENES;
use chladni_console::output::{make_folder, Output, FRF, HTML, MODEL, SCENE};
use chladni_console::Console;
use chladni_frf::Result;
use std::path::{Path, PathBuf};

/// The files of a demonstration.
pub(super) struct Files {
    pub(super) panel: PathBuf,
    pub(super) truth: PathBuf,
    pub(super) model: PathBuf,
    pub(super) scenes: Vec<PathBuf>,
    pub(super) weights: Vec<PathBuf>,
    /// The measured field of the first scene.
    pub(super) field: PathBuf,
    /// The weights that this field corrected.
    pub(super) corrected: PathBuf,
    pub(super) report: PathBuf,
}

impl Files {
    /// Makes the folder, and refuses to overwrite anything without `--force`.
    ///
    /// # Errors
    /// A folder that cannot be made; a file that exists already.
    pub(super) fn new(folder: &Path, console: &Console) -> Result<Self> {
        let numbered = |stem: &str, extension: &str| {
            (1..=SCENES)
                .map(|k| folder.join(format!("{stem}-{k}.{extension}")))
                .collect()
        };
        let files = Self {
            panel: folder.join("panel.h5"),
            truth: folder.join("truth.json"),
            model: folder.join("model.json"),
            scenes: numbered("scene", "toml"),
            weights: numbered("weights", "json"),
            field: folder.join("field-1.csv"),
            corrected: folder.join("weights-1-corrected.json"),
            report: folder.join("report.html"),
        };
        make_folder(folder, "-o")?;
        for path in files.all() {
            Output::new(path, &[FRF, MODEL, SCENE, HTML].concat(), &[], console)?;
        }
        Ok(files)
    }

    /// Every file, in the order in which they are written.
    pub(super) fn all(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.panel, &self.truth, &self.model]
            .into_iter()
            .chain(&self.scenes)
            .chain(&self.weights)
            .chain([&self.field, &self.corrected, &self.report])
    }
}
