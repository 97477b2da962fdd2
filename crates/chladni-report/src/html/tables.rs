//! Tables of the page: the model's facts, the poles, the indices.

use crate::input::RenderedScene;
use crate::sizes::SIGMAS;
use crate::text::{counted, escape, fixed, plain, significant, with_bound};
use chladni_frf::{Damping, ModalModel, Mode, Scaling, Trust};
use chladni_render::PointIndices;
use chladni_rfp::{mean_phase_deviation_deg, modal_complexity_factor};

/// Pairs of a word and what belongs to it; the second parts are HTML.
fn facts(rows: &[(&str, String)]) -> String {
    let rows: String = rows.iter().map(|(word, text)| format!("<dt>{word}</dt><dd>{text}</dd>\n")).collect();
    format!("<dl>\n{rows}</dl>")
}

/// What the model is and how well it explains its data.
pub(crate) fn model_facts(model: &ModalModel) -> String {
    let (sure, weak) = (count(model, Trust::Sure), count(model, Trust::Weak));
    let outside = model.modes.iter().filter(|mode| !mode.in_band && mode.trust != Trust::Rejected).count();
    let mut modes = counted(sure + weak, "mode");
    if weak > 0 {
        modes += &format!(" ({sure} sure, {weak} weak)");
    }
    if outside > 0 {
        modes += &format!(", and {} outside the band", counted(outside, "pole"));
    }
    let sources: Vec<String> = model
        .source
        .iter()
        .map(|source| format!("{} <span class=\"hash\">SHA-256 {}</span>", escape(&source.file), escape(&source.sha256)))
        .collect();
    let damping = match model.damping {
        Damping::Structural => "structural (hysteretic): loss factor η",
        Damping::Viscous => "viscous: η = 2ζ",
    };
    let scaling = match model.scaling {
        Scaling::UnitModalMass => "unit modal mass",
        Scaling::Unscaled => "unscaled (no driving point): shapes have largest motion 1, participations carry the rest",
    };
    let path = model.quality.path.as_ref().map(|path| format!("; {}", escape(path))).unwrap_or_default();
    facts(&[
        ("Source", if sources.is_empty() { "not recorded".into() } else { sources.join("<br>") }),
        (
            "FRFs",
            format!(
                "{} in {}, {} × {}",
                model.frf_kind,
                model.frf_kind.unit(model.reference_unit).replace("^2", "²"),
                counted(model.responses.len(), "response"),
                counted(model.references.len(), "reference")
            ),
        ),
        ("Fitted band", format!("{} to {} Hz", plain(model.band_hz[0]), plain(model.band_hz[1]))),
        ("Method", format!("{}{path}", escape(&model.method))),
        ("Found", modes),
        ("Damping", damping.into()),
        ("Scaling", scaling.into()),
        (
            "Misfit",
            format!(
                "{} % of the data's rms; χ² per degree of freedom {}",
                significant(100.0 * model.quality.relative_error, 3),
                significant(model.quality.chi2_per_dof, 4)
            ),
        ),
        ("Trust", if model.quality.trusted { "trusted" } else { "<strong>not trusted</strong>, see the warnings" }.into()),
    ])
}

fn count(model: &ModalModel, trust: Trust) -> usize {
    model.in_band_modes().filter(|mode| mode.trust == trust).count()
}

/// Poles in the band, numbered; below them those outside the band, and rejected candidates.
pub(crate) fn pole_table(model: &ModalModel) -> String {
    let inside: Vec<&Mode> = model.in_band_modes().collect();
    let outside: Vec<&Mode> = model.modes.iter().filter(|mode| !mode.in_band && mode.trust != Trust::Rejected).collect();
    let rejected: Vec<&Mode> = model.modes.iter().filter(|mode| mode.trust == Trust::Rejected).collect();
    let mut out = String::from(
        "<p>Natural frequencies are undamped (|s|/2π). Bounds are 95 % (1.96 standard deviations). \
        A real shape has the modal phase collinearity MPC 1, mean phase deviation MPD 0° and modal complexity factor MCF 0.",
    );
    if model.modes.iter().all(|mode| mode.frequency_std_hz == 0.0) {
        out += " This model carries no bounds.";
    }
    out += "</p>\n";
    out += &if inside.is_empty() { "<p>No mode in the band.</p>".into() } else { table(&inside, true) };
    for (title, modes) in [("Poles outside the band, which stand for the world beyond it", outside), ("Rejected candidates", rejected)] {
        if !modes.is_empty() {
            out += &format!("\n<details><summary>{title}: {}</summary>{}</details>", modes.len(), table(&modes, false));
        }
    }
    out
}

fn table(modes: &[&Mode], numbered: bool) -> String {
    let head = "<th class=\"number\">Mode</th><th class=\"number\">Natural frequency (Hz)</th><th class=\"number\">Loss factor η (%)</th>\
                <th class=\"number\">Damping ratio ζ (%)</th><th class=\"number\">MPC (0 to 1)</th>\
                <th class=\"number\">MPD (°)</th><th class=\"number\">MCF (0 to 1)</th><th>Trust</th>";
    let rows: String =
        modes.iter().enumerate().map(|(k, mode)| row(mode, if numbered { (k + 1).to_string() } else { "–".into() })).collect();
    format!("<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>")
}

