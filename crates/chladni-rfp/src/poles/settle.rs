//! The loop that settles the number of poles: it takes out poles that cannot be modes, and adds
//! poles that the residual shows, until neither changes anything.

use crate::damping::law::is_rational;
use crate::data::columns::Columns;
use crate::poles::limits;
use crate::poles::prune::{is_one_bad_line, redundant_pole, Patience};
use crate::poles::refine::{refine, Projection, Refined};
use crate::poles::scan::{places_beyond, scan, Scan};
use crate::poles::significance::threshold;
use crate::poles::whiteness::correlates_everywhere;
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Numbers of poles that a fit had, in order, each with its residual variance.
pub(crate) type OrderHistory = Vec<(usize, f64)>;

/// Settles the number of poles. Returns the last scan of the residual.
///
/// * `variance`: of the noise; it falls with the residual
/// * `frfs`: number of FRFs behind the columns. For a sketch, its columns; for compressed columns,
///   all FRFs, because the columns contain the noise that the basis picked up from all of them.
pub(crate) fn settle(
    work: &Columns,
    refined: &mut Refined,
    variance: &mut f64,
    frfs: usize,
    history: &mut OrderHistory,
) -> Result<Scan, LinalgError> {
    let mut guard = StallGuard::new(work, refined);
    let mut search = OrderSearch {
        work,
        refined,
        variance,
        history,
        threshold: threshold(frfs, work.lines()),
        tried: Vec::new(),
        needed: Vec::new(),
    };
    for _ in 0..limits::SCAN_ROUNDS * limits::CHANGES_PER_ROUND {
        if search.take_out()? {
            continue;
        }
        let scanned = scan(work, search.refined);
        let Some(place) = search.next_place(&scanned) else {
            return Ok(scanned);
        };
        if search.add(place)? && guard.added_pole_stalls(search.refined) {
            break;
        }
    }
    Ok(scan(work, search.refined))
}

/// A search for the number of poles under way.
struct OrderSearch<'a> {
    work: &'a Columns,
    refined: &'a mut Refined,
    /// Noise variance of a value.
    variance: &'a mut f64,
    history: &'a mut OrderHistory,
    /// Significant rise of the sum of squares, in units of the variance.
    threshold: f64,
    /// Poles taken out, and places at which one was added or refused: no pole is added there
    /// again.
    tried: Vec<Complex64>,
    /// Poles without which the others do not explain the data.
    needed: Vec<Complex64>,
}

impl OrderSearch<'_> {
    /// Rise of the sum of squares that makes a pole significant.
    fn least_rise(&self) -> f64 {
        self.threshold * *self.variance
    }

    fn note_order(&mut self) {
        let variance = self.refined.variance(self.work);
        self.history.push((self.refined.lambda.len(), variance));
    }

    /// Takes out poles that the data do not need; false if there are none.
    fn take_out(&mut self) -> Result<bool, LinalgError> {
        let least_rise = self.least_rise();
        let found = dispensable(self.work, self.refined, least_rise, &mut self.needed)?;
        let Some((gone, fewer)) = found else {
            return Ok(false);
        };
        self.tried.extend(gone);
        *self.refined = fewer;
        self.note_order();
        Ok(true)
    }

    /// The next place to try a pole at: the best of a scan, or one outside the band.
    fn next_place(&self, scanned: &Scan) -> Option<Complex64> {
        if !self.refined.has_room(self.work.lines()) {
            return None;
        }
        let shown = scanned.beyond(self.least_rise(), &self.tried);
        let best = shown.first().copied();
        best.or_else(|| beyond_the_band(self.work, &self.tried))
    }

    /// Adds a pole at `place` where it is significant, leaves the others so, and stands for no
    /// single bad line; false if it is refused.
    fn add(&mut self, place: Complex64) -> Result<bool, LinalgError> {
        self.tried.push(place);
        let (work, least_rise) = (self.work, self.least_rise());
        let more = [self.refined.lambda.as_slice(), &[place]].concat();
        let candidate = refine(
            work,
            &more,
            &self.refined.powers,
            tol::ROUGH.within(2 * tol::ROUGH.steps),
        )?;
        let gain = self.refined.projection.sse - candidate.projection.sse;
        let last = candidate.lambda.len() - 1;
        let new = candidate.lambda[last];
        let rises = candidate.significance()?;
        let weakest = rises.into_iter().fold(f64::MAX, f64::min);
        // one more beyond the band may take the place of those that are there
        let all_needed = weakest > least_rise || !(work.in_band(place) || work.in_band(new));
        let significant = gain > least_rise && all_needed;
        if !significant || is_one_bad_line(work, &candidate, last, least_rise)? {
            return Ok(false);
        }
        *self.refined = candidate;
        // poles near the new one may be redundant now, and are judged again
        self.needed
            .retain(|pole| (pole - new).norm() > limits::LEANS_WITHIN * (pole.im + new.im));
        *self.variance = self.variance.min(self.refined.variance(work));
        self.note_order();
        Ok(true)
    }
}

