//! Close modes that may be fewer: a pole that moves between FRFs looks, to first order,
//! like two that do not, and like five and more where it moves by more than its bandwidth.
//!
//! R/(λ + ε_l − x) ≈ R/(λ − x) − Rε_l/(λ − x)²: whatever ε_l each FRF has, two poles of
//! the same place fit it. One shape for all references rules it out where each DOF of one
//! side was measured under its own conditions (a roving sensor or hammer) and there are
//! several on the other; with one reference nothing but the second order does. Where
//! most modes of such a set come in twins, each is doubted without a look at that order.
//!
//! Either side may be the moved one. The smaller one is held for it where the modes of a group
//! have one shape at the DOFs of the larger, which two modes of a structure do not have.

use crate::checks::around::{pole, strength, without_others};
use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::data::columns::Columns;
use crate::poles::refine::{refine, Projection};
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use crate::validation::mac::mac;
use chladni_frf::{Finding, Mode, Reason, Trust};
use chladni_linalg::LinalgError;
use ndarray::Axis;
use num_complex::Complex64;
use rayon::prelude::*;
use std::ops::Range;

/// The reason to doubt a mode: moving modes replace it, it stands among such, or only looks so.
const EXPLAINED: &str = "one mode that moves between FRFs explains it and a neighbour as well";
const LIKE_MOST: &str =
    "most close modes of this set are one that moves between FRFs, and it stands close to others";
const LIKE_TWINS: &str = "one mode that moves between FRFs would look like it and its neighbour";

/// The side of the FRFs whose DOFs were measured one after another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Responses,
    References,
}

impl Side {
    fn other(self) -> Self {
        match self {
            Self::Responses => Self::References,
            Self::References => Self::Responses,
        }
    }

    /// The side with more DOFs.
    fn larger(case: &Case) -> Self {
        match case.data.responses.len() >= case.data.references.len() {
            true => Self::Responses,
            false => Self::References,
        }
    }

    /// Conditions that may have differed from one measurement to the next.
    fn causes(self) -> &'static str {
        match self {
            Self::Responses => "a roving sensor's mass, temperature",
            Self::References => {
                "references measured one after another, a roving hammer, temperature"
            }
        }
    }
}

/// Sure modes that fewer modes which move between set-ups explain as well.
pub(crate) fn split_modes(case: &Case) -> Option<Checked> {
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let near = |a: &&Mode, b: &&Mode| {
        let (a, b) = (pole(case, a), pole(case, b));
        (a.re - b.re).abs() < limits::SPLIT_NEAR * a.im.max(b.im)
    };
    if let Some(checked) = mostly_twins(case, &modes) {
        return Some(checked);
    }
    let groups: Vec<&[&Mode]> = modes
        .chunk_by(near)
        .filter(|group| group.len() > 1 && group.iter().any(|mode| mode.trust == Trust::Sure))
        .collect();
    let (mut doubted, mut others, mut moved) = (Vec::new(), Vec::new(), Vec::new());
    let sides = groups.par_iter().map(|group| moved_side(case, group));
    let sides: Vec<Option<Side>> = sides.collect();
    for (group, side) in groups.into_iter().zip(sides) {
        match side {
            Some(side) => {
                doubted.push(group);
                moved.push(side);
            }
            None => others.push(group),
        }
    }
    let larger = Side::larger(case);
    let of_larger = moved.iter().filter(|side| **side == larger).count();
    let side = match 2 * of_larger < moved.len() {
        true => larger.other(),
        false => larger,
    };
    if doubted.is_empty() {
        return None;
    }
    // a mode that moves by more than its bandwidth is three poles and more
    let most_move = doubted.len() >= limits::SPLIT_GROUPS && doubted.len() > others.len();
    let alike: Vec<&[&Mode]> = others
        .into_iter()
        .filter(|group| most_move && group.len() > 2)
        .collect();
    let named = |groups: &[&[&Mode]], n: usize| {
        let mode = &case.model.modes[n];
        groups.iter().any(|group| group.contains(&mode))
    };
    let weak = (0..case.model.modes.len()).filter_map(|n| {
        let why = [(&doubted, EXPLAINED), (&alike, LIKE_MOST)];
        let (_, why) = why.into_iter().find(|(groups, _)| named(groups, n))?;
        Some((n, Reason::new("split-mode", why)))
    });
    Some(Checked {
        finding: finding_of(&doubted, &alike, side, larger),
        weak: weak.collect(),
    })
}

/// True for a mode that [`split_modes`] doubts.
pub(crate) fn is_split(mode: &Mode) -> bool {
    mode.reasons.iter().any(|why| why.code == "split-mode")
}

