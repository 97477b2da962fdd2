//! Noise of a force in the FRFs of windowed records: an error −H_l·ν(k) that all FRFs of the
//! force share, and neighbouring lines, too (theory.md, eq. F4i).
//!
//! Lines beside modes tell it. Leakage there is proportional to the slopes of FRFs; the rest of
//! what FRFs share is this noise. Near a mode it is as large a part of the FRF, but the fit
//! absorbs most of it: the residual there does not tell it.

use crate::shapes::force_drop::ForceDrop;
use crate::shapes::influence::{square, Influence, Shared};
use crate::shapes::levels::{level_of, LineLevel};
use crate::shapes::limits;
use chladni_frf::shared_power;
use num_complex::Complex64;

impl Influence<'_> {
    /// The noise that lines beside modes tell; `None` where the set tells the variance of lines,
    /// or few lines lie beside modes.
    ///
    /// * `kept`: share of an error of each line that stays in the residual
    /// * `cut_off`: part of the variance that is none of the force's
    pub(super) fn noise_of_force(&self, kept: &[f64], cut_off: f64) -> Option<Shared> {
        let work = self.found.work;
        if self.found.data.share_at(work.x[0]).is_some() {
            return None;
        }
        let lines = self.found.lines_beside(self.errors, kept);
        if lines.len() < limits::SHARED_LINES {
            return None;
        }
        let of_line = |&k: &usize| self.shared_on(k, kept[k]);
        let levels: Vec<LineLevel> = lines.iter().flat_map(of_line).collect();
        // mixtures of the FRFs of several forces of like power share the mean of their noise
        let mixed = match self.found.scales_of_frfs {
            Some(_) => 1.0,
            None => self.forces as f64,
        };
        let level = mixed * level_of(&levels, self.errors.leaks())?;
        let variance = (level - cut_off).max(0.0);
        (variance > 0.0).then(|| Shared {
            variances: vec![variance; work.lines()],
            alone: 1.0,
            by_force: false,
            over_lines: true,
        })
    }

    /// The errors that FRFs of each force share on the line k.
    fn shared_on(&self, k: usize, kept: f64) -> Vec<LineLevel> {
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
            Some(LineLevel {
                seen: part(&error, kept)?,
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