/// A guard against poles that represent errors which neighbouring lines share: each lowers the
/// sum of squares a little, and adding them would never end.
struct StallGuard {
    /// Correlation of neighbouring lines' errors by the way they were estimated.
    known: f64,
    /// Poles added so far.
    added: usize,
    /// Sum of squares at the last check, if lines correlated everywhere then.
    before: Option<f64>,
}

impl StallGuard {
    fn new(work: &Columns, start: &Refined) -> Self {
        let mut guard = Self {
            known: work.neighbours,
            added: 0,
            before: None,
        };
        guard.before = guard.sse_if_correlated(start);
        guard
    }

    fn sse_if_correlated(&self, refined: &Refined) -> Option<f64> {
        let Projection { residual, sse, .. } = &refined.projection;
        correlates_everywhere(residual, self.known).then_some(*sse)
    }

    /// Counts one more pole; true if the last few have helped little.
    fn added_pole_stalls(&mut self, refined: &Refined) -> bool {
        let (count, share) = limits::ADDED_IN_VAIN;
        self.added += 1;
        if !self.added.is_multiple_of(count) {
            return false;
        }
        let (before, now) = (self.before, self.sse_if_correlated(refined));
        self.before = now;
        before
            .zip(now)
            .is_some_and(|(before, now)| now > (1.0 - share) * before)
    }
}

/// The next place outside the band at which to try a viscous pole. There residual terms stand for
/// modes less well than in the structural law, and a pool has its poles elsewhere.
fn beyond_the_band(work: &Columns, tried: &[Complex64]) -> Option<Complex64> {
    if is_rational(work.law) {
        return None;
    }
    places_beyond(work).find(|place| !tried.contains(place))
}

/// Poles that the data do not need, and the fit without them: all that stand for one bad line or
/// without which the sum of squares rises by less than `least_rise`; else one [`redundant_pole`].
fn dispensable(
    work: &Columns,
    refined: &Refined,
    least_rise: f64,
    needed: &mut Vec<Complex64>,
) -> Result<Option<(Vec<Complex64>, Refined)>, LinalgError> {
    let lambda = &refined.lambda;
    let spikes = (0..lambda.len())
        .map(|q| is_one_bad_line(work, refined, q, least_rise))
        .collect::<Result<Vec<bool>, LinalgError>>()?;
    let kept = refined
        .projection
        .removable()?
        .thin_out(lambda, |candidate| {
            candidate.rise < least_rise || spikes[candidate.pole]
        });
    if kept.len() < lambda.len() {
        let gone = lambda.iter().copied().filter(|pole| !kept.contains(pole));
        let fewer = refine(work, &kept, &refined.powers, tol::ROUGH)?;
        return Ok(Some((gone.collect(), fewer)));
    }
    let redundant = redundant_pole(work, refined, least_rise, |_| true, needed, Patience::SHORT)?;
    Ok(redundant.map(|(q, fewer)| (vec![lambda[q]], fewer)))
}

/// Keeps the `modes` most significant in-band poles, their number given by the user; returns the
/// others.
pub(crate) fn keep_strongest(
    work: &Columns,
    refined: &mut Refined,
    modes: usize,
) -> Result<Vec<Complex64>, LinalgError> {
    let mut dropped = Vec::new();
    loop {
        let inside: Vec<usize> = (0..refined.lambda.len())
            .filter(|&q| work.in_band(refined.lambda[q]))
            .collect();
        if inside.len() <= modes {
            return Ok(dropped);
        }
        let rises = refined.significance()?;
        let weakest = inside
            .into_iter()
            .min_by(|&a, &b| rises[a].total_cmp(&rises[b]))
            .expect("more than `modes`");
        let mut fewer = refined.lambda.clone();
        dropped.push(fewer.remove(weakest));
        *refined = refine(work, &fewer, &refined.powers, tol::FINE)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::basis::RESIDUAL_POWERS;
    use chladni_frf::Damping;
    use ndarray::Array2;

    /// Ten lines of values that no few poles explain, each far beyond the noise that is said.
    #[test]
    fn poles_are_added_while_there_are_lines_to_judge_them_by() {
        let lines = 10;
        let x: Vec<f64> = (1..=lines).map(|k| (0.1 * k as f64).powi(2)).collect();
        let work = Columns {
            g: vec![1.0; lines],
            b: Array2::from_shape_fn((lines, 40), |(k, c)| {
                Complex64::from_polar(1.0, (1.7 * k as f64 + 2.3 * c as f64).sin() * 9.0)
            }),
            x,
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let start: Vec<Complex64> = [0.1, 0.3, 0.5, 0.7]
            .map(|x| Complex64::new(x, 0.02))
            .to_vec();
        let mut refined = refine(&work, &start, &RESIDUAL_POWERS, tol::NO_STEP).unwrap();
        let (mut variance, mut history) = (1e-9, Vec::new());
        settle(&work, &mut refined, &mut variance, 40, &mut history).unwrap();
        assert!(!history.is_empty() && refined.unknowns() < lines);
    }
}
