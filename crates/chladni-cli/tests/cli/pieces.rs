//! The fit in pieces from the command line: verbs, files larger than the memory allowed,
//! interruption.

use crate::common::{in_band_hz, Folder};
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Memory that the panel of the tests does not fit into, and the parts it is cut into:
/// more than ten.
const LITTLE: &str = "--memory 1M";

/// A folder with the panel, whose FRFs carry noise as measured ones do.
fn noisy() -> Folder {
    let folder = Folder::with_panel();
    folder
        .run("simulate panel.toml -o panel.h5 --snr-db 50 --force -q")
        .exits(0);
    folder
}

fn model(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.text(name)).unwrap()
}

fn assert_near(a: &Value, b: &Value, tolerance: f64) {
    let (a, b) = (in_band_hz(a), in_band_hz(b));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert!((a / b - 1.0).abs() < tolerance, "{a} {b}");
    }
}

#[test]
fn verbs_lead_from_blocks_to_the_model_that_fit_finds() {
    let folder = noisy();
    for block in [2, 0, 1] {
        let said = folder
            .run(&format!(
                "block reduce panel.h5 --block {block} --blocks 3 -o first-{block}.part --json"
            ))
            .exits(0)
            .json();
        assert_eq!(
            (&said["frfs"], &said["pass"]),
            (&80.into(), &1.into()),
            "{said}"
        );
    }
    folder
        .run("block merge first-1.part first-0.part first-2.part -o first.part")
        .exits(0);
    // an option of the second pass is refused in the first
    let refused = folder
        .run("block solve first.part -o found.poles --shapes real")
        .exits(2);
    assert!(
        refused.stderr.contains("--shapes") && refused.stderr.contains("second pass"),
        "{}",
        refused.stderr
    );
    // the extension counts in capitals too
    folder
        .run("block solve first.part -o capitals.POLES")
        .exits(0);
    let poles = folder
        .run("block solve first.part -o found.poles --json")
        .exits(0)
        .json();
    assert!(poles["modes"].as_array().unwrap().len() > 5, "{poles}");
    for block in 0..3 {
        folder
            .run(&format!(
                "block reduce panel.h5 --block {block} --blocks 3 --poles found.poles \
                             -o second-{block}.part"
            ))
            .exits(0);
    }
    folder
        .run("block merge second-0.part second-1.part second-2.part -o second.part")
        .exits(0);
    folder
        .run("block solve second.part -o pieces.json --modes 3")
        .exits(2);
    folder
        .run("block solve second.part -o pieces.json")
        .exits(0);
    folder.run("fit panel.h5 -o whole.json").exits(0);
    let (pieces, whole) = (model(&folder, "pieces.json"), model(&folder, "whole.json"));
    assert_near(&pieces, &whole, 1e-6);
    assert_eq!(pieces["source"], whole["source"]);
    assert_eq!(pieces["responses"], whole["responses"]);
    // a model of pieces can be rendered, and its poles serve other FRFs
    folder
        .run("render pieces.json scene.toml -o weights.json")
        .exits(0);
    let residues = folder
        .run("block residues panel.h5 --model pieces.json -o residues.json --json")
        .exits(0)
        .json();
    assert_near(&residues, &pieces, 1e-14);
    assert!(
        residues["quality"]["relative_error"].as_f64().unwrap() < 0.01,
        "{}",
        residues["quality"]
    );
}

#[test]
fn missing_blocks_are_named_where_the_partials_know_of_them() {
    let folder = noisy();
    let reduce = |block: usize, rest: &str| {
        let line = format!("block reduce panel.h5 --block {block} {rest} -o {block}.part --force");
        folder.run(&line).exits(0);
    };
    let said = |line: &str| {
        let json = folder
            .run(&format!("{line} --force --json"))
            .exits(0)
            .json();
        let findings = json["findings"].as_array().unwrap().clone();
        let found = |finding: &&Value| finding["code"] == "blocks-missing";
        findings.iter().find(found).cloned()
    };
    for block in 0..3 {
        reduce(block, "--blocks 3");
    }
    let note = said("block merge 0.part 2.part -o all.part").unwrap();
    assert_eq!(note["severity"], "note");
    assert!(
        note["text"].as_str().unwrap().contains("missing: 1"),
        "{note}"
    );
    let caution = said("block solve all.part -o found.poles").unwrap();
    assert_eq!(caution["severity"], "caution");
    assert_eq!(said("block merge all.part 1.part -o whole.part"), None);
    assert_eq!(said("block solve whole.part -o found.poles"), None);
    // blocks that a user made know nothing of others
    reduce(7, "");
    assert_eq!(said("block solve 7.part -o found.poles"), None);
}

