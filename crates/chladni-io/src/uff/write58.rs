//! Writes one function as dataset 58 or 58b.

use super::layout::Layout;
use super::step::{multiple_near, Printed};
use super::write_options::WriteOptions;
use crate::{Abscissa, Axis, Function, Ordinate};
use chladni_frf::{Error, Finding, Result};
use num_complex::Complex;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Checks that a function can be written with these options. Returns findings on losses.
///
/// # Errors
/// Values that are not finite, in text; numbers that do not fit their columns.
pub(super) fn check(function: &Function, options: WriteOptions) -> Result<Vec<Finding>> {
    check_numbers(function)?;
    let mut warnings = Vec::new();
    warnings.extend(check_abscissa(function, options)?);
    if !options.binary {
        if let Some(line) = first_not_finite(&function.ordinate) {
            return Err(Error::bad_data(
                "a masked or infinite value cannot be written to a text universal file",
            )
            .field(format!("{}: value {}", named(function), line + 1))
            .found("NaN or infinity")
            .expected("finite numbers")
            .help("write the binary form, or HDF5"));
        }
    }
    let mut names = function.entity_names.iter();
    let mut axes = function.axes.iter();
    let lost = [
        (
            names.any(|name| name.chars().count() > 10),
            "entity names are cut to 10 characters",
        ),
        (
            axes.any(|axis| axis.label.chars().count() > 20 || axis.unit.chars().count() > 20),
            "axis and unit labels are cut to 20 characters",
        ),
        (
            id_line_4(function).own_text_is_lost,
            "ID line 4 is full: the exact step df= replaces its text",
        ),
    ];
    let lost = lost.into_iter().filter(|(is_lost, _)| *is_lost);
    warnings.extend(lost.map(|(_, words)| Finding::note("digits-lost", words)));
    Ok(warnings)
}

fn named(function: &Function) -> String {
    format!("function {} / {}", function.response, function.reference)
}

/// Checks that the numbers of the header fit their columns.
fn check_numbers(function: &Function) -> Result<()> {
    let of_record_6 = [
        ("function type", i64::from(function.function_type), 99_999),
        ("function id", function.ids[0], 9_999_999_999),
        ("version", function.ids[1], 99_999),
        ("load case", function.ids[2], 9_999_999_999),
    ];
    let of_axes = function.axes.iter().flat_map(|axis| {
        let exponents = axis
            .exponents
            .map(|exponent| ("exponent of an axis", i64::from(exponent), 99_999));
        exponents.into_iter().chain([(
            "quantity code of an axis",
            i64::from(axis.quantity),
            9_999_999_999,
        )])
    });
    for (name, number, limit) in of_record_6.into_iter().chain(of_axes) {
        if !(-limit / 10..=limit).contains(&number) {
            return Err(Error::bad_data("the number does not fit its columns")
                .field(format!("{}: {name}", named(function)))
                .found(number)
                .expected(format!("{} to {limit}", -limit / 10))
                .help("write HDF5 (.h5), which holds any number"));
        }
    }
    Ok(())
}

/// Checks the abscissa: as long as the values, finite, and still rising when printed.
fn check_abscissa(function: &Function, options: WriteOptions) -> Result<Option<Finding>> {
    let field = format!("{}: abscissa", named(function));
    let count = function.ordinate.len();
    let finite_axis = match &function.abscissa {
        Abscissa::Even { start, step } => start.is_finite() && step.is_finite(),
        Abscissa::Uneven(values) => values.iter().all(|x| x.is_finite()),
    };
    let mut warning = None;
    if let Abscissa::Uneven(values) = &function.abscissa {
        if values.len() != count {
            return Err(Error::bad_data("sizes disagree")
                .field(field)
                .found(values.len())
                .expected(format!("{count}, one per value")));
        }
        if !options.binary {
            if let Some(line) = first_alike(values) {
                return Err(Error::bad_data(
                    "a text universal file keeps six digits of an uneven axis, and two of its values are \
                     the same then",
                )
                .field(field)
                .found(format!("{} and {}", values[line], values[line + 1]))
                .expected("values that differ in six digits")
                .help("write the binary form (.uff) or HDF5 (.h5), which keep all digits"));
            }
            warning = Some(Finding::note(
                "digits-lost",
                "text keeps 6 digits of an uneven abscissa; the binary form and HDF5 keep all",
            ));
        }
    }
    if !finite_axis || !function.z.is_finite() {
        return Err(Error::bad_data("the abscissa is not finite")
            .field(field)
            .expected("finite numbers"));
    }
    Ok(warning)
}

fn first_not_finite(ordinate: &Ordinate) -> Option<usize> {
    match ordinate {
        Ordinate::Real32(values) => values.iter().position(|y| !y.is_finite()),
        Ordinate::Real64(values) => values.iter().position(|y| !y.is_finite()),
        Ordinate::Complex32(values) => values.iter().position(|y| !y.is_finite()),
        Ordinate::Complex64(values) => values.iter().position(|y| !y.is_finite()),
    }
}

