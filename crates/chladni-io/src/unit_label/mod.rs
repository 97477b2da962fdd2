//! Unit labels as people write them, `m/s/N`, `(m/s)/N`, `m/(s·N)`, `mm/s/V`, `m/s²`,
//! `g/N`: their quantity and their factor to SI.
//!
//! A label is a product of powers of known units. Division associates to the left, as
//! engineers write it: `m/s/N` is (m/s)/N. A label that is not understood gives
//! `None`; nothing is guessed.

mod decibel;
mod parser;

pub(super) use decibel::{decibel_reference, is_decibel_label};
pub(super) use parser::parse;

use crate::limits::SAME_UNIT;
use chladni_frf::{Error, FrfKind, ReferenceUnit, Result};
use std::f64::consts::{PI, TAU};

/// A unit: factor to SI and the powers of m, kg, s, V, rad, cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    /// Multiplies a value in this unit to give SI.
    pub factor: f64,
    /// Powers of m, kg, s, V, rad, cycle.
    pub powers: [i32; 6],
}

const ONE: Unit = Unit {
    factor: 1.0,
    powers: [0; 6],
};
/// g_n of ISO 80000-3, m/s².
pub(super) const STANDARD_GRAVITY: f64 = 9.80665;
/// Pound-force: 0.45359237 kg · g_n, N.
const POUND_FORCE: f64 = 4.448_221_615_260_5;

/// The unit of an FRF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrfUnit {
    pub kind: FrfKind,
    pub reference: ReferenceUnit,
    /// Factor to SI.
    pub to_si: f64,
}

impl FrfUnit {
    /// Refuses another kind that the file states beside this unit with the label `label`.
    ///
    /// # Errors
    /// Bad data in the field `frf_kind`.
    pub(super) fn check_kind(self, kind: FrfKind, label: &str) -> Result<()> {
        if kind == self.kind {
            return Ok(());
        }
        Err(Error::bad_data("frf_kind and unit contradict each other")
            .field("frf_kind")
            .found(format!("{kind} with unit {label}"))
            .expected(format!("{} for that unit", self.kind))
            .help("say which is right with `frf_kind`"))
    }

    /// Refuses another unit of the reference that the file states beside this unit with the
    /// label `label`.
    ///
    /// # Errors
    /// Bad data in the field `reference_unit`.
    pub(super) fn check_reference(self, stated: ReferenceUnit, label: &str) -> Result<()> {
        if stated == self.reference {
            return Ok(());
        }
        Err(
            Error::bad_data("reference_unit and unit contradict each other")
                .field("reference_unit")
                .found(format!("{stated} with unit {label}"))
                .expected(format!("{} for that unit", self.reference))
                .help("correct the one that is wrong"),
        )
    }
}

/// Kind, reference and scale of an FRF's unit label; `None` where it is no motion per
/// newton or volt.
pub(super) fn frf_unit(label: &str) -> Option<FrfUnit> {
    let unit = parse(label)?;
    let (kind, reference) = unit.frf_kind()?;
    Some(FrfUnit {
        kind,
        reference,
        to_si: unit.factor,
    })
}

/// Factor from the unit of a frequency axis to Hz; `None` where the label is no
/// frequency.
pub(super) fn frequency_unit(label: &str) -> Option<f64> {
    parse(label)?.to_hertz()
}

