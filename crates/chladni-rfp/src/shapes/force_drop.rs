//! A shaker's force that drops at resonances: told by what a fit leaves beside them, and
//! what it does to poles and shapes (theory.md, eq. F4f).
//!
//! Near a resonance the power of such a force goes as |jω − s|²/|jω − p|², p = d·Re s +
//! j·Im s: it is not white within one line, and the column of a mode changes by a known
//! amount. What poles and residues cannot take over of the change stays in the residual, and
//! tells d, one unknown of all modes; what they take over is their error.

use crate::damping::columns::leaking_pole;
use crate::data::window::kernel::Force;
use crate::data::window::leakage::Leakage;
use crate::shapes::influence::{square, Influence};
use crate::shapes::leakage_into_lines::LeakageIntoLines;
use crate::shapes::limits;
use chladni_frf::{counted, Finding};
use chladni_linalg::{matmul, matmul_h};
use ndarray::{concatenate, s, Array1, Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::LN_10;
use std::ops::Range;

/// Forces that the residual leaves possible.
#[derive(Debug, Clone)]
pub(crate) struct ForceDrop {
    /// Forces that may be, and their probabilities.
    forces: Vec<(Force, f64)>,
    /// The likeliest one.
    likeliest: Force,
    /// Its log-likelihood over an even force.
    gain: f64,
    /// Frequencies of the modes that were asked, over ω_max.
    asked: Vec<f64>,
}

impl ForceDrop {
    /// True where a drop may be.
    pub fn may_be(&self) -> bool {
        !self.forces.is_empty()
    }

    /// The likeliest force, where the residual decides that it drops.
    pub fn decided(&self) -> Option<Force> {
        (self.gain >= limits::DROP_DECIDES).then_some(self.likeliest)
    }

    /// The finding, in words; `None` where the force may be even.
    ///
    /// * `hz`: ω_max/2π
    pub fn finding(&self, hz: f64) -> Option<Finding> {
        let drop_db = 20.0 * self.decided()?.drop.log10();
        let words = format!(
            "the force drops at resonances, by about {drop_db:.0} dB: the lines of {} say \
             so (10^{:.0} times as likely as under an even force); the line shape of the window \
             is that of an even force, so the error bars hold the difference",
            counted(self.asked.len(), "mode"),
            self.gain / LN_10
        );
        let finding = Finding::caution("force-drop", words)
            .modes_hz(self.asked.iter().map(|y| y * hz))
            .value("drop_db", drop_db)
            .value("line_shape_nats", self.gain)
            .help(
                "estimate the FRFs from the records by the local rational method, which a drop \
                 does not bias",
            );
        Some(finding)
    }
}

/// Lines on which the column of one pole changes with the force.
struct Lines<'a> {
    /// Positions.
    places: &'a [usize],
    /// The column over 1/(jω − s) on each.
    unit: &'a [Complex64],
}

/// Residual of the column of a mode that stands alone, on the lines about it.
struct Left {
    /// Lines that leak, and the column over 1/(jω − s) on each.
    lines: Vec<usize>,
    unit: Vec<Complex64>,
    /// The lines about the mode, among these.
    about: Range<usize>,
    /// The residual there, and its variance.
    seen: Vec<(Complex64, f64)>,
    /// Part of a column on `lines` that poles and residues take over: its rows.
    taken: Array2<Complex64>,
}

