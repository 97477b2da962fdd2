//! Physical checks of an FRF measured where it is driven: kind, sign, time sign and the
//! size of its unit, before any fit.
//!
//! A passive structure takes power in: with e^{+jωt}, Re Y ≥ 0 of the mobility Y at every
//! line, and at a resonance Y is real. Data of another kind are turned by a power of jω,
//! so that Y is imaginary there; a reversed sensor makes it negative. The other time sign
//! is seen first: through a resonance the phase falls, so that Σ Im(Y*_k·Y_{k+1}) < 0.

use crate::driving_points::driving_points;
use crate::limits::{CLEAR, LEAST_LINES, NEAR, PLAUSIBLE_KG};
use crate::{Finding, FrfKind, FrfSet, ReferenceUnit};
use num_complex::Complex64;

/// Findings about the driving points of a set, each with the way out; nothing
/// without a kind or a driving point. References in volts are left alone: what their
/// amplifier does to the phase is nobody's fault.
pub fn driving_point_faults(set: &FrfSet) -> Vec<Finding> {
    let (Some(kind), ReferenceUnit::Newton) = (set.kind, set.reference_unit) else {
        return Vec::new();
    };
    let mut found: Vec<(Fault, Vec<String>)> = Vec::new();
    let mut points = 0;
    for point in driving_points(&set.responses, &set.references) {
        let response = set.responses[point.response];
        let frf = set.values.frf(point.response, point.reference);
        let lines = frf
            .iter()
            .zip(&set.frequency_hz)
            .filter(|(value, &f)| !value.re.is_nan() && f > 0.0);
        let lines: Vec<(f64, Complex64)> = lines
            .map(|(&value, &f)| (std::f64::consts::TAU * f, value * point.sign))
            .collect();
        if lines.len() < LEAST_LINES {
            continue;
        }
        points += 1;
        for fault in faults_of(&lines, kind) {
            match found.iter_mut().find(|(known, _)| *known == fault) {
                Some((_, names)) => names.push(response.to_string()),
                None => found.push((fault, vec![response.to_string()])),
            }
        }
    }
    found
        .into_iter()
        .map(|(fault, names)| {
            let (words, help) = fault.words(kind);
            let place = format!("driving point {} ({} of {points})", names[0], names.len());
            Finding::caution("driving-point", words)
                .help(help)
                .about(place)
        })
        .collect()
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    TimeSign,
    Reversed,
    Kind(FrfKind),
    NoKind,
    Unit { too_light: bool },
}

impl Fault {
    /// The fault, and the next step.
    fn words(self, said: FrfKind) -> (String, String) {
        let (words, help) = match self {
            Self::TimeSign => (
                "the phase rises through the resonances, as with e^(-jωt)".into(),
                "read the file with the other time sign".into(),
            ),
            Self::Reversed => (
                "the structure gives power out: its response or its force points the other way"
                    .into(),
                "correct that direction (a receptance that is called an accelerance looks the \
                 same, and the other way round)"
                    .into(),
            ),
            Self::Kind(kind) => (
                format!("the values are no {said}; they look like {kind}"),
                format!("read the file with `frf_kind {kind}`"),
            ),
            Self::NoKind => (
                format!("the values are no {said}, nor another FRF kind"),
                "look for a channel that is integrated once too often, or turned by a filter"
                    .into(),
            ),
            Self::Unit { too_light } => {
                let limit = match too_light {
                    true => format!("below {:e}", PLAUSIBLE_KG[0]),
                    false => format!("above {:e}", PLAUSIBLE_KG[1]),
                };
                (
                    format!(
                        "an apparent mass |F/a| {limit} kg at most lines: are the units right?"
                    ),
                    "check the units".into(),
                )
            }
        };
        (words, help)
    }
}

