//! The content of a pipe, kept in a temporary file that can be read as often as wanted.

use crate::limits::{BLOCK, SPOOL_MOST};
use chladni_frf::{Error, ErrorKind, Result};
use std::fs::{self, File};
use std::io::{self, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// The name of the standard input.
pub(crate) const STANDARD_INPUT: &str = "-";

/// The content of a pipe, in a file.
#[derive(Debug)]
pub(crate) struct Spooled {
    path: PathBuf,
    _kept: Kept,
}

#[derive(Debug)]
enum Kept {
    /// Without a name: gone with the process, however that ends.
    #[cfg(target_os = "linux")]
    Open(#[allow(dead_code)] File),
    Named(#[allow(dead_code)] TempPath),
}

/// Reads a pipe, a terminal or the standard input to its end.
///
/// # Errors
/// Those of reading and of the temporary file; a device; a pipe that gives too much.
pub(crate) fn spool(path: &Path) -> Result<Spooled> {
    let on_read = |error: io::Error| Error::from_read(&error, path);
    if path.as_os_str() == STANDARD_INPUT {
        let stdin = io::stdin();
        refuse_device(Path::new("/dev/stdin"), stdin.is_terminal())
            .map_err(|error| error.file(path))?;
        return keep(&mut stdin.lock(), path, SPOOL_MOST);
    }
    let mut pipe = File::open(path).map_err(on_read)?;
    refuse_device(path, pipe.is_terminal()).map_err(|error| error.file(path))?;
    keep(&mut pipe, path, SPOOL_MOST)
}

fn refuse_device(path: &Path, is_terminal: bool) -> Result<()> {
    if is_terminal || !fs::metadata(path).is_ok_and(|metadata| is_device(metadata.file_type())) {
        return Ok(());
    }
    Err(Error::bad_data("a device, of which no end is known")
        .found("a device")
        .expected("a file or a pipe")
        .help("copy what is wanted of it to a file"))
}

#[cfg(unix)]
fn is_device(kind: fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: fs::FileType) -> bool {
    false
}

/// Copies all that `pipe` gives, at most `most` bytes, into a temporary file.
fn keep(pipe: &mut dyn Read, path: &Path, most: u64) -> Result<Spooled> {
    let on_write = |error: io::Error| {
        Error::new(
            ErrorKind::Io,
            format!("cannot keep what the pipe gives: {error}"),
        )
        .file(path)
        .found(format!("the folder {}", std::env::temp_dir().display()))
        .expected("a folder for temporary files with room for the input")
        .help("name another with TMPDIR, or give the data as a file")
    };
    let (mut file, spooled) = Spooled::new().map_err(on_write)?;
    let mut block = vec![0; BLOCK];
    let mut bytes = 0;
    loop {
        let count = match pipe.read(&mut block) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(Error::from_read(&error, path)),
        };
        bytes += count as u64;
        if bytes > most {
            return Err(Error::bad_data("the pipe gives more than is kept of one")
                .file(path)
                .found(format!("more than {most} bytes"))
                .expected(format!("at most {} MiB", most >> 20))
                .help("give the data as a file: files of any size are read"));
        }
        file.write_all(&block[..count]).map_err(on_write)?;
    }
    Ok(spooled)
}

impl Spooled {
    /// The path where it can be read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Empty, and open to write.
    fn new() -> io::Result<(File, Self)> {
        #[cfg(target_os = "linux")]
        {
            use std::os::fd::AsRawFd;
            // a file without a name is opened again by way of its descriptor
            let file = tempfile::tempfile()?;
            let kept = file.try_clone()?;
            let path = PathBuf::from(format!("/proc/self/fd/{}", kept.as_raw_fd()));
            if File::open(&path).is_ok() {
                let _kept = Kept::Open(kept);
                return Ok((file, Self { path, _kept }));
            }
        }
        let (file, path) = tempfile::NamedTempFile::new()?.into_parts();
        let spooled = Self {
            path: path.to_path_buf(),
            _kept: Kept::Named(path),
        };
        Ok((file, spooled))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_pipe_gave_is_read_as_often_as_wanted() {
        let place = keep(&mut &b"three words here"[..], Path::new("pipe"), 16).unwrap();
        for _ in 0..2 {
            assert_eq!(fs::read(&place.path).unwrap(), b"three words here");
        }
    }

    #[test]
    fn a_pipe_that_gives_too_much_is_refused_with_the_bound() {
        let error = keep(&mut io::repeat(0), Path::new("pipe"), 3 << 20).unwrap_err();
        assert_eq!(error.kind, ErrorKind::BadData);
        let text = error.to_string();
        assert!(
            text.contains("at most 3 MiB") && text.contains("pipe"),
            "{text}"
        );
    }
}
