//! Outlier lines: a dropped sample, a mains harmonic, a spoilt average.
//!
//! The residual of a whole fit does not show them, because a pole narrower than a line absorbs
//! each. So the residual is taken without such poles. A line is an outlier if its residual is many
//! times the level around it while its neighbours are sound. A resonance, however narrow, has tails
//! on the lines beside it.

use crate::data::layout::DataLayout;
use crate::data::limits;
use crate::data::peaks::running_median;
use chladni_frf::Finding;
use ndarray::Array1;

/// The treatment of outlier lines in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OutlierLines {
    /// A run that finds some ends, and the next one is made without them.
    LeaveOut,
    /// A run uses all lines that it is given.
    Keep,
}

/// The lines whose residual energy stands alone, by sums over all FRFs.
///
/// * `energy`, `residual`: energies of data and residual on each line
pub(crate) fn outliers_by_energy(energy: &Array1<f64>, residual: &Array1<f64>) -> Vec<usize> {
    let residual = residual.to_vec();
    let fitted: Vec<f64> = energy
        .iter()
        .zip(&residual)
        .map(|(all, residual)| (all - residual).max(0.0))
        .collect();
    single_lines(&residual, &fitted)
}

/// The lines whose residual energy stands alone above the level around them.
///
/// * `residual`, `fitted`: energies of residual and model on each line
pub(crate) fn single_lines(residual: &[f64], fitted: &[f64]) -> Vec<usize> {
    let level = level(residual, fitted);
    let n = residual.len();
    let is_high = |k: usize| {
        residual[k] > limits::OVER_LEVEL * level[k] && residual[k] > limits::OF_MODEL * fitted[k]
    };
    let is_sound = |k: usize| residual[k] < limits::SOUND * level[k];
    let mut found = Vec::new();
    let mut k = 0;
    while k < n {
        let run = (k..n).take_while(|&i| is_high(i)).count();
        let beside = [k.checked_sub(1), Some(k + run).filter(|&i| i < n)];
        if (1..=limits::RUN_MOST).contains(&run) && beside.into_iter().flatten().all(is_sound) {
            found.extend(k..k + run);
        }
        k += run.max(1);
    }
    if found.len() as f64 > limits::OUTLIERS_SHARE_MOST * n as f64 {
        found.clear();
    }
    found
}

/// The usual residual on each line: its running median, and a share of the model that is usual on
/// the strongest lines.
fn level(residual: &[f64], fitted: &[f64]) -> Vec<f64> {
    let n = residual.len();
    let mut strongest: Vec<usize> = (0..n).collect();
    strongest.sort_by(|&a, &b| fitted[b].total_cmp(&fitted[a]));
    strongest.truncate((n / limits::STRONGEST_ONE_IN).max(1));
    let mut shares: Vec<f64> = strongest
        .iter()
        .map(|&k| residual[k] / fitted[k].max(f64::MIN_POSITIVE))
        .collect();
    let middle = shares.len() / 2;
    let share = *shares.select_nth_unstable_by(middle, f64::total_cmp).1;
    running_median(residual, limits::AROUND)
        .iter()
        .zip(fitted)
        .map(|(noise, fitted)| noise + share * fitted)
        .collect()
}

/// The finding on the lines left out, if any.
pub(crate) fn finding(data: &DataLayout) -> Option<Finding> {
    let mut dropped = data.dropped_hz.clone();
    if dropped.is_empty() {
        return None;
    }
    dropped.sort_by(f64::total_cmp);
    let mut names: Vec<String> = dropped
        .iter()
        .take(limits::OUTLIERS_SHOWN)
        .map(|f| format!("{f:.2}"))
        .collect();
    if dropped.len() > limits::OUTLIERS_SHOWN {
        names.push(format!(
            "and {} more",
            dropped.len() - limits::OUTLIERS_SHOWN
        ));
    }
    let finding = Finding::note(
        "outlier-lines",
        format!(
            "{} outlier lines of {} that no neighbouring line supports are left out: {} Hz",
            dropped.len(),
            data.lines.len() + dropped.len(),
            names.join(", ")
        ),
    );
    Some(finding.list("lines_hz", dropped))
}
