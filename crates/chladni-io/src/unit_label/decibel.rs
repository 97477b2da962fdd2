//! Decibels, relative to a reference value in the label.

/// Reference value and its unit: (1e-6, "m/s/N") for `dB re 1e-6 m/s/N`.
pub(crate) fn decibel_reference(label: &str) -> Option<(f64, &str)> {
    let at = label.to_lowercase().find("db")?;
    let after = label
        .get(at + 2..)?
        .trim_start_matches(|c: char| c.is_whitespace() || "(:[_".contains(c));
    let lower = after.to_lowercase();
    let word = ["reference", "ref.", "ref", "re.", "re", "rel."]
        .into_iter()
        .find(|word| lower.starts_with(word))?;
    let after = after
        .get(word.len()..)?
        .trim_start_matches(|c: char| c.is_whitespace() || ":=_".contains(c));
    let digits = after
        .find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
        .unwrap_or(after.len());
    let value: f64 = after.get(..digits)?.parse().ok()?;
    let unit = after
        .get(digits..)?
        .trim_matches(|c: char| c.is_whitespace() || c == '_');
    // the bracket of `dB (re 1 m/s/N)`
    let opened = unit.matches(['(', '[']).count();
    let unit = match unit.strip_suffix([')', ']']) {
        Some(inside) if unit.matches([')', ']']).count() > opened => inside,
        _ => unit,
    };
    (value.is_finite() && value > 0.0).then_some((value, unit))
}

/// True for a label in decibels, with a reference or without.
pub(crate) fn is_decibel_label(label: &str) -> bool {
    let lower = label.trim().to_lowercase();
    lower.starts_with("db") || lower.starts_with("decibel")
}
