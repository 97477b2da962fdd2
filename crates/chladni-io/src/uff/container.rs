//! The container: beginnings and ends of the datasets of a universal file.
//!
//! A dataset is a line with `-1` in columns 5 and 6, a line with its number in columns 1
//! to 6, its records, and a closing `-1` line. The closing line of a binary 58 (number line
//! `58b`) follows its payload, whose end is computed: a search for `-1` could end inside the
//! payload.

use super::binary::{self, Payload};
use super::fields::Record;
use super::identifier::Identifier;
use super::lines::{is_marker, Lines, HEADER_RECORDS};
use chladni_frf::{Error, Finding, Result};

/// One dataset, cut out of the file.
#[derive(Debug)]
pub(super) struct Block<'a> {
    /// `None` where the number line holds no number.
    pub number: Option<u32>,
    /// Line of the opening `-1`.
    pub line: u64,
    /// Records after the number line: all of them in a text dataset, the header in a
    /// binary one.
    pub records: Lines<'a>,
    /// Data of a binary 58.
    pub payload: Option<Payload<'a>>,
    /// Number of values of a 58 whose data were passed over.
    pub passed_over: Option<u64>,
    /// True where it is too large to be read, and listed by its name alone.
    pub listed_only: bool,
    /// The error that makes the dataset unreadable as a whole.
    pub fault: Option<Error>,
    /// False where the file ends before the closing `-1`.
    pub closed: bool,
    pub warnings: Vec<Finding>,
}

/// The number line of a dataset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberLine {
    pub number: u32,
    /// True for `58b`.
    pub is_binary: bool,
}

/// Reads a number line; `None` for any other line.
pub(super) fn number_line(text: &[u8]) -> Option<NumberLine> {
    let text = text.trim_ascii_start();
    let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
    let number = std::str::from_utf8(&text[..digits])
        .ok()?
        .parse()
        .ok()
        .filter(|_| digits <= 6)?;
    let is_binary = match text.get(digits) {
        None => false,
        Some(b) if b.is_ascii_whitespace() => false,
        Some(b'b' | b'B') if number == 58 => true,
        Some(_) => return None,
    };
    Some(NumberLine { number, is_binary })
}

/// True for a line that holds the number of a dataset and nothing else.
pub(super) fn is_number_line(text: &[u8]) -> bool {
    let alone = text.trim_ascii().iter().all(u8::is_ascii_digit);
    number_line(text).is_some_and(|line| line.is_binary || alone)
}

/// All datasets of a file in their order; text outside of datasets is reported in
/// `warnings`.
pub(super) fn datasets<'a>(
    bytes: &'a [u8],
    lenient: bool,
    warnings: &mut Vec<Finding>,
) -> Vec<Block<'a>> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let whole_file = Lines { bytes, line: 1 };
    let mut at = Lines {
        bytes: text,
        line: 1,
    };
    let mut blocks: Vec<Block<'a>> = Vec::new();
    let mut closing_line = 0;
    loop {
        let before = at;
        let Some(record) = at.next() else {
            return blocks;
        };
        if record.text.trim_ascii().is_empty() {
            continue;
        }
        if is_marker(record.text) {
            let (block, after) = dataset(whole_file, at, record.line, lenient);
            closing_line = after.line.saturating_sub(1);
            blocks.extend(block);
            at = after;
        } else if record.line == closing_line + 1
            && number_line(record.text).is_some()
            && !blocks.is_empty()
        {
            // the marker that ended the last dataset opens this one: the last was not closed
            warnings.push(Finding::note(
                "loosely-written",
                format!("line {closing_line}: the dataset before this line has no closing -1"),
            ));
            let (block, after) = dataset(whole_file, before, closing_line, lenient);
            closing_line = after.line.saturating_sub(1);
            blocks.extend(block);
            at = after;
        } else {
            let first = record.line;
            let mut number = is_number_line(record.text).then_some(first);
            let mut next = at;
            while let Some(record) = next.next().filter(|record| !is_marker(record.text)) {
                number = number.or(is_number_line(record.text).then_some(record.line));
                at = next;
            }
            warnings.push(outside(first, at.line - 1, number));
        }
    }
}

