//! Drive signals of `chladni render --wav`.

use crate::signal_files::SignalFiles;
use chladni_frf::{Error, ModalModel, Result};
use chladni_render::{play, signal_csv, PlayOptions, Scene, Signal, SignalOptions, Weights};

/// Drive signals, made before any file is written.
pub enum Drive {
    /// A table of amplitudes and phases.
    Table(String),
    /// The samples that `play` makes of the weights.
    Samples(Box<Signal>),
}

impl Drive {
    /// The signals of `weights`, in the form that the file's name asks for.
    ///
    /// # Errors
    /// Those of [`play`], as `blame` names their file.
    pub fn of(
        files: &SignalFiles,
        model: &ModalModel,
        scene: &Scene,
        weights: &Weights,
        blame: impl Fn(Error) -> Error,
    ) -> Result<Self> {
        if files.is("csv") {
            return Ok(Self::Table(signal_csv(weights)));
        }
        let played = play(model, scene, Some(weights), &PlayOptions::default()).map_err(blame)?;
        let mut signal = played.signal(&SignalOptions::default(), &scene.name())?;
        signal.sidecar.source = weights.source.clone();
        Ok(Self::Samples(Box::new(signal)))
    }

    /// Writes the signals to the files asked for.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write(&self, files: &SignalFiles) -> Result<()> {
        match self {
            Self::Table(text) => files.write_text(text),
            Self::Samples(signal) => files.write(signal, SignalOptions::default().format),
        }
    }
}
