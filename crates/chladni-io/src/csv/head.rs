//! What the header of a column says: part of the FRF, unit, DOFs.

use crate::unit_label::{frequency_unit, frf_unit, FrfUnit};
use chladni_frf::Dof;

/// Which part of an FRF a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Re,
    Im,
    Magnitude,
    Phase,
    Coherence,
    /// The header does not say.
    Unknown,
}

/// Header of one column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Head {
    pub(super) part: Part,
    /// The name without part and unit, to find the partner of a column.
    pub(super) base: String,
    /// Text in the last brackets, or of the unit row.
    pub(super) unit: String,
    pub(super) dofs: Option<(Dof, Option<Dof>)>,
}

const PARTS: [(Part, &[&str]); 5] = [
    (Part::Re, &["re", "real"]),
    (Part::Im, &["im", "imag", "imaginary"]),
    (Part::Phase, &["phase", "phi", "angle", "arg"]),
    (Part::Coherence, &["coherence", "coh", "gamma"]),
    (
        Part::Magnitude,
        &[
            "mag",
            "magnitude",
            "abs",
            "amp",
            "amplitude",
            "modulus",
            "db",
        ],
    ),
];

impl Head {
    /// Reads a column name such as `Re(x) [mm/s/N]`, `1Z:3Z imag`, `Magnitude (dB re 1
    /// m/s/N)`, `coherence`.
    pub(super) fn parse(name: &str, unit_row: &str) -> Self {
        let (rest, unit) = split_unit(name);
        let unit = if unit.is_empty() {
            unit_row
                .trim()
                .trim_matches(['[', ']', '(', ')'])
                .to_owned()
        } else {
            unit
        };
        let words: Vec<&str> = rest
            .split(|c: char| c.is_whitespace() || "()[]_|,".contains(c))
            .filter(|word| !word.is_empty())
            .collect();
        let part_of = |word: &str| {
            let letters = word
                .trim_end_matches(|c: char| c.is_ascii_digit() || c == '²')
                .to_lowercase();
            PARTS
                .iter()
                .find(|(_, names)| names.contains(&letters.as_str()))
                .map(|(part, _)| *part)
        };
        let part = words
            .iter()
            .find_map(|word| part_of(word))
            .unwrap_or(Part::Unknown);
        let part = if part == Part::Unknown && unit.to_lowercase().starts_with("db") {
            Part::Magnitude
        } else {
            part
        };
        let others: Vec<&str> = words
            .iter()
            .filter(|word| part_of(word).is_none())
            .copied()
            .collect();
        let dofs = others.iter().find_map(|word| dof_pair(word));
        Self {
            part,
            base: others.join(" ").to_lowercase(),
            unit,
            dofs,
        }
    }

    /// True where the phase is in radians; degrees are the rule.
    pub(super) fn is_radian(&self) -> bool {
        self.unit.trim().to_lowercase().starts_with("rad")
    }
    /// True where the magnitude is in decibels.
    pub(super) fn is_decibel(&self) -> bool {
        self.unit.to_lowercase().contains("db") || self.base.split(' ').any(|word| word == "db")
    }
    /// dB reference: `dB re 1e-6 m/s/N` gives (1e-6, "m/s/N").
    pub(super) fn decibel_reference(&self) -> Option<(f64, &str)> {
        let at = self.unit.to_lowercase().find("db")?;
        let after = self
            .unit
            .get(at + 2..)?
            .trim_start_matches(|c: char| c.is_whitespace() || "(:[".contains(c));
        let lower = after.to_lowercase();
        let word = ["reference", "ref.", "ref", "re.", "re", "rel."]
            .into_iter()
            .find(|word| lower.starts_with(word))?;
        let after = after
            .get(word.len()..)?
            .trim_start_matches(|c: char| c.is_whitespace() || c == ':' || c == '=');
        let digits = after
            .find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
            .unwrap_or(after.len());
        let value: f64 = after.get(..digits)?.parse().ok()?;
        (value.is_finite() && value > 0.0).then_some((
            value,
            after.get(digits..)?.trim().trim_end_matches([')', ']']),
        ))
    }
    /// Unit of the FRF, where the header names one.
    pub(super) fn frf_unit(&self) -> Option<FrfUnit> {
        frf_unit(&self.unit)
    }
}

/// Splits `Re(x) [mm/s/N]` into `Re(x)` and `mm/s/N`. Round brackets count where their
/// text is a unit.
fn split_unit(name: &str) -> (&str, String) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(start) = name
            .strip_suffix(close)
            .and_then(|inner| matching_open(inner, open, close))
        {
            let inside = name[start + 1..name.len() - 1].trim();
            let is_set_number = inside.bytes().all(|byte| byte.is_ascii_digit());
            let is_unit = open == '[' || looks_like_unit(inside);
            if is_unit && !is_set_number && dof_pair(inside).is_none() {
                return (name[..start].trim(), inside.to_owned());
            }
        }
    }
    (name, String::new())
}

