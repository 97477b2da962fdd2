//! The meaning of the header of a column: part of the FRF, unit, DOFs.

use super::dofs::{dof_pair, DofWords, Dofs};
use super::vocabulary::{
    is_beside_dof, is_decibel, is_filler, is_measurement, is_squared, known_words, part_of, words,
    Part, LAG, MINUS, NEGATIVE,
};
use crate::unit_label::{self, frequency_unit, frf_unit, FrfUnit};
use crate::PhaseUnit;
use chladni_frf::{Direction, Dof};

/// The header of one column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColumnHeader {
    pub(super) part: Part,
    /// The name without part and unit, to find the partner of a column.
    pub(super) base: String,
    /// Unit in brackets, at the end of the name, or of the unit row.
    pub(super) unit: String,
    pub(super) dofs: Dofs,
    /// True where the numbers have the opposite sign: `-Im`, `phase lag`.
    pub(super) is_negative: bool,
    is_decibel: bool,
    /// Units of a phase among the words of the name.
    angles: Vec<PhaseUnit>,
    dof_words: DofWords,
    /// True where the name has words that do not belong to a DOF: `Acc 1x`.
    is_described: bool,
    /// True where some of them are about the measurement: `5s record`.
    is_of_measurement: bool,
}

/// The unit of a phase, as a header states it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AngleUnit {
    Nothing,
    Unit(PhaseUnit),
    /// A label that is no unit of a phase, or two units.
    NotUnderstood,
}

impl ColumnHeader {
    /// Reads the names of all columns of a table, with the rows of their units.
    pub(super) fn of_columns(names: &[String], units: &[String]) -> Vec<Self> {
        let both = names.iter().zip(units);
        let mut heads: Vec<Self> = both
            .map(|(name, unit)| Self::read_words(name, unit))
            .collect();
        settle_dofs(&mut heads);
        heads
    }

    /// Reads a column name by itself.
    pub(super) fn parse(name: &str, unit_row: &str) -> Self {
        let mut head = Self::read_words(name, unit_row);
        settle_dofs(std::slice::from_mut(&mut head));
        head
    }

    /// Reads a column name such as `Re(x) [mm/s/N]`, `1Z:3Z imag`, `Magnitude (dB re 1
    /// m/s/N)`, `phase_rad`, `coherence`; its DOFs are not settled yet.
    fn read_words(name: &str, unit_row: &str) -> Self {
        let (rest, unit) = name_and_unit(name, unit_row);
        let mut words = NameWords {
            is_decibel: words(&unit).any(is_decibel),
            ..NameWords::default()
        };
        let mut before = "";
        for token in rest
            .split(|c: char| c.is_whitespace() || "()[]{}_,;=".contains(c))
            .filter(|token| !token.is_empty())
        {
            words.add(token, before);
            before = token;
        }
        words.parts.dedup();
        let part = match words.parts.as_slice() {
            [] if words.is_decibel => Part::Magnitude,
            // a power spectrum is no FRF
            [Part::Magnitude] if is_squared(rest) => Part::Unknown,
            &[part] => part,
            _ => Part::Unknown,
        };
        Self {
            part,
            base: words.others.join(" "),
            unit,
            dofs: Dofs::default(),
            is_negative: words.is_negative || (words.is_lag && part == Part::Phase),
            is_decibel: words.is_decibel,
            angles: words.angles,
            dof_words: words.dof_words,
            is_described: words.is_described,
            is_of_measurement: words.is_of_measurement,
        }
    }

    /// Unit of the phase, as the header states it.
    pub(super) fn angle(&self) -> AngleUnit {
        let label = self.unit.trim();
        if label.is_empty() || ["-", "1", "none"].contains(&label) {
            return match self.angles.as_slice() {
                [] => AngleUnit::Nothing,
                [first, rest @ ..] if rest.iter().all(|other| other == first) => {
                    AngleUnit::Unit(*first)
                }
                _ => AngleUnit::NotUnderstood,
            };
        }
        PhaseUnit::named(label).map_or(AngleUnit::NotUnderstood, AngleUnit::Unit)
    }
    /// True where the magnitude is in decibels.
    pub(super) fn is_decibel(&self) -> bool {
        self.is_decibel
    }
    /// Unit of the FRF, where the header names one.
    pub(super) fn frf_unit(&self) -> Option<FrfUnit> {
        frf_unit(&self.unit)
    }
}

/// The words of a column name, sorted by meaning.
#[derive(Default)]
struct NameWords {
    parts: Vec<Part>,
    angles: Vec<PhaseUnit>,
    dof_words: DofWords,
    /// The words without a meaning of their own, and the DOFs.
    others: Vec<String>,
    is_decibel: bool,
    is_negative: bool,
    is_lag: bool,
    is_described: bool,
    is_of_measurement: bool,
    /// The word before, in lower case; empty after a DOF.
    last: String,
}

