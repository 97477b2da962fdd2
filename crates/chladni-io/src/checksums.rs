//! Checksums of files: SHA-256 up to 1 GiB, BLAKE3 beyond.
//!
//! A file is read for its checksum, or the checksum is computed while the file is read part
//! by part for another purpose ([`Checksums`]).

use crate::limits::{BLOCK, SHA256_UP_TO_BYTES};
use chladni_frf::{Checksum, Error, Result, Source};
use chladni_text::door::{self, place_of, size_of};
use chladni_text::file_name;

use sha2::{Digest, Sha256};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// A checksum in progress.
enum Hash {
    Sha256(Sha256),
    Blake3(Box<blake3::Hasher>),
}

impl Hash {
    fn of_bytes(count: u64) -> Self {
        if count <= SHA256_UP_TO_BYTES {
            Self::Sha256(Sha256::new())
        } else {
            Self::Blake3(Box::default())
        }
    }

    fn of_file(path: &Path) -> Result<Self> {
        Ok(Self::of_bytes(size_of(path)?))
    }

    fn update(&mut self, bytes: &[u8]) {
        match self {
            Self::Sha256(hash) => hash.update(bytes),
            Self::Blake3(hash) => {
                hash.update(bytes);
            }
        }
    }

    fn finish(self) -> Checksum {
        match self {
            Self::Sha256(hash) => Checksum::Sha256(hexadecimal(hash)),
            Self::Blake3(hash) => Checksum::Blake3(hash.finalize().to_hex().to_string()),
        }
    }
}

/// Checksum of a file, to name it as a source.
///
/// # Errors
/// Those of reading.
pub fn checksum_of(path: &Path) -> Result<Checksum> {
    let mut hash = Hash::of_file(path)?;
    feed(&mut hash, path, 0, u64::MAX)?;
    Ok(hash.finish())
}

/// Checksum of a file with these bytes.
pub fn checksum_of_bytes(bytes: &[u8]) -> Checksum {
    let mut hash = Hash::of_bytes(bytes.len() as u64);
    hash.update(bytes);
    hash.finish()
}

/// SHA-256 of a file of any size, in hexadecimal digits.
///
/// # Errors
/// Those of reading.
pub fn sha256_of(path: &Path) -> Result<String> {
    let mut hash = Hash::Sha256(Sha256::new());
    feed(&mut hash, path, 0, u64::MAX)?;
    Ok(hash.finish().digits().to_owned())
}

/// Adds the bytes `from..to` of a file; those beyond its end are left out.
fn feed(hash: &mut Hash, path: &Path, from: u64, to: u64) -> Result<()> {
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
pub fn sha256_of_bytes(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Checksums of files whose bytes several threads read for another purpose.
///
/// The threads hand over the stretches that they read in the order of the files
/// ([`Turn::pass`]). Bytes between the stretches are read here.
pub struct Checksums {
    files: Vec<PathBuf>,
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    begun: bool,
    /// Number of the stretch that comes next.
    turn: usize,
    /// Checksums of the files that are complete.
    done: Vec<Checksum>,
    /// Checksum of the current file up to `position`; `None` before its first byte.
    hash: Option<Hash>,
    position: u64,
    /// True once a stretch was not handed over; then all files are read for their checksums.
    given_up: bool,
}

/// The right to hand over stretch `number`. A turn that is dropped unused gives the checksums
/// up.
pub struct Turn<'a> {
    checksums: &'a Checksums,
    number: usize,
    /// Index of the file.
    file: usize,
    used: bool,
}

impl Checksums {
    /// Checksums of `files`, in this order.
    pub fn new(files: &[PathBuf]) -> Self {
        let state = State {
            begun: false,
            turn: 0,
            done: Vec::new(),
            hash: None,
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
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns true at the first call only: the first of several passes over the files hands
    /// stretches over.
    pub fn begin(&self) -> bool {
        !std::mem::replace(&mut self.state().begun, true)
    }

    /// The turn of stretch `number`, counted over all files, in file number `file` (from 0).
    pub fn turn(&self, number: usize, file: usize) -> Turn<'_> {
        Turn {
            checksums: self,
            number,
            file,
            used: false,
        }
    }

    /// Stops waiting for stretches; [`Self::sources`] then reads all files.
    pub fn give_up(&self) {
        self.state().given_up = true;
        self.changed.notify_all();
    }

    /// The files with their checksums. Bytes that were not handed over are read now.
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
            let checksum = if has_passed {
                state.done[place].clone()
            } else {
                checksum_of(path)?
            };
            Ok(Source {
                file: file_name(path),
                checksum,
            })
        };
        self.files.iter().enumerate().map(of).collect()
    }
}

