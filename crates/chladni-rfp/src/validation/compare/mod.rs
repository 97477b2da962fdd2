//! Two sets of modes side by side: which mode is which, how alike their shapes are, how
//! far they have moved, and which have no partner.

mod common_dofs;
mod mac_estimate;
mod tracking;

pub use common_dofs::PairDofs;
pub use mac_estimate::MacEstimate;
pub use tracking::{track, ModeTrack, TrackAgainst, Tracking};

use crate::validation::limits::{LEAST_MAC, LEAST_PAIRED, SAME_EXTENT, UNIT_FACTOR};
use chladni_frf::{Error, Finding, Result, ShapeMode, ShapeSet};
use common_dofs::{extent_m, CommonDofs};
use mac_estimate::{mac_estimate, UncertainShape};
use ndarray::Array2;
use num_complex::Complex64;
use serde::Serialize;
use serde_json::{json, Value};

/// Settings of the pairing of modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareOptions {
    /// The rule by which DOFs find their partners.
    pub pair_dofs: PairDofs,
    /// Least MAC of a pair, without what noise takes from it.
    pub least_mac: f64,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            pair_dofs: PairDofs::Auto,
            least_mac: LEAST_MAC,
        }
    }
}

/// A mode of the first set and its partner in the second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ModePair {
    /// Number of the mode in the first set, from 1.
    pub a: usize,
    /// Number of the mode in the second set, from 1.
    pub b: usize,
    /// Natural frequencies of both, Hz.
    pub frequency_hz: [f64; 2],
    /// Second minus first, Hz.
    pub frequency_shift_hz: f64,
    /// The shift in standard deviations; `None` where neither is known.
    pub frequency_shift_sigmas: Option<f64>,
    /// Loss factors of both; `None` where a source has no damping.
    pub loss_factor: [Option<f64>; 2],
    /// Second minus first.
    pub loss_factor_shift: Option<f64>,
    /// The shift in standard deviations.
    pub loss_factor_shift_sigmas: Option<f64>,
    /// MAC of the shapes.
    pub mac: f64,
    /// Its standard deviation.
    pub mac_std: f64,
    /// Mean part that the errors of the shapes add to it.
    pub mac_noise_bias: f64,
}

/// A mode without a partner.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LoneMode {
    /// Number of the mode in its set, from 1.
    pub mode: usize,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Number of the mode of the other set that looks most like it, from 1, and the MAC
    /// of the two; `None` where the other set is empty.
    pub most_alike: Option<(usize, f64)>,
}

/// Two sets of modes side by side.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Comparison {
    /// The rule by which DOFs found their partners: by name or by place.
    pub paired_by: PairDofs,
    /// DOFs that both sets have, which the MAC is taken over.
    pub common_dofs: usize,
    /// Largest distance between partners, m; `None` where positions are not known.
    pub largest_distance_m: Option<f64>,
    /// MAC of every mode of the first with every mode of the second.
    pub mac: Array2<MacEstimate>,
    /// Pairs, in the order of the first set.
    pub pairs: Vec<ModePair>,
    /// Modes of the first set alone.
    pub only_in_a: Vec<LoneMode>,
    /// Modes of the second set alone.
    pub only_in_b: Vec<LoneMode>,
    /// Findings that the user must know.
    pub findings: Vec<Finding>,
}

impl Comparison {
    /// One number of every entry of the MAC matrix.
    pub fn mac_matrix(&self, of: impl Fn(&MacEstimate) -> f64) -> Array2<f64> {
        self.mac.map(of)
    }

    /// The comparison as `chladni compare` gives it in JSON.
    pub fn to_json(&self) -> Value {
        let rows = |of: fn(&MacEstimate) -> f64| -> Vec<Vec<f64>> {
            self.mac
                .rows()
                .into_iter()
                .map(|row| row.iter().map(of).collect())
                .collect()
        };
        let alone = |modes: &[LoneMode]| -> Vec<Value> {
            modes
                .iter()
                .map(|mode| {
                    json!({
                        "mode": mode.mode,
                        "frequency_hz": mode.frequency_hz,
                        "most_alike": mode.most_alike.map(|(number, _)| number),
                        "mac": mode.most_alike.map(|(_, mac)| mac),
                    })
                })
                .collect()
        };
        json!({
            "paired_by": self.paired_by.as_str(),
            "common_dofs": self.common_dofs,
            "largest_distance_m": self.largest_distance_m,
            "mac": rows(|mac| mac.value),
            "mac_std": rows(|mac| mac.std),
            "mac_noise_bias": rows(|mac| mac.noise_bias),
            "pairs": self.pairs,
            "only_in_a": alone(&self.only_in_a),
            "only_in_b": alone(&self.only_in_b),
            "warnings": chladni_frf::warnings(&self.findings),
            "findings": self.findings,
        })
    }
}

