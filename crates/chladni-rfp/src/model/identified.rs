//! Poles as the model will show them, with their error bars and grades.

use crate::damping::columns::viscous_pole_of;
use crate::damping::verdict::shift;
use crate::data::columns::Columns;
use crate::model::limits;
use crate::poles::estimate::{uncertainty_grade, Grade, PoleEstimate};
use crate::shapes::low_rank::Given;
use crate::shapes::search::Structured;
use chladni_frf::{Damping, Finding, Trust};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// One pole as the model will show it, in units of ω_max.
#[derive(Debug, Clone)]
pub(crate) struct Pole {
    /// λ (structural) or s (viscous), in units of ω_max² or ω_max.
    pub value: Complex64,
    /// ω_n/ω_max.
    pub omega: f64,
    /// η_n.
    pub loss_factor: f64,
    /// Standard deviations of the two.
    pub omega_std: f64,
    /// Standard deviation of η_n.
    pub loss_factor_std: f64,
    /// Grade.
    pub grade: Grade,
    /// Shapes and participations that came with the pole.
    pub given: Given,
}

impl Pole {
    /// ω_n²(1 + jη_n) over ω_max²: the pole in the x plane of its own law.
    pub fn lambda(&self) -> Complex64 {
        self.omega.powi(2) * Complex64::new(1.0, self.loss_factor)
    }

    /// What a saved residue is multiplied by to be that of [`crate::damping::columns`]:
    /// 2jω_d in the viscous law, where r = ψL/(2jω_d).
    pub fn residue_unit(&self, law: Damping) -> Complex64 {
        match law {
            Damping::Structural => Complex64::ONE,
            Damping::Viscous => Complex64::new(0.0, 2.0 * self.value.im),
        }
    }

    /// True where that is `lambda`, to rounding.
    fn stands_at(&self, lambda: Complex64) -> bool {
        (self.lambda() - lambda).norm() < limits::SAME * lambda.norm()
    }
}

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
    /// Which path found them, and why.
    pub path: String,
    /// Warnings so far.
    pub warnings: Vec<Finding>,
    /// False where the data as a whole contradict the model.
    pub consistent: bool,
    /// True where shapes and participations given with poles are real.
    pub real_shapes: bool,
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

/// Undamped frequency, loss factor and their deviations of a structural pole with the
/// variances of Re λ and Im λ.
pub(crate) fn structural_pole(lambda: Complex64, variance: [f64; 2], grade: Grade) -> Pole {
    let omega = lambda.re.max(0.0).sqrt();
    let deviation = variance.map(|v| v.max(0.0).sqrt());
    Pole {
        value: lambda,
        omega,
        loss_factor: lambda.im / lambda.re,
        omega_std: deviation[0] / (2.0 * omega),
        loss_factor_std: deviation[1] / lambda.re.abs(),
        grade,
        given: None,
    }
}

/// The same of a viscous pole with the 2 × 2 covariance of (Re s, Im s).
pub(crate) fn viscous_pole(s: Complex64, covariance: [[f64; 2]; 2], grade: Grade) -> Pole {
    let omega = s.norm();
    let zeta = -s.re / omega;
    // ∂|s| = (Re s, Im s)/|s|; ∂ζ = (−Im², Re·Im)/|s|³
    let along = |g: [f64; 2]| {
        (g[0] * g[0] * covariance[0][0]
            + 2.0 * g[0] * g[1] * covariance[0][1]
            + g[1] * g[1] * covariance[1][1])
            .max(0.0)
            .sqrt()
    };
    let cubed = omega.powi(3);
    Pole {
        value: s,
        omega,
        loss_factor: 2.0 * zeta,
        omega_std: along([s.re / omega, s.im / omega]),
        loss_factor_std: 2.0 * along([-s.im * s.im / cubed, s.re * s.im / cubed]),
        grade,
        given: None,
    }
}

impl Identified {
    /// Poles with their deviations.
    pub fn new(found: PoleEstimate) -> Self {
        let law = found.work.law;
        let pole = |((&lambda, &c), grade): ((&Complex64, &f64), Grade)| Pole {
            value: match law {
                Damping::Structural => lambda,
                Damping::Viscous => viscous_pole_of(lambda),
            },
            ..structural_pole(lambda, [0.5 * c; 2], grade)
        };
        let PoleEstimate {
            refined,
            work,
            back,
            variance,
            spread,
            grades,
            path,
            warnings,
            consistent,
            ..
        } = found;
        let poles = refined.lambda.iter().zip(&spread).zip(grades);
        Self {
            damping: law,
            poles: poles.map(pole).collect(),
            powers: refined.powers,
            work,
            back,
            variance,
            path,
            warnings,
            consistent,
            real_shapes: false,
        }
    }

    /// The most that a sure mode of the band would shift by under the other damping law,
    /// in error bars.
    pub fn shift_by_other_law(&self) -> f64 {
        let sure = self.poles.iter().filter(|pole| {
            pole.grade.0 == Trust::Sure && self.work.in_band((pole.omega * pole.omega).into())
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
        let (known, others): (Vec<Pole>, Vec<Pole>) = self
            .poles
            .into_iter()
            .partition(|pole| structured.replaced.iter().any(|l| pole.stands_at(*l)));
        self.poles = others;
        for found in structured.poles {
            let mut pole = structural_pole(
                found.lambda,
                found.spread.map(|v| v * self.variance),
                uncertainty_grade(found.lambda, found.spread.map(|v| v * self.variance)),
            );
            if self.damping == Damping::Viscous {
                pole.value = viscous_pole_of(found.lambda);
            }
            let unit = pole.residue_unit(self.damping);
            let nearest = known.iter().min_by(|a, b| {
                (a.lambda() - found.lambda)
                    .norm()
                    .total_cmp(&(b.lambda() - found.lambda).norm())
            });
            if let Some(nearest) = nearest.filter(|pole| {
                pole.grade.0 != Trust::Sure
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
