//! Seeded draws.

use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, Uniform};

/// A stream of random numbers; the same seed and stream give the same ones.
#[derive(Debug, Clone)]
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    /// One stream of a seed; streams are independent of each other.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self(generator)
    }

    /// Between 0 and 1.
    fn unit(&mut self) -> f64 {
        Uniform::new(0.0, 1.0).map_or(0.5, |uniform| uniform.sample(&mut self.0))
    }

    /// Even between two values.
    pub fn even(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Even on a logarithmic scale.
    pub fn spread(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.even([low.ln(), high.ln()]).exp()
    }

    /// A whole number, both ends included, even on a logarithmic scale.
    pub fn count(&mut self, [low, high]: [usize; 2]) -> usize {
        let value = self.spread([low as f64, high as f64 + 1.0]).floor();
        (value as usize).clamp(low, high)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of several.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        let place = (self.unit() * choices.len() as f64) as usize;
        choices[place.min(choices.len() - 1)]
    }

    /// Normal, of unit variance.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}
