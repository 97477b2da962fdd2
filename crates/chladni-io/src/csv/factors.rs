//! Factors and foreign units in the name of a column, without which its numbers would be read:
//! `re x1e3 [m/s/N]`, `re [10 m/s/N]`, `phase (pi rad)`.
//!
//! Words outside the brackets of a unit are names, but for a product with a power of ten directly
//! before that bracket.

use super::column_header::{split_unit, without_brackets, ColumnHeader};
use super::vocabulary::{part_of, words, Part};
use super::TableFacts;
use crate::unit_label::frf_unit;
use crate::PhaseUnit;
use chladni_frf::{Error, Result};

/// Signs of a product that no name has.
const TIMES: [char; 5] = ['*', '×', '·', '⋅', '∙'];
/// Raised digits, from 0.
const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
/// Words that scale the unit behind them.
const SCALES: [&str; 8] = ["pi", "π", "milli", "micro", "m", "µ", "μ", "u"];
/// Words beside a unit that change nothing.
const FILLERS: [&str; 5] = ["unit", "units", "of", "in", "x"];
/// Units of a phase beside degrees and radians.
const FOREIGN: [&str; 16] = [
    "gon",
    "gons",
    "grad",
    "grads",
    "gradian",
    "gradians",
    "cycle",
    "cycles",
    "turn",
    "turns",
    "rev",
    "revs",
    "revolution",
    "revolutions",
    "arcmin",
    "arcsec",
];

/// Refuses a column, counted from 0, whose name or label in the row of units holds a factor or
/// another unit of a phase.
///
/// # Errors
/// The column and its name.
pub(super) fn refuse_factor(
    column: usize,
    names: &[String],
    units: &[String],
    head: &ColumnHeader,
    facts: &TableFacts,
) -> Result<()> {
    let name = names[column].trim();
    let unit_row = units.get(column).map_or("", String::as_str);
    let (message, expected, help) = match head.part {
        Part::Phase if facts.caller_phase_unit.is_none() && has_foreign_angle(name) => (
            "the phase is in another unit than degrees or radians",
            "phases in degrees or radians, and deg or rad in the header",
            "convert the numbers, and name their unit in the header: `phase [deg]`",
        ),
        Part::Re | Part::Im | Part::Magnitude if has_factor(name, unit_row, head) => (
            "the name of a column holds a factor",
            "numbers in the unit of the header, as in `re [mm/s/N]`",
            "multiply the numbers by the factor or write the unit with its prefix, and take \
             the factor out of the header",
        ),
        _ => return Ok(()),
    };
    let label = match name.contains(&head.unit) {
        true => name.to_owned(),
        false => format!("{name} {}", head.unit),
    };
    let error = Error::bad_data(message).field(format!("column {}", column + 1));
    Err(error.found(label).expected(expected).help(help))
}

/// True for a factor before or in the bracket of the unit; a reference of decibels is none.
fn has_factor(name: &str, unit_row: &str, head: &ColumnHeader) -> bool {
    if head.is_decibel() {
        return false;
    }
    let (before, unit) = split_unit(name);
    match unit.is_empty() {
        true => is_scaled_unit(&without_brackets(unit_row)),
        false => is_scaled_unit(&unit) || ends_with_product(before),
    }
}

/// True for `x1e3`, `*1000`, `x 10^3` and `/1000` at the end of a text.
fn ends_with_product(text: &str) -> bool {
    let signs = text
        .char_indices()
        .filter(|(_, c)| "xX/".contains(*c) || TIMES.contains(c));
    signs.into_iter().any(|(at, sign)| {
        let (left, right) = (&text[..at], text[at + sign.len_utf8()..].trim());
        value(right).is_some_and(|number| {
            is_power_of_ten(number) && is_sign_of_product(sign, left, right, number)
        })
    })
}

/// True unless the number may belong to a name: `x10`, `3/100`, `re/10`, `2**10`.
fn is_sign_of_product(sign: char, left: &str, right: &str, number: f64) -> bool {
    let is_exponential = right.contains(|c| "eE^*".contains(c) || RAISED.contains(&c));
    let last = words(left).last().unwrap_or_default();
    let is_part = part_of(last).is_some() && !last.ends_with(|c: char| c.is_ascii_digit());
    match sign {
        'x' | 'X' => is_exponential && !left.ends_with(char::is_alphanumeric),
        '/' => is_part && (is_exponential || number >= 1000.0),
        _ => !left.ends_with('*'),
    }
}

