//! Second-order cone programs in the words of this crate.
//!
//! minimise qᵀx with every expression that was added non-negative, and the first of every
//! cone at least the norm of the rest. The rows of a drive are dense, and programs of
//! dense rows have a solver of their own (module [`interior_point`]); where its steps lead
//! nowhere, that of `clarabel` decides (module [`sparse`]). Both are deterministic and
//! run on one thread.

mod cones;
mod interior_point;
mod normal_equations;
mod sparse;

use chladni_frf::Result;
use cones::{Cone, Cones};
use interior_point::Outcome;
use ndarray::{Array2, ArrayView1};
use normal_equations::StandardForm;
use num_complex::Complex64;

/// Σ coefficient·variable + constant.
#[derive(Debug, Clone, Default)]
pub(crate) struct Affine {
    pub(crate) terms: Vec<(usize, f64)>,
    pub(crate) constant: f64,
}

impl Affine {
    /// A multiple of one variable.
    pub(crate) fn of(variable: usize, coefficient: f64) -> Self {
        Self {
            terms: vec![(variable, coefficient)],
            constant: 0.0,
        }
    }

    /// A number.
    pub(crate) fn constant(constant: f64) -> Self {
        Self {
            terms: Vec::new(),
            constant,
        }
    }

    /// The same plus a multiple of a variable.
    pub(crate) fn plus(mut self, variable: usize, coefficient: f64) -> Self {
        self.terms.push((variable, coefficient));
        self
    }

    /// Its value.
    pub(crate) fn at(&self, x: &[f64]) -> f64 {
        let terms = self.terms.iter();
        self.constant
            + terms
                .map(|&(variable, factor)| factor * x[variable])
                .sum::<f64>()
    }

    /// The same plus a number.
    pub(crate) fn plus_constant(mut self, constant: f64) -> Self {
        self.constant += constant;
        self
    }

    /// The same less `factor` times another; both may name different variables only.
    pub(crate) fn minus(mut self, other: &Self, factor: f64) -> Self {
        self.terms.extend(
            other
                .terms
                .iter()
                .map(|&(variable, coefficient)| (variable, -factor * coefficient)),
        );
        self.plus_constant(-factor * other.constant)
    }

    /// Real and imaginary part of Σ_i row_i·x_i, where variable i holds Re x_i and
    /// variable i + (their number) holds Im x_i.
    pub(crate) fn complex_row(row: ArrayView1<Complex64>) -> [Self; 2] {
        let count = row.len();
        let part =
            |of_real: &dyn Fn(Complex64) -> f64, of_imaginary: &dyn Fn(Complex64) -> f64| Self {
                terms: row
                    .iter()
                    .enumerate()
                    .flat_map(|(i, &value)| [(i, of_real(value)), (count + i, of_imaginary(value))])
                    .filter(|&(_, coefficient)| coefficient != 0.0)
                    .collect(),
                constant: 0.0,
            };
        [
            part(&|value| value.re, &|value| -value.im),
            part(&|value| value.im, &|value| value.re),
        ]
    }
}

/// A program under construction.
#[derive(Debug, Clone)]
pub(crate) struct ConicProgram {
    objective: Vec<f64>,
    rows: Vec<Affine>,
    cones: Vec<Cone>,
}

/// The result of the solver.
#[derive(Debug, Clone)]
pub(crate) struct ConicSolution {
    /// Values of the variables.
    pub(crate) x: Vec<f64>,
}

impl ConicProgram {
    /// A program in so many variables, without objective.
    pub(crate) fn new(variables: usize) -> Self {
        Self {
            objective: vec![0.0; variables],
            rows: Vec::new(),
            cones: Vec::new(),
        }
    }

    /// Adds `coefficient`·variable to what is minimised.
    pub(crate) fn minimise(&mut self, variable: usize, coefficient: f64) {
        self.objective[variable] += coefficient;
    }

    /// Demands that the expression is not negative.
    pub(crate) fn not_negative(&mut self, expression: Affine) {
        let row = self.rows.len();
        self.rows.push(expression);
        match self.cones.last_mut() {
            Some(Cone::NotNegative(rows)) => rows.end += 1,
            _ => self.cones.push(Cone::NotNegative(row..row + 1)),
        }
    }

    /// Demands that `bound` is at least the norm of all `parts`.
    pub(crate) fn norm_at_most(&mut self, bound: Affine, parts: impl IntoIterator<Item = Affine>) {
        let before = self.rows.len();
        self.rows.push(bound);
        self.rows.extend(parts);
        self.cones.push(Cone::Norm(before..self.rows.len()));
    }

