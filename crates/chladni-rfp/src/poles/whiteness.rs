//! Test of the residual for whiteness, which decides between the fast chain and the
//! measured-data path (theory.md, eq. 20–21).
//!
//! Under white noise the energy of L lines of M FRFs is σ²/2 times a χ² variable of 2LM
//! degrees of freedom. Each look at the residual is a ratio that is 1 (or 0) under white noise.
//! The tails of Laurent & Massart, Ann. Statist. 28 (2000) 1302, lemma 1, bound its chance spread.
//! There are three kinds of looks:
//!
//! * the level around every mode, for misfit of the line shape;
//! * the level over each tenth of the band, for a noise that is not of one level;
//! * the correlation of neighbouring lines, for leakage, windows and missing modes.
//!
//! All looks together call white noise coloured in at most [`limits::WHITE_FALSE_ALARM`] of all
//! cases. Misfit too small to matter is tolerated on top.

use crate::data::columns::{line_energy, Columns};
use crate::poles::limits;
use crate::tolerances as tol;
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;
use std::ops::Range;

/// Verdict, with the evidence in words.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whiteness {
    /// True if no look speaks against white noise.
    pub white: bool,
    /// The strongest evidence, in words.
    pub evidence: String,
    /// Ratio of this evidence to the limit of white noise and tolerated misfit.
    pub excess: f64,
    /// Part of the in-band poles whose neighbourhood is misfitted.
    pub misfit_share: f64,
    /// True if the misfit around modes has no shape: neighbouring lines do not correlate there, as
    /// they would beside a missing or misplaced pole. It is noise that follows the response; no
    /// number of poles cures it.
    pub shapeless: bool,
}

/// The residual of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Residual {
    /// White noise within its chance spread.
    White,
    /// Noise of another kind, or misfit.
    NotWhite,
    /// Not tested: the method fits the order given and judges nothing.
    NotJudged,
}

/// One look at the residual.
struct Look {
    /// The ratio seen over the limit of white noise and tolerated misfit, or the limit over it
    /// where it must not be lower; above 1 it speaks against white noise.
    excess: f64,
    words: String,
}

impl Look {
    /// A ratio that white noise keeps at or below `limit`.
    fn not_above(limit: f64, seen: f64, words: String) -> Self {
        Self {
            excess: seen / limit.max(limits::LOOK_LEAST),
            words,
        }
    }

    /// A ratio that white noise keeps at or above `limit`.
    fn not_below(limit: f64, seen: f64, words: String) -> Self {
        Self {
            excess: limit / seen.max(limits::LOOK_LEAST),
            words,
        }
    }
}

/// Bounds of chance for one of several looks.
#[derive(Clone, Copy)]
struct Chance {
    /// e^{−t} is the false-alarm rate of one look.
    t: f64,
}

impl Chance {
    fn of(looks: usize) -> Self {
        Self {
            t: (looks as f64 / limits::WHITE_FALSE_ALARM).ln(),
        }
    }
    /// χ²_ν/ν stays below this.
    fn high(self, nu: f64) -> f64 {
        1.0 + 2.0 * (self.t / nu).sqrt() + 2.0 * self.t / nu
    }
    /// χ²_ν/ν stays above this.
    fn low(self, nu: f64) -> f64 {
        (1.0 - 2.0 * (self.t / nu).sqrt()).max(0.0)
    }
    /// Mean of `count` products Re(a b*)/σ² of independent circular values, each of variance ½,
    /// stays below this.
    fn correlation(self, count: f64) -> f64 {
        (self.t / count).sqrt()
    }
}

/// Judges residual columns that stand for all FRFs.
pub(crate) fn judge_columns(
    work: &Columns,
    lambda: &[Complex64],
    residual: &Array2<Complex64>,
    hz: f64,
) -> Whiteness {
    let energy = line_energy(residual) * residual.ncols() as f64;
    judge(work, lambda, &energy, residual.ncols(), residual, hz)
}

