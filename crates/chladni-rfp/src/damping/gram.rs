//! Pole columns and their derivatives, and the inner products of them all by partial
//! fractions where the law has them: see [`crate::damping::partial_fractions`].

use crate::damping::filled::{fill, fill_terms};
use crate::damping::law::is_rational;
use crate::damping::limits;
use crate::damping::partial_fractions::{has_partial_fractions, rational_gram, viscous_gram, Kind};
use crate::data::columns::Columns;
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_gram, blocked_matmul, blocked_matmul_h, tall_qr};
use chladni_linalg::{cholesky, matmul_h, solve_lower_adjoint, LinalgError};
use ndarray::{s, Array2, ArrayView2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// The columns of one set of poles, all above the real axis, in the law of the lines.
pub(crate) struct Cauchy<'a> {
    work: &'a Columns,
    lambda: &'a [Complex64],
    /// Pole columns A, residual terms, and, unless left out, derivatives D of the pole
    /// columns, (line, n + terms + n): see [`crate::damping::basis::basis`].
    pub columns: Array2<Complex64>,
    /// Number of residual terms.
    terms: usize,
    /// Σ g²/(λ − x) and, with derivatives, Σ g²/(λ − x)²: of the structural law.
    sums: Vec<[Complex64; 2]>,
}

impl<'a> Cauchy<'a> {
    /// On the lines of `work`, with its weights.
    pub fn new(work: &'a Columns, lambda: &'a [Complex64], powers: &[i32]) -> Self {
        Self::with(work, lambda, powers, true)
    }

    /// The same without derivatives, at half the cost.
    pub fn without_derivatives(work: &'a Columns, lambda: &'a [Complex64], powers: &[i32]) -> Self {
        Self::with(work, lambda, powers, false)
    }

    /// With the derivatives of all poles, or of none.
    fn with(work: &'a Columns, lambda: &'a [Complex64], powers: &[i32], derivatives: bool) -> Self {
        let (n, m) = (lambda.len(), lambda.len() + powers.len());
        let mut columns = Array2::zeros((work.lines(), if derivatives { m + n } else { m }).f());
        let lines = work.lines().max(1);
        let values = columns.as_slice_memory_order_mut().unwrap_or_default();
        let (plain, slopes) = values.split_at_mut(m * work.lines());
        let slopes = slopes.chunks_mut(lines).map(Some);
        let slopes = slopes.chain(std::iter::repeat_with(|| None));
        let poles: Vec<_> = plain.chunks_mut(lines).zip(slopes).zip(lambda).collect();
        let sums = poles
            .into_par_iter()
            .with_min_len(limits::POLES_AT_A_TIME)
            .map(|((column, derivative), &pole)| fill(work, pole, column, derivative))
            .collect();
        fill_terms(work, powers, &mut plain[n * work.lines()..]);
        Self {
            work,
            lambda,
            columns,
            terms: powers.len(),
            sums,
        }
    }

    /// Inner products of all columns.
    pub fn gram(&self) -> Array2<Complex64> {
        if !has_partial_fractions(self.work, self.lambda) {
            return blocked_gram(self.columns.view());
        }
        let n = self.lambda.len();
        let terms = self.columns.slice(s![.., n..n + self.terms]);
        let with_terms = matmul_h(self.columns.view(), terms);
        by_partial_fractions(self.work, self.lambda, &self.sums, with_terms.view())
    }

    /// Thin QR of all columns: by Cholesky of their Gram matrix where each stands well outside
    /// those before it, else by reflections. A first pass loses as much of orthogonality as
    /// the Gram matrix is ill-conditioned, a second one restores it (Yamamoto, Nakatsukasa,
    /// Yanagisawa & Fukaya, Electron. Trans. Numer. Anal. 44 (2015) 306).
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn orthonormal(&self) -> Result<(Array2<Complex64>, Array2<Complex64>), LinalgError> {
        match self.by_cholesky() {
            Some(factors) => Ok(factors),
            None => tall_qr(self.columns.view()),
        }
    }

