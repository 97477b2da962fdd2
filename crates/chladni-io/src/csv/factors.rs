//! Factors and foreign units in the name of a column, without which its numbers would be read:
//! `re x1e3 [m/s/N]`, `phase (pi rad)`, `phase_mrad`.

use super::column_header::{name_and_unit, ColumnHeader};
use super::vocabulary::{part_of, words, Part};
use crate::PhaseUnit;
use chladni_frf::{Dof, Error, Result};

/// Signs of a product.
const TIMES: [char; 5] = ['*', '×', '·', '⋅', '∙'];
/// Words for a power of ten.
const POWERS: [&str; 14] = [
    "milli",
    "micro",
    "nano",
    "kilo",
    "mega",
    "thousand",
    "thousands",
    "thousandth",
    "thousandths",
    "tenth",
    "tenths",
    "hundredths",
    "percent",
    "ppm",
];
/// Words before the number of a factor.
const SCALED: [&str; 6] = [
    "times",
    "factor",
    "scale",
    "scaled",
    "multiplied",
    "divided",
];
/// Prefixes of a unit of a phase.
const PREFIXES: [&str; 13] = [
    "milli", "micro", "nano", "centi", "kilo", "m", "µ", "μ", "u", "n", "c", "d", "k",
];
/// Units of a phase beside degrees and radians.
const FOREIGN: [&str; 21] = [
    "gon",
    "gons",
    "grad",
    "grads",
    "grade",
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
    "mil",
    "mils",
    "quadrant",
    "quadrants",
];
/// Conversions in a name, which make degrees or radians of the other.
const TO_DEGREES: [&str; 2] = ["180/pi", "180/π"];
const TO_RADIANS: [&str; 2] = ["pi/180", "π/180"];

/// The names of the columns of a table and the row of their units.
pub(super) struct Names<'a> {
    names: &'a [String],
    units: &'a [String],
    counts_channels: bool,
}

impl<'a> Names<'a> {
    /// `units` is empty in a table without such a row.
    pub(super) fn new(names: &'a [String], units: &'a [String]) -> Self {
        Self {
            names,
            units,
            counts_channels: count_channels(names),
        }
    }

    /// Refuses a column whose name or unit hold a factor or another unit of a phase.
    ///
    /// # Errors
    /// The column, counted from 0, and its name.
    pub(super) fn refuse_factor(&self, column: usize, head: &ColumnHeader) -> Result<()> {
        let name = &self.names[column];
        let unit_row = self.units.get(column).map_or("", String::as_str);
        if head.part == Part::Coherence || !self.has_factor(name, unit_row, head) {
            return Ok(());
        }
        let label = match name.contains(&head.unit) {
            true => name.trim().to_owned(),
            false => format!("{name} {}", head.unit).trim().to_owned(),
        };
        let (message, expected, help) = match head.part {
            Part::Phase => (
                "the phase is in another unit than degrees or radians",
                "phases in degrees or radians, and deg or rad in the header",
                "convert the numbers, and name their unit in the header: `phase [deg]`",
            ),
            _ => (
                "the name of a column holds a factor",
                "numbers in the unit of the header, as in `re [mm/s/N]`",
                "multiply the numbers by the factor or write the unit with its prefix, and take \
                 the factor out of the header",
            ),
        };
        let error = Error::bad_data(message).field(format!("column {}", column + 1));
        Err(error.found(label).expected(expected).help(help))
    }

    fn has_factor(&self, name: &str, unit_row: &str, head: &ColumnHeader) -> bool {
        let (rest, unit) = name_and_unit(name, unit_row);
        // a reference of decibels is no factor
        let is_scaled = |text: &str| !head.is_decibel() && holds_factor(text, self.counts_channels);
        let is_foreign = head.part == Part::Phase && is_foreign_angle(rest, &unit);
        is_foreign || is_scaled(rest) || is_scaled(&unit)
    }
}

/// True for names of which one counts channels behind an `x` or a `/`: `x12`, `re/7`. Then `x10`
/// is a channel, too.
fn count_channels(names: &[String]) -> bool {
    let counts = |word: &str| {
        let number = word.strip_prefix(['x', '/']).unwrap_or_default();
        let is_whole = number.bytes().all(|byte| byte.is_ascii_digit());
        !number.is_empty() && is_whole && number != "1" && !is_power_of_ten(number)
    };
    let words = names.iter().flat_map(|name| {
        let name = name.as_str();
        let slashes = name.match_indices('/').map(move |(at, _)| &name[at..]);
        slashes.chain(name.split(|c: char| !c.is_alphanumeric()))
    });
    words.into_iter().any(counts)
}

