//! The command that `chladni render` suggests as the next one.

use super::Args;
use crate::limits::SWEEP_HZ;
use chladni_console::next_step::{is_of_gains, report};
use chladni_console::quoting::shell_path;
use chladni_console::table::significant;
use chladni_render::Weights;

/// For a drive that is too sensitive to the panel: a sweep, or after a sweep the suggested
/// frequency, if the scene is met there. Otherwise the report.
pub fn next_step(args: &Args, weights: &Weights, band_hz: [f64; 2]) -> Option<String> {
    let [model, scene] = [&args.model, &args.scene].map(|path| shell_path(path));
    let again = format!("chladni render {model} {scene}");
    let drive_hz = weights.frequency_hz;
    // another frequency does not help against errors of the gains
    let is_sensitive = weights
        .findings
        .iter()
        .any(|finding| finding.code == "rig-sensitive" && !is_of_gains(finding));
    match (&weights.sweep, is_sensitive || !weights.feasible) {
        (Some(sweep), true) => {
            let better = sweep.suggestion().filter(|better| better.is_met());
            let hz = better.map(|better| better.frequency_hz);
            Some(format!(
                "set frequency_hz = {} in {scene}, then {again}",
                significant(hz.filter(|hz| *hz != drive_hz)?, 6)
            ))
        }
        // a sweep suggests one frequency, for scenes of one tone
        (None, true) if weights.other_tones.is_empty() => {
            let [low, high] = around(drive_hz, band_hz)?.map(|hz| significant(hz, 6));
            Some(format!("{again} --sweep {low}:{high}"))
        }
        _ => {
            let output = args.output.as_deref().map(shell_path)?;
            Some(report(&[model, output]))
        }
    }
}

/// Range of a sweep around the drive frequency, Hz: the part inside the fitted band `[low,
/// high]`, where the model has one. `None` where the band does not reach it.
fn around(drive_hz: f64, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
    let [from, to] = [(drive_hz - SWEEP_HZ).max(1.0), drive_hz + SWEEP_HZ];
    if low >= high {
        return Some([from, to]);
    }
    let [from, to] = [from.max(low), to.min(high)];
    (from < to).then_some([from, to])
}
