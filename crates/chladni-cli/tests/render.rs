//! `render`: counts, proofs, stress, sweeps and signals on the command line.

mod common;

use common::Folder;

/// The glass panel with driving points at few lines; its truth is the model.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("panel.toml", "[responses]\nat_references = true\n[frf]\nstart_hz = 100\nstop_hz = 1000\nstep_hz = 10\n");
    folder.run("simulate panel.toml -o panel.h5 --truth model.json -q").exits(0);
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
    let json = folder.run("render model.json corner.toml --modes auto --actuators auto --measured panel.h5 --json").exits(0).json();
    assert!(json["modes_used"].as_u64().unwrap() <= 14 && json["actuators_used"].as_u64().unwrap() <= 9, "{json}");
    assert_eq!((&json["options"]["modes"], &json["options"]["actuators"]), (&"auto".into(), &"auto".into()));
    assert_eq!(json["source"].as_array().unwrap().len(), 3, "the measured file is named");
    let run = folder.run("render model.json corner.toml --modes few").exits(2);
    assert!(run.stderr.contains("--modes") && run.stderr.contains("few"), "{}", run.stderr);
}

#[test]
fn an_impossible_scene_exits_1_with_what_is_possible_and_what_was_asked() {
    let folder = prepared();
    folder.write("weak.toml", scene(330, 1, "[actuators]\nmax_force_n = 2e-5\n"));
    let run = folder.run("render model.json weak.toml -o weights.json").exits(1);
    assert!(run.stderr.contains("possible") && run.stderr.contains("asked 4.0 dB"), "{}", run.stderr);
    let json = folder.run("render model.json weak.toml --json").exits(1).json();
    assert!(json["ceiling"]["possible_db"].as_f64().unwrap() < json["ceiling"]["asked_db"].as_f64().unwrap(), "{json}");
    folder.run("report weights.json -o report.html -q").exits(0);
}

#[test]
fn stress_sweep_and_signals() {
    let folder = prepared();
    let line = "render model.json corner.toml -o weights.json --stress --seed 3 --sweep 326:334 --wav drive.wav";
    let run = folder.run(line).exits(0);
    for words in ["a finger in the hot zone", "one dead actuator", "suggested: ", "standard deviations"] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let json = folder.run(&format!("{line} --force --json")).exits(0).json();
    assert_eq!((json["sweep"]["frequencies"].as_array().unwrap().len(), &json["options"]["stress_seed"]), (5, &3.into()));
    assert_eq!(&std::fs::read(folder.path().join("drive.wav")).unwrap()[..4], b"RIFF");
    folder.run("render model.json corner.toml --wav drive.csv -q").exits(0);
    assert!(folder.text("drive.csv").starts_with("reference,frequency_hz,amplitude_peak,phase_deg,unit\n101:+Z,330,"));
    assert!(folder.run("render model.json corner.toml --wav drive.mp3").exits(2).stderr.contains(".wav"));
    assert!(folder.run("render model.json corner.toml --sweep 300").exits(2).stderr.contains("LO:HI"));
    folder.run("evaluate weights.json --scene corner.toml --on panel.h5 -q").exits(0);
}
