//! Fingers as part of the scene.

use crate::common::rig::Rig;
use crate::common::{cell_scene, scene, truth};
use chladni_render::{
    render, Finger, Ground, RenderOptions, Scene, TouchCriterion, TouchPlaces, Weights,
};
use std::path::Path;

fn corner(frequency_hz: f64, touch: &str) -> Scene {
    let mut scene = cell_scene([2, 2], 1, touch);
    scene.frequency_hz = frequency_hz;
    scene
}

fn rendered(scene: &Scene) -> Weights {
    render(truth(), scene, &RenderOptions::default())
        .unwrap()
        .weights
}

/// Hot, cold and all responses of a rig that a drive truly serves, as shares.
fn served(rig: &Rig, scene: &Scene, weights: &Weights) -> [f64; 3] {
    let field = rig.field(&rig.drive(weights));
    let limits = scene.limits().unwrap();
    let judged =
        chladni_render::evaluate(weights, scene, chladni_render::On::Model(truth())).unwrap();
    let mut counts = [[0.0; 2]; 2];
    for (ground, value) in judged.field.ground.iter().zip(&field) {
        let (kind, inside) = match ground {
            Ground::Hot => (0, limits.is_felt(value.norm())),
            Ground::Cold => (1, limits.is_quiet(value.norm())),
            Ground::Ignored => continue,
        };
        counts[kind][0] += f64::from(u8::from(inside));
        counts[kind][1] += 1.0;
    }
    let [[a, b], [c, d]] = counts;
    [a / b, c / d, (a + c) / (b + d)]
}

#[test]
fn the_quarter_bears_light_and_mid_fingers_at_330_hz() {
    let touched = corner(330.0, "[touch]\n");
    let start = std::time::Instant::now();
    let weights = rendered(&touched);
    let plain = rendered(&corner(330.0, ""));
    let told = weights.touch.clone().unwrap();
    let newtons = weights.indices.points.max_force_n.unwrap();
    eprintln!("{:.2?} {newtons} {told:?}", start.elapsed());
    assert_eq!(told.firmest.as_deref(), Some("mid"));
    assert!(told.is_known && told.places > 20);
    assert!(
        told.kappa.unwrap() >= 2.5 && newtons <= 3e-3,
        "{told:?} {newtons}"
    );
    assert!(
        told.points.min_ratio >= 0.9 && told.points.success_ratio >= 0.99,
        "{told:?}"
    );
    assert!(weights.feasible && weights.indices.points.min_ratio == 1.0);
    // on the plate itself, at places that the drive was not made for
    let (mut total, mut least, mut before) = (0.0, 1.0f64, 1.0f64);
    let fingers = [Finger::LIGHT, Finger::MID];
    let places = [
        [0.045, 0.035],
        [0.061, 0.052],
        [0.083, 0.044],
        [0.107, 0.066],
        [0.117, 0.029],
    ];
    for finger in &fingers {
        for place in places {
            let rig = Rig::new(330.0, 1).loaded(finger, place);
            let [hot, cold, all] = served(&rig, &touched, &weights);
            total += all / (fingers.len() * places.len()) as f64;
            least = least.min(hot).min(cold);
            let [hot, cold, _] = served(&rig, &touched, &plain);
            before = before.min(hot).min(cold);
        }
    }
    eprintln!("total {total} least {least}, without [touch] {before}");
    assert!(
        total >= 0.99 && least >= 0.9 && before < least,
        "{total} {least} {before}"
    );
}

#[test]
fn what_no_drive_bears_is_said_with_a_frequency_that_does() {
    let touch = "[touch]\nimpedance = [\"light\", \"mid\", \"firm\"]\n";
    let weights = rendered(&corner(300.0, touch));
    let said = weights
        .findings
        .iter()
        .find(|finding| finding.code == "touch-not-borne");
    let said = said.expect("a finding");
    eprintln!("{}", said.text);
    assert!(
        said.text.contains("tolerates a firm finger at 300 Hz"),
        "{}",
        said.text
    );
    assert!(said.text.contains("a mode lies at 299"), "{}", said.text);
    assert!(
        said.text.contains("Hz a drive tolerates a mid one with κ"),
        "{}",
        said.text
    );
    assert!(weights.feasible, "the drive without fingers stays");
}