impl State {
    /// Takes the checksum of the current file out.
    fn hash(&mut self, file: &Path) -> Result<Hash> {
        self.hash.take().map_or_else(|| Hash::of_file(file), Ok)
    }

    /// Completes the checksum of the current file.
    fn close(&mut self, files: &[PathBuf]) -> Result<()> {
        let file = &files[self.done.len()];
        let mut hash = self.hash(file)?;
        feed(&mut hash, file, self.position, u64::MAX)?;
        self.done.push(hash.finish());
        self.position = 0;
        Ok(())
    }

    /// Adds bytes from `start` on of the current file, and those before that were skipped.
    fn add(&mut self, file: &Path, start: u64, bytes: &[u8]) -> Result<()> {
        let mut hash = self.hash(file)?;
        feed(&mut hash, file, self.position, start)?;
        hash.update(bytes);
        self.hash = Some(hash);
        self.position = start + bytes.len() as u64;
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
    /// Hands over the bytes from `start` on of the file; waits for all stretches before.
    pub fn pass(&mut self, start: u64, bytes: &[u8]) {
        let Checksums { files, changed, .. } = self.checksums;
        let state = self.checksums.state();
        let mut state = changed
            .wait_while(state, |state| !state.given_up && state.turn != self.number)
            .unwrap_or_else(PoisonError::into_inner);
        if state.given_up {
            return;
        }
        let ready = state.go_to(files, self.file).is_ok() && state.position <= start;
        if ready && state.add(&files[self.file], start, bytes).is_ok() {
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

/// Number of bytes of an input, and a stamp that changes when it does: the time of the last
/// change, or of a pipe the SHA-256 of its bytes.
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

    fn expected(files: &[PathBuf]) -> Vec<Checksum> {
        let of = |path: &PathBuf| checksum_of(path).unwrap();
        files.iter().map(of).collect()
    }

    fn sums(checksums: &Checksums) -> Vec<Checksum> {
        let sources = checksums.sources().unwrap();
        sources.into_iter().map(|source| source.checksum).collect()
    }

    #[test]
    fn a_file_beyond_one_gibibyte_is_named_by_blake3_whichever_way_it_is_read() {
        let nothing = Hash::Blake3(Box::default()).finish();
        let published = "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";
        assert_eq!(
            nothing,
            Checksum::Blake3(published.into()),
            "published, of nothing"
        );

        let directory = tempfile::tempdir().unwrap();
        let sized = |name: &str, bytes| {
            let path = directory.path().join(name);
            // a file with a hole: it takes no place on the disk
            std::fs::File::create(&path)
                .unwrap()
                .set_len(bytes)
                .unwrap();
            path
        };
        let files = [
            sized("largest with SHA-256", SHA256_UP_TO_BYTES),
            sized("larger", SHA256_UP_TO_BYTES + 1),
        ];
        let checksums = Checksums::new(&files);
        checksums.turn(0, 1).pass(10, &[0; 1000]);
        let sums = sums(&checksums);
        assert_eq!(sums, expected(&files));
        let fields: Vec<&str> = sums.iter().map(Checksum::field).collect();
        assert_eq!(fields, ["sha256", "blake3"]);
    }

    #[test]
    fn stretches_in_any_order_of_arrival_give_the_sums_of_the_files() {
        let directory = tempfile::tempdir().unwrap();
        let files = files(directory.path());
        let nothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(
            expected(&files)[1].digits(),
            nothing,
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
