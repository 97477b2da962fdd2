//! The report through its public door.

use chladni_frf::{FrfSet, ModalModel, Source, Trust};
use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::{evaluate, render, On, Rendering, Scene};
use chladni_report::{charts, html, ChartFormats, RenderedScene, ReportInput};
use std::path::Path;
use std::sync::OnceLock;

const BOTH: ChartFormats = ChartFormats { svg: true, png: true };
/// A page of the demonstration panel stays below.
const MAX_PAGE_BYTES: usize = 8_000_000;

fn simulated(text: &str) -> Simulation {
    simulate(&Panel::from_toml(text, 1 << 30).unwrap(), None, None).unwrap()
}

/// The glass panel up to 400 Hz at 24 × 12 pairs, with bounds as a fit would give.
fn small() -> &'static Simulation {
    static SMALL: OnceLock<Simulation> = OnceLock::new();
    SMALL.get_or_init(|| {
        let mut simulation = simulated("[responses]\ngrid = [6, 4]\nspacing_m = 0.04\n[references]\nedge_count = [4, 2]\nspacing_m = 0.05\n[frf]\nstop_hz = 400\nstep_hz = 2\n");
        for mode in &mut simulation.truth.modes {
            (mode.frequency_std_hz, mode.loss_factor_std) = (0.0123, 1e-5);
        }
        simulation
    })
}

fn scene() -> Scene {
    Scene::parse("frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n", Path::new("")).unwrap()
}

fn rendering(model: &ModalModel) -> Rendering {
    render(model, &scene(), &Default::default()).unwrap()
}

fn input<'a>(model: &'a ModalModel, measured: Option<&'a FrfSet>, rendering: &'a Rendering) -> ReportInput<'a> {
    let scenes = vec![RenderedScene::of_rendering(rendering)];
    ReportInput { title: "Panel".into(), model: Some(model), measured, scenes, warnings: Vec::new() }
}

