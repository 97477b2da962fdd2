//! The data of dataset 58: numbers of a text dataset, floats of a binary one.
//!
//! The count of record 7 is compared with the data in the file before memory is allocated;
//! the error names both numbers. A masked line is NaN in all parts.

use super::binary::Payload;
use super::fields::{
    bad_field, count_fields, count_tokens, line_numbers, masked_numbers, warn_split, BadField,
    FieldLayout, Record,
};
use super::layout::Layout;
use super::lines::Lines;
use super::number::{self, Fault};
use crate::Ordinate;
use chladni_frf::{counted, Error, Finding, Result};
use num_complex::{Complex32, Complex64};

/// Abscissa values (none for an even axis) and ordinate values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Values {
    pub x: Vec<f64>,
    pub ordinate: Ordinate,
}

/// Reads the data lines of a text 58.
///
/// # Errors
/// A field that is no finite number (unless `lenient`, which masks it), or another number
/// of values than declared.
pub(super) fn read_text(
    data: Lines<'_>,
    layout: Layout,
    lenient: bool,
    warnings: &mut Vec<Finding>,
) -> Result<Values> {
    let data = Lines {
        bytes: data.bytes.trim_ascii_end(),
        ..data
    };
    if let Some(numbers) = usual_form(data.bytes, layout) {
        return Ok(split(numbers, layout));
    }
    let widths = layout.widths();
    let per_point = layout.numbers_per_point() as u64;
    let present_lines = data.count() as u64;
    let present = match data.last() {
        Some(last) => {
            (present_lines - 1) * widths.len() as u64 + count_fields(last.text, widths) as u64
        }
        None => 0,
    };
    let declared = layout.count.saturating_mul(per_point);
    let mut reader = TextReader {
        layout,
        lenient,
        numbers: Vec::new(),
        masked: None,
    };
    if present == declared {
        reader.lines(data, declared, warnings)?;
    } else if count_tokens(data.bytes) == declared {
        reader.free_format(data, warnings)?;
    } else if lenient {
        let read = present.min(declared) / per_point;
        warnings.push(Finding::caution(
            "values-missing",
            format!(
                "the header declares {} values, the data hold {}; {read} are read",
                layout.count,
                present / per_point
            ),
        ));
        reader.lines(data, read * per_point, warnings)?;
    } else {
        return Err(counts_disagree(
            data.line,
            layout.count,
            present / per_point,
        ));
    }
    if let Some((count, first)) = reader.masked {
        warnings.push(Finding::caution(
            "lines-masked",
            format!(
                "masked, since no finite number: {} (first in line {first})",
                counted(count, "value")
            ),
        ));
    }
    Ok(split(reader.numbers, layout))
}

/// Columns of the narrowest data field.
const LEAST_WIDTH: usize = 13;

/// The error of data from `line` on whose number of values is not that of record 7.
pub(super) fn counts_disagree(line: u64, declared: u64, present: u64) -> Error {
    Error::bad_data("the declared number of values and the data disagree")
        .at_line(line)
        .field("record 7: number of values")
        .found(format!("{declared} declared, {present} present"))
        .expected("equal numbers")
        .help(
            "the file is cut short or its header is wrong: export it again, or read what is \
               there with `lenient`",
        )
}

/// The numbers of data that lie wholly in the columns of the layout, as many as declared, in
/// one pass without cutting lines. `None` leaves all other data to [`TextReader`].
fn usual_form(bytes: &[u8], layout: Layout) -> Option<Vec<f64>> {
    let widths = layout.widths();
    let declared = layout
        .count
        .checked_mul(layout.numbers_per_point() as u64)?;
    // the file itself bounds the allocation
    let declared = usize::try_from(declared)
        .ok()
        .filter(|&declared| declared <= bytes.len() / LEAST_WIDTH)?;
    let mut numbers = Vec::with_capacity(declared);
    let mut rest = bytes;
    while numbers.len() < declared {
        for &width in &widths[..widths.len().min(declared - numbers.len())] {
            let (field, behind) = rest.split_at_checked(width)?;
            let value = number::usual_float(field)?;
            if !layout.double && value.abs() > f64::from(f32::MAX) {
                return None;
            }
            numbers.push(value);
            rest = behind;
        }
        while let [b' ', behind @ ..] = rest {
            rest = behind;
        }
        rest = match rest {
            [b'\n', behind @ ..] | [b'\r', b'\n', behind @ ..] => behind,
            [] => rest,
            _ => return None,
        };
    }
    rest.is_empty().then_some(numbers)
}

struct TextReader {
    layout: Layout,
    lenient: bool,
    numbers: Vec<f64>,
    /// Number of fields that were masked, and the line of the first.
    masked: Option<(usize, u64)>,
}