    fn by_cholesky(&self) -> Option<(Array2<Complex64>, Array2<Complex64>)> {
        let mut gram = self.gram();
        let norms: Vec<f64> = gram.diag().iter().map(|v| v.re.sqrt()).collect();
        for ((i, j), value) in gram.indexed_iter_mut() {
            *value /= norms[i] * norms[j];
        }
        let lower = cholesky(gram.view()).ok()?;
        let stands_out = |pivot: &Complex64| pivot.re >= tol::OUTSTANDING;
        if !lower.diag().iter().all(stands_out) {
            return None;
        }
        let unit = Array2::eye(norms.len());
        let mut inverse = solve_lower_adjoint(lower.view(), unit.view()).ok()?;
        for (mut row, norm) in inverse.rows_mut().into_iter().zip(&norms) {
            row.mapv_inplace(|v| v / norm);
        }
        let nearly = blocked_matmul(self.columns.view(), inverse.view());
        let rest = cholesky(blocked_gram(nearly.view()).view()).ok()?;
        let inverse = solve_lower_adjoint(rest.view(), unit.view()).ok()?;
        let mut r = matmul_h(rest.view(), lower.t().mapv(|v| v.conj()).view());
        for (mut column, norm) in r.columns_mut().into_iter().zip(&norms) {
            column.mapv_inplace(|v| v * norm);
        }
        Some((blocked_matmul(nearly.view(), inverse.view()), r))
    }
}

/// Inner products of all columns from the `sums` of a [`Cauchy`] and from their inner products
/// `with_terms`, (column, term): without derivatives where these have no rows.
fn by_partial_fractions(
    work: &Columns,
    lambda: &[Complex64],
    sums: &[[Complex64; 2]],
    with_terms: ArrayView2<Complex64>,
) -> Array2<Complex64> {
    let (all, terms) = with_terms.dim();
    let (n, m) = (lambda.len(), lambda.len() + terms);
    let kinds: &[Kind] = match all > m {
        true => &[Kind::Pole, Kind::Loss],
        false => &[Kind::Pole],
    };
    let of_poles = match is_rational(work.law) {
        true => rational_gram(lambda, sums, all > m),
        false => viscous_gram(work, lambda, kinds),
    };
    let mut gram = Array2::zeros((all, all).f());
    let parts = [(0..n, 0..n), (n..of_poles.nrows(), m..all)];
    for (from, to) in &parts {
        for (from_columns, to_columns) in &parts {
            gram.slice_mut(s![to.clone(), to_columns.clone()])
                .assign(&of_poles.slice(s![from.clone(), from_columns.clone()]));
        }
    }
    gram.slice_mut(s![.., n..m]).assign(&with_terms);
    gram.slice_mut(s![n..m, ..])
        .assign(&with_terms.t().mapv(|v| v.conj()));
    gram
}

/// The lines of a search for poles with all that does not change while these move: residual terms,
/// other columns, and the inner products of both.
pub(crate) struct Beside<'a, const K: usize> {
    /// Lines, and their weights and law.
    pub work: &'a Columns,
    /// Powers of x of the residual terms.
    pub powers: &'a [i32],
    others: [ArrayView2<'a, Complex64>; K],
    /// Residual terms, (line, term), and their inner products with themselves and with the others.
    terms: Array2<Complex64>,
    of_terms: Array2<Complex64>,
    with_terms: [Array2<Complex64>; K],
}

