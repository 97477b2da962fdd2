//! The door that every input comes in by.
//!
//! A file is opened where it lies. What cannot be read twice (a pipe, a FIFO, the standard
//! input as `-`) is read once, from its start, into a temporary file that the readers open
//! in its place: they may seek, map and make checksums as in any file.
//!
//! The door also knows the outputs of the run: an input that is one of them is refused,
//! whatever way its path is written.

use crate::spool::{spool, Spooled, STANDARD_INPUT};
use chladni_frf::{Error, ErrorKind, Result};
use std::collections::{HashMap, HashSet};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The inputs and outputs of a run, as far as they are known.
static KNOWN: Mutex<Option<Known>> = Mutex::new(None);

#[derive(Default)]
struct Known {
    /// Number of [`KeptInputs`].
    users: usize,
    pipes: HashMap<PathBuf, Slot>,
    run: Option<Run>,
}

/// The files of a run of the program.
#[derive(Default)]
struct Run {
    read: HashSet<FileId>,
    /// To be written.
    claimed: Vec<FileId>,
}

/// The content of a pipe, or the reason that it cannot be read; nothing before it was
/// asked.
type Slot = Arc<Mutex<Option<Result<Arc<Spooled>>>>>;

/// The identity of a file, whatever its name.
#[cfg(unix)]
type FileId = (u64, u64);
#[cfg(not(unix))]
type FileId = PathBuf;

fn known() -> MutexGuard<'static, Option<Known>> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn run_of(known: &mut Option<Known>) -> Option<&mut Run> {
    known.as_mut()?.run.as_mut()
}

/// While one of these lives, what pipes gave is kept for the next reader.
#[derive(Debug)]
pub struct KeptInputs(());

impl KeptInputs {
    /// From now on.
    #[allow(clippy::new_without_default)] // it does something
    pub fn new() -> Self {
        known().get_or_insert_default().users += 1;
        Self(())
    }

    /// For the whole run of a program, which does not write over what it has read.
    pub fn of_run() -> Self {
        let kept = Self::new();
        known().get_or_insert_default().run.get_or_insert_default();
        kept
    }
}

impl Clone for KeptInputs {
    fn clone(&self) -> Self {
        Self::new()
    }
}

impl Drop for KeptInputs {
    fn drop(&mut self) {
        let mut known = known();
        if let Some(inner) = known.as_mut() {
            inner.users -= 1;
            if inner.users == 0 {
                *known = None;
            }
        }
    }
}

/// A file that is to be written: it cannot be read before this is dropped.
#[derive(Debug)]
pub struct Claim(Option<FileId>);

impl Claim {
    /// On `output`, where a file of that name exists.
    ///
    /// # Errors
    /// [`ErrorKind::CannotCreate`] where it was read as an input of this run, or is
    /// another output of it.
    pub fn new(output: &Path) -> Result<Self> {
        let id = regular(output).and_then(|metadata| id_of(output, &metadata));
        if let (Some(run), Some(id)) = (run_of(&mut known()), &id) {
            if run.read.contains(id) {
                return Err(both(output));
            }
            if run.claimed.contains(id) {
                return Err(
                    Error::new(ErrorKind::CannotCreate, "two outputs are one file")
                        .file(output)
                        .found("the file of another output")
                        .expected("a file of its own")
                        .help("give the result another name"),
                );
            }
            #[allow(clippy::clone_on_copy)] // a path where files have no numbers
            run.claimed.push(id.clone());
        }
        Ok(Self(id))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if let (Some(run), Some(id)) = (run_of(&mut known()), &self.0) {
            if let Some(place) = run.claimed.iter().position(|claimed| claimed == id) {
                run.claimed.swap_remove(place);
            }
        }
    }
}

/// Refuses to write over a file that was read.
///
/// # Errors
/// [`ErrorKind::CannotCreate`].
pub fn refuse_read(output: &Path) -> Result<()> {
    let id = regular(output).and_then(|metadata| id_of(output, &metadata));
    let was_read = |id: FileId| run_of(&mut known()).is_some_and(|run| run.read.contains(&id));
    match id.is_some_and(was_read) {
        true => Err(both(output)),
        false => Ok(()),
    }
}

