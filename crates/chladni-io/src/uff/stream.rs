//! The lines of a file that is not held in memory, and the first bytes after a place in it.

use super::binary::Rest;
use super::fields::Record;
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes of a line that are read: no header has longer ones.
pub(super) const LONGEST_LINE: usize = 1 << 12;

/// A file that is read line by line.
pub(super) struct FileLines {
    input: BufReader<File>,
    length: u64,
    /// Offset of the end of the last line.
    at: u64,
    /// Offset of the last line.
    pub line_at: u64,
    /// Number of the last line, counted from `counted_from`.
    pub line: u64,
    /// Offset from which lines are counted; 0 is the beginning of the file.
    pub counted_from: u64,
    /// The last line, without its end and cut at [`LONGEST_LINE`].
    pub text: Vec<u8>,
}

impl FileLines {
    /// Opens `path` before its first line, after a byte-order mark.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let input = BufReader::with_capacity(1 << 16, file);
        let mut lines = Self {
            input,
            length,
            at: 0,
            line_at: 0,
            line: 0,
            counted_from: 0,
            text: Vec::with_capacity(LONGEST_LINE),
        };
        if lines.input.fill_buf()?.starts_with(b"\xef\xbb\xbf") {
            lines.input.consume(3);
            lines.at = 3;
        }
        Ok(lines)
    }

    /// Reads the next line; false at the end of the file.
    pub fn next_line(&mut self) -> io::Result<bool> {
        self.line_at = self.at;
        self.text.clear();
        loop {
            let buffer = self.input.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            let end = memchr::memchr(b'\n', buffer);
            let part = &buffer[..end.unwrap_or(buffer.len())];
            let room = LONGEST_LINE - self.text.len();
            self.text.extend_from_slice(&part[..part.len().min(room)]);
            let used = part.len() + usize::from(end.is_some());
            self.input.consume(used);
            self.at += used as u64;
            if end.is_some() {
                break;
            }
        }
        if self.text.last() == Some(&b'\r') {
            self.text.pop();
        }
        let found = self.at > self.line_at;
        self.line += u64::from(found);
        Ok(found)
    }

    /// True where the last line is blank.
    pub fn is_blank(&self) -> bool {
        self.text.trim_ascii().is_empty()
    }

    /// The last line as a record of its dataset.
    pub fn record(&self) -> Record<'_> {
        Record {
            line: self.line,
            text: &self.text,
        }
    }

    /// The rest after the last line, and its offset in the file.
    pub fn rest(&self) -> (FileRest<'_>, u64) {
        (
            FileRest {
                file: self.input.get_ref(),
                from: self.at,
                length: self.length - self.at.min(self.length),
            },
            self.at,
        )
    }

    /// Goes on `count` bytes after the last line, and counts lines anew from there.
    pub fn skip_bytes(&mut self, count: u64) -> io::Result<()> {
        self.at += count;
        (self.line_at, self.counted_from, self.line) = (self.at, self.at, 0);
        self.return_behind_last_line()
    }

    /// Goes back to the end of the last line, after use of the [rest](Self::rest).
    pub fn return_behind_last_line(&mut self) -> io::Result<()> {
        self.input.seek(SeekFrom::Start(self.at)).map(drop)
    }
}

/// The rest of a file, of which a few bytes are read.
pub(super) struct FileRest<'a> {
    file: &'a File,
    from: u64,
    length: u64,
}

impl Rest for FileRest<'_> {
    fn length(&self) -> u64 {
        self.length
    }
    fn behind(&self, offset: u64) -> Cow<'_, [u8]> {
        let mut bytes = Vec::new();
        let mut file = self.file;
        let read = file.seek(SeekFrom::Start(self.from.saturating_add(offset)));
        // unreadable bytes count as no marker: the dataset is then listed as damaged
        let read = read.and_then(|_| file.take(LONGEST_LINE as u64).read_to_end(&mut bytes));
        if read.is_err() {
            bytes.clear();
        }
        Cow::Owned(bytes)
    }
}
