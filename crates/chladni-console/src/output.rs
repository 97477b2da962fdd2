//! Outputs: a file that could not be written is refused before the work.

use crate::console::Console;
use crate::interrupt::unbroken;
use crate::stdout::{bytes_to_stdout, claim, is_standard_output};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_io::{extension_of, refuse_output_among_inputs, try_place, write_atomically};
use chladni_text::door::Claim;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

/// Formats of results on the standard output; a command writes the first of these that it
/// knows. FRFs are written as binary universal files, without loss.
const STREAMED: [&str; 6] = ["json", "uff", "part", "poles", "csv", "html"];
/// Binary ones among them, which no terminal can show.
const BINARY: [&str; 3] = ["uff", "part", "poles"];

/// Extensions of FRF files.
pub const FRF: &[&str] = &[
    "h5", "hdf5", "npz", "mat", "uff", "ufb", "bunv", "unv", "uf", "csv", "txt",
];
/// Extensions that `convert` writes measured data to.
pub const DATA: &[&str] = &[
    "h5", "hdf5", "npz", "mat", "uff", "ufb", "bunv", "unv", "uf", "csv", "txt", "vtu", "pvd",
];
/// Extensions of shapes and fields.
pub const SHAPES: &[&str] = &["unv", "uff", "ufb", "bunv", "uf", "vtu", "pvd"];
/// Extensions that `convert` writes a model to.
pub const MODEL_OR_SHAPES: &[&str] = &[
    "json", "h5", "hdf5", "mat", "csv", "txt", "unv", "uff", "ufb", "bunv", "uf", "vtu", "pvd",
];
/// Extensions of model files.
pub const MODEL: &[&str] = &["json", "h5", "hdf5"];
/// Extension of partials of blocks of FRFs.
pub const PARTIAL: &[&str] = &["part"];
/// Extensions that `block solve` writes to: poles or a model.
pub const POLES_OR_MODEL: &[&str] = &["poles", "json", "h5", "hdf5"];
/// Extensions of weights files.
pub const WEIGHTS: &[&str] = &["json"];
/// Extensions that `render --wav` writes to: a drive signal, or a table of amplitudes and
/// phases.
pub const SIGNAL_OR_TABLE: &[&str] = &["wav", "csv"];
/// Extensions of drive signals.
pub const SIGNALS: &[&str] = &["wav", "csv", "npz"];
/// Extensions of scene files.
pub const SCENE: &[&str] = &["toml"];
/// Extensions of reports.
pub const HTML: &[&str] = &["html", "htm"];
/// Extensions of tables.
pub const TABLE: &[&str] = &["csv"];
/// Extensions of pictures.
pub const PICTURE: &[&str] = &["svg", "png", "gif"];

/// Makes `folder`, named by `option`, where it does not exist.
///
/// # Errors
/// [`ErrorKind::CannotCreate`].
pub fn make_folder(folder: &Path, option: &str) -> Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    if is_standard_output(folder) {
        return Err(Error::new(
            ErrorKind::Usage,
            "several files cannot go to the standard output",
        )
        .field(option)
        .found("-")
        .expected("the name of a folder")
        .help(format!("choose a folder with {option}")));
    }
    std::fs::create_dir(folder).map_err(|error| {
        Error::new(
            ErrorKind::CannotCreate,
            format!("cannot create the folder: {error}"),
        )
        .file(folder)
        .field(option)
        .found(if folder.exists() {
            "a file of that name"
        } else {
            "nothing"
        })
        .expected("a new or existing folder inside an existing one")
        .help(format!("choose another folder with {option}"))
    })
}

/// A checked output of a result: a file, or the standard output as `-`.
pub struct Output<'a> {
    path: &'a Path,
    force: bool,
    /// Extension of the format on the standard output; `None` for a file.
    streamed: Option<&'static str>,
    _claim: Option<Claim>,
}

impl<'a> Output<'a> {
    /// Checks extension and folder, and that no file is overwritten unasked. From then on the
    /// file cannot be read as an input.
    ///
    /// # Errors
    /// [`ErrorKind::Usage`] for an unknown extension, [`ErrorKind::CannotCreate`] for
    /// everything else.
    pub fn new(
        path: &'a Path,
        extensions: &[&str],
        inputs: &[PathBuf],
        console: &Console,
    ) -> Result<Self> {
        if is_standard_output(path) {
            return Ok(Self {
                path,
                force: false,
                streamed: Some(format_of_stream(extensions, console)?),
                _claim: None,
            });
        }
        let extension = extension_of(path);
        if !extensions.contains(&extension.as_str()) {
            let known: Vec<String> = extensions.iter().map(|known| format!(".{known}")).collect();
            return Err(Error::new(
                ErrorKind::Usage,
                "the extension of the output names no format that can be written",
            )
            .file(path)
            .field("-o")
            .found(if extension.is_empty() {
                "none".into()
            } else {
                format!(".{extension}")
            })
            .expected(known.join(", "))
            .help("choose a name with -o: its extension decides the format"));
        }
        refuse_output_among_inputs(path, inputs)?;
        refuse_place(path, console.force)?;
        unbroken(|| try_place(path, console.force)).map_err(|error| error.field("-o"))?;
        Ok(Self {
            path,
            force: console.force,
            streamed: None,
            _claim: Some(Claim::new(path)?),
        })
    }

