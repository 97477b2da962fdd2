//! Universal files that are too large to be held: headers are read, data are passed over. Memory is that of the listing.
//!
//! The payload of a 58b is left out by seeking, as `binary` says where it ends; the lines of a text 58 are only counted. All other
//! datasets are small, and read as in a file that is held; one that is not small is listed by its name.

use super::binary::{self, Rest};
use super::container::{ends_in_header, is_marker, no_number, number_line, Block, Lines, HEADER_RECORDS};
use super::fields::{count_fields, count_tokens, Record};
use super::header::{self, Units};
use super::layout::{Layout, Record7};
use super::values::counts_disagree;
use super::{part, Collector, UnitsInForce};
use crate::io::{DatasetInfo, Document, ReadOptions};
use crate::{Error, Result};
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes of a line that are looked at: no header has longer ones.
const LONGEST_LINE: usize = 1 << 12;
/// Bytes of a dataset other than 58 that are read; a longer one is listed by its name.
const LARGEST_DATASET: usize = 16 << 20;

/// Lists a universal file without its values: `functions` and `shapes` of the document stay empty, and so does `sha256`.
///
/// Lines behind the first binary dataset are counted from its end, as the warnings of the datasets say.
///
/// # Errors
/// Those of reading, and as [`super::read`].
pub fn scan(path: &Path, options: &ReadOptions) -> Result<Document> {
    let on_read = |error: io::Error| Error::from_read(&error, path);
    let mut stream = Stream::open(path).map_err(on_read)?;
    let mut collector = Collector::new(path);
    let mut units: UnitsInForce = Ok(None);
    while let Some(passed) = stream.next_dataset(options.lenient).map_err(on_read)? {
        let block = passed.block();
        if block.number == Some(164) {
            units = header::read_units(block.records, &mut Vec::new()).map(Some).map_err(|_| ());
        }
        let mut part = part(&block, &units, options);
        (part.function, part.shape) = (None, None);
        passed.place(&mut part.info, &mut part.error);
        collector.add(part);
    }
    collector.document.warnings.append(&mut stream.warnings);
    collector.finish(matches!(units, Ok(Some(Units { .. }))))
}

/// A dataset with its data left out.
struct Passed {
    number: Option<u32>,
    /// Line and byte of the opening marker.
    line: u64,
    byte: u64,
    /// Where lines are counted from; 0 is the beginning of the file.
    counted_from: u64,
    /// The records that were kept, and the line of the first.
    records: Vec<u8>,
    first_record: u64,
    /// Values of a 58 that are there.
    values: Option<u64>,
    /// Longer than [`LARGEST_DATASET`].
    too_large: bool,
    fault: Option<Error>,
    closed: bool,
    warnings: Vec<String>,
}

impl Passed {
    fn block(&self) -> Block<'_> {
        Block {
            // without its number, nothing is read of it
            number: self.number,
            line: self.line,
            records: Lines { bytes: &self.records, line: self.first_record },
            payload: None,
            passed_over: self.values,
            listed_only: self.too_large,
            fault: self.fault.clone(),
            closed: self.closed,
            warnings: self.warnings.clone(),
        }
    }

    /// Says where the dataset stands when its lines are not those of the file.
    fn place(&self, info: &mut DatasetInfo, error: &mut Option<Error>) {
        if self.counted_from == 0 {
            return;
        }
        info.line = None;
        if !info.warnings.is_empty() {
            info.warnings
                .insert(0, format!("this dataset begins at byte {}; lines are counted from byte {}", self.byte, self.counted_from));
        }
        if let Some(error) = error {
            error.byte.get_or_insert(self.byte);
        }
    }
}

/// A file read line by line.
struct Stream {
    input: BufReader<File>,
    length: u64,
    /// Offset behind the last line.
    at: u64,
    /// Offset of the last line.
    line_at: u64,
    /// Number of the last line, counted from `counted_from`.
    line: u64,
    counted_from: u64,
    /// The last line, without its end and cut at [`LONGEST_LINE`].
    text: Vec<u8>,
    /// The last line is a closing marker.
    after_closing: bool,
    /// The last line is the number line of a dataset.
    at_number: bool,
    warnings: Vec<String>,
}