impl NameWords {
    /// Adds a token that follows the token `before`.
    fn add(&mut self, token: &str, before: &str) {
        if self.dof_words.add(token, ["/", "per"].contains(&before)) {
            self.others.push(token.to_lowercase());
            self.last.clear();
            return;
        }
        if token.len() > 2 && token.matches('|').count() == 2 {
            self.parts.push(Part::Magnitude); // |H|
        }
        // `- Im` at the beginning, but not `1Z - Im`
        let is_minus = |text: &str| text.trim_start_matches(MINUS).is_empty();
        let mut has_minus = token.starts_with(MINUS)
            || (!before.is_empty() && is_minus(before) && self.others.is_empty());
        for word in words(token) {
            self.is_decibel |= is_decibel(word);
            let lower = word.to_lowercase();
            if let Some(part) = part_of(word) {
                if NEGATIVE.contains(&self.last.as_str()) {
                    has_minus = true;
                    self.others.pop();
                }
                self.is_negative |= has_minus;
                self.parts.push(part);
            } else if let Some(angle) = PhaseUnit::named(word) {
                self.angles.push(angle);
            } else if lower == LAG {
                self.is_lag = true;
            } else if !is_filler(&lower) {
                self.is_described |= !is_beside_dof(&lower);
                self.is_of_measurement |= is_measurement(&lower);
                self.others.push(lower.clone());
            }
            self.last = lower;
        }
    }
}

/// Settles the DOFs of all columns, of which some words may be DOFs or not.
///
/// `1x` beside other words is a DOF where the columns differ in such words. Else it may be a multiple
/// (`10x`), and is a DOF only in a table of lower-case DOFs or as the only DOF of a single
/// FRF. `5s` alike in all columns is a time.
fn settle_dofs(heads: &mut [ColumnHeader]) {
    let all = heads
        .iter()
        .map(|head| (head.dof_words.loose(), head.base.clone()));
    let loose: Vec<(Vec<Dof>, String)> = all.filter(|(loose, _)| !loose.is_empty()).collect();
    let differ = loose.windows(2).any(|pair| pair[0].0 != pair[1].0);
    let is_one_frf = loose.windows(2).all(|pair| pair[0].1 == pair[1].1);
    let has_lower = heads.iter().any(|head| head.dof_words.has_lower());
    for head in heads {
        let words = &head.dof_words;
        let is_along_x = words
            .loose()
            .iter()
            .all(|dof| dof.direction != Direction::SCALAR);
        let is_alone = is_one_frf && !words.has_firm() && !head.is_of_measurement;
        if head.is_described && !differ && !(is_along_x && (has_lower || is_alone)) {
            head.dof_words.drop_loose();
        }
        head.dofs = head.dof_words.dofs();
    }
}

/// Splits a column name into the words and the unit, which may be that of the unit row.
pub(super) fn name_and_unit<'a>(name: &'a str, unit_row: &str) -> (&'a str, String) {
    let (rest, unit) = split_unit(name);
    if !unit.is_empty() {
        return (rest, unit);
    }
    let (rest, unit) = split_trailing_unit(rest);
    (rest, unit.unwrap_or_else(|| without_brackets(unit_row)))
}

/// A label of a unit row, without brackets around the whole of it.
pub(super) fn without_brackets(label: &str) -> String {
    let label = label.trim();
    let inside = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let inner = label.strip_suffix(close)?;
            (matching_open(inner, open, close) == Some(0)).then(|| inner[1..].trim())
        });
    inside.unwrap_or(label).to_owned()
}

/// Splits `Re(x) [mm/s/N]` into `Re(x)` and `mm/s/N`. Text in round brackets counts where
/// it is a unit, text in square brackets where it is no part of an FRF.
pub(super) fn split_unit(name: &str) -> (&str, String) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(start) = name
            .strip_suffix(close)
            .and_then(|inner| matching_open(inner, open, close))
        {
            let inside = name[start + 1..name.len() - 1].trim();
            let is_set_number = inside.bytes().all(|byte| byte.is_ascii_digit());
            let is_part = words(inside).any(|word| part_of(word).is_some() && !is_decibel(word));
            let is_unit = (open == '[' && !is_part) || looks_like_unit(inside);
            if is_unit && !is_set_number && dof_pair(inside).is_none() {
                return (name[..start].trim(), inside.to_owned());
            }
        }
    }
    (name, String::new())
}

