//! The normal equations FᵀW⁻²F of an interior-point step, from dense rows F.

use super::cones::{dot, inverse_entry, Cone, Cones, Scaling};
use crate::tolerances;
use chladni_linalg::{cholesky, matmul, matmul_h};
use ndarray::{s, Array2, ArrayView1, ArrayView2, Axis};
use std::f64::consts::SQRT_2;
use std::ops::Range;

/// A program: least cost·x with rows·x + constant inside the cones.
pub(crate) struct StandardForm {
    pub(crate) cost: Vec<f64>,
    /// Axes (row, variable), in standard order.
    pub(crate) rows: Array2<f64>,
    pub(crate) constant: Vec<f64>,
    pub(crate) cones: Cones,
}

/// The way in which the rows of a cone enter the sum.
enum Part {
    /// Scaled by W⁻¹, as rows of a product.
    Dense,
    /// By W⁻² = (2(Jw)(Jw)ᵀ − J)/η²: one row, and −FᵀJF that stays.
    Wide(Array2<f64>),
    /// Few terms of each row, by themselves.
    Sparse(Vec<Vec<(usize, f64)>>),
}

/// Rows and cones of a program, ready for one sum after the other.
pub(crate) struct NormalEquations<'a> {
    form: &'a StandardForm,
    parts: Vec<Part>,
    /// Rows of the product.
    scaled_rows: usize,
}

/// A sum that is factorised.
pub(crate) struct Factor {
    lower: Array2<f64>,
}

impl<'a> NormalEquations<'a> {
    /// Of a program.
    pub(crate) fn new(form: &'a StandardForm) -> Self {
        let parts: Vec<Part> = form
            .cones
            .0
            .iter()
            .map(|cone| Part::of(cone, form))
            .collect();
        let count = |(part, cone): (&Part, &Cone)| match part {
            Part::Dense => cone.rows().len(),
            Part::Wide(_) => 1,
            Part::Sparse(_) => 0,
        };
        Self {
            form,
            scaled_rows: parts.iter().zip(&form.cones.0).map(count).sum(),
            parts,
        }
    }

    /// The sum under a scaling; `None` where rounding leaves it without a factor.
    pub(crate) fn factor(&self, scaling: &Scaling) -> Option<Factor> {
        let variables = self.form.cost.len();
        let mut scaled = vec![0.0; self.scaled_rows * variables];
        let mut sum = Array2::zeros((variables, variables));
        let mut next = 0;
        for (k, (cone, part)) in self.form.cones.0.iter().zip(&self.parts).enumerate() {
            let (w, eta) = (scaling.w(cone), scaling.eta(k));
            match part {
                Part::Dense => {
                    let count = cone.rows().len();
                    self.scale_rows(cone, w, eta, &mut scaled[next * variables..]);
                    next += count;
                }
                Part::Wide(fixed) => {
                    let row = &mut scaled[next * variables..][..variables];
                    for (i, (w, of_cone)) in w.iter().zip(self.rows_of(cone)).enumerate() {
                        let sign = if i == 0 { 1.0 } else { -1.0 };
                        add_multiple(row, sign * SQRT_2 * w / eta, of_cone);
                    }
                    sum.scaled_add(eta.powi(-2), fixed);
                    next += 1;
                }
                Part::Sparse(terms) => add_sparse(cone, w, eta, terms, &mut sum),
            }
        }
        let scaled = ArrayView2::from_shape((self.scaled_rows, variables), &scaled).ok()?;
        sum += &matmul_h(scaled, scaled);
        let mean = sum.diag().sum() / variables as f64;
        sum.diag_mut()
            .mapv_inplace(|value| value + mean * tolerances::CONIC_RIDGE);
        let lower = cholesky(sum.view()).ok()?;
        // rows that lie side by side
        let lower = lower.as_standard_layout().into_owned();
        Some(Factor { lower })
    }

