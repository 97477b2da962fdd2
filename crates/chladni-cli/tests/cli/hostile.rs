//! `render` with models and scenes that no measurement gives: they are rendered or refused in
//! words, never an internal error.

use crate::common::Folder;
use serde_json::{json, Value};

/// Responses, 4 columns and 3 rows 50 mm apart.
const RESPONSES: usize = 12;
const REFERENCES: usize = 3;
/// The corner at the origin is hot.
const SCENE: &str = "frequency_hz = 60.0\n[zones]\ngrid = [2, 1]\nhot = [1]\ntransition_m = 0.0\n";
/// Numbers that are possible in files and impossible for panels.
const EXTREMES: [f64; 10] = [
    1e300, -1e300, 1e160, 1e100, 1e30, 1e10, 0.0, 1e-30, 1e-160, 1e-300,
];
/// Methods with kernels of their own.
const METHODS: [&str; 6] = ["fast", "default", "mls", "modal", "tikhonov", "vast"];

/// A sound model of three modes.
fn model() -> Value {
    let wave = |count: usize, step: usize| -> Value {
        let re: Vec<f64> = (1..=count)
            .map(|k| (1.3 * (k * step) as f64).sin())
            .collect();
        json!({"re": re, "im": vec![0.0; count]})
    };
    let modes: Vec<Value> = (1..=3)
        .map(|n| {
            json!({
                "frequency_hz": 25.0 + 15.0 * n as f64, "frequency_std_hz": 0.01,
                "loss_factor": 0.01, "loss_factor_std": 1e-3, "damping_ratio": 0.005,
                "in_band": true, "trust": "sure", "reasons": [], "mpc": 1.0,
                "shape": wave(RESPONSES, n), "shape_std": vec![0.01; RESPONSES],
                "participation": wave(REFERENCES, n),
            })
        })
        .collect();
    let nodes: Vec<Value> = (0..RESPONSES)
        .map(|k| json!({"label": k + 1, "xyz_m": [0.05 * (k % 4) as f64, 0.05 * (k / 4) as f64, 0.0]}))
        .collect();
    let dofs = |first: usize, count: usize| -> Vec<String> {
        (first..first + count)
            .map(|node| format!("{node}:+Z"))
            .collect()
    };
    json!({
        "format": "chladni.model", "version": 1, "created_by": "test", "source": [], "options": {},
        "frf_kind": "mobility", "reference_unit": "N", "band_hz": [10.0, 100.0],
        "damping": "structural", "scaling": "unscaled",
        "responses": dofs(1, RESPONSES), "references": dofs(101, REFERENCES), "nodes": nodes,
        "method": "auto", "modes": modes,
        "residual_terms": {"omega_scale_rad_per_s": 600.0, "terms": []},
        "quality": {"relative_error": 0.01, "chi2_per_dof": 1.0, "trusted": true, "warnings": []},
    })
}

/// The outcome of `render` on a model and a scene.
struct Judged {
    code: i32,
    said: String,
}

fn render(folder: &Folder, model: &Value, scene: &str, method: &str) -> Judged {
    folder.write("model.json", model.to_string());
    folder.write("scene.toml", scene);
    let run = folder.run(&format!(
        "render model.json scene.toml --method {method} -q"
    ));
    Judged {
        code: run.code,
        said: run.stderr,
    }
}

/// Every number at `pointer`, in all modes where that contains `*`.
fn set(model: &mut Value, pointer: &str, new: impl Fn(f64) -> f64 + Copy) {
    let each = if pointer.contains('*') { 3 } else { 1 };
    let pointers = (0..each).map(|n| pointer.replace('*', &n.to_string()));
    for pointer in pointers {
        let value = model.pointer_mut(&pointer).unwrap();
        match value {
            Value::Array(list) => list
                .iter_mut()
                .for_each(|value| *value = new(value.as_f64().unwrap()).into()),
            value => *value = new(value.as_f64().unwrap()).into(),
        }
    }
}

