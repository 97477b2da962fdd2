//! Moments of what leakage, noise and a force that drops do to poles and residues (theory.md,
//! eq. F4d and F4f).
//!
//! Leakage is a sum over poles of what each leaks, times its residue, the same in all FRFs of
//! one force: a few forms of the force, of which every shape takes its part.

use crate::damping::basis::basis;
use crate::damping::columns::leaking_pole;
use crate::data::window::band::Form;
use crate::shapes::force_drop::ForceDrop;
use crate::shapes::influence::{Influence, PairNoise};
use crate::shapes::leakage_into_lines::LeakageIntoLines;
use crate::shapes::limits;
use chladni_linalg::matmul;
use ndarray::{s, Array2, Axis};
use num_complex::Complex64;

/// Moments of the errors that a mode's bars are made of: what each pole leaks into its
/// residue, then errors of poles.
pub(super) struct Moments {
    /// Poles that count.
    pub near: Vec<usize>,
    /// E d·dᴴ for each force; the errors of poles hold those of noise.
    pub leaked: Vec<Array2<Complex64>>,
    /// Variances of Re λ and Im λ of the mode's own pole.
    pub pole: [f64; 2],
    /// Mean squares of the shifts of Re λ and Im λ by a force that drops.
    pub pole_shift: [f64; 2],
}

/// Variance of leakage over that in one block.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LeakageShare {
    pub all: f64,
    /// The part that forces leak into FRFs of their own. What they leak into those of others
    /// has any phase: its square has no mean.
    pub own: f64,
}

/// Mean squares of real and imaginary part, from E|δ|² and E δ².
fn sides((whole, twice): (f64, Complex64)) -> [f64; 2] {
    [whole + twice.re, whole - twice.re].map(|v| (0.5 * v).max(0.0))
}

