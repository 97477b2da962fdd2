//! Writing of results under a temporary name and renaming: an interrupted run leaves the
//! old file or none.

use super::temporary::{self, folder_of};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_text::door::{is_same, refuse_read};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes `path` as a whole or not at all: `write` fills a temporary file beside it,
/// which is then renamed.
///
/// A device or pipe (`/dev/stdout`, `/dev/null`) is written directly. Of a link, the file
/// that it points to is replaced.
///
/// # Errors
/// [`ErrorKind::CannotCreate`] when the folder does not exist, or the file exists and
/// `force` is false; [`ErrorKind::Io`] when writing fails (disk full); whatever `write`
/// returns.
pub fn write_atomically(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    if is_device(path) {
        let file = fs::OpenOptions::new()
            .write(true)
            .open(path)
            .map_err(|error| write_error(&error, path))?;
        let mut buffered = BufWriter::new(file);
        return write(&mut buffered)
            .and_then(|()| buffered.flush())
            .map_err(|error| write_error(&error, path));
    }
    let target = free_target(path, force)?;
    let mut file = temporary_beside(&target)?;
    let written = {
        let mut buffered = BufWriter::with_capacity(1 << 20, file.as_file_mut());
        write(&mut buffered).and_then(|()| buffered.flush())
    };
    written.map_err(|error| write_error(&error, path))?;
    persist(file, &target, force)
}

/// Writes files that belong together: all are complete under temporary names before the
/// first is renamed, so that none of them stands beside an old one where the disk is full.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_together(files: &[(&Path, &[u8])], force: bool) -> Result<()> {
    let mut waiting = Vec::with_capacity(files.len());
    for &(path, bytes) in files.iter().filter(|(path, _)| !is_device(path)) {
        let target = free_target(path, force)?;
        let mut file = temporary_beside(&target)?;
        let written = file
            .write_all(bytes)
            .and_then(|()| file.as_file().sync_all());
        written.map_err(|error| write_error(&error, path))?;
        waiting.push((file, target));
    }
    for &(path, bytes) in files.iter().filter(|(path, _)| is_device(path)) {
        write_atomically(path, force, |out| out.write_all(bytes))?;
    }
    waiting
        .into_iter()
        .try_for_each(|(file, target)| persist(file, &target, force))
}

/// Like [`write_atomically`] for libraries that want a path: `write` creates the file
/// under the path that it is given.
///
/// # Errors
/// As [`write_atomically`].
pub fn create_atomically(
    path: &Path,
    force: bool,
    write: impl FnOnce(&Path) -> Result<()>,
) -> Result<()> {
    if is_device(path) {
        return Err(Error::new(
            ErrorKind::CannotCreate,
            "this format needs a file, not a device or pipe",
        )
        .file(path)
        .found("a device or pipe")
        .expected("the name of a file")
        .help("give the name of a file"));
    }
    let target = free_target(path, force)?;
    let temporary = temporary_beside(&target)?;
    write(temporary.path()).map_err(|mut error| {
        error.file = Some(path.to_path_buf());
        error
    })?;
    persist(temporary, &target, force)
}

/// Checks, before long work, that `path` can be written: a temporary file is created beside
/// it and removed.
///
/// # Errors
/// As [`write_atomically`].
pub fn try_place(path: &Path, force: bool) -> Result<()> {
    if is_device(path) {
        return Ok(());
    }
    let target = free_target(path, force)?;
    temporary_beside(&target).map(drop)
}

/// True where two outputs are, or would be, one file.
pub fn is_same_place(one: &Path, other: &Path) -> bool {
    let folder = |path: &Path| fs::canonicalize(folder_of(path)).ok();
    let would_be = one.file_name() == other.file_name() && folder(one) == folder(other);
    would_be || is_same(one, other)
}

/// Refuses an output that is one of the inputs, however its path is written, even where
/// files may be overwritten.
///
/// # Errors
/// [`ErrorKind::CannotCreate`] naming the input.
pub fn refuse_output_among_inputs(output: &Path, inputs: &[PathBuf]) -> Result<()> {
    for input in inputs {
        if is_same(input, output) {
            return Err(
                Error::new(ErrorKind::CannotCreate, "the output is one of the inputs")
                    .file(output)
                    .found(input.display())
                    .expected("a file that is not read")
                    .help("give the result another name with -o"),
            );
        }
    }
    Ok(())
}

/// An operating-system failure while writing `path`.
pub(crate) fn write_error(error: &io::Error, path: &Path) -> Error {
    let kind = error.kind();
    // the user knows nothing of the temporary file
    let error = error.to_string();
    let error = error.split(" at path ").next().unwrap_or_default();
    match kind {
        io::ErrorKind::PermissionDenied
        | io::ErrorKind::NotFound
        | io::ErrorKind::ReadOnlyFilesystem => {
            Error::new(ErrorKind::CannotCreate, format!("cannot create: {error}"))
                .file(path)
                .help("check the folder and its permissions, or choose another")
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            Error::new(ErrorKind::Io, format!("cannot write: {error}"))
                .file(path)
                .help("free some space or write elsewhere with -o; nothing was left behind")
        }
        _ => Error::new(ErrorKind::Io, format!("cannot write: {error}")).file(path),
    }
}

fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// The file to be replaced or created, links followed.
fn free_target(path: &Path, force: bool) -> Result<PathBuf> {
    let refuse = |message: &str, help: &str| {
        Err(Error::new(ErrorKind::CannotCreate, message)
            .file(path)
            .help(help))
    };
    if path.file_name().is_none() || path.is_dir() {
        return refuse(
            "a folder stands where the file should be written",
            "give the name of a file",
        );
    }
    if path.exists() {
        if !force {
            return refuse(
                "the file exists",
                "choose another name, or overwrite it with `force`",
            );
        }
        refuse_read(path)?;
        return fs::canonicalize(path).map_err(|error| write_error(&error, path));
    }
    if !folder_of(path).is_dir() {
        return refuse(
            "no such folder for the output",
            "create the folder first, or choose another",
        );
    }
    Ok(path.to_path_buf())
}

fn temporary_beside(target: &Path) -> Result<NamedTempFile> {
    temporary::beside(target).map_err(|error| write_error(&error, target))
}

fn persist(temporary: NamedTempFile, target: &Path, force: bool) -> Result<()> {
    let written = fs::File::open(temporary.path()).and_then(|file| file.sync_all());
    written.map_err(|error| write_error(&error, target))?;
    let renamed = if force {
        temporary.persist(target)
    } else {
        temporary.persist_noclobber(target)
    };
    renamed.map_err(|failure| match failure.error.kind() {
        io::ErrorKind::AlreadyExists => Error::new(ErrorKind::CannotCreate, "the file exists")
            .file(target)
            .help("choose another name, or overwrite it with `force`"),
        _ => write_error(&failure.error, target),
    })?;
    // the new name is on disk once its folder is; not every file system can sync a folder
    if let Ok(folder) = fs::File::open(folder_of(target)) {
        folder.sync_all().ok();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn files_that_belong_together_are_written_both_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let [one, two] = ["one.json", "two.wav"].map(|name| folder.path().join(name));
        write_together(&[(&one, b"1"), (&two, b"2")], false).unwrap();
        assert_eq!(fs::read(&two).unwrap(), b"2");
        // the second cannot be written: its folder is gone
        let lost = folder.path().join("gone").join("two.wav");
        write_together(&[(&one, b"new"), (&lost, b"new")], true).unwrap_err();
        assert_eq!(fs::read(&one).unwrap(), b"1");
        // nor may it be, though the first one is free
        let free = folder.path().join("free.json");
        write_together(&[(&free, b"new"), (&two, b"new")], false).unwrap_err();
        assert_eq!(entries(folder.path()), ["one.json", "two.wav"]);
    }

    #[test]
    fn an_existing_file_is_kept_without_force_and_replaced_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        write_atomically(&path, false, |out| out.write_all(b"one")).unwrap();
        let error = write_atomically(&path, false, |out| out.write_all(b"two")).unwrap_err();
        assert_eq!(error.kind, ErrorKind::CannotCreate);
        assert!(error.to_string().contains("`force`"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"one");
        write_atomically(&path, true, |out| out.write_all(b"two")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(entries(folder.path()), ["out.csv"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        fs::write(&path, b"old").unwrap();
        let full = |_: &mut dyn Write| Err(io::Error::from(io::ErrorKind::StorageFull));
        let error = write_atomically(&path, true, full).unwrap_err();
        assert_eq!(error.kind, ErrorKind::Io);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(entries(folder.path()), ["out.csv"]);
    }

    #[test]
    fn a_missing_folder_and_a_folder_as_file_cannot_be_created() {
        let folder = tempfile::tempdir().unwrap();
        for path in [
            folder.path().join("no/such/out.csv"),
            folder.path().to_path_buf(),
        ] {
            let error = write_atomically(&path, true, |_| Ok(())).unwrap_err();
            assert_eq!(error.kind, ErrorKind::CannotCreate, "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_to_and_never_replaced() {
        let null = Path::new("/dev/null");
        write_atomically(null, false, |out| out.write_all(b"gone")).unwrap();
        let error = create_atomically(null, true, |_| Ok(())).unwrap_err();
        assert_eq!(error.kind, ErrorKind::CannotCreate);
        assert!(is_device(null));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_keeps_pointing_to_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_atomically(&link, true, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[test]
    fn an_input_is_never_the_output() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in.csv");
        fs::write(&input, b"x").unwrap();
        let same = folder.path().join(".").join("in.csv");
        let error = refuse_output_among_inputs(&same, std::slice::from_ref(&input)).unwrap_err();
        assert_eq!(error.kind, ErrorKind::CannotCreate);
        refuse_output_among_inputs(&folder.path().join("out.csv"), &[input]).unwrap();
    }
}