/// Splits a unit without brackets off the end of a name: `mag dB re 1 m/s/N`, `re mm/s/N`,
/// `re_mm_per_s_per_N`, `re_mm_s_N`.
fn split_trailing_unit(name: &str) -> (&str, Option<String>) {
    let starts = name
        .char_indices()
        .zip(std::iter::once(' ').chain(name.chars()))
        .filter(|(_, before)| before.is_whitespace() || "_/,;".contains(*before))
        .map(|((at, _), _)| at);
    for at in starts {
        let (rest, label) = (
            name[..at].trim_end_matches(['_', '/', ' ', ',', ';']),
            &name[at..],
        );
        let lower = label.to_lowercase();
        if lower.starts_with("db") && words(label).next().is_some_and(is_decibel) {
            return (rest, Some(label.to_owned()));
        }
        if !label.contains(['/', '_']) && !label.contains(" per ") {
            continue;
        }
        let spelled = label.replace("_per_", "/").replace(" per ", "/");
        let joined = spelled.replace('_', "/");
        let is_unit = |text: &str| text.contains('/') && frf_unit(text).is_some();
        if let Some(unit) = [spelled, joined].into_iter().find(|text| is_unit(text)) {
            return (rest, Some(unit));
        }
        // a unit, but of no FRF: kept, so that a warning names it
        if label.contains('/') && !label.contains([':', ' ', '_']) && dof_pair(label).is_none() {
            let all_units = label
                .split('/')
                .all(|factor| unit_label::parse(factor).is_some());
            if all_units {
                return (rest, Some(label.to_owned()));
            }
        }
    }
    (name, None)
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
    let label = without_brackets(text);
    let lower = label.to_lowercase();
    ["", "-", "1", "none"].contains(&lower.as_str())
        || lower.starts_with("db")
        || PhaseUnit::named(&label).is_some()
        || frequency_unit(text).is_some()
        || frf_unit(text).is_some()
        || (text.contains('/')
            && !text.contains(':')
            && dof_pair(text).is_none()
            && known_words(text) == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit_label::decibel_reference;

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
            ("H dB", Part::Magnitude, "dB"),
            ("mag_db", Part::Magnitude, "db"),
            ("|H|^2", Part::Unknown, ""),
            ("mag squared", Part::Unknown, ""),
            ("coherence^2", Part::Coherence, ""),
            ("mag [m/s^2/N]", Part::Magnitude, "m/s^2/N"),
            ("|H| m/s²/N", Part::Magnitude, "m/s²/N"),
            ("Magnitude dB re 1 m/s/N", Part::Magnitude, "dB re 1 m/s/N"),
            ("H1 [Re]", Part::Re, ""),
            ("|H|", Part::Magnitude, ""),
            ("Imaginary part of H", Part::Im, ""),
            ("Re / (mm/s/N)", Part::Re, "mm/s/N"),
            ("re_mm_s_N", Part::Re, "mm/s/N"),
            ("re_mm_per_s_per_N", Part::Re, "mm/s/N"),
            ("Re mm/(s*N)", Part::Re, "mm/(s*N)"),
            ("re mm/s", Part::Re, "mm/s"),
            ("Re 12:+Z/101:+Z", Part::Re, ""),
            ("real or imag", Part::Unknown, ""),
            ("ln|H|", Part::Magnitude, ""),
        ] {
            let head = ColumnHeader::parse(name, "");
            assert_eq!((head.part, head.unit.as_str()), (part, unit), "{name}");
        }
    }

    #[test]
    fn units_of_a_phase_in_names_and_labels() {
        use AngleUnit::{NotUnderstood, Nothing, Unit};
        for (name, row, expected) in [
            ("phase", "", Nothing),
            ("phase_rad", "", Unit(PhaseUnit::Radian)),
            ("Phase (radians)", "", Unit(PhaseUnit::Radian)),
            ("phase/deg", "", Unit(PhaseUnit::Degree)),
            ("Phase(°)", "", Unit(PhaseUnit::Degree)),
            ("phase", "rad", Unit(PhaseUnit::Radian)),
            ("phase [mrad]", "", NotUnderstood),
            ("phase", "-", Nothing),
        ] {
            assert_eq!(
                ColumnHeader::parse(name, row).angle(),
                expected,
                "{name} {row}"
            );
        }
    }

    #[test]
    fn a_minus_in_front_of_a_part_counts() {
        for (name, base) in [
            ("-Im [m/s/N]", ""),
            ("- Im", ""),
            ("\u{2212}Im(H)", "h"),
            ("12:+Z -imag", "12:+z"),
            ("1Z_-Im", "1z"),
            ("-1*Im", "1"),
            ("1Z neg. Im", "1z"),
            ("1Z phase lag [deg]", "1z"),
        ] {
            let head = ColumnHeader::parse(name, "");
            assert!(head.is_negative, "{name}");
            assert_eq!(head.base, base, "{name}");
        }
        for name in [
            "1Z - Im",
            "1Z-Im",
            "12:-Z Im",
            "-1Z Im",
            "lag 1 Im",
            "H minus noise Im",
        ] {
            assert!(!ColumnHeader::parse(name, "").is_negative, "{name}");
        }
    }

    #[test]
    fn decibels_need_their_reference() {
        for (name, reference) in [
            ("Mag [dB re 1e-6 m/s/N]", Some((1e-6, "m/s/N"))),
            ("Mag dB re 1e-6 m/s/N", Some((1e-6, "m/s/N"))),
            ("Mag (dB ref 1 (m/s)/N)", Some((1.0, "(m/s)/N"))),
            ("Mag [dB]", None),
        ] {
            let head = ColumnHeader::parse(name, "");
            assert!(head.is_decibel(), "{name}");
            let found = decibel_reference(&head.unit);
            assert_eq!(
                found.map(|(value, _)| value),
                reference.map(|(value, _)| value)
            );
        }
    }
}