impl TextReader {
    /// Reads the first `wanted` numbers, in the columns of the layout.
    fn lines(&mut self, data: Lines<'_>, wanted: u64, warnings: &mut Vec<Finding>) -> Result<()> {
        let widths = self.layout.widths();
        // a number takes at least one byte: the file itself bounds the allocation
        self.numbers
            .reserve_exact((data.bytes.len() as u64).min(wanted) as usize);
        let mut line = [0.0; 6];
        for record in data {
            let missing = wanted - self.numbers.len() as u64;
            let expected = missing.min(widths.len() as u64) as usize;
            if expected == 0 {
                break;
            }
            let text = match widths[expected..].is_empty() || !self.lenient {
                true => record.text,
                false => &record.text[..record.text.len().min(widths[..expected].iter().sum())],
            };
            let values = &mut line[..expected];
            let found = line_numbers(text, &widths[..expected], values);
            let complete = match found {
                Ok(FieldLayout::Columns(filled) | FieldLayout::Blanks(filled))
                    if filled < expected =>
                {
                    Err(self.short(record, filled, expected))
                }
                Ok(FieldLayout::Blanks(_)) => {
                    warn_split(record.line, warnings);
                    Ok(())
                }
                Ok(FieldLayout::Columns(_)) => Ok(()),
                Err(bad) => Err(bad_field(record, &self.name(bad.index), bad)),
            };
            if let Err(error) = complete.and_then(|()| self.in_range(record, values)) {
                self.mask(record, text, &widths[..expected], values, error)?;
            }
            self.numbers.extend_from_slice(values);
        }
        Ok(())
    }

    /// Reads all numbers between blanks, for lines of another length than in the layout.
    fn free_format(&mut self, data: Lines<'_>, warnings: &mut Vec<Finding>) -> Result<()> {
        warn_split(data.line, warnings);
        for record in data {
            for token in record
                .text
                .split(u8::is_ascii_whitespace)
                .filter(|token| !token.is_empty())
            {
                let start = token.as_ptr() as usize - record.text.as_ptr() as usize;
                let value = number::float(token).map_err(|fault| BadField {
                    index: 0,
                    span: (start, start + token.len()),
                    fault,
                });
                let value = value
                    .map_err(|bad| bad_field(record, &self.name(0), bad))
                    .and_then(|value| {
                        self.in_range(record, &[value])?;
                        Ok(value)
                    });
                match value {
                    Ok(value) => self.numbers.push(value),
                    Err(error) => {
                        let mut masked = [f64::NAN];
                        self.mask(record, b"", &[1], &mut masked, error)?;
                        self.numbers.push(f64::NAN);
                    }
                }
            }
        }
        Ok(())
    }

    /// Masks the fields of a line that cannot be read; an error unless `lenient`.
    fn mask(
        &mut self,
        record: Record<'_>,
        text: &[u8],
        widths: &[usize],
        values: &mut [f64],
        error: Error,
    ) -> Result<()> {
        if !self.lenient {
            return Err(error);
        }
        masked_numbers(text, widths, values);
        let mut masked = 0;
        for (k, value) in values.iter_mut().enumerate() {
            if !self.layout.double && !self.is_abscissa(k) && value.abs() > f64::from(f32::MAX) {
                *value = f64::NAN;
            }
            if value.is_nan() && self.is_abscissa(k) {
                return Err(
                    error.help("an abscissa value cannot be masked; correct the file at that line")
                );
            }
            masked += usize::from(value.is_nan());
        }
        let (count, first) = self.masked.unwrap_or((0, record.line));
        self.masked = Some((count + masked, first));
        Ok(())
    }

    /// Refuses numbers that are declared single and exceed single precision.
    fn in_range(&self, record: Record<'_>, values: &[f64]) -> Result<()> {
        if self.layout.double {
            return Ok(());
        }
        match values
            .iter()
            .position(|value| value.abs() > f64::from(f32::MAX))
        {
            Some(index) => Err(Error::bad_data(
                "the number exceeds the single precision that the header declares",
            )
            .at_line(record.line)
            .field(self.name(index))
            .found(values[index])
            .expected(format!("at most {:e}", f32::MAX))),
            None => Ok(()),
        }
    }

    fn short(&self, record: Record<'_>, filled: usize, expected: usize) -> Error {
        Error::bad_data("the line is too short")
            .at_line(record.line)
            .field(self.name(filled))
            .found(format!("{filled} numbers"))
            .expected(format!("{expected} numbers"))
            .help(
                "correct the file at that line, or read it with `lenient`, which masks what is \
                   missing",
            )
    }

    /// True where number `index` of the next line is an abscissa value.
    fn is_abscissa(&self, index: usize) -> bool {
        !self.layout.even
            && (self.numbers.len() + index).is_multiple_of(self.layout.numbers_per_point())
    }

    /// Name of number `index` of the next line.
    fn name(&self, index: usize) -> String {
        let point = (self.numbers.len() + index) / self.layout.numbers_per_point() + 1;
        let part = (self.numbers.len() + index) % self.layout.numbers_per_point()
            + usize::from(self.layout.even);
        match (self.layout.complex, part) {
            (_, 0) => format!("abscissa value {point}"),
            (false, _) => format!("ordinate value {point}"),
            (true, 1) => format!("ordinate value {point}, real part"),
            (true, _) => format!("ordinate value {point}, imaginary part"),
        }
    }
}

