//! Second-order cone programs in the words of this crate, solved by the interior-point
//! method of `clarabel`.
//!
//! minimise qᵀx with every expression that was added non-negative, and the first of every
//! cone at least the norm of the rest. The solver is deterministic and runs on one
//! thread.

use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Result};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use ndarray::ArrayView1;
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
    cones: Vec<SupportedConeT<f64>>,
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
        self.rows.push(expression);
        match self.cones.last_mut() {
            Some(SupportedConeT::NonnegativeConeT(size)) => *size += 1,
            _ => self.cones.push(SupportedConeT::NonnegativeConeT(1)),
        }
    }

    /// Demands that `bound` is at least the norm of all `parts`.
    pub(crate) fn norm_at_most(&mut self, bound: Affine, parts: impl IntoIterator<Item = Affine>) {
        let before = self.rows.len();
        self.rows.push(bound);
        self.rows.extend(parts);
        self.cones
            .push(SupportedConeT::SecondOrderConeT(self.rows.len() - before));
    }

    /// Solves the program; `None` where it has no solution, or none that the solver's own
    /// checks pass.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`] where the program is malformed: a bug.
    pub(crate) fn solve(&self) -> Result<Option<ConicSolution>> {
        let columns = self.objective.len();
        // b − A·x must lie in the cones, so that A holds the negative coefficients
        let mut by_column: Vec<Vec<(usize, f64)>> = vec![Vec::new(); columns];
        for (row, expression) in self.rows.iter().enumerate() {
            for &(column, coefficient) in &expression.terms {
                by_column[column].push((row, -coefficient));
            }
        }
        let mut starts = vec![0];
        let (mut places, mut values) = (Vec::new(), Vec::new());
        for column in &by_column {
            places.extend(column.iter().map(|entry| entry.0));
            values.extend(column.iter().map(|entry| entry.1));
            starts.push(places.len());
        }
        let matrix = CscMatrix::new(self.rows.len(), columns, starts, places, values);
        let right: Vec<f64> = self.rows.iter().map(|row| row.constant).collect();
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            max_iter: tolerances::CONIC_STEPS,
            tol_gap_abs: tolerances::CONIC_GAP,
            tol_gap_rel: tolerances::CONIC_GAP,
            tol_feas: tolerances::CONIC_GAP,
            iterative_refinement_reltol: tolerances::CONIC_REFINEMENT,
            iterative_refinement_abstol: tolerances::CONIC_REFINEMENT,
            ..DefaultSettings::default()
        };
        let quadratic = CscMatrix::zeros((columns, columns));
        let mut solver = DefaultSolver::new(
            &quadratic,
            &self.objective,
            &matrix,
            &right,
            &self.cones,
            settings,
        )
        .map_err(|error| {
            Error::new(
                ErrorKind::Internal,
                format!("malformed conic program: {error}"),
            )
        })?;
        solver.solve();
        let usable = matches!(
            solver.solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        );
        let finite = solver.solution.x.iter().all(|value| value.is_finite());
        Ok((usable && finite).then(|| ConicSolution {
            x: std::mem::take(&mut solver.solution.x),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
