//! Lines that none of their neighbours supports: a dropped sample, a mains harmonic, a
//! spoilt average.
//!
//! The residual alone does not see them: a pole narrower than a line absorbs each. So
//! such poles do not count, and a line is an outlier where what is left of it exceeds
//! many times the level around it while its neighbours are sound. A resonance, however
//! narrow, has tails on the lines beside it.

use crate::data::layout::DataLayout;
use crate::data::limits;
use crate::data::peaks::running_median;
use chladni_frf::Finding;

/// The treatment of outlier lines in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OutlierLines {
    /// A run that finds some ends, and the next one is made without them.
    LeaveOut,
    /// A run uses all lines that it is given.
    Keep,
}

/// The lines whose residual energy `left` stands alone above what it is around them;
/// `fitted` is the energy of the model.
pub(crate) fn single_lines(left: &[f64], fitted: &[f64]) -> Vec<usize> {
    let level = level(left, fitted);
    let n = left.len();
    let high = |k: usize| {
        left[k] > limits::OVER_LEVEL * level[k] && left[k] > limits::OF_MODEL * fitted[k]
    };
    let mut found = Vec::new();
    let mut k = 0;
    while k < n {
        let run = (k..n).take_while(|&i| high(i)).count();
        let beside = [k.checked_sub(1), Some(k + run).filter(|&i| i < n)];
        if (1..=limits::RUN_MOST).contains(&run)
            && beside
                .into_iter()
                .flatten()
                .all(|i| left[i] < limits::SOUND * level[i])
        {
            found.extend(k..k + run);
        }
        k += run.max(1);
    }
    if found.len() as f64 > limits::OUTLIERS_SHARE_MOST * n as f64 {
        found.clear();
    }
    found
}

/// The usual residual on each line: its running median, and the usual share of the model
/// on the strongest lines.
fn level(left: &[f64], fitted: &[f64]) -> Vec<f64> {
    let n = left.len();
    let mut strongest: Vec<usize> = (0..n).collect();
    strongest.sort_by(|&a, &b| fitted[b].total_cmp(&fitted[a]));
    strongest.truncate((n / limits::STRONGEST_ONE_IN).max(1));
    let mut shares: Vec<f64> = strongest
        .iter()
        .map(|&k| left[k] / fitted[k].max(f64::MIN_POSITIVE))
        .collect();
    let middle = shares.len() / 2;
    let share = *shares.select_nth_unstable_by(middle, f64::total_cmp).1;
    running_median(left, limits::AROUND)
        .iter()
        .zip(fitted)
        .map(|(l, f)| l + share * f)
        .collect()
}

/// The finding on the lines left out, if any.
pub(crate) fn words(data: &DataLayout) -> Option<Finding> {
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