/// Splits interleaved numbers into abscissa and ordinate. A value with one masked part is
/// masked as a whole.
fn split(numbers: Vec<f64>, layout: Layout) -> Values {
    let points = numbers.chunks_exact(layout.numbers_per_point());
    let first = usize::from(!layout.even);
    let complex = |y: &[f64]| {
        if y[0].is_nan() || y[1].is_nan() {
            MASKED
        } else {
            Complex64::new(y[0], y[1])
        }
    };
    let ordinate = match (layout.complex, layout.double) {
        (false, false) => Ordinate::Real32(points.clone().map(|p| p[first] as f32).collect()),
        (false, true) => Ordinate::Real64(points.clone().map(|p| p[first]).collect()),
        (true, false) => Ordinate::Complex32(
            points
                .clone()
                .map(|p| narrow(complex(&p[first..])))
                .collect(),
        ),
        (true, true) => Ordinate::Complex64(points.clone().map(|p| complex(&p[first..])).collect()),
    };
    let x = if layout.even {
        Vec::new()
    } else {
        points.map(|p| p[0]).collect()
    };
    Values { x, ordinate }
}

const MASKED: Complex64 = Complex64::new(f64::NAN, f64::NAN);

fn narrow(value: Complex64) -> Complex32 {
    Complex32::new(value.re as f32, value.im as f32)
}

/// Reads the payload of a binary 58. The ordinate keeps the precision of the file.
///
/// # Errors
/// An abscissa value that is not finite. Ordinate values that are not finite are masked and
/// reported.
pub(super) fn read_binary(payload: &Payload<'_>, warnings: &mut Vec<Finding>) -> Result<Values> {
    let form = payload.form;
    let big = payload.big_endian;
    let points = || payload.bytes.chunks_exact(form.point_bytes());
    let mut x = Vec::new();
    if form.x_bytes > 0 {
        x.extend(points().map(|p| {
            if form.x_bytes == 8 {
                f64_at(p, 0, big)
            } else {
                f64::from(f32_at(p, 0, big))
            }
        }));
        if let Some(index) = x.iter().position(|x| !x.is_finite()) {
            return Err(Error::bad_data(Fault::NotFinite.message())
                .at_byte(payload.byte + (index * form.point_bytes()) as u64)
                .field(format!("abscissa value {}", index + 1))
                .found(x[index])
                .expected("a finite number"));
        }
    }
    let at = form.x_bytes;
    let ordinate = match (form.parts, form.y_bytes) {
        (1, 4) => Ordinate::Real32(masked(
            points().map(|p| f32_at(p, at, big)),
            f32::NAN,
            |y| y.is_finite(),
            warnings,
        )),
        (1, _) => Ordinate::Real64(masked(
            points().map(|p| f64_at(p, at, big)),
            f64::NAN,
            |y| y.is_finite(),
            warnings,
        )),
        (_, 4) => {
            let values =
                points().map(|p| Complex32::new(f32_at(p, at, big), f32_at(p, at + 4, big)));
            Ordinate::Complex32(masked(values, narrow(MASKED), |y| y.is_finite(), warnings))
        }
        // the usual FRF: points of one size are copied many at a time
        (_, _) if at == 0 => {
            let points = payload.bytes.as_chunks::<16>().0.iter();
            let values = points.map(|p| Complex64::new(f64_at(p, 0, big), f64_at(p, 8, big)));
            Ordinate::Complex64(masked(values, MASKED, |y| y.is_finite(), warnings))
        }
        (_, _) => {
            let values =
                points().map(|p| Complex64::new(f64_at(p, at, big), f64_at(p, at + 8, big)));
            Ordinate::Complex64(masked(values, MASKED, |y| y.is_finite(), warnings))
        }
    };
    Ok(Values { x, ordinate })
}

/// The values, with `mask` for those that are not finite.
fn masked<T: Copy>(
    values: impl Iterator<Item = T>,
    mask: T,
    is_finite: impl Fn(&T) -> bool,
    warnings: &mut Vec<Finding>,
) -> Vec<T> {
    let mut values: Vec<T> = values.collect();
    // a loop without early exit tests several values in one step
    if values
        .iter()
        .fold(true, |all, value| all & is_finite(value))
    {
        return values;
    }
    let first = values
        .iter()
        .position(|value| !is_finite(value))
        .map_or(0, |index| index + 1);
    let mut count = 0;
    for value in values.iter_mut().filter(|value| !is_finite(value)) {
        *value = mask;
        count += 1;
    }
    warnings.push(Finding::caution(
        "lines-masked",
        format!("{count} values that are NaN or infinite are masked (first: value {first})"),
    ));
    values
}

fn f32_at(point: &[u8], at: usize, big_endian: bool) -> f32 {
    let mut bytes = [0; 4];
    bytes.copy_from_slice(&point[at..at + 4]);
    if big_endian {
        f32::from_be_bytes(bytes)
    } else {
        f32::from_le_bytes(bytes)
    }
}

fn f64_at(point: &[u8], at: usize, big_endian: bool) -> f64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&point[at..at + 8]);
    if big_endian {
        f64::from_be_bytes(bytes)
    } else {
        f64::from_le_bytes(bytes)
    }
}
