//! FRFs of a drawn structure: modal sums of its own, noise, and what goes wrong.

use super::draw::Draw;
use super::random::Random;
use super::structure::structure;
use chladni_frf::{Damping, FrfSet, FrfValues, Geometry, ModalModel, Mode, Result};
use ndarray::{Array1, Array3, ArrayViewMut1};
use num_complex::{Complex32, Complex64};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Streams of random numbers.
const NOISE: u64 = 4;
const FAULTS: u64 = 5;
/// Size of a spoilt value over the rms of all.
const SPOILT: f64 = 30.0;

/// A measurement with its truth.
pub(super) struct Measurement {
    pub frf: FrfSet,
    pub truth: ModalModel,
    /// E|n|² of the noise of each FRF, (response, reference) by turns.
    pub noise_variance: Vec<f64>,
    /// Mean energy of tones over that of the noise.
    pub tones: f64,
}

/// Measures the structure.
///
/// # Errors
/// None for what [`Draw::new`] draws.
pub(super) fn measurement(draw: &Draw) -> Result<Measurement> {
    let (truth, frequency_hz) = structure(draw);
    let mut values = synthesis(draw, &truth, &frequency_hz);
    let noise_variance = noise(draw, &mut values);
    faults(draw, &truth, &frequency_hz, &noise_variance, &mut values);
    let tones = match draw.tones > 0.0 {
        true => tones(draw, &frequency_hz).len() as f64 / frequency_hz.len() as f64,
        false => 0.0,
    };
    let tones = 2.0 * draw.tones.powi(2) * tones;
    let values = match draw.single {
        true => FrfValues::F32(values.mapv(|v| Complex32::new(v.re as f32, v.im as f32))),
        false => FrfValues::F64(values),
    };
    let frf = FrfSet {
        frequency_hz,
        values,
        responses: truth.responses.clone(),
        references: truth.references.clone(),
        kind: Some(draw.kind),
        reference_unit: truth.reference_unit,
        coherence: None,
        variance: None,
        geometry: Geometry::default(),
        estimation: None,
    };
    Ok(Measurement {
        frf: frf.checked()?,
        truth,
        noise_variance,
        tones,
    })
}

/// FRFs without noise, axes (response, reference, line).
fn synthesis(draw: &Draw, truth: &ModalModel, frequency_hz: &Array1<f64>) -> Array3<Complex64> {
    let (responses, references) = (truth.responses.len(), truth.references.len());
    let omega: Vec<f64> = frequency_hz.iter().map(|f| TAU * f).collect();
    let kind: Vec<Complex64> = omega
        .iter()
        .map(|&w| draw.kind.from_receptance(w))
        .collect();
    let mut values = Array3::zeros((responses, references, omega.len()));
    for mode in &truth.modes {
        let mut lines = lines(mode, 0.0, draw.law, &omega, &kind);
        let size = mean_square(mode);
        for i in 0..responses {
            if draw.roving_mass > 0.0 {
                let moved = -draw.roving_mass * mode.shape.0[i].norm_sqr() / size;
                lines = self::lines(mode, moved, draw.law, &omega, &kind);
            }
            for j in 0..references {
                let residue = mode.shape.0[i] * mode.participation.0[j];
                add(values.slice_mut(ndarray::s![i, j, ..]), residue, &lines);
            }
        }
    }
    for term in &truth.residual_terms.terms {
        let scale = truth.residual_terms.omega_scale_rad_per_s;
        for ((i, j, k), value) in values.indexed_iter_mut() {
            *value += kind[k] * term.matrix.0[[i, j]] * (omega[k] / scale).powi(term.power);
        }
    }
    values
}

fn mean_square(mode: &Mode) -> f64 {
    let sum: f64 = mode.shape.0.iter().map(|v| v.norm_sqr()).sum();
    sum / mode.shape.0.len() as f64
}

/// The columns that a residue and its conjugate multiply, line by line; `moved`: shift of
/// the natural frequency in half-bandwidths.
fn lines(
    mode: &Mode,
    moved: f64,
    law: Damping,
    omega: &[f64],
    kind: &[Complex64],
) -> Vec<[Complex64; 2]> {
    let own = TAU * mode.frequency_hz * (1.0 + 0.5 * moved * mode.loss_factor);
    let eta = mode.loss_factor;
    let of_line = |(&w, &kind): (&f64, &Complex64)| match law {
        Damping::Structural => {
            let receptance = Complex64::new(own * own - w * w, eta * own * own).inv();
            [kind * receptance, Complex64::ZERO]
        }
        Damping::Viscous => {
            let damped = own * (1.0 - 0.25 * eta * eta).sqrt();
            // jω − s and jω − s*
            let near = Complex64::new(0.5 * eta * own, w - damped);
            let far = Complex64::new(0.5 * eta * own, w + damped);
            let over = Complex64::new(0.0, 2.0 * damped);
            [kind / (over * near), -kind / (over * far)]
        }
    };
    omega.iter().zip(kind).map(of_line).collect()
}

fn add(mut values: ArrayViewMut1<Complex64>, residue: Complex64, lines: &[[Complex64; 2]]) {
    for (value, [own, conjugate]) in values.iter_mut().zip(lines) {
        *value += residue * own + residue.conj() * conjugate;
    }
}

fn mean_square_of(values: &Array3<Complex64>) -> f64 {
    values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64
}

