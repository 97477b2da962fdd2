//! Bias of damping by the window of the records: its bounds if the window is not known, the
//! evidence against the window if it is.

use crate::checks::around::window_pairs;
use crate::checks::case::{Case, Checked};
use crate::checks::correlation::{Correlation, TAPERED};
use crate::checks::limits;
use crate::checks::limits::DECIDES;
use crate::checks::line_shape::{resonances_over, LineShapes, CUT_BURST};
use crate::checks::witness::{decades, witness, Witness};
use crate::data::layout::DataLayout;
use crate::data::window::kinds::Window;
use crate::data::window::leakage::Leakage;
use crate::model::modes::widen_scale;
use chladni_frf::{counted, Finding, ModalModel, Mode, Scaling};
use std::f64::consts::PI;

/// The check where the window is known: its effect is in the columns, as long as the
/// force is white.
pub(crate) fn modelled(case: &Case) -> Option<Checked> {
    let window = case.data.window?;
    let leakage = case.data.leakage.as_deref()?;
    let broadened = |mode: &Mode| {
        let decay = PI * mode.loss_factor * mode.frequency_hz / case.data.omega_max;
        leakage.broadening(decay)
    };
    let worst = case
        .model
        .in_band_modes()
        .map(broadened)
        .fold(0.0, f64::max);
    let words = match window {
        Window::Transient => "responses are cut at the end of their records, and the fit has the \
                              line shape of that"
            .to_owned(),
        _ => format!(
            "the fit has the line shape of records under a {window} window: the loss factors are \
             those of the structure, up to {:.0} % below those of the broadened lines",
            100.0 * worst / (1.0 + worst)
        ),
    };
    let finding = Finding::note("window-modelled", words)
        .value("bias_relative", worst)
        .help("window none shows the broadened lines");
    Some(finding.into())
}

/// True if the lines of isolated modes look like pure resonances rather than lines under the
/// known window. False if an exponential window moved the poles or records were padded: their
/// lines have another shape.
pub(crate) fn lines_look_unwindowed(case: &Case) -> bool {
    let told = case.data.window.filter(|window| *window != Window::None);
    let as_measured = case.options.exponential_window_per_s.is_none() && !case.data.is_padded();
    let gain = told
        .filter(|_| as_measured)
        .and_then(|window| resonances_over(case, window));
    gain.is_some_and(|gain| gain > DECIDES)
}

/// The finding that the data contradict the known window: a fit of pure resonances leaves far
/// less. `models`: under the window and without it. `None` if it does not.
pub(crate) fn known_window_contradicted(
    window: Window,
    models: [&ModalModel; 2],
) -> Option<Finding> {
    let [under, plain] = models.map(|model| model.quality.relative_error);
    let less = (under / plain.max(f64::MIN_POSITIVE)).powi(2);
    let words = format!(
        "the data contradict the {window} window that the file or you name: a fit of pure \
         resonances leaves {:.2} % of the FRFs unexplained, the fit under the window {:.2} %; its \
         loss factors are wrong, mostly too low",
        100.0 * plain,
        100.0 * under
    );
    (less > limits::CONTRADICTS).then(|| {
        Finding::fault("window-contradicted", words)
            .value("relative_error", under)
            .value("relative_error_without", plain)
            .help("say that there was no window, or which other one")
    })
}

