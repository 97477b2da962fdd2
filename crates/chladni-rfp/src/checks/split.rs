//! Close modes that may be one: a pole that moves between FRFs looks, to first order,
//! like two or more that do not.
//!
//! R/(λ + ε_l − x) ≈ R/(λ − x) − Rε_l/(λ − x)²: whatever ε_l each FRF has, two poles of
//! the same place fit it. One shape for all references rules it out where each DOF of one
//! side was measured under its own conditions (a roving sensor or hammer) and there are
//! several on the other; with one reference nothing but the second order does. Where
//! most modes of such a set come in twins, each is doubted without a look at that order.

use crate::checks::around::{pole, strength, without_others};
use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::poles::refine::{refine, Projection};
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_frf::{Finding, Mode, Reason, Trust};
use chladni_linalg::LinalgError;
use ndarray::Axis;
use num_complex::Complex64;
use std::ops::Range;

/// Sure modes that one mode per measurement set-up explains as well.
pub(crate) fn split_modes(case: &Case) -> Option<Checked> {
    if !case.white {
        return None;
    }
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let near = |a: &&Mode, b: &&Mode| {
        let (a, b) = (pole(case, a), pole(case, b));
        (a.re - b.re).abs() < limits::SPLIT_NEAR * a.im.max(b.im)
    };
    if let Some(checked) = mostly_twins(case, &modes) {
        return Some(checked);
    }
    let groups = modes
        .chunk_by(near)
        .filter(|group| group.len() > 1 && group.iter().any(|mode| mode.trust == Trust::Sure));
    let doubted: Vec<&[&Mode]> = groups
        .filter(|group| one_moving(case, group).unwrap_or(false))
        .collect();
    if doubted.is_empty() {
        return None;
    }
    let places = |group: &&[&Mode]| {
        group
            .iter()
            .map(|mode| format!("{:.2}", mode.frequency_hz))
            .collect::<Vec<_>>()
            .join(" and ")
    };
    let words = format!(
        "modes at {} Hz: one mode whose frequency differs between measurements (a roving sensor's \
         mass, temperature) explains each group as well as several",
        doubted.iter().map(places).collect::<Vec<_>>().join("; ")
    );
    let named = |mode: &Mode| doubted.iter().any(|group| group.contains(&mode));
    let reason = Reason::new(
        "split-mode",
        "one mode that moves between FRFs explains it and its neighbour as well",
    );
    let weak = (0..case.model.modes.len())
        .filter(|&n| named(&case.model.modes[n]))
        .map(|n| (n, reason.clone()))
        .collect();
    let concerned = doubted.iter().copied().flatten();
    let finding = Finding::caution("split-modes", words)
        .modes_hz(concerned.map(|mode| mode.frequency_hz))
        .help("measure another reference, or all points at once");
    Some(Checked { finding, weak })
}

/// The modes that have a twin, where one side has one DOF and most modes are so: of the
/// same damping, and nearer than a part of their half-bandwidth.
fn mostly_twins(case: &Case, modes: &[&Mode]) -> Option<Checked> {
    if case.data.responses.len().min(case.data.references.len()) > 1 {
        return None;
    }
    let alike = |a: Complex64, b: Complex64| {
        let near = (a - b).norm() < limits::TWIN_NEAR * a.im.min(b.im);
        near && a.im.max(b.im) < limits::TWIN_DAMPING * a.im.min(b.im)
    };
    let twins: Vec<usize> = (0..modes.len())
        .filter(|&n| {
            let own = pole(case, modes[n]);
            (0..modes.len()).any(|m| m != n && alike(own, pole(case, modes[m])))
        })
        .collect();
    if twins.len() < limits::TWINS_LEAST || 2 * twins.len() < modes.len() {
        return None;
    }
    let is_twin = |mode: &Mode| twins.iter().any(|&n| std::ptr::eq(modes[n], mode));
    let reason = Reason::new(
        "split-mode",
        "one mode that moves between FRFs would look like it and its neighbour",
    );
    let weak = (0..case.model.modes.len())
        .filter(|&n| is_twin(&case.model.modes[n]))
        .map(|n| (n, reason.clone()))
        .collect();
    let words = format!(
        "{} of {} modes stand within a fraction of their bandwidth beside another one of the \
         same damping, as one mode does whose frequency differs between measurements (a roving \
         sensor's mass, temperature)",
        twins.len(),
        modes.len()
    );
    let finding = Finding::caution("split-modes", words)
        .modes_hz(twins.iter().map(|&n| modes[n].frequency_hz))
        .help("measure another reference, or all points at once");
    Some(Checked { finding, weak })
}

/// True where a pole of its own for each DOF of the side that was moved leaves no more of
/// the FRFs than the common poles do.
fn one_moving(case: &Case, group: &[&Mode]) -> Result<bool, LinalgError> {
    let frfs = by_set_up(case, group);
    let poles: Vec<Complex64> = group.iter().map(|mode| pole(case, mode)).collect();
    let middle = poles.iter().sum::<Complex64>() / poles.len() as f64;
    let axis = case.data.axis();
    let rows = poles
        .iter()
        .map(|&pole| axis.window(pole, limits::SPLIT_WINDOW.0, limits::SPLIT_WINDOW.1));
    let rows = rows
        .reduce(|all, own| Range {
            start: all.start.min(own.start),
            end: all.end.max(own.end),
        })
        .expect("two modes");
    let all: Vec<usize> = frfs.concat();
    let Some((local, own)) = without_others(case, group, rows, &all) else {
        return Ok(false);
    };
    let common = Projection::new(&local.with_columns(own.clone()), &poles, &[0])?.sse;
    let (mut moving, mut first) = (0.0, 0);
    for set in &frfs {
        let columns: Vec<usize> = (first..first + set.len()).collect();
        first += set.len();
        let single = local.with_columns(own.select(Axis(1), &columns));
        moving += refine(&single, &[middle], &[0], tol::REFINE_FINE, tol::ROUGH_STEP)?
            .projection
            .sse;
    }
    Ok(moving < common + threshold(all.len(), local.lines()) * case.noise_variance)
}

/// FRFs (positions among the pairs) that were measured together, if the side with more
/// DOFs was moved: those of one DOF of it.
fn by_set_up(case: &Case, group: &[&Mode]) -> Vec<Vec<usize>> {
    let (responses, references) = (case.data.responses.len(), case.data.references.len());
    let moved = |(i, j): (usize, usize)| if responses >= references { i } else { j };
    let mut sets: Vec<(f64, Vec<usize>)> = vec![(0.0, Vec::new()); responses.max(references)];
    for (l, &pair) in case.data.pairs.iter().enumerate() {
        let (seen, set) = &mut sets[moved(pair)];
        *seen += group
            .iter()
            .map(|mode| strength(mode, pair).powi(2))
            .sum::<f64>();
        set.push(l);
    }
    sets.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut left = limits::SPLIT_FRFS_MOST;
    let room = |(_, set): &(f64, Vec<usize>)| {
        let fits = !set.is_empty() && left > 0;
        left = left.saturating_sub(set.len());
        fits
    };
    sets.into_iter()
        .take_while(room)
        .map(|(_, set)| set)
        .collect()
}
