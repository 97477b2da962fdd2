//! Leakage of poles into the lines about a mode.

use crate::damping::columns::{leaking_pole, resonance};
use crate::data::window::band::{Band, Leak};
use crate::data::window::kernel::Force;
use crate::shapes::influence::Influence;
use num_complex::Complex64;

/// Leakage of some poles into some lines.
pub(super) struct LeakageIntoLines<'a> {
    pub band: Band<'a>,
    /// Of each pole.
    pub leaks: Vec<Leak>,
    /// Its column over 1/(jω − s) on each line.
    pub units: Vec<Vec<Complex64>>,
}

impl Influence<'_> {
    /// Leakage of `poles` into `lines` about the mode n; `None` where nothing leaks.
    ///
    /// * `drop`: the force, where it drops at the resonance of n
    pub fn leaking(
        &self,
        n: usize,
        poles: &[usize],
        lines: &[usize],
        drop: Option<Force>,
    ) -> Option<LeakageIntoLines<'_>> {
        let (work, middle) = (self.found.work, self.middle(n));
        let y: Vec<f64> = lines.iter().map(|&k| work.x[k].sqrt()).collect();
        let s: Vec<Complex64> = poles
            .iter()
            .map(|&m| leaking_pole(work.law, self.lambda[m]).s)
            .collect();
        let slowest = s.iter().map(|s| -s.re).fold(f64::MAX, f64::min);
        let cycles = y.iter().map(|y| self.errors.cycles(y - middle)).collect();
        let offset = |s: &Complex64| s - Complex64::new(0.0, middle);
        let own = leaking_pole(work.law, self.lambda[n]).s;
        let drop = drop.map(|force| self.errors.dropping(force, offset(&own)));
        let band = self.errors.band(cycles, slowest, drop)?;
        let leaks = s.iter().map(|s| band.leak(offset(s))).collect();
        // the column of a pole over 1/(jω − s), with the weight of the line
        let unit = |(&m, s): (&usize, &Complex64)| -> Vec<Complex64> {
            let at = |(&k, &y): (&usize, &f64)| {
                let plain = resonance(work.law, self.lambda[m], work.x[k]);
                work.g[k] * plain * (Complex64::new(0.0, y) - s)
            };
            lines.iter().zip(&y).map(at).collect()
        };
        let units = poles.iter().zip(&s).map(unit).collect();
        Some(LeakageIntoLines { band, leaks, units })
    }

    /// Variance of what the first pole leaks into a line, for one block.
    pub fn leaked_on(&self, leaking: &LeakageIntoLines, place: usize) -> f64 {
        let mut row = vec![Complex64::ZERO; leaking.units[0].len()];
        row[place] = leaking.units[0][place];
        let form = leaking.band.form(std::iter::once((row, &leaking.leaks[0])));
        leaking.band.covariance(&[form])[[0, 0]].re
    }
}
