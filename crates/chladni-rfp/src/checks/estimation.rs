//! FRFs whose estimation does not suit the course of their force, as the set itself says.

use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use chladni_frf::{Finding, Mode, Reason};

/// Blows under a Hann window: it weighs a response by sin²(πt/T), so each mode has lines of the
/// width of its own at 1/T to both sides.
pub(crate) fn of_blows(case: &Case) -> Option<Checked> {
    let reach_hz = limits::BESIDE_LINES / case.data.hann_on_blows_s?;
    let modes = || {
        let all = case.model.modes.iter().enumerate();
        all.filter(|(_, mode)| mode.counts())
    };
    let reason = Reason::new(
        "windowed-side-lobe",
        "the window sets lines at this distance beside every mode",
    );
    let beside = |(n, mode): &(usize, &Mode)| {
        let near = |other: &Mode| (other.frequency_hz - mode.frequency_hz).abs() < reach_hz;
        let told = |known: &Reason| known.code == reason.code;
        !mode.reasons.iter().any(told) && modes().any(|(m, other)| m != *n && near(other))
    };
    let weak = modes()
        .filter(beside)
        .map(|(n, _)| (n, reason.clone()))
        .collect();
    let words = "the FRFs were made of blows under a Hann window, which broadens every line and sets \
                 others beside it: loss factors are upper bounds, and poles a line or two apart may \
                 be one mode";
    let finding = Finding::caution("windowed", words)
        .modes_hz(case.model.in_band_modes().map(|mode| mode.frequency_hz))
        .help("estimate the FRFs again without that window, one record for each blow");
    Some(Checked { finding, weak })
}

/// Local fits to a force of which neighbouring lines are alike, or most carry nothing: leakage and
/// response cannot be told apart, and the variance of the lines does not hold it.
pub(crate) fn of_local_fits(case: &Case) -> Option<Checked> {
    if !case.data.local_on_smooth_force {
        return None;
    }
    let reason = Reason::new(
        "local-on-smooth-force",
        "local fits cannot tell its leakage from its response under this force",
    );
    let modes = case.model.modes.iter().enumerate();
    let weak = modes
        .filter(|(_, mode)| mode.counts())
        .map(|(n, _)| (n, reason.clone()))
        .collect();
    let words = "the FRFs were made by local fits, and the force was no noise through the whole \
                 record: what they take for the response holds leakage, and error bars do not \
                 hold that";
    let finding = Finding::caution("local-on-smooth-force", words).help(
        "estimate the FRFs again by `estimator h1`, one record for each blow, sweep or period",
    );
    Some(Checked { finding, weak })
}
