//! Wrong inputs: messages as text and as JSON, and the exit status.

use crate::common::Folder;
use serde_json::Value;

/// One wrong input.
struct Wrong {
    line: &'static str,
    code: i32,
    kind: &'static str,
    words: Vec<&'static str>,
}

/// Wrong inputs, one in each line: command, exit status, kind, and words of the message.
const WRONG: &str = "
fit nowhere.uff|66|no_input|nowhere.uff|no such file|check the path
fit pannel.h5|66|no_input|pannel.h5|did you mean panel.h5?
fit panel|66|no_input|did you mean panel.h5?
fit nofolder/panel.h5|66|no_input|no folder nofolder
fit panel.h5/x|66|no_input|panel.h5/x
fit empty|66|no_input|empty|no file
fit nowhere/*.uff|66|no_input|no such file|nowhere
fit *.xyz|66|no_input|*.xyz|no file fits
fit truncated.unv|65|bad_data|truncated.unv|dataset 58|line
fit letters.unv|65|bad_data|letters.unv|dataset 58|line|abcdefg
fit header.unv|65|bad_data|header.unv|dataset 58|record 1|cut short
fit unknown.unv|65|bad_data|no FRF|dataset 999|(`chladni info FILE`)
fit binary.dat|65|bad_data|binary.dat|binary file|UFF 58
fit empty.csv|65|bad_data|empty.csv|0 bytes
fit notes.txt|65|bad_data|notes.txt|line 1|measured on Monday|f,re,im
fit timely.csv|65|bad_data|timely.csv|a time|(`chladni estimate`)
fit twice.csv|65|bad_data|twice.csv|line 3|occurs twice
fit decibel.csv|65|bad_data|decibel.csv|column 2|mag [dB]|dB re 1
fit headless.csv|65|bad_data|headless.csv|no row
fit direction.csv|65|bad_data|direction.csv|line 2|found 9|-6 to 6
fit infinite.csv|65|bad_data|infinite.csv|line 2|re|inf|--lenient
fit garbage.h5|65|bad_data|garbage.h5|HDF5
fit cut.h5|65|bad_data|cut.h5
fit brace.json|65|bad_data|brace.json|line|JSON
fit other.json|65|bad_data|other.json|format|found music|chladni.model
fit panel.h5 --band 5000:6000|65|bad_data|--band|5000:6000|20 to 400 Hz
fit panel.h5 --band 300:200|2|usage|--band|300:200|LO:HI
fit panel.h5 --band low:high|2|usage|--band|low:high|LO:HI
fit panel.h5 --bend 20:300|2|usage|--bend|--band|chladni fit --help
fit panel.h5 --modes 0|2|usage|--modes|found 0|auto
fit panel.h5 --modes 500|65|bad_data|381 lines|500 modes
fit panel.h5 --shapes ral|2|usage|--shapes|real, or another of
fit panel.h5 --damping none|2|usage|--damping|none|viscous
fit panel.h5 --rfp-weight iv|2|usage|--method|auto|--rfp-weight|--method rfp
fit panel.h5 --method rfp --rfp-weight best|2|usage|--rfp-weight|best|linear
fit panel.h5 --method rfp --rfp-bands 0|2|usage|--rfp-bands|found 0|auto
fit panel.h5 --method rfp --rfp-local --rfp-bands 2|2|usage|--rfp-local|--rfp-bands
fit panel.h5 --window flat|2|usage|--window|flat|rectangular
fit panel.h5 --exponential-window 0|2|usage|--exponential-window|record length
fit panel.h5 --threads 0|2|usage|--threads|found 0|a whole number from 1 to 1024|all cores
fit panel.h5 --threads 5000|2|usage|--threads|found 5000|no such number of threads|a whole number from 1 to 1024
fit panel.h5 --seed -1|2|usage|--seed|-1|whole number
fit panel.h5 --reference x|2|usage|--reference|found x|whole number
fit panel.h5 --reference 7|2|usage|panel.h5|--reference|more than one reference
fit panel.h5 --reference 1,2,3|2|usage|--reference|found 3|one for all
fit panel.h5 --map frf=/nope,freq=/freq|65|bad_data|map frf|/nope|/frf
fit panel.h5 --map frf|2|usage|--map|NAME=PATH
fit panel.h5 --dofs one.csv|65|bad_data|dofs|1 rows|(`chladni info -v FILE` lists them)
fit panel.h5 --map foo=/frf|2|usage|--map|foo|freq
fit panel.h5 -q -v|2|usage|exclude each other
fit panel.h5 -o new.json -o newer.json|2|usage|--output|given twice|expected it once
fit panel.h5 --memory -5|2|usage|--memory|found -5|500M
fit panel.h5 --exponential-window -5|2|usage|--exponential-window|found -5
fit|2|usage|FRF
fix panel.h5|2|usage|fix|fit
fit kindless.csv|65|unknown_frf_kind|kindless.csv|--frf-kind|mobility
fit truth.json|65|bad_data|truth.json|a model
fit truth.h5|65|bad_data|truth.h5|a model
fit panel.h5 panel.h5|65|bad_data|1:+Z|copies of each other|only one of these two files|--duplicates
fit panel.h5 -o old.json|73|cannot_create|old.json|exists|--force
fit panel.h5 -o no/such/model.json|73|cannot_create|no such folder|no/such
fit panel.h5 -o model.xyz|2|usage|.xyz|.json
convert panel.h5 -o panel.h5 --force|73|cannot_create|one of the inputs
convert panel.h5 -o new.json|2|usage|.json|.h5
convert truth.json -o new.ods|2|usage|.ods|.json
convert unknown.unv -o new.h5|65|bad_data|nothing|carried over
convert weights.json -o new.json|65|bad_data|weights.json|a weights file
simulate typo.toml -o new.h5|65|bad_data|typo.toml|line 2|stop_hz
simulate panel.toml -o new.h5 --memory 1K|65|bad_data|memory|panel.toml
simulate panel.toml -o new.h5 --memory lots|2|usage|--memory|lots|2G
simulate panel.toml -o new.h5 --truth new.h5|2|usage|--truth|new.h5
simulate binary.dat -o new.h5|65|bad_data|binary.dat|byte 0|a binary file|a panel
simulate latin.toml -o new.h5|65|bad_data|latin.toml|byte 3|0xe9|UTF-8
simulate empty -o new.h5|65|bad_data|empty|a folder
simulate text.toml -o new.h5|65|bad_data|line 2|plate.width_m|found string
simulate unclosed.toml -o new.h5|65|bad_data|unclosed.toml|line 1|TOML
select truth.json typo.toml -o new.json|65|bad_data|typo.toml|line 1|frf|drop
select truth.json many.toml -o new.json|65|bad_data|many.toml|line 1|drop[1]|999|the nearest is mode
select panel.h5 many.toml -o new.json|65|bad_data|panel.h5|no model|(`chladni fit FRF -o MODEL.json`)
select truth.json modeless.toml -o new.json|65|bad_data|modeless.toml|names no mode|(`chladni fit` prints the numbers)
select truth.json many.toml -o truth.json --force|73|cannot_create|one of the inputs
compare truth.json|2|usage|MODEL|SHAPES
compare truth.json panel.h5|65|bad_data|panel.h5|FRFs|datasets 55 or 2414|fit a model first (`chladni fit
compare truth.json weights.json|65|bad_data|weights.json
compare truth.json truth.json --least-mac 2|2|usage|--least-mac|0 to 1
render truth.json typo.toml|65|bad_data|typo.toml|line
render truth.json scen.toml|66|no_input|did you mean scene.toml?
render truth.json binary.dat|65|bad_data|binary.dat|a binary file|a scene
render truth.json empty|65|bad_data|empty|a folder
render truth.json cell.toml|65|bad_data|cell.toml|line 4|zones.hot[1]|from 1 to 4
render truth.json zoneless.toml|65|bad_data|zoneless.toml|zones|missing
render truth.json deaf.toml|65|bad_data|deaf.toml|3000 Hz|4 to 400 Hz
render truth.json profile.toml|65|bad_data|profile.toml|line 3|did you mean `classic`?
render truth.json actuator.toml|65|bad_data|actuator.toml|999:+Z|101:+Z
render panel.h5 scene.toml|65|bad_data|panel.h5|no model
render kindless.csv scene.toml|65|bad_data|kindless.csv|not a model|(`chladni fit FRF -o MODEL.json`)
render truth.json uncorrected.toml|65|bad_data|uncorrected.toml|none.json|no such file|(`chladni correct` writes one)
render truth.json modelled.toml|65|bad_data|truth.json|a model, not a calibration file|(`chladni correct` writes one)
render versionless.json scene.toml|65|bad_data|versionless.json|missing field|version
render short.json scene.toml|65|bad_data|short.json|modes[0].shape_std|found 23|expected 24
render weights.json scene.toml|65|bad_data|weights.json|not a model
render rig.json scene.toml|65|bad_data|rig.json|a calibration file, neither|(`chladni correct` writes one)
render drive.json scene.toml|65|bad_data|drive.json|the sidecar of a signal, neither|sound file beside it
render truth.json weights.json|65|bad_data|weights.json|a weights file, not TOML|its own place
render sideways.json scene.toml --frequency auto|65|bad_data|sideways.json: responses|can be judged
render undamped.json scene.toml|65|bad_data|undamped.json: modes|no finite mobility
evaluate weights.json --scene scene.toml --on undamped.json --field field.csv|65|bad_data|undamped.json: modes|no finite
correct undamped.json scene.toml --weights weights.json --field field.csv|65|bad_data|undamped.json: modes|no finite
render sideways.json scene.toml|65|bad_data|sideways.json: responses|can be judged
play sideways.json scene.toml|65|bad_data|sideways.json: responses|can be judged
correct sideways.json scene.toml --weights weights.json --field field.csv|65|bad_data|sideways.json: responses|can be judged
correct truth.json actuator.toml --weights weights.json --field field.csv|65|bad_data|actuator.toml|999:+Z|101:+Z
evaluate weights.json --scene scene.toml --on sideways.json --field field.csv|65|bad_data|sideways.json: responses|can be judged
evaluate weights.json --scene dead.toml --on truth.json --field field.csv|65|bad_data|dead.toml|actuators.dead|999:+Z
evaluate drive.wav --scene scene.toml --on sideways.json|65|bad_data|sideways.json: responses|can be judged
fit panel.h5 --dofs sideways.csv --scene scene.toml|65|bad_data|sideways.csv: responses|can be judged
render truth.json scene.toml --method magic|2|usage|--method|magic|mls
render truth.json scene.toml --actuators -5|2|usage|--actuators|found -5|above 0
render truth.json scene.toml --frequency -5|2|usage|--frequency|found -5
render truth.json scene.toml --sweep 40:1041|2|usage|--sweep|at most 1000 Hz wide
render truth.json scene.toml --sweep 310:290|2|usage|--sweep|310:290|does not rise|LO:HI
render truth.json scene.toml --sweep 290:290|2|usage|--sweep|290:290|does not rise|LO:HI
render truth.json scene.toml --actuators auto --also deaf.toml|65|bad_data|deaf.toml|3000 Hz
render scene.toml truth.json|65|bad_data|scene.toml|TOML|its own place
play truth.json scene.toml --rate 0|2|usage|--rate|found 0|Hz from 1 to 4294967295|48000 is usual
play truth.json scene.toml --rate 100|2|usage|--rate|100 Hz|twice the highest frequency
play truth.json scene.toml --rate 5000000000|2|usage|--rate|found 5000000000|Hz from 1 to 4294967295|48000 is usual
studio panel.h5 --port 70000|2|usage|--port|found 70000|0 to 65535|any free one
play truth.json scene.toml --full-scale 1e-9|2|usage|--full-scale|nothing clips
play truth.json scene.toml --seed -5|2|usage|--seed|found -5
estimate panel.h5 -o new.h5|65|bad_data|no time record|(`chladni info FILE`)
estimate headless.csv -o new.h5 --scales nan,1|2|usage|--scales|found nan|finite
estimate headless.csv -o new.h5 --exponential-window 0|2|usage|--exponential-window|found 0|above 0|the rate is ln
estimate headless.csv -o new.h5 --window exponential|2|usage|--exponential-window|found none|choose another --window
estimate headless.csv -o new.h5 --window hann --exponential-window 5|2|usage|--exponential-window|leave one of the two out
evaluate truth.json --scene scene.toml --on panel.h5|65|bad_data|truth.json|a model, not a weights file|(`chladni render` writes one)
evaluate binary.dat --scene scene.toml --on panel.h5|65|bad_data|binary.dat|a binary file|weights
evaluate hollow.json --scene scene.toml --on panel.h5|65|bad_data|hollow.json|missing field|version|(`chladni render` writes one)
evaluate stranger.json --scene scene.toml --on panel.h5|65|bad_data|999:+Z|101:+Z
evaluate weights.json --on panel.h5|2|usage|--scene
report panel.toml -o new.html|65|bad_data|panel.toml|model
report panel.h5 -o new.html|65|bad_data|panel.h5|no model
report truth.json truth.h5 -o new.html|2|usage|truth.h5|one model
report scene.toml -o new.html|65|bad_data|scene.toml|TOML
report truth.json --charts old.json|73|cannot_create|--charts|a file
report truth.json -o new.pdf|2|usage|.pdf|.html
info nowhere.uff|66|no_input|nowhere.uff
info empty|66|no_input|empty
info binary.dat|65|bad_data|binary.dat
info rig.json|65|bad_data|rig.json|a calibration file, neither|chladni.calibration|in a scene
demo -o no/such/demo|73|cannot_create|no/such/demo
demo -o panel.h5|73|cannot_create|panel.h5|a file
man fix|2|usage|fix
completions tcsh|2|usage|tcsh|bash
";

fn wrong_inputs() -> impl Iterator<Item = Wrong> {
    WRONG.lines().filter(|row| !row.is_empty()).map(|row| {
        let mut cells = row.split('|');
        let mut next = || cells.next().unwrap_or_else(|| panic!("{row}"));
        Wrong {
            line: next(),
            code: next().parse().unwrap(),
            kind: next(),
            words: cells.collect(),
        }
    })
}

fn prepared() -> Folder {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.unv -q").exits(0);
    let text = folder.text("panel.unv");
    folder.write("truncated.unv", &text[..text.len() * 3 / 5]);
    let lines: Vec<&str> = text.lines().collect();
    let middle = lines.len() / 2;
    let mut damaged: Vec<String> = lines.iter().map(ToString::to_string).collect();
    damaged[middle].replace_range(0..7, "abcdefg");
    folder.write("letters.unv", damaged.join("\n"));
    folder.write("kindless.csv", "f,re,im\n10,1,0\n20,2,1\n30,1,0\n40,2,1\n");
    folder.write("old.json", "old");
    folder.write("many.toml", "drop = [999]\n");
    folder.write("typo.toml", "[frf]\nstop_hertz = 3\n");
    for (name, text) in [
        ("empty.csv", ""),
        ("notes.txt", "measured on Monday\n"),
        ("timely.csv", "time,re,im\n1,2,3\n2,2,3\n"),
        ("twice.csv", "f,re,im\n1,2,3\n1,2,3\n"),
        ("decibel.csv", "f,mag [dB],phase\n1,2,3\n2,3,4\n"),
        ("headless.csv", "node,dir,ref_node,ref_dir,f,re,im\n"),
        (
            "direction.csv",
            "node,dir,ref_node,ref_dir,f,re,im\n1,9,1,3,1,2,3\n",
        ),
        ("infinite.csv", "f,re,im\n1,inf,3\n2,1,2\n"),
        ("header.unv", "    -1\n    58\n"),
        ("unknown.unv", "    -1\n   999\nx\n    -1\n"),
        ("brace.json", "{"),
        ("other.json", "{\"format\": \"music\"}"),
        ("rig.json", "{\"format\": \"chladni.calibration\"}"),
        ("versionless.json", "{\"format\": \"chladni.model\"}"),
        ("hollow.json", "{\"format\": \"chladni.weights\"}"),
        ("text.toml", "[plate]\nwidth_m = \"a\"\n"),
        ("unclosed.toml", "[frf\n"),
        (
            "cell.toml",
            "frequency_hz = 300\n[zones]\ngrid = [2, 2]\nhot = [9]\n",
        ),
        ("zoneless.toml", "frequency_hz = 300\n"),
        ("modeless.toml", "keep = []\n"),
        ("one.csv", "1:+Z,101:+Z\n"),
        (
            "uncorrected.toml",
            "frequency_hz = 300\n[actuators]\ncalibration = \"none.json\"\n[zones]\ngrid = \
             [2, 2]\nhot = [1]\n",
        ),
        (
            "modelled.toml",
            "frequency_hz = 300\n[actuators]\ncalibration = \"truth.json\"\n[zones]\ngrid = \
             [2, 2]\nhot = [1]\n",
        ),
        (
            "deaf.toml",
            "frequency_hz = 3000\n[threshold]\nprofile = \"classic\"\n[zones]\ngrid = \
                       [2, 2]\nhot = [1]\n",
        ),
        (
            "profile.toml",
            "frequency_hz = 300\n[threshold]\nprofile = \"clasic\"\n[zones]\ngrid = \
                          [2, 2]\nhot = [1]\n",
        ),
        (
            "dead.toml",
            "frequency_hz = 300\n[actuators]\ndead = [\"999:+Z\"]\n[zones]\ngrid = \
                           [2, 2]\nhot = [1]\n",
        ),
        (
            "actuator.toml",
            "frequency_hz = 300\n[actuators]\nuse = [\"999:+Z\"]\n[zones]\ngrid = \
                           [2, 2]\nhot = [1]\n",
        ),
    ] {
        folder.write(name, text);
    }
    folder.write("garbage.h5", b"\x89HDF\r\n\x1a\n garbage");
    folder.write("binary.dat", [0xff, 0x00, 0x01, 0x02]);
    folder.write("latin.toml", b"caf\xe9 = 1\n");
    folder.write("cut.h5", &folder.read("panel.h5")[..40_000]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    folder.run("convert truth.json -o truth.h5 -q").exits(0);
    folder.run("render truth.json scene.toml -o weights.json -q");
    folder.write(
        "stranger.json",
        folder.text("weights.json").replacen("101:+Z", "999:+Z", 1),
    );
    let mut truth: Value = serde_json::from_str(&folder.text("truth.json")).unwrap();
    truth["modes"][0]["shape_std"].as_array_mut().unwrap().pop();
    folder.write("short.json", truth.to_string());
    let mut undamped: Value = serde_json::from_str(&folder.text("truth.json")).unwrap();
    undamped["modes"][0]["frequency_hz"] = 300.0.into();
    for key in ["loss_factor", "damping_ratio"] {
        undamped["modes"][0][key] = 0.0.into();
    }
    folder.write("undamped.json", undamped.to_string());
    turn_sideways(&folder);
    folder
}

/// The model and the FRFs as if the responses were along X; a field and a drive signal.
fn turn_sideways(folder: &Folder) {
    let mut model: Value = serde_json::from_str(&folder.text("truth.json")).unwrap();
    let mut rows = String::new();
    let references = model["references"].clone();
    for response in model["responses"].as_array_mut().unwrap() {
        *response = response.as_str().unwrap().replace("+Z", "+X").into();
        for reference in references.as_array().unwrap() {
            let [response, reference] = [&*response, reference].map(|dof| dof.as_str().unwrap());
            rows += &format!("{response},{reference}\n");
        }
    }
    folder.write("sideways.json", model.to_string());
    folder.write("sideways.csv", rows);
    folder.run("simulate panel.toml --play weights.json -o field.csv -q");
    folder.run("play truth.json scene.toml -o drive.wav -q");
}

#[test]
fn every_wrong_input_is_explained_and_leaves_nothing_behind() {
    let folder = prepared();
    let names = folder.names();
    for wrong in wrong_inputs() {
        let run = folder.run(wrong.line).exits(wrong.code);
        assert!(
            run.stderr.contains("error: ") && run.stdout.is_empty(),
            "{}: {}",
            wrong.line,
            run.stderr
        );
        for word in &wrong.words {
            assert!(
                run.stderr.contains(word),
                "{}: no {word:?} in {}",
                wrong.line,
                run.stderr
            );
        }
        let json = folder
            .run(&format!("{} --json", wrong.line))
            .exits(wrong.code)
            .json();
        let error = json["error"].as_object().unwrap();
        for key in [
            "code", "kind", "file", "dataset", "line", "field", "found", "expected", "help",
        ] {
            assert!(error.contains_key(key), "{}: no key {key}", wrong.line);
        }
        for key in ["found", "expected"] {
            assert!(error[key].is_string(), "{}: nothing {key}", wrong.line);
        }
        assert_eq!(error["code"], wrong.code, "{}", wrong.line);
        assert_eq!(error["kind"], wrong.kind, "{}", wrong.line);
    }
    assert_eq!(folder.names(), names);
    assert_eq!(folder.text("old.json"), "old");
}

#[test]
fn a_damaged_file_says_where() {
    let error = prepared().run("fit letters.unv --json").exits(65).json()["error"].clone();
    assert_eq!(error["file"], "letters.unv");
    assert_eq!(error["dataset"], 58);
    assert!(error["line"].as_u64().unwrap() > 1000);
    assert!(error["found"].as_str().unwrap().contains("abcdefg"));
    assert!(error["expected"].is_string());
}

#[test]
fn help_and_version_are_no_errors_and_give_examples() {
    let folder = Folder::new();
    assert!(folder
        .run("--version")
        .exits(0)
        .stdout
        .starts_with("chladni "));
    for command in [
        "demo",
        "info",
        "convert",
        "estimate",
        "simulate",
        "fit",
        "select",
        "compare",
        "render",
        "evaluate",
        "correct",
        "report",
        "completions",
        "man",
    ] {
        let help = folder.run(&format!("{command} --help")).exits(0).stdout;
        assert!(
            help.contains("Examples:") && help.contains(&format!("chladni {command}")),
            "{command}: {help}"
        );
    }
    assert!(folder.run("").exits(2).stderr.contains("Usage:"));
    assert_eq!(
        folder.run("--json").exits(2).json()["error"]["expected"],
        "a command"
    );
    folder.run("man fit").exits(0);
    folder.run("man fix").exits(2);
    folder.run("completions zsh").exits(0);
}

#[cfg(unix)]
#[test]
fn a_full_disk_and_a_closed_pipe_on_stdout() {
    use std::process::{Command, Stdio};
    let folder = Folder::with_panel();
    let command = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        command
            .current_dir(folder.path())
            .args(["info", "panel.h5"])
            .stderr(Stdio::null());
        command
    };
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    assert_eq!(command().stdout(full).status().unwrap().code(), Some(74));
    let mut child = command().stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn an_interruption_leaves_nothing_half_written() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    // background jobs ignore SIGINT, those under nohup SIGHUP, and tests would inherit that
    let mut child = Command::new("env")
        .current_dir(folder.path())
        .args([
            "--default-signal",
            env!("CARGO_BIN_EXE_chladni"),
            "demo",
            "--progress",
            "plain",
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines
        .by_ref()
        .map_while(Result::ok)
        .any(|line| line == "writing the FRFs"));
    assert!(Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap()
        .success());
    assert!(lines
        .map_while(Result::ok)
        .any(|line| line.contains("interrupted")));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let left = std::fs::read_dir(folder.path().join("chladni-demo")).unwrap();
    for entry in left {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(!name.starts_with('.'), "{name} was left behind");
    }
}

#[test]
fn what_is_found_is_said_once() {
    let folder = Folder::with_panel();
    for line in [
        "fit panel.h5 --modes 0",
        "render truth.json scene.toml --actuators 0",
    ] {
        let said = folder.run(line).exits(2).said();
        assert_eq!(said.matches("found").count(), 1, "{said}");
    }
}

#[test]
fn help_explains_itself_and_windows() {
    let folder = Folder::new();
    assert!(folder.run("help --help").exits(0).stdout.contains("Usage"));
    let fit = folder.run("help fit --help").exits(0).stdout;
    let words: Vec<&str> = fit.split_whitespace().collect();
    assert!(words.join(" ").contains("hammer: transient"), "{fit}");
}
