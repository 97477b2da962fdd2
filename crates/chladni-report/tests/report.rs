//! The report through its public door.

use base64::engine::general_purpose::STANDARD;
use base64::Engine;
use chladni_frf::{Checksum, Finding, FrfSet, ModalModel, Reason, Source, Trust};
use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::{evaluate, render, stress, sweep, On, Rendering, Scene, StressOptions};
use chladni_report::{
    charts, data, figures, gallery, html, scene_data, studio_html, ChartFormats, CurvePoint,
    Curves, RenderedScene, ReportInput, Table,
};
use std::path::Path;
use std::sync::OnceLock;

const BOTH: ChartFormats = ChartFormats {
    svg: true,
    png: true,
    gif: true,
};
/// A page of the demonstration panel stays below.
const MAX_PAGE_BYTES: usize = 8_000_000;

fn simulated(text: &str) -> Simulation {
    simulate(&Panel::from_toml(text, 1 << 30).unwrap(), None, None).unwrap()
}

/// The glass panel up to 400 Hz at 24 × 12 pairs, with bounds as a fit would give.
fn small() -> &'static Simulation {
    static SMALL: OnceLock<Simulation> = OnceLock::new();
    SMALL.get_or_init(|| {
        let mut simulation = simulated(
            "[responses]\ngrid = [6, 4]\nspacing_m = \
                                        0.04\n[references]\nedge_count = [4, 2]\nspacing_m = \
                                        0.05\n[frf]\nstop_hz = 400\nstep_hz = 2\n",
        );
        for mode in &mut simulation.truth.modes {
            (mode.frequency_std_hz, mode.loss_factor_std) = (0.0123, 1e-5);
        }
        simulation
    })
}

fn scene() -> Scene {
    Scene::parse(
        "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, \
                  0.268, 0.170]\n",
        Path::new(""),
    )
    .unwrap()
}

fn rendering(model: &ModalModel) -> Rendering {
    render(model, &scene(), &Default::default()).unwrap()
}

fn input<'a>(
    model: &'a ModalModel,
    measured: Option<&'a FrfSet>,
    rendering: &'a Rendering,
) -> ReportInput<'a> {
    let scenes = vec![RenderedScene::of_rendering(rendering)];
    ReportInput {
        title: "Panel".into(),
        model: Some(model),
        measured,
        scenes,
        ..ReportInput::default()
    }
}

/// Numbers that stand in the data as base64 of little-endian single precision.
fn f32s(coded: &serde_json::Value) -> Vec<f32> {
    let bytes = STANDARD.decode(coded["f32"].as_str().unwrap()).unwrap();
    bytes
        .chunks_exact(4)
        .map(|four| f32::from_le_bytes(four.try_into().unwrap()))
        .collect()
}