#[test]
fn a_set_larger_than_memory_is_read_in_parts_and_gives_the_same_model() {
    let folder = noisy();
    folder.run("fit panel.h5 -o whole.json").exits(0);
    let run = folder
        .run(&format!(
            "fit panel.h5 -o parts.json {LITTLE} --progress plain"
        ))
        .exits(0);
    assert!(
        run.stderr.contains("pass over the data: 100 %"),
        "{}",
        run.stderr
    );
    assert_near(
        &model(&folder, "parts.json"),
        &model(&folder, "whole.json"),
        1e-6,
    );
    // universal files, binary and text, one and several
    for (name, line) in [
        ("panel.uff", "convert panel.h5 -o panel.uff"),
        ("panel.unv", "convert panel.h5 -o panel.unv"),
    ] {
        folder.run(line).exits(0);
        folder
            .run(&format!("fit {name} -o {name}.json {LITTLE}"))
            .exits(0);
        assert_near(
            &model(&folder, &format!("{name}.json")),
            &model(&folder, "whole.json"),
            1e-6,
        );
    }
    // the same bytes at any number of threads, and no other files
    for threads in [1, 2, 4] {
        folder
            .run(&format!(
                "fit panel.h5 -o t{threads}.json {LITTLE} --threads {threads}"
            ))
            .exits(0);
        assert!(folder.read(&format!("t{threads}.json")) == folder.read("parts.json"));
    }
    assert!(
        folder.names().iter().all(|name| !name.ends_with(".resume")),
        "{:?}",
        folder.names()
    );
}

#[test]
fn a_killed_fit_goes_on_and_writes_the_same_bytes() {
    let folder = noisy();
    let fit = |name: &str| format!("fit panel.h5 -o {name} {LITTLE}");
    folder.run(&fit("whole.json")).exits(0);
    let mut resumed = 0;
    for kill in 0..40 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_chladni"))
            .current_dir(folder.path())
            .args(format!("{} --force", fit("killed.json")).split_whitespace())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(10 * kill));
        child.kill().ok(); // SIGKILL
        child.wait().unwrap();
        if folder
            .names()
            .iter()
            .any(|name| name == "killed.json.resume")
        {
            resumed += 1;
            folder
                .run(&format!("{} --resume --force", fit("killed.json")))
                .exits(0);
            assert!(
                folder.read("killed.json") == folder.read("whole.json"),
                "kill {kill}"
            );
            std::fs::remove_file(folder.path().join("killed.json")).unwrap();
        }
        if resumed >= 4 {
            return;
        }
    }
    assert!(resumed > 0, "no kill came while it ran");
}

/// The error of a command that must be refused.
fn error(folder: &Folder, line: &str, code: i32) -> Value {
    let run = folder.run(&format!("{line} --json")).exits(code);
    run.json()["error"].clone()
}

#[test]
fn a_fit_that_cannot_be_made_in_parts_is_refused_with_the_next_step() {
    let folder = noisy();
    let method = error(&folder, &format!("fit panel.h5 --method lscf {LITTLE}"), 2);
    assert_eq!(
        (&method["field"], &method["found"]),
        (&"--method".into(), &"lscf".into()),
        "{method}"
    );
    folder.run("convert panel.h5 -o panel.csv").exits(0);
    let table = error(&folder, &format!("fit panel.csv {LITTLE}"), 65);
    let said = |key: &str| table[key].as_str().unwrap();
    assert!(
        said("message").contains("cannot be read in parts"),
        "{table}"
    );
    assert!(said("help").contains("--memory"), "{table}");
    // the state of another version of the program
    folder.write("model.json.resume", b"{\"format\":\"chladni.resume\"}\nx");
    let line = format!("fit panel.h5 -o model.json --resume {LITTLE}");
    let resume = error(&folder, &line, 65);
    assert_eq!(&resume["field"], "version", "{resume}");
}

