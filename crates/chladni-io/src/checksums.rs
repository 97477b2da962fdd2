//! SHA-256 of files: of one that is read for it, and of many whose bytes pass by while
//! they are read part by part.

use crate::limits::BLOCK;
use chladni_frf::{Error, Result, Source};
use chladni_text::door::{self, place_of, size_of};
use chladni_text::file_name;

use sha2::{Digest, Sha256};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard};

/// SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// Those of reading.
pub fn sha256_of(path: &Path) -> Result<String> {
    let mut hash = Sha256::new();
    feed(&mut hash, path, 0, u64::MAX)?;
    Ok(hexadecimal(hash))
}

/// Adds the bytes `from..to` of a file, or up to its end.
fn feed(hash: &mut Sha256, path: &Path, from: u64, to: u64) -> Result<()> {
    let on_read = |error: std::io::Error| Error::from_read(&error, path);
    let mut file = door::open(path)?;
    file.seek(SeekFrom::Start(from)).map_err(on_read)?;
    let mut file = file.take(to - from);
    let mut block = vec![0; BLOCK];
    loop {
        match file.read(&mut block).map_err(on_read)? {
            0 => return Ok(()),
            count => hash.update(&block[..count]),
        }
    }
}

/// SHA-256 of bytes, in hexadecimal digits.
pub(super) fn sha256_of_bytes(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Checksums of files from stretches of them that several threads read, each handed over
/// in its turn; what lies between is read.
pub struct Checksums {
    files: Vec<PathBuf>,
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    begun: bool,
    /// Of the stretch that is expected.
    turn: usize,
    /// Sums of the files before this one.
    done: Vec<String>,
    /// Of the file that is passing, up to here.
    hash: Sha256,
    position: u64,
    /// True once a stretch failed to come: all files are to be read.
    given_up: bool,
}

/// The right to hand over stretch `number` of all; where none comes of it, the checksums
/// are given up.
pub struct Turn<'a> {
    checksums: &'a Checksums,
    number: usize,
    /// Place among the files.
    file: usize,
    used: bool,
}

impl Checksums {
    /// Of `files`, in this order.
    pub fn new(files: &[PathBuf]) -> Self {
        let state = State {
            begun: false,
            turn: 0,
            done: Vec::new(),
            hash: Sha256::new(),
            position: 0,
            given_up: false,
        };
        Self {
            files: files.to_vec(),
            state: Mutex::new(state),
            changed: Condvar::new(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("nothing panics while it is held")
    }

    /// True once: of several passes over the files only the first hands stretches over.
    pub fn begin(&self) -> bool {
        !std::mem::replace(&mut self.state().begun, true)
    }

    /// The turn of stretch `number`, counted over all files, which lies in file `file`.
    pub fn turn(&self, number: usize, file: usize) -> Turn<'_> {
        Turn {
            checksums: self,
            number,
            file,
            used: false,
        }
    }

    /// No stretch need be waited for any more.
    pub fn give_up(&self) {
        self.state().given_up = true;
        self.changed.notify_all();
    }

    /// The files with their checksums: of what passed and of the rest, or of files read
    /// now.
    ///
    /// # Errors
    /// Those of reading.
    pub fn sources(&self) -> Result<Vec<Source>> {
        let mut state = self.state();
        let has_passed = !state.given_up && state.turn > 0;
        if has_passed && state.done.len() < self.files.len() {
            let last = self.files.len() - 1;
            state.go_to(&self.files, last)?;
            state.close(&self.files)?;
        }
        let of = |(place, path): (usize, &PathBuf)| {
            let sha256 = if has_passed {
                state.done[place].clone()
            } else {
                sha256_of(path)?
            };
            Ok(Source {
                file: file_name(path),
                sha256,
            })
        };
        self.files.iter().enumerate().map(of).collect()
    }
}

impl State {
    /// The rest of the file that is passing.
    fn close(&mut self, files: &[PathBuf]) -> Result<()> {
        feed(
            &mut self.hash,
            &files[self.done.len()],
            self.position,
            u64::MAX,
        )?;
        self.done.push(hexadecimal(std::mem::take(&mut self.hash)));
        self.position = 0;
        Ok(())
    }

