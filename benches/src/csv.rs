//! Tables as CSV: one header row, a comment above it, empty cells for what is not
//! defined.

/// A number with the digits that statistics of some hundred values can carry; empty where
/// it is not defined.
pub(crate) fn number(value: f64) -> String {
    match value {
        value if !value.is_finite() => String::new(),
        0.0 => "0".into(),
        value if (1e-3..1e6).contains(&value.abs()) => {
            format!(
                "{:.*}",
                (4 - value.abs().log10().floor() as i32).clamp(0, 7) as usize,
                value
            )
        }
        value => format!("{value:.4e}"),
    }
}

/// First and third quartile of what is given as median, first and third quartile.
pub(crate) fn quartiles([_, first, third]: &[f64; 3]) -> String {
    format!("{} {}", number(*first), number(*third))
}

/// The file: `comment` above the header, one line per row.
pub(crate) fn table<'a>(
    comment: &str,
    header: &[&str],
    rows: impl IntoIterator<Item = Vec<String>> + 'a,
) -> String {
    let line = |cells: Vec<String>| {
        cells
            .iter()
            .map(|cell| quoted(cell))
            .collect::<Vec<_>>()
            .join(",")
            + "\n"
    };
    let header = line(header.iter().map(ToString::to_string).collect());
    format!(
        "# {comment}\n{header}{}",
        rows.into_iter().map(line).collect::<String>()
    )
}

/// A cell with a comma or a quotation mark in quotation marks (RFC 4180).
fn quoted(cell: &str) -> String {
    match cell.contains([',', '"', '\n']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_what_is_not_defined_is_empty() {
        let texts = [0.0, 1.234_567, 12_345.678, 1e-9, f64::NAN].map(number);
        assert_eq!(texts, ["0", "1.2346", "12346", "1.0000e-9", ""]);
        assert_eq!(
            table("made", &["a", "b"], [vec!["1,5".into(), String::new()]]),
            "# made\na,b\n\"1,5\",\n"
        );
    }
}
