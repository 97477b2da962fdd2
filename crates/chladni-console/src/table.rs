//! Tables for people, and numbers with as many digits as their error bars allow.

pub use chladni_frf::counted;
use comfy_table::{presets, CellAlignment, Table};

/// Standard deviations within which 95 % of a normal distribution lie.
pub const SIGMAS_95: f64 = 1.96;

/// A table without a frame: header, then rows; columns of numbers are aligned at the right.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table
        .load_style(presets::NOTHING)
        .set_header(header.iter().map(ToString::to_string));
    for row in rows {
        table.add_row(row.iter().map(ToString::to_string));
    }
    let is_number = |cell: &String| {
        cell.is_empty() || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '±')
    };
    for column in 0..header.len() {
        if rows.iter().filter_map(|row| row.get(column)).all(is_number) {
            if let Some(column) = table.column_mut(column) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
    }
    // the first cell of a line is padded on its left too
    table
        .lines()
        .map(|line| format!("{}\n", line.strip_prefix(' ').unwrap_or(&line).trim_end()))
        .collect()
}

/// A value with its bound, both rounded to the first digit of the bound. Without a known bound
/// the value alone, to six digits.
pub fn bounded(value: f64, bound: f64) -> String {
    if !(bound.is_finite() && bound > 0.0) {
        return significant(value, 6);
    }
    // the exponent after rounding to one digit: 0.96 becomes 1e0
    let leading = format!("{bound:.0e}");
    let exponent: f64 = leading
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0.0);
    let decimals = (-exponent).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$} ± {bound:.decimals$}")
}

/// A value with `digits` significant digits, without trailing zeros.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals =
        (f64::from(digits) - 1.0 - value.abs().log10().floor()).clamp(0.0, 15.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// The first `shown` items of a list, and the number of the others.
pub fn shortened(items: &[String], shown: usize) -> String {
    let first = items
        .iter()
        .take(shown)
        .cloned()
        .collect::<Vec<_>>()
        .join(", ");
    match items.len().checked_sub(shown) {
        Some(more) if more > 0 => format!("{first} and {more} more"),
        _ => first,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_error_bar() {
        assert_eq!(bounded(54.351_234, 0.001_96), "54.351 ± 0.002");
        assert_eq!(bounded(54.351_234, 0.000_98), "54.351 ± 0.001");
        assert_eq!(bounded(54.351_234, 19.6), "54 ± 20");
        assert_eq!(bounded(54.351_234, 0.0), "54.3512");
        assert_eq!(significant(0.010_000_00, 3), "0.01");
        assert_eq!(significant(1234.5, 2), "1234");
    }
}
