//! Pole columns and their derivatives, and the inner products of them all by partial
//! fractions: one sum over lines for each pole in place of one for each pair.
//!
//! 1/((ā − x)(b − x)) = [1/(ā − x) − 1/(b − x)]/(b − ā), and derivatives of that. No
//! digit is lost: ā lies below the real axis and b above, however near a and b are.

use crate::damping::columns::inverse;
use crate::damping::columns::{loss, resonance, Leaking};
use crate::damping::limits;
use crate::data::columns::Columns;
use chladni_frf::Damping;
use chladni_linalg::blocked::blocked_matmul_h;
use chladni_linalg::matmul_h;
use ndarray::{s, Array2, ArrayViewMut1, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// The columns of one set of poles, all above the real axis, in the law of the lines.
pub(crate) struct Cauchy<'a> {
    lambda: &'a [Complex64],
    /// Pole columns A, residual terms, and, unless left out, derivatives D of the pole
    /// columns, (line, n + terms + n): see [`crate::damping::structural::basis`].
    pub columns: Array2<Complex64>,
    /// Number of residual terms.
    terms: usize,
    /// Σ g²/(λ − x) and, with derivatives, Σ g²/(λ − x)².
    sums: Vec<[Complex64; 2]>,
    /// The columns follow the structural law and nothing leaks.
    rational: bool,
}

impl<'a> Cauchy<'a> {
    /// On the lines of `work`, with its weights.
    pub fn new(work: &Columns, lambda: &'a [Complex64], powers: &[i32]) -> Self {
        Self::with(work, lambda, powers, true)
    }

    /// The same without derivatives, at half the cost.
    pub fn without_derivatives(work: &Columns, lambda: &'a [Complex64], powers: &[i32]) -> Self {
        Self::with(work, lambda, powers, false)
    }

    /// With the derivatives of all poles, or of none.
    fn with(work: &Columns, lambda: &'a [Complex64], powers: &[i32], derivatives: bool) -> Self {
        let (n, m) = (lambda.len(), lambda.len() + powers.len());
        let mut columns = Array2::zeros((work.lines(), if derivatives { m + n } else { m }).f());
        let (mut plain, mut slopes) = columns.view_mut().split_at(Axis(1), m);
        let slopes = slopes
            .columns_mut()
            .into_iter()
            .map(Some)
            .chain(std::iter::repeat_with(|| None));
        let poles: Vec<_> = plain
            .columns_mut()
            .into_iter()
            .zip(slopes)
            .zip(lambda)
            .collect();
        let sums = poles
            .into_par_iter()
            .with_min_len(limits::POLES_AT_A_TIME)
            .map(|((column, derivative), &pole)| fill(work, pole, column, derivative))
            .collect();
        for (column, &power) in plain.columns_mut().into_iter().skip(n).zip(powers) {
            let lines = work.x.iter().zip(&work.g);
            column
                .into_iter()
                .zip(lines)
                .for_each(|(value, (&x, &g))| *value = (g * x.powi(power)).into());
        }
        Self {
            lambda,
            columns,
            terms: powers.len(),
            sums,
            rational: work.law == Damping::Structural && work.leakage.is_none(),
        }
    }

    /// Inner products of all columns.
    pub fn gram(&self) -> Array2<Complex64> {
        match self.rational {
            true => self.by_partial_fractions(),
            false => blocked_matmul_h(self.columns.view(), self.columns.view()),
        }
    }

