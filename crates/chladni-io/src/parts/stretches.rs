//! Stretches of a universal file that are read as if they were a file, and the places in the
//! file that lines and bytes among them stand for.

use crate::Document;
use chladni_frf::{Error, Result};
use chladni_text::door;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// A dataset in its file.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub(super) bytes: Range<u64>,
    /// Line at which it begins, counted from 1, where that is known.
    pub(super) line: Option<u64>,
}

impl Stretch {
    pub(super) fn length(&self) -> u64 {
        self.bytes.end - self.bytes.start
    }
}

/// The bytes of some stretches, one after the other.
pub(super) struct Joined {
    pub(super) bytes: Vec<u8>,
    starts: Vec<Start>,
}

/// The beginning of a stretch, among the joined ones and in the file. Bytes are counted from
/// 0, lines from 1.
struct Start {
    byte: u64,
    byte_in_file: u64,
    line: u64,
    line_in_file: Option<u64>,
}

impl Joined {
    /// Reads stretches in the order of the file, neighbours at once.
    pub(super) fn read(path: &Path, mut wanted: Vec<&Stretch>) -> Result<Self> {
        let on_read = |error: std::io::Error| Error::from_read(&error, path);
        wanted.sort_by_key(|stretch| stretch.bytes.start);
        let mut file = door::open(path)?;
        let mut bytes = Vec::new();
        for neighbours in wanted.chunk_by(|a, b| a.bytes.end == b.bytes.start) {
            let start = neighbours[0].bytes.start;
            let length = neighbours.iter().map(|stretch| stretch.length()).sum();
            file.seek(SeekFrom::Start(start)).map_err(on_read)?;
            (&mut file)
                .take(length)
                .read_to_end(&mut bytes)
                .map_err(on_read)?;
        }
        let starts = starts_of(&wanted, &bytes);
        Ok(Self { bytes, starts })
    }

    /// Gives the errors, functions and shapes of a document of these bytes their places in
    /// the file; line 0 is not known.
    pub(super) fn tell_places(&self, document: &mut Document) {
        for error in &mut document.errors {
            let joined_line = error.line.take();
            error.line = joined_line.and_then(|line| self.line_in_file(line));
            let begin = joined_line.filter(|_| error.line.is_none());
            let byte = error.byte.or_else(|| Some(self.byte_of_line(begin?)));
            error.byte = byte.map(|byte| self.byte_in_file(byte));
        }
        let functions = document.functions.iter_mut();
        let shapes = document.shapes.iter_mut();
        let lines = (functions.map(|function| &mut function.line))
            .chain(shapes.map(|shape| &mut shape.line));
        lines.for_each(|line| *line = self.line_in_file(*line).unwrap_or(0));
    }

    fn byte_in_file(&self, byte: u64) -> u64 {
        let behind = self.starts.partition_point(|start| start.byte <= byte);
        match self.starts[..behind].last() {
            Some(start) => start.byte_in_file + (byte - start.byte),
            None => byte,
        }
    }

    fn line_in_file(&self, line: u64) -> Option<u64> {
        let behind = self.starts.partition_point(|start| start.line <= line);
        let start = self.starts[..behind].last()?;
        Some(start.line_in_file? + (line - start.line))
    }

    /// The byte at which a line begins, among the joined bytes.
    fn byte_of_line(&self, line: u64) -> u64 {
        let before = usize::try_from(line.saturating_sub(2)).unwrap_or(usize::MAX);
        let end = memchr::memchr_iter(b'\n', &self.bytes).nth(before);
        end.filter(|_| line > 1).map_or(0, |end| end as u64 + 1)
    }
}

/// The beginnings of the stretches whose bytes these are.
fn starts_of(stretches: &[&Stretch], bytes: &[u8]) -> Vec<Start> {
    // lines are not counted in vain: not where binary data hide those of the file
    let has_lines = stretches.iter().all(|stretch| stretch.line.is_some());
    let (mut at, mut line) = (0_usize, 1);
    let mut start = |stretch: &&Stretch| {
        let start = Start {
            byte: at as u64,
            byte_in_file: stretch.bytes.start,
            line,
            line_in_file: stretch.line.filter(|_| has_lines),
        };
        let length = usize::try_from(stretch.length()).unwrap_or(usize::MAX);
        let end = at.saturating_add(length).min(bytes.len());
        if has_lines {
            line += memchr::memchr_iter(b'\n', &bytes[at..end]).count() as u64;
        }
        at = end;
        start
    };
    stretches.iter().map(&mut start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_among_joined_stretches_are_those_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines.txt");
        std::fs::write(&path, "a\nbb\nccc\ndddd\ne").unwrap();
        let stretch = |bytes, line| Stretch { bytes, line };
        // lines 5, 1 and 3, which are put in order
        let wanted = [
            stretch(14..15, Some(5)),
            stretch(0..2, Some(1)),
            stretch(5..9, Some(3)),
        ];
        let joined = Joined::read(&path, wanted.iter().collect()).unwrap();
        assert_eq!(joined.bytes, b"a\nccc\ne");
        let lines: Vec<_> = (1..=3).map(|line| joined.line_in_file(line)).collect();
        assert_eq!(lines, [Some(1), Some(3), Some(5)]);
        let bytes: Vec<_> = (1..=3).map(|line| joined.byte_of_line(line)).collect();
        assert_eq!(bytes, [0, 2, 6]);
        assert_eq!(
            [0, 2, 3, 6].map(|byte| joined.byte_in_file(byte)),
            [0, 5, 6, 14]
        );
    }
}
