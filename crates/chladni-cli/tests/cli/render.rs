//! `render`: counts, proofs, stress, sweeps and signals on the command line.

use crate::common::Folder;

/// The glass panel with driving points at few lines; its truth is the model.
fn prepared() -> Folder {
    let folder = Folder::with_glass();
    folder.write("corner.toml", scene(330, 1, ""));
    folder
}

fn scene(frequency_hz: u32, cell: usize, rest: &str) -> String {
    format!(
        "frequency_hz = {frequency_hz}\n[zones]\ngrid = [2, 2]\nhot = [{cell}]\narea_m = [0.034, 0.025, 0.234, 0.145]\n\
         cells_m = [0.0, 0.0, 0.268, 0.170]\n{rest}"
    )
}

#[test]
fn as_few_modes_and_actuators_as_the_scene_needs() {
    let folder = prepared();
    let json = folder
        .run(
            "render model.json corner.toml --modes auto --actuators auto --measured \
                           panel.h5 --json",
        )
        .exits(0)
        .json();
    assert!(
        json["modes_used"].as_u64().unwrap() <= 14 && json["actuators_used"].as_u64().unwrap() <= 9,
        "{json}"
    );
    assert_eq!(
        (&json["options"]["modes"], &json["options"]["actuators"]),
        (&"auto".into(), &"auto".into())
    );
    assert_eq!(
        json["source"].as_array().unwrap().len(),
        3,
        "the measured file is named"
    );
    let run = folder
        .run("render model.json corner.toml --modes few")
        .exits(2);
    assert!(
        run.said().contains("--modes") && run.said().contains("few"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_model_that_its_fit_does_not_trust_serves_no_scene() {
    let folder = prepared();
    let model = folder.text("model.json");
    folder.write(
        "doubted.json",
        model.replace("\"trusted\": true", "\"trusted\": false"),
    );
    folder.write("beyond.toml", scene(5000, 1, ""));
    let run = folder.run("render doubted.json corner.toml").exits(1);
    assert!(run.said().contains("the model is not to be trusted"));
    assert!(
        run.stdout.contains("but only in a model that is not"),
        "{}",
        run.stdout
    );
    folder.write(
        "burst.toml",
        scene(330, 1, "[time]\n[[time.burst]]\nduration_s = 0.1\n"),
    );
    folder
        .run("play doubted.json burst.toml --method fast")
        .exits(1);
    let run = folder.run("render model.json beyond.toml").exits(0);
    assert!(
        run.stdout.contains("only in a model of other frequencies"),
        "{}",
        run.stdout
    );
}

#[test]
fn an_impossible_scene_exits_1_with_what_is_possible_and_what_was_asked() {
    let folder = prepared();
    folder.write(
        "weak.toml",
        scene(330, 1, "[actuators]\nmax_force_n = 2e-5\n"),
    );
    let run = folder
        .run("render model.json weak.toml -o weights.json")
        .exits(1);
    assert!(
        run.said().contains("possible") && run.said().contains("asked 4.0 dB"),
        "{}",
        run.stderr
    );
    let json = folder
        .run("render model.json weak.toml --json")
        .exits(1)
        .json();
    assert!(
        json["ceiling"]["possible_db"].as_f64().unwrap()
            < json["ceiling"]["asked_db"].as_f64().unwrap(),
        "{json}"
    );
    folder.run("report weights.json -o report.html -q").exits(0);
}

/// Few modes serve the drive of all actuators; the drive of the few that are chosen then needs more.
#[test]
fn fewer_actuators_take_the_modes_that_they_need() {
    let folder = prepared();
    for (hz, cell) in [(320, 4), (340, 1)] {
        let zones = format!("[zones]\ngrid = [2, 2]\nhot = [{cell}]\n");
        folder.write("scene.toml", format!("frequency_hz = {hz}\n{zones}"));
        let line = "render model.json scene.toml --modes auto --actuators auto --json";
        let json = folder.run(line).exits(0).json();
        assert_eq!(json["indices"]["points"]["success_ratio"], 1.0, "{json}");
        assert!(json["actuators_used"].as_u64().unwrap() < 34, "{json}");
    }
}

/// A zone that is to be 20 dB louder than the limit, which no drive of 1 mN makes.
#[test]
fn a_louder_zone_is_felt_from_its_own_level_on() {
    let folder = prepared();
    let corners = "[[0.03, 0.02], [0.14, 0.02], [0.14, 0.09], [0.03, 0.09]]";
    let zone = format!("[[zones.polygon]]\nkind = \"hot\"\npoints_m = {corners}\nlevel_db = 20\n");
    let scene = format!("frequency_hz = 330\n{zone}[actuators]\nmax_force_n = 0.001\n");
    folder.write("scene.toml", scene);
    let line = "render model.json scene.toml -o weights.json";
    let run = folder.run(line).exits(1);
    assert!(
        run.stdout.contains("hot ground felt       0 of 8"),
        "{}",
        run.stdout
    );
    assert!(
        run.said().contains("as strong as [actuators] allows"),
        "{}",
        run.said()
    );
    folder
        .run("report model.json weights.json -o report.html --charts charts -q")
        .exits(0);
    let field = folder.text("charts/field-1.svg");
    assert!(field.contains("above +2.0 dB, in the loudest zone above +22.0 dB"));
    assert!(!field.contains("felt as wished"));
}

/// The suggestion of a sweep where no frequency serves the scene is no next step.
#[test]
fn a_frequency_that_does_not_serve_is_not_suggested() {
    let folder = prepared();
    let rest = "transition_m = 0.0\n[actuators]\nmax_force_n = 1e-4\n";
    folder.write("scene.toml", scene(330, 1, rest));
    let run = folder
        .run("render model.json scene.toml --sweep 326:334")
        .exits(1);
    assert!(
        run.stdout.contains("no frequency serves every response; "),
        "{}",
        run.stdout
    );
    assert!(!run.said().contains("set frequency_hz"), "{}", run.said());
}

#[test]
fn stress_sweep_and_signals() {
    let folder = prepared();
    let line = "render model.json corner.toml -o weights.json --stress --seed 3 --sweep 326:334 \
                --wav drive.wav";
    let run = folder.run(line).exits(0);
    for words in [
        "a finger in the hot zone",
        "one dead actuator",
        "suggested: ",
        "standard deviations",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let json = folder
        .run(&format!("{line} --force --json"))
        .exits(0)
        .json();
    assert_eq!(
        (
            json["sweep"]["frequencies"].as_array().unwrap().len(),
            &json["options"]["stress_seed"]
        ),
        (5, &3.into())
    );
    assert_eq!(
        &std::fs::read(folder.path().join("drive.wav")).unwrap()[..4],
        b"RIFF"
    );
    folder
        .run("render model.json corner.toml --wav drive.csv -q")
        .exits(0);
    assert!(folder
        .text("drive.csv")
        .starts_with("reference,frequency_hz,amplitude_peak,phase_deg,unit\n101:+Z,330,"));
    assert!(folder
        .run("render model.json corner.toml --wav drive.mp3")
        .exits(2)
        .stderr
        .contains(".wav"));
    assert!(folder
        .run("render model.json corner.toml --sweep 300")
        .exits(2)
        .stderr
        .contains("LO:HI"));
    folder
        .run("evaluate weights.json --scene corner.toml --on panel.h5 -q")
        .exits(0);
}

#[test]
fn a_fit_for_a_scene_takes_only_the_band_that_it_needs() {
    let folder = Folder::new();
    folder.write(
        "panel.toml",
        "[responses]\ngrid = [6, 4]\nspacing_m = \
                                0.04\n[references]\nedge_count = [3, 2]\n[frf]\nstop_hz = 700\n",
    );
    folder.write("corner.toml", scene(300, 1, ""));
    folder
        .run("simulate panel.toml -o panel.h5 --truth truth.json -q")
        .exits(0);
    let json = folder
        .run("fit panel.h5 -o part.json --scene corner.toml --json")
        .exits(0)
        .json();
    let band: Vec<f64> = json["options"]["band_hz"]
        .as_array()
        .unwrap()
        .iter()
        .map(|hz| hz.as_f64().unwrap())
        .collect();
    assert!(
        band[0] > 20.0 && band[0] < 290.0 && band[1] > 310.0 && band[1] < 690.0,
        "{band:?}"
    );
    let said = json["findings"].to_string();
    assert!(
        said.contains("what corner.toml needs at 300 Hz")
            && said.contains("stand as residual terms"),
        "{said}"
    );
    assert_eq!(
        json["source"].as_array().unwrap().len(),
        2,
        "the scene is named"
    );
    // the drive serves as much in the whole truth as in the model of a part of the band
    folder.run("render part.json corner.toml -o weights.json -q");
    let on = |model: &str| {
        folder
            .run(&format!(
                "evaluate weights.json --scene corner.toml --on {model} --json"
            ))
            .exits(0)
            .json()
    };
    let ratio =
        |json: &serde_json::Value| json["indices"]["points"]["success_ratio"].as_f64().unwrap();
    let (own, truth) = (ratio(&on("part.json")), ratio(&on("truth.json")));
    assert!(
        (own - truth).abs() <= 0.1,
        "{own} in its model, {truth} in truth"
    );
    assert!(folder
        .run("fit panel.h5 --scene corner.toml --band 100:500")
        .exits(2)
        .stderr
        .contains("--band"));
}

#[test]
fn actuators_are_chosen_for_several_scenes() {
    let folder = prepared();
    folder.write("other.toml", scene(330, 4, ""));
    let weights = |line: &str| {
        folder
            .run(&format!("render model.json {line} --actuators auto --json"))
            .exits(0)
            .json()
    };
    let used = |json: &serde_json::Value| -> Vec<String> {
        let driven = json["weights"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|weight| weight["amplitude"].as_f64().unwrap() > 0.0);
        driven
            .map(|weight| weight["reference"].to_string())
            .collect()
    };
    let (first, second) = (
        weights("corner.toml --also other.toml"),
        weights("other.toml --also corner.toml"),
    );
    assert_eq!(used(&first), used(&second));
    assert_eq!(
        (
            &first["options"]["also"][0],
            first["source"].as_array().unwrap().len()
        ),
        (&"other.toml".into(), 3)
    );
    folder.write(
        "fewer.toml",
        scene(330, 4, "[actuators]\nuse = [\"101:+Z\", \"102:+Z\"]\n"),
    );
    let run = folder
        .run("render model.json corner.toml --also fewer.toml --actuators auto")
        .exits(65);
    assert!(
        run.stderr.contains("the scenes allow different actuators"),
        "{}",
        run.stderr
    );
}

#[test]
fn several_tones_are_rendered_judged_and_reported_one_by_one() {
    let folder = prepared();
    folder.write("chord.toml", scene(330, 1, "").replace("330", "[330, 350]"));
    let json = folder
        .run("render model.json chord.toml -o weights.json --method mls --wav drive.csv --json")
        .json();
    assert_eq!(
        (
            json["frequency_hz"].as_f64(),
            json["other_tones"][0]["frequency_hz"].as_f64()
        ),
        (Some(330.0), Some(350.0))
    );
    assert_eq!(folder.text("drive.csv").lines().count(), 1 + 2 * 34);
    folder
        .run("convert model.json weights.json -o fields.unv")
        .exits(0);
    let text = folder.text("fields.unv");
    for tone in ["Velocity at 330 Hz", "Velocity at 350 Hz"] {
        assert!(text.contains(tone), "{tone}");
    }
    folder
        .run("evaluate weights.json --scene chord.toml --on panel.h5 -q")
        .exits(0);
    let judged = folder
        .run("evaluate weights.json --scene chord.toml --on model.json --json")
        .exits(0)
        .json();
    let limit =
        |tone: &serde_json::Value, name: &str| tone["limits_m_per_s"][name].as_f64().unwrap();
    // two tones share the limit of cold ground; each is felt by itself
    for (tone, rendered) in [
        (&judged, &json),
        (&judged["other_tones"][0], &json["other_tones"][0]),
    ] {
        let ratio = limit(tone, "hot") / limit(tone, "cold");
        assert!(
            (20.0 * ratio.log10() - 4.0 - 10.0 * 2f64.log10()).abs() < 1e-9,
            "{tone}"
        );
        assert_eq!(
            tone["indices"]["points"]["success_ratio"],
            rendered["indices"]["points"]["success_ratio"]
        );
    }
    let report = folder
        .run("report model.json weights.json -o report.html --json")
        .exits(0)
        .json();
    assert_eq!(report["scenes"], 2);
    assert!(folder.text("report.html").contains("chord.toml, 350 Hz"));
    assert!(folder
        .run("render model.json chord.toml --sweep 300:310")
        .exits(2)
        .stderr
        .contains("one frequency"));
}

#[test]
fn fingers_are_tolerated_and_a_better_frequency_is_one_flag() {
    let folder = prepared();
    folder.write("scene.toml", scene(300, 1, "[touch]\n"));
    let run = folder
        .run("render model.json scene.toml --frequency auto --sweep 328:332 -o w.json --json")
        .exits(0);
    let json = run.json();
    let frequency_hz = json["frequency_hz"].as_f64().unwrap();
    assert!((328.0..=332.0).contains(&frequency_hz), "{json}");
    assert_eq!(json["sweep"]["suggested_hz"], json["frequency_hz"]);
    assert!(json["sweep"]["frequencies"][0]["touched_kappa"].is_number());
    assert_eq!(json["touch"]["firmest"], "mid", "{}", json["touch"]);
    assert!(json["touch"]["points"]["min_ratio"].as_f64().unwrap() >= 0.9);
    let run = folder
        .run("render model.json scene.toml --frequency 330")
        .exits(0);
    assert!(run.stdout.contains("tolerates fingers") && run.stdout.contains("up to mid"));
    for (flags, words) in [
        ("--frequency loud", "neither `auto`"),
        ("--frequency -3", ""),
    ] {
        let run = folder
            .run(&format!("render model.json scene.toml {flags}"))
            .exits(2);
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
}

#[test]
fn one_frequency_does_not_replace_several_tones() {
    let folder = prepared();
    let chord = scene(330, 1, "").replace("= 330", "= [330.0, 335.0]");
    folder.write("chord.toml", chord);
    let run = folder
        .run("render model.json chord.toml --frequency 335 -o w.json")
        .exits(2);
    assert!(run.stderr.contains("several tones"), "{}", run.stderr);
}

#[test]
fn a_cut_off_is_of_method_modal_alone() {
    let folder = prepared();
    let run = folder
        .run("render model.json corner.toml --cut 0.1")
        .exits(2);
    assert!(run.stderr.contains("--method modal"), "{}", run.stderr);
}

#[test]
fn options_that_do_not_reach_a_sweep_or_other_scenes_are_said() {
    let folder = prepared();
    let json = |options: &str| {
        let line = format!("render model.json corner.toml --sweep 328:330 --json {options}");
        folder.run(&line).json()["findings"].to_string()
    };
    assert!(!json("").contains("sweep-of-all"));
    assert!(json("--actuators 20").contains("sweep-of-all"));
    assert!(json("--also corner.toml").contains("also-of-all"));
}

#[test]
fn a_sweep_that_suggests_no_frequency_says_why_the_scene_keeps_its_own() {
    let folder = prepared();
    let run = folder.run("render model.json corner.toml --frequency auto --sweep 2000:2010");
    let hint = "no frequency of the sweep lies in the fitted band";
    assert!(run.stdout.contains(hint), "{}", run.stdout);
    let words = "keeps its frequency of 330 Hz: no frequency from 2000 to 2010 Hz lies in";
    assert!(run.said().contains(words), "{}", run.said());
}

#[test]
fn weights_are_not_written_where_their_signal_cannot_be_made() {
    let folder = prepared();
    let path = "[time]\n[[time.move]]\npath_m = [[0.07, 0.08], [9.0, 0.08]]\n\
                speed_m_per_s = 0.1\nhot_radius_m = 0.025\nquiet_from_m = 0.06\n";
    folder.write("away.toml", scene(330, 1, path));
    folder
        .run("render model.json away.toml --method mls -o w.json --wav d.wav")
        .exits(65);
    assert!(!folder.names().contains(&"w.json".to_owned()));
}

#[test]
fn a_sweep_says_its_method_and_unit_and_is_not_proposed_for_two_tones() {
    let folder = prepared();
    let swept = folder.run("render model.json corner.toml --sweep 328:330");
    for words in ["by method mls", "largest drive, N"] {
        assert!(swept.stdout.contains(words), "{}", swept.stdout);
    }
    let two = scene(330, 1, "").replace("330", "[260.0, 335.0]");
    folder.write("two.toml", two);
    folder.write("report.html", "");
    let said = folder.run("render model.json two.toml -o w.json").said();
    let next = said.split("Next: ").nth(1).unwrap_or_default();
    assert!(
        next.starts_with("chladni report model.json w.json -o report.html --force"),
        "{said}"
    );
}
