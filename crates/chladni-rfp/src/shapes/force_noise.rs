//! Noise of a force in the FRFs of windowed records: an error −H_l·ν(k) that all FRFs of the
//! force share, and neighbouring lines, too (theory.md, eq. F4i).
//!
//! Lines beside modes tell it. There leakage is what the slopes of FRFs leak, and goes with their
//! square; the rest of what FRFs share is this noise. Near a mode it is as large a part of the FRF,
//! but the fit takes most of it along: bars must know it from elsewhere.

use crate::shapes::force_drop::ForceDrop;
use crate::shapes::influence::{square, Influence, Shared};
use crate::shapes::limits;
use chladni_frf::shared_power;
use num_complex::Complex64;

/// The errors that FRFs of one force share on a line, over their power.
struct Told {
    /// Of the residual.
    shared: f64,
    /// Of their slopes, per cycle.
    slope: f64,
    /// Noise of an FRF by itself.
    alone: f64,
}

/// E|ν|² from lines that hold it and, where slopes leak, a part that goes with the power of the
/// slope; `None` where there is none.
///
/// Lines scatter by their own mean and by noise of their FRFs, and count over the square of both.
fn level_of(told: &[Told], leaks: bool) -> Option<f64> {
    let seen = told.iter().map(|own| own.shared.abs()).sum::<f64>();
    let [mut level, mut leaked] = [seen / told.len().max(1) as f64, 0.0];
    for _ in 0..limits::LEVEL_ROUNDS {
        // normal equations of the two parts
        let [mut ones, mut slopes, mut squares, mut sum, mut along] = [0.0; 5];
        for own in told {
            let mean: f64 = level + leaked * own.slope.max(0.0);
            let weight = (mean + own.alone).max(f64::EPSILON * seen).powi(-2);
            ones += weight;
            slopes += weight * own.slope;
            squares += weight * own.slope * own.slope;
            sum += weight * own.shared;
            along += weight * own.slope * own.shared;
        }
        let free = ones * squares - slopes * slopes;
        leaked = match leaks && free > 0.0 {
            true => ((ones * along - slopes * sum) / free).max(0.0),
            false => 0.0,
        };
        level = ((sum - leaked * slopes) / ones).max(0.0);
    }
    (level > 0.0 && level.is_finite()).then_some(level)
}

impl Influence<'_> {
    /// The noise that lines beside modes tell; `None` where the set tells the variance of lines,
    /// or few lines lie beside modes.
    ///
    /// * `kept`: share of an error of each line that stays in the residual
    pub(super) fn noise_of_force(&self, kept: &[f64]) -> Option<Shared> {
        let work = self.found.work;
        if self.found.data.share_at(work.x[0]).is_some() {
            return None;
        }
        let modes: Vec<f64> = (0..self.lambda.len())
            .filter(|&n| work.in_band(self.lambda[n]))
            .map(|n| self.middle(n))
            .collect();
        let beside = |k: usize| {
            let apart = |middle: &f64| self.errors.cycles((work.x[k].sqrt() - middle).abs());
            kept[k] > limits::KEPT_MOSTLY
                && modes.iter().all(|own| apart(own) >= limits::BESIDE_CYCLES)
        };
        let lines: Vec<usize> = (1..work.lines() - 1).filter(|&k| beside(k)).collect();
        if lines.len() < limits::SHARED_LINES {
            return None;
        }
        let of_line = |&k: &usize| self.shared_on(k, kept[k]);
        let told: Vec<Told> = lines.iter().flat_map(of_line).collect();
        // mixtures of the FRFs of several forces of like power share the mean of their noise
        let mixed = match self.found.scales_of_frfs {
            Some(_) => 1.0,
            None => self.forces as f64,
        };
        let variance = mixed * level_of(&told, self.errors.leaks())?;
        Some(Shared {
            variances: vec![variance; work.lines()],
            alone: 1.0,
            by_force: false,
            over_lines: true,
        })
    }

    /// The errors that FRFs of each force share on the line k.
    fn shared_on(&self, k: usize, kept: f64) -> Vec<Told> {
        let work = self.found.work;
        let fitted = |k: usize| -> Vec<Complex64> {
            let all = work
                .b
                .row(k)
                .into_iter()
                .zip(self.projection.residual.row(k));
            all.map(|(b, e)| (b - e) / self.found.weight(k)).collect()
        };
        let [before, here, after] = [k - 1, k, k + 1].map(fitted);
        let cycles = self
            .errors
            .cycles(work.x[k + 1].sqrt() - work.x[k - 1].sqrt());
        let slope: Vec<Complex64> = after
            .iter()
            .zip(&before)
            .map(|(b, a)| (b - a) / cycles)
            .collect();
        let residual = self.projection.residual.row(k);
        let error: Vec<Complex64> = residual.iter().map(|e| e / self.found.weight(k)).collect();
        // columns are FRFs, or mixtures of those of all forces
        let apart = self.found.scales_of_frfs.is_some();
        let groups = if apart { self.forces } else { 1 };
        let of_group = |group: usize| {
            let own = || (0..here.len()).filter(move |&l| !apart || self.force[l] == group);
            let part = |all: &[Complex64], unit: f64| {
                let frfs = own().map(|l| (here[l], &all[l..=l]));
                shared_power(frfs, unit)
            };
            let power: f64 = own().map(|l| here[l].norm_sqr()).sum();
            Some(Told {
                shared: part(&error, kept)?,
                slope: part(&slope, 1.0)?,
                alone: self.noise_of_columns() / power,
            })
        };
        (0..groups).filter_map(of_group).collect()
    }

    /// Σ|FRF|² of the columns on the line k, as the fit has them.
    pub(super) fn power(&self, k: usize) -> f64 {
        let residual = self.projection.residual.row(k);
        let model = self.found.work.b.row(k).into_iter().zip(residual);
        square(model.map(|(b, e)| b - e).collect::<Vec<_>>().iter())
    }

    /// Variances of lines that FRFs share, as they are near the mode n.
    ///
    /// * `drop`: forces that may be
    pub(super) fn shared_near(&self, n: usize, drop: Option<&ForceDrop>) -> Vec<f64> {
        let variances = &self.shared.variances;
        let dropping = drop.filter(|_| self.shared.over_lines);
        let near = dropping.and_then(|drop| self.noise_near(n, *variances.first()?, drop));
        near.unwrap_or_else(|| variances.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_a_force_is_told_from_what_slopes_leak() {
        // distances of 10 to 60 cycles to a mode; leakage of 0.3 per slope; at each distance the
        // quantiles of an exponential
        let of = |noise: f64| -> Vec<Told> {
            let places = (0..50).flat_map(|k| (0..50).map(move |n| (k, n)));
            let line = |(k, n): (usize, usize)| {
                let slope = (10.0 + k as f64).powi(-2);
                let chance = -((n as f64 + 0.5) / 50.0).ln();
                Told {
                    shared: (noise + 0.3 * slope) * chance,
                    slope,
                    alone: 1e-5,
                }
            };
            places.map(line).collect()
        };
        let level = level_of(&of(1e-4), true).unwrap();
        assert!((level / 1e-4 - 1.0).abs() < 0.05, "{level}");
        // leakage alone is not read as noise, and noise alone needs no slopes
        assert!(level_of(&of(0.0), true).unwrap_or(0.0) < 1e-6);
        let flat = of(1e-4).into_iter().map(|own| Told {
            shared: 1e-4,
            ..own
        });
        let level = level_of(&flat.collect::<Vec<_>>(), false).unwrap();
        assert!((level / 1e-4 - 1.0).abs() < 1e-9, "{level}");
    }
}
