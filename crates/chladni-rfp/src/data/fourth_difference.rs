//! Fourth differences of five neighbouring lines: next to nothing for smooth curves, so they tell
//! noise, E|Δ⁴n|² = 70σ². Where lines were left out, or lie unevenly, they are divided differences:
//! those of even lines would take the slope of an FRF for noise.

use crate::data::limits;
use num_complex::Complex64;
use std::f64::consts::LN_2;

/// A fourth difference of five lines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FourthDifference([f64; 5]);

impl FourthDifference {
    /// The one of even lines.
    pub const OF_EVEN_LINES: Self = Self(limits::DIFFERENCE_OF_EVEN);

    /// The one of lines at these places, which rise.
    pub fn new(places: [f64; 5]) -> Self {
        let gaps = [0, 1, 2, 3].map(|k| places[k + 1] - places[k]);
        let least = gaps.iter().copied().fold(f64::MAX, f64::min);
        let most = gaps.iter().copied().fold(0.0, f64::max);
        if most <= (1.0 + limits::EVEN_LINES) * least || least <= 0.0 {
            return Self::OF_EVEN_LINES;
        }
        let factor = |k: usize| -> f64 {
            let others = (0..5).filter(|other| *other != k);
            others
                .map(|other| most / (places[k] - places[other]))
                .product()
        };
        let factors = [0, 1, 2, 3, 4].map(factor);
        let size: f64 = factors.iter().map(|factor| factor * factor).sum();
        Self(factors.map(|factor| factor * (limits::DIFFERENCE_OF_NOISE / size).sqrt()))
    }

    /// σ² of noise whose |Δ⁴|² has this median: the median of an exponential variable is ln 2 times
    /// its mean, 70σ².
    pub fn noise_of_median(median: f64) -> f64 {
        median / (limits::DIFFERENCE_OF_NOISE * LN_2)
    }

    /// |Δ⁴|² of the values of these lines.
    pub fn energy(self, values: [Complex64; 5]) -> f64 {
        let Self(factors) = self;
        let parts = values.iter().zip(factors);
        let sum: Complex64 = parts.map(|(value, factor)| factor * value).sum();
        sum.norm_sqr()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A light resonance at ten lines per half-bandwidth.
    fn resonance(place: f64) -> Complex64 {
        Complex64::new(0.0, 10.0) / Complex64::new(place - 200.3, -10.0)
    }

    #[test]
    fn even_lines_keep_their_factors() {
        let FourthDifference(factors) = FourthDifference::new([0.1, 0.2, 0.3, 0.4, 0.5]);
        assert_eq!(factors, limits::DIFFERENCE_OF_EVEN);
    }

    #[test]
    fn a_cubic_has_none_on_any_lines() {
        for places in [[0.0, 1.0, 2.0, 4.0, 5.0], [0.0, 0.1, 7.0, 7.5, 9.0]] {
            let cubic = |x: f64| Complex64::new(1.0 + x * x * x, 2.0 - 3.0 * x * x);
            let difference = FourthDifference::new(places);
            let least = 1e-20 * cubic(9.0).norm_sqr();
            assert!(difference.energy(places.map(cubic)) < least);
            let FourthDifference(factors) = difference;
            let size: f64 = factors.iter().map(|factor| factor * factor).sum();
            assert!((size / limits::DIFFERENCE_OF_NOISE - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_line_left_out_of_a_resonance_adds_little() {
        let largest = |left_out: f64| {
            let lines = (180..220).map(f64::from).filter(|place| *place != left_out);
            let lines: Vec<f64> = lines.collect();
            let of = |places: &[f64]| {
                let places = [0, 1, 2, 3, 4].map(|k| places[k]);
                FourthDifference::new(places).energy(places.map(resonance))
            };
            lines.windows(5).map(of).fold(0.0, f64::max)
        };
        let whole = largest(0.0);
        for left_out in [195.0, 200.0, 207.0] {
            let energy = largest(left_out);
            assert!(
                energy < 20.0 * whole,
                "{left_out}: {energy:.1e} of {whole:.1e}"
            );
        }
    }
}