/// A piece of a name between blanks and brackets.
struct Token<'a> {
    text: &'a str,
    /// True directly behind the bracket of a call: `x10` of `Re(x10)`.
    is_argument: bool,
    /// True directly behind an opening or a closing bracket.
    is_behind_bracket: bool,
}

fn tokens(name: &str) -> Vec<Token<'_>> {
    let is_cut = |c: char| c.is_whitespace() || "()[]{}_,;=".contains(c);
    let cut = name.split(is_cut).filter(|text| !text.is_empty());
    cut.map(|text| {
        let at = text.as_ptr() as usize - name.as_ptr() as usize;
        let mut before = name[..at].chars().rev();
        let last = before.next();
        let is_open = last.is_some_and(|c| "([{".contains(c));
        Token {
            text,
            is_argument: is_open && before.next().is_some_and(|c| !c.is_whitespace()),
            is_behind_bracket: is_open || last.is_some_and(|c| ")]}".contains(c)),
        }
    })
    .collect()
}

/// True for a name with a factor: `x1e3`, `*1000`, `1e-3*re`, `10^3`, `scaled by 100`, `/1000`,
/// `milli`. Whole numbers behind an `x` are channels where `counts_channels`.
fn holds_factor(name: &str, counts_channels: bool) -> bool {
    let tokens = tokens(name);
    let text = |at: usize| tokens.get(at).map_or("", |token| token.text);
    (0..tokens.len()).any(|at| {
        let (token, before, next) = (&tokens[at], text(at.wrapping_sub(1)), text(at + 1));
        is_product(token.text, before, next)
            || is_multiple(token, before, next, counts_channels)
            || is_quotient(token, before, next, counts_channels)
            || is_exponential(token.text)
            || is_said(token.text, &tokens[at + 1..])
    })
}

/// `*1000`, `1e3*re`, `re × 10`; a factor 1 or −1 changes no number but its sign.
fn is_product(token: &str, before: &str, next: &str) -> bool {
    let Some((left, right)) = token.split_once(TIMES) else {
        return false;
    };
    if right.starts_with('*') {
        return false; // a power
    }
    let left = if left.is_empty() { before } else { left };
    let right = if right.is_empty() { next } else { right };
    let counts = |text: &str| is_number(text) && !["1", "-1", "+1"].contains(&text);
    counts(left) || counts(right) || is_exponential(left) || is_exponential(right)
}

/// `x1000`, `x 0.1`.
fn is_multiple(token: &Token<'_>, before: &str, next: &str, counts_channels: bool) -> bool {
    if token.text.eq_ignore_ascii_case("x") {
        return !token.is_behind_bracket && !is_number(before) && is_scale(next);
    }
    let Some(number) = token.text.strip_prefix(['x', 'X']) else {
        return false;
    };
    let is_channel = is_power_of_ten(number) && (counts_channels || token.is_argument);
    is_scale(number) && !is_channel
}

/// `re/1000`, `(rad) / 180`.
fn is_quotient(token: &Token<'_>, before: &str, next: &str, counts_channels: bool) -> bool {
    let Some((left, right)) = token.text.split_once('/') else {
        return false;
    };
    let left = if left.is_empty() { before } else { left };
    let right = if right.is_empty() { next } else { right };
    let last = words(left).last().unwrap_or_default();
    let is_part = part_of(last).is_some() || PhaseUnit::named(last).is_some();
    let is_half_turn = ["180", "360"].contains(&right);
    let is_channel = counts_channels && is_power_of_ten(right);
    is_part && (is_scale(right) || is_half_turn) && !is_channel
}