/// Position of the bracket that the closing one after `inner` belongs to.
fn matching_open(inner: &str, open: char, close: char) -> Option<usize> {
    let mut depth = 1;
    for (at, c) in inner.char_indices().rev() {
        if c == close {
            depth += 1;
        } else if c == open {
            depth -= 1;
            if depth == 0 {
                return Some(at);
            }
        }
    }
    None
}

/// True for a unit of an FRF, a frequency, an angle or decibels.
pub(super) fn looks_like_unit(text: &str) -> bool {
    let lower = text
        .trim()
        .trim_matches(['[', ']', '(', ')'])
        .to_lowercase();
    let known = ["", "-", "1", "deg", "degrees", "°", "rad", "none"].contains(&lower.as_str())
        || lower.starts_with("db");
    known
        || frequency_unit(text).is_some()
        || frf_unit(text).is_some()
        || (text.contains('/') && !text.contains(':'))
}

/// A response and perhaps its reference: `12:+Z`, `1Z:3Z`, `12:+Z:101:+Z`,
/// `12:+Z/101:+Z`.
pub(super) fn dof_pair(text: &str) -> Option<(Dof, Option<Dof>)> {
    let text = text.trim();
    if let Ok(dof) = text.parse() {
        return Some((dof, None));
    }
    text.match_indices([':', '/']).find_map(|(at, _)| {
        let response = text[..at].parse().ok()?;
        Some((response, Some(text[at + 1..].parse().ok()?)))
    })
}

/// Factor from the first column to Hz; `None` where its header names a unit that is no
/// frequency.
pub(super) fn frequency_factor(name: &str, unit_row: &str) -> Option<f64> {
    let (rest, unit) = split_unit(name);
    for label in [
        unit.as_str(),
        unit_row.trim().trim_matches(['[', ']', '(', ')']),
    ] {
        if !label.is_empty() {
            return frequency_unit(label);
        }
    }
    let lower = rest.to_lowercase();
    let words: Vec<&str> = lower
        .split(|c: char| !(c.is_alphanumeric() || c == '/'))
        .collect();
    for word in &words {
        match *word {
            "hz" => return Some(1.0),
            "khz" => return Some(1e3),
            "rad/s" => return frequency_unit(word),
            "omega" | "w" | "time" | "t" | "s" => return None,
            _ => {}
        }
    }
    Some(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn column_names_of_formats_section_5() {
        for (name, part, unit) in [
            ("re", Part::Re, ""),
            ("Re(x) [mm/s/N]", Part::Re, "mm/s/N"),
            ("Im(x) [(m/s)/N]", Part::Im, "(m/s)/N"),
            ("Abs(H1)", Part::Magnitude, ""),
            ("Phi(H1) [rad]", Part::Phase, "rad"),
            (
                "Magnitude (dB re 1 m/s/N)",
                Part::Magnitude,
                "dB re 1 m/s/N",
            ),
            ("coherence", Part::Coherence, ""),
            ("12:+Z_imag", Part::Im, ""),
            ("1Z:3Z [2]", Part::Unknown, ""),
            ("H [dB]", Part::Magnitude, "dB"),
        ] {
            let head = Head::parse(name, "");
            assert_eq!((head.part, head.unit.as_str()), (part, unit), "{name}");
        }
    }

    #[test]
    fn dofs_in_headers() {
        let show = |name: &str| {
            let dofs = Head::parse(name, "").dofs;
            dofs.map(|(response, reference)| {
                (
                    response.to_string(),
                    reference.map(|dof| dof.to_string()).unwrap_or_default(),
                )
            })
        };
        let pair = |a: &str, b: &str| Some((a.to_owned(), b.to_owned()));
        assert_eq!(show("1Z:3Z [2]"), pair("1:+Z", "3:+Z"));
        assert_eq!(show("Re(12:-Z:101:+Z)"), pair("12:-Z", "101:+Z"));
        assert_eq!(show("12:+Z_re"), pair("12:+Z", ""));
        assert_eq!(show("Re(x)"), None);
    }

    #[test]
    fn decibels_need_their_reference() {
        assert_eq!(
            Head::parse("Mag [dB re 1e-6 m/s/N]", "").decibel_reference(),
            Some((1e-6, "m/s/N"))
        );
        assert_eq!(
            Head::parse("Mag (dB ref 1 (m/s)/N)", "")
                .decibel_reference()
                .map(|(value, _)| value),
            Some(1.0)
        );
        assert_eq!(Head::parse("Mag [dB]", "").decibel_reference(), None);
    }

    #[test]
    fn units_of_the_frequency_column() {
        for (name, row, factor) in [
            ("f [kHz]", "", Some(1e3)),
            ("freq_hz", "", Some(1.0)),
            ("Frequency", "", Some(1.0)),
            ("Frequency", "kHz", Some(1e3)),
            ("omega", "", None),
            ("f [V]", "", None),
            ("Time", "", None),
        ] {
            assert_eq!(frequency_factor(name, row), factor, "{name}");
        }
        assert!(
            (frequency_factor("omega [rad/s]", "").unwrap() - 1.0 / std::f64::consts::TAU).abs()
                < 1e-15
        );
    }
}
