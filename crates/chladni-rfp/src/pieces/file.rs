//! Partials and poles as bytes: one line of JSON that says what follows, then the
//! content.
//!
//! ```text
//! {"format":"chladni.partial","version":8,"created_by":"chladni 0.1.0","bytes":1234,"sha256":"..."}
//! ```

use crate::pieces::limits;
use crate::pieces::partial::Partial;
use crate::pieces::poles::Poles;
use crate::pieces::sound::Sound;
use chladni_frf::{Error, CREATED_BY};
use serde::{de::DeserializeOwned, Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The first line.
#[derive(Debug, Serialize, Deserialize)]
struct FirstLine {
    format: String,
    version: u64,
    created_by: String,
    bytes: usize,
    sha256: String,
}

impl Partial {
    const FORMAT: &'static str = "chladni.partial";

    /// The bytes of a partial file.
    pub fn to_bytes(&self) -> Vec<u8> {
        to_bytes(Self::FORMAT, self)
    }

    /// Reads them.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: not such a file, another version, damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        from_bytes(Self::FORMAT, bytes)
    }
}

impl Poles {
    const FORMAT: &'static str = "chladni.poles";

    /// The bytes of a poles file.
    pub fn to_bytes(&self) -> Vec<u8> {
        to_bytes(Self::FORMAT, self)
    }

    /// Reads them.
    ///
    /// # Errors
    /// As [`Partial::from_bytes`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        from_bytes(Self::FORMAT, bytes)
    }
}

fn digest(content: &[u8]) -> String {
    Sha256::digest(content)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn to_bytes(format: &str, content: &impl Serialize) -> Vec<u8> {
    let content = postcard::to_allocvec(content).expect("plain data of known length");
    let first_line = FirstLine {
        format: format.into(),
        version: limits::VERSION,
        created_by: CREATED_BY.into(),
        bytes: content.len(),
        sha256: digest(&content),
    };
    let mut bytes = serde_json::to_vec(&first_line).expect("plain data");
    bytes.push(b'\n');
    bytes.extend(content);
    bytes
}

fn from_bytes<T: DeserializeOwned + Sound>(format: &str, bytes: &[u8]) -> Result<T, Error> {
    let end = bytes
        .iter()
        .take(limits::HEAD_MOST)
        .position(|byte| *byte == b'\n');
    let first_line: Option<FirstLine> =
        end.and_then(|end| serde_json::from_slice(&bytes[..end]).ok());
    let (Some(end), Some(first_line)) = (end, first_line) else {
        let expected = format!("one line of JSON with \"format\":\"{format}\"");
        return Err(Error::bad_data(format!("no {format} file"))
            .field("first line")
            .found("something else")
            .expected(expected));
    };
    if first_line.format != format {
        return Err(Error::bad_data("a file of another kind")
            .field("format")
            .found(first_line.format)
            .expected(format));
    }
    if first_line.version != limits::VERSION {
        return Err(Error::bad_data("a file of another version")
            .field("version")
            .found(format!(
                "{} (written by {})",
                first_line.version, first_line.created_by
            ))
            .expected(limits::VERSION)
            .help("make it anew: the versions of all machines must agree"));
    }
    let content = &bytes[end + 1..];
    if content.len() != first_line.bytes {
        return Err(Error::bad_data("the file is cut off or too long")
            .field("bytes")
            .found(content.len())
            .expected(first_line.bytes));
    }
    if digest(content) != first_line.sha256 {
        return Err(Error::bad_data("the file is damaged")
            .field("sha256")
            .found(digest(content))
            .expected(first_line.sha256));
    }
    let content: T = postcard::from_bytes(content).map_err(|error| {
        Error::bad_data("the content cannot be read")
            .field("content")
            .found(error)
            .expected("what its first line says")
    })?;
    content.check()?;
    Ok(content)
}