    /// As [`Self::new`] for the path that `option` names, which may be left out.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn asked(
        option: &str,
        path: Option<&'a Path>,
        extensions: &[&str],
        inputs: &[PathBuf],
        console: &Console,
    ) -> Result<Option<Self>> {
        path.map(|path| Self::new(path, extensions, inputs, console))
            .transpose()
            .map_err(|error| of_option(error, option))
    }

    /// Writes `content`, the whole file.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_bytes(&self, content: impl AsRef<[u8]>) -> Result<()> {
        self.write(|path, force| {
            write_atomically(path, force, |file| file.write_all(content.as_ref()))
        })
    }

    /// Calls `write(path, force)`. An interruption waits until it has returned.
    ///
    /// # Errors
    /// Those of `write`.
    pub fn write<T>(&self, write: impl FnOnce(&Path, bool) -> Result<T>) -> Result<T> {
        let Some(extension) = self.streamed else {
            return unbroken(|| write(self.path, self.force));
        };
        // the result is complete before its first byte is printed
        let (made, bytes) = unbroken(|| {
            let folder = tempfile::tempdir().map_err(|error| no_temporary_file(&error))?;
            let file = folder.path().join(format!("stdout.{extension}"));
            let made = write(&file, false)?;
            Ok((
                made,
                fs::read(&file).map_err(|error| no_temporary_file(&error))?,
            ))
        })?;
        bytes_to_stdout(&bytes)?;
        Ok(made)
    }
}

/// The error of an output with the name of its option in place of `-o`.
fn of_option(error: Error, option: &str) -> Error {
    let help = error.help.as_deref();
    match help.map(|help| help.replace("with -o", &format!("with {option}"))) {
        Some(help) => error.field(option).help(help),
        None => error.field(option),
    }
}

fn no_temporary_file(error: &io::Error) -> Error {
    Error::new(
        ErrorKind::Io,
        format!("cannot make the result for the standard output: {error}"),
    )
    .found(format!("the folder {}", std::env::temp_dir().display()))
    .expected("a folder for temporary files with room for the result")
    .help("name another with TMPDIR, or give a file with -o")
}

/// Claims the standard output for a result, and returns the one of `extensions` that can be
/// streamed.
fn format_of_stream(extensions: &[&str], console: &Console) -> Result<&'static str> {
    let refuse = |message: &str, found: &str, expected: &str| {
        Err(Error::new(ErrorKind::Usage, message)
            .field("-o")
            .found(found)
            .expected(expected)
            .help("give the name of a file with -o"))
    };
    let known = STREAMED.into_iter().find(|one| extensions.contains(one));
    let Some(extension) = known else {
        return refuse("this result needs a file", "-", "the name of a file");
    };
    if console.json {
        return refuse(
            "the standard output carries the result or the object of --json",
            "both",
            "one of them",
        );
    }
    if BINARY.contains(&extension) && io::stdout().is_terminal() {
        return refuse(
            "the result is binary, and the standard output a terminal",
            "a terminal",
            "a pipe or a file",
        );
    }
    match claim() {
        true => Ok(extension),
        false => refuse("two outputs are one file", "- twice", "- once at most"),
    }
}

fn refuse_place(path: &Path, force: bool) -> Result<()> {
    let refuse = |message: &str, found: &str, expected: &str, help: &str| {
        Err(Error::new(ErrorKind::CannotCreate, message)
            .file(path)
            .field("-o")
            .found(found)
            .expected(expected)
            .help(help))
    };
    if path.is_dir() {
        return refuse(
            "a folder stands where the file should be written",
            "a folder",
            "the name of a file",
            "give the name of a file with -o",
        );
    }
    if path.exists() && !force {
        return refuse(
            "the file exists",
            "a file of that name",
            "a new name, or --force",
            "choose another name with -o, or overwrite it with --force",
        );
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let found = if folder.exists() { "a file" } else { "nothing" };
        return refuse(
            "no such folder for the output",
            &format!("{found} at {}", folder.display()),
            "an existing folder",
            "create the folder first, or choose another with -o",
        );
    }
    Ok(())
}
