//! Medians, root mean squares, and values without their repetitions.

/// The value below which the part `share` (0..=1) of the values lies, interpolated; NaN
/// without values.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| !value.is_nan())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    sorted[below] + part * (sorted[(below + 1).min(last)] - sorted[below])
}

/// The middle value; NaN without values.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The largest value; NaN without values.
pub fn largest(values: &[f64]) -> f64 {
    quantile(values, 1.0)
}

/// Root of the mean square; NaN without values.
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0usize), |(sum, count), value| {
            (sum + value * value, count + 1)
        });
    (sum / count as f64).sqrt()
}

/// Mean; NaN without values.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0usize), |(sum, count), value| {
            (sum + value, count + 1)
        });
    sum / count as f64
}

/// Each value once, in the order of their first appearance.
pub fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for value in values {
        if !seen.contains(&value) {
            seen.push(value);
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_and_nothing_has_none() {
        assert_eq!(quantile(&[4.0, 1.0, 2.0, 3.0], 0.5), 2.5);
        assert_eq!(
            (largest(&[1.0, 7.0, f64::NAN]), quantile(&[5.0], 0.25)),
            (7.0, 5.0)
        );
        assert!(median(&[]).is_nan() && root_mean_square([]).is_nan());
        assert_eq!(root_mean_square([3.0, 4.0, 5.0, 0.0, 0.0]), 10f64.sqrt());
    }
}