#[test]
fn the_page_needs_no_network_and_shows_every_part() {
    let rendering = rendering(&small().truth);
    let page = html(&input(&small().truth, Some(&small().frf), &rendering)).unwrap();
    for outside in ["http://", "https://", "src=", "@import", "url(", "<link", "<iframe"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for part in [
        "id=\"poles\"",
        "figure-frf-sum",
        "figure-frf-12",
        "figure-cmif",
        "figure-stabilization",
        "figure-auto-mac",
        "figure-mode-01",
        "figure-field-1",
        "figure-weights-1-panel",
        "figure-weights-1-list",
        "Silence would score",
        "0.024",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.contains("Shown are 12 of 288 FRFs"));
}

#[test]
fn foreign_text_cannot_become_markup() {
    const EVIL: &str = "<script>alert(1)</script>\"'&";
    let mut model = small().truth.clone();
    model.source = vec![Source { file: EVIL.into(), sha256: EVIL.into() }];
    (model.method, model.quality.path) = (EVIL.into(), Some(EVIL.into()));
    model.quality.warnings = vec![EVIL.into()];
    (model.modes[0].trust, model.modes[0].reasons) = (Trust::Weak, vec![EVIL.into()]);
    let mut rendering = rendering(&small().truth);
    (rendering.weights.scene, rendering.weights.method) = (EVIL.into(), EVIL.into());
    rendering.weights.warnings = vec![EVIL.into()];
    let mut input = input(&model, None, &rendering);
    (input.title, input.warnings) = (EVIL.into(), vec![EVIL.into()]);
    let page = html(&input).unwrap();
    assert_eq!(page.matches("<script>").count(), 1, "only the page's own script");
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;"));
    assert!(!page.contains("alert(1)</script>"));
}

#[test]
fn warnings_come_first_and_doubts_have_their_reasons() {
    let mut model = small().truth.clone();
    (model.modes[1].trust, model.modes[1].reasons) = (Trust::Weak, vec!["hardly above the noise".into()]);
    model.quality.trusted = false;
    let page = html(&ReportInput { title: "Panel".into(), model: Some(&model), ..Default::default() }).unwrap();
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(place("not to be trusted") < place("<nav"));
    assert!(place("1 mode kept with doubts") < place("<nav"));
    assert!(page.contains("? weak</span>: hardly above the noise"));
}

#[test]
fn without_measured_frfs_the_synthesis_stands_alone_and_the_page_says_so() {
    let rendering = rendering(&small().truth);
    let page = html(&input(&small().truth, None, &rendering)).unwrap();
    assert!(page.contains("The measured FRFs are not at hand: only the model's synthesis is shown."));
    assert!(page.contains("Complex mode indicator function of the synthesis"));
    assert!(!page.contains(">measured<"));
}

#[test]
fn weights_alone_and_measured_frfs_alone_make_a_report() {
    let rendering = rendering(&small().truth);
    let weights = ReportInput { scenes: vec![RenderedScene::of_weights(&rendering.weights)], ..Default::default() };
    let page = html(&weights).unwrap();
    assert!(page.contains("figure-weights-1-list") && page.contains("weights alone do not carry it"));
    let frfs = ReportInput { measured: Some(&small().frf), ..Default::default() };
    assert!(html(&frfs).unwrap().contains("There is no model: only the measured FRFs are shown."));
    assert!(html(&ReportInput::default()).unwrap().contains("No warnings."));
}

#[test]
fn weights_judged_on_the_measured_line_name_it() {
    let rendering = rendering(&small().truth);
    let evaluation = evaluate(&rendering.weights, &scene(), On::Frf(&small().frf)).unwrap();
    let scenes = vec![RenderedScene::of_evaluation(&rendering.weights, &evaluation, "panel.h5 <1>")];
    let page = html(&ReportInput { scenes, ..Default::default() }).unwrap();
    assert!(page.contains("Field at 300.0 Hz (panel.h5 &lt;1&gt;)") && page.contains("Share that keeps its limit (panel.h5 &lt;1&gt;)"));
}

#[test]
fn measured_frfs_of_another_structure_are_refused() {
    let mut other = small().frf.clone();
    other.responses.iter_mut().for_each(|dof| dof.node += 1000);
    let error = html(&ReportInput { model: Some(&small().truth), measured: Some(&other), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("no DOF pair of the model"), "{error}");
}

#[test]
fn a_model_without_positions_still_shows_its_shapes() {
    let mut model = small().truth.clone();
    model.nodes.clear();
    let page = html(&ReportInput { model: Some(&model), ..Default::default() }).unwrap();
    assert!(page.contains("figure-mode-01") && page.contains("Response (DOF)"));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let rendering = rendering(&small().truth);
    let whole = input(&small().truth, Some(&small().frf), &rendering);
    assert!(html(&whole).unwrap() == html(&whole).unwrap());
    let scene_alone = ReportInput { model: None, measured: None, ..whole };
    assert!(charts(&scene_alone, BOTH).unwrap() == charts(&scene_alone, BOTH).unwrap());
}

#[test]
fn chart_files_are_sound_and_have_their_own_names() {
    let mut model = small().truth.clone();
    model.modes.truncate(3);
    let rendering = rendering(&model);
    let files = charts(&input(&model, Some(&small().frf), &rendering), BOTH).unwrap();
    let (pngs, svgs): (Vec<_>, Vec<_>) = files.iter().partition(|file| file.0.ends_with(".png"));
    assert_eq!((pngs.len(), svgs.len()), (22, 22));
    for (name, bytes) in pngs {
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82"), "{name}");
    }
    for (name, bytes) in svgs {
        let text = std::str::from_utf8(bytes).unwrap();
        assert!(text.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && text.ends_with("</svg>\n"), "{name}");
        let drawn = |line: &&str| !line.starts_with("<image");
        assert!(text.lines().filter(drawn).all(|line| !line.contains("NaN") && !line.contains("inf,")), "{name}");
    }
    let names: std::collections::BTreeSet<&String> = files.iter().map(|file| &file.0).collect();
    assert_eq!(names.len(), files.len());
}

#[test]
fn the_page_of_the_demonstration_panel_stays_small() {
    let simulation = simulated("[plate]\n");
    let rendering = rendering(&simulation.truth);
    let page = html(&input(&simulation.truth, Some(&simulation.frf), &rendering)).unwrap();
    assert!(page.len() < MAX_PAGE_BYTES, "{} bytes", page.len());
    assert!(page.contains("12 of 2618 FRFs") && page.contains("77.9 %"), "shares are those of the seed paper's scene");
}
