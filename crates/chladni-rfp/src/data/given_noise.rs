//! Noise of FRFs from the variances or the coherences that their set holds.

use crate::data::pair_weights::NoiseSource;
use crate::data::screening::Screened;

/// Noise energy of each FRF on the lines used, in work units, and its source; `None` unless the set
/// holds the variance or the coherence of every value.
///
/// Variances come from averages, as `estimate` writes them. Coherence γ² of n averages gives a
/// variance |H|²(1 − γ²)/(2nγ²) (Bendat, Piersol, Random Data, 4th ed., table 9.6); the factor
/// 1/(2n), which all FRFs share, is left out. The median line is taken for all lines, because
/// leakage raises both at the peaks.
pub(crate) fn given_noise(data: &Screened) -> Option<(Vec<f64>, NoiseSource)> {
    let (frf, unit) = (data.frf, data.factor().norm_sqr());
    let over_lines = |variance: &dyn Fn(usize) -> f64| {
        let mut values: Vec<f64> = data.lines.iter().map(|&k| variance(k)).collect();
        let (middle, lines) = (values.len() / 2, values.len() as f64);
        *values.select_nth_unstable_by(middle, f64::total_cmp).1 * lines * unit
    };
    let (noise, noise_source): (Vec<f64>, _) = match (&frf.variance, &frf.coherence) {
        (Some(variance), _) => (
            data.pairs
                .iter()
                .map(|&(i, j)| over_lines(&|k| variance[[i, j, k]]))
                .collect(),
            NoiseSource::Variance,
        ),
        (None, Some(coherence)) => {
            let variance = |(i, j): (usize, usize), k: usize| {
                let squared = f64::from(coherence[[i, j, k]]);
                frf.values.get(i, j, k).norm_sqr() * (1.0 - squared) / squared
            };
            (
                data.pairs
                    .iter()
                    .map(|&pair| over_lines(&|k| variance(pair, k)))
                    .collect(),
                NoiseSource::Coherence,
            )
        }
        (None, None) => return None,
    };
    noise
        .iter()
        .all(|sum| sum.is_finite() && *sum > 0.0)
        .then_some((noise, noise_source))
}