impl<'a, const K: usize> Beside<'a, K> {
    /// On the lines of `work`, with the residual terms x^`powers` and the columns `others`.
    pub fn new(
        work: &'a Columns,
        powers: &'a [i32],
        others: [ArrayView2<'a, Complex64>; K],
    ) -> Self {
        let mut terms = Array2::zeros((work.lines(), powers.len()).f());
        let values = terms.as_slice_memory_order_mut().unwrap_or_default();
        fill_terms(work, powers, values);
        Self {
            work,
            powers,
            others,
            of_terms: matmul_h(terms.view(), terms.view()),
            with_terms: others.map(|other| matmul_h(terms.view(), other)),
            terms,
        }
    }

    /// Inner products of the columns of a [`Cauchy`], with each other and with the other columns,
    /// (column, ·). Where partial fractions give the first, the columns of a few poles are alive at
    /// a time, so that they stay in the cache.
    pub fn products(
        &self,
        lambda: &[Complex64],
        derivatives: bool,
    ) -> (Array2<Complex64>, [Array2<Complex64>; K]) {
        let work = self.work;
        if !has_partial_fractions(work, lambda) {
            let cauchy = Cauchy::with(work, lambda, self.powers, derivatives);
            let with = |other| blocked_matmul_h(cauchy.columns.view(), other);
            return (cauchy.gram(), self.others.map(with));
        }
        let (n, m) = (lambda.len(), lambda.len() + self.powers.len());
        let lines = work.lines().max(1);
        let kinds = if derivatives { 2 } else { 1 };
        let beside: Vec<_> = std::iter::once(self.terms.view())
            .chain(self.others)
            .collect();
        // blocks of nearly one size, mostly an even number: two threads end together
        let pairs = n.div_ceil(2 * limits::POLES_IN_CACHE).max(1);
        let size = n.div_ceil(2 * pairs).max(1);
        let block = |memory: &mut Vec<Complex64>, poles: &[Complex64]| {
            let columns = &mut memory[..kinds * poles.len() * work.lines()];
            let (plain, slopes) = columns.split_at_mut(poles.len() * work.lines());
            let slopes = slopes.chunks_mut(lines).map(Some);
            let slopes = slopes.chain(std::iter::repeat_with(|| None));
            let columns_of = plain.chunks_mut(lines).zip(slopes).zip(poles);
            let sums: Vec<_> = columns_of
                .map(|((column, derivative), &pole)| fill(work, pole, column, derivative))
                .collect();
            let columns = ArrayView2::from_shape((work.lines(), kinds * poles.len()).f(), columns)
                .expect("as many values");
            let with = beside.iter().map(|other| matmul_h(columns, *other));
            (sums, with.collect())
        };
        let parts: Vec<(Vec<_>, Vec<Array2<Complex64>>)> = lambda
            .par_chunks(size)
            .map_init(|| vec![Complex64::ZERO; kinds * size * lines], block)
            .collect();
        let whole = |k: usize, of_terms: &Array2<Complex64>| {
            let mut whole = Array2::zeros((m + (kinds - 1) * n, beside[k].ncols()).f());
            for (number, (sums, with)) in parts.iter().enumerate() {
                for kind in 0..kinds {
                    let (from, to) = (kind * sums.len(), kind * m + number * size);
                    whole
                        .slice_mut(s![to..to + sums.len(), ..])
                        .assign(&with[k].slice(s![from..from + sums.len(), ..]));
                }
            }
            whole.slice_mut(s![n..m, ..]).assign(of_terms);
            whole
        };
        let sums: Vec<_> = parts.iter().flat_map(|(sums, _)| sums).copied().collect();
        let with_terms = whole(0, &self.of_terms);
        let gram = by_partial_fractions(work, lambda, &sums, with_terms.view());
        let with_others = |k: usize| whole(k + 1, &self.with_terms[k]);
        (gram, std::array::from_fn(with_others))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Damping;

    #[test]
    fn partial_fractions_are_the_inner_products() {
        let x: Vec<f64> = (0..300).map(|k| 0.1 + 0.003 * f64::from(k)).collect();
        let g = x.iter().map(|x| 1.0 + x.sqrt()).collect();
        let work = Columns {
            x,
            g,
            b: Array2::zeros((300, 0)),
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
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

    #[test]
    fn products_of_a_few_poles_at_a_time_are_those_of_all() {
        let x: Vec<f64> = (0..203).map(|k| 0.05 + 0.004 * f64::from(k)).collect();
        let structural = Columns {
            g: x.iter().map(|x| x.sqrt()).collect(),
            b: Array2::zeros((x.len(), 0)),
            x,
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let value = |(k, c): (usize, usize)| {
            Complex64::new((k * 31 % 17) as f64 - 8.0, (k * 7 % 11 + c) as f64)
        };
        let [some, none] = [5, 0].map(|count| Array2::from_shape_fn((203, count).f(), value));
        let laws = [Damping::Structural, Damping::Viscous];
        let counts = [
            0,
            1,
            2,
            limits::POLES_IN_CACHE + 1,
            4 * limits::POLES_IN_CACHE + 3,
        ];
        for (law, count) in laws
            .iter()
            .flat_map(|law| counts.map(|count| (*law, count)))
        {
            let work = structural.clone().in_law(law);
            let lambda: Vec<Complex64> = (0..count)
                .map(|n| Complex64::new(0.06 + 0.011 * n as f64, 1e-3 + 1e-4 * n as f64))
                .collect();
            for (powers, derivatives) in [(&[][..], true), (&[-1, 0, 2], true), (&[0, 1], false)] {
                let cauchy = Cauchy::with(&work, &lambda, powers, derivatives);
                let others = [some.view(), none.view()];
                let (gram, with) =
                    Beside::new(&work, powers, others).products(&lambda, derivatives);
                let direct = matmul_h(cauchy.columns.view(), cauchy.columns.view());
                let with_some = matmul_h(cauchy.columns.view(), some.view());
                assert_eq!(with[1].dim(), (cauchy.columns.ncols(), 0));
                let norm = |i: usize| direct[[i, i]].re.sqrt();
                for ((i, j), value) in gram.indexed_iter() {
                    let error = (value - direct[[i, j]]).norm();
                    assert!(
                        error < 1e-12 * norm(i) * norm(j),
                        "{law:?} {count} ({i}, {j})"
                    );
                }
                let whole = some.mapv(|v| v.norm_sqr()).sum().sqrt();
                for ((i, j), value) in with[0].indexed_iter() {
                    let error = (value - with_some[[i, j]]).norm();
                    assert!(
                        error < 1e-13 * norm(i) * whole,
                        "{law:?} {count} ({i}, {j})"
                    );
                }
            }
        }
    }

    #[test]
    fn orthonormal_columns_span_the_same_however_alike_they_are() {
        let x: Vec<f64> = (0..500).map(|k| 0.05 + 0.0019 * f64::from(k)).collect();
        let work = Columns {
            g: x.iter().map(|x| x.sqrt()).collect(),
            b: Array2::zeros((x.len(), 0)),
            x,
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        // far apart, and so near that their Gram matrix does not tell them apart
        for (gap, by_cholesky) in [(0.1, true), (1e-9, false)] {
            let lambda: Vec<Complex64> = (0..6)
                .map(|n| Complex64::new(0.2 + gap * f64::from(n), 0.02))
                .collect();
            let cauchy = Cauchy::without_derivatives(&work, &lambda, &[-1, 0, 1, 2]);
            assert_eq!(cauchy.by_cholesky().is_some(), by_cholesky);
            let (q, r) = cauchy.orthonormal().unwrap();
            let unit = matmul_h(q.view(), q.view()) - Array2::<Complex64>::eye(10);
            assert!(unit.iter().all(|v| v.norm() < 1e-14), "{gap}: {unit}");
            for (column, made) in cauchy
                .columns
                .columns()
                .into_iter()
                .zip(q.dot(&r).columns())
            {
                let norm = |v: &ndarray::Array1<Complex64>| v.mapv(|v| v.norm_sqr()).sum().sqrt();
                let (left, whole) = (norm(&(&column - &made)), norm(&column.to_owned()));
                assert!(left < 1e-13 * whole, "{gap}: {left} of {whole}");
            }
            assert!(r
                .indexed_iter()
                .all(|((i, j), v)| i <= j || v.norm() == 0.0));
        }
    }
}
