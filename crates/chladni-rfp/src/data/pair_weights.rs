//! Weights of FRFs: the product of a response's and a reference's.

use serde::{Deserialize, Serialize};

/// Part of a set that gives the noise of its FRFs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum NoiseSource {
    Variance,
    Coherence,
}

impl NoiseSource {
    /// The source in words, for the path.
    pub fn words(self) -> &'static str {
        match self {
            Self::Variance => "the variances of the set say",
            Self::Coherence => "the coherence of the set says",
        }
    }
}

/// The weights of FRFs that may be tried next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum NextWeights {
    /// No other weights.
    None,
    /// Weights from the residual of a fit.
    FromResidual,
    /// Weights from the noise that the set gives, then those from the residual.
    FromSet,
    /// Weights from the residual of a fit that was weighted by a residual.
    FromWeightedResidual,
}

/// Weights 1/(s_i·t_j) of FRFs, about one in the mean: s_i is the noise of response i, t_j that of
/// reference j.
#[derive(Debug, Clone)]
pub(crate) struct PairWeights {
    pub response: Vec<f64>,
    pub reference: Vec<f64>,
}

impl PairWeights {
    /// Weight of a pair (response, reference).
    pub fn of(&self, (i, j): (usize, usize)) -> f64 {
        self.response[i] * self.reference[j]
    }

    /// The weighting in words, for the path.
    pub fn words(&self) -> String {
        format!(
            "FRFs weighted by their noise, which {}",
            self.spread_in_words()
        )
    }

    /// The spread of the noise, in words.
    pub fn spread_in_words(&self) -> String {
        let range = |values: &[f64]| {
            values.iter().cloned().fold(f64::MIN, f64::max)
                / values.iter().cloned().fold(f64::MAX, f64::min)
        };
        format!(
            "differs {:.1} times between responses and {:.1} times between references",
            range(&self.response),
            range(&self.reference)
        )
    }
}
