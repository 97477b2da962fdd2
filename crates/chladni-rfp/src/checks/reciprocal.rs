//! A reference whose gain, wiring or place is wrong, where reciprocity shows it. Poles are not
//! affected; shapes that take their mass scale from a driving point are.

use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::validation::reciprocity::reciprocity;
use crate::validation::reciprocity::ReciprocalPair;
use chladni_frf::Finding;

/// Compares every pair of FRFs that reciprocity makes equal.
pub(crate) fn not_reciprocal(case: &Case) -> Option<Checked> {
    let pairs = reciprocity(case.values?.frf, case.data.band_hz);
    let lines = case.data.lines.len() as f64;
    let noise = case.model.quality.relative_error;
    // neighbouring lines of a resonance carry one piece of evidence together
    let deviation =
        |pair: &ReciprocalPair| pair.misfit / (lines / limits::LINES_TOGETHER).max(1.0).sqrt();
    let gain_error = |pair: &ReciprocalPair| (pair.gain - 1.0).norm();
    let wrong = |pair: &&ReciprocalPair| {
        pair.misfit > limits::UNLIKE + limits::UNLIKE_ERRORS * noise
            || (pair.misfit < limits::UNLIKE
                && gain_error(pair) > limits::GAIN.max(limits::RECIPROCAL_SIGMAS * deviation(pair)))
    };
    let found: Vec<&ReciprocalPair> = pairs.iter().filter(wrong).collect();
    let worst = *found
        .iter()
        .max_by(|a, b| (gain_error(a) + a.misfit).total_cmp(&(gain_error(b) + b.misfit)))?;
    let [a, b] = worst.dofs;
    let what = if worst.misfit > limits::UNLIKE {
        format!(
            "differ by {:.0} % whatever the factor between them: sensors do not sit where the \
                 drivers do",
            100.0 * worst.misfit
        )
    } else {
        format!(
            "differ by a factor {:.3} ({:+.2} dB, {:+.1}°): a gain or delay of one reference",
            worst.gain.norm(),
            20.0 * worst.gain.norm().log10(),
            worst.gain.arg().to_degrees()
        )
    };
    let words = format!(
        "not reciprocal: {} of {} pairs of FRFs; H({a} from {b}) and H({b} from {a}) {what}; \
         mass-scaled shapes are affected, poles are not",
        found.len(),
        pairs.len()
    );
    let finding = Finding::caution("not-reciprocal", words)
        .dofs([a, b])
        .help("check the calibration and the place of sensors and drivers");
    Some(finding.into())
}
