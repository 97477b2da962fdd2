//! Conic programs with dense rows by primal-dual interior-point steps.
//!
//! Least c·x with s = F·x + h in the cones, and largest −h·z with Fᵀz = c and z in the
//! cones. From a pair s, z with the scaling W each step solves
//!
//! Fᵀdz = (1−σ)(c − Fᵀz),  ds − F·dx = (1−σ)(F·x + h − s),  W⁻¹ds + W·dz = d
//!
//! first with d = −λ, σ = 0 to see how far that leads, then with σ = (1 − that)³ and the
//! products of the first step in d (Mehrotra 1992). What is left of it is one symmetric
//! system FᵀW⁻²F (module [`normal_equations`](super::normal_equations)): for some 70
//! variables and hundreds of full rows it takes a fifth of the time of a sparse
//! factorisation of all rows.

use super::cones::{dot, norm, Cones, Scaling};
use super::normal_equations::{Factor, NormalEquations, StandardForm};
use crate::tolerances;

/// The end of the steps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outcome {
    /// The variables.
    Solved(Vec<f64>),
    /// Proven to have no solution, or none of least cost.
    Impossible,
    /// Steps that lead nowhere.
    Unsure,
}

struct Solver<'a> {
    form: &'a StandardForm,
    normal: NormalEquations<'a>,
}

/// A pair inside the cones, and what it leaves of the equations.
struct Iterate {
    x: Vec<f64>,
    s: Vec<f64>,
    z: Vec<f64>,
    /// c − Fᵀz.
    dual_residual: Vec<f64>,
    /// F·x + h − s.
    primal_residual: Vec<f64>,
}

/// The right-hand side of a step.
struct Aim<'a> {
    /// 1 − σ.
    share: f64,
    /// d.
    sum: &'a [f64],
    /// True where rounding of the factor is taken out.
    refine: bool,
}

/// A step, ds and dz scaled to W⁻¹ds and W·dz.
struct Direction {
    x: Vec<f64>,
    s: Vec<f64>,
    z: Vec<f64>,
}

/// Solves `form`.
pub(crate) fn solve(form: &StandardForm) -> Outcome {
    let solver = Solver {
        form,
        normal: NormalEquations::new(form),
    };
    let Some(mut at) = solver.start() else {
        return Outcome::Unsure;
    };
    for _ in 0..tolerances::CONIC_STEPS {
        if let Some(outcome) = solver.judge(&at) {
            return outcome;
        }
        if !solver.step(&mut at) {
            break;
        }
    }
    Outcome::Unsure
}

