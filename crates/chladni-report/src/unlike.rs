//! Measured FRFs that a model does not explain.

use crate::comparison::Comparison;
use crate::input::ReportInput;
use crate::sizes::{UNEXPLAINED, WORSE_THAN_FIT};
use chladni_frf::{Finding, FrfSet, ModalModel, Result};

/// The finding on FRFs of another structure, or of a structure that has changed: `model` leaves
/// most of them unexplained, and far more than of its own FRFs. `None` where it explains them, and
/// where no line lies in its band.
///
/// # Errors
/// Those of [`crate::html`].
pub fn unlike(model: &ModalModel, measured: &FrfSet) -> Result<Option<Finding>> {
    let input = ReportInput {
        model: Some(model),
        measured: Some(measured),
        ..ReportInput::default()
    };
    let left = Comparison::new(&input)?.and_then(|comparison| comparison.left_in_band());
    let of_fit = model.quality.relative_error;
    let most = UNEXPLAINED.max(WORSE_THAN_FIT * of_fit);
    let finding = |left: f64| {
        let words = format!(
            "the model leaves {:.0} % of these FRFs, and {:.1} % of those that it was fitted to: \
             they are of another structure, or it has changed",
            100.0 * left,
            100.0 * of_fit
        );
        Finding::caution("measured-unlike", words)
            .value("relative_error", left)
            .help("name the FRFs that the model was fitted to, or fit these")
    };
    Ok(left.filter(|left| *left > most).map(finding))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_plate::Synthetic;

    #[test]
    fn frfs_of_another_structure_are_told_from_those_of_the_model() {
        let panel = |hz: [f64; 2]| {
            let synthetic = Synthetic {
                natural_frequency_hz: hz.to_vec(),
                ..Synthetic::default()
            };
            synthetic.build().unwrap()
        };
        let [one, other] = [[60.0, 120.0], [75.0, 150.0]].map(panel);
        assert_eq!(unlike(&one.truth, &one.frf).unwrap(), None);
        let finding = unlike(&one.truth, &other.frf).unwrap().unwrap();
        assert_eq!(finding.code, "measured-unlike");
    }
}
