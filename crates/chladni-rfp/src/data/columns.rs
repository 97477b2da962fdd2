//! The data in the form that pole finders take: columns of receptance in the plane x = ω²/ω_max²
//! (theory.md, eq. 5).
//!
//! A structural mode contributes R/(λ − x) with λ = x_n(1 + jη_n): each pole occurs once, without its
//! conjugate, and every derivative is complex-analytic. The weight g turns receptance back into the
//! measured kind. So residuals are those of the measurement, and white noise stays white.

use crate::data::inner_products::sum_of_squares;
use crate::data::window::leakage::LeakingLines;
use chladni_frf::Damping;
use ndarray::{Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Range;

/// Weighted columns on the selected lines.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    /// x_k = ω_k²/ω_max², rising.
    pub x: Vec<f64>,
    /// Weight of receptance per line: |jω|^p normalised, times the line's 1/σ.
    pub g: Vec<f64>,
    /// Data with the same weights; axes (line, column), column-major.
    pub b: Array2<Complex64>,
    /// The law that poles follow: see [`crate::damping::columns`].
    pub law: Damping,
    /// Effect of records and windows on the columns of poles, if it is known.
    pub leakage: Option<LeakingLines>,
    /// Correlation of the errors of neighbouring lines by the way they were estimated.
    pub neighbours: f64,
}

impl Columns {
    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.x.len()
    }
    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.b.ncols()
    }
    /// Line spacing around x.
    pub fn spacing(&self, x: f64) -> f64 {
        let n = self.x.len();
        if n < 2 {
            return 1.0;
        }
        let k = self.x.partition_point(|v| *v < x).clamp(1, n - 1);
        self.x[k] - self.x[k - 1]
    }
    /// Lowest and highest x.
    pub fn range(&self) -> (f64, f64) {
        (
            self.x.first().copied().unwrap_or(0.0),
            self.x.last().copied().unwrap_or(0.0),
        )
    }
    /// True if the pole's natural frequency lies between the first and the last line.
    pub fn in_band(&self, lambda: Complex64) -> bool {
        let (low, high) = self.range();
        lambda.re >= low && lambda.re <= high
    }
    /// Sum of squares of the data.
    pub fn energy(&self) -> f64 {
        sum_of_squares(&self.b)
    }
    /// The lines within `half_widths` half-bandwidths of the pole, at least `least` on both sides.
    pub fn window(&self, lambda: Complex64, half_widths: f64, least: usize) -> Range<usize> {
        let reach = half_widths * lambda.im.abs();
        let centre = self.x.partition_point(|v| *v < lambda.re);
        let low = self
            .x
            .partition_point(|v| *v < lambda.re - reach)
            .min(centre.saturating_sub(least));
        let high = self
            .x
            .partition_point(|v| *v <= lambda.re + reach)
            .max((centre + least).min(self.x.len()));
        low..high
    }
    /// The same lines and weights with other columns.
    pub fn with_columns(&self, b: Array2<Complex64>) -> Self {
        Self {
            x: self.x.clone(),
            g: self.g.clone(),
            b,
            law: self.law,
            leakage: self.leakage.clone(),
            neighbours: self.neighbours,
        }
    }
    /// The same data, whose poles follow another law.
    pub fn in_law(self, law: Damping) -> Self {
        Self { law, ..self }
    }
    /// The same data, of records that hold samples in their first 1/`factor` alone.
    pub fn of_padded(self, factor: usize) -> Self {
        let leakage = self.leakage.map(|leaking| leaking.padded(factor));
        Self { leakage, ..self }
    }
    /// The same lines without data.
    pub fn axis(&self) -> Self {
        self.with_columns(Array2::zeros((self.lines(), 0)))
    }
    /// Some of these lines without data.
    pub fn axis_on(&self, rows: Range<usize>) -> Self {
        Self {
            x: self.x[rows.clone()].to_vec(),
            g: self.g[rows.clone()].to_vec(),
            b: Array2::zeros((rows.len(), 0)),
            law: self.law,
            leakage: self.leakage_on(rows),
            neighbours: self.neighbours,
        }
    }
    /// Only the given lines.
    pub fn select(&self, lines: &[usize]) -> Self {
        let mut b = Array2::zeros((lines.len(), self.columns()).f());
        for (row, &k) in lines.iter().enumerate() {
            b.row_mut(row).assign(&self.b.row(k));
        }
        Self {
            x: lines.iter().map(|&k| self.x[k]).collect(),
            g: lines.iter().map(|&k| self.g[k]).collect(),
            b,
            law: self.law,
            leakage: self.leakage_on(lines.iter().copied()),
            neighbours: self.neighbours,
        }
    }
    /// A stretch of lines.
    pub fn rows(&self, rows: Range<usize>) -> Self {
        let mut b = Array2::zeros((rows.len(), self.columns()).f());
        b.assign(&self.b.slice(ndarray::s![rows.clone(), ..]));
        Self {
            x: self.x[rows.clone()].to_vec(),
            g: self.g[rows.clone()].to_vec(),
            b,
            law: self.law,
            leakage: self.leakage_on(rows),
            neighbours: self.neighbours,
        }
    }
    fn leakage_on(&self, lines: impl Iterator<Item = usize>) -> Option<LeakingLines> {
        Some(self.leakage.as_ref()?.select(lines))
    }
    /// The same data with each line multiplied by its weight.
    pub fn reweighted(&self, weights: &[f64]) -> Self {
        let mut out = self.clone();
        out.weigh(weights);
        out
    }
    /// Multiplies data and g of each line by its weight. Empty `weights` change nothing.
    pub fn weigh(&mut self, weights: &[f64]) {
        for (k, &w) in weights.iter().enumerate() {
            self.g[k] *= w;
            self.b.row_mut(k).mapv_inplace(|v| v * w);
        }
    }
}

/// Mean square over the columns, of each line.
pub(crate) fn line_energy(b: &Array2<Complex64>) -> Array1<f64> {
    let mut energy = Array1::zeros(b.nrows());
    for column in b.columns() {
        for (sum, value) in energy.iter_mut().zip(column) {
            *sum += value.norm_sqr();
        }
    }
    energy / b.ncols().max(1) as f64
}
