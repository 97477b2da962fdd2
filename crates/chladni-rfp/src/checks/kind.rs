//! The wrong FRF kind: mobility called receptance, and the like.
//!
//! Poles are not affected (a factor jω is smooth across a resonance), but every residue is
//! turned by 90° for each differentiation too many or too few. A real shape has residues
//! ψ_iψ_j: real and positive at a driving point, real of either sign elsewhere. Two
//! differentiations reverse the sign, as a reversed sensor does; the terms beside the
//! resonances tell the two apart, since −ω²/(λ − ω²) = 1 − λ/(λ − ω²) and −1/(ω²(λ − ω²)) =
//! −(1/ω² + 1/(λ − ω²))/λ (theory.md, eq. F1).

use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use chladni_frf::{driving_points, Finding, FrfKind, ModalModel, Mode, ReferenceUnit, Severity};
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Looks at the common phase of the residues.
pub(crate) fn wrong_kind(case: &Case) -> Option<Checked> {
    let modes = case.sure_modes();
    let driving = driving_residues(case.model, &modes);
    let declared = case.model.frf_kind;
    let with_driving_point = !driving.is_empty();
    let (phase, count) = phase_of(&modes, &driving)?;
    let turned = |quarters: f64| {
        (phase - quarters * FRAC_PI_2).sin().abs() < limits::KIND_NEAR.sin()
            && (phase - quarters * FRAC_PI_2).cos() > 0.0
    };
    let evidence = format!(
        "the residues of {count} modes {} are turned by {:+.0}° against {declared}",
        if with_driving_point {
            "at the driving points"
        } else {
            "(no driving point: up to their sign)"
        },
        phase.to_degrees()
    );
    let candidates: Vec<FrfKind> = match (with_driving_point, turned(1.0), turned(-1.0)) {
        (true, true, _) => kind_of(declared, 1).into_iter().collect(),
        (true, _, true) => kind_of(declared, -1).into_iter().collect(),
        (false, true, _) | (false, _, true) => [kind_of(declared, -1), kind_of(declared, 1)]
            .into_iter()
            .flatten()
            .collect(),
        (true, ..) if turned(2.0) || turned(-2.0) => {
            return Some(reversed(case.model, &modes, &driving, &evidence))
        }
        _ => return None,
    };
    let names: Vec<&str> = candidates.iter().map(|kind| kind.as_str()).collect();
    // between a voltage and its force stands an amplifier, whose phase is no fault
    let severity = match case.model.reference_unit {
        ReferenceUnit::Newton => Severity::Fault,
        ReferenceUnit::Volt => Severity::Caution,
    };
    let finding = match names.as_slice() {
        [] => turned_channel(severity, &evidence),
        names => wrong(severity, &evidence, &names.join(" or ")),
    };
    Some(finding.value("turn_deg", phase.to_degrees()).into())
}

/// Phase that the residues have in common, and of how many modes: at driving points, or
/// where there are none up to their sign. `None` where they are too few, or do not agree.
fn phase_of(modes: &[&Mode], driving: &[Complex64]) -> Option<(f64, usize)> {
    if driving.len() >= limits::KIND_LEAST_MODES[0] {
        Some((common_phase(driving.iter().copied())?, driving.len()))
    } else if driving.is_empty() && modes.len() >= limits::KIND_LEAST_MODES[1] {
        // squares: the sign of a residue between two points says nothing
        let squares = modes
            .iter()
            .map(|mode| square_sum(&mode.shape.0) * square_sum(&mode.participation.0));
        Some((common_phase(squares)? / 2.0, modes.len()))
    } else {
        None
    }
}

/// The finding of residues turned as no kind of FRF turns them.
fn turned_channel(severity: Severity, evidence: &str) -> Finding {
    let words = format!(
        "{evidence}: a channel is integrated or turned by a filter; real shapes and their scale \
         are wrong"
    );
    Finding::new(severity, "turned-channel", words).help("look at the signal path of the channel")
}

