//! Lines of a universal file, and the marks between its datasets.

use super::fields::Record;

/// Records of the header of dataset 58.
pub(super) const HEADER_RECORDS: usize = 11;

/// Lines of a part of the file, numbered as in the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lines<'a> {
    pub bytes: &'a [u8],
    /// Line number of the first line.
    pub line: u64,
}

impl<'a> Iterator for Lines<'a> {
    type Item = Record<'a>;
    fn next(&mut self) -> Option<Record<'a>> {
        if self.bytes.is_empty() {
            return None;
        }
        let (text, rest) = match memchr::memchr(b'\n', self.bytes) {
            Some(end) => (&self.bytes[..end], &self.bytes[end + 1..]),
            None => (self.bytes, &[][..]),
        };
        let record = Record {
            line: self.line,
            text: text.strip_suffix(b"\r").unwrap_or(text),
        };
        self.bytes = rest;
        self.line += 1;
        Some(record)
    }
}

impl<'a> Lines<'a> {
    /// The text between this position and a later one.
    pub fn until(self, later: Lines<'a>) -> Lines<'a> {
        Lines {
            bytes: &self.bytes[..self.bytes.len() - later.bytes.len()],
            line: self.line,
        }
    }
    /// The position `count` bytes further on, with the lines between counted.
    pub fn skip_bytes(self, count: usize) -> Lines<'a> {
        let (skipped, bytes) = self.bytes.split_at(count.min(self.bytes.len()));
        Lines {
            bytes,
            line: self.line + memchr::memchr_iter(b'\n', skipped).count() as u64,
        }
    }
}

/// True for `    -1`, padded with blanks or not at all.
pub(super) fn is_marker(text: &[u8]) -> bool {
    const LAST_COLUMN: usize = 6;
    // fast exit: most lines are data, which fill these columns
    if text
        .get(LAST_COLUMN)
        .is_some_and(|b| !b.is_ascii_whitespace())
    {
        return false;
    }
    match text.iter().position(|b| !b.is_ascii_whitespace()) {
        Some(start) if start + 2 <= LAST_COLUMN => text[start..].trim_ascii_end() == b"-1",
        _ => false,
    }
}