/// ID line 4 as it is written.
struct IdLine4 {
    text: String,
    /// True where it has no room for its own text.
    own_text_is_lost: bool,
}

/// ID line 4 with the exact step `df=`, and `start=` where the digits of record 7 do not
/// give the exact start.
fn id_line_4(function: &Function) -> IdLine4 {
    let own = function.id_lines[3].as_str();
    let (start, step) = match function.abscissa {
        Abscissa::Even { start, step } if step > 0.0 => (start, step),
        _ => {
            return IdLine4 {
                text: own.to_owned(),
                own_text_is_lost: false,
            }
        }
    };
    let mut tag = format!("df={step:?}");
    let text = fortran(start, 13, 5, 'E');
    let printed = Printed::new(text.as_bytes(), text.trim().parse().unwrap_or(start));
    if multiple_near(printed.value, step, printed.half_unit) != start {
        let _ = write!(tag, " start={start:?}");
    }
    let kept: Vec<&str> = own
        .split_whitespace()
        .filter(|word| !word.starts_with("df=") && !word.starts_with("start="))
        .collect();
    let line = [kept, vec![&tag]].concat().join(" ");
    let own_text_is_lost = line.chars().count() > 80;
    IdLine4 {
        text: if own_text_is_lost { tag } else { line },
        own_text_is_lost,
    }
}

/// Index of the first value that prints like the next one in six digits.
fn first_alike(values: &[f64]) -> Option<usize> {
    let printed: Vec<String> = values.iter().map(|x| format!("{x:.5e}")).collect();
    printed.windows(2).position(|pair| pair[0] == pair[1])
}

/// The layout in which the function is written.
///
/// An uneven abscissa takes the precision of the ordinate. Where single precision would
/// round it, the binary form is written in double precision.
fn layout_of(function: &Function, options: WriteOptions) -> Layout {
    let (complex, double) = match &function.ordinate {
        Ordinate::Real32(_) => (false, false),
        Ordinate::Real64(_) => (false, true),
        Ordinate::Complex32(_) => (true, false),
        Ordinate::Complex64(_) => (true, true),
    };
    let (even, fits_single) = match &function.abscissa {
        Abscissa::Even { .. } => (true, true),
        Abscissa::Uneven(values) => (false, values.iter().all(|&x| f64::from(x as f32) == x)),
    };
    Layout {
        complex,
        double: double || (options.binary && !fits_single),
        even,
        count: function.ordinate.len() as u64,
    }
}

/// Writes the dataset with its markers.
///
/// # Errors
/// Those of `sink`.
pub(super) fn write(
    sink: &mut dyn Write,
    function: &Function,
    options: WriteOptions,
) -> io::Result<()> {
    let layout = layout_of(function, options);
    let float_bytes = if layout.double { 8 } else { 4 };
    let bytes = function.ordinate.len() * layout.numbers_per_point() * float_bytes;
    if options.binary {
        writeln!(
            sink,
            "    -1\n    58b{:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}",
            1, 2, 11, bytes, 0, 0, 0, 0
        )?;
    } else {
        writeln!(sink, "    -1\n    58")?;
    }
    write_records(sink, function, layout)?;
    let mut data = Data {
        sink,
        layout,
        binary: options.binary,
        buffer: Vec::with_capacity(2 * FLUSH_AT),
        column: 0,
    };
    match &function.ordinate {
        Ordinate::Real32(values) => data.points(function, values, |&y| [y.into(), 0.0])?,
        Ordinate::Real64(values) => data.points(function, values, |&y| [y, 0.0])?,
        Ordinate::Complex32(values) => data.points(function, values, |&Complex { re, im }| {
            [re.into(), im.into()]
        })?,
        Ordinate::Complex64(values) => {
            data.points(function, values, |&Complex { re, im }| [re, im])?
        }
    }
    data.finish()?;
    sink.write_all(b"    -1\n")
}

fn write_records(sink: &mut dyn Write, function: &Function, layout: Layout) -> io::Result<()> {
    let id_4 = id_line_4(function).text;
    for (k, line) in function.id_lines.iter().enumerate() {
        writeln!(sink, "{}", id_line(if k == 3 { &id_4 } else { line }))?;
    }
    let [id, version, load_case] = function.ids;
    write!(
        sink,
        "{:5}{id:10}{version:5}{load_case:10}",
        function.function_type
    )?;
    for (name, dof) in function
        .entity_names
        .iter()
        .zip([function.response, function.reference])
    {
        write!(
            sink,
            " {:<10}{:10}{:4}",
            text_field(name, 10),
            dof.node,
            dof.direction.code()
        )?;
    }
    let (start, step) = match &function.abscissa {
        Abscissa::Even { start, step } => (*start, *step),
        Abscissa::Uneven(_) => (0.0, 0.0),
    };
    let [start, step, z] = [start, step, function.z].map(|value| fortran(value, 13, 5, 'E'));
    writeln!(
        sink,
        "\n{:10}{:10}{:10}{start}{step}{z}",
        layout.code(),
        layout.count,
        i32::from(layout.even)
    )?;
    for Axis {
        quantity,
        exponents: [length, force, temperature],
        label,
        unit,
    } in &function.axes
    {
        let (label, unit) = (text_field(label, 20), text_field(unit, 20));
        writeln!(
            sink,
            "{quantity:10}{length:5}{force:5}{temperature:5} {label:<20} {unit:<20}"
        )?;
    }
    Ok(())
}

