//! `chladni demo`: the whole way on the built-in panel, judged by its known truth.

mod files;
mod methods;
mod rig;

use self::files::Files;
use self::rig::OnRig;
use crate::curves::curves;
use crate::fit::fit_model;
use crate::limits::{LEAST_RATIO, SCENES};
use crate::render::{render_scene, write_weights, Trials};
use crate::truth::Comparison;
use chladni_console::input::source;
use chladni_console::output::{Output, FRF, HTML, MODEL, SCENE, WEIGHTS};
use chladni_console::quoting::shell_path;
use chladni_console::table::{significant, table};
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result};
use chladni_io::{write_contents, write_model, Contents};
use chladni_plate::{simulate, Panel};
use chladni_render::{evaluate, On, PointIndices, RenderOptions, Rendering, Scene};
use chladni_report::{html, sentence, Curves, RenderedScene, ReportInput};
use chladni_rfp::FitOptions;
use serde_json::{json, Value};
use std::path::PathBuf;
use std::time::Instant;

/// The trials of the first scene, as by `chladni render --stress
/// --sweep 310:350`.
const TRIALS: Trials = Trials {
    stress_seed: Some(1),
    sweep_hz: Some([310.0, 350.0]),
};

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni demo
  chladni demo -o /tmp/demo --force

Simulates the FRFs of a glass panel with 40 dB of noise and one driving point, fits them, renders four scenes at 330 Hz (one quarter of the
panel is felt, the rest is quiet), tries the first under stress and at other frequencies, fits once more by other methods
for a chart of speed against accuracy. Then an actuator of the first scene dies: the field is measured, the actuator named,
the weights corrected. Writes panel.h5, truth.json, model.json, scene-1..4.toml, weights-1..4.json, field-1.csv,
weights-1-corrected.json and report.html. Exit 1 where the known truth is missed or a scene is not met.")]
pub struct Args {
    /// Folder to write into
    #[arg(short, long, value_name = "DIR", default_value = "chladni-demo")]
    output: PathBuf,
}

/// A scene rendered with the fitted model, judged in that model and on the true panel.
struct Judged {
    rendering: Rendering,
    curves: Curves,
    on_panel: PointIndices,
}

/// Runs the command.
///
/// # Errors
/// Those of writing; anything else is a bug.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let files = Files::new(&args.output, console)?;
    // the panel of fixtures/panel.toml, with one driving point
    let mut panel = Panel::default();
    panel.responses.driving_point = true;
    let (frf, truth) = measure(&files, &panel, console)?;
    let (model, time_s) = identify(&files, &frf, console)?;
    let scenes: Vec<Judged> = (0..SCENES)
        .map(|k| render_one(&files, k, &model, &truth, console))
        .collect::<Result<_>>()?;
    let on_rig = rig::on_rig(
        &files,
        &model,
        &truth,
        &scenes[0].rendering.weights,
        console,
    )?;
    let methods =
        methods::speed_against_accuracy(&frf, &truth, panel.frf.snr_db, &model, time_s, console)?;
    console.stage("report");
    let page = html(&ReportInput {
        title: "Chladni demonstration".into(),
        model: Some(&model),
        measured: Some(&frf),
        scenes: scenes
            .iter()
            .map(|scene| {
                RenderedScene::of_rendering(&scene.rendering).with_curves(Some(&scene.curves))
            })
            .chain(on_rig.shown())
            .collect(),
        tables: vec![methods],
        ..ReportInput::default()
    })?;
    Output::new(&files.report, HTML, &[], console)?.write_bytes(page)?;

    let comparison = Comparison::new(&model, &truth);
    let doubts: Vec<String> = comparison
        .complaint()
        .into_iter()
        .chain(unmet(&scenes))
        .collect();
    let doubt = (!doubts.is_empty()).then(|| doubts.join("; "));
    let json = json(args, &files, &comparison, &scenes, &on_rig);
    let text = text(args, &model, &comparison, &scenes, &on_rig);
    let page = shell_path(&files.report);
    Ok(Outcome::written(&args.output, json, text)
        .doubted(doubt)
        .next(format!(
            "open {page} in a browser; or chladni studio {}",
            shell_path(&files.panel)
        )))
}