/// Pairs the modes of two sets by their shapes at the DOFs that both have.
///
/// The best pair comes first, by the MAC without noise times the ratio of the lower to
/// the higher frequency: shapes decide, frequencies where shapes cannot.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where the sets share no DOF.
pub fn compare(a: &ShapeSet, b: &ShapeSet, options: &CompareOptions) -> Result<Comparison> {
    let dofs = CommonDofs::new(a, b, options.pair_dofs);
    if dofs.pairs.is_empty() {
        return Err(nothing_in_common(a, b, &dofs));
    }
    let (of_a, of_b) = (
        at_dofs(a, dofs.pairs.iter().map(|&(i, ..)| (i, 1.0))),
        at_dofs(b, dofs.pairs.iter().map(|&(_, j, sign)| (j, sign))),
    );
    let mac = Array2::from_shape_fn((of_a.len(), of_b.len()), |(n, m)| {
        match (&of_a[n], &of_b[m]) {
            (Some(a), Some(b)) => mac_estimate(a, b),
            _ => MacEstimate::default(),
        }
    });
    let places = pair_modes(a, b, &mac, options.least_mac);
    let pairs = places
        .iter()
        .map(|&(n, m)| pair(n, m, &a.modes[n], &b.modes[m], &mac[[n, m]]))
        .collect();
    Ok(Comparison {
        only_in_a: alone(a, &mac, |n| places.iter().all(|&(a, _)| a != n)),
        only_in_b: alone(b, &mac.t().to_owned(), |m| {
            places.iter().all(|&(_, b)| b != m)
        }),
        findings: findings(a, b, &dofs),
        paired_by: dofs.by,
        common_dofs: dofs.pairs.len(),
        largest_distance_m: dofs.largest_distance_m,
        mac,
        pairs,
    })
}

fn nothing_in_common(a: &ShapeSet, b: &ShapeSet, dofs: &CommonDofs) -> Error {
    let first = |set: &ShapeSet| set.dofs.first().map_or("none".into(), ToString::to_string);
    let error = |found: String, expected: &str, help: String| {
        Error::bad_data("the two have no DOF in common")
            .found(found)
            .expected(expected)
            .help(help)
    };
    if dofs.names_contradicted {
        let names = "the same names of nodes, each at another place";
        return error(names.into(), "nodes at the same places", ways_out(a, b));
    }
    let found = format!("DOFs like {} and {}", first(a), first(b));
    if a.nodes.is_empty() || b.nodes.is_empty() {
        let help = "compare models of one structure, with positions or with the same names";
        return error(
            found,
            "the same names of nodes and directions, or positions of the nodes in both",
            help.into(),
        );
    }
    error(
        format!("{found}, none at the same place"),
        "the same names of nodes and directions, or nodes at the same places",
        ways_out(a, b),
    )
}

/// Advice that makes points coincide: one unit, one coordinate system, or names alone.
fn ways_out(a: &ShapeSet, b: &ShapeSet) -> String {
    let times = extent_m(b) / extent_m(a);
    let is_thousand = |times: f64| (times / UNIT_FACTOR).ln().abs() < SAME_EXTENT.ln();
    if is_thousand(times) || is_thousand(times.recip()) {
        let larger = if times > 1.0 { "second" } else { "first" };
        return format!(
            "the points of the {larger} span {:.0} times as much as those of the other: correct the \
             unit of its positions (mm read as m?), or pair DOFs by name",
            times.max(times.recip())
        );
    }
    "give the positions of both in one unit, from one origin along the same axes; or pair DOFs by \
     name where names stand for the same nodes"
        .into()
}

/// The shapes of a set at some of its DOFs, some of them turned round.
fn at_dofs(
    set: &ShapeSet,
    places: impl Iterator<Item = (usize, f64)> + Clone,
) -> Vec<Option<UncertainShape>> {
    let of = |mode: &ShapeMode| {
        let values: Vec<Complex64> = (places.clone())
            .map(|(place, sign)| mode.shape[place] * sign)
            .collect();
        let std = places.clone().map(|(place, _)| mode.shape_std[place]);
        UncertainShape::new(values, std.collect())
    };
    set.modes.iter().map(of).collect()
}

/// Places of the pairs in both sets, by rising place in the first.
fn pair_modes(
    a: &ShapeSet,
    b: &ShapeSet,
    mac: &Array2<MacEstimate>,
    least_mac: f64,
) -> Vec<(usize, usize)> {
    let mut candidates: Vec<(f64, usize, usize)> = mac
        .indexed_iter()
        .filter(|(_, mac)| mac.unbiased() >= least_mac)
        .map(|((n, m), mac)| {
            let closeness = closeness(a.modes[n].frequency_hz, b.modes[m].frequency_hz);
            (mac.unbiased() * closeness, n, m)
        })
        .collect();
    candidates.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let (mut free_a, mut free_b) = (vec![true; a.modes.len()], vec![true; b.modes.len()]);
    let mut places: Vec<(usize, usize)> = candidates
        .into_iter()
        .map(|(_, n, m)| (n, m))
        .filter(|&(n, m)| {
            let both = free_a[n] && free_b[m];
            if both {
                (free_a[n], free_b[m]) = (false, false);
            }
            both
        })
        .collect();
    places.sort_unstable();
    places
}

