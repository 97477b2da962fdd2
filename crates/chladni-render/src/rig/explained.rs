//! The judgement of a measured field: a faulty rig explains it, or nothing does.
//!
//! Whatever is wrong with a rig, its panel moves as the columns of the mobility do: behind amplifiers
//! that err, dead, reversed or swapped channels, moved modes, fingers and masses. A field whose
//! points have other names is no such motion. One of other weights, or of a mirrored grid, is: it
//! has hardly any of the form foretold (`agreement`), and gains and poles do not explain it.

use super::lone_points::{left, motions};
use super::seen::Seen;
use super::structured::Structured;
use crate::tolerances;
use chladni_frf::{Finding, Result};
use ndarray::{Array2, Axis};
use num_complex::Complex64;

/// The parts of a field that nothing explains.
pub(super) struct Unexplained {
    /// Share of its square, beyond its noise, that gains and natural frequencies leave.
    by_faults: f64,
    /// The same that every motion of the panel leaves; `None` where phases are unknown or points
    /// too few to tell.
    by_motions: Option<f64>,
    /// Agreement in form with the field that gains and natural frequencies foretell.
    agreement: f64,
}

impl Unexplained {
    /// * `mobility`: before any field
    ///
    /// # Errors
    /// Those of the factorisation.
    pub(super) fn of(
        mobility: &Array2<Complex64>,
        structured: &Structured,
        seen: &Seen,
    ) -> Result<Self> {
        let foretold = structured.mobility.select(Axis(0), &seen.rows);
        let foretold = foretold.dot(&seen.drive);
        let measured = seen.phased(&structured.mobility);
        let square = |values: &mut dyn Iterator<Item = Complex64>| -> f64 {
            values.map(|value| value.norm_sqr()).sum()
        };
        let size = square(&mut measured.iter().copied()).max(f64::MIN_POSITIVE);
        let share = |miss: f64, freedom: usize| {
            (miss - seen.noise.powi(2) * freedom as f64).max(0.0) / size
        };
        let miss = square(&mut measured.iter().zip(&foretold).map(|(a, b)| a - b));
        let rows = mobility.select(Axis(0), &seen.rows);
        let basis = match seen.magnitudes_only {
            true => None,
            false => motions(&rows)?,
        };
        let by_motions = basis.map(|basis| {
            let miss = square(&mut left(&basis, &measured).into_iter());
            share(miss, seen.rows.len() - basis.ncols())
        });
        Ok(Self {
            by_faults: share(miss, seen.rows.len()),
            by_motions,
            agreement: seen.likeness(&structured.mobility).coefficient,
        })
    }

    /// True where gains and natural frequencies make the field, whatever form it had before.
    pub(super) fn is_explained(&self) -> bool {
        self.by_faults <= tolerances::FAULTS_LEAVE && self.agreement >= tolerances::SAME_FORM[0]
    }

    /// The finding of a field that is no motion of the panel.
    pub(super) fn finding(&self) -> Option<Finding> {
        let share = self.by_motions?;
        let words = format!(
            "no fault of the rig explains the field: {:.0} % of it is no motion that the actuators can \
             make, and a faulty rig leaves 1 %; nothing that is learned from it is to be trusted",
            100.0 * share
        );
        (share > tolerances::MOTIONS_LEAVE).then(|| {
            Finding::caution("field-unexplained", words)
                .value("share", share)
                .help(
                    "see that points have their names and their order, and that the field is of this \
                     panel; measure it again",
                )
        })
    }
}
