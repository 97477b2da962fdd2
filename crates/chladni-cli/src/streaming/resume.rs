//! The state that a run saves beside its output, so that the next can go on where it was
//! interrupted.
//!
//! The file holds one line of JSON, which names the input files and the options of reading
//! and fitting, and then the partial so far.

use crate::limits::SHARE;
use chladni_console::{is_standard_output, unbroken};
use chladni_frf::{Error, ErrorKind, Result, CREATED_BY};
use chladni_io::{stamp_of, write_atomically};
use chladni_rfp::pieces::Partial;
use chladni_text::door::Claim;
use chladni_text::file_name;
use serde_json::{json, Map, Value};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Version of the first line; another one is refused.
const VERSION: u64 = 2;

/// The saved state of a run.
pub struct Resume {
    /// The file of the state; `None` where nothing is saved.
    place: Option<PathBuf>,
    /// The first line of the file.
    head: Value,
    /// Time of the last save, and how long it took.
    kept: Instant,
    cost: Duration,
    /// The state of the interrupted run.
    found: Option<Partial>,
    /// Claim on the file of the state, so that no input is read from it.
    _claim: Option<Claim>,
}

impl Resume {
    /// A state that is saved beside `output`, or nowhere without one. With `goes_on` the
    /// state of an interrupted run is read.
    ///
    /// * `memory`: bytes that determine the parts of the files
    /// * `options`: all that can change the result, as results echo them
    ///
    /// # Errors
    /// A state that belongs to other files or options, or is damaged.
    pub fn new(
        output: Option<&Path>,
        files: &[PathBuf],
        memory: u64,
        mut options: Map<String, Value>,
        goes_on: bool,
    ) -> Result<Self> {
        options.insert("memory".into(), memory.into());
        let place = output.filter(|output| !is_standard_output(output));
        if goes_on && place.is_none() {
            return Err(Error::new(
                ErrorKind::Usage,
                "what an interrupted run leaves lies beside its output",
            )
            .field("--resume")
            .found("no file with -o")
            .expected("the name of a file")
            .help("give the same -o as in the interrupted run"));
        }
        let place = place.map(|output| {
            let mut name = OsString::from(output);
            name.push(".resume");
            PathBuf::from(name)
        });
        let mut this = Self {
            _claim: place.as_deref().map(Claim::new).transpose()?,
            place,
            head: json!({
                "format": "chladni.resume",
                "version": VERSION,
                "created_by": CREATED_BY,
                "inputs": described(files)?,
                "options": options,
            }),
            kept: Instant::now(),
            cost: Duration::ZERO,
            found: None,
        };
        if let Some(place) = this
            .place
            .as_ref()
            .filter(|place| goes_on && place.exists())
        {
            let found = this.read(place);
            this.found = Some(found.map_err(|error| match &error.help {
                Some(_) => error.file(place),
                None => error.file(place).help("run again without --resume"),
            })?);
        }
        Ok(this)
    }

    fn read(&self, place: &Path) -> Result<Partial> {
        let bytes = fs::read(place).map_err(|error| Error::from_read(&error, place))?;
        let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(0);
        let head: Value = serde_json::from_slice(&bytes[..end]).map_err(|_| {
            Error::bad_data("this is nothing that an interrupted run left")
                .found("something else")
                .expected("one line of JSON")
        })?;
        for (key, what) in [
            ("format", "is nothing that an interrupted run left"),
            ("version", "was left by another version of this program"),
            ("created_by", "was left by another version of this program"),
            ("inputs", "was left by a fit of other files"),
        ] {
            if head[key] != self.head[key] {
                return Err(Error::bad_data(format!("this {what}"))
                    .field(key)
                    .found(&head[key])
                    .expected(&self.head[key]));
            }
        }
        same_options(&head["options"], &self.head["options"])?;
        Partial::from_bytes(&bytes[end + 1..])
    }

    /// The state of the interrupted run, once.
    pub fn take(&mut self) -> Option<Partial> {
        self.found.take()
    }

    /// Saves the state, if the last save is long enough ago.
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
        let head = format!("{}\n", self.head);
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

    /// Removes the file of the state once the work is done.
    pub fn done(self) {
        if let Some(place) = self.place {
            // the result is written, so a file that stays is no failure
            let _ = fs::remove_file(place);
        }
    }
}

/// Names, sizes and times of the files: enough to tell whether they are the same.
fn described(files: &[PathBuf]) -> Result<Value> {
    let of = |file: &PathBuf| {
        let (bytes, stamp) = stamp_of(file)?;
        Ok(json!({"file": file_name(file), "bytes": bytes, "stamp": stamp}))
    };
    files.iter().map(of).collect()
}

/// Refuses options that differ from those of the interrupted run; names the first.
fn same_options(were: &Value, are: &Value) -> Result<()> {
    let no_options = Map::new();
    let [were, are] = [were, are].map(|options| options.as_object().unwrap_or(&no_options));
    let differs = |name: &&String| were.get(*name) != are.get(*name);
    let Some(name) = are.keys().chain(were.keys()).find(differs) else {
        return Ok(());
    };
    let shown = |options: &Map<String, Value>| match options.get(name) {
        None | Some(Value::Null) => "not given".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(value) => value.to_string(),
    };
    // names in results end with the unit
    let flag = name.trim_end_matches("_hz").trim_end_matches("_per_s");
    Err(
        Error::bad_data("what was interrupted was a fit with other options")
            .field(format!("--{}", flag.replace('_', "-")))
            .found(shown(were))
            .expected(format!("{}, as now", shown(are)))
            .help("give the options of the interrupted run, or run again without --resume"),
    )
}