/// Simulates the measurement and writes it with its truth.
fn measure(files: &Files, panel: &Panel, console: &Console) -> Result<(FrfSet, ModalModel)> {
    console.stage("simulating the panel");
    let simulation = simulate(panel, None, None)?;
    console.find_all(&simulation.findings);
    console.stage("writing the FRFs");
    let contents = Contents {
        frf: Some(simulation.frf),
        ..Contents::default()
    };
    Output::new(&files.panel, FRF, &[], console)?
        .write(|path, force| write_contents(path, &contents, force))?;
    Output::new(&files.truth, MODEL, &[], console)?
        .write(|path, force| write_model(path, &simulation.truth, force))?;
    let frf = contents
        .frf
        .ok_or_else(|| Error::new(ErrorKind::Internal, "the simulated FRFs are gone"))?;
    Ok((frf, simulation.truth))
}

/// Fits the FRFs and writes the model, as `chladni fit panel.h5 -o model.json` does; the
/// model, and the seconds that the fit took.
fn identify(files: &Files, frf: &FrfSet, console: &Console) -> Result<(ModalModel, f64)> {
    let options = FitOptions::default();
    let sources = vec![source(&files.panel)?];
    let start = Instant::now();
    let model = fit_model(frf, &options, sources, &files.panel, console)?;
    let time_s = start.elapsed().as_secs_f64();
    console.find_all(&model.quality.findings);
    Output::new(&files.model, MODEL, &[], console)?
        .write(|path, force| write_model(path, &model, force))?;
    Ok((model, time_s))
}

/// Writes scene `k`, renders it with the fitted model, and judges the weights on the true
/// panel.
fn render_one(
    files: &Files,
    k: usize,
    model: &ModalModel,
    truth: &ModalModel,
    console: &Console,
) -> Result<Judged> {
    console.stage("rendering four scenes");
    Output::new(&files.scenes[k], SCENE, &[], console)?.write_bytes(scene_text(k + 1))?;
    let scene = Scene::read(&files.scenes[k])?;
    let options = RenderOptions::default();
    let mut rendering = render_scene(
        model,
        &scene,
        &options,
        None,
        vec![source(&files.model)?, source(&files.scenes[k])?],
    )?;
    if k == 0 {
        TRIALS.on(&mut rendering.weights, model, &scene, &options, console)?;
    }
    let of_scene = |finding: &Finding| Finding {
        text: format!("scene-{}.toml: {}", k + 1, finding.text),
        ..finding.clone()
    };
    let findings: Vec<Finding> = rendering.weights.findings.iter().map(of_scene).collect();
    console.find_all(&findings);
    write_weights(
        &Output::new(&files.weights[k], WEIGHTS, &[], console)?,
        &rendering.weights,
    )?;
    let on_panel = evaluate(&rendering.weights, &scene, On::Model(truth))?
        .indices
        .points;
    let curves = curves(model, &scene, &rendering.weights)?;
    Ok(Judged {
        rendering,
        curves,
        on_panel,
    })
}

fn scene_text(hot: usize) -> String {
    format!(
        "# Cell {hot} of four is to be felt, the other three are to be quiet.

frequency_hz = 330.0

[threshold]
profile = \"paper\"                      # 0.2 mm/s peak
limen_db = 2.0

[zones]
grid = [2, 2]                          # columns, rows of equal cells over cells_m
hot = [{hot}]
area_m = [0.034, 0.025, 0.234, 0.145]  # the measured grid
cells_m = [0.0, 0.0, 0.268, 0.170]     # the panel
transition_m = 0.010

[actuators]
use = \"all\"
max_force_n = 0.1
"
    )
}

