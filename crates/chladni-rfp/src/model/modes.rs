//! Modes in SI units, scaled.

use super::pole::Pole;
use crate::screen::Screened;
use crate::structure::Shapes;
use crate::validation::mpc;
use chladni_frf::{ComplexVector, Damping, Mode, Scaling};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Modes in SI units, scaled by a driving point where there is one.
pub(super) fn modes(
    data: &Screened,
    damping: Damping,
    poles: &[Pole],
    shapes: &Shapes,
    variance: f64,
    warnings: &mut Vec<String>,
) -> (Vec<Mode>, Scaling) {
    let kind_power = data.kind.omega_power();
    // (response index, reference index, sign) of driving points
    let driving: Vec<(usize, usize, f64)> = data
        .frf
        .responses
        .iter()
        .enumerate()
        .flat_map(|(i, r)| {
            data.frf
                .references
                .iter()
                .enumerate()
                .filter(move |(_, f)| r.same_axis(**f))
                .map(move |(j, f)| (i, j, r.direction.sign() * f.direction.sign()))
        })
        .collect();
    let massed = !driving.is_empty() && data.frf.reference_unit == chladni_frf::ReferenceUnit::Newton;
    let modes = shapes
        .owner
        .iter()
        .map(|&n| &poles[n])
        .enumerate()
        .map(|(n, pole)| {
            // R in receptance units: structural ω_max²(λ − x); viscous r·2jω_d
            let scale = match damping {
                Damping::Structural => Complex64::new(data.rms * data.omega_max.powi(2 - kind_power), 0.0),
                Damping::Viscous => Complex64::new(0.0, 2.0 * pole.value.im * data.rms * data.omega_max.powi(2 - kind_power)),
            };
            let mut shape: Vec<Complex64> = shapes.shape.row(n).to_vec();
            let mut participation: Vec<Complex64> = shapes.participation.row(n).iter().map(|v| v * scale).collect();
            let factor = if massed {
                // t² = Σ sign·conj(s)·L / Σ|s|² makes shape·t and participation/t agree at the driving points
                let up: Complex64 = driving.iter().map(|&(i, j, sign)| shape[i].conj() * participation[j] * sign).sum();
                let down: f64 = driving.iter().map(|&(i, _, _)| shape[i].norm_sqr()).sum();
                if down > 0.0 {
                    (up / down).sqrt()
                } else {
                    Complex64::new(1.0, 0.0)
                }
            } else {
                let largest = shape.iter().copied().max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr())).unwrap_or_default();
                if largest.norm() > 0.0 {
                    largest.inv()
                } else {
                    Complex64::new(1.0, 0.0)
                }
            };
            let mut deviation: Vec<f64> = shapes.shape_variance.row(n).iter().map(|v| (variance * v).sqrt() * factor.norm()).collect();
            shape.iter_mut().for_each(|v| *v *= factor);
            participation.iter_mut().for_each(|v| *v /= factor);
            deviation.iter_mut().for_each(|v| {
                if !v.is_finite() {
                    *v = 0.0
                }
            });
            mode(data, pole, ComplexVector(shape), deviation, ComplexVector(participation))
        })
        .collect();
    if !massed {
        warnings.push(match data.frf.reference_unit {
            chladni_frf::ReferenceUnit::Volt => "shapes are not mass-scaled: the references are voltages".into(),
            chladni_frf::ReferenceUnit::Newton => {
                "shapes are not mass-scaled: no response is measured at a reference (driving point)".to_string()
            }
        });
    }
    (modes, if massed { Scaling::UnitModalMass } else { Scaling::Unscaled })
}

/// A rejected pole as it is listed: no shape, no part in the synthesis.
pub(super) fn rejected_mode(data: &Screened, pole: &Pole) -> Mode {
    let zeros = |count| ComplexVector(vec![Complex64::default(); count]);
    let (responses, references) = (data.frf.responses.len(), data.frf.references.len());
    mode(data, pole, zeros(responses), vec![0.0; responses], zeros(references))
}

/// A pole in Hz with its shape.
fn mode(data: &Screened, pole: &Pole, shape: ComplexVector, shape_std: Vec<f64>, participation: ComplexVector) -> Mode {
    let hz = data.omega_max / TAU;
    let frequency_hz = pole.omega * hz;
    Mode {
        frequency_hz,
        frequency_std_hz: pole.omega_std * hz,
        loss_factor: pole.loss_factor,
        loss_factor_std: pole.loss_factor_std,
        damping_ratio: 0.5 * pole.loss_factor,
        in_band: frequency_hz >= data.band_hz[0] && frequency_hz <= data.band_hz[1],
        trust: pole.grade.0,
        reasons: pole.grade.1.clone(),
        mpc: mpc(&shape.0),
        shape,
        shape_std,
        participation,
    }
}