/// The check where the window is not known: how much too high damping can be.
pub(crate) fn possible_bias(case: &Case) -> Option<Checked> {
    if case.data.window.is_some() || case.noise_is_known {
        return None;
    }
    let step = case.data.line_spacing_hz();
    let found = Evidence::new(case);
    let Evidence { shapes, errors } = &found;
    let window = found.suspected();
    // only where error bars do not hold them anyway
    let leakage = leakage_of(window, case.data)?;
    let open = |mode: &&Mode| {
        doubt(&leakage, mode) > limits::BIAS.max(mode.loss_factor_std / mode.loss_factor)
    };
    let sure = case.sure_modes();
    let asked = match sure.is_empty() {
        true => case.model.in_band_modes().collect(),
        false => sure,
    };
    let concerned: Vec<&Mode> = asked.into_iter().filter(open).collect();
    let worst = *concerned
        .iter()
        .max_by(|a, b| first_order(step, a).total_cmp(&first_order(step, b)))?;
    let (bias, rule) = match window {
        Window::Hann => (first_order(step, worst), "1/(πb) "),
        _ => (excess(&leakage, worst), ""),
    };
    let of_shapes = shapes.as_ref().and_then(LineShapes::decided);
    let evidence = match (of_shapes, shapes) {
        (Some((Window::None, _)), _) => return None,
        (Some((window, gain)), Some(shapes)) => format!(
            "the line shapes of {} are those of a {window} window (likelihood e^{gain:.0} \
             times that of any other)",
            counted(shapes.modes, "mode")
        ),
        _ => "the line shapes do not tell".into(),
    };
    let evidence = match errors.filter(Witness::decides) {
        Some(found) => format!(
            "{evidence}; the errors of neighbouring lines are those of FRFs {} (10^{:.0} times as \
             likely as any other)",
            found.likeliest,
            decades(found.gain)
        ),
        None => evidence,
    };
    let words = format!(
        "the error bars hold what a {window} window may have added: if these FRFs were averaged \
         from windowed records of random excitation, the loss factors of {} mode(s) are too high \
         by up to {rule}({:.0} % at {:.2} Hz, b = {:.1} lines per bandwidth); {evidence}",
        concerned.len(),
        100.0 * bias,
        worst.frequency_hz,
        1.0 / (PI * first_order(step, worst))
    );
    let finding = Finding::note("window-bias", words)
        .modes_hz(concerned.iter().map(|mode| mode.frequency_hz))
        .value("bias_relative", bias);
    let finding = match case.data.unlike_h1 {
        true => finding.help(
            "estimate H1, or by a local method: H2 and Hv of records that leak have a line shape \
             that the fit does not know",
        ),
        false => finding.help("say which window was used, or that there was none"),
    };
    Some(finding.into())
}

/// Evidence of the window in the data.
pub(crate) struct Evidence {
    shapes: Option<LineShapes>,
    errors: Option<Witness>,
}

impl Evidence {
    /// Of a fit without a window.
    pub fn new(case: &Case) -> Self {
        Self {
            shapes: LineShapes::new(case),
            errors: witness(case),
        }
    }

    /// The window of most effect that neither line shapes nor the errors of neighbouring lines
    /// exclude; a Hann window, the usual one, where these tell none.
    pub fn suspected(&self) -> Window {
        let (shapes, errors) = (self.shapes.as_ref(), self.errors.as_ref());
        let tapered = shapes.is_some_and(|found| found.tapered_gain() > DECIDES);
        let of_errors = errors.map_or([false; TAPERED.len()], |found| found.open);
        let of_shapes = shapes.map_or([false; TAPERED.len()], LineShapes::open);
        let most = |holds: &dyn Fn(usize) -> bool| (0..TAPERED.len()).rev().find(|&w| holds(w));
        // errors hardly tell one window from the next wider one
        let by_errors = |w: usize| of_errors[w] || (w > 0 && of_errors[w - 1]);
        let place = match (of_errors.contains(&true), tapered) {
            (true, _) => most(&|w| by_errors(w) && of_shapes[w])
                // one of them is mistaken
                .or_else(|| most(&|w| of_errors[w] || of_shapes[w])),
            (false, true) => most(&|w| of_shapes[w]),
            (false, false) => None,
        };
        place.map_or(Window::Hann, |place| TAPERED[place])
    }
}

/// Widens the bars of damping by what `window` would have added to it, and the bars of mass
/// scales with them. Bars of frequencies are widened if two poles may be one broadened line.
pub(crate) fn widen_bars_for(model: &mut ModalModel, data: &DataLayout, window: Window) {
    let Some(leakage) = leakage_of(window, data) else {
        return;
    };
    let scaling = model.scaling;
    let splits: Vec<Option<f64>> = model
        .modes
        .iter()
        .map(|m| split_hz(model, data, m))
        .collect();
    for (mode, split) in model
        .modes
        .iter_mut()
        .zip(splits)
        .filter(|(mode, _)| mode.counts())
    {
        let doubt = excess(&leakage, mode);
        widen(mode, scaling, doubt, limits::SCALE_OF_DAMPING * doubt);
        let between = 0.5 * split.unwrap_or(0.0);
        mode.frequency_std_hz = mode.frequency_std_hz.hypot(between);
    }
}

