//! The commands that the studio shows, followed: they write its models and weights, to the last
//! byte, and it takes fields that were measured under them.

use crate::common::studio::Studio;
use crate::common::Folder;
use crate::measured_studio::{downloaded, SAVED};
use crate::workbench::{workbench, AT_REST};
use serde_json::{json, Value};

/// Work in the studio.
struct Work {
    /// Arguments of the studio.
    args: &'static [&'static str],
    /// Settings of the fit.
    fit: Value,
    /// Content of `selection.toml`; empty where no mode is dropped.
    selection: &'static str,
    method: &'static str,
    /// Number of fields that are measured.
    fields: usize,
}

/// Runs a command of the page; empty ones are left out.
fn follow(folder: &Folder, command: &Value) {
    let command = command.as_str().unwrap();
    if let Some(line) = command.strip_prefix("chladni ") {
        let force = if line.starts_with("evaluate") {
            ""
        } else {
            " --force"
        };
        // a scene that is not met is a result
        let run = folder.run(&format!("{line}{force} -q"));
        assert!(run.code <= 1, "{command}: {}", run.stderr);
    }
}

impl Work {
    /// The work in a folder; `panel.h5` is also in its folder `scans`.
    fn is_followed(&self) {
        let folder = Folder::with_panel();
        std::fs::create_dir(folder.path().join("scans")).unwrap();
        folder.write("scans/panel.h5", folder.read("panel.h5"));
        folder.write("scans/notes.txt", "of no use here\n");
        let studio = Studio::start(&folder, self.args);
        let about = |what: &str, question: &Value| {
            let said = studio.asked_about(what, &question.to_string());
            assert!(said["error"].is_null(), "{what}: {said}");
            said
        };
        let scene = json!({"toml": folder.text("scene.toml"), "method": self.method, "selection": self.selection});
        let is_the_same = |file: &str, name: &str, fields: &[Value]| {
            let question = json!({"name": name, "selection": self.selection, "scene": scene, "fields": fields}).to_string();
            let answer = studio.asked_bytes(&studio.head("file", &question), &question);
            let split = answer
                .windows(4)
                .position(|four| four == b"\r\n\r\n")
                .unwrap();
            let same = answer[split + 4..] == folder.read(file);
            assert!(same, "{:?}, {}: {file}", self.args, self.method);
        };
        let fit = about("fit", &self.fit);
        follow(&folder, &fit["command"]);
        folder.write("added.toml", fit["added"]["toml"].as_str().unwrap());
        follow(&folder, &fit["added"]["command"]);
        let mut model = fit["model_file"].as_str().unwrap().to_owned();
        if !self.selection.is_empty() {
            folder.write("selection.toml", self.selection);
            follow(
                &folder,
                &format!("chladni select {model} selection.toml -o selected.json").into(),
            );
            model = "selected.json".into();
        }
        if !self.args.contains(&model.as_str()) {
            is_the_same(&model, "model.json", &[]);
        }
        follow(&folder, &about("scene", &scene)["command"]);
        is_the_same("weights.json", "weights.json", &[]);
        let (mut fields, mut weights) = (Vec::new(), "weights.json".to_owned());
        for number in 1..=self.fields {
            let name = format!("field-{number}.csv");
            folder
                .run(&format!(
                    "simulate panel.toml --play {weights} -o {name} --snr-db 40 --seed 3 -q"
                ))
                .exits(0);
            assert!(folder.text(&name).contains("weights_sha256"));
            fields.push(json!({"name": name, "csv": folder.text(&name)}));
            let question = json!({"scene": scene, "fields": fields});
            follow(&folder, &about("measured", &question)["command"]);
            follow(&folder, &about("correct", &question)["command"]);
            weights = format!("weights-{number}.json");
            is_the_same(&weights, "weights.json", &fields);
            is_the_same("calibration.json", "calibration.json", &fields);
        }
    }
}

impl Default for Work {
    fn default() -> Self {
        Self {
            args: &["truth.json"],
            fit: json!({"number": 1}),
            selection: "",
            method: "mls",
            fields: 1,
        }
    }
}

/// A fit without some of the modes, and one of these added.
fn with_added() -> Value {
    json!({"number": 1, "modes": 10, "added_hz": [383.6]})
}

#[test]
fn every_method_gives_the_weights_of_its_command_before_and_after_two_fields() {
    for method in ["mls", "robust", "best"] {
        let work = Work {
            method,
            fields: 2,
            ..Work::default()
        };
        work.is_followed();
    }
}

#[test]
fn a_fit_and_an_opened_model_are_followed_with_dropped_modes_too() {
    for (args, selection) in [
        (&["panel.h5"][..], ""),
        // an option of reading, which the model tells
        (&["panel.h5", "--frf-kind", "mobility"], "keep = \"sure\"\n"),
        (&["truth.json"], "# 2: 100 Hz\ndrop = [2]\n"),
    ] {
        Work {
            args,
            selection,
            ..Work::default()
        }
        .is_followed();
    }
}

#[test]
fn modes_added_by_hand_are_followed_with_dropped_modes_too() {
    for (args, selection) in [
        (&["panel.h5"][..], ""),
        // FRFs that do not lie beside the model, in a folder with another file
        (&["scans", "--frf-kind", "mobility"], "drop = [2]\n"),
    ] {
        Work {
            args,
            selection,
            fit: with_added(),
            ..Work::default()
        }
        .is_followed();
    }
}

/// The same through the page: its texts are saved as files, its commands are run.
#[test]
fn the_texts_and_commands_on_the_page_give_its_weights() {
    let Some((folder, _studio, mut page)) = workbench("panel.h5") else {
        return;
    };
    page.eval(SAVED);
    page.eval("(() => { const i = document.querySelector('#modes'); i.value = 10; i.dispatchEvent(new Event('change')); })()");
    page.wait("document.documentElement.dataset.fits === '2'");
    page.wait(AT_REST);
    page.eval("document.querySelector('#add-pole').click()");
    page.eval("(() => { document.querySelector('#add-hz').value = 383.6; document.querySelector('#add-there').click(); })()");
    page.wait("document.documentElement.dataset.fits === '3'");
    page.wait(AT_REST);
    page.eval("document.querySelector('input[data-mode=\"2\"]').click()");
    page.wait("document.querySelector('#scene-status').textContent !== ''");
    page.wait(AT_REST);
    for name in ["scene", "added", "selection"] {
        let text = page.text(&format!("#{name}-toml"));
        folder.write(&format!("{name}.toml"), text);
    }
    for name in ["fit", "add", "select", "scene"] {
        let command = page.text(&format!("#{name}-command"));
        assert!(command.starts_with("chladni "), "{name}: {command}");
        follow(&folder, &command.into());
    }
    // the checksum of the model is among the sources
    let written: Value = serde_json::from_str(&folder.text("weights.json")).unwrap();
    assert_eq!(written["source"][0]["file"], "selected.json");
    assert_eq!(downloaded(&mut page, "weights.json"), written);
    assert_eq!(page.complaints(), Vec::<String>::new());
}
