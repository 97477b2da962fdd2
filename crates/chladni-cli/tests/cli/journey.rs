//! The main job, command by command, on a small panel.

use crate::common::{in_band_hz, Folder};
use serde_json::Value;

#[test]
fn from_a_panel_to_a_report() {
    let folder = Folder::with_panel();
    let fit = folder
        .run("fit panel.h5 -o model.json --json")
        .exits(0)
        .json();
    assert_eq!(fit["output"], "model.json");
    assert_eq!(fit["quality"]["trusted"], true);

    let truth: Value = serde_json::from_str(&folder.text("truth.json")).unwrap();
    let (found, known) = (in_band_hz(&fit), in_band_hz(&truth));
    assert_eq!(found.len(), known.len(), "{found:?} {known:?}");
    for (found, known) in found.iter().zip(&known) {
        assert!((found / known - 1.0).abs() < 1e-4, "{found} {known}");
    }

    let model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    assert_eq!(model["source"][0]["file"], "panel.h5");
    assert_eq!(model["source"][0]["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(model["options"]["modes"], "auto");

    let render = folder.run("render model.json scene.toml -o weights.json --json");
    assert!(render.code == 0 || render.code == 1, "{}", render.stderr);
    let rendered = render.json();
    assert_eq!(rendered["feasible"], render.code == 0);
    let weights: Value = serde_json::from_str(&folder.text("weights.json")).unwrap();
    assert_eq!(weights["source"][0]["file"], "model.json");
    assert_eq!(weights["scene"], "scene.toml");
    assert_eq!(weights["indices"], rendered["indices"]);

    for on in ["panel.h5", "truth.json"] {
        let judged = folder
            .run(&format!(
                "evaluate weights.json --scene scene.toml --on {on} --json"
            ))
            .exits(0)
            .json();
        let (there, here) = (&judged["indices"]["points"], &weights["indices"]["points"]);
        let ratio = |indices: &Value| indices["success_ratio"].as_f64().unwrap();
        assert!((ratio(there) - ratio(here)).abs() < 0.2, "{there} {here}");
    }

    let report = folder
        .run("report model.json weights.json -o report.html --json")
        .exits(0)
        .json();
    assert_eq!(
        (&report["measured"], &report["scenes"]),
        (&true.into(), &1.into())
    );
    let page = folder.text("report.html");
    assert!(page.contains("id=\"data\"") && !page.contains(&folder.path().display().to_string()));
}

#[test]
fn results_are_the_same_bytes_at_any_number_of_threads_and_from_any_folder() {
    let folder = Folder::with_panel();
    std::fs::create_dir(folder.path().join("other")).unwrap();
    for (threads, place) in [(1, ""), (2, "other/")] {
        folder
            .run(&format!(
                "simulate panel.toml -o {place}p{threads}.h5 --truth \
                             {place}t{threads}.json --threads {threads}"
            ))
            .exits(0);
        folder
            .run(&format!(
                "fit ./panel.h5 -o {place}m{threads}.json --threads {threads}"
            ))
            .exits(0);
        folder.run(&format!(
            "render truth.json scene.toml -o {place}w{threads}.json --threads {threads}"
        ));
    }
    for (one, two) in [
        ("p1.h5", "p2.h5"),
        ("t1.json", "t2.json"),
        ("m1.json", "m2.json"),
        ("w1.json", "w2.json"),
    ] {
        assert!(
            folder.read(one) == folder.read(&format!("other/{two}")),
            "{one}"
        );
    }
    assert!(folder.read("panel.h5") == folder.read("p1.h5"));
}

#[test]
fn stdout_carries_the_result_and_nothing_else() {
    let folder = Folder::with_panel();
    let table = folder.run("fit panel.h5").exits(0);
    assert!(
        table.stdout.contains(" explain ") && table.stdout.contains("\nmode"),
        "{}",
        table.stdout
    );
    assert!(
        table.stderr.contains("notes: -v shows them"),
        "no driving point is a note: {}",
        table.stderr
    );
    let verbose = folder.run("fit panel.h5 -v").exits(0);
    assert!(
        verbose
            .stderr
            .contains("note     shapes are not mass-scaled"),
        "{}",
        verbose.stderr
    );
    let quiet = folder.run("fit panel.h5 -o model.json -q").exits(0);
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let whole = folder.run("fit panel.h5 --json").exits(0).json();
    assert_eq!(whole["format"], "chladni.model");
    assert_eq!(whole["warnings"], serde_json::json!([]));
    let unscaled = whole["findings"].as_array().unwrap().iter();
    let unscaled: Vec<&Value> = unscaled.filter(|f| f["code"] == "unscaled").collect();
    assert_eq!(
        (unscaled.len(), &unscaled[0]["severity"]),
        (1, &"note".into())
    );
    // the object on stdout is a model file itself
    folder.write(
        "copy.json",
        folder.run("fit panel.h5 --json -q").exits(0).stdout,
    );
    assert!(folder.run("info copy.json --json").exits(0).json()["files"][0]["format"] == "model");
}

/// Most lines of a command and its result on a large terminal.
const SCREEN: usize = 40;

#[test]
fn what_the_terminal_shows_fits_one_screen_and_begins_with_a_sentence() {
    let folder = Folder::with_panel();
    for (line, first) in [
        ("info panel.h5", "panel.h5: hdf5, mobility"),
        ("fit panel.h5 -o model.json", " sure modes explain "),
        (
            "render model.json scene.toml -o weights.json",
            "The scene is met at ",
        ),
    ] {
        let run = folder.run(line).exits(0);
        let begins = run.stdout.lines().next().unwrap_or_default();
        assert!(begins.contains(first), "{line}: {begins}");
        let lines = run.stdout.lines().count() + run.stderr.lines().count();
        assert!(lines <= SCREEN, "{lines}\n{}{}", run.stdout, run.stderr);
        let widest = run.stderr.lines().map(|line| line.chars().count()).max();
        assert!(widest.unwrap_or(0) <= 100, "{}", run.stderr);
    }
}

#[test]
fn the_options_of_reading_reach_the_result() {
    let folder = Folder::with_panel();
    folder
        .run(
            "fit panel.h5 -o model.json --band 40:350 --damping structural --frf-kind mobility \
                --force",
        )
        .exits(0);
    let model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    assert_eq!(model["band_hz"], serde_json::json!([40.0, 350.0]));
    assert_eq!(model["options"]["frf_kind"], "mobility");
    assert_eq!(model["options"]["damping"], "structural");
    // the other time sign mirrors every pole, so that the model is not trusted
    let mirrored = folder.run("fit panel.h5 --time-sign - --json");
    assert_eq!(mirrored.code, 1, "{}", mirrored.stderr);
    assert_eq!(mirrored.json()["quality"]["trusted"], false);
}

#[test]
fn the_form_of_the_polynomials_reaches_the_fit_and_its_result() {
    let folder = Folder::with_panel();
    let fitted = |flags: &str| folder.run(&format!("fit panel.h5 --method rfp {flags} --json"));
    let model = fitted("--rfp-weight sk --rfp-bands 2").json();
    assert_eq!(model["options"]["rfp_weight"], "sk");
    assert_eq!(model["options"]["rfp_bands"], 2);
    assert_eq!(model["options"]["rfp_local"], false);
    let likeliest = fitted("").json();
    assert_eq!(likeliest["options"]["rfp_weight"], "iv");
    assert_eq!(likeliest["options"]["rfp_bands"], "auto");
    let local = fitted("--rfp-local").json();
    assert_eq!(local["options"]["rfp_local"], true);
    let error = |model: &Value| model["quality"]["relative_error"].as_f64().unwrap();
    assert!(error(&local) > error(&model) && error(&model) >= error(&likeliest));
}

#[test]
fn modes_are_selected_by_hand_and_the_result_says_so() {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    let model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    let second = model["modes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|mode| mode["in_band"] == true)
        .nth(1)
        .unwrap()["frequency_hz"]
        .clone();
    folder.write(
        "selection.toml",
        format!("drop = [1]\n[[mode]]\nnear_hz = {second}\nwithin_hz = 0.1\n"),
    );
    let run = folder
        .run("select model.json selection.toml -o selected.json --json")
        .exits(0);
    assert!(
        run.said().contains("modes dropped by hand: 2"),
        "{}",
        run.stderr
    );
    let selected: Value = serde_json::from_str(&folder.text("selected.json")).unwrap();
    let count = |model: &Value| {
        model["modes"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|mode| mode["in_band"] == true)
            .count()
    };
    assert_eq!(count(&selected) + 2, count(&model));
    let names: Vec<&str> = selected["source"]
        .as_array()
        .unwrap()
        .iter()
        .map(|source| source["file"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["panel.h5", "model.json", "selection.toml"]);
    assert_eq!(selected["options"]["modes"], "auto");
    assert_eq!(selected["options"]["selections"][0]["drop"][0], 1);
    assert!(
        selected["quality"]["relative_error"].as_f64()
            > model["quality"]["relative_error"].as_f64()
    );
    // the same bytes again, and a report that still finds the FRFs
    folder
        .run("select model.json selection.toml -o again.json -q")
        .exits(0);
    assert_eq!(folder.text("selected.json"), folder.text("again.json"));
    assert_eq!(
        folder
            .run("report selected.json -o report.html --json")
            .exits(0)
            .json()["measured"],
        true
    );
}

#[test]
fn any_format_becomes_any_other() {
    let folder = Folder::with_panel();
    for extension in ["uff", "unv", "csv", "hdf5"] {
        let written = folder
            .run(&format!("convert panel.h5 -o copy.{extension} --json"))
            .exits(0)
            .json();
        assert_eq!(
            (
                &written["responses"],
                &written["references"],
                &written["lines"]
            ),
            (&24.into(), &10.into(), &381.into())
        );
        folder
            .run(&format!(
                "convert copy.{extension} -o back-{extension}.h5 -q"
            ))
            .exits(0);
    }
    let listed = folder
        .run("info --json back-uff.h5 back-csv.h5")
        .exits(0)
        .json();
    for file in listed["files"].as_array().unwrap() {
        assert_eq!(file["frf_kind"], "mobility");
        assert_eq!(file["responses"].as_array().unwrap().len(), 24);
    }
    folder.run("convert truth.json -o truth.h5").exits(0);
    folder.run("convert truth.h5 -o again.json").exits(0);
    assert_eq!(folder.text("truth.json"), folder.text("again.json"));
}

#[test]
fn the_seed_and_the_noise_can_be_chosen() {
    let folder = Folder::with_panel();
    folder
        .run("simulate panel.toml -o a.h5 --seed 7 --snr-db 20")
        .exits(0);
    folder
        .run("simulate panel.toml -o b.h5 --seed 7 --snr-db 20")
        .exits(0);
    folder
        .run("simulate panel.toml -o c.h5 --seed 8 --snr-db 20")
        .exits(0);
    assert!(
        folder.read("a.h5") == folder.read("b.h5") && folder.read("a.h5") != folder.read("c.h5")
    );
    folder
        .run("simulate panel.toml -o d.h5 --snr-db inf")
        .exits(0);
}

#[test]
fn noise_alone_has_no_mode_and_says_so() {
    let folder = Folder::new();
    // a linear congruential generator, so that the noise does not depend on a library
    let mut state = 1_u64;
    let mut draw = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut table = String::from(
        "# frf_kind = mobility\nf [Hz],1:+Z/9:+Z re [m/s/N],1:+Z/9:+Z \
                                  im,2:+Z/9:+Z re [m/s/N],2:+Z/9:+Z im\n",
    );
    for line in 0..500 {
        let values: Vec<String> = (0..4).map(|_| format!("{:.6}", draw())).collect();
        table += &format!("{},{}\n", 20.0 + 0.2 * f64::from(line), values.join(","));
    }
    folder.write("noise.csv", &table);
    let run = folder.run("fit noise.csv -o model.json --json").exits(1);
    let fit = run.json();
    let accepted = fit["modes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|mode| mode["trust"] != "rejected" && mode["in_band"] == true);
    assert_eq!(accepted.count(), 0, "{fit}");
    assert_eq!(fit["quality"]["trusted"], false);
    assert!(
        run.said().contains("no mode stands out of the noise"),
        "{}",
        run.stderr
    );
}
