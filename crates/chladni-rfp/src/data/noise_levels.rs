//! Noise of single FRFs, as the residual of a fit tells it.

use crate::data::limits;

/// Noise of FRFs that are not equally noisy as they were fitted, weights included.
pub(crate) struct UnevenNoise {
    /// Noise variance of each FRF over the mean.
    pub over_mean: Vec<f64>,
    /// Variance of these.
    pub spread: f64,
}

impl UnevenNoise {
    /// The noise that the residual energies `left` of FRFs tell; `None` where they differ little more
    /// than chance makes them, which is one over the lines that are left free.
    ///
    /// * `unknowns`: of each FRF
    pub fn new(left: &[f64], lines: usize, unknowns: usize) -> Option<Self> {
        let sum: f64 = left.iter().sum();
        let squares: f64 = left.iter().map(|left| left * left).sum();
        let spread = squares * left.len() as f64 / (sum * sum) - 1.0;
        let free = lines.saturating_sub(unknowns).max(1) as f64;
        (spread > limits::UNEVEN_NOISE + 1.0 / free).then(|| {
            let mean = sum / left.len() as f64;
            Self {
                over_mean: left.iter().map(|left| left / mean).collect(),
                spread,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_uneven_beyond_what_few_lines_make_of_even_one() {
        // energies of 100 lines scatter by a tenth, those of four by a half
        let by_chance = [1.1, 0.9, 1.05, 0.95];
        assert!(UnevenNoise::new(&by_chance, 104, 4).is_none());
        let of_few = [1.5, 0.5, 1.4, 0.6];
        assert!(UnevenNoise::new(&of_few, 8, 4).is_none());
        assert!(UnevenNoise::new(&of_few, 104, 4).is_some());
        assert!(UnevenNoise::new(&[], 104, 4).is_none());
        let loud = UnevenNoise::new(&[6.0, 1.0, 1.0, 0.0], 104, 4).unwrap();
        assert_eq!(loud.over_mean, [3.0, 0.5, 0.5, 0.0]);
        assert!((loud.spread - 1.375).abs() < 1e-12);
    }
}