#[test]
fn copies_in_two_files_are_refused_with_what_to_do() {
    let folder = noisy();
    folder
        .run("convert panel.h5 -o copy.h5 --frf-kind mobility")
        .exits(0);
    let line = format!("fit panel.h5 copy.h5 --duplicates first {LITTLE}");
    let copies = error(&folder, &line, 65);
    let said = |key: &str| copies[key].as_str().unwrap();
    assert!(said("message").contains("an FRF occurs twice"), "{copies}");
    assert!(said("help").contains("--duplicates first"), "{copies}");
    assert!(copies["file"].is_null(), "{copies}");
    // a list of nodes that does not fit the files is refused as in memory
    let line = format!("panel.h5 copy.h5 --reference 1,2,3 {LITTLE}");
    for command in ["fit", "block reduce -o a.part"] {
        let list = error(&folder, &format!("{command} {line}"), 2);
        assert_eq!(&list["field"], "--reference", "{list}");
        assert_eq!(&list["found"], "3", "{list}");
    }
}

#[test]
fn blocks_that_cannot_be_are_refused_by_name() {
    let folder = noisy();
    let error = |line: &str, code: i32| error(&folder, line, code);
    let many = error("block reduce panel.h5 --block 0 --blocks 25 -o a.part", 2);
    assert_eq!(
        (&many["field"], &many["found"]),
        (&"--blocks".into(), &"25".into()),
        "{many}"
    );
    let beyond = error("block reduce panel.h5 --block 3 --blocks 3 -o a.part", 2);
    assert_eq!(&beyond["field"], "--block", "{beyond}");
    let kind = error("block merge panel.h5 -o a.part", 65);
    assert!(
        kind["message"]
            .as_str()
            .unwrap()
            .contains("chladni.partial"),
        "{kind}"
    );
    assert!(!folder.names().contains(&"a.part".to_owned()));
}

#[test]
fn passes_that_do_not_belong_together_are_refused_with_the_next_step() {
    let folder = noisy();
    let error = |line: &str, code: i32| error(&folder, line, code);
    folder.run("block reduce panel.h5 -o all.part").exits(0);
    let model = error("block solve all.part -o model.json", 2);
    assert!(
        model["help"]
            .as_str()
            .unwrap()
            .contains("a first pass leads to poles"),
        "{model}"
    );
    folder.run("block solve all.part -o found.poles").exits(0);
    folder
        .run("block reduce panel.h5 --block 0 --blocks 2 --poles found.poles -o half.part")
        .exits(0);
    let half = error("block solve half.part -o model.json", 65);
    assert_eq!(
        (&half["found"], &half["file"]),
        (&"120".into(), &"half.part".into()),
        "{half}"
    );
    let other = error(
        "block reduce panel.h5 --band 30:300 --poles found.poles -o b.part",
        65,
    );
    assert_eq!(&other["field"], "band", "{other}");
    assert!(folder
        .names()
        .iter()
        .all(|name| !["b.part", "model.json"].contains(&name.as_str())));
}

#[test]
fn blocks_that_were_read_otherwise_are_refused_by_name() {
    let folder = noisy();
    let reduce = |k: usize, more: &str| {
        format!("block reduce panel.h5 --block {k} --blocks 2 -o {k}.part --force {more}")
    };
    let refused = |line: &str| {
        let error = folder.run(&format!("{line} --json")).exits(65).json()["error"].clone();
        assert_eq!(error["field"], "time sign", "{error}");
        assert!(error["found"].as_str().unwrap().contains('-'), "{error}");
        assert_eq!(error["expected"], "not given, as in the others", "{error}");
    };
    folder.run(&reduce(0, "")).exits(0);
    folder.run(&reduce(1, "--time-sign -")).exits(0);
    refused("block merge 0.part 1.part -o all.part");
    // the second pass reads as the first did
    folder.run("block reduce panel.h5 -o whole.part").exits(0);
    folder.run("block solve whole.part -o found.poles").exits(0);
    refused(&reduce(1, "--poles found.poles --time-sign -"));
    // merged partials and models name the options of reading
    folder.run(&reduce(0, "--lenient")).exits(0);
    folder.run(&reduce(1, "--lenient")).exits(0);
    folder.run("block merge 0.part 1.part -o all.part").exits(0);
    folder.run("block solve all.part -o all.poles").exits(0);
    for k in 0..2 {
        folder
            .run(&reduce(k, "--lenient --poles all.poles"))
            .exits(0);
    }
    folder
        .run("block merge 0.part 1.part -o all.part --force")
        .exits(0);
    folder.run("block solve all.part -o model.json").exits(0);
    assert_eq!(model(&folder, "model.json")["options"]["lenient"], true);
}