/// Judges the residual of a fit with the poles `lambda`.
///
/// * `line_residual`: energy of each line, summed over `frfs` FRFs
/// * `sample`: some residual columns, for the correlation of neighbouring lines
/// * `hz`: frequency of x = 1
pub(crate) fn judge(
    work: &Columns,
    lambda: &[Complex64],
    line_residual: &Array1<f64>,
    frfs: usize,
    sample: &Array2<Complex64>,
    hz: f64,
) -> Whiteness {
    let n = work.lines();
    let mean = line_residual.sum() / n as f64;
    if mean * n as f64 <= limits::EXPLAINED * work.energy() {
        return Whiteness {
            white: true,
            evidence: "the model explains the data to rounding".into(),
            excess: 0.0,
            misfit_share: 0.0,
            shapeless: false,
        };
    }
    let modes: Vec<Complex64> = lambda
        .iter()
        .copied()
        .filter(|p| work.in_band(*p))
        .collect();
    let tenths = limits::NOISE_PARTS.min(n / limits::NOISE_PART_LINES).max(1);
    let level = Level {
        line_residual,
        mean,
        frfs,
        chance: Chance::of(modes.len() + 2 * tenths + 1),
    };
    let window =
        |pole: Complex64| work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
    let mut looks: Vec<Look> = modes
        .iter()
        .map(|&pole| level.around_mode(window(pole), pole.re.max(0.0).sqrt() * hz))
        .collect();
    let misfitted: Vec<Complex64> = modes
        .iter()
        .zip(&looks)
        .filter(|(_, look)| look.excess > 1.0)
        .map(|(pole, _)| *pole)
        .collect();
    let (products, squares) = misfitted
        .iter()
        .map(|&pole| neighbour_sums(sample, window(pole)))
        .fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    let shapeless = !misfitted.is_empty() && products < limits::SHAPELESS * squares;
    let segments = (0..tenths).map(|tenth| tenth * n / tenths..(tenth + 1) * n / tenths);
    looks.extend(segments.flat_map(|rows| level.over_tenth(rows)));
    looks.push(correlation_look(
        sample,
        work.neighbours,
        frfs,
        level.chance,
    ));

    let misfit_share = misfitted.len() as f64 / modes.len().max(1) as f64;
    Whiteness::by_looks(&looks, misfit_share, shapeless)
}

/// The level of the residual in parts of the band.
struct Level<'a> {
    line_residual: &'a Array1<f64>,
    /// Mean energy of a line.
    mean: f64,
    frfs: usize,
    chance: Chance,
}

impl Level<'_> {
    /// The level on `rows` over the average, and its degrees of freedom.
    fn on_rows(&self, rows: Range<usize>) -> (f64, f64) {
        let lines = rows.len();
        (
            self.line_residual.slice(s![rows]).sum() / lines.max(1) as f64 / self.mean,
            (2 * lines.max(1) * self.frfs.max(1)) as f64,
        )
    }

    /// The look at the lines around a mode.
    fn around_mode(&self, rows: Range<usize>, mode_hz: f64) -> Look {
        let (seen, nu) = self.on_rows(rows);
        Look::not_above(
            self.chance.high(nu) + limits::WHITE_LOCAL,
            seen,
            format!("residual {seen:.1} times the average around {mode_hz:.2} Hz"),
        )
    }

    /// The looks at a tenth of the band, for a level too low and too high.
    fn over_tenth(&self, rows: Range<usize>) -> [Look; 2] {
        let (seen, nu) = self.on_rows(rows);
        let words = format!("residual level {seen:.2} times the average over a tenth of the band");
        let low = self.chance.low(nu) / limits::WHITE_SEGMENT;
        let high = limits::WHITE_SEGMENT * self.chance.high(nu);
        [
            Look::not_below(low, seen, words.clone()),
            Look::not_above(high, seen, words),
        ]
    }
}

/// The look at the correlation of neighbouring lines.
///
/// * `known`: the correlation that their errors have by the way they were estimated
fn correlation_look(sample: &Array2<Complex64>, known: f64, frfs: usize, chance: Chance) -> Look {
    let lines = sample.nrows();
    let (products, squares) = neighbour_sums(sample, 0..lines);
    let seen = if squares > 0.0 {
        products / squares
    } else {
        0.0
    };
    let count = (lines * sample.ncols().min(frfs).max(1)) as f64;
    Look::not_above(
        known + limits::WHITE_CORRELATION + chance.correlation(count),
        seen,
        format!("neighbouring residual lines correlate by {seen:.2}"),
    )
}

impl Whiteness {
    /// The verdict, by the look that comes nearest to its limit or goes farthest beyond it.
    fn by_looks(looks: &[Look], misfit_share: f64, shapeless: bool) -> Self {
        let (excess, words) = looks
            .iter()
            .map(|look| (look.excess, look.words.as_str()))
            .fold((0.0, "none"), |a, b| if b.0 > a.0 { b } else { a });
        let white = excess <= 1.0;
        let evidence = match white {
            true => format!(
                "the residual passes all {} whiteness tests (closest: {words})",
                looks.len()
            ),
            false => format!("{words}, {excess:.1} times what white noise allows"),
        };
        Self {
            white,
            evidence,
            excess,
            misfit_share,
            shapeless,
        }
    }
}

/// True if neighbouring lines correlate in all parts of the band but a few. Windows and short
/// records make them do so; a missing mode does it near its own frequency only.
///
/// * `known`: the correlation that their errors have by the way they were estimated
pub(crate) fn correlates_everywhere(residual: &Array2<Complex64>, known: f64) -> bool {
    let (lines, parts) = (residual.nrows(), limits::BAND_PARTS);
    let chance = Chance::of(parts);
    let correlates = |part: &usize| {
        let rows = part * lines / parts..(part + 1) * lines / parts;
        let count = (rows.len() * residual.ncols()).max(1) as f64;
        let (products, squares) = neighbour_sums(residual, rows);
        products > (known + limits::WHITE_CORRELATION + chance.correlation(count)) * squares
    };
    (0..parts).filter(correlates).count() >= limits::PARTS_CORRELATED
}