/// Faults of one driving-point FRF: (ω, value) of its lines, the direction of the
/// response along that of the force.
fn faults_of(lines: &[(f64, Complex64)], kind: FrfKind) -> Vec<Fault> {
    let mut faults = Vec::new();
    let size = |omega: f64| omega.powi(1 - kind.omega_power());
    // the mobility: of all kinds the one in which resonances stand out most evenly
    let mut y: Vec<Complex64> = lines
        .iter()
        .map(|&(omega, value)| value * size(omega) * Complex64::i().powi(1 - kind.omega_power()))
        .collect();
    let steps = |y: &[Complex64]| -> Vec<f64> {
        y.windows(2)
            .map(|pair| (pair[0].conj() * pair[1]).im)
            .collect()
    };
    let turn = steps(&y);
    let turn = turn.iter().sum::<f64>() / turn.iter().map(|step| step.abs()).sum::<f64>();
    if turn > CLEAR {
        faults.push(Fault::TimeSign);
        let back = |(&(omega, value), y): (&(f64, Complex64), &mut Complex64)| {
            *y = value.conj() * size(omega) * Complex64::i().powi(1 - kind.omega_power());
        };
        lines.iter().zip(&mut y).for_each(back);
    }
    // its mean phase where the phase falls, which is at resonances; elsewhere noise
    // decides the sign of what is small
    let falls: Vec<f64> = steps(&y).into_iter().map(|step| (-step).max(0.0)).collect();
    let middles = || {
        y.windows(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .zip(&falls)
    };
    let mean = middles().map(|(y, fall)| y * fall).sum::<Complex64>()
        / middles().map(|(y, fall)| y.norm() * fall).sum::<f64>();
    let towards = |direction: Complex64| {
        turn.abs() > CLEAR
            && (mean * direction.conj()).re > CLEAR
            && (mean * direction.conj()).arg().abs() < NEAR
    };
    // data with one differentiation more are ahead by 90°
    for (more, direction) in [(1, Complex64::i()), (-1, -Complex64::i())] {
        if towards(direction) {
            let kinds = [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance];
            let other = kinds
                .into_iter()
                .find(|other| other.omega_power() == kind.omega_power() + more);
            faults.push(other.map_or(Fault::NoKind, Fault::Kind));
        }
    }
    if towards(-Complex64::ONE) {
        faults.push(Fault::Reversed);
    }
    faults.extend(implausible_mass(lines, &y));
    faults
}

/// The fault of an apparent mass that no structure has, by the median over the lines of
/// the mobility `y`.
fn implausible_mass(lines: &[(f64, Complex64)], y: &[Complex64]) -> Option<Fault> {
    let mut masses: Vec<f64> = lines
        .iter()
        .zip(y)
        .map(|(line, y)| (line.0 * y.norm()).recip())
        .filter(|mass| mass.is_finite())
        .collect();
    masses.sort_by(f64::total_cmp);
    let &median = masses.get(masses.len() / 2)?;
    let is_plausible = (PLAUSIBLE_KG[0]..PLAUSIBLE_KG[1]).contains(&median);
    (!is_plausible).then_some(Fault::Unit {
        too_light: median < PLAUSIBLE_KG[0],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FrfValues, Geometry};
    use ndarray::{Array1, Array3};

    /// A plate on springs at its driving point: five modes, structural damping, 1 % of
    /// noise; (kind of the values, kind said).
    fn set(written: FrfKind, said: FrfKind, change: impl Fn(Complex64) -> Complex64) -> FrfSet {
        let lines = 400;
        let frequency_hz = Array1::from_iter((0..lines).map(|k| 2.0 + 0.5 * f64::from(k)));
        let mut state = 7_u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            0.01 * ((state >> 33) as f64 / 2_f64.powi(30) - 1.0)
        };
        let values = Array3::from_shape_fn((1, 1, lines as usize), |(_, _, k)| {
            let omega = std::f64::consts::TAU * frequency_hz[k];
            let receptance: Complex64 = [31.0, 54.0, 77.0, 120.0, 171.0]
                .iter()
                .map(|f: &f64| {
                    ((std::f64::consts::TAU * f).powi(2) * Complex64::new(1.0, 0.02)
                        - omega * omega)
                        .inv()
                })
                .sum();
            change(
                receptance
                    * written.from_receptance(omega)
                    * (1.0 + Complex64::new(noise(), noise())),
            )
        });
        FrfSet {
            frequency_hz,
            values: FrfValues::F64(values),
            responses: vec!["5:+Z".parse().unwrap()],
            references: vec!["5:+Z".parse().unwrap()],
            kind: Some(said),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        }
    }

    const KINDS: [FrfKind; 3] = [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance];

    #[test]
    fn a_sound_driving_point_is_not_complained_about() {
        for kind in KINDS {
            assert_eq!(
                driving_point_faults(&set(kind, kind, |value| value)),
                Vec::<Finding>::new(),
                "{kind}"
            );
            // both directions reversed: the same
            let mut turned = set(kind, kind, |value| -value);
            turned.responses = vec!["5:-Z".parse().unwrap()];
            assert_eq!(
                driving_point_faults(&turned),
                Vec::<Finding>::new(),
                "{kind}"
            );
        }
    }

    #[test]
    fn each_fault_is_named_with_its_way_out() {
        for kind in KINDS {
            let one = |change: fn(Complex64) -> Complex64| {
                let found = driving_point_faults(&set(kind, kind, change));
                assert_eq!(found.len(), 1, "{kind}: {found:?}");
                found.into_iter().next().unwrap()
            };
            assert!(one(|value| -value).contains("other way"), "{kind}");
            assert!(
                one(|value| value.conj()).contains("the other time sign"),
                "{kind}"
            );
            assert!(one(|value| value * 1e9).contains("units"), "{kind}");
            assert!(one(|value| value * 1e-12).contains("units"), "{kind}");
        }
    }

    #[test]
    fn a_kind_that_is_one_differentiation_off_is_named() {
        for (written, said) in [(0, 1), (1, 0), (1, 2), (2, 1)] {
            let found = driving_point_faults(&set(KINDS[written], KINDS[said], |value| value));
            assert!(
                found.len() == 1 && found[0].contains(&format!("`frf_kind {}`", KINDS[written])),
                "{found:?}"
            );
        }
        let found =
            driving_point_faults(&set(FrfKind::Receptance, FrfKind::Accelerance, |value| {
                value
            }));
        assert!(
            found[0].contains("receptance that is called an accelerance"),
            "{found:?}"
        );
    }

    #[test]
    fn nothing_is_said_without_a_driving_point_a_kind_or_a_force() {
        let wrong = set(FrfKind::Mobility, FrfKind::Mobility, |value| -value);
        let elsewhere = FrfSet {
            references: vec!["6:+Z".parse().unwrap()],
            ..wrong.clone()
        };
        let unsaid = FrfSet {
            kind: None,
            ..wrong.clone()
        };
        let volts = FrfSet {
            reference_unit: ReferenceUnit::Volt,
            ..wrong
        };
        for set in [elsewhere, unsaid, volts] {
            assert_eq!(driving_point_faults(&set), Vec::<Finding>::new());
        }
    }
}