/// The finding of groups of modes that fewer moving modes explain.
///
/// * `alike`: groups that only look like these
/// * `side`: the moved one
fn finding_of(doubted: &[&[&Mode]], alike: &[&[&Mode]], side: Side, larger: Side) -> Finding {
    let mut words = format!(
        "modes at {} Hz: fewer modes explain each group as well, if their frequencies differ \
         between measurements ({})",
        places(doubted),
        side.causes()
    );
    if !alike.is_empty() {
        words += &format!(
            "; those at {} Hz stand as near to each other",
            places(alike)
        );
    }
    let concerned = doubted.iter().chain(alike).copied().flatten();
    Finding::caution("split-modes", words)
        .modes_hz(concerned.map(|mode| mode.frequency_hz))
        .help(match side == larger {
            true => "measure another reference, or all points at once",
            false => "measure them at once, or fit the FRFs of each by themselves",
        })
}

/// The frequencies of groups of modes, in words.
fn places(groups: &[&[&Mode]]) -> String {
    let of_group = |group: &&[&Mode]| {
        let [first, last] = [0, group.len() - 1].map(|n| group[n].frequency_hz);
        match group.len() {
            2 => format!("{first:.2} and {last:.2}"),
            count => format!("{first:.2} to {last:.2} ({count} modes)"),
        }
    };
    let each: Vec<String> = groups.iter().map(of_group).collect();
    each.join("; ")
}

