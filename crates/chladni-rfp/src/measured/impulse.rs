//! Evidence of the record itself, through its impulse response: was it padded with zeros,
//! was it windowed (theory.md, eq. 24)?

use super::limits::{CUT_DB, SEGMENTS, TREND_SEGMENTS, TREND_SHARE, WINDOWED_DB, WRAPPED_SEGMENTS};
use crate::data::columns::Columns;
use crate::data::onset::even_step;
use crate::tolerances as tol;
use chladni_linalg::fft;
use num_complex::Complex64;

/// Energy of the impulse response over the record, all columns, dB; `None` where the
/// lines are not evenly spaced.
fn decay(work: &Columns, frequency: &[f64]) -> Option<[f64; SEGMENTS]> {
    even_step(frequency)?;
    let n = frequency.len();
    let mut energy = [0.0; SEGMENTS];
    let fft = fft::inverse(n);
    for column in work.b.columns() {
        let mut response: Vec<Complex64> = column.to_vec();
        fft.process(&mut response);
        for (i, v) in response.iter().enumerate() {
            energy[i * SEGMENTS / n] += v.norm_sqr();
        }
    }
    Some(energy.map(|e| 10.0 * e.max(tol::TINY).log10()))
}

/// Factor (2 or 4) by which the time record was padded with zeros, or 1.
///
/// A padded record's impulse response ends abruptly at T/2 or T/4; then only every second
/// or fourth line carries information, and on those lines alone the cut record is exactly
/// a sum of modes.
pub(crate) fn padding_factor(work: &Columns, frequency: &[f64]) -> usize {
    let Some(level) = decay(work, frequency) else {
        return 1;
    };
    for (factor, end) in [(4, SEGMENTS / 4), (2, SEGMENTS / 2)] {
        // the last segment before the cut, and everything after it but the wrap-around at
        // the end
        let before = level[end - 1];
        let after = &level[end + 1..SEGMENTS - WRAPPED_SEGMENTS];
        let drop = before - after.iter().cloned().fold(f64::MIN, f64::max);
        let trend = level[end - TREND_SEGMENTS] - before;
        if drop > CUT_DB && trend < TREND_SHARE * drop {
            return factor;
        }
    }
    1
}

/// True where the impulse response decays ever faster: Σ a_n e^{−2σ_n t} is convex on a
/// logarithmic scale, a Hann or similar window is not. Compared are the falls over two
/// successive quarters of the record, each between means over an eighth.
pub(crate) fn windowed(work: &Columns, frequency: &[f64]) -> bool {
    let Some(level) = decay(work, frequency) else {
        return false;
    };
    let eighth = |i: usize| {
        let part = &level[i * SEGMENTS / 8..(i + 1) * SEGMENTS / 8];
        10.0 * (part.iter().map(|db| 10f64.powf(db / 10.0)).sum::<f64>()).log10()
    };
    let (start, middle, end) = (eighth(0), eighth(2), eighth(4));
    (middle - end) - (start - middle) > WINDOWED_DB
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// Spectrum of three modes times `window` over a record of 1024 samples.
    fn spectrum(window: impl Fn(f64) -> f64) -> (Columns, Vec<f64>) {
        let n = 1024;
        let mut response: Vec<Complex64> = (0..n)
            .map(|k| {
                let t = k as f64 / n as f64;
                let modes: Complex64 = [110.0, 333.0, 701.0]
                    .iter()
                    .map(|f| Complex64::new(-5.0 * t, std::f64::consts::TAU * f * t).exp())
                    .sum();
                modes * window(t)
            })
            .collect();
        fft::forward(n).process(&mut response);
        let x: Vec<f64> = (0..n).map(|k| (k + 1) as f64).collect();
        let b = Array2::from_shape_fn((n, 1), |(k, _)| response[k]);
        (
            Columns {
                g: vec![1.0; n],
                x: x.clone(),
                b,
                law: chladni_frf::Damping::Structural,
                leakage: None,
                neighbours: 0.0,
            },
            x,
        )
    }

    #[test]
    fn a_padded_record_is_told_from_a_decayed_one() {
        for (window, factor) in [(1.0, 1), (0.5, 2), (0.25, 4)] {
            let (work, frequency) = spectrum(|t| if t < window { 1.0 } else { 0.0 });
            assert_eq!(padding_factor(&work, &frequency), factor);
        }
    }

    #[test]
    fn only_a_window_makes_the_decay_grow() {
        let hann = |t: f64| {
            (1.0 - t) * (2.0 + (std::f64::consts::TAU * t).cos()) / 3.0
                + (std::f64::consts::TAU * t).sin() / std::f64::consts::TAU
        };
        let (work, frequency) = spectrum(hann);
        assert!(
            windowed(&work, &frequency),
            "autocorrelation of a Hann window"
        );
        for (name, window) in [
            ("none", (|_| 1.0) as fn(f64) -> f64),
            ("exponential", |t| (-3.0 * t).exp()),
            ("uniform", |t| 1.0 - t),
        ] {
            let (work, frequency) = spectrum(window);
            assert!(!windowed(&work, &frequency), "{name}");
        }
    }
}