/// Lower over higher frequency; 1 where one is not known.
fn closeness(a_hz: f64, b_hz: f64) -> f64 {
    if a_hz > 0.0 && b_hz > 0.0 {
        (a_hz / b_hz).min(b_hz / a_hz)
    } else {
        1.0
    }
}

fn pair(n: usize, m: usize, a: &ShapeMode, b: &ShapeMode, mac: &MacEstimate) -> ModePair {
    let sigmas = |shift: f64, of_a: f64, of_b: f64| {
        let std = of_a.hypot(of_b);
        (std > 0.0 && std.is_finite()).then(|| shift / std)
    };
    let shift_hz = b.frequency_hz - a.frequency_hz;
    let loss_shift = a.loss_factor.zip(b.loss_factor).map(|(a, b)| b - a);
    ModePair {
        a: n + 1,
        b: m + 1,
        frequency_hz: [a.frequency_hz, b.frequency_hz],
        frequency_shift_hz: shift_hz,
        frequency_shift_sigmas: sigmas(shift_hz, a.frequency_std_hz, b.frequency_std_hz),
        loss_factor: [a.loss_factor, b.loss_factor],
        loss_factor_shift: loss_shift,
        loss_factor_shift_sigmas: loss_shift
            .and_then(|shift| sigmas(shift, a.loss_factor_std, b.loss_factor_std)),
        mac: mac.value,
        mac_std: mac.std,
        mac_noise_bias: mac.noise_bias,
    }
}

fn alone(
    set: &ShapeSet,
    mac: &Array2<MacEstimate>,
    is_alone: impl Fn(usize) -> bool,
) -> Vec<LoneMode> {
    let lone = |n: usize| LoneMode {
        mode: n + 1,
        frequency_hz: set.modes[n].frequency_hz,
        most_alike: (mac.row(n).iter().enumerate())
            .max_by(|x, y| x.1.value.total_cmp(&y.1.value))
            .map(|(m, mac)| (m + 1, mac.value)),
    };
    (0..set.modes.len())
        .filter(|&n| is_alone(n))
        .map(lone)
        .collect()
}

fn findings(a: &ShapeSet, b: &ShapeSet, dofs: &CommonDofs) -> Vec<Finding> {
    let mut findings = Vec::new();
    let (common, modes) = (dofs.pairs.len(), a.modes.len().max(b.modes.len()));
    if dofs.names_contradicted && dofs.by == PairDofs::Nearest {
        findings.push(Finding::note(
            "nodes-renumbered",
            "names of nodes are shared, but stand for other places: paired by place instead",
        ));
    }
    if let Some([x, y, z]) = dofs.offset_m.filter(|_| dofs.by == PairDofs::Name) {
        findings.push(
            Finding::note(
                "origin-differs",
                format!(
                    "positions in b lie ({:.1}, {:.1}, {:.1}) mm beyond those of the same names in \
                     a, another origin: paired by name",
                    1e3 * x,
                    1e3 * y,
                    1e3 * z
                ),
            )
            .list("offset_m", [x, y, z])
            .help("pair DOFs by the nearest node where names do not stand for the same nodes"),
        );
    } else if dofs.names_contradicted && dofs.by == PairDofs::Name {
        findings.push(
            Finding::caution(
                "nodes-elsewhere",
                "nodes of one name lie at different places: paired by name as asked",
            )
            .help("check the units and the origin of the positions"),
        );
    }
    let fewer = a.dofs.len().min(b.dofs.len());
    if dofs.by == PairDofs::Nearest && (common as f64) < LEAST_PAIRED * fewer as f64 {
        findings.push(
            Finding::caution(
                "points-apart",
                format!("only {common} of {fewer} DOFs have a partner at their place"),
            )
            .value("common_dofs", common as f64)
            .value("dofs", fewer as f64)
            .help(ways_out(a, b)),
        );
    }
    if common < modes {
        findings.push(
            Finding::caution(
                "few-common-dofs",
                format!(
                    "{common} DOFs in common for up to {modes} modes: different shapes can look \
                     alike"
                ),
            )
            .value("common_dofs", common as f64)
            .help("compare at more points, or read the pairs with their frequencies"),
        );
    }
    findings
}

#[cfg(test)]
mod tests;