/// The finding that most modes have a twin: a mode of the same damping, nearer than a part of
/// their half-bandwidth. `None` unless the residual is noise, one side has one DOF, at least half
/// of the modes have a twin, and five or more do.
fn mostly_twins(case: &Case, modes: &[&Mode]) -> Option<Checked> {
    if !case.noise_is_known || case.data.responses.len().min(case.data.references.len()) > 1 {
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
    let reason = Reason::new("split-mode", LIKE_TWINS);
    let weak = (0..case.model.modes.len())
        .filter(|&n| is_twin(&case.model.modes[n]))
        .map(|n| (n, reason.clone()))
        .collect();
    let words = format!(
        "{} of {} modes stand within a fraction of their bandwidth beside another one of the \
         same damping, as one mode does whose frequency differs between measurements ({})",
        twins.len(),
        modes.len(),
        Side::larger(case).causes()
    );
    let finding = Finding::caution("split-modes", words)
        .modes_hz(twins.iter().map(|&n| modes[n].frequency_hz))
        .help("measure another reference, or all points at once");
    Some(Checked { finding, weak })
}

/// The side whose DOFs have poles of their own, if fewer modes that move explain a group. A mode
/// that moves over one side keeps its shape at the other.
fn moved_side(case: &Case, group: &[&Mode]) -> Option<Side> {
    let larger = Side::larger(case);
    let smaller = larger.other();
    let explains = |side: Side| fewer_moving(case, group, side).unwrap_or(false);
    let kept = shapes_at(group, larger);
    if kept[0].len() >= limits::SPLIT_DOFS_LEAST
        && (0..kept.len()).all(|n| is_like_another(&kept, n, limits::SPLIT_ONE_SHAPE))
        && explains(smaller)
    {
        return Some(smaller);
    }
    let kept = shapes_at(group, smaller);
    let possible = kept[0].len() < limits::SPLIT_DOFS_LEAST
        || (0..kept.len()).any(|n| is_like_another(&kept, n, limits::SPLIT_LIKE));
    (possible && explains(larger)).then_some(larger)
}

/// The shapes of a group at the DOFs of a side.
fn shapes_at(group: &[&Mode], side: Side) -> Vec<Vec<Complex64>> {
    let at = |mode: &&Mode| match side {
        Side::Responses => mode.shape.0.clone(),
        Side::References => mode.participation.0.clone(),
    };
    group.iter().map(at).collect()
}

/// True if another shape has this MAC at least with shape `n`.
fn is_like_another(shapes: &[Vec<Complex64>], n: usize, least: f64) -> bool {
    (0..shapes.len()).any(|m| m != n && mac(&shapes[n], &shapes[m]) > least)
}

/// True if fewer moving poles explain the FRFs as well as the common poles do: at most half as
/// many, with places of their own for each DOF of the side that was moved. A repeated pole
/// counts once. Where the residual is more than noise they must explain the FRFs far better.
fn fewer_moving(case: &Case, group: &[&Mode], moved: Side) -> Result<bool, LinalgError> {
    let frfs = by_set_up(case, group, moved);
    if frfs.len() < 2 {
        return Ok(false);
    }
    // Modes of one pole, which a model holds as one number, are told apart by their shapes: no
    // movement makes two of these.
    let mut poles: Vec<Complex64> = group.iter().map(|mode| pole(case, mode)).collect();
    poles.dedup();
    let axis = case.data.axis();
    let rows = poles
        .iter()
        .map(|&pole| axis.window(pole, limits::SPLIT_WINDOW.0, limits::SPLIT_WINDOW.1));
    let rows = rows.reduce(|all, own| Range {
        start: all.start.min(own.start),
        end: all.end.max(own.end),
    });
    let Some(rows) = rows else { return Ok(false) };
    let all: Vec<usize> = frfs.concat();
    let Some((local, own)) = without_others(case, group, rows, &all) else {
        return Ok(false);
    };
    let together = local.with_columns(own.clone());
    // without a level of noise the common poles are moved to where they leave least
    let common = match case.noise_is_known {
        true => Projection::new(&together, &poles, &[0])?.sse,
        false => {
            let steps = tol::ROUGH.within(tol::FINE.steps);
            refine(&together, &poles, &[0], steps)?.projection.sse
        }
    };
    // each further common pole must explain more than chance
    let of_pole = threshold(all.len(), local.lines()) * case.noise.variance;
    let most = match poles.len() {
        0..=limits::SPLIT_POLES_MOST => limits::SPLIT_MOVING_MOST,
        _ => 1,
    };
    for few in 1..=most.min(poles.len() / 2) {
        let (mut moving, mut first) = (0.0, 0);
        for set in &frfs {
            let columns: Vec<usize> = (first..first + set.len()).collect();
            first += set.len();
            let single = local.with_columns(own.select(Axis(1), &columns));
            let start = starts(&single, &poles, few)?;
            moving += refine(&single, &start, &[0], tol::ROUGH.within(tol::FINE.steps))?
                .projection
                .sse;
        }
        // further unknowns of the common poles, those of one pole each: its residues
        let own = few as f64 * (1.0 + frfs.len() as f64 / all.len() as f64);
        let further = (poles.len() as f64 - own).max(1.0);
        let bound = match case.noise_is_known {
            true => common + further * of_pole,
            false => limits::SPLIT_CLEARLY * common,
        };
        if moving < bound {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Starting places for `few` poles: those of a group, or its mean, that explain most of `single`,
/// one after the other.
fn starts(
    single: &Columns,
    poles: &[Complex64],
    few: usize,
) -> Result<Vec<Complex64>, LinalgError> {
    let mean = poles.iter().sum::<Complex64>() / poles.len() as f64;
    let mut left: Vec<Complex64> = [mean].iter().chain(poles).copied().collect();
    let mut taken = Vec::new();
    while taken.len() < few {
        let mut best = (f64::INFINITY, 0);
        for (n, &next) in left.iter().enumerate() {
            let sse = Projection::new(single, &[&taken[..], &[next]].concat(), &[0])?.sse;
            if sse < best.0 {
                best = (sse, n);
            }
        }
        taken.push(left.swap_remove(best.1));
    }
    Ok(taken)
}

/// FRFs (positions among the pairs) that were measured together: those of one DOF of the moved
/// side, of the smaller side only the strongest of each.
fn by_set_up(case: &Case, group: &[&Mode], moved: Side) -> Vec<Vec<usize>> {
    let (responses, references) = (case.data.responses.len(), case.data.references.len());
    let (set_ups, each) = match (moved, Side::larger(case)) {
        (Side::Responses, Side::Responses) => (responses, references),
        (Side::References, Side::References) => (references, responses),
        (Side::Responses, _) => (responses, limits::SPLIT_FRFS_MOST / responses.max(1)),
        (Side::References, _) => (references, limits::SPLIT_FRFS_MOST / references.max(1)),
    };
    let each = each.max(limits::SPLIT_SET_LEAST);
    let mut sets: Vec<Vec<(f64, usize)>> = vec![Vec::new(); set_ups];
    for (l, &pair) in case.data.pairs.iter().enumerate() {
        let energy = |mode: &&Mode| strength(mode, pair).powi(2);
        let dof = match moved {
            Side::Responses => pair.0,
            Side::References => pair.1,
        };
        sets[dof].push((group.iter().map(energy).sum(), l));
    }
    for set in &mut sets {
        set.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        set.truncate(each);
    }
    let seen = |set: &[(f64, usize)]| set.iter().map(|(energy, _)| energy).sum::<f64>();
    sets.sort_by(|a, b| seen(b).total_cmp(&seen(a)));
    let mut left = limits::SPLIT_FRFS_MOST;
    let room = |set: &Vec<(f64, usize)>| {
        let fits = !set.is_empty() && left > 0;
        left = left.saturating_sub(set.len());
        fits
    };
    sets.into_iter()
        .take_while(room)
        .map(|set| set.into_iter().map(|(_, l)| l).collect())
        .collect()
}
