//! Poles on their way to becoming modes, each with where it came from.

use super::limits::EXPLAINS;
use crate::data::columns::Columns;
use crate::poles::refine::{refine, Refined};
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// The origin of a pole, and what the votes say of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Origin {
    /// Several runs agree on it.
    Agreed {
        /// Part of the runs that found it.
        score: f64,
        /// Distance between odd and even lines, where both found it.
        odd_even: Option<f64>,
    },
    /// Added at a peak that the votes had left.
    Added,
    /// In place of two poles that may be one mode which moves between FRFs.
    MayBeTwo,
    /// Represents out-of-band modes, or a broad background.
    Nuisance,
    /// A mode beyond the number that was asked for: fitted, not counted.
    LeftOut,
}

/// A change of the poles: one may go, near ones move, one may come.
#[derive(Debug, Default)]
pub(crate) struct Change {
    /// Goes.
    pub removed: Option<usize>,
    /// Move to.
    pub moved: Vec<(usize, Complex64)>,
    /// Comes.
    pub added: Option<Complex64>,
}

/// Poles with their linear part and their origins, alike in order.
#[derive(Debug, Clone)]
pub(crate) struct Candidates {
    /// Poles.
    pub refined: Refined,
    /// Origin of each.
    pub origin: Vec<Origin>,
}

impl Candidates {
    /// Makes the changes and projects again, without a step of refinement.
    pub fn apply(&mut self, work: &Columns, changes: Vec<Change>) -> Result<(), LinalgError> {
        let mut lambda: Vec<Option<Complex64>> =
            self.refined.lambda.iter().copied().map(Some).collect();
        for &(q, pole) in changes.iter().flat_map(|c| &c.moved) {
            lambda[q] = Some(pole);
        }
        for q in changes.iter().filter_map(|c| c.removed) {
            lambda[q] = None;
        }
        let mut kept: Vec<(Complex64, Origin)> = lambda
            .into_iter()
            .zip(&self.origin)
            .filter_map(|(pole, origin)| pole.map(|p| (p, *origin)))
            .collect();
        kept.extend(
            changes
                .iter()
                .filter_map(|c| c.added)
                .map(|p| (p, Origin::Added)),
        );
        let poles: Vec<Complex64> = kept.iter().map(|k| k.0).collect();
        self.origin = kept.into_iter().map(|k| k.1).collect();
        self.refined = refine(work, &poles, &self.refined.powers, tol::NO_STEP)?;
        Ok(())
    }

    /// True where pole q may be tested, merged or dropped.
    pub fn may_go(&self, q: usize) -> bool {
        !matches!(self.origin[q], Origin::Nuisance | Origin::LeftOut)
    }

    /// True where a pole stands within a width of `lambda`.
    pub fn explain(&self, lambda: Complex64) -> bool {
        self.refined
            .lambda
            .iter()
            .any(|p| (p.re - lambda.re).abs() < EXPLAINS * p.im.max(lambda.im))
    }
}
