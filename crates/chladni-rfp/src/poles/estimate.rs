//! The poles that a path found, and their grades by their error bars alone.

use super::limits::{EXPLAINED, FAINT, FAINT_OVER_USUAL, SAME_NOISE, UNCERTAIN};
use crate::data::columns::Columns;
use crate::data::grade::Grade;
use crate::data::information::covariance;
use crate::poles::refine::Refined;
use chladni_frf::{Finding, Reason, Trust};
use ndarray::Array2;
use num_complex::Complex64;

/// The poles that a path found.
#[derive(Debug, Clone)]
pub(crate) struct PoleEstimate {
    /// Poles in the x plane with the linear fit at them.
    pub refined: Refined,
    /// Columns that the residues are found on.
    pub work: Columns,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<Array2<f64>>,
    /// Noise variance of a value of these columns.
    pub variance: f64,
    /// E|δλ|² per pole.
    pub spread: Vec<f64>,
    /// True if the residual is white, or taken for noise without a test: spreads come from the
    /// information matrix.
    pub residual_is_noise: bool,
    /// Grade of each pole.
    pub grades: Vec<Grade>,
    /// Poles added by hand that explain nothing; they are not among `refined`.
    pub idle: Vec<Complex64>,
    /// The path, and the reason for it.
    pub path: String,
    pub warnings: Vec<Finding>,
    /// False if the data as a whole contradict the model.
    pub consistent: bool,
}

impl PoleEstimate {
    /// True if the poles explain the data to rounding.
    pub fn is_rounding(&self) -> bool {
        self.room_to_rounding() >= 0.0
    }

    /// True if the poles leave noise or rounding, and no more of it than those of another estimate.
    pub fn leaves_no_more_than(&self, other: &Self) -> bool {
        let is_same = self.variance <= SAME_NOISE * other.variance;
        self.residual_is_noise && (is_same || self.is_rounding())
    }

    /// Sum of squares that may be added before the residual is more than rounding.
    pub fn room_to_rounding(&self) -> f64 {
        EXPLAINED * self.work.energy() - self.refined.projection.sse
    }

    /// Largest loss factor among the in-band modes that are sure; 0 if there are none.
    pub fn heaviest_sure(&self) -> f64 {
        let sure = self
            .refined
            .lambda
            .iter()
            .zip(&self.grades)
            .filter(|(pole, grade)| grade.trust == Trust::Sure && self.work.in_band(**pole));
        sure.map(|(pole, _)| pole.im / pole.re).fold(0.0, f64::max)
    }
}

/// Grades of the poles by their error bars, and the linearised variances E|δλ|².
///
/// * `variance`: of the noise of a value
pub(crate) fn graded(refined: &Refined, work: &Columns, variance: f64) -> (Vec<Grade>, Vec<f64>) {
    let inverse = covariance(refined.information(work).view());
    let grade_of = |(&pole, &spread): (&Complex64, &f64)| match work.in_band(pole) {
        true => uncertainty_grade(pole, [0.5 * spread; 2]),
        false => Grade::SURE,
    };
    let spread: Vec<f64> = inverse
        .diag()
        .iter()
        .map(|value| (variance * value.re).max(0.0))
        .collect();
    let mut grades: Vec<Grade> = refined.lambda.iter().zip(&spread).map(grade_of).collect();
    let relative = |n: usize| spread[n].sqrt() / refined.lambda[n].im;
    let mut in_band: Vec<f64> = (0..spread.len())
        .filter(|&n| work.in_band(refined.lambda[n]))
        .map(relative)
        .collect();
    in_band.sort_by(f64::total_cmp);
    let usual = in_band.get(in_band.len() / 2).copied().unwrap_or(f64::MAX);
    for (n, grade) in grades.iter_mut().enumerate() {
        let faint = relative(n) > FAINT.max(FAINT_OVER_USUAL * usual);
        if faint && work.in_band(refined.lambda[n]) && grade.trust == Trust::Sure {
            *grade = Grade::weak(Reason::new("faint", FAINT_SENTENCE));
        }
    }
    (grades, spread)
}

/// True for a mode that is much less certain than all others.
pub(crate) fn is_faint(grade: &Grade) -> bool {
    grade.reasons.iter().any(|reason| reason.code == "faint")
}

/// The finding of more modes in the data than were asked for; `None` if no pole was `dropped`.
///
/// * `hz`: frequency of x = 1
pub(crate) fn more_than_asked(asked: usize, dropped: &[Complex64], hz: f64) -> Option<Finding> {
    let places: Vec<f64> = dropped
        .iter()
        .map(|pole| pole.re.max(0.0).sqrt() * hz)
        .collect();
    let named: Vec<String> = places.iter().map(|hz| format!("{hz:.2}")).collect();
    (!places.is_empty()).then(|| {
        Finding::caution(
            "more-modes",
            format!(
                "{asked} modes were asked for and the data show more: left out at {} Hz; the \
                 others and the shapes are off by what these leave",
                named.join(", ")
            ),
        )
        .value("modes_asked", asked as f64)
        .list("left_out_hz", places)
        .help("let the data decide how many modes there are, or fit a narrower band")
    })
}

/// The finding of fewer modes than were asked for.
///
/// * `why`: the reason, which begins with a colon; or empty
pub(crate) fn fewer_modes(asked: usize, found: usize, why: &str) -> Finding {
    Finding::caution(
        "fewer-modes",
        format!("{asked} modes asked for, {found} found{why}"),
    )
    .value("modes_asked", asked as f64)
    .value("modes_found", found as f64)
    .help("ask for fewer modes, or fit a wider band")
}

/// True for the finding of [`fewer_modes`].
pub(crate) fn says_fewer_modes(finding: &Finding) -> bool {
    finding.code == "fewer-modes"
}

/// The grade of a pole by the `variance` of its real and imaginary part: sure if it is known to a
/// fraction of its half-bandwidth.
pub(crate) fn uncertainty_grade(lambda: Complex64, variance: [f64; 2]) -> Grade {
    let deviation = (variance[0] + variance[1]).max(0.0).sqrt();
    if deviation.is_infinite() {
        Grade::weak(Reason::new("not-told-apart", NOT_TOLD))
    } else if deviation > UNCERTAIN * lambda.im {
        Grade::weak(uncertain(deviation / lambda.im))
    } else {
        Grade::SURE
    }
}

/// The reason for a doubt: the error bar of a pole, in half-bandwidths.
pub(crate) fn uncertain(half_bandwidths: f64) -> Reason {
    Reason::new("uncertain", UNCERTAIN_SENTENCE)
        .detail(format!("{half_bandwidths:.1} half-bandwidths, one sigma"))
}

/// True for the reason that [`uncertain`] gives.
pub(crate) fn is_uncertain(reason: &Reason) -> bool {
    reason.code == "uncertain"
}

/// Reason for a doubt: the mode is much less certain than all others.
const FAINT_SENTENCE: &str =
    "hundreds of times less certain than the other modes: it may stand for the background";

/// Reason for a doubt: the variance of the pole is infinite.
const NOT_TOLD: &str = "the data do not tell it from its neighbours: its error bars are not known";

/// Reason for a doubt: the error bar is large.
pub(crate) const UNCERTAIN_SENTENCE: &str = "its frequency or damping is uncertain";
