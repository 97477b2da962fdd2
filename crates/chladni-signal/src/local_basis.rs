//! The basis of local fits, which the local polynomial and the local rational method share: the
//! columns of the references and of the transient on the lines around one frequency.

use crate::force_noise::ForceNoise;
use crate::limits::{BASIS_SINGULAR, DEGREE, SPARE_LINES};
use num_complex::Complex64;

/// Coefficients of one polynomial.
const TERMS: usize = DEGREE + 1;

/// Lines that one frequency wants: an odd number, so that the frequency is one of them.
pub(super) fn wanted_lines(references: usize) -> usize {
    (unknowns(references) + SPARE_LINES) | 1
}

/// Unknowns of one response.
pub(super) fn unknowns(references: usize) -> usize {
    TERMS * (references + 1)
}

/// FRFs of one response at one frequency.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LocalEstimate {
    /// Value and variance per reference.
    pub values: Vec<(Complex64, f64)>,
    /// Part of the response's power that the fit explains.
    pub coherence: f64,
}

/// Everything that a local fit tells of one frequency.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LocalLine {
    /// One per response.
    pub responses: Vec<LocalEstimate>,
    /// The force's noise, where the method tells it.
    pub force_noise: Option<ForceNoise>,
}

/// Lines around one frequency.
pub(super) struct LocalLines<'a> {
    /// Place of each line, −1 to 1.
    pub places: Vec<f64>,
    /// Spectrum of each reference on these lines.
    pub references: Vec<&'a [Complex64]>,
    /// Spectrum of each response on these lines.
    pub responses: Vec<&'a [Complex64]>,
}

/// Orthonormal columns that span the transients and Σ_j B_j·X_j on weighted lines.
pub(super) struct Basis {
    lines: usize,
    /// One after another; those of B_j(0) last.
    columns: Vec<Complex64>,
    /// Triangular factor of the last columns, those of B_j(0): [row][column].
    last: Vec<Vec<Complex64>>,
}

/// A vector split by a basis.
pub(super) struct Split {
    /// The part that the basis does not hold.
    pub rest: Vec<Complex64>,
    /// B_j(0) per reference.
    pub at_centre: Vec<Complex64>,
}

impl Basis {
    /// `None` where a reference has no power, or two act as one. `weight`: of each line.
    pub(super) fn new(local: &LocalLines, weight: &[f64]) -> Option<Self> {
        let lines = local.places.len();
        let references = &local.references;
        let ones = std::iter::repeat_n(Complex64::from(1.0), lines);
        let mut columns = Vec::with_capacity(lines * unknowns(references.len()));
        let mut add = |values: &mut dyn Iterator<Item = Complex64>, power: usize| {
            let places = local.places.iter().zip(weight);
            columns.extend(
                values
                    .zip(places)
                    .map(|(value, (place, weight))| value * place.powi(power as i32) * weight),
            );
        };
        for power in 0..TERMS {
            add(&mut ones.clone(), power);
        }
        for power in (0..TERMS).rev() {
            for reference in references {
                add(&mut reference.iter().copied(), power);
            }
        }
        let mut basis = Self {
            lines,
            columns,
            last: Vec::new(),
        };
        basis.orthonormalise(references.len()).then_some(basis)
    }

    /// Gram and Schmidt, each projection taken off at once (modified).
    fn orthonormalise(&mut self, references: usize) -> bool {
        let count = self.columns.len() / self.lines;
        self.last = vec![vec![Complex64::default(); references]; references];
        for at in 0..count {
            let (done, rest) = self.columns.split_at_mut(at * self.lines);
            let column = &mut rest[..self.lines];
            let before = norm(column);
            for (index, unit) in done.chunks_exact(self.lines).enumerate() {
                let part = take_off(column, unit);
                if let (Some(row), Some(column)) = (
                    (index + references).checked_sub(count),
                    (at + references).checked_sub(count),
                ) {
                    self.last[row][column] = part;
                }
            }
            let length = norm(column);
            if length.is_nan() || length <= BASIS_SINGULAR * before {
                return false;
            }
            column.iter_mut().for_each(|value| *value /= length);
            if let Some(place) = (at + references).checked_sub(count) {
                self.last[place][place] = length.into();
            }
        }
        true
    }

    /// The rest of `vector`, and its B_j(0).
    pub(super) fn split(&self, mut vector: Vec<Complex64>) -> Split {
        let count = self.columns.len() / self.lines;
        let references = self.last.len();
        let mut parts = vec![Complex64::default(); references];
        for (index, unit) in self.columns.chunks_exact(self.lines).enumerate() {
            let part = take_off(&mut vector, unit);
            if let Some(row) = (index + references).checked_sub(count) {
                parts[row] = part;
            }
        }
        Split {
            rest: vector,
            at_centre: self.solve(parts),
        }
    }

    /// Backward substitution.
    fn solve(&self, mut parts: Vec<Complex64>) -> Vec<Complex64> {
        for row in (0..parts.len()).rev() {
            for column in row + 1..parts.len() {
                let known = self.last[row][column] * parts[column];
                parts[row] -= known;
            }
            parts[row] /= self.last[row][row];
        }
        parts
    }

    /// Variance of each B_j(0) for noise of variance 1 on every line: the diagonal of
    /// R⁻¹R⁻ᴴ.
    pub(super) fn unit_variance(&self) -> Vec<f64> {
        let references = self.last.len();
        let mut sum = vec![0.0; references];
        for column in 0..references {
            let mut unit = vec![Complex64::default(); references];
            unit[column] = 1.0.into();
            for (sum, value) in sum.iter_mut().zip(self.solve(unit)) {
                *sum += value.norm_sqr();
            }
        }
        sum
    }
}

/// Takes the part along `unit` off `vector`, and returns it.
fn take_off(vector: &mut [Complex64], unit: &[Complex64]) -> Complex64 {
    let part = inner(unit, vector);
    for (value, unit) in vector.iter_mut().zip(unit) {
        *value -= part * unit;
    }
    part
}

/// aᴴb.
pub(super) fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

/// ‖a‖².
pub(super) fn square(a: &[Complex64]) -> f64 {
    a.iter().map(Complex64::norm_sqr).sum()
}

fn norm(a: &[Complex64]) -> f64 {
    square(a).sqrt()
}

/// Part of the response's power that the fit explains, where noise of `variance` is left
/// on each line.
pub(super) fn coherence(response: &[Complex64], variance: f64) -> f64 {
    let power = square(response) / response.len() as f64;
    (1.0 - variance / power).clamp(0.0, 1.0)
}
