//! Temporary files beside results, and the removal of those that killed runs left.
//!
//! A run locks its temporary file until the file is renamed. The system releases the lock
//! when the process ends, however it ends. The next run that writes into a folder removes
//! temporary files without a lock.

use crate::limits::{ABANDONED, TRIES};
use std::collections::HashSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use tempfile::NamedTempFile;

const PREFIX: &str = ".chladni-";
const SUFFIX: &str = ".tmp";

/// The folder that a path lies in.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."))
}

/// A new file beside `target`, locked where the file system supports locks.
pub(super) fn beside(target: &Path) -> io::Result<NamedTempFile> {
    let folder = folder_of(target);
    remove_leftovers_once(folder);
    let mut tries = 1;
    loop {
        let file = create(folder)?;
        let is_ours = match file.as_file().try_lock() {
            Ok(()) => file.path().exists(),
            Err(TryLockError::WouldBlock) => false,
            // without locks no other run removes it
            Err(TryLockError::Error(_)) => true,
        };
        if is_ours || tries == TRIES {
            return Ok(file);
        }
        tries += 1;
    }
}

fn create(folder: &Path) -> io::Result<NamedTempFile> {
    let prefix = prefix();
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    {
        // the umask applies to it, as to any other file
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// Beginning of the names of temporary files of this machine since its last start; on Linux
/// it has a part that is random for each start.
fn prefix() -> String {
    let start = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    format!("{PREFIX}{}-", start.split('-').next().unwrap_or_default())
}

/// Removes what killed runs left in `folder`, once for each process.
fn remove_leftovers_once(folder: &Path) {
    static SEEN: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    let is_first = SEEN
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .insert(folder.to_path_buf());
    if is_first {
        remove_leftovers(folder);
    }
}

/// Removes leftovers. Failures are ignored: a leftover disturbs no run.
fn remove_leftovers(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PREFIX) && name.ends_with(SUFFIX) {
            drop(remove_leftover(&entry.path(), name.starts_with(&prefix())));
        }
    }
}

/// Removes a file without a lock; one of another machine only where it is old.
fn remove_leftover(path: &Path, is_ours: bool) -> io::Result<()> {
    let metadata = fs::symlink_metadata(path)?;
    let age = metadata.modified()?.elapsed().unwrap_or_default();
    if !metadata.is_file() || !(is_ours || age > ABANDONED) {
        return Ok(());
    }
    let file = File::options().read(true).write(true).open(path)?;
    match file.try_lock() {
        Ok(()) => fs::remove_file(path),
        Err(_) => Ok(()),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_file_at_work_stays_and_a_leftover_goes() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out.json");
        let at_work = beside(&target).unwrap();
        let leftover = folder.path().join(format!("{}abc{SUFFIX}", prefix()));
        let of_another = folder.path().join(format!("{PREFIX}00000000-abc{SUFFIX}"));
        let of_others = folder.path().join(".another-abc.tmp");
        for path in [&leftover, &of_another, &of_others] {
            fs::write(path, "half").unwrap();
        }
        remove_leftovers(folder.path());
        assert!(at_work.path().exists() && of_another.exists() && of_others.exists());
        assert!(!leftover.exists());
        let old = std::time::SystemTime::now() - 2 * ABANDONED;
        let file = File::options().write(true).open(&of_another).unwrap();
        file.set_modified(old).unwrap();
        drop(file);
        remove_leftovers(folder.path());
        assert!(at_work.path().exists() && !of_another.exists());
    }
}