#[test]
fn no_number_of_a_model_is_a_bug() {
    let folder = Folder::new();
    let pointers = [
        "/modes/*/frequency_hz",
        "/modes/1/frequency_hz",
        "/modes/*/frequency_std_hz",
        "/modes/*/loss_factor",
        "/modes/*/loss_factor_std",
        "/modes/*/shape/re",
        "/modes/1/shape/re",
        "/modes/*/shape_std",
        "/modes/*/participation/re",
        "/modes/1/participation/re",
        "/nodes/*/xyz_m",
        "/nodes/1/xyz_m",
        "/band_hz",
        "/residual_terms/omega_scale_rad_per_s",
    ];
    let mut refused = 0;
    for (k, pointer) in pointers.into_iter().enumerate() {
        for (n, extreme) in EXTREMES.into_iter().enumerate() {
            let mut hostile = model();
            // each method gets every kind of number, with some of the extremes
            let method = METHODS[(k + n) % METHODS.len()];
            hostile["damping"] = ["structural", "viscous"][(k + n / 2) % 2].into();
            hostile["residual_terms"]["terms"] = json!([{"power": 4, "re": vec![[1e-9; REFERENCES]; RESPONSES], "im": vec![[0.0; REFERENCES]; RESPONSES]}]);
            set(&mut hostile, pointer, |value| {
                match pointer.contains("/re") {
                    true => value * extreme,
                    false => extreme,
                }
            });
            if pointer.ends_with("/loss_factor") {
                set(&mut hostile, "/modes/*/damping_ratio", |_| 0.5 * extreme);
            }
            let judged = render(&folder, &hostile, SCENE, method);
            assert!(
                [0, 1, 65].contains(&judged.code),
                "{pointer} {extreme:e} {method}: exit {}, {}",
                judged.code,
                judged.said
            );
            refused += usize::from(judged.code == 65);
        }
    }
    assert!(refused > 50, "{refused} of the models were refused");
    assert_eq!(
        render(&folder, &model(), SCENE, "default").code,
        1,
        "the sound one is rendered"
    );
}

/// Checks that a refusal names the number, its value and the expected one.
#[test]
fn what_no_panel_can_have_is_refused_by_name() {
    let folder = Folder::new();
    let changes: [(&str, Value, &str, [&str; 3]); 12] = [
        (
            "/modes/1/loss_factor",
            json!(-0.01),
            "structural",
            ["modes[1].loss_factor", "the mode at 55 Hz", "0 or more"],
        ),
        (
            "/modes/1/loss_factor",
            json!(-1e-300),
            "viscous",
            ["modes[1].loss_factor", "a negative number", "55 Hz"],
        ),
        (
            "/modes/2/loss_factor",
            json!(2.5),
            "viscous",
            ["modes[2].loss_factor", "the mode at 70 Hz", "less than 2"],
        ),
        (
            "/modes/0/damping_ratio",
            json!(-0.5),
            "structural",
            ["modes[0].damping_ratio", "-0.5", "0 or more"],
        ),
        (
            "/modes/0/frequency_hz",
            json!(-40.0),
            "structural",
            ["modes[0].frequency_hz", "-40", "0 or more"],
        ),
        (
            "/modes/0/frequency_hz",
            json!(1e300),
            "structural",
            ["modes[0].frequency_hz", "1e300", "1e100"],
        ),
        (
            "/modes/0/frequency_std_hz",
            json!(-1.0),
            "structural",
            ["modes[0].frequency_std_hz", "-1", "0 or more"],
        ),
        (
            "/modes/0/shape_std/3",
            json!(1e200),
            "structural",
            ["modes[0].shape_std", "1e200", "no panel"],
        ),
        (
            "/modes/0/participation/im/0",
            json!(-1e200),
            "structural",
            ["modes[0].participation", "-1e200", "no panel"],
        ),
        (
            "/nodes/1/xyz_m/0",
            json!(1e7),
            "structural",
            ["nodes, label 2", "1e7", "1e6"],
        ),
        (
            "/responses/1",
            json!("1:+Z"),
            "structural",
            ["responses", "1:+Z", "every DOF once"],
        ),
        (
            "/references/2",
            json!("101:+Z"),
            "structural",
            ["references", "101:+Z", "every DOF once"],
        ),
    ];
    for (pointer, value, law, words) in changes {
        let mut hostile = model();
        hostile["damping"] = law.into();
        *hostile.pointer_mut(pointer).unwrap() = value;
        let judged = render(&folder, &hostile, SCENE, "fast");
        assert_eq!(judged.code, 65, "{pointer}: {}", judged.said);
        for word in words.iter().chain(&["model.json"]) {
            assert!(
                judged.said.contains(word),
                "{pointer}: {word:?} in {}",
                judged.said
            );
        }
    }
}

#[test]
fn modes_that_are_sound_one_by_one_and_too_far_apart_together_are_refused() {
    let folder = Folder::new();
    let mut apart = model();
    set(&mut apart, "/modes/1/shape/re", |value| 1e12 * value);
    let judged = render(&folder, &apart, SCENE, "default");
    assert_eq!(judged.code, 65, "{}", judged.said);
    assert!(judged.said.contains("too far apart"), "{}", judged.said);
}