    /// Adds W⁻¹F of a cone to rows in standard order.
    fn scale_rows(&self, cone: &Cone, w: &[f64], eta: f64, to: &mut [f64]) {
        let to = to.chunks_exact_mut(self.form.cost.len().max(1));
        match cone {
            Cone::NotNegative(_) => {
                for ((to, row), w) in to.zip(self.rows_of(cone)).zip(w) {
                    add_multiple(to, 1.0 / w, row);
                }
            }
            Cone::Norm(rows) => {
                for (i, to) in to.take(rows.len()).enumerate() {
                    for (j, row) in self.rows_of(cone).enumerate() {
                        add_multiple(to, inverse_entry(w, eta, i, j), row);
                    }
                }
            }
        }
    }

    /// The rows F of a cone.
    fn rows_of(&self, cone: &Cone) -> impl Iterator<Item = &[f64]> {
        let variables = self.form.cost.len();
        let rows = self.form.rows.as_slice().unwrap_or_default();
        let Range { start, end } = cone.rows();
        rows[start * variables..end * variables].chunks_exact(variables.max(1))
    }

    /// F·x.
    pub(crate) fn times(&self, x: &[f64]) -> Vec<f64> {
        product(self.form.rows.view(), x)
    }

    /// Fᵀ·z.
    pub(crate) fn transposed(&self, z: &[f64]) -> Vec<f64> {
        product(self.form.rows.t(), z)
    }
}

fn product(matrix: ArrayView2<f64>, vector: &[f64]) -> Vec<f64> {
    let column = ArrayView1::from(vector).insert_axis(Axis(1));
    matmul(matrix, column).into_raw_vec_and_offset().0
}

/// a ← a + factor·b.
fn add_multiple(a: &mut [f64], factor: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}

impl Part {
    fn of(cone: &Cone, form: &StandardForm) -> Self {
        let rows = form.rows.slice(s![cone.rows(), ..]);
        let of_row = |row: ndarray::ArrayView1<f64>| -> Vec<(usize, f64)> {
            let terms = row.into_iter().copied().enumerate();
            terms.filter(|term| term.1 != 0.0).collect()
        };
        let terms: Vec<Vec<(usize, f64)>> = rows.rows().into_iter().map(of_row).collect();
        let count = terms.iter().map(Vec::len).sum::<usize>();
        match cone {
            _ if count * count <= form.cost.len() => Self::Sparse(terms),
            Cone::Norm(_) if rows.nrows() > tolerances::WIDE_CONE => {
                let others = rows.slice(s![1.., ..]);
                let mut fixed = matmul_h(others, others);
                for &(i, a) in &terms[0] {
                    for &(j, b) in &terms[0] {
                        fixed[[i, j]] -= a * b;
                    }
                }
                Self::Wide(fixed)
            }
            _ => Self::Dense,
        }
    }
}

/// Adds FᵀW⁻²F of a cone whose rows have few terms.
fn add_sparse(
    cone: &Cone,
    w: &[f64],
    eta: f64,
    terms: &[Vec<(usize, f64)>],
    sum: &mut Array2<f64>,
) {
    let weight = |i: usize, j: usize| match cone {
        Cone::NotNegative(_) if i != j => 0.0,
        Cone::NotNegative(_) => w[i].powi(-2),
        Cone::Norm(_) => (0..w.len())
            .map(|k| inverse_entry(w, eta, i, k) * inverse_entry(w, eta, k, j))
            .sum(),
    };
    for (i, of_first) in terms.iter().enumerate() {
        for (j, of_second) in terms.iter().enumerate() {
            let weight = weight(i, j);
            for &(a, first) in of_first {
                for &(b, second) in of_second {
                    sum[[a, b]] += weight * first * second;
                }
            }
        }
    }
}

impl Factor {
    /// The x of L·Lᵀ·x = right.
    pub(crate) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let count = right.len();
        let mut x = right.to_vec();
        let lower = self.lower.as_slice().unwrap_or_default();
        let row = |i: usize| &lower[i * count..=i * count + i];
        for i in 0..count {
            let row = row(i);
            x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
        }
        for i in (0..count).rev() {
            let row = row(i);
            let value = x[i] / row[i];
            x[i] = value;
            for (x, lower) in x[..i].iter_mut().zip(row) {
                *x -= value * lower;
            }
        }
        x
    }
}