#[test]
fn each_criterion_is_borne_by_itself() {
    let kappa = |criterion: &str, fingers: usize| {
        let touch = format!("[touch]\nfingers = {fingers}\ncriterion = \"{criterion}\"\n");
        rendered(&corner(330.0, &touch))
            .touch
            .unwrap()
            .kappa
            .unwrap()
    };
    let [own, pair, field] = [kappa("own", 1), kappa("pair", 2), kappa("field", 1)];
    eprintln!("{own} {pair} {field}");
    assert!(
        own >= 1.0 && pair >= 1.0 && field >= 1.0,
        "{own} {pair} {field}"
    );
}

#[test]
fn the_table_is_read_and_checked() {
    let read = |rest: &str| {
        let text = format!("frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n{rest}");
        Scene::parse(&text, Path::new(""))
    };
    let touch = scene("frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[touch]\n").touch;
    let touch = touch.unwrap();
    assert_eq!((touch.fingers, touch.criterion), (1, TouchCriterion::Field));
    assert_eq!((touch.places, touch.kappa_least), (TouchPlaces::Hot, 1.0));
    let names: Vec<&str> = touch.impedances.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["light", "mid"]);
    let own = "[touch]\npoints_m = [[0.05, 0.04]]\nimpedance = [\"firm\", {c = 1.0}]\n";
    let touch = read(own).unwrap().touch.unwrap();
    assert_eq!(touch.places, TouchPlaces::Points(vec![[0.05, 0.04]]));
    assert_eq!(
        (
            touch.impedances[1].name.as_str(),
            touch.impedances[0].finger
        ),
        ("c = 1", Finger::FIRM)
    );
    for (rest, words) in [
        ("[touch]\nwhere = \"cold\"", "no such ground"),
        ("[touch]\nfingers = 0", "not a count"),
        ("[touch]\nfingers = 9", "no such number of fingers"),
        ("[touch]\ncriterion = \"all\"", "no such criterion"),
        ("[touch]\nimpedance = [\"hard\"]", "no such fingertip"),
        ("[touch]\nimpedance = [{}]", "a fingertip that is nothing"),
        ("[touch]\nimpedance = [{d = 1.0}]", "unknown key"),
        (
            "[touch]\nwhere = \"hot\"\npoints_m = [[0.0, 0.0]]",
            "either somewhere or at points",
        ),
        ("[touch]\nkappa_leas = 1.0", "unknown key"),
    ] {
        let error = read(rest).unwrap_err().to_string();
        assert!(error.contains(words), "{rest}: {error}");
    }
}

#[test]
fn fingers_beyond_the_responses_are_refused() {
    let far = corner(330.0, "[touch]\npoints_m = [[5.0, 5.0]]\n");
    let error = render(truth(), &far, &RenderOptions::default()).unwrap_err();
    assert!(error.to_string().contains("touch.points_m"), "{error}");
}

#[test]
fn fingertips_have_all_their_numbers_as_name_and_the_softest_is_the_one_that_gives_way() {
    let told = |impedance: &str| {
        let touch = format!("[touch]\nimpedance = {impedance}\n");
        let weights = rendered(&corner(330.0, &touch));
        let is_said = weights.findings.iter().any(|f| f.code == "touch-not-borne");
        (weights.touch.unwrap().firmest, is_said)
    };
    for list in [
        "[{c = 0.05, m = 1e-6}, {c = 0.05, m = 1.0}]",
        "[{c = 0.05, m = 1.0}, {c = 0.05, m = 1e-6}]",
    ] {
        let (firmest, is_said) = told(list);
        assert_eq!(firmest.as_deref(), Some("c = 0.05, m = 0.000001"));
        assert!(is_said, "{list}");
    }
    let (firmest, is_said) = told("[\"light\", {m = 1.0}]");
    assert!(firmest.as_deref() == Some("light") && is_said);
}

#[test]
fn a_panel_in_millimetres_read_as_metres_is_touched_at_as_many_places() {
    let mut model = truth().clone();
    for node in &mut model.nodes {
        node.xyz_m = node.xyz_m.map(|metres| 1e3 * metres);
    }
    let text = "frequency_hz = 330.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[touch]\n";
    let weights = render(&model, &scene(text), &RenderOptions::default()).unwrap();
    let places = weights.weights.touch.unwrap().places;
    assert!((20..=150).contains(&places), "{places}");
}
