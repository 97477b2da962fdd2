//! `play`: drive signals on the command line, and their performance on other data.

use crate::common::Folder;
use serde_json::Value;

const ZONES: &str = "frequency_hz = 330\n[zones]\ngrid = [2, 2]\nhot = [1]\narea_m = [0.034, 0.025, 0.234, 0.145]\n\
                     cells_m = [0.0, 0.0, 0.268, 0.170]\n";
const BURSTS: &str = "[time]\n[[time.burst]]\nduration_s = 0.1\nrepeat = [2, 0.15]\n";

/// The glass panel at few lines from below its lowest mode; its truth is the model.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write(
        "panel.toml",
        "[frf]\nstart_hz = 2\nstop_hz = 1000\nstep_hz = 99.8\n",
    );
    folder
        .run("simulate panel.toml -o panel.h5 --truth model.json -q")
        .exits(0);
    folder.write("burst.toml", format!("{ZONES}{BURSTS}"));
    folder
}

#[test]
fn bursts_become_a_sound_file_that_is_judged_again_from_its_samples() {
    let folder = prepared();
    folder
        .run("render model.json burst.toml -o weights.json -q")
        .exits(0);
    let played = folder
        .run("play model.json burst.toml --weights weights.json -o drive.wav --format i24 --json")
        .exits(0)
        .json();
    let time = &played["time"];
    let findings = played["findings"].as_array().unwrap();
    let short = |finding: &Value| finding["code"] == "time-burst-short";
    assert!(findings.iter().any(short), "{played}");
    assert!(
        time["ramp_s"].as_f64().unwrap() <= 0.0101 && time["peak"]["ever_over_ratio"] == 0.0,
        "{time}"
    );
    let wav = folder.read("drive.wav");
    let word = |at: usize| u16::from_le_bytes([wav[at], wav[at + 1]]);
    let long = |at: usize| u32::from_le_bytes([wav[at], wav[at + 1], wav[at + 2], wav[at + 3]]);
    assert_eq!(
        (word(20), word(22), long(24), word(34), long(40)),
        (0xFFFE, 34, 48_000, 24, 0),
        "extensible, 34 channels, 48 kHz, 24 bits, no loudspeaker"
    );
    let sidecar: Value = serde_json::from_str(&folder.text("drive.json")).unwrap();
    assert_eq!(
        (
            &sidecar["format"],
            &sidecar["rate_hz"],
            &sidecar["channels"][33]["reference"]
        ),
        (&"chladni.signal".into(), &48_000.into(), &"134:+Z".into())
    );
    assert_eq!(sidecar["source"].as_array().unwrap().len(), 3);
    // three cycles of the carrier in a ramp; with fewer the peaks do not show the envelope
    folder.write("ten.toml", format!("{ZONES}{BURSTS}ramp_s = 0.01\n"));
    let ten = folder
        .run("play model.json ten.toml --weights weights.json -o ten.wav --format i24 --json")
        .exits(0)
        .json();
    let again = folder
        .run("evaluate ten.wav --scene ten.toml --on model.json --json")
        .exits(0)
        .json();
    for (measure, key) in [("peak", "worst_cold_db"), ("summed", "worst_hot_db")] {
        let of = |json: &Value| json["time"][measure][key].as_f64().unwrap();
        assert!((of(&again) - of(&ten)).abs() < 0.1, "{again} {ten}");
    }
    let steady = folder
        .run("evaluate weights.json --scene burst.toml --on model.json --json")
        .exits(0)
        .json();
    assert_eq!(&steady["time"], time, "weights with ramps");
    let text = folder
        .run("play model.json burst.toml --weights weights.json")
        .exits(0)
        .stdout;
    assert!(
        text.contains("hot after") && text.contains("cold never over"),
        "{text}"
    );
}