    fn by_partial_fractions(&self) -> Array2<Complex64> {
        let (n, all) = (self.lambda.len(), self.columns.ncols());
        let m = n + self.terms;
        let mut gram = Array2::zeros((all, all).f());
        for (q, (&b, of_b)) in self.lambda.iter().zip(&self.sums).enumerate() {
            for (p, (a, of_a)) in self.lambda.iter().zip(&self.sums).enumerate() {
                let over = inverse(b - a.conj());
                let [first, second] = of_a.map(|sum| sum.conj());
                let plain = (first - of_b[0]) * over;
                gram[[p, q]] = plain;
                if all == m {
                    continue;
                }
                gram[[p, m + q]] = (of_b[1] - plain) * over;
                gram[[m + q, p]] = gram[[p, m + q]].conj();
                gram[[m + p, m + q]] = (second + of_b[1] - 2.0 * plain) * over * over;
            }
        }
        let terms = matmul_h(self.columns.slice(s![.., n..m]), self.columns.view());
        gram.slice_mut(s![n..m, ..]).assign(&terms);
        gram.slice_mut(s![.., n..m])
            .assign(&terms.t().mapv(|v| v.conj()));
        gram
    }
}

/// Writes the column of a pole and its derivative; returns Σ g²/(λ − x) and
/// Σ g²/(λ − x)², the second with the derivative alone, and neither where lines leak.
fn fill(
    work: &Columns,
    pole: Complex64,
    mut column: ArrayViewMut1<Complex64>,
    derivative: Option<ArrayViewMut1<Complex64>>,
) -> [Complex64; 2] {
    let mut sums = [Complex64::ZERO; 2];
    let lines = work.x.iter().zip(&work.g);
    if let Some(leakage) = &work.leakage {
        let leaking = Leaking::new(work.law, leakage, pole);
        let of_lines = lines.map(|(&x, &g)| leaking.at(x).map(|v| v * g));
        match derivative {
            None => column
                .iter_mut()
                .zip(of_lines)
                .for_each(|(value, [own, _])| *value = own),
            Some(mut derivative) => column
                .iter_mut()
                .zip(derivative.iter_mut())
                .zip(of_lines)
                .for_each(|((value, slope), both)| [*value, *slope] = both),
        }
        return sums;
    }
    let Some(mut derivative) = derivative else {
        for (value, (&x, &g)) in column.iter_mut().zip(lines) {
            *value = resonance(work.law, pole, x) * g;
            sums[0] += *value * g;
        }
        return sums;
    };
    for ((value, slope), (&x, &g)) in column.iter_mut().zip(derivative.iter_mut()).zip(lines) {
        let resonance = resonance(work.law, pole, x);
        *value = resonance * g;
        *slope = -(resonance * *value) * loss(work.law, pole, x);
        sums[0] += *value * g;
        sums[1] -= *slope * g;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partial_fractions_are_the_inner_products() {
        let x: Vec<f64> = (0..300).map(|k| 0.1 + 0.003 * f64::from(k)).collect();
        let g = x.iter().map(|x| 1.0 + x.sqrt()).collect();
        let work = Columns {
            x,
            g,
            b: Array2::zeros((300, 0)),
            law: chladni_frf::Damping::Structural,
            leakage: None,
        };
        // narrower than a line, near a twin, and outside the lines
        let lambda = [
            (0.4, 1e-3),
            (0.4003, 1e-3),
            (0.4, 1e-3 + 1e-12),
            (0.7, 0.02),
            (1.2, 0.01),
        ]
        .map(|(re, im)| Complex64::new(re, im));
        let cauchy = Cauchy::new(&work, &lambda, &[-1, 0, 2]);
        let direct = matmul_h(cauchy.columns.view(), cauchy.columns.view());
        let gram = cauchy.gram();
        for ((i, j), value) in gram.indexed_iter() {
            let size = (direct[[i, i]].re * direct[[j, j]].re).sqrt();
            assert!(
                (value - direct[[i, j]]).norm() < 1e-13 * size,
                "({i}, {j}): {value} for {}",
                direct[[i, j]]
            );
        }
        let plain = Cauchy::without_derivatives(&work, &lambda, &[-1, 0, 2]);
        assert_eq!(plain.columns, cauchy.columns.slice(s![.., ..8]));
        let size = |i: usize| direct[[i, i]].re.sqrt();
        assert!(plain
            .gram()
            .indexed_iter()
            .all(|((i, j), value)| (value - gram[[i, j]]).norm() < 1e-13 * size(i) * size(j)));
    }
}
