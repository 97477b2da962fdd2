//! Damping that a window of the test may have raised, where nobody said which it was.

use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::checks::line_shape::{likely_window, DECIDES};
use crate::data::options::Window;
use chladni_frf::{Finding, Mode};
use std::f64::consts::PI;

/// Where nobody said which window was used: how much too high damping can be.
pub(crate) fn possible_bias(case: &Case) -> Option<Checked> {
    if case.options.window.is_some() || case.white {
        return None;
    }
    let step = case.data.line_spacing_hz();
    let bias = |mode: &Mode| step / (PI * mode.loss_factor * mode.frequency_hz);
    // ... where the error bar does not cover them anyway
    let open =
        |mode: &&Mode| bias(mode) > limits::BIAS.max(2.0 * mode.loss_factor_std / mode.loss_factor);
    let concerned: Vec<&Mode> = case.sure_modes().into_iter().filter(open).collect();
    let worst = *concerned
        .iter()
        .max_by(|a, b| bias(a).total_cmp(&bias(b)))?;
    let evidence = match likely_window(case) {
        Some((Window::None, gain, _)) if gain > DECIDES => return None,
        Some((window, gain, modes)) if gain > DECIDES => {
            format!(
                "the line shapes of {modes} mode(s) are those of a {window} window (likelihood \
                     e^{gain:.0} times that of any other)"
            )
        }
        _ => "the line shapes do not tell".into(),
    };
    let words = format!(
        "error bars assume no window bias: if these FRFs were averaged from windowed records of \
         random excitation, the loss factors of {} mode(s) are too high by up to 1/(πb) ({:.0} % \
         at {:.2} Hz, b = {:.1} lines per bandwidth); {evidence}",
        concerned.len(),
        100.0 * bias(worst),
        worst.frequency_hz,
        1.0 / (PI * bias(worst))
    );
    let finding = Finding::note("window-bias", words)
        .modes_hz(concerned.iter().map(|mode| mode.frequency_hz))
        .value("bias_relative", bias(worst))
        .help("say which window was used, or that there was none");
    Some(finding.into())
}