#[test]
fn the_page_needs_no_network_and_runs_no_script_but_its_own() {
    let rendering = rendering(&small().truth);
    let page = html(&input(&small().truth, Some(&small().frf), &rendering)).unwrap();
    // the name of SVG elements is no address
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for outside in [
        "http://", "https://", " src=", "@import", "url(http", "<link", "<iframe", "fetch(",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(
        page.contains("default-src 'none'")
            && page.contains("script-src 'sha256-")
            && page.contains("connect-src 'none'")
    );
    assert_eq!(page.matches("<script>").count(), 1);
}

#[test]
fn a_gallery_shows_its_figures_without_a_script() {
    let all = figures(&ReportInput {
        model: Some(&small().truth),
        ..Default::default()
    })
    .unwrap();
    let page = gallery("Charts <1>", "made & measured", &all[..3]);
    assert_eq!(
        (
            page.matches("<svg").count(),
            page.matches("<section").count()
        ),
        (3, 3)
    );
    assert!(page.contains("<h1>Charts &lt;1&gt;</h1>") && page.contains("made &amp; measured"));
    assert!(!page.contains("module_page"));
}

#[test]
fn the_studio_asks_its_own_server_only() {
    let page = studio_html("a <b>", 7);
    assert!(
        page.contains("connect-src 'self'")
            && page.contains("fetch(`/api/${path}`")
            && page.contains(r#"{"page":7,"#)
            && page.contains("a &lt;b&gt;")
    );
}

#[test]
fn the_data_hold_every_part_of_the_report() {
    let rendering = rendering(&small().truth);
    let tables = vec![Table {
        name: "accuracy.csv".into(),
        header: vec!["case".into()],
        rows: vec![vec!["panel".into()]],
    }];
    let input = ReportInput {
        tables,
        ..input(&small().truth, Some(&small().frf), &rendering)
    };
    let all = data(&input).unwrap();
    let modes = small().truth.in_band_modes().count();
    for part in ["model", "frfs", "cmif", "stabilization", "mac", "geometry"] {
        assert!(all[part].is_object(), "{part}");
    }
    assert_eq!(
        (
            all["frfs"]["total_pairs"].as_u64(),
            all["frfs"]["full"].as_array().map(Vec::len)
        ),
        (Some(288), Some(12))
    );
    assert_eq!(all["mac"]["count"].as_u64(), Some(modes as u64));
    let mac = f32s(&all["mac"]["values"]);
    assert!(
        (0..modes).all(|k| (mac[k * (modes + 1)] - 1.0).abs() < 1e-6),
        "a shape agrees with itself"
    );
    assert!(all["stabilization"]["orders"]
        .as_array()
        .is_some_and(|orders| orders.len() > 5));
    let scene = &all["scenes"][0];
    assert_eq!(
        scene["weights"].as_array().unwrap().len(),
        small().truth.references.len()
    );
    let velocity = f32s(&scene["field"]["velocity"]);
    for (k, v) in rendering.field.velocity_m_per_s.iter().enumerate() {
        assert!(
            (f64::from(velocity[2 * k]) - v.re).abs() < 1e-6 * v.norm()
                && (f64::from(velocity[2 * k + 1]) - v.im).abs() < 1e-6 * v.norm()
        );
    }
    assert_eq!(scene_data(&input), *scene);
    assert_eq!(all["tables"][0]["rows"][0][0], "panel");
}

#[test]
fn of_many_sources_the_first_are_named() {
    let mut model = small().truth.clone();
    model.source = (1..=34)
        .map(|k| Source {
            file: format!("scan_{k}.uff"),
            checksum: Checksum::Sha256("ab".repeat(32)),
        })
        .collect();
    let facts = data(&ReportInput {
        model: Some(&model),
        ..Default::default()
    })
    .unwrap()["model"]["facts"]
        .to_string();
    assert!(
        facts.contains("scan_1.uff, scan_2.uff, scan_3.uff and 31 more") && !facts.contains("abab"),
        "{facts}"
    );
}

#[test]
fn foreign_text_cannot_become_markup() {
    const EVIL: &str = "</script><script>alert(1)</script>\"'&";
    let mut model = small().truth.clone();
    model.source = vec![Source {
        file: EVIL.into(),
        checksum: Checksum::Sha256(EVIL.into()),
    }];
    (model.method, model.quality.path) = (EVIL.into(), Some(EVIL.into()));
    model.quality.findings = vec![Finding::from(EVIL.to_owned())];
    (model.modes[0].trust, model.modes[0].reasons) =
        (Trust::Weak, vec![Reason::new(EVIL, EVIL)].into());
    let mut rendering = rendering(&small().truth);
    (rendering.weights.scene, rendering.weights.method) = (EVIL.into(), EVIL.into());
    rendering.weights.findings = vec![Finding::from(EVIL.to_owned())].into();
    let mut input = input(&model, None, &rendering);
    (input.title, input.findings) = (EVIL.into(), vec![Finding::from(EVIL.to_owned())]);
    let page = html(&input).unwrap();
    assert_eq!(
        page.matches("<script").count(),
        2,
        "the data and the page's own script"
    );
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(page.contains("<title>&lt;/script&gt;&lt;script&gt;alert(1)"));
}

#[test]
fn findings_come_by_weight_with_what_they_are_about_beside_the_sentence() {
    let mut model = small().truth.clone();
    (model.modes[1].trust, model.modes[1].reasons) = (
        Trust::Weak,
        vec![Reason::new("hardly", "hardly above the noise")].into(),
    );
    model.quality.findings = vec![
        Finding::caution("look", "look here"),
        Finding::fault("wrong", "this is wrong").help("mend it"),
    ];
    let all = data(&ReportInput {
        title: "Panel".into(),
        model: Some(&model),
        ..Default::default()
    })
    .unwrap();
    let findings = all["findings"].as_array().unwrap();
    let codes: Vec<&str> = findings
        .iter()
        .map(|finding| finding["code"].as_str().unwrap())
        .collect();
    assert_eq!(codes, ["wrong", "look"]);
    assert_eq!(findings[0]["about"], "Model");
    let sentence = all["sentence"].as_str().unwrap();
    assert!(
        sentence.contains(", 1 weak; together they explain"),
        "{sentence}"
    );
    assert_eq!(
        all["model"]["modes"][1]["reasons"][0],
        "hardly above the noise"
    );
}

#[test]
fn what_is_missing_is_null_and_the_rest_is_there() {
    let rendering = rendering(&small().truth);
    let without_frfs = data(&input(&small().truth, None, &rendering)).unwrap();
    assert!(
        without_frfs["frfs"]["residuals"].is_null()
            && without_frfs["frfs"]["sums"]["measured"].is_null()
    );
    assert_eq!(without_frfs["cmif"]["of"], "of the synthesis");
    assert!(without_frfs["stabilization"].is_null());
    let weights = data(&ReportInput {
        scenes: vec![RenderedScene::of_weights(&rendering.weights)],
        ..Default::default()
    })
    .unwrap();
    assert!(
        weights["scenes"][0]["field"].is_null()
            && weights["scenes"][0]["weights"].is_array()
            && weights["model"].is_null()
    );
    let frfs = data(&ReportInput {
        measured: Some(&small().frf),
        ..Default::default()
    })
    .unwrap();
    assert!(frfs["frfs"]["residuals"].is_object() && frfs["frfs"]["sums"]["synthesis"].is_null());
    assert!(html(&ReportInput::default()).is_ok());
    let mut bare = small().truth.clone();
    bare.nodes.clear();
    assert!(data(&ReportInput {
        model: Some(&bare),
        ..Default::default()
    })
    .unwrap()["geometry"]
        .is_null());
}

#[test]
fn a_beam_has_a_structure_and_no_map() {
    let mut beam = small().truth.clone();
    for (k, node) in beam.nodes.iter_mut().enumerate() {
        node.xyz_m = [0.01 * k as f64, 0.0, 0.0];
    }
    (beam.lines, beam.faces) = (Vec::new(), Vec::new());
    let input = ReportInput {
        model: Some(&beam),
        ..Default::default()
    };
    let shown = data(&input).unwrap();
    assert!(shown["geometry"].is_null());
    let structure = &shown["structure"];
    assert_eq!(
        structure["lines"].as_array().unwrap().len(),
        1,
        "{structure}"
    );
    assert_eq!(
        structure["moves"].as_array().unwrap().len(),
        beam.responses.len()
    );
    let plate = ReportInput {
        model: Some(&small().truth),
        ..Default::default()
    };
    let faces = data(&plate).unwrap()["structure"]["faces"].clone();
    assert_eq!(faces.as_array().unwrap().len(), small().truth.faces.len());
    assert!(!small().truth.faces.is_empty());
}

#[test]
fn weights_judged_on_the_measured_line_name_it() {
    let rendering = rendering(&small().truth);
    let evaluation = evaluate(&rendering.weights, &scene(), On::Frf(&small().frf)).unwrap();
    let scenes = vec![RenderedScene::of_evaluation(
        &rendering.weights,
        &evaluation,
        "panel.h5 <1>",
    )];
    let all = data(&ReportInput {
        scenes,
        ..Default::default()
    })
    .unwrap();
    assert_eq!(all["scenes"][0]["judged_on"], "panel.h5 <1>");
}

#[test]
fn measured_frfs_of_another_structure_are_refused() {
    let mut other = small().frf.clone();
    other.responses.iter_mut().for_each(|dof| dof.node += 1000);
    let error = html(&ReportInput {
        model: Some(&small().truth),
        measured: Some(&other),
        ..Default::default()
    })
    .unwrap_err();
    assert!(
        error.to_string().contains("no DOF pair of the model"),
        "{error}"
    );
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let rendering = rendering(&small().truth);
    let whole = input(&small().truth, Some(&small().frf), &rendering);
    assert!(html(&whole).unwrap() == html(&whole).unwrap());
    let scene_alone = ReportInput {
        model: None,
        measured: None,
        ..whole
    };
    assert!(charts(&scene_alone, BOTH).unwrap() == charts(&scene_alone, BOTH).unwrap());
}

#[test]
fn chart_files_are_sound_and_have_their_own_names() {
    let mut model = small().truth.clone();
    model.modes.truncate(3);
    let rendering = rendering(&model);
    let files = charts(&input(&model, Some(&small().frf), &rendering), BOTH).unwrap();
    let of = |ending: &str| {
        let files = files.iter().filter(|file| file.0.ends_with(ending));
        files.collect::<Vec<_>>()
    };
    let (pngs, svgs, gifs) = (of(".png"), of(".svg"), of(".gif"));
    assert_eq!((pngs.len(), svgs.len(), gifs.len()), (25, 25, 3));
    for (name, bytes) in gifs {
        assert!(
            bytes.starts_with(b"GIF89a") && bytes.ends_with(b"\x3b"),
            "{name}"
        );
    }
    for (name, bytes) in pngs {
        assert!(
            bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82"),
            "{name}"
        );
    }
    for (name, bytes) in svgs {
        let text = std::str::from_utf8(bytes).unwrap();
        assert!(
            text.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"")
                && text.ends_with("</svg>\n"),
            "{name}"
        );
        let drawn = |line: &&str| !line.starts_with("<image");
        assert!(
            text.lines()
                .filter(drawn)
                .all(|line| !line.contains("NaN") && !line.contains("inf,")),
            "{name}"
        );
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
}

#[test]
fn every_axis_of_every_figure_has_a_label_and_a_unit() {
    let mut rendering = rendering(&small().truth);
    rendering.weights.stress = Some(
        stress(
            &rendering.weights,
            &scene(),
            &small().truth,
            &StressOptions {
                draws: 5,
                ..Default::default()
            },
        )
        .unwrap()
        .0,
    );
    rendering.weights.sweep = Some(
        sweep(
            &small().truth,
            &scene(),
            &Default::default(),
            [295.0, 305.0],
        )
        .unwrap(),
    );
    let header = ["case", "method", "time_s", "frequency_rmse_over_crlb"]
        .map(String::from)
        .to_vec();
    let rows = vec![["panel", "auto", "1.5", "1.02"].map(String::from).to_vec()];
    let tables = vec![Table {
        name: "accuracy.csv".into(),
        header,
        rows,
    }];
    let points = [(1, 0.2), (2, 0.9)].map(|(count, ratio)| CurvePoint {
        count,
        hot_ratio: ratio,
        cold_ratio: ratio,
        success_ratio: ratio,
    });
    let curves = Curves {
        method: "fast".into(),
        modes: points.to_vec(),
        actuators: points.to_vec(),
    };
    let mut input = ReportInput {
        tables,
        ..input(&small().truth, Some(&small().frf), &rendering)
    };
    input.scenes = input
        .scenes
        .into_iter()
        .map(|scene| scene.with_curves(Some(&curves)))
        .collect();
    let shown = data(&input).unwrap();
    let layers = shown["scenes"][0]["curves"][0]["charts"][0]["layers"].as_array();
    let both = layers.unwrap().iter().find(|layer| layer["name"] == "both");
    assert_eq!(f32s(&both.unwrap()["lines"][0][1])[1], 90.0);
    let figures = figures(&input).unwrap();
    let diagram = figures
        .iter()
        .find(|figure| figure.name == "stabilization")
        .unwrap();
    assert_eq!(
        diagram.charts[0]
            .right
            .as_ref()
            .map(|right| right.axis.label.as_str()),
        Some("Order of the denominator")
    );
    for name in [
        "frf-sum",
        "frf-12",
        "cmif",
        "stabilization",
        "poles",
        "auto-mac",
        "mode-01",
        "complexity",
        "zones-1",
        "field-1",
        "fewer-modes-1",
        "fewer-actuators-1",
        "weights-1-panel",
        "weights-1-list",
        "sweep-1",
        "stress-1",
        "speed-1",
    ] {
        assert!(figures.iter().any(|figure| figure.name == name), "{name}");
    }
    for figure in figures {
        assert!(!figure.title.is_empty(), "{}", figure.name);
        for chart in &figure.charts {
            let right = chart.right.as_ref().map(|right| &right.axis);
            for axis in [&chart.x, &chart.y]
                .into_iter()
                .chain(right)
                .chain(chart.colour_bar.as_ref().map(|bar| &bar.axis))
            {
                assert!(
                    !axis.label.is_empty() && !axis.unit.is_empty(),
                    "{}: {axis:?}",
                    figure.name
                );
            }
        }
    }
}
