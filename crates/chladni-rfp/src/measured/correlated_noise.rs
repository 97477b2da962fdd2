//! Poles that noise alone would make where its errors on neighbouring lines are correlated.
//!
//! An exponential window, or zeros after a gate, leave noise that is as smooth over lines as
//! a resonance is. Whitened by that correlation it is noise like any other, and what one
//! more pole explains of it is told from chance (theory.md, eq. 8).

use super::limits::{
    CORRELATION_LEAST, CORRELATION_REACH, CORRELATION_WHITE, CORRELATION_WIDEST,
    LOCAL_LINES_TO_SPARE, POWERS,
};
use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::data::window::block_errors::BlockErrors;
use crate::measured::local::Neighbourhood;
use crate::poles::refine::Refined;
use crate::poles::significance::threshold;
use chladni_linalg::blocked::projected;
use chladni_linalg::{cholesky, matmul_h, qr_thin, solve_lower, LinalgError};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// The part of its whitened neighbourhood that pole `q` explains, over the part that chance
/// lets a pole explain; `None` where it is far broader than what correlation makes, or too few lines
/// tell it.
pub(crate) fn over_chance(
    work: &Columns,
    refined: &Refined,
    q: usize,
    errors: &BlockErrors,
) -> Result<Option<f64>, LinalgError> {
    let pole = refined.lambda[q];
    let own_y = pole.re.max(f64::MIN_POSITIVE).sqrt();
    if errors.cycles(pole.im / (2.0 * own_y)) > CORRELATION_WIDEST {
        return Ok(None);
    }
    let hood = Neighbourhood::around(work, refined, pole);
    let near = |y: f64| errors.cycles(y - own_y).abs() <= CORRELATION_REACH;
    let kept: Vec<usize> = (0..hood.local.lines())
        .filter(|&k| near(y(hood.local.x[k])))
        .collect();
    let local = hood.local.select(&kept);
    let others: Vec<Complex64> = hood
        .near
        .iter()
        .filter(|&&near| near != q)
        .map(|&near| refined.lambda[near])
        .collect();
    let columns = others.len() + POWERS.len();
    if local.lines() < columns + 1 + LOCAL_LINES_TO_SPARE {
        return Ok(None);
    }
    let lower = cholesky(correlation(&local, errors).view())?;
    let whitened = |columns: &Array2<Complex64>| solve_lower(lower.view(), columns.view());
    let (beside, _) = qr_thin(whitened(&basis(&local, &others, &POWERS))?.view())?;
    let past = |columns: Array2<Complex64>| projected(beside.view(), columns.view()).1;
    let own = past(whitened(&basis(&local, &[pole], &[]))?);
    let left = past(whitened(&local.b)?);
    let size = own.iter().map(Complex64::norm_sqr).sum::<f64>();
    let explained = matmul_h(own.view(), left.view());
    let energy: Array1<f64> = left.map(Complex64::norm_sqr).sum_axis(Axis(0));
    let free = (local.lines() - columns - 1) as f64;
    // exponential with mean 1 where there is noise alone (checks/noise.rs)
    let share = |(e, energy): (&Complex64, &f64)| {
        let explained = e.norm_sqr() / size.max(f64::MIN_POSITIVE);
        let rest = (energy - explained).max(f64::MIN_POSITIVE);
        free * (explained / rest).ln_1p()
    };
    let sum: f64 = explained.iter().zip(&energy).map(share).sum();
    Ok(Some(sum / threshold(energy.len(), work.lines())))
}

/// ω/ω_max of a line at x.
fn y(x: f64) -> f64 {
    x.max(0.0).sqrt()
}

/// True where noise of neighbouring lines is as smooth as a narrow resonance, and nothing
/// else leaves errors there.
pub(crate) fn correlates(lines: &Columns, errors: &BlockErrors) -> bool {
    let apart = lines.x.windows(2).map(|two| y(two[1]) - y(two[0]));
    let nearest = apart.fold(f64::INFINITY, f64::min);
    let of_noise = || errors.of_noise(errors.cycles(nearest)).norm();
    !errors.leaks() && nearest.is_finite() && of_noise() > CORRELATION_LEAST
}

