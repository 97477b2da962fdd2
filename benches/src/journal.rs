//! The finished pieces of a long run, kept on disk line by line: an interrupted run goes on
//! where it stopped.
//!
//! The first line says what is being run; a journal of something else is begun anew. A
//! line that was cut off counts as not written.

use chladni_frf::{Error, ErrorKind, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Finished pieces of work by name.
pub struct Journal {
    file: Option<(File, PathBuf)>,
    done: HashMap<String, Value>,
}

impl Journal {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self {
            file: None,
            done: HashMap::new(),
        }
    }

    /// Opens the journal at `path` of a run that is described by `purpose` in full: what
    /// does not stand there must not change results.
    ///
    /// # Errors
    /// A file that can be neither read nor made.
    pub fn open(path: &Path, purpose: &str) -> Result<Self> {
        let purpose = Value::from(purpose).to_string();
        let text = fs::read_to_string(path).unwrap_or_default();
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let mut lines = whole.lines();
        let entry = |line: &str| serde_json::from_str::<(String, Value)>(line).ok();
        let done: HashMap<String, Value> = match lines.next() == Some(&purpose) {
            true => lines.filter_map(entry).collect(),
            false => HashMap::new(),
        };
        let kept = match done.is_empty() {
            true => format!("{purpose}\n"),
            false => whole.to_owned(),
        };
        fs::write(path, kept).map_err(|error| failed(path, &error))?;
        let file = OpenOptions::new()
            .append(true)
            .open(path)
            .map_err(|error| failed(path, &error))?;
        Ok(Self {
            file: Some((file, path.to_path_buf())),
            done,
        })
    }

    /// Pieces that an earlier run has finished.
    pub fn resumed(&self) -> usize {
        self.done.len()
    }

    /// True where `name` is finished.
    pub fn has(&self, name: &str) -> bool {
        self.done.contains_key(name)
    }

    /// The piece `name`: from the journal, or by `work`, whose result is kept.
    ///
    /// # Errors
    /// Those of `work`; a disk that is full.
    pub fn once<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &str,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        if let Some(value) = self
            .done
            .get(name)
            .and_then(|value| serde_json::from_value(value.clone()).ok())
        {
            return Ok(value);
        }
        let value = work()?;
        if let Some((file, path)) = &mut self.file {
            let line = serde_json::to_string(&(name, &value))
                .map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))?;
            file.write_all(format!("{line}\n").as_bytes())
                .map_err(|error| failed(path, &error))?;
        }
        Ok(value)
    }

    /// Takes the file away: the run is at its end, and its tables are written.
    pub fn finish(self) {
        if let Some((file, path)) = self.file {
            drop(file);
            // a journal that stays behind costs nothing but its place
            let _ = fs::remove_file(path);
        }
    }
}

fn failed(path: &Path, error: &std::io::Error) -> Error {
    Error::new(
        ErrorKind::Io,
        format!("cannot keep what is finished: {error}"),
    )
    .file(path)
}

/// A number as JSON can hold it: what is not finite stands there as null, and comes back
/// as NaN.
pub(crate) fn nan<'de, D: Deserializer<'de>>(input: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(input)?.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct Number(#[serde(deserialize_with = "nan")] f64);

    #[test]
    fn a_run_goes_on_where_it_stopped_and_another_run_begins_anew() {
        let folder = std::env::temp_dir().join(format!("chladni-journal-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("run.journal");
        let mut first = Journal::open(&path, "a run").unwrap();
        let third = 1.0 / 3.0;
        first.once("one", || Ok(Number(third))).unwrap();
        first.once("none", || Ok(Number(f64::NAN))).unwrap();
        drop(first);
        let cut = fs::read_to_string(&path).unwrap() + "[\"cut\",{\"re";
        fs::write(&path, cut).unwrap();

        let mut second = Journal::open(&path, "a run").unwrap();
        assert_eq!((second.resumed(), second.has("cut")), (2, false));
        let kept = |journal: &mut Journal, name: &str| {
            journal
                .once::<Number>(name, || panic!("done already"))
                .unwrap()
                .0
        };
        assert_eq!(kept(&mut second, "one").to_bits(), third.to_bits());
        assert!(kept(&mut second, "none").is_nan());
        second.once("cut", || Ok(Number(2.0))).unwrap();
        drop(second);
        assert_eq!(Journal::open(&path, "a run").unwrap().resumed(), 3);
        let other = Journal::open(&path, "another run").unwrap();
        assert_eq!(other.resumed(), 0);
        other.finish();
        assert!(!path.exists());
        fs::remove_dir_all(folder).unwrap();
    }
}
