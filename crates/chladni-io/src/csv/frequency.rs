//! The frequency column: its unit, its name, its order.

use super::column_header::{split_unit, without_brackets};
use super::vocabulary::{after_frequency, is_filler, is_frequency};
use crate::unit_label::{frequency_unit, parse};

/// Factor from a column to Hz by its header; `None` where the header names another unit or
/// another quantity. A column without a name is in Hz.
pub(super) fn factor_to_hz(name: &str, unit_row: &str) -> Option<f64> {
    let (rest, unit) = split_unit(name);
    for label in [unit.as_str(), without_brackets(unit_row).as_str()] {
        if !label.is_empty() {
            return frequency_unit(label);
        }
    }
    if rest.is_empty() {
        return Some(1.0);
    }
    let spelled = rest.replace("_per_", "/").replace(" per ", "/");
    let mut known = false;
    let mut units: Vec<&str> = Vec::new();
    for token in spelled
        .split(|c: char| c.is_whitespace() || "()[]{}_,;:|.=".contains(c))
        .filter(|token| !token.is_empty())
    {
        let lower = token.to_lowercase();
        let (name, tail) = token.split_once('/').unwrap_or((token, ""));
        if is_filler(&lower) {
            continue; // "in" is no inch here
        }
        if frequency_unit(token).is_some() || (parse(token).is_some() && !is_frequency(&lower)) {
            units.push(token);
        } else if is_frequency(&name.to_lowercase()) {
            known = true;
            units.extend(Some(tail).filter(|tail| !tail.is_empty()));
        } else if let Some(tail) = after_frequency(token).filter(|t| frequency_unit(t).is_some()) {
            units.push(tail);
        } else {
            return None; // another quantity, or another unit
        }
    }
    match units.as_slice() {
        [] => known.then_some(1.0),
        units => frequency_unit(&units.join("/")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_the_frequency_column() {
        for (name, row, factor) in [
            ("", "", Some(1.0)),
            ("f [kHz]", "", Some(1e3)),
            ("freq_hz", "", Some(1.0)),
            ("Frequency", "", Some(1.0)),
            ("Frequency", "kHz", Some(1e3)),
            ("Frequency in kHz", "", Some(1e3)),
            ("f/kHz", "", Some(1e3)),
            ("f_MHz", "", Some(1e6)),
            ("fkHz", "", Some(1e3)),
            ("f_mhz", "", None),
            ("rpm", "", Some(1.0 / 60.0)),
            ("f [rpm]", "", Some(1.0 / 60.0)),
            ("Hz", "", Some(1.0)),
            ("omega", "", None),
            ("angular frequency", "", None),
            ("f [V]", "", None),
            ("Time", "", None),
            ("index", "", None),
            ("node", "", None),
        ] {
            assert_eq!(factor_to_hz(name, row), factor, "{name} {row}");
        }
        for name in ["omega [rad/s]", "frequency rad/s", "f_rad_per_s", "f_rad_s"] {
            let factor = factor_to_hz(name, "").unwrap();
            assert!(
                (factor * std::f64::consts::TAU - 1.0).abs() < 1e-15,
                "{name}"
            );
        }
    }
}
