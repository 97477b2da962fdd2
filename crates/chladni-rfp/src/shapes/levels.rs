//! Levels of errors on lines beside modes, apart from what the slopes of FRFs leak there.

use crate::shapes::limits;

/// The errors of a line.
pub(super) struct LineLevel {
    /// Power of the residual: that which all FRFs of a force share, over their power, or that of
    /// one FRF.
    pub seen: f64,
    /// The same of the slope, per cycle.
    pub slope: f64,
    /// Scatter of the residual by other noise.
    pub alone: f64,
}

/// The level of errors from lines that hold it and, where slopes leak, a part that goes with the
/// power of the slope; `None` where there is none.
///
/// Lines scatter by their own mean and by noise of their FRFs, and count over the square of both.
pub(super) fn level_of(lines: &[LineLevel], leaks: bool) -> Option<f64> {
    let seen = lines.iter().map(|own| own.seen.abs()).sum::<f64>();
    let [mut level, mut leaked] = [seen / lines.len().max(1) as f64, 0.0];
    for _ in 0..limits::LEVEL_ROUNDS {
        // normal equations of the two parts
        let [mut ones, mut slopes, mut squares, mut sum, mut along] = [0.0; 5];
        for own in lines {
            let mean: f64 = level + leaked * own.slope.max(0.0);
            let weight = (mean + own.alone).max(f64::EPSILON * seen).powi(-2);
            ones += weight;
            slopes += weight * own.slope;
            squares += weight * own.slope * own.slope;
            sum += weight * own.seen;
            along += weight * own.slope * own.seen;
        }
        let free = ones * squares - slopes * slopes;
        leaked = match leaks && free > 0.0 {
            true => ((ones * along - slopes * sum) / free).max(0.0),
            false => 0.0,
        };
        level = ((sum - leaked * slopes) / ones).max(0.0);
    }
    (level > 0.0 && level.is_finite()).then_some(level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_told_from_what_slopes_leak() {
        // distances of 10 to 60 cycles to a mode; leakage of 0.3 per slope; at each distance the
        // quantiles of an exponential
        let of = |noise: f64| -> Vec<LineLevel> {
            let places = (0..50).flat_map(|k| (0..50).map(move |n| (k, n)));
            let line = |(k, n): (usize, usize)| {
                let slope = (10.0 + k as f64).powi(-2);
                let chance = -((n as f64 + 0.5) / 50.0).ln();
                LineLevel {
                    seen: (noise + 0.3 * slope) * chance,
                    slope,
                    alone: 1e-5,
                }
            };
            places.map(line).collect()
        };
        let level = level_of(&of(1e-4), true).unwrap();
        assert!((level / 1e-4 - 1.0).abs() < 0.05, "{level}");
        // leakage alone is not read as noise, and noise alone needs no slopes
        assert!(level_of(&of(0.0), true).unwrap_or(0.0) < 1e-6);
        let flat = of(1e-4)
            .into_iter()
            .map(|own| LineLevel { seen: 1e-4, ..own });
        let level = level_of(&flat.collect::<Vec<_>>(), false).unwrap();
        assert!((level / 1e-4 - 1.0).abs() < 1e-9, "{level}");
    }
}