impl Solver<'_> {
    /// Least squares, moved inside the cones.
    fn start(&self) -> Option<Iterate> {
        let Self { form, normal } = self;
        let mut one = vec![0.0; form.constant.len()];
        form.cones.add_identity(&mut one, 1.0);
        let factor = normal.factor(&form.cones.scaling(&one, &one))?;
        let mut x = factor.solve(&normal.transposed(&form.constant));
        x.iter_mut().for_each(|value| *value = -*value);
        let mut s = sum(&normal.times(&x), &form.constant, 1.0);
        let mut z = normal.times(&factor.solve(&form.cost));
        for inside in [&mut s, &mut z] {
            let least = form.cones.least_eigenvalue(inside);
            if least < tolerances::CONIC_START {
                form.cones
                    .add_identity(inside, tolerances::CONIC_START - least);
            }
        }
        Some(self.at(x, s, z))
    }

    fn at(&self, x: Vec<f64>, s: Vec<f64>, z: Vec<f64>) -> Iterate {
        let moved = sum(&self.normal.times(&x), &self.form.constant, 1.0);
        Iterate {
            dual_residual: sum(&self.form.cost, &self.normal.transposed(&z), -1.0),
            primal_residual: sum(&moved, &s, -1.0),
            x,
            s,
            z,
        }
    }

    /// The outcome where it is known.
    fn judge(&self, at: &Iterate) -> Option<Outcome> {
        let form = self.form;
        let gap = dot(&at.s, &at.z);
        let (primal, dual) = (dot(&form.cost, &at.x), -dot(&form.constant, &at.z));
        if !(gap.is_finite() && primal.is_finite() && dual.is_finite()) {
            return Some(Outcome::Unsure);
        }
        let scale = |vectors: &[&[f64]]| 1.0 + vectors.iter().map(|v| norm(v)).sum::<f64>();
        let feasible = norm(&at.primal_residual)
            <= tolerances::CONIC_GAP * scale(&[&form.constant, &at.x, &at.s])
            && norm(&at.dual_residual) <= tolerances::CONIC_GAP * scale(&[&form.cost, &at.z]);
        let size = primal.abs().min(dual.abs()).max(1.0);
        if feasible && gap <= tolerances::CONIC_GAP * size {
            return Some(Outcome::Solved(at.x.clone()));
        }
        // z with Fᵀz = 0 and h·z < 0, or F·x in the cones with c·x < 0
        let back = sum(&form.cost, &at.dual_residual, -1.0);
        let no_point = dual > 0.0 && norm(&back) <= tolerances::CONIC_PROOF * dual;
        let beyond = sum(&at.primal_residual, &form.constant, -1.0);
        let no_least = primal < 0.0 && norm(&beyond) <= tolerances::CONIC_PROOF * -primal;
        (no_point || no_least).then_some(Outcome::Impossible)
    }

    /// Moves on; false where that leads nowhere.
    fn step(&self, at: &mut Iterate) -> bool {
        let cones = &self.form.cones;
        let scaling = cones.scaling(&at.s, &at.z);
        let Some(factor) = self.normal.factor(&scaling) else {
            return false;
        };
        let lambda = &scaling.lambda;
        let toward: Vec<f64> = lambda.iter().map(|value| -value).collect();
        let aim = Aim {
            share: 1.0,
            sum: &toward,
            refine: false,
        };
        let first = self.direction(&factor, &scaling, at, &aim);
        let sigma = (1.0 - cones.longest(lambda, &first).min(1.0)).powi(3);
        let mut right = cones.product(lambda, lambda);
        for (value, product) in right.iter_mut().zip(cones.product(&first.s, &first.z)) {
            *value = -*value - product;
        }
        cones.add_identity(&mut right, sigma * dot(lambda, lambda) / cones.degree());
        let aim = Aim {
            share: 1.0 - sigma,
            sum: &cones.quotient(&right, lambda),
            refine: true,
        };
        let mut step = self.direction(&factor, &scaling, at, &aim);
        let length = (tolerances::CONIC_STEP * cones.longest(lambda, &step)).min(1.0);
        cones.scale(&scaling, &mut step.s);
        cones.unscale(&scaling, &mut step.z);
        let moved = |from: &[f64], step: &[f64]| sum(from, step, length);
        *at = self.at(
            moved(&at.x, &step.x),
            moved(&at.s, &step.s),
            moved(&at.z, &step.z),
        );
        length > tolerances::CONIC_LEAST_STEP
    }

    fn direction(&self, factor: &Factor, scaling: &Scaling, at: &Iterate, aim: &Aim) -> Direction {
        let cones = &self.form.cones;
        // W⁻¹(1−σ)(F·x + h − s) − d
        let mut fixed: Vec<f64> = at.primal_residual.iter().map(|v| aim.share * v).collect();
        cones.unscale(scaling, &mut fixed);
        let fixed = sum(&fixed, aim.sum, -1.0);
        let of = |x: &[f64]| {
            let mut moved = self.normal.times(x);
            cones.unscale(scaling, &mut moved);
            let z: Vec<f64> = moved.iter().zip(&fixed).map(|(m, f)| -m - f).collect();
            z
        };
        // what z leaves of its equation: −FᵀW⁻²F times the error of x
        let residual = |z: &[f64]| {
            let mut plain = z.to_vec();
            cones.unscale(scaling, &mut plain);
            sum(
                &self.normal.transposed(&plain),
                &at.dual_residual,
                -aim.share,
            )
        };
        let at_rest: Vec<f64> = fixed.iter().map(|value| -value).collect();
        let mut x = factor.solve(&residual(&at_rest));
        let mut z = of(&x);
        if aim.refine {
            x = sum(&x, &factor.solve(&residual(&z)), 1.0);
            z = of(&x);
        }
        let s = sum(aim.sum, &z, -1.0);
        Direction { x, s, z }
    }
}

impl Cones {
    /// The longest step of both vectors of a direction.
    fn longest(&self, lambda: &[f64], direction: &Direction) -> f64 {
        let of = |part: &[f64]| self.longest_step(lambda, part);
        of(&direction.s).min(of(&direction.z))
    }
}

/// a + factor·b.
fn sum(a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}