/// Adds circular noise, of one size or of one for each FRF; returns its variances.
fn noise(draw: &Draw, values: &mut Array3<Complex64>) -> Vec<f64> {
    let mut random = Random::new(draw.seed, NOISE);
    let deviation = (mean_square_of(values) * 10f64.powf(-0.1 * draw.snr_db)).sqrt();
    let (responses, references, _) = values.dim();
    let mut factors = |count: usize| -> Vec<f64> {
        (0..count)
            .map(|_| (draw.uneven_noise * FRAC_1_SQRT_2 * random.normal()).exp())
            .collect()
    };
    let (own, other) = (factors(responses), factors(references));
    let mut variance = Vec::with_capacity(responses * references);
    for (pair, mut lines) in values.rows_mut().into_iter().enumerate() {
        let deviation = deviation * own[pair / references] * other[pair % references];
        for value in &mut lines {
            let draw = Complex64::new(random.normal(), random.normal());
            *value += draw * (deviation * FRAC_1_SQRT_2);
        }
        variance.push(deviation * deviation);
    }
    variance
}

/// Adds the other faults that the draw asks for.
fn faults(
    draw: &Draw,
    truth: &ModalModel,
    frequency_hz: &Array1<f64>,
    noise_variance: &[f64],
    values: &mut Array3<Complex64>,
) {
    let mut random = Random::new(draw.seed, FAULTS);
    let references = truth.references.len();
    for (pair, mut lines) in values.rows_mut().into_iter().enumerate() {
        let turn = |f: f64| -draw.delay_deg * f / truth.band_hz[1] + draw.phase_deg;
        if draw.delay_deg != 0.0 || draw.phase_deg != 0.0 {
            for (value, &f) in lines.iter_mut().zip(frequency_hz) {
                *value *= Complex64::from_polar(1.0, turn(f).to_radians());
            }
        }
        if draw.tones > 0.0 {
            for k in tones(draw, frequency_hz) {
                let size = draw.tones * noise_variance[pair].sqrt();
                lines[k] += Complex64::new(random.normal(), random.normal()) * size;
            }
        }
    }
    let spoilt = SPOILT * mean_square_of(values).sqrt();
    for _ in 0..draw.spoilt_values {
        let [i, k] =
            [truth.responses.len(), frequency_hz.len()].map(|count| random.count([1, count]) - 1);
        let j = random.count([1, references]) - 1;
        values[[i, j, k]] = Complex64::from_polar(spoilt, random.even([0.0, TAU]));
    }
}

/// Lines nearest to the multiples of the mains' frequency.
fn tones(draw: &Draw, frequency_hz: &Array1<f64>) -> Vec<usize> {
    let (low, high) = (frequency_hz[0], frequency_hz[frequency_hz.len() - 1]);
    let mut lines: Vec<usize> = (1..)
        .map(|n| draw.mains_hz * f64::from(n))
        .skip_while(|f| *f < low)
        .take_while(|f| *f <= high)
        .map(|f| frequency_hz.iter().take_while(|line| **line < f).count())
        .collect();
    lines.retain(|&k| k < frequency_hz.len());
    lines.dedup();
    lines
}

#[cfg(test)]
mod tests {
    use super::super::draw::{Difficulty, Draw};
    use super::*;

    /// A small calm draw of the law.
    fn small(law: Damping) -> Draw {
        Draw {
            law,
            responses: 3,
            references: 2,
            modes: 3,
            complexity: 0.3,
            single: false,
            snr_db: f64::INFINITY,
            ..Draw::new(5, Difficulty::Calm)
        }
    }

    #[test]
    fn the_truth_as_a_file_has_it_synthesises_the_measurement() {
        for law in [Damping::Structural, Damping::Viscous] {
            let Measurement { frf, truth, .. } = measurement(&small(law)).unwrap();
            let synthesis = truth.synthesise(&frf.frequency_hz);
            let largest = synthesis.iter().map(|v| v.norm()).fold(0.0, f64::max);
            for ((i, j, k), value) in synthesis.indexed_iter() {
                let distance = (value - frf.values.get(i, j, k)).norm();
                assert!(
                    distance < 1e-12 * largest,
                    "{law:?} {i} {j} {k}: {distance}"
                );
            }
            assert!(truth
                .modes
                .iter()
                .any(|mode| mode.frequency_hz > truth.band_hz[1]));
        }
    }

    #[test]
    fn noise_has_the_level_that_is_drawn() {
        let draw = Draw {
            snr_db: 20.0,
            uneven_noise: 0.5,
            ..small(Damping::Viscous)
        };
        let clean = measurement(&small(Damping::Viscous)).unwrap();
        let noisy = measurement(&draw).unwrap();
        let lines = clean.frf.frequency_hz.len();
        for (pair, variance) in noisy.noise_variance.iter().enumerate() {
            let (i, j) = (pair / 2, pair % 2);
            let of = |set: &Measurement, k| set.frf.values.get(i, j, k);
            let sum: f64 = (0..lines)
                .map(|k| (of(&noisy, k) - of(&clean, k)).norm_sqr())
                .sum();
            let ratio = sum / lines as f64 / variance;
            assert!((ratio - 1.0).abs() < 6.0 / (lines as f64).sqrt(), "{ratio}");
        }
    }

    #[test]
    fn tones_lie_on_the_lines_next_to_the_mains() {
        let axis = Array1::linspace(40.0, 130.0, 91);
        assert_eq!(tones(&small(Damping::Viscous), &axis), [10, 60]);
    }
}