fn row(mode: &Mode, number: String) -> String {
    let frequency = with_bound(mode.frequency_hz, SIGMAS * mode.frequency_std_hz);
    let loss = with_bound(100.0 * mode.loss_factor, SIGMAS * 100.0 * mode.loss_factor_std);
    let damping = with_bound(100.0 * mode.damping_ratio, SIGMAS * 50.0 * mode.loss_factor_std);
    let (class, word) = match mode.trust {
        Trust::Sure => ("sure", "✓ sure"),
        Trust::Weak => ("weak", "? weak"),
        Trust::Rejected => ("rejected", "× rejected"),
    };
    let reasons = if mode.reasons.is_empty() { String::new() } else { format!(": {}", escape(&mode.reasons.join("; "))) };
    let [mpd, mcf] = [mean_phase_deviation_deg(&mode.shape.0), modal_complexity_factor(&mode.shape.0)];
    let numbers: String = [number, frequency, loss, damping, fixed(mode.mpc, 3), fixed(mpd, 1), fixed(mcf, 3)]
        .iter()
        .map(|text| format!("<td class=\"number\">{text}</td>"))
        .collect();
    format!("<tr>{numbers}<td><span class=\"{class}\">{word}</span>{reasons}</td></tr>\n")
}

/// What was asked of a scene and by which means.
pub(crate) fn scene_facts(scene: &RenderedScene) -> String {
    let weights = scene.weights;
    let sources: Vec<String> = weights.source.iter().map(|source| escape(&source.file)).collect();
    let verdict = if weights.feasible {
        "met: every judged response keeps its limit in the model".to_owned()
    } else {
        "<strong>not met</strong> in the model: some judged response misses its limit".to_owned()
    };
    let mut rows = vec![
        ("Drive frequency", format!("{} Hz", plain(weights.frequency_hz))),
        ("Method", escape(&weights.method)),
        ("Scene", verdict),
        ("Used", format!("{}, {}", counted(weights.modes_used, "mode"), counted(weights.actuators_used, "actuator"))),
    ];
    if let Some(kappa) = weights.kappa {
        let words = match kappa >= 0.0 {
            true => format!("limits are kept under model errors of {} standard deviations (κ)", fixed(kappa, 2)),
            false => format!("none: some limit is missed even without model errors (κ = {})", fixed(kappa, 2)),
        };
        rows.push(("Robustness", words));
    }
    if !sources.is_empty() {
        rows.push(("Made from", sources.join(", ")));
    }
    facts(&rows)
}

/// The indices beside what silence would score.
pub(crate) fn index_table(scene: &RenderedScene) -> String {
    let indices = scene.shown.as_ref().map_or(&scene.weights.indices, |shown| shown.indices);
    let (points, area) = (&indices.points, &indices.area);
    let on = scene.shown.as_ref().map_or("the model", |shown| shown.on);
    let share = |value: f64| format!("{} %", fixed(100.0 * value, 1));
    let maybe = |value: Option<f64>| value.map_or("–".into(), share);
    let row = |name: &str, cells: [String; 3]| {
        let cells: String = cells.iter().map(|cell| format!("<td class=\"number\">{cell}</td>")).collect();
        format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>\n")
    };
    let rows = [
        row("Hot ground that is felt", [share(points.hot_ratio), maybe(area.and_then(|area| area.hot_ratio)), share(0.0)]),
        row("Cold ground that is quiet", [share(points.cold_ratio), maybe(area.and_then(|area| area.cold_ratio)), share(1.0)]),
        row("The smaller of the two", [share(points.min_ratio), maybe(smaller(area)), share(0.0)]),
        row("Hot and cold together", [share(points.success_ratio), "–".into(), share(points.silence_ratio)]),
    ]
    .concat();
    format!(
        "<div class=\"scroll\"><table class=\"indices\">\n<thead><tr><th>Share that keeps its limit ({})</th><th class=\"number\">At the responses</th>\
         <th class=\"number\">Over the area</th><th class=\"number\">Silence would score</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n{}",
        escape(on),
        levels(points)
    )
}

fn smaller(area: &Option<chladni_render::AreaIndices>) -> Option<f64> {
    let area = area.as_ref()?;
    Some(area.hot_ratio?.min(area.cold_ratio?))
}

fn levels(points: &PointIndices) -> String {
    let db = |value: Option<f64>| value.map_or("–".into(), |value| format!("{} dB", fixed(value, 1)));
    let mut rows = vec![
        ("Contrast", format!("{} between the stillest hot and the liveliest cold response", db(points.contrast_db))),
        (
            "Margin",
            format!(
                "{} from the nearest limit{}",
                db(points.margin_db),
                match points.margin_db {
                    Some(margin) if margin < 0.0 => " (negative: some response misses it)",
                    _ => "",
                }
            ),
        ),
    ];
    if let Some(force) = points.max_force_n {
        rows.push(("Largest force", format!("{} mN peak", significant(1e3 * force, 3))));
    }
    if let Some(voltage) = points.max_voltage_v {
        rows.push(("Largest voltage", format!("{} V peak", significant(voltage, 3))));
    }
    facts(&rows)
}