/// `scaled by 100`, `kilo`.
fn is_said(token: &str, behind: &[Token<'_>]) -> bool {
    let lower = token.to_lowercase();
    let mut behind = behind.iter().map(|token| token.text);
    let number = behind.find(|text| !["by", "of", "is", ":"].contains(text));
    let is_scaled = SCALED.contains(&lower.trim_end_matches(':'));
    words(&lower).any(|word| POWERS.contains(&word)) || is_scaled && number.is_some_and(is_number)
}

fn is_number(text: &str) -> bool {
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    begins && text.parse::<f64>().is_ok()
}

/// `10`, `100`, `1000`, ...
fn is_power_of_ten(text: &str) -> bool {
    let zeros = text.strip_prefix('1').unwrap_or_default();
    !zeros.is_empty() && zeros.bytes().all(|byte| byte == b'0')
}

/// `1e3`, `10^3`, `10**3`, `10³`.
fn is_exponential(text: &str) -> bool {
    let power = text.split_once('^').or_else(|| text.split_once("**"));
    let of_power = power.is_some_and(|(base, power)| is_number(base) && is_number(power));
    let base = text.trim_end_matches(|c| "⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c));
    let of_raised = base.len() < text.len() && is_number(base);
    of_power || of_raised || (is_number(text) && text.contains(['e', 'E']))
}

/// True for a number that scales, and counts nothing.
fn is_scale(text: &str) -> bool {
    is_exponential(text) || is_power_of_ten(text) || (is_number(text) && text.contains('.'))
}

/// True for the name and the unit of a phase in another unit than degrees or radians: `pi rad`,
/// `mrad`, `gon`, `(0.1 deg)`.
fn is_foreign_angle(name: &str, unit: &str) -> bool {
    let angles: Vec<PhaseUnit> = [name, unit]
        .into_iter()
        .flat_map(words)
        .filter_map(PhaseUnit::named)
        .collect();
    let mut name = name.to_lowercase();
    for (conversions, of) in [
        (TO_DEGREES, PhaseUnit::Degree),
        (TO_RADIANS, PhaseUnit::Radian),
    ] {
        if angles.iter().all(|angle| *angle == of) {
            conversions
                .iter()
                .for_each(|text| name = name.replace(text, " "));
        }
    }
    let all = format!("{name} [{unit}]");
    let has_angle = !angles.is_empty();
    words(&all).any(|word| is_part_of_angle(&word.to_lowercase()))
        || (!has_angle && words(&all).any(is_foreign))
        || in_brackets(&all).any(is_foreign_label)
        || has_scaled_angle(&name)
}

fn is_foreign(word: &str) -> bool {
    FOREIGN.contains(&word.to_lowercase().as_str())
}

/// `pi`, `2pi`, `mrad`, `10deg`, in lower case.
fn is_part_of_angle(word: &str) -> bool {
    let behind_digits = word.trim_start_matches(|c: char| c.is_ascii_digit());
    let is_angle = |text: &str| PhaseUnit::named(text).is_some();
    let is_prefixed = |prefix: &str| word.strip_prefix(prefix).is_some_and(is_angle);
    ["pi", "π"].contains(&behind_digits)
        || (behind_digits.len() < word.len() && is_angle(behind_digits))
        || PREFIXES.iter().any(|prefix| is_prefixed(prefix))
}

/// The texts in the innermost brackets, cut at commas.
fn in_brackets(name: &str) -> impl Iterator<Item = &str> {
    let inner = name.match_indices(['(', '[', '{']).filter_map(|(at, _)| {
        let inside = &name[at + 1..];
        let end = inside.find([')', ']', '}', '(', '[', '{'])?;
        let is_closed = inside[end..].starts_with([')', ']', '}']);
        is_closed.then(|| &inside[..end])
    });
    inner.flat_map(|inside| inside.split([',', ';']))
}

/// True for a label of an angle with a number or a prefix, or of a foreign unit.
fn is_foreign_label(label: &str) -> bool {
    let words: Vec<&str> = words(label).collect();
    if words.iter().any(|word| is_foreign(word)) {
        return true;
    }
    let is_angle = |word: &str| PhaseUnit::named(word).is_some();
    let scales = |word: &str| {
        let number = word.strip_prefix(['x', 'X']).unwrap_or(word);
        number.starts_with(|c: char| c.is_ascii_digit()) && word.parse::<Dof>().is_err()
    };
    let is_prefixed = words
        .windows(2)
        .any(|pair| PREFIXES.contains(&pair[0].to_lowercase().as_str()) && is_angle(pair[1]));
    words.iter().any(|word| is_angle(word))
        && (is_prefixed || words.iter().any(|word| scales(word)))
}

/// `m rad` and `0.1 deg` without brackets.
fn has_scaled_angle(name: &str) -> bool {
    let words: Vec<&str> = name.split_whitespace().collect();
    words.windows(2).any(|pair| {
        let is_decimal = is_number(pair[0]) && pair[0].contains('.');
        let is_prefix = ["m", "µ", "μ", "u"].contains(&pair[0]);
        PhaseUnit::named(pair[1]).is_some() && (is_decimal || is_prefix)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has_factor(name: &str) -> bool {
        let (names, head) = ([name.to_owned()], ColumnHeader::parse(name, ""));
        Names::new(&names, &[]).refuse_factor(0, &head).is_err()
    }

    #[test]
    fn phases_in_other_units_than_degrees_and_radians() {
        for name in [
            "phase (pi rad)",
            "phase (\\pi rad)",
            "phase (units of pi rad)",
            "phase (milli rad)",
            "phase (m rad)",
            "phase m rad",
            "phase (deg x10)",
            "phase (deg*10)",
            "phase (0.1 deg)",
            "phase 0.1 deg",
            "phase pi*rad",
            "phase in 2pi rad",
            "phase (rad) / (2 pi)",
            "phase (rad)/pi",
            "phase (gon)",
            "phase (mrad)",
            "phase_mrad",
            "phase (cycles)",
            "phase in cycles",
            "phase [pi rad]",
            "phase [gon]",
            "phase [0.1 deg]",
            "1Z phase (mdeg) 5s record",
            "phase (deg) x10",
            "phase x0.1 [deg]",
            "phase*180/pi [rad]",
            "phase (deg/10)",
            "phase (10 deg)",
        ] {
            assert!(has_factor(name), "{name}");
        }
        for name in [
            "phase",
            "phase (deg)",
            "Phase(°)",
            "Phase (radians)",
            "phase_rad",
            "phase/deg",
            "-phase [deg]",
            "-1*phase [deg]",
            "1Z phase lag [deg]",
            "phase 3 [deg]",
            "phase_12_deg",
            "phase 12 deg",
            "phase (deg, unwrapped)",
            "phase (deg) 10x avg",
            "12:+Z/101:+Z phase [rad]",
            "1Z/101Z phase (deg)",
            "Phase(H1) (deg)",
            "Phase(x10) (deg)",
            "phase*180/pi [deg]",
            "phase, cycle 3 (deg)",
            "phase [-]",
            "Phase(1Z deg)",
            "phase (1:+Z/101:+Z) (deg)",
        ] {
            assert!(!has_factor(name), "{name}");
        }
    }

    #[test]
    fn values_with_a_factor() {
        for name in [
            "re x1e3 [m/s/N]",
            "re *1000 (m/s/N)",
            "re (x1000) [m/s/N]",
            "re x 1000 [m/s/N]",
            "re × 10 [m/s/N]",
            "1e3*re [m/s/N]",
            "re 10^3 [m/s/N]",
            "re 10³ [m/s/N]",
            "mag x10 [m/s/N]",
            "re/1000 [m/s/N]",
            "re scaled by 100 [m/s/N]",
            "re [1e-3 m/s/N]",
            "re (1000*m/s/N)",
            "re milli [m/s/N]",
        ] {
            assert!(has_factor(name), "{name}");
        }
        for name in [
            "re",
            "re1",
            "Re(x) [mm/s/N]",
            "Re(x10) [mm/s/N]",
            "re x1 [m/N]",
            "re x2/f1 [m/N]",
            "x12 re",
            "-1*Im",
            "Re 10x avg",
            "Re 5s record",
            "re 3/101 [m/s/N]",
            "1Z/101Z re [(1/N)*(m/s²)]",
            "re [m/s^2/N]",
            "re [m/s**2/N]",
            "re m/(s*N)",
            "Magnitude (dB re 1e-6 m/s/N)",
            "20*log10(|H|)",
            "Re(x) 1",
            "re (3x5 grid)",
            "H1 re 100",
        ] {
            assert!(!has_factor(name), "{name}");
        }
        let counted = ["f", "re x9", "re x10", "re/101"].map(String::from);
        let names = Names::new(&counted, &[]);
        for (column, name) in counted.iter().enumerate() {
            let head = ColumnHeader::parse(name, "");
            assert!(names.refuse_factor(column, &head).is_ok(), "{name}");
        }
    }
}