impl Influence<'_> {
    /// Forces that the residual leaves possible, where leakage has the variance `share` of that
    /// in one block; `None` where no window of a continuous force is known, or lines are too
    /// few.
    pub fn force_drop(&self, share: f64) -> Option<ForceDrop> {
        let leakage = self.continuous().filter(|_| self.found.fitted)?;
        let inside = |n: &usize| self.found.work.in_band(self.lambda[*n]);
        let modes: Vec<(usize, Left)> = (0..self.lambda.len())
            .into_par_iter()
            .filter(inside)
            .filter_map(|n| Some((n, self.left_of(n, share)?)))
            .collect();
        if modes.is_empty() {
            return None;
        }
        let with_noise = |drop| limits::NOISES.map(|noise| Force { drop, noise });
        let gain = |force: Force| -> (Force, f64) {
            let each = modes
                .iter()
                .map(|(n, left)| self.gain(leakage, *n, left, &force));
            (force, each.sum())
        };
        let all: Vec<(Force, f64)> = limits::DROPS
            .into_par_iter()
            .flat_map(with_noise)
            .map(gain)
            .collect();
        let &(likeliest, most) = all.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let sum: f64 = all.iter().map(|(_, gain)| (gain - most).exp()).sum();
        let probable = all
            .into_iter()
            .map(|(force, gain)| (force, (gain - most).exp() / sum))
            .filter(|(force, part)| force.drop > 1.0 && *part > limits::FORCE_LEAST);
        Some(ForceDrop {
            forces: probable.collect(),
            likeliest,
            gain: most,
            asked: modes.iter().map(|(n, _)| self.middle(*n)).collect(),
        })
    }

    /// Variance of what noise of the force adds to each line near the mode n, which has the
    /// variance `level` beside modes: the mean over the forces that may be (theory.md, eq. F4j).
    pub fn noise_near(&self, n: usize, level: f64, drop: &ForceDrop) -> Option<Vec<f64>> {
        let leakage = self.continuous()?;
        let s = leaking_pole(self.found.work.law, self.lambda[n]).s;
        let averaged = self.errors.averaged();
        let louder = |(force, part): &(Force, f64), x: f64| -> f64 {
            // noise beyond what this force makes beside modes has another origin
            let most = averaged.map_or(f64::INFINITY, |averaged| averaged * force.noise);
            let power = leakage.power_of_force(s, x.sqrt(), force);
            let read = (power + force.noise) / (1.0 + force.noise);
            let over_beside = power / read.powi(2).max(f64::MIN_POSITIVE);
            part * level.min(most) * (over_beside - 1.0)
        };
        let at = |&x: &f64| {
            let sum: f64 = drop.forces.iter().map(|force| louder(force, x)).sum();
            (level + sum).max(0.0)
        };
        Some(self.found.work.x.iter().map(at).collect())
    }

    /// The line shape of a continuous force under a known window.
    fn continuous(&self) -> Option<&Leakage> {
        let leakage = self.found.data.leakage.as_deref()?;
        let window = self.found.data.window?;
        window.is_continuous().then_some(leakage)
    }

    /// `None` where the mode n does not stand alone, or lines are too few.
    fn left_of(&self, n: usize, share: f64) -> Option<Left> {
        let work = self.found.work;
        let half_width = 0.5 * self.lambda[n].im / self.middle(n);
        let is_near = |m: usize| {
            let distance = (self.middle(m) - self.middle(n)).abs();
            m != n && work.in_band(self.lambda[m]) && distance < limits::DROP_ALONE * half_width
        };
        let width = self.errors.cycles(half_width);
        if 2.0 * width < limits::DROP_LINES || (0..self.lambda.len()).any(is_near) {
            return None;
        }
        let (half_widths, least) = limits::DROP_REACH;
        let near = self.lines_about(n, (half_widths * width).max(least).min(limits::LEAK_CYCLES));
        let lines = self.lines_about(n, limits::LEAK_CYCLES);
        if near.len() < 2 * limits::DROP_UNKNOWNS {
            return None;
        }
        let leaking = self.leaking(n, &[n], &lines, None)?;
        let first = lines.iter().position(|k| *k == near[0])?;
        let about = first..first + near.len();
        let residues = matmul(self.rows.slice(s![.., n..=n]).t(), work.b.view());
        let power = square(residues.iter());
        let noise = self.noise_of_columns() / power;
        let seen = |place: usize| {
            let k = lines[place];
            let row = self.projection.residual.row(k);
            let matched = row.iter().zip(&residues).map(|(e, r)| e * r.conj());
            let weight = self.found.weight(k).powi(2);
            let variance = share * self.leaked_on(&leaking, place) + weight * noise;
            (matched.sum::<Complex64>() / power, variance)
        };
        let seen: Vec<(Complex64, f64)> = about.clone().map(seen).collect();
        let usable = |(seen, variance): &(Complex64, f64)| seen.is_finite() && *variance > 0.0;
        let sound = seen.iter().all(usable) && seen.iter().any(|own| own.0.norm_sqr() > 0.0);
        sound.then(|| Left {
            seen,
            taken: self.taken(n, &lines),
            unit: leaking.units[0].clone(),
            about,
            lines,
        })
    }

    /// Part of a column on `lines` that poles and the residue of n take over: its rows.
    fn taken(&self, n: usize, lines: &[usize]) -> Array2<Complex64> {
        let outside = self.rows.column(self.lambda.len() + n);
        let scale = square(outside.iter()).sqrt();
        let derivative = lines.iter().map(|&k| outside[k].conj() / scale).collect();
        let derivative = Array1::from_vec(derivative).insert_axis(Axis(1));
        let q = self.projection.q.select(Axis(0), lines);
        concatenate![Axis(1), q, derivative]
    }

    /// The change of a column by a force of which poles and residue take over the part `taken`: what
    /// stays in the residual.
    fn stays(
        &self,
        leakage: &Leakage,
        n: usize,
        (lines, taken): (&Lines, &Array2<Complex64>),
        force: &Force,
    ) -> Array1<Complex64> {
        let by_force = |s: Complex64, y: f64| leakage.by_force(s, y, force);
        let change = Array1::from(self.changed(n, lines, &by_force)).insert_axis(Axis(1));
        let part = matmul_h(taken.view(), change.view());
        (&change - &matmul(taken.view(), part.view())).remove_axis(Axis(1))
    }

    /// The change of the column of the mode n on `lines` by a force that drops: what stays in the
    /// residual. The column is `unit` times 1/(jω − s).
    pub fn left_by_drop(
        &self,
        n: usize,
        lines: &[usize],
        unit: &[Complex64],
        force: &Force,
    ) -> Option<Array1<Complex64>> {
        let taken = self.taken(n, lines);
        let lines = Lines {
            places: lines,
            unit,
        };
        Some(self.stays(self.continuous()?, n, (&lines, &taken), force))
    }

    /// Log-likelihood of a force over an even one; the level of errors is free.
    fn gain(&self, leakage: &Leakage, n: usize, left: &Left, force: &Force) -> f64 {
        let lines = Lines {
            places: &left.lines,
            unit: &left.unit,
        };
        let stays = self.stays(leakage, n, (&lines, &left.taken), force);
        let (mut before, mut after) = (0.0, f64::MIN_POSITIVE);
        for (&(seen, variance), stays) in left.seen.iter().zip(stays.slice(s![left.about.clone()]))
        {
            before += seen.norm_sqr() / variance;
            after += (seen - stays).norm_sqr() / variance;
        }
        let free = left.seen.len() - limits::DROP_UNKNOWNS;
        free as f64 * (before / after).ln()
    }

    /// The part that a force that is not even adds to the column of a pole; `by_force`: to
    /// 1/(jω − s).
    fn changed(
        &self,
        n: usize,
        lines: &Lines,
        by_force: &dyn Fn(Complex64, f64) -> Complex64,
    ) -> Vec<Complex64> {
        let work = self.found.work;
        let s = leaking_pole(work.law, self.lambda[n]).s;
        let each = lines.places.iter().zip(lines.unit);
        each.map(|(&k, unit)| unit * by_force(s, work.x[k].sqrt()))
            .collect()
    }

    /// Second moments of what the forces that may be do, for each force of the test: E d·dᴴ of
    /// the errors of the residue of n by each of `near`, then of their poles, and E δ² of the
    /// pole n.
    pub fn moments_of_drop(
        &self,
        (n, near): (usize, &[usize]),
        (places, leaking): (&[usize], &LeakageIntoLines),
        drop: &ForceDrop,
    ) -> Vec<(Array2<Complex64>, Complex64)> {
        let Some(leakage) = self.continuous() else {
            return Vec::new();
        };
        let size = 2 * near.len();
        let own = near.iter().position(|&m| m == n);
        let none = (Array2::zeros((size, size)), Complex64::ZERO);
        let mut moments = vec![none; self.forces];
        for (force, probability) in &drop.forces {
            // the same drop of all forces: at most their number times that of independent ones
            let weight = probability * self.forces as f64;
            let by_force = |s: Complex64, y: f64| leakage.by_force(s, y, force);
            let of_pole = |(&a, unit): (&usize, &Vec<Complex64>)| {
                self.changed(a, &Lines { places, unit }, &by_force)
            };
            let changes: Vec<Vec<Complex64>> =
                near.iter().zip(&leaking.units).map(of_pole).collect();
            for ((sum, of_pole), products) in moments.iter_mut().zip(&self.of_forces) {
                let off = self.sums((n, near), places, &changes, products);
                let pole = own.map_or(Complex64::ZERO, |own| off[near.len() + own]);
                *of_pole += weight * pole * pole;
                let column = Array1::from(off).insert_axis(Axis(1));
                let adjoint = column.t().mapv(|v| v.conj());
                sum.scaled_add(weight.into(), &column.dot(&adjoint));
            }
        }
        moments
    }

    /// Sums over lines of errors that are residues times `changes` of columns: of the residue
    /// of n by each of `near`, then of their poles.
    fn sums(
        &self,
        (n, near): (usize, &[usize]),
        places: &[usize],
        changes: &[Vec<Complex64>],
        products: &Array2<Complex64>,
    ) -> Vec<Complex64> {
        let count = self.lambda.len();
        let seen_by = |row: usize, change: &[Complex64]| -> Complex64 {
            let each = places.iter().zip(change);
            each.map(|(&k, change)| self.rows[[k, row]] * change).sum()
        };
        let score = |&q: &usize| -> Complex64 {
            let each = near.iter().zip(changes);
            each.map(|(&a, change)| products[[q, a]] * seen_by(count + q, change))
                .sum()
        };
        let scores: Vec<Complex64> = near.iter().map(score).collect();
        let of_pole = |&m: &usize| -> Complex64 {
            let each = near.iter().zip(&scores);
            each.map(|(&q, score)| self.inverse[[m, q]] * score).sum()
        };
        let direct = changes.iter().map(|change| seen_by(n, change));
        direct.chain(near.iter().map(of_pole)).collect()
    }
}
