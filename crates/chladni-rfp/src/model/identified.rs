//! Poles of the model with their error bars and grades.

use crate::damping::bars::UncertainPole;
use crate::damping::places::value_in;
use crate::damping::verdict::{shift, without_decay};
use crate::data::columns::Columns;
use crate::data::grade::Grade;
use crate::poles::estimate::{uncertainty_grade, PoleEstimate};
use crate::poles::pole::Pole;
use crate::shapes::structure::Structured;
use chladni_frf::{Damping, Finding, Reason, Trust};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// Poles of one law with the data they were found on.
#[derive(Debug)]
pub(crate) struct Identified {
    pub damping: Damping,
    pub poles: Vec<Pole>,
    /// Powers of x of the residual terms.
    pub powers: Vec<i32>,
    /// Columns that the residues are found on.
    pub work: Columns,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<Array2<f64>>,
    /// Noise variance of a value of these columns.
    pub variance: f64,
    /// The path that found them, and the reason for it.
    pub path: String,
    /// Warnings so far.
    pub warnings: Vec<Finding>,
    /// False if the data as a whole contradict the model.
    pub consistent: bool,
    /// True if shapes and participations given with poles are real.
    pub real_shapes: bool,
    /// State of the damping law: if it is open, error bars cover both laws.
    pub law_open: LawOpen,
    /// False if the poles were given, and not fitted to these columns.
    pub fitted: bool,
    /// True if the residual is white, or taken for noise without a test. If not, the error bars come
    /// from the residual itself.
    pub residual_is_noise: bool,
}

/// State of the damping law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LawOpen {
    /// It is decided, given, or makes no difference.
    No,
    /// Not decided, and the residual is not white.
    ResidualNotWhite,
    /// Not decided: the laws differ by more than an error bar, and the residual is white or was not
    /// tested.
    BeyondErrorBars,
}

impl Identified {
    /// Noise variance of each FRF over that of a work value, if columns are scaled FRFs; `None` for
    /// mixtures, which share one variance.
    pub fn noise_of_frfs(&self) -> Option<Array1<f64>> {
        let back = self.back.as_ref()?;
        let is_diagonal = back.is_square()
            && back
                .indexed_iter()
                .all(|((a, b), value)| a == b || *value == 0.0);
        is_diagonal.then(|| back.diag().mapv(|scale| scale * scale))
    }

    /// The poles of an estimate with their error bars.
    pub fn new(found: PoleEstimate) -> Self {
        let law = found.work.law;
        let pole = |((&lambda, &spread), grade): ((&Complex64, &f64), Grade)| Pole {
            value: value_in(law, lambda),
            ..Pole::new(UncertainPole::of_lambda(lambda, [0.5 * spread; 2]), grade)
        };
        let PoleEstimate {
            refined,
            work,
            back,
            variance,
            spread,
            grades,
            idle,
            path,
            warnings,
            consistent,
            residual_is_noise,
            ..
        } = found;
        let poles = refined.lambda.iter().zip(&spread).zip(grades);
        let no_gain = Reason::new("no-gain", "explains no more of the data than noise would");
        // a pole without effect is known to its bandwidth
        let idle_spreads: Vec<f64> = idle.iter().map(|pole| 2.0 * pole.im * pole.im).collect();
        let rejected = Grade::rejected(no_gain);
        let rejected = idle
            .iter()
            .zip(&idle_spreads)
            .map(|idle| (idle, rejected.clone()));
        Self {
            damping: law,
            poles: poles.chain(rejected).map(pole).collect(),
            powers: refined.powers,
            work,
            back,
            variance,
            path,
            warnings,
            consistent,
            real_shapes: false,
            law_open: LawOpen::No,
            fitted: true,
            residual_is_noise,
        }
    }

    /// Largest shift, in error bars, of a sure mode of the band under the other damping law.
    ///
    /// * `decay`: of an exponential window, in units of ω_max
    pub fn shift_by_other_law(&self, decay: f64) -> f64 {
        let sure = self
            .poles
            .iter()
            .filter(|pole| pole.grade.trust == Trust::Sure && self.work.in_band(pole.lambda()));
        let shifts = sure.map(|pole| {
            shift(
                without_decay(pole.loss_factor, pole.omega, decay),
                pole.omega_std / pole.omega,
                pole.loss_factor_std,
            )
        });
        shifts.filter(|shift| shift.is_finite()).fold(0.0, f64::max)
    }

    /// Replaces poles by those that structured refinement found. A mode that only this refinement
    /// found is graded by its error bar.
    pub fn structured(mut self, structured: Structured) -> Self {
        let (replaced, others): (Vec<Pole>, Vec<Pole>) = std::mem::take(&mut self.poles)
            .into_iter()
            .partition(|pole| structured.replaced.iter().any(|l| pole.is_at(*l)));
        for mut pole in others {
            let is_start = |from: &&(Complex64, Option<Complex64>)| pole.is_at(from.0);
            match structured.others.iter().find(is_start) {
                Some((_, None)) => continue,
                Some((_, Some(to))) => pole.move_to(*to, self.damping),
                None => {}
            }
            self.poles.push(pole);
        }
        for lambda in structured.added {
            let uncertain = UncertainPole::of_lambda(lambda, [lambda.im.powi(2); 2]);
            let mut pole = Pole::new(uncertain, Grade::SURE);
            pole.move_to(lambda, self.damping);
            self.poles.push(pole);
        }
        for found in structured.poles {
            let variance = found.spread.map(|v| v * self.variance);
            let mut pole = Pole::new(
                UncertainPole::of_lambda(found.lambda, variance),
                uncertainty_grade(found.lambda, variance),
            );
            pole.move_to(found.lambda, self.damping);
            let unit = pole.residue_unit(self.damping);
            let distance = |pole: &Pole| (pole.lambda() - found.lambda).norm();
            let nearest = replaced
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            if let Some(nearest) = nearest.filter(|nearest| {
                nearest.grade.trust != Trust::Sure && distance(nearest) < found.lambda.im
            }) {
                pole.grade = nearest.grade.clone();
            }
            pole.given = Some((found.shape, found.participation.mapv(|v| v / unit)));
            self.poles.push(pole);
        }
        self.real_shapes = structured.real;
        self.path += &format!("; {}", structured.evidence);
        self
    }
}
