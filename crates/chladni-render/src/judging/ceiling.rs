//! The limit of physics: a certified upper bound on the contrast of a scene.
//!
//! For any λ ≥ 0 on hot rows with Σλ = 1 and μ ≥ 0 on cold rows and actuators, rows
//! divided by their limits,
//!
//! Σ_h λ_h |h_h·A|² ≤ Σ_k μ_k |r_k·A|² for every A   ⟹   min_h |h_h·A|² ≤ Σ_k μ_k for
//! every A that keeps the cold and the force limits
//!
//! (theory.md, eq. 49; module [`dual`](crate::solving::dual)). The least Σμ is the dual of the
//! scene's own problem after its phases are relaxed. Where it stays apart from what was
//! found, the phases are held in sectors, case by case (module
//! [`branches`](crate::solving::branches)).

use crate::panel::drive::Drive;
use crate::problems::problem::Problem;
use crate::solving::branches::tighten;
use crate::solving::climb::Climb;
use crate::solving::dual::Dual;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::{concatenate, Array2, ArrayView2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// The contrast that a scene asks for, that its panel can give at most with the actuators in
/// use, and that the drive reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    /// No drive within the force limits gives more, dB: least hot amplitude over the
    /// limit of cold ground, while every cold response keeps that limit.
    pub possible_db: f64,
    /// Limit of hot ground over limit of cold ground, dB.
    pub asked_db: f64,
    /// The same for the drive of most contrast that was found, dB; what is possible lies
    /// between the two.
    pub reached_db: f64,
}

impl Ceiling {
    /// The ceiling of `problem`, and the most contrasting drive that was found from `start`
    /// or from the bound; `None` without force limits.
    ///
    /// * `thorough`: tell cases apart until bound and drive are within
    ///   `tolerances::CEILING_CASES_DB`; some seconds, which a scene that is proven far out of
    ///   reach is spared
    ///
    /// # Errors
    /// Those of the kernels: a broken promise.
    pub(crate) fn of(
        problem: &Problem,
        start: &Drive,
        thorough: bool,
    ) -> Result<Option<(Self, Drive)>> {
        let Some(Bound {
            squared,
            drive,
            hot,
            bounded,
            dual,
        }) = Bound::of(problem)?
        else {
            return Ok(None);
        };
        // a file holds no infinity: nothing and everything have the least and the largest number
        let db = |squared: f64| 10.0 * squared.clamp(f64::MIN_POSITIVE, f64::MAX).log10();
        let asked_db = 2.0 * db(problem.limits.hot_m_per_s / problem.limits.cold_m_per_s);
        let mut climb = Climb::new(problem)?;
        let (mut reached, mut best) = (0.0, start.clone());
        let mut reach = |start: Drive| -> Result<f64> {
            let (hot, drive) = climb.raise_hot(start)?;
            if hot.powi(2) > reached {
                (reached, best) = (hot.powi(2), drive);
            }
            Ok(reached)
        };
        let mut most = 0.0;
        for start in [drive, start.clone()] {
            most = reach(start)?;
            if db(most) > db(squared) - tolerances::CEILING_REACHED_DB {
                break;
            }
        }
        let target = |reached: f64| reached * 10f64.powf(tolerances::CEILING_CASES_DB / 10.0);
        let is_far = db(squared) < -tolerances::CEILING_FAR_DB;
        let possible = match thorough && !is_far && squared > target(most) {
            true => tighten(&dual, hot.view(), bounded.view(), squared, |drive| {
                reach(drive).map(target)
            })?,
            false => squared,
        };
        let ceiling = Self {
            possible_db: asked_db + db(possible),
            asked_db,
            reached_db: asked_db + db(reached),
        };
        Ok(Some((ceiling, best)))
    }

    /// True where the scene is proven to be impossible.
    pub fn forbids(&self) -> bool {
        self.possible_db < self.asked_db
    }

    /// The possible and the asked contrast, dB, in as many digits as tell them apart.
    pub fn in_words(&self) -> [String; 2] {
        let words =
            |digits: usize| [self.possible_db, self.asked_db].map(|db| format!("{db:.digits$}"));
        let apart = (1..4)
            .map(words)
            .find(|[possible, asked]| possible != asked);
        apart.unwrap_or_else(|| words(1))
    }
}

/// The bound that the multipliers prove.
struct Bound {
    /// No drive moves every hot row by more than the root of this over its limit while it
    /// keeps the cold and the force limits.
    squared: f64,
    /// The drive that the bound leans on, of arbitrary gain: the best one where the
    /// relaxation of the phases loses nothing.
    drive: Drive,
    /// Hot rows over their limits, and cold rows and unit rows of the actuators over
    /// theirs, all in drives of the force limit.
    hot: Array2<Complex64>,
    bounded: Array2<Complex64>,
    dual: Dual,
}

impl Bound {
    /// `None` without force limits, where nothing bounds what noise-like drives could do.
    ///
    /// # Errors
    /// Those of the kernels: a broken promise.
    fn of(problem: &Problem) -> Result<Option<Self>> {
        let each = problem.drive_limits.each;
        if !each.is_finite() {
            return Ok(None);
        }
        let scaled =
            |rows: ArrayView2<Complex64>, limit: f64| rows.mapv(|value| value * (each / limit));
        let hot = scaled(problem.rows.hot_rows(), problem.limits.hot_m_per_s);
        let cold = scaled(problem.rows.cold_rows(), problem.limits.cold_m_per_s);
        let bounded = concatenate![
            Axis(0),
            cold,
            Array2::from_diag_elem(hot.ncols(), Complex64::ONE)
        ];
        let mut dual = Dual::start(hot.view(), bounded.view(), Vec::new())?;
        let (squared, drive) = dual.solve(0.0)?;
        Ok(Some(Self {
            squared,
            drive,
            hot,
            bounded,
            dual,
        }))
    }
}
