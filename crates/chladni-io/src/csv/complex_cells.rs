//! Tables of complex numbers in one cell each, which are refused.

use super::text::{Cell, Dialect, Line};
use crate::limits::ROWS_TRIED;
use chladni_frf::{Error, Result};

/// Refuses complex numbers in one cell, with and without a frequency beside them.
pub(super) fn refuse_complex_lists(lines: &[Line<'_>]) -> Result<()> {
    refuse_complex_cells(lines)?;
    let Some(first) = lines.iter().find(|line| !line.is_comment) else {
        return Ok(());
    };
    let text = first.text.trim();
    let inner = text.trim_start_matches('(').trim_end_matches(')');
    let is_complex = inner.ends_with('j')
        && inner.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    if !is_complex || text.contains([',', ';', '\t']) {
        return Ok(());
    }
    Err(
        Error::bad_data("complex numbers in Python notation, without a frequency axis")
            .at_line(first.number)
            .found(text)
            .expected("columns frequency,re,im")
            .help(
                "write the frequency beside each value: three columns f,re,im with that line as \
               header",
            ),
    )
}

/// True for a complex number in one cell: `1.5-2e-3j`, `(1+2j)`, `1.5 + 2i`.
fn is_complex_cell(cell: &str) -> bool {
    let cell = cell.trim().trim_start_matches('(').trim_end_matches(')');
    let Some(both) = cell.strip_suffix(['j', 'i', 'J', 'I']) else {
        return false;
    };
    let both: String = both.chars().filter(|c| !c.is_whitespace()).collect();
    let is_number = |text: &str| {
        text.ends_with(|c: char| c.is_ascii_digit() || c == '.') && text.parse::<f64>().is_ok()
    };
    let signs = both.rmatch_indices(['+', '-']).filter(|(at, _)| *at > 0);
    let mut halves = signs.map(|(at, _)| both.split_at(at));
    halves.any(|(re, im)| is_number(re) && is_number(im))
}

/// Refuses rows of a frequency and complex numbers, each in one cell.
fn refuse_complex_cells(lines: &[Line<'_>]) -> Result<()> {
    let any = Dialect {
        delimiter: Some('\t'),
        decimal_comma: false,
    };
    let is_row = |text: &str| {
        any.and_others().any(|dialect| {
            let cells = dialect.cells(text);
            matches!(dialect.number(&cells[0]), Cell::Value(_))
                && cells[1..].iter().any(|cell| is_complex_cell(cell))
        })
    };
    let tried = lines.iter().filter(|line| !line.is_comment);
    match tried.take(ROWS_TRIED).find(|line| is_row(line.text)) {
        None => Ok(()),
        Some(line) => Err(Error::bad_data("a complex number in one cell")
            .at_line(line.number)
            .found(line.text.trim())
            .expected("real and imaginary part in columns of their own: f,re,im")
            .help(
                "write three columns f,re,im with that line as header, as in \
                 numpy.savetxt(file, numpy.c_[f, H.real, H.imag], delimiter=\",\", \
                 header=\"f,re,im\")",
            )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complex_numbers_are_known_in_python_and_matlab_notation() {
        for cell in ["1.5+2j", "(1.5e-05-2.5e-3j)", "-1 + 2i", "-1e+3+1E-2J"] {
            assert!(is_complex_cell(cell), "{cell}");
        }
        for cell in ["", "j", "2j", "1.5", "-2e-3j", "1+x2i", "Hi-Fi", "1.5+2"] {
            assert!(!is_complex_cell(cell), "{cell}");
        }
    }
}
