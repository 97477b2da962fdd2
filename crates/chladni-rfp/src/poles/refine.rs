//! Maximum-likelihood poles by variable projection (theory.md, eq. 9–12).
//!
//! Residues and residual terms are eliminated by QR. A complex-analytic Gauss–Newton problem in
//! the poles alone remains; it is solved with Kaufman's Jacobian and Levenberg–Marquardt damping.
//! For white noise of one variance the fixed point is the maximum likelihood estimate, and
//! `information` is its Fisher matrix times σ².
//!
//! Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; Kaufman, BIT 15 (1975) 49. A step costs
//! about 8Nm(5m + 3r) flop. The search needs a start within about a bandwidth of each pole.

use crate::damping::basis::basis_derivative;
use crate::damping::gram::{Beside, Cauchy};
use crate::data::columns::Columns;
use crate::data::information::coefficients;
use crate::data::inner_products::sum_of_squares;
use crate::poles::descent::{Descent, NewtonSystem, Point, SearchData};
use crate::poles::limits;
use crate::poles::normal::{gradient, NormalFit, NormalPoint};
use crate::poles::removal::{rise_without, Removable};
use crate::tolerances::{self as tol, Precision};
use chladni_linalg::blocked::{blocked_gram, blocked_matmul_h, projected};
use chladni_linalg::{matmul, solve_upper, LinalgError};
use ndarray::{Array1, Array2, ArrayView1};
use num_complex::Complex64;

/// The linear fit at given poles, on an orthonormal basis.
#[derive(Debug, Clone)]
pub(crate) struct Projection {
    /// Orthonormal basis of the model, (line, m).
    pub q: Array2<Complex64>,
    /// R of the basis, (m, m).
    pub r: Array2<Complex64>,
    /// Qᴴb, (m, column).
    pub qb: Array2<Complex64>,
    /// Residual b − QQᴴb.
    pub residual: Array2<Complex64>,
    /// Sum of squares of the residual.
    pub sse: f64,
}

/// Q and R of the poles `lambda` and the residual terms x^`powers` on the lines of `work`.
pub(crate) fn orthonormal_basis(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
) -> Result<(Array2<Complex64>, Array2<Complex64>), LinalgError> {
    Cauchy::without_derivatives(work, lambda, powers).orthonormal()
}

impl Projection {
    /// Projects the columns of `work` on the basis of the poles `lambda` and the residual terms
    /// x^`powers`.
    pub fn new(work: &Columns, lambda: &[Complex64], powers: &[i32]) -> Result<Self, LinalgError> {
        let (q, r) = orthonormal_basis(work, lambda, powers)?;
        let (qb, residual) = projected(q.view(), work.b.view());
        Ok(Self {
            sse: sum_of_squares(&residual),
            q,
            r,
            qb,
            residual,
        })
    }
    /// Residues and residual coefficients, (m, column). Columns that are alike share theirs.
    pub fn coefficients(&self) -> Result<Array2<Complex64>, LinalgError> {
        coefficients(self.r.view(), self.qb.view())
    }
    /// The fit as one whose columns can be taken out.
    pub fn removable(&self) -> Result<Removable, LinalgError> {
        let energy = |column: ArrayView1<Complex64>| column.iter().map(|v| v.norm_sqr()).sum();
        Ok(Removable {
            inverse: self.gram_inverse()?,
            coefficients: self.coefficients()?,
            basis_energy: self.r.columns().into_iter().map(energy).collect(),
            sse: self.sse,
        })
    }
    /// The part of column q of the basis that lies outside all others: it determines the
    /// residue.
    pub fn outside_of_others(&self, q: usize) -> Result<Array1<Complex64>, LinalgError> {
        // with Rᴴy = e_q, Qy is orthogonal to all other columns, and 1 along this one
        let y = self.r_inverse()?.row(q).mapv(|v| v.conj());
        let energy = y.iter().map(|v| v.norm_sqr()).sum::<f64>();
        Ok(self.q.dot(&y) / Complex64::from(energy))
    }
    /// (AᴴA)⁻¹ of the basis A.
    pub fn gram_inverse(&self) -> Result<Array2<Complex64>, LinalgError> {
        let inverse = self.r_inverse()?;
        let adjoint = inverse.t().mapv(|v| v.conj());
        Ok(matmul(inverse.view(), adjoint.view()))
    }
    fn r_inverse(&self) -> Result<Array2<Complex64>, LinalgError> {
        let unit = Array2::from_diag_elem(self.r.nrows(), Complex64::new(1.0, 0.0));
        solve_upper(self.r.view(), unit.view())
    }
}