/// Correlation of noise on the lines; axes (line, line).
fn correlation(lines: &Columns, errors: &BlockErrors) -> Array2<Complex64> {
    let size = (lines.lines(), lines.lines());
    Array2::from_shape_fn(size, |(k, q)| {
        let white = f64::from(u8::from(k == q)) * CORRELATION_WHITE;
        errors.of_noise(errors.cycles(y(lines.x[k]) - y(lines.x[q]))) + white
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::window::kinds::Window;
    use crate::poles::refine::refine;
    use crate::tolerances as tol;
    use chladni_frf::Damping;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;

    const LINES: usize = 200;
    const SAMPLES: usize = 512;
    /// α·T of the window.
    const DECAY: f64 = 3.0;

    /// Of blows under an exponential window of so many nepers.
    fn errors(decay: f64) -> Option<BlockErrors> {
        BlockErrors::new(Some(Window::Transient), None, decay, TAU * LINES as f64)
    }

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (u, v): (f64, f64) = (rng.random::<f64>().max(1e-300), rng.random());
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    }

    /// Three FRFs of windowed noise, unit mean square, and of a resonance at x of this
    /// height.
    fn columns(seed: u64, pole: Complex64, height: f64) -> Columns {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut columns = Columns {
            x: (1..=LINES)
                .map(|k| (k as f64 / LINES as f64).powi(2))
                .collect(),
            g: vec![1.0; LINES],
            b: Array2::zeros((LINES, 3)),
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let peak = basis(&columns, &[pole], &[]).column(0).to_owned();
        let top = peak.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let power: f64 = (0..SAMPLES)
            .map(|t| (-2.0 * DECAY * t as f64 / SAMPLES as f64).exp())
            .sum();
        for (n, mut column) in columns.b.columns_mut().into_iter().enumerate() {
            let samples: Vec<f64> = (0..SAMPLES)
                .map(|t| {
                    normal(&mut random) * (-DECAY * t as f64 / SAMPLES as f64).exp() / power.sqrt()
                })
                .collect();
            for (k, value) in column.iter_mut().enumerate() {
                let turn = |t: usize| -TAU * (k + 1) as f64 * t as f64 / SAMPLES as f64;
                let spectrum = samples.iter().enumerate();
                *value = spectrum
                    .map(|(t, x)| Complex64::from_polar(*x, turn(t)))
                    .sum();
                *value += peak[k] * (height * (1.0 + n as f64) / top);
            }
        }
        columns
    }

    /// The pole that the loudest line, or the one at x, leads to, and what it explains over
    /// chance.
    fn judged(work: &Columns, start: Option<Complex64>) -> f64 {
        let energy = |k: &usize| -> f64 { work.b.row(*k).iter().map(Complex64::norm_sqr).sum() };
        let loudest = (10..LINES - 10).max_by(|a, b| energy(a).total_cmp(&energy(b)));
        let x = work.x[loudest.unwrap()];
        let start = start.unwrap_or(Complex64::new(x, 2.0 * work.spacing(x)));
        let refined = refine(work, &[start], &POWERS, tol::FINE).unwrap();
        over_chance(work, &refined, 0, &errors(DECAY).unwrap())
            .unwrap()
            .unwrap()
    }

    /// The loudest peak of windowed noise is chance, in each of 40 draws; a resonance of
    /// four times its rms is none.
    #[test]
    fn the_peaks_of_windowed_noise_are_chance_and_a_resonance_is_none() {
        let pole = Complex64::new(0.25, 0.01);
        for seed in 0..40 {
            let noise = judged(&columns(seed, pole, 0.0), None);
            assert!(noise < 0.8, "{seed}: {noise}");
            // half-widths of 2, 4 and 7 lines
            for pole in [0.01, 0.02, 0.035].map(|im| Complex64::new(0.25, im)) {
                let mode = judged(&columns(seed, pole, 4.0), Some(pole));
                assert!(mode > 1.2, "{seed}, {pole}: {mode}");
            }
        }
    }

    #[test]
    fn only_windowed_records_have_such_noise() {
        let lines = columns(0, Complex64::new(0.25, 0.01), 0.0);
        assert!(correlates(&lines, &errors(DECAY).unwrap()));
        assert!(errors(0.0).is_none());
        assert!(!correlates(
            &lines,
            &BlockErrors::independent(TAU * LINES as f64)
        ));
    }
}