/// Σ Re E_k E*_{k−1} and Σ|E_k|² over `rows` and all columns.
fn neighbour_sums(residual: &Array2<Complex64>, rows: Range<usize>) -> (f64, f64) {
    let (mut products, mut squares) = (0.0, 0.0);
    for column in residual.columns() {
        for k in rows.start + 1..rows.end {
            products += (column[k] * column[k - 1].conj()).re;
            squares += column[k].norm_sqr();
        }
    }
    (products, squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Axis, ShapeBuilder};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Circular white residuals of unit variance, with poles a few lines wide.
    fn white(
        lines: usize,
        columns: usize,
        seed: u64,
    ) -> (Columns, Vec<Complex64>, Array2<Complex64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || {
            let (u, turn): (f64, f64) = (random.random(), random.random());
            Complex64::from_polar((-(1.0 - u).ln()).sqrt(), std::f64::consts::TAU * turn)
        };
        let residual = Array2::from_shape_simple_fn((lines, columns).f(), &mut draw);
        let x: Vec<f64> = (0..lines).map(|k| (k + 1) as f64 / lines as f64).collect();
        let poles = (1..8)
            .map(|i| Complex64::new(i as f64 / 8.0, 1.5 / lines as f64))
            .collect();
        (
            Columns {
                g: vec![1.0; lines],
                x,
                b: residual.clone(),
                law: chladni_frf::Damping::Structural,
                leakage: None,
                neighbours: 0.0,
            },
            poles,
            residual,
        )
    }

    fn judged(work: &Columns, poles: &[Complex64], residual: &Array2<Complex64>) -> Whiteness {
        let energy = residual.map_axis(Axis(1), |row| row.iter().map(|v| v.norm_sqr()).sum());
        judge(work, poles, &energy, residual.ncols(), residual, 1.0)
    }

    fn verdict(work: &Columns, poles: &[Complex64], residual: &Array2<Complex64>) -> bool {
        judged(work, poles, residual).white
    }

    #[test]
    fn a_missing_mode_has_shape_and_gain_noise_has_none() {
        let (work, poles, residual) = white(400, 4, 1);
        let pole = poles[3];
        let mut missing = residual.clone();
        let mut noisy = residual;
        for k in 0..400 {
            let resonance = pole.im / (pole - work.x[k]);
            missing.row_mut(k).mapv_inplace(|v| v + 10.0 * resonance);
            noisy
                .row_mut(k)
                .mapv_inplace(|v| v * (1.0 + 10.0 * resonance.norm()));
        }
        let (missing, noisy) = (
            judged(&work, &poles, &missing),
            judged(&work, &poles, &noisy),
        );
        assert!(!missing.white && !missing.shapeless, "{missing:?}");
        assert!(!noisy.white && noisy.shapeless, "{noisy:?}");
    }

    #[test]
    fn white_noise_is_called_coloured_in_at_most_one_case_of_a_hundred() {
        for (lines, columns) in [(64, 1), (200, 1), (200, 4), (800, 12)] {
            let alarms = (0..300)
                .filter(|seed| !verdict_of_white(lines, columns, *seed))
                .count();
            // 3 expected at the rate of 1 %; the bound and the tolerance leave fewer
            assert!(
                alarms <= 3,
                "{lines} lines, {columns} FRFs: {alarms} of 300"
            );
        }
        fn verdict_of_white(lines: usize, columns: usize, seed: u64) -> bool {
            let (work, poles, residual) = white(lines, columns, seed);
            verdict(&work, &poles, &residual)
        }
    }

    #[test]
    fn misfit_around_one_mode_two_noise_levels_and_leakage_are_seen() {
        let spoilt =
            |columns: usize, spoil: &dyn Fn(&mut Array2<Complex64>, &Columns, Complex64)| {
                (0..40)
                    .filter(|seed| {
                        let (work, poles, mut residual) = white(400, columns, *seed);
                        spoil(&mut residual, &work, poles[2]);
                        !verdict(&work, &poles, &residual)
                    })
                    .count()
            };
        // twice the amplitude within three half-widths of one mode
        let misfit = |residual: &mut Array2<Complex64>, work: &Columns, pole: Complex64| {
            let rows = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
            residual.slice_mut(s![rows, ..]).mapv_inplace(|v| 2.0 * v);
        };
        let levels = |residual: &mut Array2<Complex64>, _: &Columns, _: Complex64| {
            residual.slice_mut(s![..200, ..]).mapv_inplace(|v| 0.2 * v);
        };
        // each line half its neighbour's
        let leakage = |residual: &mut Array2<Complex64>, _: &Columns, _: Complex64| {
            for mut column in residual.columns_mut() {
                for k in (1..column.len()).rev() {
                    column[k] = 0.9 * column[k] + 0.45 * column[k - 1];
                }
            }
        };
        assert!(spoilt(4, &misfit) >= 38, "misfit {}", spoilt(4, &misfit));
        assert!(spoilt(1, &levels) >= 38, "levels {}", spoilt(1, &levels));
        assert!(spoilt(1, &leakage) >= 38, "leakage {}", spoilt(1, &leakage));
    }
}
