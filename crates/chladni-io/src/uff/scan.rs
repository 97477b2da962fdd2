//! Universal files that do not fit into memory: headers are read, data are passed over.
//!
//! The payload of a 58b is skipped; `binary` computes its end. The lines of a text 58 are only
//! counted. Other datasets are read as usual; a large one is listed by its name.

use super::binary;
use super::container::{ends_in_header, is_number_line, no_number, number_line, outside};
use super::fields::{count_fields, count_tokens, Record};
use super::header::{self, Units};
use super::identifier::Identifier;
use super::layout::{Layout, Record7};
use super::lines::{is_marker, HEADER_RECORDS};
use super::passed::Passed;
use super::stream::{FileLines, LONGEST_LINE};
use super::values::counts_disagree;
use super::{part, Collector, UnitsInForce};
use crate::{Document, ReadOptions};
use chladni_frf::{Error, Finding, Result};
use chladni_text::door::place_of;
use std::io;
use std::path::Path;

/// Largest dataset other than 58 that is read, bytes; a longer one is listed by its name.
const LARGEST_DATASET: usize = 16 << 20;

/// Lists a universal file without its values: `functions` and `shapes` of the document
/// stay empty, and so does `sha256`.
///
/// Lines after the first binary dataset are counted from its end; the warnings of the datasets
/// say so.
///
/// # Errors
/// Those of reading, and as [`super::read`].
pub fn scan(path: &Path, options: &ReadOptions) -> Result<Document> {
    // the first units also hold for datasets before them: then the file is passed over again
    match listed(path, options, Ok(None))? {
        (document, None) => Ok(document),
        (_, Some(first)) => Ok(listed(path, options, first)?.0),
    }
}

/// The list, read with the units that hold at the beginning; and the first units of the file
/// where other datasets come before them.
fn listed(
    path: &Path,
    options: &ReadOptions,
    start: UnitsInForce,
) -> Result<(Document, Option<UnitsInForce>)> {
    let on_read = |error: io::Error| Error::from_read(&error, path);
    let place = place_of(path)?;
    let mut datasets = Datasets::open(&place).map_err(on_read)?;
    let mut collector = Collector::new(path);
    let (mut units, mut first, mut late) = (start, true, None);
    while let Some(passed) = datasets.next_dataset(options.lenient).map_err(on_read)? {
        let block = passed.block();
        if block.number == Some(164) {
            units = header::read_units(block.records, &mut Vec::new())
                .map(Some)
                .map_err(|_| ());
            let others_before = collector
                .document
                .datasets
                .iter()
                .any(|info| info.number != Some(151));
            late = late.or((first && others_before).then_some(units));
            first = false;
        }
        let mut part = part(&block, &units, options);
        (part.function, part.shape) = (None, None);
        passed.place(&mut part.info, &mut part.error);
        collector.add(part);
    }
    collector.document.warnings.append(&mut datasets.warnings);
    Ok((
        collector.finish(matches!(units, Ok(Some(Units { .. }))))?,
        late,
    ))
}

/// The datasets of a file, one after the other.
pub(super) struct Datasets {
    lines: FileLines,
    /// True where the last line is a closing marker.
    after_closing: bool,
    /// True where the last line is the number line of a dataset.
    at_number: bool,
    warnings: Vec<Finding>,
}

