//! A drive signal and the file beside it.

use chladni_console::output::Output;
use chladni_console::{bytes_to_stdout, is_standard_output, unbroken, Console};
use chladni_frf::Result;
use chladni_io::{write_atomically, write_npz, write_together, NamedArray};
use chladni_render::{SampleFormat, Signal};
use chladni_text::door::Claim;
use std::path::{Path, PathBuf};

/// The files that a drive signal is written to.
pub struct SignalFiles {
    path: PathBuf,
    /// The JSON file beside a sound file.
    sidecar: Option<PathBuf>,
    force: bool,
    /// Claims on both files, so that no input is read from them.
    _claims: Vec<Claim>,
}

impl SignalFiles {
    /// Checks the path that `option` names, and that of its sidecar, before the work.
    ///
    /// # Errors
    /// As [`Output::new`].
    pub fn new(
        option: &str,
        path: &Path,
        extensions: &[&str],
        inputs: &[PathBuf],
        console: &Console,
    ) -> Result<Self> {
        let mut files = Self {
            path: path.to_path_buf(),
            sidecar: None,
            force: console.force,
            _claims: Vec::new(),
        };
        Output::asked(option, Some(path), extensions, inputs, console)?;
        if is_standard_output(path) {
            return Ok(files);
        }
        if files.is("wav") {
            let sidecar = path.with_extension("json");
            Output::asked(option, Some(&sidecar), &["json"], inputs, console)?;
            files._claims.push(Claim::new(&sidecar)?);
            files.sidecar = Some(sidecar);
        }
        files._claims.push(Claim::new(path)?);
        Ok(files)
    }

    /// True where the file has this extension; the standard output counts as `csv`.
    pub fn is(&self, extension: &str) -> bool {
        if is_standard_output(&self.path) {
            return extension == "csv";
        }
        self.path
            .extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
    }

    /// The file beside the sound file.
    pub fn sidecar(&self) -> Option<&Path> {
        self.sidecar.as_deref()
    }

    /// Writes the signal in the format that the extension names.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write(&self, signal: &Signal, format: SampleFormat) -> Result<()> {
        if self.is("csv") {
            return self.write_text(&signal.csv());
        }
        if self.is("npz") {
            return self.write_npz(signal);
        }
        let bytes = signal.wav(format)?;
        let text = signal.sidecar.to_json()?;
        let mut files = vec![(self.path.as_path(), bytes.as_slice())];
        files.extend(
            self.sidecar
                .as_deref()
                .map(|sidecar| (sidecar, text.as_bytes())),
        );
        unbroken(|| write_together(&files, self.force))
    }

    /// Writes `text` in place of a signal.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_text(&self, text: &str) -> Result<()> {
        self.write_bytes(&self.path, text.as_bytes())
    }

    fn write_bytes(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        if is_standard_output(path) {
            return bytes_to_stdout(bytes);
        }
        unbroken(|| write_atomically(path, self.force, |out| out.write_all(bytes)))
    }

    fn write_npz(&self, signal: &Signal) -> Result<()> {
        let channels = &signal.sidecar.channels;
        let drive = signal.driven();
        let values: Vec<f64> = drive.iter().copied().collect();
        let (frames, count) = drive.dim();
        let references = channels.iter().map(|channel| channel.reference.to_string());
        let units = channels.iter().map(|channel| channel.unit.to_string());
        let rate = [f64::from(signal.sidecar.rate_hz)];
        let arrays = [
            ("drive", NamedArray::Numbers(&values, vec![frames, count])),
            ("rate_hz", NamedArray::Numbers(&rate, Vec::new())),
            ("reference", NamedArray::Texts(references.collect())),
            ("unit", NamedArray::Texts(units.collect())),
        ];
        unbroken(|| write_npz(&self.path, &arrays, self.force))
    }
}