/// Distance, Hz, of the next of the poles that a window may have made of one mode.
fn split_hz(model: &ModalModel, data: &DataLayout, mode: &Mode) -> Option<f64> {
    let distance = |other: &Mode| (other.frequency_hz - mode.frequency_hz).abs();
    let pairs = window_pairs(model, data.line_spacing_hz(), mode);
    pairs.into_iter().map(distance).min_by(f64::total_cmp)
}

/// Widens the bars of a mode by relative doubts of its loss factor and of its mass scale.
fn widen(mode: &mut Mode, scaling: Scaling, of_loss: f64, of_scale: f64) {
    mode.loss_factor_std = mode.loss_factor_std.hypot(of_loss * mode.loss_factor);
    if scaling != Scaling::UnitModalMass {
        return;
    }
    widen_scale(mode, |std, size| std.hypot(of_scale * size));
}

/// Effect of a window on records whose length is the inverse of the line spacing; decays are in
/// 1/s.
fn leakage_of(window: Window, data: &DataLayout) -> Option<Leakage> {
    let record_s = 1.0 / data.line_spacing_hz();
    Some(Leakage::new(window.kernel()?, record_s, 0))
}

/// Part of a loss factor that a window would have added.
fn doubt(leakage: &Leakage, mode: &Mode) -> f64 {
    added(leakage, PI * mode.loss_factor * mode.frequency_hz)
}

/// The same relative to the loss factor that would be left: lines of equal height tell too
/// little of how far a window spreads broad ones.
fn excess(leakage: &Leakage, mode: &Mode) -> f64 {
    of_what_is_left(doubt(leakage, mode))
}

/// A part of a whole over the rest of it. Lines narrower than those of the window alone leave
/// none, so the part has a bound.
fn of_what_is_left(part: f64) -> f64 {
    let part = part.min(limits::DOUBT_MOST);
    part / (1.0 - part)
}

/// Part of the decay `seen`, 1/s, that a window added.
fn added(leakage: &Leakage, seen: f64) -> f64 {
    match seen > 0.0 {
        true => 1.0 - leakage.unbroadened(seen) / seen,
        false => 0.0,
    }
}

/// True if an unknown window may bias damping.
pub(crate) fn damping_may_be_biased(model: &ModalModel) -> bool {
    let mut findings = model.quality.findings.iter();
    findings.any(|finding| finding.code == "window-bias")
}

/// Relative excess of damping under a Hann window, to first order: 1/(πb).
fn first_order(step_hz: f64, mode: &Mode) -> f64 {
    step_hz / (PI * mode.loss_factor * mode.frequency_hz)
}

/// A window that was found.
pub(crate) struct FoundWindow {
    pub window: Window,
    /// Windows that may have been it as well.
    others: Vec<Window>,
    pub finding: Finding,
}

impl FoundWindow {
    /// Widens the bars of modes by what damping would change under the other windows.
    pub fn widen_bars_for_other_windows(&self, model: &mut ModalModel, data: &DataLayout) {
        let Some(own) = leakage_of(self.window, data) else {
            return;
        };
        let others = self.others.iter().filter_map(|w| leakage_of(*w, data));
        let others: Vec<Leakage> = others.collect();
        let scaling = model.scaling;
        for mode in model.modes.iter_mut().filter(|mode| mode.counts()) {
            let decay = PI * mode.loss_factor * mode.frequency_hz;
            let seen = decay * (1.0 + own.broadening(decay));
            let off = |other: &Leakage| (other.unbroadened(seen) / decay - 1.0).abs();
            let most = others.iter().map(off).fold(0.0, f64::max);
            widen(mode, scaling, most, limits::SCALE_OF_DAMPING * most);
        }
    }
}

