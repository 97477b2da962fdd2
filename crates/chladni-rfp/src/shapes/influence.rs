//! Poles and residues as sums over the errors of lines (theory.md, eq. F4e): to first order
//! δλ = H⁻¹·Σ_l R̄_l∘(DᴴP⊥E_l) and δR_l = A⁺(E_l − D·R_l∘δλ).

use crate::damping::basis::basis_derivative;
use crate::data::information::{covariance, kept_share};
use crate::data::window::block_errors::BlockErrors;
use crate::poles::pole::Pole;
use crate::poles::refine::Projection;
use crate::shapes::found::FittedPoles;
use crate::shapes::limits;
use chladni_frf::shared_power;
use chladni_linalg::{matmul, matmul_h, solve_upper, LinalgError};
use ndarray::{concatenate, s, Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::LN_2;

impl FittedPoles<'_> {
    /// The error that FRFs share on each line, as noise of the force makes it (theory.md, eq.
    /// F4h), or one denominator of all responses.
    fn shared(&self, residual: &Array2<Complex64>) -> Shared {
        let Self { data, work, .. } = self;
        let none = Shared {
            variances: Vec::new(),
            alone: 1.0,
            by_force: false,
            over_lines: false,
        };
        let shares: Option<Vec<f64>> = work.x.iter().map(|x| data.share_at(*x)).collect();
        let Some(shares) = shares else {
            return none;
        };
        // FRFs of several forces count as those of one: the part comes out too small
        let of_line = |(k, share): (usize, &f64)| {
            let errors = residual.row(k).into_iter().map(std::slice::from_ref);
            shared_power(work.b.row(k).into_iter().copied().zip(errors), *share)
        };
        let mut parts: Vec<f64> = shares.iter().enumerate().filter_map(of_line).collect();
        let seen = match parts.len() {
            0..limits::SHARED_LINES => 0.0,
            count => *parts.select_nth_unstable_by(count / 2, f64::total_cmp).1 / LN_2,
        };
        let by_force = seen >= limits::SHARED_PART;
        let part = |share: f64| match by_force {
            // far from modes noise of the responses hides some of it
            true => seen.max(1.0),
            false => data.shared_part(share),
        };
        // what noise makes them share comes on top
        let alone = 1.0 - if by_force { seen } else { part(0.0) };
        if alone >= 1.0 {
            return none;
        }
        Shared {
            variances: shares.iter().map(|share| part(*share) * share).collect(),
            alone: alone.max(0.0),
            by_force,
            over_lines: false,
        }
    }
}

/// Errors that FRFs share.
pub(super) struct Shared {
    /// Variance of each line's error that all FRFs of a force share, over their power; empty
    /// where they share none.
    pub variances: Vec<f64>,
    /// Part of the noise that they do not share.
    pub alone: f64,
    /// True where it is noise of the force, as the variance of lines tells it.
    pub by_force: bool,
    /// True where neighbouring lines share it, too, as windows make them.
    pub over_lines: bool,
}

/// Noise of pairs.
#[derive(Default)]
pub(super) struct PairNoise {
    /// Variance of each.
    pub variances: Vec<f64>,
    /// Σ_l R̄_ml·R_nl over FRFs l, times these, (m, n).
    pub products: Array2<Complex64>,
}

/// Poles and residues as sums over errors of lines.
pub(super) struct Influence<'a> {
    pub found: &'a FittedPoles<'a>,
    pub errors: &'a BlockErrors,
    pub lambda: Vec<Complex64>,
    pub projection: Projection,
    /// Row n of A⁺ and DᴴP⊥ of pole n, (line, 2n).
    pub rows: Array2<Complex64>,
    /// A⁺D, (pole, pole).
    pub follow: Array2<Complex64>,
    /// H⁻¹.
    pub inverse: Array2<Complex64>,
    /// Residues, (pole, pair), of columns.
    pub residues: Array2<Complex64>,
    /// Σ_l R̄_ml·R_nl over FRFs l of each force, weighted as in the fit, (m, n).
    pub of_forces: Vec<Array2<Complex64>>,
    /// Noise of each pair by itself.
    pub noise: PairNoise,
    /// The same with what pairs leak on the median line.
    pub seen: PairNoise,
    /// Force of each pair, and their number.
    pub force: Vec<usize>,
    pub forces: usize,
    /// Pairs of each response.
    pub of_response: Vec<Vec<usize>>,
    /// Σ|residual|² of each line over the share that a fit leaves of an error.
    pub left: Vec<f64>,
    pub shared: Shared,
}