#[test]
fn a_sound_file_beside_the_sidecar_of_another_run_is_refused() {
    let folder = prepared();
    folder
        .run("play model.json burst.toml -o drive.wav -q")
        .exits(0);
    let text = folder.text("drive.json");
    for (key, other) in [("frames", "24001"), ("rate_hz", "44100")] {
        let mut sidecar: Value = serde_json::from_str(&text).unwrap();
        sidecar[key] = serde_json::from_str(other).unwrap();
        folder.write("drive.json", sidecar.to_string());
        let run = folder
            .run("evaluate drive.wav --scene burst.toml --on model.json")
            .exits(65);
        let said = run.stderr;
        let all = [key, other, "drive.wav", "of different runs"];
        assert!(all.iter().all(|part| said.contains(part)), "{said}");
    }
    folder.write("drive.json", folder.text("model.json"));
    let run = folder
        .run("evaluate drive.wav --scene burst.toml --on model.json")
        .exits(65);
    let said = run.stderr;
    let all = ["drive.json", "a model, not the sidecar of a signal"];
    assert!(all.iter().all(|part| said.contains(part)), "{said}");
}

#[test]
fn a_drive_in_time_is_tried_on_panels_that_differ_and_under_fingers() {
    let folder = prepared();
    let command = "play model.json burst.toml --method mls --stress --json";
    let run = || folder.run(command).json();
    let json = run();
    let rows = json["stress"].as_array().unwrap();
    let of = |trial: &str| {
        let row = rows.iter().find(|row| row["trial"] == trial);
        row.unwrap_or_else(|| panic!("{trial}: {json}"))
    };
    let level = |trial: &str| of(trial)["worst_cold_db"].as_f64().unwrap();
    let near = (level("none") - json["time"]["peak"]["worst_cold_db"].as_f64().unwrap()).abs();
    assert!(near < 1e-9, "{json}");
    assert!(level("drift") < level("none") + 0.6, "{json}");
    assert!(
        level("one reversed actuator") > level("none") + 1.0,
        "{json}"
    );
    assert_eq!(of("a finger that comes and goes")["cases"], 40);
    assert_eq!(of("a finger in the hot zone")["cases"], 3);
    assert_eq!(run()["stress"], json["stress"], "one seed, one table");
}

#[test]
fn plain_ramps_exit_with_1_by_the_strict_measure() {
    let folder = prepared();
    let strict = BURSTS.replace("[time]", "[time]\nmeasure = \"peak\"");
    folder.write(
        "strict.toml",
        format!(
            "{ZONES}{}",
            strict.replace("duration_s", "ramp_s = 0.01\nduration_s")
        ),
    );
    folder
        .run("play model.json strict.toml --method mls -o modal.npz --charts figures -q")
        .exits(0);
    assert!(folder.read("figures/time.gif").starts_with(b"GIF89a"));
    assert!(folder.text("figures/time.svg").contains("Drives"));
    let run = folder
        .run("play model.json strict.toml --method mls --ramps plain -o plain.csv")
        .exits(1);
    assert!(run.stderr.contains("over its limit"), "{}", run.stderr);
    let csv = folder.text("plain.csv");
    assert!(
        csv.starts_with("time_s,101:+Z [N],102:+Z [N]"),
        "{}",
        &csv[..80]
    );
    assert_eq!(csv.lines().count(), 1 + 12_001);
    assert!(folder.read("modal.npz").starts_with(b"PK"));
}

