//! Weights of FRFs: the product of a response's and a reference's.

use chladni_frf::{FrfSet, FrfValues};

/// 1/(s_i·t_j), about one in the mean.
#[derive(Debug, Clone)]
pub(crate) struct PairWeights {
    pub response: Vec<f64>,
    pub reference: Vec<f64>,
}

impl PairWeights {
    /// Of a pair (response, reference).
    pub fn of(&self, (i, j): (usize, usize)) -> f64 {
        self.response[i] * self.reference[j]
    }

    /// The set with every FRF times its weight.
    pub fn applied(&self, frf: &FrfSet) -> FrfSet {
        let mut out = frf.clone();
        match &mut out.values {
            FrfValues::F64(values) => values
                .indexed_iter_mut()
                .for_each(|((i, j, _), value)| *value *= self.of((i, j))),
            FrfValues::F32(values) => values
                .indexed_iter_mut()
                .for_each(|((i, j, _), value)| *value *= self.of((i, j)) as f32),
        }
        out
    }

    /// What was done, for the path.
    pub fn words(&self) -> String {
        format!(
            "FRFs weighted by their noise, which {}",
            self.spread_in_words()
        )
    }

    /// How the noise differs.
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
