//! Conventions of the shell: long names, the standard output as a place of results, dry
//! runs, settings of the environment.

use crate::common::Folder;
use crate::pipes::bash;
use std::process::Command;

#[test]
fn the_standard_output_takes_a_result_and_nothing_else() {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    let piped = bash(&folder, "chladni fit panel.h5 --output - | cat").exits(0);
    assert_eq!(piped.stdout, folder.text("model.json"));
    assert!(!piped.stderr.contains("Next:"), "{}", piped.stderr);

    bash(
        &folder,
        "chladni simulate panel.toml -o - | chladni convert - -o - | chladni fit - -o piped.json -q",
    )
    .exits(0);
    let modes = |name: &str| -> serde_json::Value {
        let model: serde_json::Value = serde_json::from_str(&folder.text(name)).unwrap();
        model["modes"].clone()
    };
    assert_eq!(modes("piped.json"), modes("model.json"));

    let table = bash(
        &folder,
        "chladni render truth.json scene.toml --method fast --wav - -q -o w.json",
    );
    assert!(table.stdout.contains("101:+Z"), "{}", table.stdout);
    // only the result, and no file named `-`
    assert!(folder
        .names()
        .iter()
        .all(|name| !name.starts_with(['-', '.'])));
}

#[test]
fn what_cannot_go_to_the_standard_output_is_refused() {
    let folder = Folder::with_panel();
    for (line, words) in [
        ("fit panel.h5 -o - --json", "the object of --json"),
        (
            "fit panel.h5 -o - --memory 1M --resume",
            "beside its output",
        ),
        ("demo -o -", "several files"),
        ("simulate panel.toml -o - --truth -", "are two files"),
    ] {
        let run = folder.run(line).exits(2);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
    assert_eq!(
        folder.names(),
        ["panel.h5", "panel.toml", "scene.toml", "truth.json"]
    );
}

#[test]
fn a_dry_run_says_what_would_be_done_and_does_nothing() {
    let folder = Folder::with_panel();
    let before = folder.names();
    let plan = folder
        .run("fit panel.h5 -o model.json --dry-run --json")
        .exits(0)
        .json();
    // 24 responses, 10 references, 381 lines
    let bytes = 24 * 10 * 381 * 16;
    assert_eq!(plan["dry_run"], true);
    assert_eq!(plan["frf_bytes"], bytes);
    assert_eq!(
        (&plan["parts"], &plan["outputs"][0]),
        (&serde_json::Value::Null, &"model.json".into())
    );
    let plan = folder
        .run("fit panel.h5 -o model.json --memory 1M --dry-run --json")
        .exits(0)
        .json();
    assert!(plan["parts"].as_u64().unwrap() > 1, "{plan}");
    let half = folder
        .run("block reduce panel.h5 --block 0 --blocks 2 -o 0.part --dry-run --json")
        .exits(0)
        .json();
    assert_eq!(half["frf_bytes"], bytes / 2);
    let plan = folder
        .run("simulate panel.toml -o new.h5 --truth new.json --dry-run --json")
        .exits(0)
        .json();
    assert_eq!(
        (
            &plan["frf_bytes"],
            plan["outputs"].as_array().unwrap().len()
        ),
        (&bytes.into(), 2)
    );
    // an output that could not be written is refused now
    folder
        .run("simulate panel.toml -o panel.h5 --dry-run")
        .exits(73);
    folder
        .run("fit panel.h5 -o no/such/model.json --dry-run")
        .exits(73);
    assert_eq!(folder.names(), before);
}

#[test]
fn the_environment_stands_for_options_that_are_set_once() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.npz -q").exits(0);
    let fit = |variables: &[(&str, &str)], line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        command.current_dir(folder.path()).args(line.split(' '));
        command.envs(variables.iter().copied());
        let output = command.output().unwrap();
        (
            output.status.code().unwrap(),
            String::from_utf8(output.stdout).unwrap(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let line = "fit panel.npz --json -q";
    let (code, said, _) = fit(
        &[("CHLADNI_THREADS", "1"), ("CHLADNI_FRF_KIND", "mobility")],
        line,
    );
    assert!(
        code <= 1 && said.contains("\"frf_kind\":\"mobility\""),
        "{said}"
    );
    let (code, _, said) = fit(&[("CHLADNI_THREADS", "many")], line);
    assert!(code == 2 && said.contains("--threads"), "{said}");
    let (code, _, said) = fit(&[("CHLADNI_FRF_KIND", "speed")], line);
    assert!(code == 2 && said.contains("--frf-kind"), "{said}");
    let help = folder.run("fit --help").exits(0).stdout;
    assert!(
        help.contains("[env: CHLADNI_FRF_KIND]") && help.contains("--no-color"),
        "{help}"
    );
}

#[test]
fn every_short_output_has_its_long_name_and_help_names_the_documentation() {
    let folder = Folder::new();
    for verb in [
        "fit",
        "convert",
        "estimate",
        "simulate",
        "select",
        "render",
        "play",
        "correct",
        "report",
        "demo",
        "block reduce",
        "block solve",
    ] {
        let help = folder.run(&format!("{verb} --help")).exits(0).stdout;
        assert!(help.contains("-o, --output <"), "{verb}: {help}");
    }
    let help = folder.run("--help").exits(0).stdout;
    assert!(help.contains("https://docs.rs/chladni-cli"), "{help}");
}
