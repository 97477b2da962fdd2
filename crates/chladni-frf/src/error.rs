//! One shape for every error about a user's input: what was found, what was expected,
//! where, and what to do.

use crate::nearest_word::{is_near, nearest_word};
use crate::printable::printable;
use std::fmt;
use std::path::{Path, PathBuf};

/// Result of everything that reads or writes a user's files.
pub type Result<T> = std::result::Result<T, Error>;

/// The kind of failure; decides the exit code of the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A wrong option or combination of options (exit 2).
    Usage,
    /// A file holds something that it must not hold (exit 65).
    BadData,
    /// The file does not say its FRF kind, and nobody else did (exit 65).
    UnknownFrfKind,
    /// No such input (exit 66).
    NoInput,
    /// A broken promise of our own (exit 70).
    Internal,
    /// The output cannot be created (exit 73).
    CannotCreate,
    /// Reading or writing failed (exit 74).
    Io,
    /// Stopped by the user (exit 130).
    Interrupted,
}

impl ErrorKind {
    /// Exit code of the command line (design contract, after BSD `sysexits`).
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Usage => 2,
            Self::BadData | Self::UnknownFrfKind => 65,
            Self::NoInput => 66,
            Self::Internal => 70,
            Self::CannotCreate => 73,
            Self::Io => 74,
            Self::Interrupted => 130,
        }
    }

    /// The word for this kind in errors that are JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Usage => "usage",
            Self::BadData => "bad_data",
            Self::UnknownFrfKind => "unknown_frf_kind",
            Self::NoInput => "no_input",
            Self::Internal => "internal",
            Self::CannotCreate => "cannot_create",
            Self::Io => "io",
            Self::Interrupted => "interrupted",
        }
    }
}

/// An error about input or output, with its place and the next step.
///
/// Build it with [`Error::bad_data`] and the `with_...` setters:
///
/// ```
/// use chladni_frf::Error;
/// let error = Error::bad_data("text instead of a number")
///     .at_line(12)
///     .field("ordinate")
///     .found("abc")
///     .expected("a decimal number")
///     .help("open the file at that line and correct it, or read it with `lenient`");
/// assert!(error.to_string().contains("line 12"));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Error {
    /// The kind of failure.
    pub kind: ErrorKind,
    /// One sentence that says what happened.
    pub message: String,
    /// The file concerned.
    pub file: Option<PathBuf>,
    /// Number of the universal-file dataset concerned (58, 151, ...).
    pub dataset: Option<u32>,
    /// Line of the text file, counted from 1.
    pub line: Option<u64>,
    /// Byte offset in a binary file, counted from 0.
    pub byte: Option<u64>,
    /// Name of the field, column, key or record.
    pub field: Option<String>,
    /// The content found there.
    pub found: Option<String>,
    /// The content expected there.
    pub expected: Option<String>,
    /// Advice on what to do about it.
    pub help: Option<String>,
}

impl Error {
    /// An error of `kind` that says `message`.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self {
            kind,
            message: message.into(),
            file: None,
            dataset: None,
            line: None,
            byte: None,
            field: None,
            found: None,
            expected: None,
            help: None,
        }
    }

    /// Bad data in a file.
    pub fn bad_data(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::BadData, message)
    }

    /// A word that a parser refused as "`x` is no ...; write ...": the second half is
    /// what was expected.
    pub fn bad_word(message: &str, found: impl fmt::Display) -> Self {
        let (message, expected) = message
            .split_once("; write ")
            .unwrap_or((message, "another value"));
        Self::bad_data(message).found(found).expected(expected)
    }

    /// An operating-system failure on `file`: "not found" becomes [`ErrorKind::NoInput`],
    /// with the nearest name there is.
    pub fn from_read(error: &std::io::Error, file: &Path) -> Self {
        use std::io::ErrorKind as Io;
        match error.kind() {
            Io::NotFound | Io::NotADirectory => Self::no_such_file(file),
            Io::IsADirectory => Self::bad_data("a folder, not a file")
                .file(file)
                .found("a folder")
                .expected("a file")
                .help("name a file in it"),
            Io::PermissionDenied => Self::new(ErrorKind::Io, "cannot read: permission denied")
                .file(file)
                .help("ask its owner, or change its permissions (chmod)"),
            _ => Self::new(ErrorKind::Io, format!("cannot read: {error}")).file(file),
        }
    }

    fn no_such_file(file: &Path) -> Self {
        const CHECK: &str = "check the path; paths are taken relative to the current folder";
        let folder = file
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty())
            .unwrap_or_else(|| Path::new("."));
        let error = Self::new(ErrorKind::NoInput, "no such file")
            .file(file)
            .expected("an existing file");
        let Ok(entries) = std::fs::read_dir(folder) else {
            return error
                .found(format!("no folder {}", folder.display()))
                .help(CHECK);
        };
        let mut names: Vec<String> = entries
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort_unstable();
        let asked = file
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default();
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let near = nearest_word(&asked, &known).filter(|near| is_near(&asked, near));
        error
            .found("nothing of that name")
            .help(near.map_or(CHECK.into(), |near| {
                format!("did you mean {}?", file.with_file_name(near).display())
            }))
    }

    /// Adds the file, unless one is named already.
    pub fn file(mut self, file: impl AsRef<Path>) -> Self {
        self.file.get_or_insert_with(|| file.as_ref().to_path_buf());
        self
    }
    /// Adds the dataset number, unless one is named already.
    pub fn dataset(mut self, number: u32) -> Self {
        self.dataset.get_or_insert(number);
        self
    }
    /// Adds the line, counted from 1.
    pub fn at_line(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }
    /// Adds the byte offset, counted from 0.
    pub fn at_byte(mut self, byte: u64) -> Self {
        self.byte = Some(byte);
        self
    }
    /// Names the field.
    pub fn field(mut self, field: impl Into<String>) -> Self {
        self.field = Some(field.into());
        self
    }
    /// Says what stood there (foreign text is cut at 80 characters, control characters
    /// are escaped).
    pub fn found(mut self, found: impl fmt::Display) -> Self {
        let text = found.to_string();
        let mut shown: String = text
            .chars()
            .take(80)
            .flat_map(|c| {
                if c.is_control() {
                    c.escape_default().collect::<Vec<_>>()
                } else {
                    vec![c]
                }
            })
            .collect();
        if text.chars().count() > 80 {
            shown.push_str("...");
        }
        self.found = Some(shown);
        self
    }
    /// Says what must stand there.
    pub fn expected(mut self, expected: impl fmt::Display) -> Self {
        self.expected = Some(expected.to_string());
        self
    }
    /// Says what to do.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}: ", printable(&file.to_string_lossy(), &[]))?;
        }
        if let Some(dataset) = self.dataset {
            write!(f, "dataset {dataset}: ")?;
        }
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        if let Some(byte) = self.byte {
            write!(f, "byte {byte}: ")?;
        }
        if let Some(field) = &self.field {
            write!(f, "{field}: ")?;
        }
        write!(f, "{}", self.message)?;
        if let Some(found) = &self.found {
            write!(f, "; found {found}")?;
        }
        if let Some(expected) = &self.expected {
            write!(f, "; expected {expected}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