impl Datasets {
    /// The datasets of the file at `path`.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        Ok(Self {
            lines: FileLines::open(path)?,
            after_closing: false,
            at_number: false,
            warnings: Vec::new(),
        })
    }

    fn next_line(&mut self) -> io::Result<bool> {
        (self.after_closing, self.at_number) = (false, false);
        self.lines.next_line()
    }

    /// The next dataset, its data passed over; `None` at the end of the file.
    pub(super) fn next_dataset(&mut self, lenient: bool) -> io::Result<Option<Passed>> {
        let Some((line, byte)) = self.opening()? else {
            return Ok(None);
        };
        let number_record = self.lines.text.clone();
        let number_line = number_line(&number_record);
        let mut passed = Passed {
            number: number_line.map(|line| line.number),
            line,
            byte,
            counted_from: self.lines.counted_from,
            records: Vec::new(),
            first_record: self.lines.line + 1,
            values: None,
            too_large: false,
            fault: None,
            closed: true,
            warnings: Vec::new(),
        };
        let record = Record {
            line: self.lines.line,
            text: &number_record,
        };
        match number_line {
            Some(line) if line.is_binary => self.binary_function(record, &mut passed, lenient)?,
            Some(line) if line.number == 58 => self.text_function(&mut passed, lenient)?,
            _ => {
                passed.fault = number_line.is_none().then(|| no_number(record));
                self.other(&mut passed)?;
            }
        }
        Ok(Some(passed))
    }

    /// Goes on to a number line. Returns line and byte of the marker before it.
    fn opening(&mut self) -> io::Result<Option<(u64, u64)>> {
        if self.at_number {
            return Ok(Some((self.lines.line - 1, self.lines.line_at)));
        }
        let mut beyond: Option<(u64, Option<u64>)> = None;
        let (mut marker, mut closing) = (None, self.after_closing.then_some(self.lines.line_at));
        while self.next_line()? {
            let first_behind = closing.take();
            if is_marker(&self.lines.text) {
                self.note_outside(&mut beyond);
                marker = Some((self.lines.line, self.lines.line_at));
            } else if !self.lines.is_blank() {
                if marker.is_some() {
                    return Ok(marker);
                }
                if let Some(byte) = first_behind.filter(|_| number_line(&self.lines.text).is_some())
                {
                    self.warnings.push(Finding::note(
                        "loosely-written",
                        format!(
                            "line {}: the dataset before this line has no closing -1",
                            self.lines.line - 1
                        ),
                    ));
                    return Ok(Some((self.lines.line - 1, byte)));
                }
                let line = self.lines.line;
                let number = is_number_line(&self.lines.text).then_some(line);
                let (_, found) = beyond.get_or_insert((line, number));
                *found = found.or(number);
            }
        }
        self.lines.line += 1;
        self.note_outside(&mut beyond);
        Ok(None)
    }

    fn note_outside(&mut self, found: &mut Option<(u64, Option<u64>)>) {
        if let Some((first, number)) = found.take() {
            self.warnings
                .push(outside(first, self.lines.line - 1, number));
        }
    }

    /// Reads the next record of a dataset; returns false at its closing marker or the end of the
    /// file.
    fn next_record(&mut self, passed: &mut Passed) -> io::Result<bool> {
        passed.closed = self.next_line()?;
        self.after_closing = passed.closed && is_marker(&self.lines.text);
        Ok(passed.closed && !self.after_closing)
    }

    fn keep(&self, passed: &mut Passed) {
        passed.records.extend_from_slice(&self.lines.text);
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
            passed.warnings.push(Finding::note(
                "headers-only",
                format!(
                    "longer than {} MiB: listed, not looked into",
                    LARGEST_DATASET >> 20
                ),
            ));
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
        let first_line = self.lines.line + 1;
        let (mut lines, mut blank, mut tokens, mut is_cut) = (0, 0, 0, false);
        let mut last = Vec::with_capacity(LONGEST_LINE);
        while self.next_record(passed)? {
            blank += 1;
            if !self.lines.is_blank() {
                lines += std::mem::take(&mut blank);
                tokens += count_tokens(&self.lines.text);
                is_cut |= self.lines.text.len() == LONGEST_LINE;
                std::mem::swap(&mut last, &mut self.lines.text);
            }
        }
        let Some(layout) = layout else { return Ok(()) };
        let (widths, per_point) = (layout.widths(), layout.numbers_per_point() as u64);
        let present = if lines > 0 {
            (lines - 1) * widths.len() as u64 + count_fields(&last, widths) as u64
        } else {
            0
        };
        let declared = layout.count.saturating_mul(per_point);
        if is_cut {
            passed.warnings.push(Finding::note(
                "headers-only",
                format!(
                    "lines of {LONGEST_LINE} bytes or more: the number of values was not checked"
                ),
            ));
        }
        let (count, found) = (layout.count, present / per_point);
        if present == declared || tokens == declared || is_cut {
            passed.values = Some(count);
        } else if lenient {
            passed.values = Some(present.min(declared) / per_point);
            let words = format!("the header declares {count} values, the data hold {found}");
            passed
                .warnings
                .push(Finding::caution("values-missing", words));
        } else {
            passed.fault = Some(counts_disagree(first_line, count, found));
        }
        Ok(())
    }

    fn record_7(&self) -> Result<Record7> {
        Record7::read(self.lines.record(), &mut Vec::new())
    }

    fn binary_function(
        &mut self,
        number: Record<'_>,
        passed: &mut Passed,
        lenient: bool,
    ) -> io::Result<()> {
        let identifier = match Identifier::read(number, &mut passed.warnings) {
            Ok(identifier) => identifier,
            Err(error) => {
                passed.fault = Some(error);
                return self.go_on_behind_damage();
            }
        };
        let mut record7 = Vec::new();
        for k in 1..=identifier.header_lines {
            if !self.next_record(passed)? {
                passed.fault = Some(ends_in_header(
                    self.lines.line,
                    k - 1,
                    identifier.header_lines,
                ));
                return Ok(());
            }
            if k == 7 {
                record7 = self.lines.text.clone();
            }
            if k <= HEADER_RECORDS {
                self.keep(passed);
            }
        }
        let record7 = Record {
            line: number.line + 7,
            text: &record7,
        };
        let (rest, at) = self.lines.rest();
        match binary::locate(
            &rest,
            at,
            identifier,
            record7,
            lenient,
            &mut passed.warnings,
        ) {
            Ok(landed) => {
                passed.values = Some(landed.length / landed.form.point_bytes() as u64);
                self.after_closing = true;
                self.lines.skip_bytes(landed.end)
            }
            Err(error) => {
                passed.fault = Some(error);
                self.lines.return_behind_last_line()?;
                self.go_on_behind_damage()
            }
        }
    }

    /// Goes on to the next marker before a dataset number. Only used where no length fits, to
    /// list the datasets that follow.
    fn go_on_behind_damage(&mut self) -> io::Result<()> {
        let mut after_marker = false;
        while self.next_line()? {
            if after_marker && number_line(&self.lines.text).is_some() {
                self.at_number = true;
                return Ok(());
            }
            after_marker = is_marker(&self.lines.text);
        }
        Ok(())
    }
}