/// True for the unit of an FRF with a number other than 1: `10 m/s/N`, `m/s/(10 N)`.
fn is_scaled_unit(label: &str) -> bool {
    if frf_unit(label).is_some() {
        return false; // its numbers are exponents, or 1
    }
    let label = label.replace("**", "^");
    let mut is_scaled = false;
    let mut without_numbers = String::new();
    for piece in label.split_inclusive(is_between) {
        let token = piece.trim_end_matches(is_between);
        match value(token.trim_start_matches(['x', 'X'])) {
            Some(number) => {
                is_scaled |= number != 1.0;
                without_numbers.push('1');
                without_numbers.push_str(&piece[token.len()..]);
            }
            None => without_numbers.push_str(piece),
        }
    }
    is_scaled && frf_unit(&without_numbers).is_some()
}

/// True between the factors of a product.
fn is_between(c: char) -> bool {
    c.is_whitespace() || "()[]{}/\\".contains(c) || TIMES.contains(&c)
}

/// `10`, `1e3`, `10^3`, `10**3`, `10³`.
fn value(text: &str) -> Option<f64> {
    let text = text.replace("**", "^");
    let base = text.trim_end_matches(|c| "⁻⁺".contains(c) || RAISED.contains(&c));
    let raised = text[base.len()..].chars().map(|c| match c {
        '⁻' => '-',
        '⁺' => '+',
        _ => RAISED
            .iter()
            .zip('0'..)
            .find(|(it, _)| **it == c)
            .map_or(c, |(_, digit)| digit),
    });
    let raised: String = raised.collect();
    match text.split_once('^') {
        Some((base, power)) => Some(number(base)?.powf(number(power)?)),
        None if raised.is_empty() => number(&text),
        None => Some(number(base)?.powf(number(&raised)?)),
    }
}

/// A number in digits, not `inf` or `nan`.
fn number(text: &str) -> Option<f64> {
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let number = text.parse::<f64>().ok().filter(|_| begins)?;
    number.is_finite().then_some(number)
}

/// True for a power of ten other than 1.
fn is_power_of_ten(number: f64) -> bool {
    let power = number.abs().log10();
    power != 0.0 && power.fract() == 0.0
}

/// True for a name with a bracket of another unit than degrees or radians, and none of these.
fn has_foreign_angle(name: &str) -> bool {
    let is_stated = in_brackets(name).any(|label| PhaseUnit::named(label).is_some());
    !is_stated && in_brackets(name).any(is_foreign)
}

/// The texts in round and square brackets, with those inside.
fn in_brackets(name: &str) -> impl Iterator<Item = &str> {
    name.match_indices(['(', '[']).filter_map(|(at, _)| {
        let inside = &name[at + 1..];
        let mut depth = 1;
        let (end, _) = inside.char_indices().find(|(_, c)| {
            match c {
                '(' | '[' => depth += 1,
                ')' | ']' => depth -= 1,
                _ => {}
            }
            depth == 0
        })?;
        Some(&inside[..end])
    })
}

/// Signs of a unit of phase in a word.
#[derive(Default)]
struct Said {
    angle: bool,
    scale: bool,
    foreign: bool,
}

/// True for degrees or radians with a number, π or a prefix, or another unit alone; false beside
/// other words.
fn is_foreign(label: &str) -> bool {
    let mut all = Said::default();
    for token in label.split(is_between).filter(|token| !token.is_empty()) {
        let Some(said) = said(&token.to_lowercase()) else {
            return false;
        };
        all.angle |= said.angle;
        all.scale |= said.scale;
        all.foreign |= said.foreign;
    }
    match all.angle {
        true => all.scale,
        false => all.foreign && !all.scale,
    }
}

