//! What an interrupted run leaves beside its output, so that the next can go on.
//!
//! One line of JSON that says of which files it is, then the partial so far.

use chladni_console::unbroken;
use chladni_frf::{Error, Result};
use chladni_io::write_atomically;
use chladni_rfp::pieces::Partial;
use serde_json::{json, Value};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, UNIX_EPOCH};

/// Keeping what was done may cost one part in so many of the time.
const SHARE: u32 = 40;

/// What is kept, and where.
pub struct Resume {
    place: Option<PathBuf>,
    inputs: Value,
    /// When it was kept last, and how long that took.
    kept: Instant,
    cost: Duration,
    found: Option<Partial>,
}

impl Resume {
    /// Beside `output` (nowhere without one); with `goes_on` what an interrupted run left
    /// there is taken up.
    ///
    /// * `parts`: number of parts that `files` are cut into
    ///
    /// # Errors
    /// What was left belongs to other files, or is damaged.
    pub fn new(
        output: Option<&Path>,
        files: &[PathBuf],
        parts: usize,
        goes_on: bool,
    ) -> Result<Self> {
        let place = output.map(|output| {
            let mut name = OsString::from(output);
            name.push(".resume");
            PathBuf::from(name)
        });
        let mut this = Self {
            place,
            inputs: described(files, parts)?,
            kept: Instant::now(),
            cost: Duration::ZERO,
            found: None,
        };
        if let Some(place) = this
            .place
            .as_ref()
            .filter(|place| goes_on && place.exists())
        {
            this.found = Some(this.read(place).map_err(|error| error.file(place))?);
        }
        Ok(this)
    }

    fn read(&self, place: &Path) -> Result<Partial> {
        let bytes = fs::read(place).map_err(|error| Error::from_read(&error, place))?;
        let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(0);
        let help = "run again without --resume";
        match serde_json::from_slice::<Value>(&bytes[..end]) {
            Ok(inputs) if inputs == self.inputs => {
                Partial::from_bytes(&bytes[end + 1..]).map_err(|error| error.help(help))
            }
            Ok(inputs) => Err(Error::bad_data(
                "what was interrupted was a fit of other files, or cut otherwise",
            )
            .field("inputs")
            .found(inputs)
            .expected(&self.inputs)
            .help(help)),
            Err(_) => Err(
                Error::bad_data("this is nothing that an interrupted run left")
                    .found("something else")
                    .expected("one line of JSON")
                    .help(help),
            ),
        }
    }

    /// What the interrupted run had done.
    pub fn take(&mut self) -> Option<Partial> {
        self.found.take()
    }

    /// Keeps what is done, from time to time.
    ///
    /// # Errors
    /// Those of writing.
    pub fn keep(&mut self, partial: &Partial) -> Result<()> {
        let Some(place) = self
            .place
            .as_ref()
            .filter(|_| self.kept.elapsed() >= SHARE * self.cost)
        else {
            return Ok(());
        };
        let start = Instant::now();
        let head = format!("{}\n", self.inputs);
        let bytes = partial.to_bytes();
        unbroken(|| {
            write_atomically(place, true, |file| {
                file.write_all(head.as_bytes())
                    .and_then(|()| file.write_all(&bytes))
            })
        })?;
        (self.kept, self.cost) = (Instant::now(), start.elapsed());
        Ok(())
    }

    /// The work is done: nothing is left behind.
    pub fn done(self) {
        if let Some(place) = self.place {
            // the result is written: a file too much is no failure
            let _ = fs::remove_file(place);
        }
    }
}

/// Names, sizes and times of the files: enough to tell whether they are the same.
fn described(files: &[PathBuf], parts: usize) -> Result<Value> {
    let of = |file: &PathBuf| {
        let metadata = fs::metadata(file).map_err(|error| Error::from_read(&error, file))?;
        let modified = metadata
            .modified()
            .ok()
            .and_then(|time| time.duration_since(UNIX_EPOCH).ok())
            .map(|time| time.as_nanos().to_string());
        Ok(
            json!({"file": chladni_text::file_name(file), "bytes": metadata.len(), "modified_ns": modified}),
        )
    };
    let inputs = files.iter().map(of).collect::<Result<Vec<_>>>()?;
    Ok(json!({"format": "chladni.resume", "version": 1, "inputs": inputs, "parts": parts}))
}