impl<'a> Influence<'a> {
    /// The influence of lines on what was `found`.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(found: &'a FittedPoles<'a>, errors: &'a BlockErrors) -> Result<Self, LinalgError> {
        let FittedPoles { data, work, .. } = found;
        let lambda: Vec<Complex64> = found.poles.iter().map(Pole::lambda).collect();
        let n = lambda.len();
        let projection = Projection::new(work, &lambda, found.powers)?;
        let unit = Array2::eye(projection.r.nrows());
        let inverse = solve_upper(projection.r.view(), unit.view())?;
        let inverse = inverse.slice(s![..n, ..]);
        let derivative = basis_derivative(work, &lambda);
        let inside = matmul_h(projection.q.view(), derivative.view());
        let follow = matmul(inverse, inside.view());
        let outside = &derivative - &matmul(projection.q.view(), inside.view());
        let own = matmul(projection.q.view(), inverse.t().mapv(|v| v.conj()).view());
        let rows = concatenate![Axis(1), own, outside].mapv(|v| v.conj());

        let forces = match data.references.len() {
            references @ 1..=limits::FORCES_MOST => references,
            _ => 1,
        };
        let mut of_response = vec![Vec::new(); data.responses.len()];
        for (l, &(i, _)) in data.pairs.iter().enumerate() {
            of_response[i].push(l);
        }
        let energy = projection.residual.rows().into_iter();
        let kept = kept_share(&projection.q, &outside);
        let left = energy
            .zip(&kept)
            .map(|(row, kept)| square(row.iter()) / kept);
        let shared = found.shared(&projection.residual);
        let mut influence = Self {
            found,
            errors,
            shared,
            follow,
            inverse: Array2::zeros((0, 0)),
            residues: found.residues(),
            of_forces: Vec::new(),
            noise: PairNoise::default(),
            seen: PairNoise::default(),
            force: data.pairs.iter().map(|&(_, j)| j % forces).collect(),
            forces,
            of_response,
            left: left.collect(),
            rows,
            lambda,
            projection,
        };
        let weight = |l: usize| found.scale_of(l).powi(-2);
        let at = |force: usize, l: usize| match influence.force[l] == force {
            true => weight(l),
            false => 0.0,
        };
        let of_forces = (0..forces).map(|force| influence.products(|l| at(force, l)));
        influence.of_forces = of_forces.collect();
        let noise = found.noise(errors, &influence.projection.residual, &kept);
        [influence.noise, influence.seen] = noise.map(|variances| PairNoise {
            products: influence.products(|l| variances[l] * weight(l).powi(2)),
            variances,
        });
        let outside = influence.rows.slice(s![.., n..]);
        let across = matmul_h(outside, outside).mapv(|v: Complex64| v.conj());
        influence.inverse = covariance((across * influence.of_all()).view());
        let cut_off = influence.cut_off();
        if let Some(shared) = influence.noise_of_force(&kept, cut_off) {
            influence.shared = shared;
        }
        Ok(influence)
    }

    /// Σ_l weight·R̄_ml·R_nl over pairs, (m, n).
    fn products(&self, weight: impl Fn(usize) -> f64) -> Array2<Complex64> {
        let mut weighted = self.residues.t().to_owned();
        for (l, mut row) in weighted.rows_mut().into_iter().enumerate() {
            row.mapv_inplace(|v| v * weight(l));
        }
        matmul(self.residues.mapv(|v| v.conj()).view(), weighted.view())
    }

    /// The products of all forces.
    pub fn of_all(&self) -> Array2<Complex64> {
        let none = Array2::zeros((self.lambda.len(), self.lambda.len()));
        self.of_forces.iter().fold(none, |sum, one| sum + one)
    }

    /// Variance of the errors of each line over that of the median line.
    pub fn line_variances(&self) -> Vec<f64> {
        let FittedPoles { data, work, .. } = self.found;
        work.x.iter().map(|x| data.variance_at(*x)).collect()
    }

    /// Σ_kq row_a(k)·row_b(q)*·r(k, q) over lines, of all rows, for errors of these
    /// `variances` before the weights of lines.
    pub fn noise_products(
        &self,
        correlation: impl Fn(f64) -> Complex64,
        variances: &[f64],
    ) -> Array2<Complex64> {
        let mut weighted = self.rows.clone();
        for (k, mut row) in weighted.rows_mut().into_iter().enumerate() {
            let weight = self.found.weight(k) * variances[k].sqrt();
            row.mapv_inplace(|v| v * weight);
        }
        self.products_over_lines(&weighted, correlation)
    }

    /// Σ_kq row_a(k)·row_b(q)*·r(k, q) over lines, of all columns of `rows`.
    pub fn products_over_lines(
        &self,
        rows: &Array2<Complex64>,
        correlation: impl Fn(f64) -> Complex64,
    ) -> Array2<Complex64> {
        let work = self.found.work;
        let y: Vec<f64> = work.x.iter().map(|x| x.sqrt()).collect();
        let mut mixed = Array2::zeros(rows.raw_dim());
        let mut known: Vec<(f64, Complex64)> = Vec::new();
        for k in 0..y.len() {
            for q in k..y.len() {
                let cycles = self.errors.cycles(y[q] - y[k]);
                if cycles > limits::CYCLES_APART {
                    break;
                }
                let near = known
                    .iter()
                    .find(|(at, _)| (at - cycles).abs() < limits::SAME_CYCLES);
                let value = near.map(|(_, value)| *value).unwrap_or_else(|| {
                    let value = correlation(if q == k { 0.0 } else { cycles });
                    known.push((cycles, value));
                    value
                });
                if value.norm_sqr() == 0.0 {
                    continue;
                }
                mixed.row_mut(k).scaled_add(value, &rows.row(q));
                if q != k {
                    mixed.row_mut(q).scaled_add(value.conj(), &rows.row(k));
                }
            }
        }
        matmul(mixed.t(), rows.mapv(|v| v.conj()).view())
    }

    /// Mean variance of noise of the columns, before the weights of lines.
    pub fn noise_of_columns(&self) -> f64 {
        let of_column = |(l, noise): (usize, &f64)| noise / self.found.scale_of(l).powi(2);
        let variances = &self.noise.variances;
        let sum: f64 = variances.iter().enumerate().map(of_column).sum();
        sum / variances.len().max(1) as f64
    }

    /// Lines whose leakage counts for the mode n.
    pub fn lines_about(&self, n: usize, cycles: f64) -> Vec<usize> {
        let x = &self.found.work.x;
        let middle = self.middle(n);
        let near = |k: &usize| self.errors.cycles((x[*k].sqrt() - middle).abs()) < cycles;
        (0..x.len()).filter(near).collect()
    }

    /// ω_n over ω_max.
    pub fn middle(&self, n: usize) -> f64 {
        self.lambda[n].re.max(0.0).sqrt()
    }
}

/// Σ|v|², never zero.
pub(super) fn square<'a>(values: impl Iterator<Item = &'a Complex64>) -> f64 {
    let sum: f64 = values.map(|v| v.norm_sqr()).sum();
    sum.max(f64::MIN_POSITIVE)
}