/// Meaning of a word in lower case; `None` for another word.
fn said(word: &str) -> Option<Said> {
    let is_angle = |text: &str| PhaseUnit::named(text).is_some();
    let mut said = Said {
        angle: is_angle(word),
        scale: SCALES.contains(&word),
        foreign: FOREIGN.contains(&word),
    };
    if said.angle || said.scale || said.foreign || FILLERS.contains(&word) {
        return Some(said);
    }
    if let Some(number) = value(word.trim_start_matches('x')) {
        said.scale = number != 1.0;
        return Some(said);
    }
    // `10deg`, `2pi`, `mrad`
    let bare = word.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let is_prefixed = |prefix: &&str| bare.strip_prefix(*prefix).is_some_and(is_angle);
    let has_prefix = SCALES.iter().any(is_prefixed);
    said.angle = has_prefix || is_angle(bare);
    said.scale = has_prefix
        || SCALES.contains(&bare)
        || number(&word[..word.len() - bare.len()]).is_some_and(|number| number != 1.0);
    (said.angle || SCALES.contains(&bare)).then_some(said)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_refused(name: &str) -> bool {
        let (names, head) = ([name.to_owned()], ColumnHeader::parse(name, ""));
        refuse_factor(0, &names, &[], &head, &TableFacts::default()).is_err()
    }

    #[test]
    fn phases_in_other_units_than_degrees_and_radians() {
        for unit in [
            "pi rad",
            "\\pi rad",
            "units of pi rad",
            "milli rad",
            "m rad",
            "mrad",
            "mdeg",
            "2pi rad",
            "rad/(2 pi)",
            "deg x10",
            "deg*10",
            "deg/10",
            "0.1 deg",
            "10deg",
            "1e-3 rad",
            "gon",
            "cycles",
            "rev",
        ] {
            assert!(is_refused(&format!("phase ({unit})")), "{unit}");
            assert!(is_refused(&format!("1Z phase [{unit}]")), "{unit}");
        }
        for name in [
            "phase",
            "phase (deg)",
            "Phase(°)",
            "Phase (radians)",
            "phase_rad",
            "phase rev 2",
            "phase_mrad",
            "phase (rev B)",
            "phase (rev 2)",
            "phase x10 [deg]",
            "phase [rad] (wrapped to +-pi)",
            "phase [deg] (rev B)",
            "phase (deg) (cycle 2)",
            "phase (20 deg C)",
            "phase (±180 deg)",
            "phase (-pi..pi rad)",
            "phase (deg 2 avg)",
            "phase (rad*1)",
            "phase (deg, unwrapped)",
            "phase*180/pi [deg]",
            "Phase(x10) (deg)",
            "Phase(1Z deg)",
            "phase (1:+Z/101:+Z) (deg)",
        ] {
            assert!(!is_refused(name), "{name}");
        }
    }

    #[test]
    fn values_with_a_factor() {
        for name in [
            "re x1e3 [m/s/N]",
            "re x 10^3 [m/s/N]",
            "re x10**3 [m/s/N]",
            "re *1000 (m/s/N)",
            "re*1e-3 [m/s/N]",
            "re × 10 [m/s/N]",
            "mag ·10³ [m/s/N]",
            "re/1000 [m/s/N]",
            "re /1e3 [m/s/N]",
            "re [10 m/s/N]",
            "re [0.001 m/s/N]",
            "re [1e-3 m/s/N]",
            "re [10^-3 m/s^2/N]",
            "re [m/s/N/1000]",
            "re [m/s/(10 N)]",
            "re (1000*m/s/N)",
            "re [m/s/N x1000]",
        ] {
            assert!(is_refused(name), "{name}");
        }
        for name in [
            "re",
            "re x10",
            "x=100 re",
            "re scale 1",
            "re 2^10 lines",
            "re micro-shaker",
            "re x1.0 y2.0",
            "mag x10 avg",
            "point x10 re [m/s/N]",
            "re 1E2",
            "re x10 [m/s/N]",
            "re x1 [m/N]",
            "re *1 [m/N]",
            "re 2**10 [m/N]",
            "re/10 [m/N]",
            "re 3/1000 [m/s/N]",
            "re1/1000 [m/s/N]",
            "re (x1000) [m/s/N]",
            "re [1 m/s/N]",
            "re [1.0 m/s/N]",
            "re [m/s^2/N]",
            "re [m/s**2/N]",
            "re [m s-1 N-1]",
            "re [m s^(-2)/N]",
            "re [10 N]",
            "1Z/101Z re [(1/N)*(m/s²)]",
            "Magnitude (dB re 1 m/s/N)",
            "Magnitude [dB re 1e-6 m/s/N]",
            "re (run 3/10)",
            "re (3x5 grid)",
        ] {
            assert!(!is_refused(name), "{name}");
        }
    }
}
