//! Unit labels as people write them: `m/s/N`, `(m/s)/N`, `m/(s·N)`, `mm/s/V`, `(1/N)*(m/s²)`, `g/N`, `1/kg`.

use crate::{FrfKind, ReferenceUnit};

/// Standard gravity, m/s² (exact by definition); a lone `g` in a unit label of vibration data.
const STANDARD_GRAVITY: f64 = 9.80665;
/// Inch in metres (exact) and pound-force in newtons (exact).
const INCH_M: f64 = 0.0254;
const POUND_FORCE_N: f64 = 4.448_221_615_260_5;

/// What the unit of an FRF says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrfUnit {
    pub(crate) kind: FrfKind,
    pub(crate) reference: ReferenceUnit,
    /// From the label's unit to SI.
    pub(crate) to_si: f64,
}

/// Kind, reference and scale of an FRF's unit label; `None` where it is no motion per force or volt.
pub(crate) fn frf_unit(label: &str) -> Option<FrfUnit> {
    let quantity = quantity(label)?;
    let reference = match (quantity.newton, quantity.volt) {
        (-1, 0) => ReferenceUnit::Newton,
        (0, -1) => ReferenceUnit::Volt,
        _ => return None,
    };
    let kind = match (quantity.metre, quantity.second) {
        (1, 0) => FrfKind::Receptance,
        (1, -1) => FrfKind::Mobility,
        (1, -2) => FrfKind::Accelerance,
        _ => return None,
    };
    Some(FrfUnit { kind, reference, to_si: quantity.factor })
}

/// Factor from the unit of a frequency axis to Hz.
pub(crate) fn frequency_unit(label: &str) -> Option<f64> {
    match label.trim().to_ascii_lowercase().as_str() {
        "hz" | "1/s" | "cycles/s" => Some(1.0),
        "khz" => Some(1e3),
        "mhz" => Some(1e6),
        "rad/s" | "rad/sec" => Some(1.0 / std::f64::consts::TAU),
        _ => None,
    }
}

/// A physical unit: factor to SI and the powers of metre, second, newton and volt.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Quantity {
    factor: f64,
    metre: i32,
    second: i32,
    newton: i32,
    volt: i32,
}

impl Quantity {
    const fn new(factor: f64, metre: i32, second: i32, newton: i32, volt: i32) -> Self {
        Self { factor, metre, second, newton, volt }
    }
    fn power(self, exponent: i32) -> Self {
        Self {
            factor: self.factor.powi(exponent),
            metre: self.metre.saturating_mul(exponent),
            second: self.second.saturating_mul(exponent),
            newton: self.newton.saturating_mul(exponent),
            volt: self.volt.saturating_mul(exponent),
        }
    }
    fn times(self, other: Self) -> Self {
        Self {
            factor: self.factor * other.factor,
            metre: self.metre.saturating_add(other.metre),
            second: self.second.saturating_add(other.second),
            newton: self.newton.saturating_add(other.newton),
            volt: self.volt.saturating_add(other.volt),
        }
    }
}

const ONE: Quantity = Quantity::new(1.0, 0, 0, 0, 0);

fn quantity(label: &str) -> Option<Quantity> {
    let plain: Vec<char> = label
        .trim()
        .chars()
        .filter(|c| !c.is_whitespace())
        .flat_map(|c| match c {
            '²' => vec!['^', '2'],
            '·' | '⋅' | '×' => vec!['*'],
            'µ' | 'μ' => vec!['u'],
            '[' | '{' => vec!['('],
            ']' | '}' => vec![')'],
            other => vec![other],
        })
        .collect();
    let mut parser = Parser { text: &plain, at: 0 };
    let value = parser.product(0)?;
    (parser.at == plain.len() && value.factor.is_finite()).then_some(value)
}

/// Parentheses deeper than this stand in no unit.
const MAX_DEPTH: usize = 8;

