//! Variance of lines, which local methods tell: it follows the power of the force.

use chladni_frf::FrfSet;

/// Variance of each line over that of the median line, where a local method tells it: with
/// the power of the force it differs from line to line. The mean over FRFs, each over its
/// own median.
pub(crate) fn line_variance(
    frf: &FrfSet,
    pairs: &[(usize, usize)],
    lines: &[usize],
) -> Option<Vec<f64>> {
    let local = frf.estimation.filter(|made| made.estimator.is_local());
    let (Some(variance), Some(_)) = (&frf.variance, local) else {
        return None;
    };
    let mut sum = vec![0.0; lines.len()];
    for &(i, j) in pairs {
        let own: Vec<f64> = lines.iter().map(|&k| variance[[i, j, k]]).collect();
        let middle = median(own.clone())?;
        sum.iter_mut()
            .zip(own)
            .for_each(|(sum, own)| *sum += own / middle);
    }
    let middle = median(sum.clone())?;
    let relative: Vec<f64> = sum.iter().map(|sum| sum / middle).collect();
    let usable = relative.iter().all(|v| v.is_finite() && *v > 0.0);
    usable.then_some(relative)
}

/// `None` where it is not above 0.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let value = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    (value > 0.0).then_some(value)
}