/// The finding about the lines `first` to `last` outside of any dataset; `number` is the one
/// of them that looks like a number line.
pub(super) fn outside(first: u64, last: u64, number: Option<u64>) -> Finding {
    let words = format!("lines {first} to {last}: text outside of any dataset is not read");
    match number {
        Some(line) => Finding::caution(
            "not-read",
            format!("{words}; line {line} has the number of a dataset, but no -1 stands above it"),
        )
        .help("write -1 into columns 5 and 6 of the line above it"),
        None => Finding::note("not-read", words),
    }
}

/// The dataset whose opening marker ends at `at`, and the position after it; no dataset at
/// the end of the file.
fn dataset<'a>(
    file: Lines<'a>,
    mut at: Lines<'a>,
    line: u64,
    lenient: bool,
) -> (Option<Block<'a>>, Lines<'a>) {
    let mut line = line;
    let number_record = loop {
        match at.next() {
            None => return (None, at),
            // of two markers the second one opens the dataset
            Some(record) if is_marker(record.text) => line = record.line,
            Some(record) if record.text.trim_ascii().is_empty() => {}
            Some(record) => break record,
        }
    };
    let number_line = number_line(number_record.text);
    let nothing = Lines {
        bytes: &[],
        line: at.line,
    };
    let mut block = Block {
        number: number_line.map(|line| line.number),
        line,
        records: nothing,
        payload: None,
        passed_over: None,
        listed_only: false,
        fault: number_line.is_none().then(|| no_number(number_record)),
        closed: true,
        warnings: Vec::new(),
    };
    let after = if number_line.is_some_and(|line| line.is_binary) {
        binary_body(file, at, number_record, &mut block, lenient)
    } else {
        text_body(at, &mut block)
    };
    (Some(block), after)
}

/// The error of a dataset without number.
pub(super) fn no_number(record: Record<'_>) -> Error {
    Error::bad_data("no dataset number after the opening -1")
        .at_line(record.line)
        .field("dataset number")
        .found(String::from_utf8_lossy(record.text))
        .expected("a number in columns 1 to 6")
}

/// The error of a header of `records` records in place of `expected`.
pub(super) fn ends_in_header(line: u64, records: usize, expected: usize) -> Error {
    Error::bad_data("the dataset ends inside its header")
        .at_line(line)
        .field(format!("record {}", records + 1))
        .found(format!("{records} records"))
        .expected(format!("{expected} records before the data"))
        .help("the file is cut short; copy or export it again")
}

fn text_body<'a>(start: Lines<'a>, block: &mut Block<'a>) -> Lines<'a> {
    let mut at = start;
    loop {
        let before = at;
        match at.next() {
            Some(record) if is_marker(record.text) => {
                block.records = start.until(before);
                return at;
            }
            Some(_) => {}
            None => {
                block.records = start;
                block.closed = false;
                return at;
            }
        }
    }
}

fn binary_body<'a>(
    file: Lines<'a>,
    start: Lines<'a>,
    number: Record<'a>,
    block: &mut Block<'a>,
    lenient: bool,
) -> Lines<'a> {
    let mut at = start;
    match payload(file.bytes.len(), &mut at, number, block, lenient) {
        Ok((payload, length)) => {
            block.payload = Some(payload);
            at.skip_bytes(length as usize)
        }
        Err(error) => {
            block.fault = Some(error);
            let header_ends_early = { at }.next().is_some_and(|record| is_marker(record.text));
            if header_ends_early {
                at.next();
                return at;
            }
            next_opening(at)
        }
    }
}