/// A complaint for each scene whose hot or cold ratio is too low, in the model or on the
/// panel.
fn unmet(scenes: &[Judged]) -> Vec<String> {
    let least = |scene: &Judged| {
        scene
            .rendering
            .weights
            .indices
            .points
            .min_ratio
            .min(scene.on_panel.min_ratio)
    };
    let low = scenes
        .iter()
        .enumerate()
        .filter(|(_, scene)| least(scene) < LEAST_RATIO);
    low.map(|(k, scene)| {
        format!(
            "scene {}: a hot or cold ratio of {:.3} is below {LEAST_RATIO}",
            k + 1,
            least(scene)
        )
    })
    .collect()
}

fn json(
    args: &Args,
    files: &Files,
    comparison: &Comparison,
    scenes: &[Judged],
    on_rig: &OnRig,
) -> Value {
    let name = |path: &PathBuf| {
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
    };
    let spread = |sorted: &[f64]| json!({"worst": sorted.last(), "median": median(sorted)});
    let scene = |(k, scene): (usize, &Judged)| {
        json!({
            "scene": name(&files.scenes[k]),
            "feasible": scene.rendering.weights.feasible,
            "indices": scene.rendering.weights.indices,
            "on_panel": scene.on_panel,
        })
    };
    json!({
        "output": args.output.display().to_string(),
        "files": files.all().map(name).collect::<Vec<_>>(),
        "modes": {"known": comparison.known, "missed": comparison.missed, "spurious": comparison.spurious},
        "frequency_error": spread(&comparison.frequency_errors),
        "loss_factor_error": spread(&comparison.loss_factor_errors),
        "mac": {"worst": comparison.mac.first(), "median": median(&comparison.mac)},
        "scenes": scenes.iter().enumerate().map(scene).collect::<Vec<_>>(),
        "dead_actuator": on_rig.json(),
    })
}

fn text(
    args: &Args,
    model: &ModalModel,
    comparison: &Comparison,
    scenes: &[Judged],
    on_rig: &OnRig,
) -> String {
    let worst = |sorted: &[f64]| {
        let worst = sorted.last().copied().unwrap_or(f64::NAN);
        format!("{} %", significant(100.0 * worst, 2))
    };
    let truth = format!(
        "Against the known truth: {} of {} modes, {} spurious; worst error of a frequency {}, of a \
         loss factor {}.",
        comparison.known - comparison.missed,
        comparison.known,
        comparison.spurious,
        worst(&comparison.frequency_errors),
        worst(&comparison.loss_factor_errors)
    );
    let percent = |ratio: f64| format!("{:.0} %", 100.0 * ratio);
    let row = |(k, scene): (usize, &Judged)| {
        let points = &scene.rendering.weights.indices.points;
        let spare = points
            .margin_db
            .map_or_else(String::new, |db| format!("{db:.1} dB"));
        vec![
            format!("scene {}", k + 1),
            percent(points.hot_ratio),
            percent(points.cold_ratio),
            spare,
            percent(scene.on_panel.hot_ratio),
            percent(scene.on_panel.cold_ratio),
        ]
    };
    let rows: Vec<Vec<String>> = scenes.iter().enumerate().map(row).collect();
    const HEADER: [&str; 6] = [
        "",
        "hot felt",
        "cold quiet",
        "to spare",
        "on the panel: hot",
        "cold",
    ];
    format!(
        "{}\n{truth}\n\n{}\n{}\n\n{}/report.html shows it, and what becomes of the drive under stress and at \
         other frequencies.\n",
        sentence(model),
        table(&HEADER, &rows),
        on_rig.text(),
        args.output.display()
    )
}

/// Median of rising values; NaN without values.
fn median(sorted: &[f64]) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let (low, high) = (sorted[last / 2], sorted[last.div_ceil(2)]);
    low + 0.5 * (high - low)
}
