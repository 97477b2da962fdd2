//! Warnings of all parts, each with what it is about: first of all in the page.

use crate::input::ReportInput;
use crate::text::{counted, fixed};
use chladni_frf::Trust;

/// Pairs of what it is about, and the warning.
pub(crate) fn all(input: &ReportInput) -> Vec<[String; 2]> {
    let about = |what: &str, text: &str| [what.to_owned(), text.to_owned()];
    let mut warnings: Vec<[String; 2]> = input
        .findings
        .iter()
        .map(|finding| about("Report", &finding.to_string()))
        .collect();
    if let Some(model) = input.model {
        if !model.quality.trusted {
            warnings.push(about(
                "Model",
                "this model is not to be trusted; the reasons follow",
            ));
        }
        warnings.extend(
            model
                .quality
                .findings
                .iter()
                .map(|finding| about("Model", &finding.to_string())),
        );
        let weak = model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Weak)
            .count();
        if weak > 0 {
            warnings.push(about(
                "Model",
                &format!(
                    "{} kept with doubts; the pole table says why",
                    counted(weak, "mode")
                ),
            ));
        }
    }
    for (k, scene) in input.scenes.iter().enumerate() {
        let of = format!("Scene {}", k + 1);
        if !scene.weights.feasible {
            let ratio = fixed(100.0 * scene.weights.indices.points.min_ratio, 1);
            warnings.push(about(
                &of,
                &format!("not met: the worse zone keeps its limit at {ratio} % of its responses"),
            ));
        }
        let shown = scene.shown.map_or(&[][..], |shown| shown.findings);
        warnings.extend(
            scene
                .weights
                .findings
                .iter()
                .chain(shown)
                .map(|finding| about(&of, &finding.to_string())),
        );
    }
    warnings
}