/// Reads past the header at `at` and finds the payload. Returns with it the bytes from `at`
/// to one past its closing marker.
fn payload<'a>(
    file_bytes: usize,
    at: &mut Lines<'a>,
    number: Record<'a>,
    block: &mut Block<'a>,
    lenient: bool,
) -> Result<(Payload<'a>, u64)> {
    let start = *at;
    let identifier = Identifier::read(number, &mut block.warnings)?;
    let mut record7 = None;
    for k in 1..=identifier.header_lines {
        let before = *at;
        let record = at
            .next()
            .filter(|record| !is_marker(record.text))
            .ok_or_else(|| {
                *at = before;
                ends_in_header(before.line, k - 1, identifier.header_lines)
            })?;
        if k == 7 {
            record7 = Some(record);
        }
        if k == HEADER_RECORDS {
            block.records = start.until(*at);
        }
    }
    let byte = (file_bytes - at.bytes.len()) as u64;
    let landed = binary::locate(
        &at.bytes,
        byte,
        identifier,
        record7.unwrap_or(number),
        lenient,
        &mut block.warnings,
    )?;
    let payload = Payload {
        bytes: &at.bytes[..landed.length as usize],
        byte,
        form: landed.form,
        big_endian: identifier.big_endian,
    };
    Ok((payload, landed.end))
}

/// The place where reading can go on behind a damaged binary dataset: the next closing
/// marker with an opening marker and a dataset number after it. Only used when no length
/// fits, to list what follows; no data are read by it.
fn next_opening(at: Lines<'_>) -> Lines<'_> {
    let mut skipped = 0;
    while let Some(found) = at.bytes[skipped..]
        .windows(2)
        .position(|pair| pair == b"-1")
    {
        let marker = skipped + found;
        let mut ahead = Lines {
            bytes: &at.bytes[marker..],
            line: 0,
        };
        let closing = ahead.next();
        let after_closing = ahead;
        let opens = closing.is_some_and(|record| is_marker(record.text))
            && ahead.next().is_some_and(|record| is_marker(record.text))
            && ahead
                .next()
                .is_some_and(|record| number_line(record.text).is_some());
        if opens {
            return at.skip_bytes(at.bytes.len() - after_closing.bytes.len());
        }
        skipped = marker + 1;
    }
    at.skip_bytes(at.bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number, line and whether it is closed.
    type Listed = (Option<u32>, u64, bool);

    fn numbers(text: &str) -> (Vec<Listed>, Vec<Finding>) {
        let mut warnings = Vec::new();
        let blocks = datasets(text.as_bytes(), false, &mut warnings);
        (
            blocks
                .iter()
                .map(|block| (block.number, block.line, block.closed))
                .collect(),
            warnings,
        )
    }

    #[test]
    fn markers_may_be_padded_or_not_and_line_ends_may_mix() {
        let text = "    -1\r\n   151\r\nNONE\r\n    -1    \n    -1\n   164                     \
                    \r\n         1\n    -1";
        assert_eq!(
            numbers(text),
            (vec![(Some(151), 1, true), (Some(164), 5, true)], vec![])
        );
    }

    #[test]
    fn minus_one_in_a_wide_column_is_no_marker() {
        let text = "    -1\n   999\n        -1\n    -1\n";
        assert_eq!(numbers(text).0, [(Some(999), 1, true)]);
    }

    #[test]
    fn a_missing_closing_marker_costs_a_warning_and_no_dataset() {
        let (found, warnings) = numbers(
            "    -1\n   151\nNONE\n    -1\n   164\n         1\n    -1\n    -1\n    15\n    -1\n",
        );
        assert_eq!(
            found,
            [
                (Some(151), 1, true),
                (Some(164), 4, true),
                (Some(15), 8, true)
            ]
        );
        assert!(warnings[0].contains("no closing -1"), "{warnings:?}");
    }

    #[test]
    fn text_outside_of_datasets_is_reported() {
        let (found, warnings) = numbers("hello\nworld\n    -1\n   151\n    -1\n");
        assert_eq!(found, [(Some(151), 3, true)]);
        assert_eq!(
            warnings[0].text,
            "lines 1 to 2: text outside of any dataset is not read"
        );
    }

    #[test]
    fn a_file_that_ends_inside_a_dataset_is_noticed() {
        assert_eq!(numbers("    -1\n   151\nNONE\n").0, [(Some(151), 1, false)]);
        assert_eq!(numbers("    -1\n").0, []);
    }

    #[test]
    fn a_line_that_is_no_dataset_number_is_a_fault() {
        let blocks = datasets(b"    -1\n   abc\n    -1\n", false, &mut Vec::new());
        assert!(blocks[0]
            .fault
            .as_ref()
            .unwrap()
            .to_string()
            .contains("found    abc"));
    }
}
