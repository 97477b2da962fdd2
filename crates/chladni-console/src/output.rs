//! Places of results: refused before the work where they could not be written after it.

use crate::console::Console;
use crate::interrupt::unbroken;
use chladni_frf::{Error, ErrorKind, Result};
use chladni_io::refuse_output_among_inputs;
use chladni_io::try_place;
use chladni_text::door::Claim;
use std::path::{Path, PathBuf};

/// Extensions of FRF files.
pub const FRF: &[&str] = &[
    "h5", "hdf5", "npz", "mat", "uff", "ufb", "bunv", "unv", "uf", "csv", "txt",
];
/// Extensions of what `convert` writes of measured data.
pub const DATA: &[&str] = &[
    "h5", "hdf5", "npz", "mat", "uff", "ufb", "bunv", "unv", "uf", "csv", "txt", "vtu", "pvd",
];
/// Extensions of shapes and fields.
pub const SHAPES: &[&str] = &["unv", "uff", "ufb", "bunv", "uf", "vtu", "pvd"];
/// Extensions of what `convert` writes of a model.
pub const MODEL_OR_SHAPES: &[&str] = &[
    "json", "h5", "hdf5", "mat", "csv", "txt", "unv", "uff", "ufb", "bunv", "uf", "vtu", "pvd",
];
/// Extensions of model files.
pub const MODEL: &[&str] = &["json", "h5", "hdf5"];
/// Extensions of what is left of blocks of FRFs.
pub const PARTIAL: &[&str] = &["part"];
/// Extensions of what `block solve` writes: poles, or a model.
pub const POLES_OR_MODEL: &[&str] = &["poles", "json", "h5", "hdf5"];
/// Extensions of weights files.
pub const WEIGHTS: &[&str] = &["json"];
/// Extensions of what `render --wav` writes: a drive signal, or a table of amplitudes and
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
/// Pictures, moving ones among them.
pub const MOVING: &[&str] = &["svg", "png", "gif"];

/// Makes `folder` where it does not exist.
///
/// # Errors
/// [`ErrorKind::CannotCreate`].
pub fn make_folder(folder: &Path) -> Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    std::fs::create_dir(folder).map_err(|error| {
        Error::new(
            ErrorKind::CannotCreate,
            format!("cannot create the folder: {error}"),
        )
        .file(folder)
        .field("-o")
        .found(if folder.exists() {
            "a file of that name"
        } else {
            "nothing"
        })
        .expected("a new or existing folder inside an existing one")
        .help("choose another folder with -o")
    })
}

/// A place that a result may be written to.
pub struct Output<'a> {
    path: &'a Path,
    force: bool,
    _claim: Claim,
}

impl<'a> Output<'a> {
    /// Checks extension, folder and an existing file, so that hours of work do not end in
    /// a refusal. From then on the file is no input.
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
        let extension = path
            .extension()
            .map(|extension| extension.to_string_lossy().to_ascii_lowercase())
            .unwrap_or_default();
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
            .help("the extension of -o decides the format"));
        }
        refuse_output_among_inputs(path, inputs)?;
        refuse_place(path, console.force)?;
        unbroken(|| try_place(path, console.force)).map_err(|error| error.field("-o"))?;
        Ok(Self {
            path,
            force: console.force,
            _claim: Claim::new(path)?,
        })
    }

    /// Writes by `write(path, force)`, to its end even where an interruption comes
    /// between.
    ///
    /// # Errors
    /// Those of `write`.
    pub fn write<T>(&self, write: impl FnOnce(&Path, bool) -> Result<T>) -> Result<T> {
        unbroken(|| write(self.path, self.force))
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
