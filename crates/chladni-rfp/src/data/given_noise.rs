//! Noise that a set tells of itself: the variance of its values, else their coherence.

use crate::data::pair_weights::Giver;
use crate::data::screening::Screened;

/// Noise energy of each FRF on the lines used, in work units (by coherence: up to a
/// factor, the number of averages), where the set tells it of every value.
///
/// Variances come from averages, as `estimate` writes them. Coherence γ² of n averages stands
/// for a variance |H|²(1 − γ²)/(2nγ²) (Bendat, Piersol, Random Data, 4th ed., table 9.6). The
/// median line is taken for all lines: leakage raises either at the peaks.
pub(crate) fn given_noise(data: &Screened) -> Option<(Vec<f64>, Giver)> {
    let (frf, unit) = (data.frf, data.factor().norm_sqr());
    let median = |of: &dyn Fn(usize) -> f64| {
        let mut values: Vec<f64> = data.lines.iter().map(|&k| of(k)).collect();
        let (middle, lines) = (values.len() / 2, values.len() as f64);
        *values.select_nth_unstable_by(middle, f64::total_cmp).1 * lines * unit
    };
    let (noise, giver): (Vec<f64>, _) = match (&frf.variance, &frf.coherence) {
        (Some(variance), _) => (
            data.pairs
                .iter()
                .map(|&(i, j)| median(&|k| variance[[i, j, k]]))
                .collect(),
            Giver::Variance,
        ),
        (None, Some(coherence)) => {
            let of = |(i, j): (usize, usize), k: usize| {
                let squared = f64::from(coherence[[i, j, k]]);
                frf.values.get(i, j, k).norm_sqr() * (1.0 - squared) / squared
            };
            (
                data.pairs
                    .iter()
                    .map(|&pair| median(&|k| of(pair, k)))
                    .collect(),
                Giver::Coherence,
            )
        }
        (None, None) => return None,
    };
    noise
        .iter()
        .all(|sum| sum.is_finite() && *sum > 0.0)
        .then_some((noise, giver))
}