/// The linear fit at the poles `lambda`, as one whose poles can be taken out.
pub(crate) fn removable(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
) -> Result<Removable, LinalgError> {
    match NormalFit::at(work, lambda, powers) {
        Some(fit) => fit.removable(),
        None => Projection::new(work, lambda, powers)?.removable(),
    }
}

/// Refined poles with the linear fit at them.
#[derive(Debug, Clone)]
pub(crate) struct Refined {
    /// Poles in the x plane.
    pub lambda: Vec<Complex64>,
    /// Powers of x of the residual terms.
    pub powers: Vec<i32>,
    /// Linear fit at these poles.
    pub projection: Projection,
    /// Residues and residual coefficients, (m, column).
    pub coefficients: Array2<Complex64>,
    /// Gauss–Newton matrix, if the refinement ended by normal equations.
    information: Option<Array2<Complex64>>,
}

/// Gauss–Newton matrix and gradient at one set of poles.
fn newton_system(
    work: &Columns,
    lambda: &[Complex64],
    projection: &Projection,
    coefficients: &Array2<Complex64>,
) -> NewtonSystem {
    let n = lambda.len();
    let residues = coefficients.slice(ndarray::s![..n, ..]);
    let derivative = basis_derivative(work, lambda);
    let (_, outside) = projected(projection.q.view(), derivative.view());
    let products = matmul(residues, residues.t().mapv(|v| v.conj()).view());
    let mut information = blocked_gram(outside.view());
    information.zip_mut_with(&products.t(), |h, p| *h *= p);
    let along = blocked_matmul_h(derivative.view(), projection.residual.view());
    NewtonSystem {
        information,
        gradient: gradient(along.view(), residues),
    }
}

/// A point on an orthonormal basis: it keeps the digits that normal equations lose.
struct OrthonormalPoint {
    projection: Projection,
    coefficients: Array2<Complex64>,
}

impl OrthonormalPoint {
    fn new(work: &Columns, lambda: &[Complex64], powers: &[i32]) -> Result<Self, LinalgError> {
        let projection = Projection::new(work, lambda, powers)?;
        Ok(Self {
            coefficients: projection.coefficients()?,
            projection,
        })
    }
}

impl Point for OrthonormalPoint {
    const HAS_FALLBACK: bool = false;
    fn at(search: &SearchData, lambda: &[Complex64]) -> Option<Self> {
        Self::new(search.beside.work, lambda, search.beside.powers).ok()
    }
    fn sse(&self) -> f64 {
        self.projection.sse
    }
    fn rounding(&self, energy: f64) -> f64 {
        tol::STEP_ROUNDING * (energy * self.projection.sse).sqrt()
    }
    fn system(&self, search: &SearchData, lambda: &[Complex64]) -> NewtonSystem {
        newton_system(
            search.beside.work,
            lambda,
            &self.projection,
            &self.coefficients,
        )
    }
}

/// Refines the poles `start` to this precision: by normal equations as far as they go, then on an
/// orthonormal basis.
pub(crate) fn refine(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    precision: Precision,
) -> Result<Refined, LinalgError> {
    let search = SearchData::new(work, powers);
    let (descent, end) = by_normal_equations(&search, start, precision);
    on_orthonormal_basis(descent, end, precision)
}

/// Refines the poles of the band. Poles outside stand for background, and stay at their places.
pub(crate) fn refine_inside(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    precision: Precision,
) -> Result<Refined, LinalgError> {
    let moved = refined_poles(work, start, powers, precision)?;
    let moved_inside = |(old, new): (&Complex64, &Complex64)| match work.in_band(*old) {
        true => *new,
        false => *old,
    };
    let lambda: Vec<Complex64> = start.iter().zip(&moved).map(moved_inside).collect();
    refine(work, &lambda, powers, tol::NO_STEP)
}

/// The refined poles alone.
pub(crate) fn refined_poles(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    precision: Precision,
) -> Result<Vec<Complex64>, LinalgError> {
    let search = SearchData::new(work, powers);
    let (descent, end) = by_normal_equations(&search, start, precision);
    if end.is_some() || descent.steps == 0 {
        return Ok(descent.lambda);
    }
    Ok(on_orthonormal_basis(descent, None, precision)?.lambda)
}

