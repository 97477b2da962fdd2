//! Noise of each FRF by itself.
//!
//! The median of the residual is that noise where FRFs do not leak. Where they do, lines beside
//! modes tell it apart from what the slopes of the FRF leak there.

use crate::data::window::block_errors::BlockErrors;
use crate::shapes::found::FittedPoles;
use crate::shapes::levels::{level_of, LineLevel};
use crate::shapes::limits;
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::LN_2;

impl FittedPoles<'_> {
    /// Lines that lie beside all modes of the band, and keep most of an error in the residual.
    ///
    /// * `kept`: share of an error of each line that stays in the residual
    pub(super) fn lines_beside(&self, errors: &BlockErrors, kept: &[f64]) -> Vec<usize> {
        let work = self.work;
        let in_band = |omega: &f64| work.in_band((omega * omega).into());
        let middles = self.poles.iter().map(|pole| pole.omega).filter(in_band);
        let middles: Vec<f64> = middles.collect();
        let beside = |k: &usize| {
            let apart = |middle: &f64| errors.cycles((work.x[*k].sqrt() - middle).abs());
            kept[*k] > limits::KEPT_MOSTLY
                && middles
                    .iter()
                    .all(|own| apart(own) >= limits::BESIDE_CYCLES)
        };
        (1..work.lines() - 1).filter(beside).collect()
    }

    /// Noise variance of each pair before the weights of lines: by itself, and as the median line
    /// shows it.
    ///
    /// * `kept`: as for [`Self::lines_beside`]
    pub(super) fn noise(
        &self,
        errors: &BlockErrors,
        residual: &Array2<Complex64>,
        kept: &[f64],
    ) -> [Vec<f64>; 2] {
        let columns = 0..residual.ncols();
        let seen = columns.map(|column| self.median_noise(residual, column));
        let seen: Vec<f64> = seen.collect();
        let beside = match errors.leaks() {
            true => self.lines_beside(errors, kept),
            false => Vec::new(),
        };
        if beside.len() < limits::SHARED_LINES {
            return [self.of_pairs(&seen), self.of_pairs(&seen)];
        }
        let by_chance = limits::LEVEL_SIGMAS * self.scatter(errors, beside.len());
        let apart = |(column, &seen): (usize, &f64)| {
            let of_line = |&k: &usize| self.line_level(errors, residual, (k, column), kept[k]);
            let levels: Vec<LineLevel> = beside.iter().map(of_line).collect();
            let least = limits::NOISE_OF_MEDIAN * seen;
            match level_of(&levels, true).map_or(least, |level| level.max(least)) {
                apart if apart < (1.0 - by_chance) * seen => apart,
                _ => seen,
            }
        };
        let apart: Vec<f64> = seen.iter().enumerate().map(apart).collect();
        [self.of_pairs(&apart), self.of_pairs(&seen)]
    }

    /// Levels of columns as those of pairs.
    fn of_pairs(&self, levels: &[f64]) -> Vec<f64> {
        let usual = levels.iter().sum::<f64>() / levels.len().max(1) as f64;
        let noise = |l: usize| match self.scales_of_frfs {
            Some(_) => levels[l] * self.scale_of(l).powi(2),
            None => usual,
        };
        (0..self.data.pairs.len()).map(noise).collect()
    }

    /// Relative scatter of a difference of two levels that so many lines tell by chance.
    fn scatter(&self, errors: &BlockErrors, lines: usize) -> f64 {
        let work = self.work;
        let spacing = work.spacing(1.0) / (2.0 * work.range().1.sqrt());
        let squares = (1..limits::CYCLES_APART as usize).map(|lag| {
            errors
                .of_noise(errors.cycles(lag as f64 * spacing))
                .norm_sqr()
        });
        let alike = 1.0 + 2.0 * squares.sum::<f64>();
        (2.0 * alike / lines as f64).sqrt()
    }

    /// The noise of a column, from the median of its residual.
    fn median_noise(&self, residual: &Array2<Complex64>, column: usize) -> f64 {
        let values = residual.column(column);
        let mut squares: Vec<f64> = (0..values.len())
            .map(|k| values[k].norm_sqr() / self.expected(k))
            .collect();
        let middle = squares.len() / 2;
        *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / LN_2
    }

    /// Variance of noise of one unit on line k, with the weight of the line.
    fn expected(&self, k: usize) -> f64 {
        self.weight(k).powi(2) * self.data.variance_at(self.work.x[k])
    }

    /// The residual and the slope of a column on line k, of whose error the residual keeps a
    /// share.
    fn line_level(
        &self,
        errors: &BlockErrors,
        residual: &Array2<Complex64>,
        (k, column): (usize, usize),
        kept: f64,
    ) -> LineLevel {
        let work = self.work;
        let fitted = |k: usize| (work.b[[k, column]] - residual[[k, column]]) / self.weight(k);
        let cycles = errors.cycles(work.x[k + 1].sqrt() - work.x[k - 1].sqrt());
        let slope = (fitted(k + 1) - fitted(k - 1)) / cycles;
        LineLevel {
            seen: residual[[k, column]].norm_sqr() / (kept * self.expected(k)),
            slope: slope.norm_sqr() / self.data.variance_at(work.x[k]),
            alone: 0.0,
        }
    }
}