impl Influence<'_> {
    /// 1/M by the residual about modes: without the noise of the force, and with it. The fit
    /// absorbs an unknown part of that noise, so the first is too small.
    ///
    /// * `drop`: forces that may be, where the noise is read over a force that drops
    pub fn share_of_leakage(&self, drop: Option<&ForceDrop>) -> [f64; 2] {
        let work = self.found.work;
        let products = self.of_all();
        let force = drop.and_then(ForceDrop::decided);
        let (mut seen, mut noise, mut foretold) = (0.0, 0.0, 0.0);
        for n in (0..self.lambda.len()).filter(|&n| work.in_band(self.lambda[n])) {
            let width = self.errors.cycles(self.lambda[n].im / self.middle(n));
            let lines = self.lines_about(n, width.max(limits::LEAK_SEEN));
            let Some(leaking) = self.leaking(n, &[n], &lines, force) else {
                continue;
            };
            let of_drop =
                force.and_then(|force| self.left_by_drop(n, &lines, &leaking.units[0], &force));
            let shared = match self.shared.over_lines {
                true => self.shared_near(n, drop),
                false => Vec::new(),
            };
            for (place, &k) in lines.iter().enumerate() {
                foretold += self.leaked_on(&leaking, place) * products[[n, n]].re;
                seen += self.left[k];
                if let Some(of_drop) = &of_drop {
                    seen -= of_drop[place].norm_sqr() * products[[n, n]].re;
                }
                if let Some(shared) = shared.get(k) {
                    noise += shared * self.power(k);
                }
            }
        }
        [seen - noise, seen].map(|seen: f64| match foretold > 0.0 {
            true => seen.max(0.0) / foretold,
            false => 0.0,
        })
    }

    /// Variance beside modes of the responses that records of bursts cut off, over the power of
    /// the FRFs; zero if it cannot be foretold. Like noise of the force it is an equal part of
    /// an FRF on all lines, so slopes do not tell the two apart.
    pub fn cut_off(&self) -> f64 {
        let work = self.found.work;
        let Some(blocks) = self.errors.blocks().filter(|_| self.errors.cuts_off()) else {
            return 0.0;
        };
        let of_mode = |n: usize| -> Option<f64> {
            let apart = |k: usize| {
                let distance = work.x[k].sqrt() - self.middle(n);
                self.errors.cycles(distance.abs())
            };
            let lines = self.lines_about(n, limits::LEAK_CYCLES).into_iter();
            let beside = lines.filter(|&k| apart(k) >= limits::BESIDE_CYCLES);
            let line = beside.min_by(|&a, &b| apart(a).total_cmp(&apart(b)))?;
            let leaking = self.leaking(n, &[n], &[line], None)?;
            let s = leaking_pole(work.law, self.lambda[n]).s;
            let column = leaking.units[0][0] / (Complex64::new(0.0, work.x[line].sqrt()) - s);
            Some(self.leaked_on(&leaking, 0) / (blocks * column.norm_sqr()))
        };
        let inside = (0..self.lambda.len()).filter(|&n| work.in_band(self.lambda[n]));
        let parts: Vec<f64> = inside.filter_map(of_mode).collect();
        parts.iter().sum::<f64>() / parts.len().max(1) as f64
    }

    /// Moments for the mode n where leakage has this `share` of its variance in one block, and
    /// errors that FRFs share the variances `shared` on lines.
    ///
    /// * `noise`: products of the influence of lines, for noise correlated over them
    /// * `own`: of pairs
    pub fn moments(
        &self,
        n: usize,
        (noise, own): (&Array2<Complex64>, &PairNoise),
        share: LeakageShare,
        shared: &[f64],
        drop: Option<&ForceDrop>,
    ) -> Moments {
        let count = self.lambda.len();
        let distance = |m: usize| self.errors.cycles((self.middle(m) - self.middle(n)).abs());
        let counts = |m: &usize| {
            let known = self.inverse[[*m, *m]].re.is_finite() && self.lambda[*m].im > 0.0;
            known && (*m == n || distance(*m) < limits::LEAK_CYCLES)
        };
        let mut near: Vec<usize> = (0..count).filter(counts).collect();
        near.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        near.truncate(limits::LEAKING_MOST);
        let size = near.len();
        // errors of poles by the noise of all forces
        let of_noise = &noise.slice(s![count.., count..]) * &own.products;
        let part = self.inverse.select(Axis(0), &near);
        let adjoint = part.t().mapv(|v| v.conj());
        let of_poles = matmul(matmul(part.view(), of_noise.view()).view(), adjoint.view());
        let mut leaked = vec![Array2::zeros((2 * size, 2 * size)); self.forces];
        leaked[0].slice_mut(s![size.., size..]).assign(&of_poles);
        let Some(place) = near.iter().position(|&m| m == n) else {
            return Moments {
                near,
                leaked,
                pole: [f64::INFINITY; 2],
                pole_shift: [0.0; 2],
            };
        };
        // E|δ|² and E δ² of errors, and of what a drop shifts
        let mut errors = (of_poles[[place, place]].re, Complex64::ZERO);
        let mut shift = (0.0, Complex64::ZERO);
        let lines = self.lines_about(n, limits::LEAK_CYCLES);
        let force = drop.and_then(ForceDrop::decided);
        let leaking = self.leaking(n, &near, &lines, force);
        let leaking = leaking.filter(|_| share.all > 0.0);
        let of_drop = match (&leaking, drop) {
            (Some(leaking), Some(drop)) => {
                self.moments_of_drop((n, &near), (&lines, leaking), drop)
            }
            _ => Vec::new(),
        };
        for (force, leaked) in leaked.iter_mut().enumerate() {
            let products = &self.of_forces[force];
            if !shared.is_empty() {
                let of_shared = self.of_shared((n, &near), shared, products);
                errors.0 += of_shared[[size + place, size + place]].re;
                *leaked += &of_shared;
            }
            let Some(leaking) = &leaking else { continue };
            let forms = self.forms((n, &near), &lines, leaking, products);
            let straight = leaking.band.covariance(&forms);
            errors.0 += share.all * straight[[size + place, size + place]].re;
            errors.1 += share.own * leaking.band.mean_square(&forms[size + place]);
            leaked.scaled_add(share.all.into(), &straight);
            if let Some((of_drop, of_pole)) = of_drop.get(force) {
                shift.0 += of_drop[[size + place, size + place]].re;
                shift.1 += of_pole;
                *leaked += of_drop;
            }
        }
        Moments {
            near,
            leaked,
            pole: sides(errors),
            pole_shift: sides(shift),
        }
    }

    /// Moments of the same sums by errors that are FRFs times a number of each line, the same
    /// for all, of variance `shared`.
    fn of_shared(
        &self,
        (n, near): (usize, &[usize]),
        shared: &[f64],
        products: &Array2<Complex64>,
    ) -> Array2<Complex64> {
        let (work, count) = (self.found.work, self.lambda.len());
        let poles: Vec<Complex64> = near.iter().map(|&a| self.lambda[a]).collect();
        let columns = basis(work, &poles, &[]);
        let mut sums = Array2::zeros((2 * near.len(), work.lines()));
        for (k, shared) in shared.iter().enumerate() {
            let columns = columns.row(k);
            for (a, &value) in columns.iter().enumerate() {
                sums[[a, k]] = self.rows[[k, n]] * value * shared.sqrt();
            }
            // what the error is in the residues of each pole
            let of_pole = |&q: &usize| -> Complex64 {
                let sum: Complex64 = near
                    .iter()
                    .zip(&columns)
                    .map(|(&a, value)| products[[q, a]] * value)
                    .sum();
                self.rows[[k, count + q]] * sum
            };
            let scores: Vec<Complex64> = near.iter().map(of_pole).collect();
            for (row, &m) in near.iter().enumerate() {
                let parts = near.iter().zip(&scores);
                let sum: Complex64 = parts.map(|(&q, score)| self.inverse[[m, q]] * score).sum();
                sums[[near.len() + row, k]] = sum * shared.sqrt();
            }
        }
        if self.shared.over_lines {
            let rows = sums.t().to_owned();
            return self.products_over_lines(&rows, |cycles| self.errors.of_noise(cycles));
        }
        matmul(sums.view(), sums.t().mapv(|v| v.conj()).view())
    }

    /// Errors of the residue of n by what each pole leaks, and of the poles; `products`: of
    /// residues under one force.
    fn forms(
        &self,
        (n, near): (usize, &[usize]),
        lines: &[usize],
        leaking: &LeakageIntoLines,
        products: &Array2<Complex64>,
    ) -> Vec<Form> {
        let count = self.lambda.len();
        let weights = |a: usize, row: &dyn Fn(usize) -> Complex64| -> Vec<Complex64> {
            let each = lines.iter().zip(&leaking.units[a]);
            each.map(|(&k, unit)| row(k) * unit).collect()
        };
        let direct = (0..near.len()).map(|a| {
            let row = |k: usize| self.rows[[k, n]];
            let part = (weights(a, &row), &leaking.leaks[a]);
            leaking.band.form(std::iter::once(part))
        });
        let of_poles = near.iter().map(|&m| {
            let part = |a: usize| {
                let of = |k: usize, q: usize| {
                    self.inverse[[m, q]] * self.rows[[k, count + q]] * products[[q, near[a]]]
                };
                let row = |k: usize| near.iter().map(|&q| of(k, q)).sum();
                (weights(a, &row), &leaking.leaks[a])
            };
            leaking.band.form((0..near.len()).map(part))
        });
        direct.chain(of_poles).collect()
    }
}
