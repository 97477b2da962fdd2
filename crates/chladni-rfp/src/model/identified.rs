//! Poles as the model will show them, with their error bars and grades.

use crate::damping::bars::UncertainPole;
use crate::damping::places::value_in;
use crate::damping::verdict::shift;
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
    /// Law.
    pub damping: Damping,
    /// Poles.
    pub poles: Vec<Pole>,
    /// Powers of x of the residual terms.
    pub powers: Vec<i32>,
    /// Columns the residues are found on.
    pub work: Columns,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<Array2<f64>>,
    /// Noise variance of a work value.
    pub variance: f64,
    /// The path that found them, and the reason for it.
    pub path: String,
    /// Warnings so far.
    pub warnings: Vec<Finding>,
    /// False where the data as a whole contradict the model.
    pub consistent: bool,
    /// True where shapes and participations given with poles are real.
    pub real_shapes: bool,
    /// State of the damping law: where it is open, bars hold both laws.
    pub law_open: LawOpen,
    /// False where the poles were given, and not fitted to these columns.
    pub fitted: bool,
    /// True if errors were found not to be white noise, and deviations come from the residual itself.
    pub measured: bool,
}

/// State of the damping law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LawOpen {
    /// It is decided, given, or makes no difference.
    No,
    /// Not decided: damping is light and the residual is not white.
    Light,
    /// Not decided: the laws differ by more than an error bar, and the residual is white or was not
    /// tested.
    White,
}

impl Identified {
    /// Noise variance of each FRF over that of a work value: columns that are scaled FRFs
    /// have each its own, mixtures share theirs.
    pub fn noise_of_frfs(&self) -> Option<Array1<f64>> {
        let back = self.back.as_ref()?;
        let scaled = back.is_square()
            && back
                .indexed_iter()
                .all(|((a, b), value)| a == b || *value == 0.0);
        scaled.then(|| back.diag().mapv(|scale| scale * scale))
    }
}

impl Identified {
    /// Poles with their deviations.
    pub fn new(found: PoleEstimate) -> Self {
        let law = found.work.law;
        let pole = |((&lambda, &c), grade): ((&Complex64, &f64), Grade)| Pole {
            value: value_in(law, lambda),
            ..Pole::new(UncertainPole::of_lambda(lambda, [0.5 * c; 2]), grade)
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
            measured,
            ..
        } = found;
        let poles = refined.lambda.iter().zip(&spread).zip(grades);
        let no_gain = Reason::new("no-gain", "explains no more of the data than noise would");
        // as wide as it is uncertain
        let spreads: Vec<f64> = idle.iter().map(|pole| 2.0 * pole.im * pole.im).collect();
        let rejected = Grade::rejected(no_gain);
        let rejected = idle
            .iter()
            .zip(&spreads)
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
            measured,
        }
    }

    /// The most that a sure mode of the band would shift by under the other damping law,
    /// in error bars.
    pub fn shift_by_other_law(&self) -> f64 {
        let sure = self.poles.iter().filter(|pole| {
            pole.grade.trust == Trust::Sure && self.work.in_band((pole.omega * pole.omega).into())
        });
        let shifts = sure.map(|pole| {
            shift(
                pole.loss_factor,
                pole.omega_std / pole.omega,
                pole.loss_factor_std,
            )
        });
        shifts.filter(|shift| shift.is_finite()).fold(0.0, f64::max)
    }

    /// Poles replaced by what structured refinement found for them; a mode seen only
    /// there is graded by its error bar.
    pub fn structured(mut self, structured: Structured) -> Self {
        let (known, others): (Vec<Pole>, Vec<Pole>) = std::mem::take(&mut self.poles)
            .into_iter()
            .partition(|pole| structured.replaced.iter().any(|l| pole.is_at(*l)));
        for mut pole in others {
            let known = |from: &&(Complex64, Option<Complex64>)| pole.is_at(from.0);
            match structured.others.iter().find(known) {
                Some((_, None)) => continue,
                Some((_, Some(to))) => pole.move_to(*to, self.damping),
                None => {}
            }
            self.poles.push(pole);
        }
        for lambda in structured.added {
            let broad = UncertainPole::of_lambda(lambda, [lambda.im.powi(2); 2]);
            let mut pole = Pole::new(broad, Grade::SURE);
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
            let nearest = known.iter().min_by(|a, b| {
                (a.lambda() - found.lambda)
                    .norm()
                    .total_cmp(&(b.lambda() - found.lambda).norm())
            });
            if let Some(nearest) = nearest.filter(|pole| {
                pole.grade.trust != Trust::Sure
                    && (pole.lambda() - found.lambda).norm() < found.lambda.im
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