#[test]
fn signals_that_cannot_be_are_refused_before_anything_is_written() {
    let folder = prepared();
    folder.write("map.csv", "channel,reference,gain\n1,101:+Z,1\n");
    folder.write(
        "bad.toml",
        format!("{ZONES}[time]\n[[time.burst]]\nduration_s = -1\n"),
    );
    folder.write(
        "fast.toml",
        format!("{ZONES}[time]\n[[time.burst]]\nduration_s = 0.1\nramp_s = 0.001\n"),
    );
    for (line, code, words) in [
        ("burst.toml -o drive.mp3", 2, ".wav"),
        ("burst.toml -o drive.wav --rate 600", 2, "--rate"),
        // above twice the tone, but too low for its ramps of 9 ms
        ("burst.toml -o drive.wav --rate 700", 2, "with its ramps"),
        ("burst.toml -o drive.wav --full-scale 1e-9", 2, "clips"),
        ("burst.toml -o drive.wav --full-scale -1", 2, "auto"),
        // nearly silence
        (
            "burst.toml -o drive.wav --full-scale 100 --format i16",
            2,
            "steps of i16",
        ),
        ("burst.toml -o drive.wav --format i8", 2, "i16"),
        (
            "burst.toml -o drive.wav --channel-map map.csv",
            65,
            "lacks an actuator",
        ),
        ("bad.toml -o drive.wav", 65, "duration_s"),
        ("fast.toml -o drive.wav", 65, "ramp_s"),
    ] {
        let run = folder
            .run(&format!("play model.json {line} --method fast"))
            .exits(code);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
    let names = folder.names();
    assert!(
        names
            .iter()
            .all(|name| !name.starts_with("drive") && !name.contains("tmp")),
        "{names:?}"
    );
    folder
        .run("play model.json burst.toml --method fast -o drive.wav -q")
        .exits(1);
    folder.write("drive.json", "{}");
    let run = folder
        .run("evaluate drive.wav --scene burst.toml --on model.json")
        .exits(65);
    assert!(run.stderr.contains("drive.json"), "{}", run.stderr);
}

/// A spot that moves along x as far as `x`.
fn spot(start_s: f64, x: f64) -> String {
    format!(
        "[[time.move]]\nstart_s = {start_s}\npath_m = [[0.07, 0.085], [{x}, 0.085]]\n\
         speed_m_per_s = 0.2\nhot_radius_m = 0.025\nquiet_from_m = 0.06\n"
    )
}

#[test]
fn tables_that_cannot_be_are_refused_by_name_and_line() {
    let folder = prepared();
    let burst = |more: &str| format!("[[time.burst]]\nduration_s = 0.1\n{more}\n");
    let negative = |key: &str| spot(0.0, 0.198).replace(key, &format!("{key} = -1 #"));
    for (name, table, named) in [
        (
            "duration",
            "[[time.burst]]\nduration_s = -0.1\n".into(),
            "duration_s",
        ),
        ("start", burst("start_s = -1"), "start_s"),
        ("ramp", burst("ramp_s = -0.01"), "ramp_s"),
        ("period", burst("repeat = [2, -0.2]"), "repeat"),
        (
            "fade",
            "[[time.fade]]\nfrom = [1]\nto = [2]\nstart_s = 1\nfade_s = -0.05\n".into(),
            "fade_s",
        ),
        ("speed", negative("speed_m_per_s"), "speed_m_per_s"),
        (
            "summation",
            format!("summation_s = -0.2\n{}", burst("")),
            "summation_s",
        ),
        (
            "moves",
            spot(0.0, 0.198) + &spot(0.3, 0.198),
            "[[time.move]] 2",
        ),
        (
            "mixed",
            burst("start_s = 0.2") + &spot(0.0, 0.198),
            "overlap",
        ),
        ("path", spot(0.0, 0.26), "path_m"),
        ("late", burst("").replace("0.1", "1e6"), "[[time.burst]] 1"),
        (
            "all",
            burst("hot = [1, 2, 3, 4]"),
            "[[time.burst]] 1 hot: no response is left to keep quiet",
        ),
    ] {
        let file = format!("{name}.toml");
        folder.write(&file, format!("{ZONES}[time]\n{table}"));
        let run = folder
            .run(&format!(
                "play model.json {file} --method fast -o drive.wav"
            ))
            .exits(65);
        let said = &run.stderr;
        assert!(
            said.contains(named) && said.contains(&file),
            "{name}: {said}"
        );
        assert!(said.contains("line "), "{name}: {said}");
    }
    assert!(folder.names().iter().all(|name| !name.starts_with("drive")));
}

#[test]
fn a_path_beyond_the_responses_is_refused_where_they_alone_bound_the_judged_ground() {
    let folder = prepared();
    let zones = ZONES.replace("area_m", "#");
    folder.write(
        "scanned.toml",
        format!("{zones}[time]\n{}", spot(0.0, 0.26)),
    );
    let run = folder
        .run("play model.json scanned.toml --method fast -o drive.wav")
        .exits(65);
    assert!(
        run.stderr.contains("[[time.move]] 1 path_m"),
        "{}",
        run.stderr
    );
    assert!(folder.names().iter().all(|name| !name.starts_with("drive")));
}

#[test]
fn volts_per_newton_of_each_channel_are_in_the_samples_and_beside_them() {
    let folder = prepared();
    let gain = |channel: usize| 2.0 + 0.1 * channel as f64;
    let rows = (1..=34).map(|k| format!("{k},{}:+Z,{}\n", 100 + k, gain(k)));
    let map = rows.fold("channel,reference,gain\n".to_owned(), |all, row| all + &row);
    folder.write("dac.csv", map);
    let command = "play model.json burst.toml --method fast -q -o";
    folder.run(&format!("{command} newtons.csv")).exits(1);
    folder
        .run(&format!(
            "{command} volts.wav --channel-map dac.csv --full-scale 0.5"
        ))
        .exits(1);
    let sidecar: Value = serde_json::from_str(&folder.text("volts.json")).unwrap();
    for (k, channel) in sidecar["channels"].as_array().unwrap().iter().enumerate() {
        let of = |key: &str| channel[key].as_f64().unwrap();
        assert!((of("gain") - gain(k + 1)).abs() < 1e-12, "{channel}");
        // full scale is 0.5 V, for any force
        assert!(
            (of("full_scale") * of("gain") - 0.5).abs() < 1e-12,
            "{channel}"
        );
        assert_eq!(channel["unit"], "N");
    }
    let wav = folder.read("volts.wav");
    let data = wav.windows(4).position(|id| id == b"data").unwrap() + 8;
    let samples: Vec<f64> = wav[data..]
        .chunks_exact(4)
        .map(|bytes| f64::from(f32::from_le_bytes(bytes.try_into().unwrap())))
        .collect();
    let newtons: Vec<Vec<f64>> = folder
        .text("newtons.csv")
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .skip(1)
                .map(|v| v.parse().unwrap())
                .collect()
        })
        .collect();
    assert_eq!(samples.len(), 34 * newtons.len());
    let mut most: f64 = 0.0;
    for (frame, forces) in samples.chunks_exact(34).zip(&newtons) {
        for (k, (sample, force)) in frame.iter().zip(forces).enumerate() {
            let volts = force * gain(k + 1);
            assert!((0.5 * sample - volts).abs() < 1e-7, "channel {}", k + 1);
            most = most.max(volts.abs());
        }
    }
    assert!(most > 1e-4, "{most} V");
}