/// Kills a run as soon as it has saved the state for `--resume`.
fn left_by_a_killed_run(folder: &Folder, line: &str, output: &str) {
    let resume = format!("{output}.resume");
    for _ in 0..60 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_chladni"))
            .current_dir(folder.path())
            .args(line.split_whitespace())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while child.try_wait().unwrap().is_none() && !folder.names().contains(&resume) {
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().ok(); // SIGKILL
        child.wait().unwrap();
        if folder.names().contains(&resume) {
            return;
        }
        std::fs::remove_file(folder.path().join(output)).ok();
    }
    panic!("no kill came while it ran: {line}");
}

/// The functions of `panel.h5` at one of its references, as a universal file.
fn functions_of_reference_101(folder: &Folder) -> String {
    folder
        .run("convert panel.h5 -o panel.unv --force -q")
        .exits(0);
    let text = folder.text("panel.unv");
    let sets = text.split("    -1\n").filter(|set| {
        let dofs = set.lines().nth(6).unwrap_or_default();
        set.trim_start().starts_with("58") && dofs.trim_end().ends_with(" 101   3")
    });
    let sets: Vec<String> = sets.map(|set| format!("    -1\n{set}    -1\n")).collect();
    assert_eq!(sets.len(), 24);
    sets.concat()
}

#[test]
fn what_was_read_or_fitted_otherwise_is_not_resumed() {
    let folder = noisy();
    folder.write("one.unv", functions_of_reference_101(&folder));
    for (line, output, others) in [
        (
            "fit panel.h5 --memory 1M -o a.json",
            "a.json",
            &[
                ("--time-sign -", "--time-sign", "not given", "-"),
                ("--frf-kind mobility", "--frf-kind", "not given", "mobility"),
                ("--duplicates mean", "--duplicates", "not given", "mean"),
                ("--lenient", "--lenient", "not given", "true"),
                ("--band 30:300", "--band", "not given", "[30.0,300.0]"),
                ("--seed 7", "--seed", "0", "7"),
                ("--damping viscous", "--damping", "auto", "viscous"),
                ("--modes 5", "--modes", "auto", "5"),
                ("--shapes real", "--shapes", "auto", "real"),
                ("--window none", "--window", "not given", "none"),
                ("--memory 1030K", "--memory", "1048576", "1054720"),
            ][..],
        ),
        (
            "fit one.unv --memory 100K -o one.json",
            "one.json",
            &[("--reference 101", "--reference", "not given", "[101]")],
        ),
        (
            "block reduce panel.h5 --memory 1M -o a.part --block 1 --blocks 2",
            "a.part",
            &[
                ("--time-sign -", "--time-sign", "not given", "-"),
                ("--block 0", "--block", "1", "0"),
            ],
        ),
    ] {
        left_by_a_killed_run(&folder, line, output);
        let left = folder.read(&format!("{output}.resume"));
        for &(other, field, were, is) in others {
            // the last of an option that occurs twice is refused by the command line
            let name = other.split(' ').next().unwrap();
            let words: Vec<&str> = line.split(' ').collect();
            let at = words.iter().position(|word| *word == name);
            let kept = |k: usize| at.is_none_or(|at| k != at && k != at + 1);
            let line: Vec<&str> = (0..words.len())
                .filter(|k| kept(*k))
                .map(|k| words[k])
                .collect();
            let run = folder.run(&format!(
                "{} {other} --resume --force --json",
                line.join(" ")
            ));
            let error = run.exits(65).json()["error"].clone();
            assert_eq!(error["field"], field, "{error}");
            assert_eq!(error["found"], were, "{error}");
            let expected = error["expected"].as_str().unwrap();
            assert_eq!(expected, format!("{is}, as now"), "{error}");
            assert!(folder.read(&format!("{output}.resume")) == left);
        }
        folder.run(&format!("{line} --resume --force")).exits(0);
        assert!(!folder.names().contains(&format!("{output}.resume")));
    }
}