/// The refined poles and their residual sum of squares.
pub(crate) fn refined_sum(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    precision: Precision,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    let search = SearchData::new(work, powers);
    let (descent, end) = by_normal_equations(&search, start, precision);
    let sum = match end {
        Some(point) => Some(point.sse()),
        // no step was asked for
        None if descent.steps == 0 => {
            NormalFit::at(work, &descent.lambda, powers).map(|fit| fit.sse())
        }
        None => None,
    };
    if let Some(sum) = sum {
        return Ok((descent.lambda, sum));
    }
    let refined = on_orthonormal_basis(descent, None, precision)?;
    Ok((refined.lambda, refined.projection.sse))
}

/// The residual sum of squares after a few steps, and the least that further ones can leave by what
/// the next of them promises; −∞ where that is not known.
pub(crate) fn sum_in_sight<'a>(
    search: &'a SearchData<'a>,
    start: &[Complex64],
    precision: Precision,
) -> Result<[f64; 2], LinalgError> {
    let (descent, end) = by_normal_equations(search, start, precision);
    match end {
        Some(point) => {
            let largest_fall = limits::GAIN_OVER_PROMISE * descent.promised_fall(&point);
            Ok([point.sse(), point.sse() - largest_fall])
        }
        None => {
            let refined = on_orthonormal_basis(descent, None, precision)?;
            Ok([refined.projection.sse, f64::NEG_INFINITY])
        }
    }
}

/// Makes steps by normal equations, as far as rounding allows. Returns the search, and its last
/// point if the refinement ended there: at this precision, or with its last step.
fn by_normal_equations<'a>(
    search: &'a SearchData<'a>,
    start: &[Complex64],
    precision: Precision,
) -> (Descent<'a>, Option<NormalPoint>) {
    let mut descent = Descent::new(search, start, precision.steps);
    let mut point = match descent.steps {
        0 => None,
        _ => descent.point::<NormalPoint>(),
    };
    let end = point.take_if(|point| descent.ends(point, precision.tolerance));
    (descent, end)
}

/// Goes on from where normal equations left the search; `end`: their last point if it has ended.
///
/// # Errors
/// A kernel that fails.
pub(super) fn on_orthonormal_basis(
    mut descent: Descent,
    end: Option<NormalPoint>,
    precision: Precision,
) -> Result<Refined, LinalgError> {
    let search = descent.search;
    let Beside { work, powers, .. } = search.beside;
    let information = end.map(|point| point.system(search, &descent.lambda).information);
    let mut point = OrthonormalPoint::new(work, &descent.lambda, powers)?;
    if information.is_none() {
        descent.run(&mut point, precision.tolerance);
    }
    let OrthonormalPoint {
        projection,
        coefficients,
    } = point;
    Ok(Refined {
        lambda: descent.lambda,
        powers: powers.to_vec(),
        projection,
        coefficients,
        information,
    })
}

/// The poles refined, if their residual sum of squares is below `sse_limit`. `None` if it is not, or
/// if the first step promises too little for that.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn refine_below(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    precision: Precision,
    sse_limit: f64,
) -> Result<Option<Refined>, LinalgError> {
    let search = SearchData::new(work, powers);
    let mut descent = Descent::new(&search, start, precision.steps);
    let mut point = descent.point::<NormalPoint>();
    if let Some(point) = &point {
        let largest_fall = limits::GAIN_OVER_PROMISE * descent.promised_fall(point);
        if point.sse() - largest_fall > sse_limit {
            return Ok(None);
        }
    }
    let end = point.take_if(|point| descent.ends(point, precision.tolerance));
    // the rest of `Refined` costs as much as a step: it is made only for a fit that is kept
    if end.as_ref().is_some_and(|point| point.sse() >= sse_limit) {
        return Ok(None);
    }
    let refined = on_orthonormal_basis(descent, end, precision)?;
    Ok((refined.projection.sse < sse_limit).then_some(refined))
}