/// The window that line shapes clearly show, if it is worth a new fit and the errors of
/// neighbouring lines do not contradict it.
pub(crate) fn window_by_line_shapes(case: &Case, found: &Evidence) -> Option<Window> {
    let shapes = found.shapes.as_ref()?;
    let window = shapes.likeliest();
    let leakage = leakage_of(window, case.data)?;
    // its broadening exceeds the error bars, or it may have split a mode
    let clear = |mode: &&Mode| {
        let bar = 2.0 * mode.loss_factor_std / mode.loss_factor;
        let doubt = doubt(&leakage, mode);
        let split = || split_hz(case.model, case.data, mode).is_some();
        doubt > limits::BIAS_UNDONE && (doubt > bar || split())
    };
    let against = |errors: &Witness| errors.decides() && !of_continuous(errors);
    let worth = case.model.in_band_modes().any(|mode| clear(&mode));
    let decisive = worth && shapes.tapered_gain() >= DECIDES;
    (decisive && !found.errors.as_ref().is_some_and(against)).then_some(window)
}

/// True if errors are those of windowed records under a continuous force: FRFs share them, they
/// are correlated as by a window that falls off to both ends, and one such window at least is
/// possible.
fn of_continuous(errors: &Witness) -> bool {
    let open = errors.open.contains(&true);
    errors.leakage && open && errors.likeliest == Correlation::Tapered
}

/// The window that line shapes and the errors of neighbouring lines both show clearly, under a
/// force that leakage shows to be continuous. Weaker evidence corrects nothing. The errors that
/// the fit `under` the window leaves are asked if those of the first fit say too little.
pub(crate) fn confirmed_window(found: &Evidence, under: &Case) -> Option<FoundWindow> {
    let shapes = found.shapes.as_ref()?;
    let (window, gain) = (shapes.likeliest(), shapes.tapered_gain());
    let says = |errors: &Witness| of_continuous(errors) && errors.gain >= DECIDES;
    let errors = found.errors.filter(says);
    let errors = errors.or_else(|| witness(under).filter(says))?;
    let open = TAPERED.into_iter().zip(shapes.open());
    let others = open.filter_map(|(other, open)| (open && other != window).then_some(other));
    let burst = shapes.may_be_burst().then_some(CUT_BURST);
    let others: Vec<Window> = others.chain(burst).collect();
    let name = |window: &Window| match window.part() {
        Some(part) => format!("bursts over {:.0} % of each record", 100.0 * part),
        None => format!("a {window} window"),
    };
    let names: Vec<String> = others.iter().map(name).collect();
    let left_open = match names.is_empty() {
        true => String::new(),
        false => format!(
            "; the error bars hold what {} would make of damping, which is possible, too",
            names.join(" or ")
        ),
    };
    let words = format!(
        "the FRFs were made of records under a {window} window, so the fit has its line shape: the \
         line shapes of {} mode(s) and the errors of neighbouring lines both say so (10^{:.0} and \
         10^{:.0} times as likely as those of none){left_open}",
        shapes.modes,
        decades(gain),
        decades(errors.gain)
    );
    let finding = Finding::caution("window-found", words)
        .value("line_shape_nats", gain)
        .value("error_correlation_nats", errors.gain)
        .help("say which window was used, or that there was none");
    Some(FoundWindow {
        window,
        others,
        finding,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_narrower_than_those_of_a_window_have_bars_of_their_size() {
        let leakage = Leakage::new(Window::Flattop.kernel().unwrap(), 1.0, 0);
        for lines in [0.0, 0.1, 0.5, 2.0] {
            let excess = of_what_is_left(added(&leakage, PI * lines));
            assert!((0.0..=2.1).contains(&excess), "{lines}: {excess}");
        }
    }

    #[test]
    fn bars_hold_what_windows_added_in_simulated_tests() {
        // mean excess of plain fits, `chladni bench measured` (docs/accuracy.md): window,
        // lines per bandwidth
        for (window, lines, excess) in [
            (Window::Hann, 2.0, 0.263),
            (Window::Flattop, 4.0, 0.364),
            (Window::Flattop, 8.0, 0.098),
        ] {
            let leakage = Leakage::new(window.kernel().unwrap(), 1.0, 0);
            let seen = PI * lines * (1.0 + excess);
            let expected = excess / (1.0 + excess);
            let found = added(&leakage, seen);
            // a bar of one standard deviation; broadening is that of a line of the same height
            assert!(
                (found - expected).abs() < 0.3 * expected,
                "{window}, {lines}: {found} for {expected}"
            );
        }
    }
}