/// True where both are one file.
pub fn is_same(one: &Path, other: &Path) -> bool {
    let id = |path: &Path| regular(path).and_then(|metadata| id_of(path, &metadata));
    id(one).is_some_and(|one| Some(one) == id(other))
}

fn both(file: &Path) -> Error {
    Error::new(ErrorKind::CannotCreate, "the output is one of the inputs")
        .file(file)
        .found("a file that is read")
        .expected("another file")
        .help("give the result another name")
}

fn regular(path: &Path) -> Option<Metadata> {
    fs::metadata(path).ok().filter(Metadata::is_file)
}

#[cfg(unix)]
#[allow(clippy::unnecessary_wraps)] // elsewhere there may be none
fn id_of(_: &Path, metadata: &Metadata) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn id_of(path: &Path, _: &Metadata) -> Option<FileId> {
    fs::canonicalize(path).ok()
}

/// The file to open for an input; a temporary one lives as long as this.
#[derive(Debug, Clone)]
pub struct Place {
    path: PathBuf,
    kept: Option<Arc<Spooled>>,
}

impl std::ops::Deref for Place {
    type Target = Path;
    fn deref(&self) -> &Path {
        &self.path
    }
}

impl Place {
    /// True where the input is a pipe, and this what it gave.
    pub fn is_temporary(&self) -> bool {
        self.kept.is_some()
    }
}

/// The place where the bytes of an input can be read, as often as wanted.
///
/// # Errors
/// Those of reading; a folder; a device; a pipe that gives too much; an input that is also
/// an output.
pub fn place_of(path: &Path) -> Result<Place> {
    if path.as_os_str() == STANDARD_INPUT {
        return spooled(path);
    }
    let on_read = |error: io::Error| Error::from_read(&error, path);
    let metadata = fs::metadata(path).map_err(on_read)?;
    if metadata.is_dir() {
        return Err(on_read(io::ErrorKind::IsADirectory.into()));
    }
    if !metadata.is_file() {
        return spooled(path);
    }
    if let Some(id) = id_of(path, &metadata) {
        if let Some(run) = run_of(&mut known()) {
            if run.claimed.contains(&id) {
                return Err(both(path));
            }
            run.read.insert(id);
        }
    }
    Ok(Place {
        path: path.to_path_buf(),
        kept: None,
    })
}

/// Opens an input at its start.
///
/// # Errors
/// As [`place_of`].
pub fn open(path: &Path) -> Result<File> {
    File::open(&*place_of(path)?).map_err(|error| Error::from_read(&error, path))
}

/// Number of bytes of an input.
///
/// # Errors
/// As [`place_of`].
pub fn size_of(path: &Path) -> Result<u64> {
    let metadata = fs::metadata(&*place_of(path)?);
    Ok(metadata
        .map_err(|error| Error::from_read(&error, path))?
        .len())
}

/// All bytes of an input.
///
/// # Errors
/// As [`place_of`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    fs::read(&*place_of(path)?).map_err(|error| Error::from_read(&error, path))
}

/// The content of a pipe, read now where nobody has asked for it yet.
fn spooled(path: &Path) -> Result<Place> {
    let slot = match known().as_mut() {
        Some(known) => known.pipes.entry(path.to_path_buf()).or_default().clone(),
        None => Slot::default(),
    };
    let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
    let kept = slot
        .get_or_insert_with(|| spool(path).map(Arc::new))
        .clone()?;
    Ok(Place {
        path: kept.path().to_path_buf(),
        kept: Some(kept),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_is_no_input_and_an_input_no_output() {
        let _kept = KeptInputs::of_run();
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "x").unwrap();
        fs::hard_link(&file, &link).unwrap();
        let claim = Claim::new(&file).unwrap();
        assert_eq!(read_bytes(&link).unwrap_err().kind, ErrorKind::CannotCreate);
        drop(claim);
        assert_eq!(read_bytes(&link).unwrap(), b"x");
        assert_eq!(Claim::new(&file).unwrap_err().kind, ErrorKind::CannotCreate);
        assert_eq!(
            refuse_read(&file).unwrap_err().kind,
            ErrorKind::CannotCreate
        );
    }
}