/// The finding of data that look like another kind of FRF.
fn wrong(severity: Severity, evidence: &str, kinds: &str) -> Finding {
    Finding::new(
        severity,
        "wrong-kind",
        format!("wrong FRF kind? {evidence}, as if the data were {kinds}"),
    )
    .help(format!("read them as {kinds}"))
}

/// Residues at the driving points over what they could be at most, one for each mode that
/// shows there.
fn driving_residues(model: &ModalModel, modes: &[&Mode]) -> Vec<Complex64> {
    let points = driving_points(&model.responses, &model.references);
    modes
        .iter()
        .filter_map(|mode| {
            let residues = points.iter().map(|point| {
                point.sign * mode.shape.0[point.response] * mode.participation.0[point.reference]
            });
            let (sum, most) = residues.fold((Complex64::default(), 0.0), |(sum, most), r| {
                (sum + r, most + r.norm())
            });
            (most > 0.0).then(|| sum / most)
        })
        .collect()
}

/// (Σv²)/Σ|v|²: of modulus 1 for a vector of one phase.
pub(super) fn square_sum(values: &[Complex64]) -> Complex64 {
    let total: f64 = values.iter().map(|v| v.norm_sqr()).sum();
    values.iter().map(|v| v * v).sum::<Complex64>() / total.max(f64::MIN_POSITIVE)
}

/// Phase of the mean; `None` where the entries do not agree.
fn common_phase(phasors: impl Iterator<Item = Complex64>) -> Option<f64> {
    let (sum, count) = phasors.fold((Complex64::default(), 0), |(sum, count), p| {
        (sum + p, count + 1)
    });
    let mean = sum / f64::from(count.max(1));
    (mean.norm() > limits::COHERENT).then(|| mean.arg())
}

/// The kind with `more` differentiations.
fn kind_of(declared: FrfKind, more: i32) -> Option<FrfKind> {
    [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance]
        .into_iter()
        .find(|kind| kind.omega_power() == declared.omega_power() + more)
}

/// Negative driving points: two differentiations, or a direction that is reversed.
fn reversed(model: &ModalModel, modes: &[&Mode], driving: &[Complex64], evidence: &str) -> Checked {
    let points = driving_points(&model.responses, &model.references);
    // Σ over driving points of the coefficient of ω^power
    let beside = |power: i32| -> f64 {
        let scale = model.residual_terms.omega_scale_rad_per_s.powi(-power);
        let term = model
            .residual_terms
            .terms
            .iter()
            .filter(|term| term.power == power);
        term.flat_map(|term| {
            points.iter().map(move |point| {
                point.sign * term.matrix.0[[point.response, point.reference]].re * scale
            })
        })
        .sum()
    };
    let of_modes = |power: i32| -> f64 {
        let size = |mode: &Mode| {
            points
                .iter()
                .map(|point| {
                    (mode.shape.0[point.response] * mode.participation.0[point.reference]).norm()
                })
                .sum::<f64>()
        };
        modes
            .iter()
            .map(|mode| size(mode) * (TAU * mode.frequency_hz).powi(power))
            .sum()
    };
    let other = match model.frf_kind {
        FrfKind::Receptance if beside(0) > limits::BESIDE_SHARE * of_modes(-2) => {
            Some(FrfKind::Accelerance)
        }
        FrfKind::Accelerance if beside(-2) < -limits::BESIDE_SHARE * of_modes(0) => {
            Some(FrfKind::Receptance)
        }
        _ => None,
    };
    let finding = match other {
        Some(kind) => wrong(
            Severity::Fault,
            &format!("{evidence}, and so are the residual terms"),
            kind.as_str(),
        ),
        None => Finding::caution(
            "sensor-reversed",
            format!(
                "{evidence} ({} modes negative): a sensor or a driver points the other way, and \
                 mass-scaled shapes come out imaginary",
                driving.len()
            ),
        )
        .help("correct its direction"),
    };
    finding.into()
}