    fn go_to(&mut self, files: &[PathBuf], file: usize) -> Result<()> {
        while self.done.len() < file {
            self.close(files)?;
        }
        Ok(())
    }
}

impl Turn<'_> {
    /// Hands over the bytes that lie at `start` of the file, once all before have been.
    pub fn pass(&mut self, start: u64, bytes: &[u8]) {
        let Checksums { files, changed, .. } = self.checksums;
        let state = self.checksums.state();
        let mut state = changed
            .wait_while(state, |state| !state.given_up && state.turn != self.number)
            .expect("nothing panics while it is held");
        if state.given_up {
            return;
        }
        let ready = state.go_to(files, self.file).is_ok() && state.position <= start;
        let position = state.position;
        if ready && feed(&mut state.hash, &files[self.file], position, start).is_ok() {
            state.hash.update(bytes);
            state.position = start + bytes.len() as u64;
            state.turn += 1;
            self.used = true;
            changed.notify_all();
        }
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        if !self.used {
            self.checksums.give_up();
        }
    }
}

/// A stamp that tells an input from another of the same name: when it was changed, or of
/// a pipe what it gave. And its number of bytes.
///
/// # Errors
/// As [`place_of`].
pub fn stamp_of(path: &Path) -> Result<(u64, String)> {
    let place = place_of(path)?;
    if place.is_temporary() {
        return Ok((size_of(path)?, sha256_of(path)?));
    }
    let metadata = std::fs::metadata(&*place).map_err(|error| Error::from_read(&error, path))?;
    let changed = metadata.modified().ok();
    let changed = changed.and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok());
    Ok((
        metadata.len(),
        changed.map_or_else(String::new, |time| format!("{} ns", time.as_nanos())),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    fn files(directory: &Path) -> Vec<PathBuf> {
        let bytes = |count: usize| (0..count).map(|k| (k * k % 251) as u8).collect::<Vec<u8>>();
        let write = |(name, count)| {
            let path = directory.join(name);
            std::fs::write(&path, bytes(count)).unwrap();
            path
        };
        [("one", 300_000), ("empty", 0), ("two", 70_000)]
            .map(write)
            .to_vec()
    }

    fn expected(files: &[PathBuf]) -> Vec<String> {
        files.iter().map(|path| sha256_of(path).unwrap()).collect()
    }

    fn sums(checksums: &Checksums) -> Vec<String> {
        checksums
            .sources()
            .unwrap()
            .into_iter()
            .map(|source| source.sha256)
            .collect()
    }

    #[test]
    fn stretches_in_any_order_of_arrival_give_the_sums_of_the_files() {
        let directory = tempfile::tempdir().unwrap();
        let files = files(directory.path());
        assert_eq!(
            expected(&files)[1],
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
            "published, of nothing"
        );
        let checksums = Checksums::new(&files);
        // gaps before, between and after
        let stretches = [
            (0, 2048, 100_000),
            (0, 100_000, 250_000),
            (0, 260_000, 299_999),
            (2, 10, 70_000),
        ];
        thread::scope(|scope| {
            for (number, (file, start, end)) in stretches.into_iter().enumerate().rev() {
                let (checksums, path) = (&checksums, &files[file]);
                scope.spawn(move || {
                    checksums
                        .turn(number, file)
                        .pass(start, &std::fs::read(path).unwrap()[start as usize..end])
                });
            }
        });
        assert_eq!(sums(&checksums), expected(&files));
    }

    #[test]
    fn where_a_stretch_fails_to_come_nobody_waits_and_the_files_are_read() {
        let directory = tempfile::tempdir().unwrap();
        let files = files(directory.path());
        let checksums = Checksums::new(&files);
        thread::scope(|scope| {
            scope.spawn(|| checksums.turn(1, 0).pass(5, &[1, 2, 3]));
            drop(checksums.turn(0, 0));
        });
        assert_eq!(sums(&checksums), expected(&files));
    }
}