    /// Solves the program; `None` where it has no solution, or none that the solvers' own
    /// checks pass.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Internal`] where the program is malformed: a bug.
    pub(crate) fn solve(&self) -> Result<Option<ConicSolution>> {
        match interior_point::solve(&self.standard_form()) {
            Outcome::Solved(x) => Ok(Some(ConicSolution { x })),
            Outcome::Impossible => Ok(None),
            Outcome::Unsure => sparse::solve(self),
        }
    }

    fn standard_form(&self) -> StandardForm {
        let mut rows = Array2::zeros((self.rows.len(), self.objective.len()));
        for (mut row, expression) in rows.rows_mut().into_iter().zip(&self.rows) {
            for &(variable, coefficient) in &expression.terms {
                row[variable] += coefficient;
            }
        }
        StandardForm {
            cost: self.objective.clone(),
            rows,
            constant: self.rows.iter().map(|row| row.constant).collect(),
            cones: Cones(self.cones.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_nearest_point_of_a_line_is_found() {
        // least t ≥ ‖(x, y)‖ on x + y ≥ 2: (1, 1), t = √2
        let mut program = ConicProgram::new(3);
        program.minimise(2, 1.0);
        program.not_negative(Affine::of(0, 1.0).plus(1, 1.0).plus_constant(-2.0));
        program.norm_at_most(Affine::of(2, 1.0), [Affine::of(0, 1.0), Affine::of(1, 1.0)]);
        let x = program.solve().unwrap().expect("a solution").x;
        for (found, expected) in x.iter().zip([1.0, 1.0, 2f64.sqrt()]) {
            assert!((found - expected).abs() < 1e-6, "{x:?}");
        }
    }

    #[test]
    fn what_cannot_be_met_has_no_solution() {
        let mut program = ConicProgram::new(1);
        program.not_negative(Affine::of(0, 1.0).plus_constant(-1.0));
        program.not_negative(Affine::of(0, -1.0));
        assert!(program.solve().unwrap().is_none());
    }

    /// Least ‖x‖ with rows that must reach far and complex ones that must stay small, both
    /// kept by a point drawn before.
    fn drawn(random: &mut ChaCha8Rng) -> ConicProgram {
        const VARIABLES: usize = 12;
        let mut draw = || random.random_range(-1.0..1.0);
        let known: Vec<f64> = (0..VARIABLES).map(|_| draw()).collect();
        let mut row = || {
            let terms = (0..VARIABLES).map(|k| (k, draw())).collect();
            Affine {
                terms,
                constant: 0.0,
            }
        };
        let mut program = ConicProgram::new(VARIABLES + 1);
        program.minimise(VARIABLES, 1.0);
        for _ in 0..20 {
            let hot = row();
            let least = hot.at(&known) - 0.1;
            program.not_negative(hot.plus_constant(-least));
            let cold = [row(), row()];
            let most = cold[0].at(&known).hypot(cold[1].at(&known)) + 0.1;
            program.norm_at_most(Affine::default().plus_constant(most), cold);
        }
        let every = (0..VARIABLES).map(|k| Affine::of(k, 1.0));
        program.norm_at_most(Affine::of(VARIABLES, 1.0), every);
        program
    }

    #[test]
    fn dense_steps_and_clarabel_find_the_same_least_cost() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for number in 0..100 {
            let program = drawn(&mut random);
            let Outcome::Solved(x) = interior_point::solve(&program.standard_form()) else {
                panic!("program {number}: the dense steps do not end");
            };
            let judge = sparse::solve(&program).unwrap().expect("a solution").x;
            let (found, expected) = (x[x.len() - 1], judge[judge.len() - 1]);
            assert!(
                (found - expected).abs() < 1e-6 * expected.max(1.0),
                "program {number}: {found}, clarabel {expected}"
            );
            let inside = program
                .rows
                .iter()
                .map(|row| row.at(&x))
                .collect::<Vec<_>>();
            let least = Cones(program.cones.clone()).least_eigenvalue(&inside);
            assert!(least > -1e-6, "program {number}: {least} outside the cones");
        }
    }

    #[test]
    fn a_complex_row_is_a_real_and_an_imaginary_one() {
        let row = ndarray::array![Complex64::new(1.0, 2.0), Complex64::new(0.0, -1.0)];
        let x = [3.0, 4.0, 5.0, 6.0];
        let expected: Complex64 =
            row[0] * Complex64::new(3.0, 5.0) + row[1] * Complex64::new(4.0, 6.0);
        let value = |part: &Affine| part.terms.iter().map(|&(i, c)| c * x[i]).sum::<f64>();
        let [re, im] = Affine::complex_row(row.view());
        assert_eq!((value(&re), value(&im)), (expected.re, expected.im));
    }
}