impl Stream {
    fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let input = BufReader::with_capacity(1 << 16, file);
        let text = Vec::with_capacity(LONGEST_LINE);
        let warnings = Vec::new();
        let mut stream =
            Self { input, length, at: 0, line_at: 0, line: 0, counted_from: 0, text, after_closing: false, at_number: false, warnings };
        if stream.input.fill_buf()?.starts_with(b"\xef\xbb\xbf") {
            stream.input.consume(3);
            stream.at = 3;
        }
        Ok(stream)
    }

    /// Reads the next line; false at the end of the file.
    fn next_line(&mut self) -> io::Result<bool> {
        (self.line_at, self.after_closing, self.at_number) = (self.at, false, false);
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

    fn is_blank(&self) -> bool {
        self.text.trim_ascii().is_empty()
    }

    /// The next dataset, its data passed over; `None` at the end of the file.
    fn next_dataset(&mut self, lenient: bool) -> io::Result<Option<Passed>> {
        let Some((line, byte)) = self.opening()? else { return Ok(None) };
        let number_record = self.text.clone();
        let (number, is_binary) = number_line(&number_record).unzip();
        let mut passed = Passed {
            number,
            line,
            byte,
            counted_from: self.counted_from,
            records: Vec::new(),
            first_record: self.line + 1,
            values: None,
            too_large: false,
            fault: None,
            closed: true,
            warnings: Vec::new(),
        };
        let record = Record { line: self.line, text: &number_record };
        match (number, is_binary) {
            (_, Some(true)) => self.binary_function(record, &mut passed, lenient)?,
            (Some(58), _) => self.text_function(&mut passed, lenient)?,
            _ => {
                passed.fault = number.is_none().then(|| no_number(record));
                self.other(&mut passed)?;
            }
        }
        Ok(Some(passed))
    }

    /// Goes on to a number line; gives line and byte of the marker before it.
    fn opening(&mut self) -> io::Result<Option<(u64, u64)>> {
        if self.at_number {
            return Ok(Some((self.line - 1, self.line_at)));
        }
        let mut outside: Option<u64> = None;
        let (mut marker, mut closing) = (None, self.after_closing.then_some(self.line_at));
        while self.next_line()? {
            let first_behind = closing.take();
            if is_marker(&self.text) {
                self.note_outside(&mut outside);
                marker = Some((self.line, self.line_at));
            } else if !self.is_blank() {
                if marker.is_some() {
                    return Ok(marker);
                }
                if let Some(byte) = first_behind.filter(|_| number_line(&self.text).is_some()) {
                    self.warnings.push(format!("line {}: the dataset before this line has no closing -1", self.line - 1));
                    return Ok(Some((self.line - 1, byte)));
                }
                outside.get_or_insert(self.line);
            }
        }
        self.line += 1;
        self.note_outside(&mut outside);
        Ok(None)
    }

    fn note_outside(&mut self, first: &mut Option<u64>) {
        if let Some(first) = first.take() {
            self.warnings.push(format!("lines {first} to {}: text outside of any dataset is not read", self.line - 1));
        }
    }

    /// Reads one more record of a dataset; false where it ends, with its marker or with the file.
    fn next_record(&mut self, passed: &mut Passed) -> io::Result<bool> {
        passed.closed = self.next_line()?;
        self.after_closing = passed.closed && is_marker(&self.text);
        Ok(passed.closed && !self.after_closing)
    }

    fn keep(&self, passed: &mut Passed) {
        passed.records.extend_from_slice(&self.text);
        passed.records.push(b'\n');
    }

    fn other(&mut self, passed: &mut Passed) -> io::Result<()> {
        while self.next_record(passed)? {
            passed.too_large |= passed.records.len() > LARGEST_DATASET;
            if !passed.too_large {
                self.keep(passed);
            }
        }
        if passed.too_large {
            passed.records = Vec::new();
            passed.warnings.push(format!("longer than {} MiB: listed, not looked into", LARGEST_DATASET >> 20));
        }
        Ok(())
    }

    fn text_function(&mut self, passed: &mut Passed, lenient: bool) -> io::Result<()> {
        let mut layout: Option<Layout> = None;
        let mut count = 0;
        while count < HEADER_RECORDS && self.next_record(passed)? {
            count += 1;
            self.keep(passed);
            if count == 7 {
                layout = self.record_7().ok().map(|record| record.layout);
            }
        }
        if count < HEADER_RECORDS {
            return Ok(());
        }
        let first_line = self.line + 1;
        let (mut lines, mut blank, mut tokens, mut is_cut) = (0, 0, 0, false);
        let mut last = Vec::with_capacity(LONGEST_LINE);
        while self.next_record(passed)? {
            blank += 1;
            if !self.is_blank() {
                lines += std::mem::take(&mut blank);
                tokens += count_tokens(&self.text);
                is_cut |= self.text.len() == LONGEST_LINE;
                std::mem::swap(&mut last, &mut self.text);
            }
        }
        let Some(layout) = layout else { return Ok(()) };
        let (widths, per_point) = (layout.widths(), layout.numbers_per_point() as u64);
        let present = if lines > 0 { (lines - 1) * widths.len() as u64 + count_fields(&last, widths) as u64 } else { 0 };
        let declared = layout.count.saturating_mul(per_point);
        if is_cut {
            passed.warnings.push(format!("lines of {LONGEST_LINE} bytes or more: the number of values was not checked"));
        }
        if present == declared || tokens == declared || is_cut {
            passed.values = Some(layout.count);
        } else if lenient {
            passed.values = Some(present.min(declared) / per_point);
            passed.warnings.push(format!("the header declares {} values, the data hold {}", layout.count, present / per_point));
        } else {
            passed.fault = Some(counts_disagree(first_line, layout.count, present / per_point));
        }
        Ok(())
    }

    fn record_7(&self) -> Result<Record7> {
        Record7::read(Record { line: self.line, text: &self.text }, &mut Vec::new())
    }

    fn binary_function(&mut self, number: Record<'_>, passed: &mut Passed, lenient: bool) -> io::Result<()> {
        let identifier = match binary::Identifier::read(number, &mut passed.warnings) {
            Ok(identifier) => identifier,
            Err(error) => {
                passed.fault = Some(error);
                return self.go_on_behind_damage();
            }
        };
        let mut record7 = Vec::new();
        for k in 1..=identifier.header_lines {
            if !self.next_record(passed)? {
                passed.fault = Some(ends_in_header(self.line, k - 1, identifier.header_lines));
                return Ok(());
            }
            if k == 7 {
                record7 = self.text.clone();
            }
            if k <= HEADER_RECORDS {
                self.keep(passed);
            }
        }
        let record7 = Record { line: number.line + 7, text: &record7 };
        let rest = FileRest { file: self.input.get_ref(), from: self.at, length: self.length - self.at.min(self.length) };
        let landed = binary::locate(&rest, self.at, identifier, record7, lenient, &mut passed.warnings);
        match landed {
            Ok(landed) => {
                passed.values = Some(landed.length / landed.form.point_bytes() as u64);
                self.at += landed.end;
                self.input.seek(SeekFrom::Start(self.at))?;
                (self.line_at, self.counted_from, self.line, self.after_closing) = (self.at, self.at, 0, true);
                Ok(())
            }
            Err(error) => {
                passed.fault = Some(error);
                self.input.seek(SeekFrom::Start(self.at))?;
                self.go_on_behind_damage()
            }
        }
    }

    /// Goes on to the next marker with a dataset number behind it. Only used where no length fits, to list what follows.
    fn go_on_behind_damage(&mut self) -> io::Result<()> {
        let mut after_marker = false;
        while self.next_line()? {
            if after_marker && number_line(&self.text).is_some() {
                self.at_number = true;
                return Ok(());
            }
            after_marker = is_marker(&self.text);
        }
        Ok(())
    }
}

/// The rest of a file from one place on, of which a few bytes are looked at.
struct FileRest<'a> {
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
        // what cannot be read is no marker: the dataset is then listed as damaged
        let read = read.and_then(|_| file.take(LONGEST_LINE as u64).read_to_end(&mut bytes));
        if read.is_err() {
            bytes.clear();
        }
        Cow::Owned(bytes)
    }
}