impl Refined {
    /// Gauss–Newton matrix (DᴴP⊥D)∘(R̄Rᵀ), (n, n), on the lines and columns of the
    /// refinement.
    pub fn information(&self, work: &Columns) -> Array2<Complex64> {
        self.information.clone().unwrap_or_else(|| {
            let search = SearchData::new(work, &self.powers);
            let system = match NormalPoint::at(&search, &self.lambda) {
                Some(point) => point.system(&search, &self.lambda),
                None => newton_system(work, &self.lambda, &self.projection, &self.coefficients),
            };
            system.information
        })
    }
    /// Number of unknown columns m.
    pub fn unknowns(&self) -> usize {
        self.lambda.len() + self.powers.len()
    }
    /// True if there are lines enough to judge one more pole.
    pub fn has_room(&self, lines: usize) -> bool {
        self.unknowns() + 1 < lines
    }
    /// Residual variance per line and column, from all degrees of freedom.
    pub fn variance(&self, work: &Columns) -> f64 {
        let dof = ((work.lines() - self.unknowns().min(work.lines())) * work.columns()) as f64
            - self.lambda.len() as f64;
        self.projection.sse / dof.max(1.0)
    }
    /// For each pole, the rise of the sum of squares if it alone is taken out and residues are
    /// refitted: ‖X_q‖²/[(AᴴA)⁻¹]_qq (theory.md, eq. 8).
    pub fn significance(&self) -> Result<Vec<f64>, LinalgError> {
        let inverse = self.projection.gram_inverse()?;
        let rise = |q: usize| rise_without(q, &inverse, &self.coefficients);
        Ok((0..self.lambda.len()).map(rise).collect())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::damping::basis::{basis, RESIDUAL_POWERS};
    use chladni_frf::Damping;
    use ndarray::ShapeBuilder;

    /// Two resonances over three columns, with an error of this size that neither makes.
    pub(crate) fn two_resonances(poles: [Complex64; 2], error: f64) -> Columns {
        let lines = 200;
        let mut work = Columns {
            x: (1..=lines).map(|k| k as f64 / lines as f64).collect(),
            g: vec![1.0; lines],
            b: Array2::zeros((lines, 3).f()),
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let residue = |(n, c): (usize, usize)| Complex64::new(1.0 + n as f64, c as f64 - 1.0);
        work.b = matmul(
            basis(&work, &poles, &[]).view(),
            Array2::from_shape_fn((2, 3), residue).view(),
        );
        for ((k, c), value) in work.b.indexed_iter_mut() {
            *value += Complex64::from_polar(error, (37 * k * k + 11 * c) as f64);
        }
        work
    }

    #[test]
    fn a_fit_goes_on_where_its_first_step_promises_enough() {
        let poles = [Complex64::new(0.3, 0.01), Complex64::new(0.6, 0.02)];
        let work = two_resonances(poles, 0.1);
        let near = poles.map(|pole| pole + 0.1 * pole.im);
        let best = refine(&work, &near, &RESIDUAL_POWERS, tol::ROUGH).unwrap();
        let search = SearchData::new(&work, &RESIDUAL_POWERS);
        let descent = Descent::new(&search, &near, tol::ROUGH.steps);
        let point = descent.point::<NormalPoint>().unwrap();
        let (left, falls) = (best.projection.sse, point.sse() - best.projection.sse);
        let promised = descent.promised_fall(&point);
        assert!(
            (0.8..1.25).contains(&(falls / promised)),
            "{falls} of {promised}"
        );
        let below = |start: &[Complex64]| {
            refine_below(&work, start, &RESIDUAL_POWERS, tol::ROUGH, 1.1 * left)
        };
        assert!(below(&near).unwrap().is_some());
        assert!(below(&near[..1]).unwrap().is_none());
    }

    /// By normal equations, where these give up, and without a step.
    #[test]
    fn the_sum_of_squares_is_that_of_the_whole_refinement() {
        let poles = [Complex64::new(0.3, 0.01), Complex64::new(0.6, 0.02)];
        let twins = [poles[0], poles[0] + 1e-9];
        let work = two_resonances(poles, 0.1);
        for (start, steps) in [(poles, 30), (poles, 0), (twins, 3)] {
            let near = start.map(|pole| pole + 0.1 * pole.im);
            let (lambda, sum) =
                refined_sum(&work, &near, &RESIDUAL_POWERS, tol::FINE.within(steps)).unwrap();
            let whole = refine(&work, &near, &RESIDUAL_POWERS, tol::FINE.within(steps)).unwrap();
            assert_eq!(lambda, whole.lambda);
            assert!((sum / whole.projection.sse - 1.0).abs() < 1e-8, "{steps}");
        }
    }
}
