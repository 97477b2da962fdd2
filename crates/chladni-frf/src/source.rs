//! Input files, by name and content.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt;

/// Digest of a file's bytes, in hexadecimal digits: another content has another one.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Checksum {
    /// SHA-256: of files up to 1 GiB.
    Sha256(String),
    /// BLAKE3: of larger ones, several times as fast.
    Blake3(String),
}

impl Checksum {
    /// The checksum of a file that holds the digits under one of these names.
    ///
    /// # Errors
    /// The complaint that there is neither.
    pub fn of_fields(sha256: Option<String>, blake3: Option<String>) -> Result<Self, &'static str> {
        match (sha256, blake3) {
            (Some(digits), _) => Ok(Self::Sha256(digits)),
            (None, Some(digits)) => Ok(Self::Blake3(digits)),
            (None, None) => Err("missing field `sha256` or `blake3`"),
        }
    }

    /// The digits.
    pub fn digits(&self) -> &str {
        match self {
            Self::Sha256(digits) | Self::Blake3(digits) => digits,
        }
    }

    /// The name of its field in a file: `sha256` or `blake3`.
    pub fn field(&self) -> &'static str {
        match self {
            Self::Sha256(_) => "sha256",
            Self::Blake3(_) => "blake3",
        }
    }
}

/// `SHA-256 ...` or `BLAKE3 ...`.
impl fmt::Display for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sha256(digits) => write!(f, "SHA-256 {digits}"),
            Self::Blake3(digits) => write!(f, "BLAKE3 {digits}"),
        }
    }
}

/// An input file, by name (without its folder) and content. In files an object with
/// `file` and `sha256`, or `file` and `blake3`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "Entry", into = "Entry")]
pub struct Source {
    /// File name.
    pub file: String,
    /// Of its bytes.
    pub checksum: Checksum,
}

impl Source {
    /// The files with the content of an earlier one, in words with the names of the first two;
    /// `None` where all contents differ.
    pub fn copies(sources: &[Self]) -> Option<String> {
        let mut originals: HashMap<&Checksum, &Self> = HashMap::new();
        let mut copies = Vec::new();
        for source in sources {
            let original = *originals.entry(&source.checksum).or_insert(source);
            if !std::ptr::eq(original, source) {
                copies.push((source, original));
            }
        }
        let (copy, original) = copies.first()?;
        let count = match copies.len() {
            1 => "a file has".to_owned(),
            count => format!("{count} files have"),
        };
        Some(format!(
            "{count} the content of another one, such as {} of {}",
            copy.file, original.file
        ))
    }
}

/// A source as files have it.
#[derive(Serialize, Deserialize)]
struct Entry {
    file: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    blake3: Option<String>,
}

impl From<Source> for Entry {
    fn from(source: Source) -> Self {
        let (sha256, blake3) = match source.checksum {
            Checksum::Sha256(digits) => (Some(digits), None),
            Checksum::Blake3(digits) => (None, Some(digits)),
        };
        Self {
            file: source.file,
            sha256,
            blake3,
        }
    }
}

impl TryFrom<Entry> for Source {
    type Error = &'static str;

    fn try_from(entry: Entry) -> Result<Self, Self::Error> {
        Ok(Self {
            file: entry.file,
            checksum: Checksum::of_fields(entry.sha256, entry.blake3)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_named_beside_the_file_that_they_copy() {
        let source = |(file, digits): (&str, &str)| Source {
            file: file.into(),
            checksum: Checksum::Sha256(digits.into()),
        };
        let words = |files: &[(&str, &str)]| {
            let sources: Vec<Source> = files.iter().copied().map(source).collect();
            Source::copies(&sources)
        };
        let (one, other) = (("a.csv", "01"), ("b.csv", "02"));
        assert_eq!(words(&[one, other]), None);
        assert_eq!(
            words(&[one, other, ("c.csv", "02")]).unwrap(),
            "a file has the content of another one, such as c.csv of b.csv"
        );
        let several = words(&[one, one, other, ("c.csv", "01")]).unwrap();
        assert!(several.starts_with("2 files have"), "{several}");
        assert!(several.ends_with("a.csv of a.csv"), "{several}");
    }

    #[test]
    fn either_sum_is_read_as_it_is_written_and_neither_is_refused() {
        let source = |checksum| Source {
            file: "scan.h5".into(),
            checksum,
        };
        let text = |source: &Source| serde_json::to_string(source).unwrap();
        let small = source(Checksum::Sha256("ab".into()));
        let large = source(Checksum::Blake3("cd".into()));
        assert_eq!(text(&small), r#"{"file":"scan.h5","sha256":"ab"}"#);
        assert_eq!(text(&large), r#"{"file":"scan.h5","blake3":"cd"}"#);
        for source in [small, large] {
            assert_eq!(
                serde_json::from_str::<Source>(&text(&source)).unwrap(),
                source
            );
        }
        let error = serde_json::from_str::<Source>(r#"{"file":"scan.h5"}"#).unwrap_err();
        assert!(
            error.to_string().contains("`sha256` or `blake3`"),
            "{error}"
        );
    }
}