#[test]
fn what_is_wrong_is_said_of_its_own_file_and_a_folder_before_the_work() {
    let folder = prepared();
    folder
        .run("render model.json burst.toml -o weights.json -q")
        .exits(0);
    let run = folder
        .run("play model.json burst.toml -o drive.wav --charts burst.toml")
        .exits(73);
    assert!(run.said().contains("--charts"), "{}", run.stderr);
    assert!(!folder.names().contains(&"drive.wav".to_owned()));
    let weights = folder.text("weights.json");
    folder.write(
        "volts.json",
        weights.replace("\"unit\": \"N\"", "\"unit\": \"V\""),
    );
    folder.write("dac.csv", "channel,reference\n1,101:+Z\n");
    for (options, words) in [
        (
            "--weights volts.json",
            ["volts.json", "have different units"],
        ),
        (
            "--method fast --channel-map dac.csv",
            ["dac.csv", "lacks an actuator of the drive"],
        ),
    ] {
        let run = folder.run(&format!("play model.json burst.toml {options}"));
        let said = run.exits(65).said();
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
}

#[test]
fn a_steady_tone_is_played_by_the_weights_that_render_finds() {
    let folder = Folder::new();
    folder.write(
        "panel.toml",
        "[responses]\ngrid = [2, 1]\nspacing_m = 0.1\nat_references = true\n\
         [references]\nedge_count = [1, 1]\n[frf]\nstop_hz = 100.0\nstep_hz = 9.8\n",
    );
    folder
        .run("simulate panel.toml -o panel.h5 --truth model.json -q")
        .exits(0);
    folder.write(
        "scene.toml",
        "frequency_hz = 60.0\n[zones]\ngrid = [2, 1]\nhot = [1]\n",
    );
    folder
        .run("render model.json scene.toml -o weights.json -q")
        .exits(0);
    let [given, own] = ["--weights weights.json", ""].map(|weights| {
        let run = folder.run(&format!("play model.json scene.toml {weights} --json"));
        run.exits(0).json()["time"].clone()
    });
    assert_eq!(given, own);
}
