//! Large stretches of a file that are read once, past the page cache of the system. The
//! cache would cost more processor time than the transfer from disk, and push other pages
//! out of memory.

use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom};
use std::path::Path;

/// Bytes read at a time; with fewer, the disk waits between requests.
#[cfg(any(target_os = "linux", test))]
const STRETCH: usize = 1 << 20;
/// Alignment of addresses in memory and offsets in the file. Where a disk needs more, it
/// refuses, and the file is read the usual way.
#[cfg(target_os = "linux")]
const ALIGNMENT: usize = 4096;

/// Reads `out.len()` bytes from byte `start` on into `out`.
///
/// # Errors
/// Those of reading; an end of the file before that of `out`.
pub(super) fn read_past_cache(path: &Path, start: u64, out: &mut [u8]) -> Result<()> {
    #[cfg(target_os = "linux")]
    if out.len() >= STRETCH && read_directly(path, start, out).is_ok() {
        return Ok(());
    }
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(start))?;
    file.read_exact(out)
}

/// Reads without the page cache; fails, among others, where the file system cannot do that.
#[cfg(target_os = "linux")]
fn read_directly(path: &Path, start: u64, out: &mut [u8]) -> Result<()> {
    use std::cell::RefCell;
    use std::os::unix::fs::{FileExt, OpenOptionsExt};
    thread_local! {
        static BUFFER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    }
    let file = File::options()
        .read(true)
        .custom_flags(libc::O_DIRECT)
        .open(path)?;
    BUFFER.with_borrow_mut(|buffer| {
        buffer.resize(STRETCH + ALIGNMENT, 0);
        let first = buffer.as_ptr().align_offset(ALIGNMENT);
        let buffer = &mut buffer[first..first + STRETCH];
        let mut done = 0;
        while done < out.len() {
            let at = start + done as u64;
            let before = (at % ALIGNMENT as u64) as usize;
            let count = file.read_at(buffer, at - before as u64)?;
            let here = &buffer[before.min(count)..count];
            if here.is_empty() {
                return Err(std::io::ErrorKind::UnexpectedEof.into());
            }
            let taken = here.len().min(out.len() - done);
            out[done..done + taken].copy_from_slice(&here[..taken]);
            done += taken;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stretch_is_what_lies_there() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("bytes");
        let bytes: Vec<u8> = (0..3 * STRETCH + 777).map(|k| (k % 251) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        for (start, end) in [
            (0, bytes.len()),
            (1, 2 * STRETCH),
            (4095, bytes.len()),
            (4097, 4097 + STRETCH),
            (5, 9),
            (7, 7),
        ] {
            let mut out = vec![0; end - start];
            read_past_cache(&path, start as u64, &mut out).unwrap();
            assert!(out == bytes[start..end], "{start} to {end}");
        }
        assert!(
            read_past_cache(&path, 1, &mut vec![0; bytes.len()]).is_err(),
            "beyond the end"
        );
    }
}