#[test]
fn millions_of_modes_are_refused_and_thousands_are_rendered() {
    let folder = Folder::new();
    let mut crowded = model();
    let mode = crowded["modes"][0].clone();
    crowded["modes"] = vec![mode.clone(); 2000].into();
    assert!(render(&folder, &crowded, SCENE, "fast").code <= 1);
    for key in ["responses", "references", "nodes"] {
        crowded[key] = json!([]);
    }
    let mut bare = mode;
    bare["shape"] = json!({"re": [], "im": []});
    bare["participation"] = bare["shape"].clone();
    bare["shape_std"] = json!([]);
    crowded["modes"] = vec![bare; 100_001].into();
    let judged = render(&folder, &crowded, SCENE, "fast");
    assert_eq!(judged.code, 65, "{}", judged.said);
    assert!(
        judged.said.contains("100001") && judged.said.contains("at most 100000"),
        "{}",
        judged.said
    );
}

#[test]
fn panels_of_any_form_have_grids_of_bounded_size() {
    let folder = Folder::new();
    // [m per column, m per row]: extremely wide, extremely narrow and long
    for spacing in [[3e5, 3e5], [3e5, 1e-5], [1e-5, 3e5], [1e-9, 1e-9]] {
        let mut hostile = model();
        for k in 0..RESPONSES {
            hostile["nodes"][k]["xyz_m"] = json!([
                spacing[0] * (k % 4) as f64,
                spacing[1] * (k / 4) as f64,
                0.0
            ]);
        }
        let judged = render(&folder, &hostile, SCENE, "fast");
        assert!(
            [0, 1, 65].contains(&judged.code),
            "{spacing:?}: {}",
            judged.said
        );
    }
}

#[test]
fn no_number_of_a_scene_is_a_bug() {
    let folder = Folder::new();
    let square = "[zones]\n[[zones.polygon]]\nkind = \"hot\"\n";
    let scenes = |x: f64| {
        [
            SCENE.replace("60.0", &format!("{x:e}")),
            SCENE.replace("60.0", &format!("[60.0, [1.0, {x:e}]]")),
            SCENE.replace("m = 0.0", &format!("m = {x:e}")),
            format!("{SCENE}area_m = [-{x:e}, -{x:e}, {x:e}, {x:e}]\n"),
            format!("{SCENE}cells_m = [0.0, 0.0, {x:e}, 0.1]\n"),
            format!("{SCENE}[threshold]\nlimen_db = {x:e}\n"),
            format!("{SCENE}[actuators]\nmax_force_n = {x:e}\n"),
            format!("{SCENE}[actuators]\nmax_effort = {x:e}\n"),
            format!("{SCENE}[drift]\nfrequency_relative = {x:e}\n"),
            format!("{SCENE}[drift]\nloss_factor_relative = {x:e}\n"),
            format!("{SCENE}[drift]\nshape_relative = {x:e}\n"),
            format!("{SCENE}[drift]\nisotropic_relative = {x:e}\n"),
            format!("{SCENE}[drift]\ndrive_relative = {x:e}\n"),
            format!("frequency_hz = 60.0\n{square}level_db = {x:e}\npoints_m = [[0.0, 0.0], [0.07, 0.0], [0.0, 0.1]]\n"),
            format!("frequency_hz = 60.0\n{square}points_m = [[0.0, 0.0], [{x:e}, 0.0], [0.07, {x:e}], [0.0, 0.1]]\n"),
        ]
    };
    for (n, extreme) in [1e300, -1e300, 1e16, 1e15, 1e10, 201.0, 1e-30, 1e-300]
        .into_iter()
        .enumerate()
    {
        for (k, scene) in scenes(extreme).into_iter().enumerate() {
            let method = METHODS[(k + n) % METHODS.len()];
            let judged = render(&folder, &model(), &scene, method);
            assert!(
                [0, 1, 65].contains(&judged.code),
                "{scene} {method}: {}",
                judged.said
            );
            if extreme.abs() > 1e15 {
                assert_eq!(judged.code, 65, "{scene}: {}", judged.said);
                assert!(
                    judged.said.contains("scene.toml: line"),
                    "{scene}: {}",
                    judged.said
                );
            }
        }
    }
    for (scene, words) in [
        (
            SCENE.replace("[2, 1]", "[4294967296, 4294967296]"),
            "too many cells",
        ),
        (SCENE.replace("[2, 1]", "[99999, 99999]"), "too many cells"),
        (
            format!("{SCENE}[threshold]\nlimen_db = 1e3\n"),
            "too many decibels",
        ),
    ] {
        let judged = render(&folder, &model(), &scene, "fast");
        assert_eq!(judged.code, 65, "{}", judged.said);
        assert!(judged.said.contains(words), "{}", judged.said);
    }
}