struct Parser<'a> {
    text: &'a [char],
    at: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.text.get(self.at).copied()
    }

    /// term { ('*' | '/') term }
    fn product(&mut self, depth: usize) -> Option<Quantity> {
        let mut value = self.term(depth)?;
        while let Some(operator @ ('*' | '/')) = self.peek() {
            self.at += 1;
            let factor = self.term(depth)?;
            value = value.times(if operator == '/' { factor.power(-1) } else { factor });
        }
        Some(value)
    }

    /// ( '(' product ')' | symbol ) [ ['^'] integer ]
    fn term(&mut self, depth: usize) -> Option<Quantity> {
        if depth > MAX_DEPTH {
            return None;
        }
        let base = if self.peek() == Some('(') {
            self.at += 1;
            let inner = self.product(depth + 1)?;
            (self.peek() == Some(')')).then_some(())?;
            self.at += 1;
            inner
        } else if self.peek() == Some('1') {
            self.at += 1;
            return Some(ONE);
        } else {
            let start = self.at;
            while self.peek().is_some_and(char::is_alphabetic) {
                self.at += 1;
            }
            symbol(&self.text[start..self.at].iter().collect::<String>())?
        };
        if self.peek() == Some('^') {
            self.at += 1;
        }
        let negative = self.peek() == Some('-');
        if negative {
            self.at += 1;
        }
        match self.peek().and_then(|c| c.to_digit(10)) {
            Some(digit) => {
                self.at += 1;
                let exponent = digit as i32;
                Some(base.power(if negative { -exponent } else { exponent }))
            }
            None => (!negative).then_some(base),
        }
    }
}

fn symbol(name: &str) -> Option<Quantity> {
    Some(match name {
        "m" => Quantity::new(1.0, 1, 0, 0, 0),
        "cm" => Quantity::new(1e-2, 1, 0, 0, 0),
        "mm" => Quantity::new(1e-3, 1, 0, 0, 0),
        "um" => Quantity::new(1e-6, 1, 0, 0, 0),
        "nm" => Quantity::new(1e-9, 1, 0, 0, 0),
        "pm" => Quantity::new(1e-12, 1, 0, 0, 0),
        "in" | "inch" => Quantity::new(INCH_M, 1, 0, 0, 0),
        "ft" => Quantity::new(12.0 * INCH_M, 1, 0, 0, 0),
        "s" | "sec" => Quantity::new(1.0, 0, 1, 0, 0),
        "ms" => Quantity::new(1e-3, 0, 1, 0, 0),
        "g" | "gn" => Quantity::new(STANDARD_GRAVITY, 1, -2, 0, 0),
        "N" => Quantity::new(1.0, 0, 0, 1, 0),
        "mN" => Quantity::new(1e-3, 0, 0, 1, 0),
        "kN" => Quantity::new(1e3, 0, 0, 1, 0),
        "lbf" | "lb" => Quantity::new(POUND_FORCE_N, 0, 0, 1, 0),
        "V" => Quantity::new(1.0, 0, 0, 0, 1),
        "mV" => Quantity::new(1e-3, 0, 0, 0, 1),
        "kV" => Quantity::new(1e3, 0, 0, 0, 1),
        "kg" => Quantity::new(1.0, -1, 2, 1, 0), // N·s²/m
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use FrfKind::{Accelerance, Mobility, Receptance};
    use ReferenceUnit::{Newton, Volt};

    #[test]
    fn every_spelling_of_formats_section_3_is_read() {
        for (label, kind, reference, to_si) in [
            ("m/N", Receptance, Newton, 1.0),
            ("µm/N", Receptance, Newton, 1e-6),
            ("m/s/N", Mobility, Newton, 1.0),
            ("(m/s)/N", Mobility, Newton, 1.0),
            ("m/(s·N)", Mobility, Newton, 1.0),
            ("mm/s/V", Mobility, Volt, 1e-3),
            ("mm/s/mV", Mobility, Volt, 1.0),
            ("m/s^2/N", Accelerance, Newton, 1.0),
            ("m/s2/N", Accelerance, Newton, 1.0),
            ("(m/s²)/N", Accelerance, Newton, 1.0),
            ("(1/N)*(m/s²)", Accelerance, Newton, 1.0),
            ("g/N", Accelerance, Newton, 9.80665),
            ("1/kg", Accelerance, Newton, 1.0),
            ("[in/s²]/lbf", Accelerance, Newton, 0.0254 / 4.448_221_615_260_5),
            ("m s^-1/N", Receptance, Newton, 0.0), // no operator between m and s: refused below
        ] {
            match frf_unit(label) {
                Some(unit) => {
                    assert_eq!((unit.kind, unit.reference), (kind, reference), "{label}");
                    assert!((unit.to_si - to_si).abs() <= 1e-15 * to_si, "{label}: {}", unit.to_si);
                }
                None => assert_eq!(to_si, 0.0, "{label}"),
            }
        }
    }

    #[test]
    fn what_is_no_motion_per_force_or_volt_is_refused() {
        for label in ["", "m", "N/m", "V/V", "m/s", "((((((((((m/N))))))))))", "m/s/N)", "xyz/N", "m^/N/"] {
            assert_eq!(frf_unit(label), None, "{label}");
        }
    }
}