impl Unit {
    fn power(self, exponent: i32) -> Self {
        Self {
            factor: self.factor.powi(exponent),
            powers: self.powers.map(|p| p.saturating_mul(exponent)),
        }
    }
    fn times(self, other: Self) -> Self {
        let mut powers = self.powers;
        for (power, more) in powers.iter_mut().zip(other.powers) {
            *power = power.saturating_add(more);
        }
        Self {
            factor: self.factor * other.factor,
            powers,
        }
    }
    /// This unit per `other`.
    pub(super) fn per(self, other: Self) -> Self {
        self.times(other.power(-1))
    }
    /// FRF kind and reference that this unit measures: a motion per newton or per volt.
    pub(super) fn frf_kind(self) -> Option<(FrfKind, ReferenceUnit)> {
        use FrfKind::{Accelerance, Mobility, Receptance};
        use ReferenceUnit::{Newton, Volt};
        match self.powers {
            // N = kg·m/s²: m/N = s²/kg
            [0, -1, 2, 0, 0, 0] => Some((Receptance, Newton)),
            [0, -1, 1, 0, 0, 0] => Some((Mobility, Newton)),
            [0, -1, 0, 0, 0, 0] => Some((Accelerance, Newton)),
            [1, 0, 0, -1, 0, 0] => Some((Receptance, Volt)),
            [1, 0, -1, -1, 0, 0] => Some((Mobility, Volt)),
            [1, 0, -2, -1, 0, 0] => Some((Accelerance, Volt)),
            _ => None,
        }
    }
    /// The reference that is measured in this unit, without a factor.
    pub(super) fn reference(self) -> Option<ReferenceUnit> {
        let is_si = (self.factor - 1.0).abs() <= SAME_UNIT;
        match self.powers {
            [1, 1, -2, 0, 0, 0] if is_si => Some(ReferenceUnit::Newton),
            [0, 0, 0, 1, 0, 0] if is_si => Some(ReferenceUnit::Volt),
            _ => None,
        }
    }
    /// True for volts with any prefix.
    pub(super) fn is_voltage(self) -> bool {
        self.powers == [0, 0, 0, 1, 0, 0]
    }
    /// Factor to Hz, for a frequency.
    pub(super) fn to_hertz(self) -> Option<f64> {
        match self.powers {
            [0, 0, -1, 0, 1, 0] => Some(self.factor / TAU),
            [0, 0, -1, 0, 0, 0 | 1] => Some(self.factor),
            _ => None,
        }
    }
    /// Factor to s, for a time.
    pub(super) fn to_seconds(self) -> Option<f64> {
        (self.powers == [0, 0, 1, 0, 0, 0]).then_some(self.factor)
    }
}

