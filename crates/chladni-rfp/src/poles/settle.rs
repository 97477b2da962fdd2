//! The loop that settles the order: what cannot be a mode goes, what the residual shows
//! comes, until neither changes anything.

use crate::damping::law::is_rational;
use crate::data::columns::Columns;
use crate::poles::limits;
use crate::poles::prune::{is_spike, redundant_pole};
use crate::poles::refine::{refine, Projection, Refined};
use crate::poles::scan::{places_beyond, scan, Scan};
use crate::poles::significance::threshold;
use crate::poles::whiteness::correlates_everywhere;
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Drops what cannot be a mode, adds what the residual shows, until neither changes
/// anything.
///
/// `frfs`: FRFs whose noise a pole of the model takes along. On a sketch these are its
/// columns; compressed columns hold all that the basis they were made with takes out of
/// *all* FRFs, noise included. Returns the last look at the residual.
pub(crate) fn settle(
    work: &Columns,
    refined: &mut Refined,
    variance: &mut f64,
    frfs: usize,
    history: &mut Vec<(usize, f64)>,
) -> Result<Scan, LinalgError> {
    let limit = threshold(frfs, work.lines());
    let mut vain = InVain::new(refined);
    let (mut tried, mut needed): (Vec<Complex64>, Vec<Complex64>) = (Vec::new(), Vec::new());
    for _ in 0..limits::SCAN_ROUNDS * limits::CHANGES_PER_ROUND {
        if let Some((gone, fewer)) = dispensable(work, refined, limit * *variance, &mut needed)? {
            tried.extend(gone);
            *refined = fewer;
            history.push((refined.lambda.len(), refined.variance(work)));
            continue;
        }
        let scanned = scan(work, refined);
        if !refined.has_room(work.lines()) {
            return Ok(scanned);
        }
        let shown = scanned.beyond(limit * *variance, &tried).first().copied();
        let Some(pole) = shown.or_else(|| beyond_the_band(work, &tried)) else {
            return Ok(scanned);
        };
        tried.push(pole);
        let mut more = refined.lambda.clone();
        more.push(pole);
        let candidate = refine(
            work,
            &more,
            &refined.powers,
            tol::ROUGH.within(2 * tol::ROUGH.steps),
        )?;
        let gain = refined.projection.sse - candidate.projection.sse;
        let new = *candidate.lambda.last().expect("one was added");
        let weakest = candidate
            .significance()?
            .into_iter()
            .fold(f64::MAX, f64::min);
        // one more beyond the band may take the place of those that are there
        let needed_all = weakest > limit * *variance || !(work.in_band(pole) || work.in_band(new));
        let last = candidate.lambda.len() - 1;
        if gain > limit * *variance
            && needed_all
            && !is_spike(work, &candidate, last, limit * *variance)?
        {
            *refined = candidate;
            // poles near the new one may be redundant now, and are judged again
            needed.retain(|pole| (pole - new).norm() > limits::LEANS_WITHIN * (pole.im + new.im));
            *variance = variance.min(refined.variance(work));
            history.push((refined.lambda.len(), refined.variance(work)));
            if vain.after(refined) {
                break;
            }
        }
    }
    Ok(scan(work, refined))
}

/// A guard against poles that stand for errors which neighbouring lines share: each lowers the
/// sum of squares a little, and adding them would never end.
struct InVain {
    added: usize,
    /// Sum of squares at the last look, if lines correlated everywhere then.
    before: Option<f64>,
}

impl InVain {
    fn new(start: &Refined) -> Self {
        Self {
            added: 0,
            before: Self::look(start),
        }
    }

    fn look(refined: &Refined) -> Option<f64> {
        let Projection { residual, sse, .. } = &refined.projection;
        correlates_everywhere(residual).then_some(*sse)
    }

    /// Counts one pole more; true if the last few have helped little.
    fn after(&mut self, refined: &Refined) -> bool {
        let (count, share) = limits::ADDED_IN_VAIN;
        self.added += 1;
        if !self.added.is_multiple_of(count) {
            return false;
        }
        let (before, now) = (self.before, Self::look(refined));
        self.before = now;
        before
            .zip(now)
            .is_some_and(|(before, now)| now > (1.0 - share) * before)
    }
}

/// The next place outside the band where a viscous mode may lie: residual terms stand for
/// it less well than in the structural law, and a pool has its poles elsewhere.
fn beyond_the_band(work: &Columns, tried: &[Complex64]) -> Option<Complex64> {
    if is_rational(work.law) {
        return None;
    }
    places_beyond(work).find(|place| !tried.contains(place))
}

/// Poles that the data do not need, and the fit without them: all that stand for no mode
/// or without which the sum of squares rises by less than `limit`, or else one
/// [`redundant_pole`].
fn dispensable(
    work: &Columns,
    refined: &Refined,
    limit: f64,
    needed: &mut Vec<Complex64>,
) -> Result<Option<(Vec<Complex64>, Refined)>, LinalgError> {
    let lambda = &refined.lambda;
    let spikes = (0..lambda.len())
        .map(|q| is_spike(work, refined, q, limit))
        .collect::<Result<Vec<bool>, LinalgError>>()?;
    let kept = refined
        .projection
        .removable()?
        .thin_out(lambda, |_, q, rise, _| rise < limit || spikes[q]);
    if kept.len() < lambda.len() {
        let gone = lambda
            .iter()
            .copied()
            .filter(|pole| !kept.contains(pole))
            .collect();
        return Ok(Some((
            gone,
            refine(work, &kept, &refined.powers, tol::ROUGH)?,
        )));
    }
    Ok(redundant_pole(work, refined, limit, |_| true, needed)?
        .map(|(q, fewer)| (vec![lambda[q]], fewer)))
}

/// Keeps the `modes` in-band poles that matter most (an order given by the user); returns
/// the others.
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
    use crate::damping::structural::POWERS;
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
        };
        let start: Vec<Complex64> = [0.1, 0.3, 0.5, 0.7]
            .map(|x| Complex64::new(x, 0.02))
            .to_vec();
        let mut refined = refine(&work, &start, &POWERS, tol::NO_STEP).unwrap();
        let (mut variance, mut history) = (1e-9, Vec::new());
        settle(&work, &mut refined, &mut variance, 40, &mut history).unwrap();
        assert!(!history.is_empty() && refined.unknowns() < lines);
    }
}
