//! Conic programs under construction: expressions, cones, and what is minimised.

use super::cones::{Cone, Cones};
use super::normal_equations::StandardForm;
use ndarray::{Array2, ArrayView1};
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
    pub(super) objective: Vec<f64>,
    pub(super) rows: Vec<Affine>,
    pub(super) cones: Vec<Cone>,
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

    /// The rows as one matrix, for the dense solver.
    pub(super) fn standard_form(&self) -> StandardForm {
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