/// Text of at most `width` characters without control characters; `NONE` for an empty one.
fn text_field(text: &str, width: usize) -> String {
    let clean: String = text
        .trim()
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(width)
        .collect();
    if clean.trim().is_empty() {
        "NONE".into()
    } else {
        clean
    }
}

/// An ID line. A line `-1` is moved to other columns, so that it does not end the dataset.
pub(super) fn id_line(text: &str) -> String {
    match text_field(text, 80) {
        line if line.trim() == "-1" => format!("{line:>20}"),
        line => line,
    }
}

/// A number in `width` columns with an exponent as Fortran prints it: `1.00000E+00`.
pub(super) fn fortran(value: f64, width: usize, decimals: usize, letter: char) -> String {
    let mut text = String::new();
    push_fortran(&mut text, value, width, decimals, letter);
    text
}

fn push_fortran(out: &mut String, value: f64, width: usize, decimals: usize, letter: char) {
    // "1.5e-7" -> "1.5E-07"; writing to a String cannot fail
    let start = out.len();
    let _ = write!(out, "{value:.decimals$e}");
    let exponent_at = out[start..].find('e').map_or(out.len(), |k| start + k);
    let exponent: i32 = out[exponent_at..]
        .trim_start_matches('e')
        .parse()
        .unwrap_or(0);
    out.truncate(exponent_at);
    let _ = write!(out, "{letter}{exponent:+03}");
    for _ in out.len() - start..width {
        out.insert(start, ' ');
    }
}

/// Bytes from which the buffer is passed on.
const FLUSH_AT: usize = 1 << 16;

/// Buffered data lines or payload.
struct Data<'a> {
    sink: &'a mut dyn Write,
    layout: Layout,
    binary: bool,
    buffer: Vec<u8>,
    /// Index of the next field in its line.
    column: usize,
}

impl Data<'_> {
    fn points<T>(
        &mut self,
        function: &Function,
        values: &[T],
        parts: impl Fn(&T) -> [f64; 2],
    ) -> io::Result<()> {
        let mut text = String::new();
        for (k, value) in values.iter().enumerate() {
            if let Abscissa::Uneven(x) = &function.abscissa {
                self.number(x[k], &mut text);
            }
            let [re, im] = parts(value);
            self.number(re, &mut text);
            if self.layout.complex {
                self.number(im, &mut text);
            }
            if self.buffer.len() >= FLUSH_AT {
                self.sink.write_all(&self.buffer)?;
                self.buffer.clear();
            }
        }
        Ok(())
    }

    fn number(&mut self, value: f64, text: &mut String) {
        if self.binary {
            if self.layout.double {
                self.buffer.extend_from_slice(&value.to_le_bytes());
            } else {
                self.buffer.extend_from_slice(&(value as f32).to_le_bytes());
            }
            return;
        }
        let widths = self.layout.widths();
        let width = widths[self.column];
        text.clear();
        push_fortran(text, value, width, if width == 13 { 5 } else { 12 }, 'E');
        self.buffer.extend_from_slice(text.as_bytes());
        self.column = (self.column + 1) % widths.len();
        if self.column == 0 {
            self.buffer.push(b'\n');
        }
    }

    fn finish(mut self) -> io::Result<()> {
        if self.column != 0 {
            self.buffer.push(b'\n');
        }
        self.sink.write_all(&self.buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_printed_as_fortran_does() {
        for (value, text) in [
            (0.0, "  0.00000E+00"),
            (-1.5, " -1.50000E+00"),
            (1.234e-101, " 1.23400E-101"),
            (-1.234e-101, "-1.23400E-101"),
            (2.44140625e9, "  2.44141E+09"),
        ] {
            assert_eq!(fortran(value, 13, 5, 'E'), text);
        }
        assert_eq!(fortran(0.1, 25, 16, 'D'), "   1.0000000000000001D-01");
    }

    #[test]
    fn an_id_line_cannot_end_the_dataset() {
        assert!(!super::super::lines::is_marker(id_line("  -1").as_bytes()));
        assert_eq!(id_line(" a\nb "), "a b");
        assert_eq!(id_line(""), "NONE");
    }
}
