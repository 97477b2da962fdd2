//! The source of a fit's data: it holds the FRFs, and makes the passes over them that a fit
//! asks for.
//!
//! A set in memory makes every pass at once. Merged partials hold the passes that other machines
//! have made. At the next pass they stop the fit, with all that it needs to go on from there once
//! that pass is made.

use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::grade::Grade;
use crate::data::layout::DataLayout;
use crate::data::pair_weights::{NextWeights, NoiseSource, PairWeights};
use crate::data::products::Projected;
use crate::data::screening::Screened;
use chladni_frf::{Damping, Finding};
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::ops::Deref;

/// Data of a fit. The [`DataLayout`] holds all but their values.
pub(crate) trait Source: Deref<Target = DataLayout> + Clone + Sync {
    /// The reason that a fit does not go on: an error, or a pass that others must make.
    type Stop: From<FitError> + From<LinalgError>;

    /// First pass: a sketch of all FRFs, in work units, and the energy of each line over
    /// them.
    fn sketch(&self, seed: u64) -> (Columns, Array1<f64>);

    /// Frees the sums of the first pass, if they take a good part of the memory of the data and can be
    /// made again. Called once the sketch is not needed any more.
    fn end_first_pass(&self) {}

    /// Second pass: all FRFs, weighted by the lines of `way`, are compressed on the basis of a model
    /// with its poles.
    ///
    /// * `q`: that basis, orthonormal on weighted lines, (line, unknown)
    /// * `energy`: of each line over all FRFs
    ///
    /// # Errors
    /// A kernel that fails; the pass itself, where others must make it.
    fn projected(
        &self,
        way: &Way,
        q: Array2<Complex64>,
        energy: &Array1<f64>,
    ) -> Result<Projected, Self::Stop>;

    /// The poles that the last pass was made for, and how they were found, if a fit stopped for
    /// that pass.
    fn way(&self) -> Option<&Way>;

    /// The same data without the lines at `places` (among the lines used), which are
    /// outliers; the scale stays.
    fn without(&self, places: &[usize]) -> Self;

    /// The same data, whose poles are sought in another law.
    fn in_law(&self, law: Damping) -> Self;

    /// Noise energy of each FRF on the lines used, and its source, if the set gives it.
    fn given_noise(&self) -> Option<(Vec<f64>, NoiseSource)>;

    /// The same data times `weights`; without weights they are as measured.
    ///
    /// * `still_to_try`: weights that may be tried after these
    ///
    /// # Errors
    /// As [`Self::projected`].
    fn weighted(
        &self,
        weights: Option<(PairWeights, Option<NoiseSource>)>,
        still_to_try: NextWeights,
    ) -> Result<Self, Self::Stop>;

    /// The same data with one more finding.
    fn noted(&self, finding: Option<Finding>) -> Self;

    /// The single FRFs, if they are in memory.
    fn values(&self) -> Option<&Screened<'_>>;
}

/// Poles that a pass is made for, and the path that found them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Way {
    /// The law that they follow.
    pub law: Damping,
    /// In the x plane.
    pub lambda: Vec<Complex64>,
    pub by: By,
}

impl Way {
    /// Weight of each line used; empty if all count alike.
    pub fn weights(&self) -> &[f64] {
        match &self.by {
            By::Measured { weights, .. } => weights,
            By::Fast { .. } | By::Conjugated | By::Delay(_) => &[],
        }
    }
}

/// The path that found the poles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum By {
    /// Fast chain.
    Fast {
        /// Orders tried: (poles, residual variance), in order.
        history: Vec<(usize, f64)>,
        /// Passes made beyond the second.
        extra_passes: usize,
        /// Evidence against the other damping law, if that was tried before.
        doubt: Option<String>,
    },
    /// Measured-data path.
    Measured {
        /// The reason for this path.
        evidence: String,
        /// E|δλ|² of each pole.
        spread: Vec<f64>,
        #[serde(with = "as_json")]
        grades: Vec<Grade>,
        #[serde(with = "as_json")]
        findings: Vec<Finding>,
        /// 1/σ of each line used, of unit mean square; empty if all count alike.
        weights: Vec<f64>,
    },
    /// The fit was stopped: every resonance turns the wrong way.
    Conjugated,
    /// The fit was stopped: a delay of so many seconds explains the data.
    Delay(f64),
}

/// Findings and reasons as JSON text inside files of a format that does not describe itself: they
/// leave out empty fields, and hold values of several types.
pub(crate) mod as_json {
    use serde::{de, de::DeserializeOwned, ser, Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(value: &impl Serialize, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&serde_json::to_string(value).map_err(ser::Error::custom)?)
    }

    pub fn deserialize<'de, T: DeserializeOwned, D: Deserializer<'de>>(
        from: D,
    ) -> Result<T, D::Error> {
        serde_json::from_str(&String::deserialize(from)?).map_err(de::Error::custom)
    }
}