/// A unit by its name. Names in capitals, as in old files (`M/S**2`), are read where they are
/// unambiguous.
fn named(name: &str) -> Option<Unit> {
    let unit = |factor, powers| Some(Unit { factor, powers });
    match name {
        "m" | "M" | "meter" | "metre" => unit(1.0, [1, 0, 0, 0, 0, 0]),
        "cm" => unit(1e-2, [1, 0, 0, 0, 0, 0]),
        "mm" | "MM" => unit(1e-3, [1, 0, 0, 0, 0, 0]),
        "µm" | "μm" | "um" | "micron" => unit(1e-6, [1, 0, 0, 0, 0, 0]),
        "nm" => unit(1e-9, [1, 0, 0, 0, 0, 0]),
        "pm" => unit(1e-12, [1, 0, 0, 0, 0, 0]),
        "in" | "IN" | "inch" | "\"" => unit(0.0254, [1, 0, 0, 0, 0, 0]),
        "mil" => unit(25.4e-6, [1, 0, 0, 0, 0, 0]),
        "ft" | "FT" => unit(0.3048, [1, 0, 0, 0, 0, 0]),
        "s" | "S" | "sec" | "SEC" => unit(1.0, [0, 0, 1, 0, 0, 0]),
        "ms" => unit(1e-3, [0, 0, 1, 0, 0, 0]),
        "µs" | "μs" | "us" => unit(1e-6, [0, 0, 1, 0, 0, 0]),
        "min" => unit(60.0, [0, 0, 1, 0, 0, 0]),
        "g" | "G" | "gn" => unit(STANDARD_GRAVITY, [1, 0, -2, 0, 0, 0]),
        "mg" => unit(STANDARD_GRAVITY * 1e-3, [1, 0, -2, 0, 0, 0]),
        "kg" => unit(1.0, [0, 1, 0, 0, 0, 0]),
        "N" | "newton" => unit(1.0, [1, 1, -2, 0, 0, 0]),
        "mN" => unit(1e-3, [1, 1, -2, 0, 0, 0]),
        "kN" => unit(1e3, [1, 1, -2, 0, 0, 0]),
        "lbf" | "lb" | "LBF" | "LB" => unit(POUND_FORCE, [1, 1, -2, 0, 0, 0]),
        "kgf" => unit(STANDARD_GRAVITY, [1, 1, -2, 0, 0, 0]),
        "Pa" => unit(1.0, [-1, 1, -2, 0, 0, 0]),
        "V" | "v" | "volt" | "Volt" => unit(1.0, [0, 0, 0, 1, 0, 0]),
        "mV" => unit(1e-3, [0, 0, 0, 1, 0, 0]),
        "kV" => unit(1e3, [0, 0, 0, 1, 0, 0]),
        "Hz" | "HZ" | "hz" | "hertz" => unit(1.0, [0, 0, -1, 0, 0, 1]),
        "kHz" | "khz" | "KHz" | "KHZ" => unit(1e3, [0, 0, -1, 0, 0, 1]),
        "MHz" => unit(1e6, [0, 0, -1, 0, 0, 1]),
        "rpm" | "RPM" => unit(1.0 / 60.0, [0, 0, -1, 0, 0, 1]),
        "cycle" | "cycles" => unit(1.0, [0, 0, 0, 0, 0, 1]),
        "rad" | "RAD" => unit(1.0, [0, 0, 0, 0, 1, 0]),
        "deg" | "°" => unit(PI / 180.0, [0, 0, 0, 0, 1, 0]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use FrfKind::{Accelerance, Mobility, Receptance};
    use ReferenceUnit::{Newton, Volt};

    #[test]
    fn labels_in_every_spelling_give_kind_reference_and_factor() {
        for (label, kind, reference, factor) in [
            ("m/s/N", Mobility, Newton, 1.0),
            ("(m/s)/N", Mobility, Newton, 1.0),
            ("m/(s·N)", Mobility, Newton, 1.0),
            ("m/(s*N)", Mobility, Newton, 1.0),
            ("m / s / N", Mobility, Newton, 1.0),
            ("mm/s/V", Mobility, Volt, 1e-3),
            ("(m/s)/V", Mobility, Volt, 1.0),
            ("µm/s/mV", Mobility, Volt, 1e-3),
            ("m/N", Receptance, Newton, 1.0),
            ("mm/N", Receptance, Newton, 1e-3),
            ("m/s^2/N", Accelerance, Newton, 1.0),
            ("m/s2/N", Accelerance, Newton, 1.0),
            ("(m/s²)/N", Accelerance, Newton, 1.0),
            ("M/S**2/N", Accelerance, Newton, 1.0),
            ("(1/N)*(m/s²)", Accelerance, Newton, 1.0),
            ("1/kg", Accelerance, Newton, 1.0),
            ("g/N", Accelerance, Newton, 9.80665),
            ("m s^-1/N", Mobility, Newton, 1.0),
            ("[m·s⁻²/N]", Accelerance, Newton, 1.0),
            ("[in/s²]/lbf", Accelerance, Newton, 0.0254 / 4.4482216152605),
            ("in/s²/lbf", Accelerance, Newton, 0.0254 / 4.4482216152605),
        ] {
            let unit = frf_unit(label).unwrap_or_else(|| panic!("{label}"));
            assert_eq!((unit.kind, unit.reference), (kind, reference), "{label}");
            assert!(
                (unit.to_si / factor - 1.0).abs() < 1e-12,
                "{label}: {}",
                unit.to_si
            );
        }
    }

    #[test]
    fn motions_alone_have_a_factor_and_no_kind() {
        for (label, factor) in [
            ("m/s", 1.0),
            ("m/s^2", 1.0),
            ("m/s2", 1.0),
            ("m/s²", 1.0),
            ("g", 9.80665),
            ("in/s²", 0.0254),
        ] {
            let unit = parse(label).unwrap();
            assert_eq!(unit.frf_kind(), None, "{label}");
            assert!((unit.factor / factor - 1.0).abs() < 1e-12, "{label}");
        }
    }

    #[test]
    fn frequencies_in_radians_and_kilohertz() {
        for (label, factor) in [
            ("Hz", 1.0),
            ("hz", 1.0),
            ("1/s", 1.0),
            ("cycles/s", 1.0),
            ("kHz", 1e3),
            ("khz", 1e3),
            ("MHz", 1e6),
            ("rad/s", 1.0 / TAU),
            ("rad/sec", 1.0 / TAU),
        ] {
            assert_eq!(frequency_unit(label), Some(factor), "{label}");
        }
        assert_eq!(frequency_unit("mhz"), None, "milli or mega: not guessed");
        assert_eq!(frequency_unit("V"), None);
        assert_eq!(parse("ms").unwrap().to_seconds(), Some(1e-3));
    }

    #[test]
    fn what_is_not_understood_is_none() {
        for label in [
            "",
            "furlong",
            "m/",
            "/s",
            "(m/s",
            "m)",
            "m^",
            "m^x",
            "m s^99",
            "((((((((((m/N))))))))))",
            "m**",
            "²",
            "[m/s",
            "m^/N/",
        ] {
            assert_eq!(parse(label), None, "{label}");
        }
    }

    #[test]
    fn what_is_no_motion_per_force_or_volt_is_no_unit_of_an_frf() {
        for label in ["m", "N/m", "V/V", "m/s", "xyz/N", "rad/s/N"] {
            assert_eq!(frf_unit(label), None, "{label}");
        }
    }
}
