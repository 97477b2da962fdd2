//! The documents are correct: their examples are read and their commands are run.

use crate::common::{skipped, Folder};
use std::env::consts::EXE_EXTENSION;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const FORMATS: &str = include_str!("../../../../docs/formats.md");
const TUTORIAL: &str = include_str!("../../../../docs/tutorial.md");
const TROUBLESHOOTING: &str = include_str!("../../../../docs/troubleshooting.md");
const FIRST_HOUR: &str = include_str!("../../../../docs/first-hour.md");
const ACCURACY: &str = include_str!("../../../../docs/accuracy.md");
const PAPER: &str = include_str!("../../../../docs/paper.md");
const README: &str = include_str!("../../../../README.md");
const ARCHITECTURE: &str = include_str!("../../../../docs/architecture.md");
const THEORY: &str = include_str!("../../../../docs/theory.md");
const CONTRIBUTING: &str = include_str!("../../../../CONTRIBUTING.md");
const FIXTURES: &str = include_str!("../../../../fixtures/README.md");

#[test]
fn the_examples_of_the_page_are_read() {
    let folder = Folder::new();
    let mut blocks = FORMATS
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap());
    folder.write("scene.toml", blocks.next().unwrap());
    // the axis is cut so that the test takes no time
    folder.write(
        "panel.toml",
        blocks
            .next()
            .unwrap()
            .replace("step_hz = 0.5", "step_hz = 50.0"),
    );
    folder.write("selection.toml", blocks.next().unwrap());
    assert!(blocks.next().is_none(), "a new example needs a line here");
    let written = folder
        .run("simulate panel.toml -o panel.h5 --truth truth.json --json")
        .exits(0)
        .json();
    assert_eq!(
        (&written["responses"], &written["references"]),
        (&77.into(), &34.into())
    );
    let rendered = folder.run("render truth.json scene.toml --method fast --json");
    assert!(rendered.code <= 1, "{}", rendered.stderr);
    assert_eq!(rendered.json()["scene"], "scene.toml");
    folder
        .run("select truth.json selection.toml -o kept.json -q")
        .exits(0);
}

/// The actions that a page asks of the reader, in its order.
enum Step {
    /// A file to save: its name, from the words before it, and its text.
    Save(String, String),
    /// A command without the name of the program.
    Run(String),
}

/// Commands of `sh` blocks, and `toml` and `csv` blocks after words that name a file in
/// backquotes.
fn steps(page: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let (mut rest, mut words) = (page, String::new());
    while let Some((before, after)) = rest.split_once("```") {
        words += before;
        let (kind, body) = after.split_once('\n').unwrap();
        let (body, tail) = body.split_once("```").unwrap();
        match kind {
            "toml" | "csv" => {
                let ending = format!(".{kind}");
                let name = words
                    .rsplit('`')
                    .find(|word| word.ends_with(&ending) && !word.contains([' ', '\n']));
                let name = name.map_or(format!("example{ending}"), str::to_owned);
                steps.push(Step::Save(name, body.to_owned()));
            }
            "sh" => steps.extend(body.lines().filter_map(command).map(Step::Run)),
            _ => {}
        }
        rest = tail;
    }
    steps
}

/// Arguments of `chladni` in a line of a shell; `None` for other programs.
fn command(line: &str) -> Option<String> {
    let line = line.split(" #").next().unwrap().trim();
    Some(line.strip_prefix("chladni ")?.trim().to_owned())
}

/// A measurement as 34 files, one for each reference, and as one universal file.
fn scans(folder: &Folder) {
    use chladni_frf::FrfValues;
    use chladni_io::{read_frf, write_contents, Contents};
    std::fs::create_dir(folder.path().join("scans")).unwrap();
    let (frf, ..) = read_frf(&[folder.path().join("panel.h5")], &Default::default()).unwrap();
    for (j, reference) in frf.references.iter().enumerate() {
        let FrfValues::F64(values) = &frf.values else {
            panic!("a simulation is of double precision")
        };
        let mut one = frf.clone();
        one.values = FrfValues::F64(values.slice(ndarray::s![.., j..j + 1, ..]).to_owned());
        one.references = vec![*reference];
        let file = folder
            .path()
            .join(format!("scans/scan_{}.uff", reference.node));
        write_contents(
            &file,
            &Contents {
                frf: Some(one),
                ..Contents::default()
            },
            false,
        )
        .unwrap();
    }
    std::fs::copy(
        folder.path().join("scans/scan_101.uff"),
        folder.path().join("measurement.uff"),
    )
    .unwrap();
}

/// The measured beam of part 3, and its natural frequencies as other programs find them,
/// with the largest difference between these, Hz.
const BEAM: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../shared/data/pyuff-beam/beam.uff"
);
const BEAM_HZ: [[f64; 2]; 5] = [
    [52.554, 0.003],
    [144.632, 0.002],
    [283.127, 0.003],
    [468.278, 0.003],
    [698.464, 0.010],
];

#[test]
fn the_tutorial_does_what_it_says() {
    let folder = Folder::new();
    let beam = std::fs::copy(BEAM, folder.path().join("beam.uff")).is_ok();
    if !beam {
        skipped("part 3 of the tutorial: beam.uff is not at hand");
    }
    for step in steps(TUTORIAL) {
        match step {
            Step::Run(line) if line.contains("beam") && !beam => {}
            Step::Save(name, text) => folder.write(&name, text),
            Step::Run(line) if line.starts_with("studio") => a_studio_starts(&folder, &line),
            Step::Run(line) => {
                if line.contains("measurement.uff") {
                    scans(&folder);
                }
                let wanted = if line.contains("--time-sign -") { 1 } else { 0 };
                let run = folder.run(&line);
                assert!(
                    run.code == wanted || (run.code == 1 && line.starts_with("render")),
                    "{line}: exit {}, {}",
                    run.code,
                    run.stderr
                );
            }
        }
    }
    // 34 files in a folder, and three commands later the stabilization diagram over their
    // CMIF
    let diagram = folder.text("measured.html");
    assert!(
        diagram.contains("\"stabilization\":{\"damping_ratio\"")
            && diagram.contains("of the measured FRFs")
    );
    for written in [
        "report.html",
        "scene.html",
        "figures/stabilization.svg",
        "figures/field-1.png",
        "drive.wav",
        "field.html",
        "all.uff",
    ] {
        assert!(folder.path().join(written).is_file(), "{written}");
    }
    the_loop_in_volts_closes(&folder);
    if beam {
        the_beam_is_found(&folder);
    }
}

/// Part 4, after the tutorial has been followed: its numbers are those of the page.
fn the_loop_in_volts_closes(folder: &Folder) {
    let judged = |number: usize, scene: &str| {
        let line = format!(
            "evaluate volts-{number}.json --scene {scene}.toml --on volts.json \
             --field scan-{number}.csv --json"
        );
        folder.run(&line).exits(0).json()["indices"]["points"].clone()
    };
    let before = judged(0, "corner");
    let quiet = 53.0 * before["cold_ratio"].as_f64().unwrap();
    assert!((quiet - 44.0).abs() < 2.5, "the page says 44: {quiet}");
    for after in [judged(1, "corner"), judged(2, "opposite")] {
        assert_eq!(after["min_ratio"], 1.0, "{after}");
        // 3 mA through 8.07 ohms
        let largest = after["max_voltage_v"].as_f64().unwrap();
        assert!(largest <= 0.0242, "{after}");
    }
    let rig: serde_json::Value = serde_json::from_str(&folder.text("rig.json")).unwrap();
    assert_eq!(rig["dead"], serde_json::json!(["108:+Z"]));
    assert_eq!(rig["gain_tables"][0]["gain"][1], 0.95);
    let sidecar: serde_json::Value = serde_json::from_str(&folder.text("coils.json")).unwrap();
    assert_eq!(sidecar["channels"][0]["full_scale"], 0.05);
    assert_eq!(sidecar["source"][3]["file"], "amplifiers.csv");
}

/// Part 3, after the tutorial has been followed.
fn the_beam_is_found(folder: &Folder) {
    let model = chladni_io::read_model(&folder.path().join("beam.json")).unwrap();
    let sure: Vec<f64> = model
        .in_band_modes()
        .filter(|mode| mode.trust == chladni_frf::Trust::Sure)
        .map(|mode| mode.frequency_hz)
        .collect();
    assert_eq!(sure.len(), BEAM_HZ.len(), "{sure:?}");
    for (found, [known, spread]) in sure.iter().zip(BEAM_HZ) {
        assert!(
            (found - known).abs() <= 2.0 * spread,
            "{found} Hz, known {known} Hz"
        );
    }
}

fn a_studio_starts(folder: &Folder, line: &str) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
    command
        .current_dir(folder.path())
        .args(line.split_whitespace())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut studio = command.spawn().unwrap();
    let mut url = String::new();
    BufReader::new(studio.stdout.take().unwrap())
        .read_line(&mut url)
        .unwrap();
    studio.kill().unwrap();
    studio.wait().unwrap();
    assert!(url.starts_with("http://127.0.0.1:"), "{url}");
}

#[test]
fn commands_of_the_other_pages_are_run() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o scan.uff -q").exits(0);
    std::fs::create_dir(folder.path().join("scans")).unwrap();
    let rows = (0..512).map(|k| {
        let time_s = f64::from(k) / 1024.0;
        let force_n = f64::from(u8::from(k == 1));
        let ringing = (-20.0 * time_s).exp() * (600.0 * time_s).sin();
        format!("{time_s},{force_n},{ringing}\n")
    });
    let hit = "t,force_N,acc_m_s2\n".to_owned() + &rows.collect::<String>();
    folder.write("hits_1.csv", hit);
    let scan = folder.path().join("scan.uff");
    std::fs::copy(&scan, folder.path().join("scans/scan_1.uff")).unwrap();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    folder
        .run("convert truth.json -o fe_shapes.unv -q")
        .exits(0);
    folder.write("selection.toml", "drop = [1]\n");
    std::fs::copy(
        folder.path().join("scan.uff"),
        folder.path().join("hammer.uff"),
    )
    .unwrap();

    // a bench would take hours: with a file in the way of its folder it ends after its
    // arguments were read
    folder.write("bench", "");
    let benches = Path::new(env!("CARGO_BIN_EXE_chladni")).with_file_name("chladni-bench");
    if !benches.with_extension(EXE_EXTENSION).is_file() {
        skipped(
            "the lines of `chladni bench`, which is not built (cargo test --release builds it)",
        );
    }
    let mut seen = 0;
    for page in [README, TROUBLESHOOTING, ACCURACY, PAPER] {
        for step in steps(page) {
            let line = match step {
                Step::Run(line) => line,
                Step::Save(name, text) => {
                    folder.write(&name, text);
                    continue;
                }
            };
            if line.starts_with("bench") && !benches.with_extension(EXE_EXTENSION).is_file() {
                continue;
            }
            if line.starts_with("studio") {
                a_studio_starts(&folder, &line);
                continue;
            }
            let run = folder.run(&format!(
                "{line} {}",
                if line.starts_with("bench") {
                    ""
                } else {
                    "--force"
                }
            ));
            let fine: &[i32] = if line.starts_with("bench") {
                &[73]
            } else {
                &[0, 1]
            };
            assert!(
                fine.contains(&run.code),
                "{line}: exit {}, {}",
                run.code,
                run.stderr
            );
            seen += 1;
        }
    }
    assert!(seen > 12, "only {seen} commands were found");
}

#[test]
fn the_first_hour_is_the_tutorials_second_part() {
    // its log is of commands that stand in the tutorial, the README or the demonstration,
    // which tests run
    let known: Vec<String> = [TUTORIAL, README]
        .iter()
        .flat_map(|page| steps(page))
        .filter_map(|step| match step {
            Step::Run(line) => Some(line.split_whitespace().next().unwrap().to_owned()),
            Step::Save(..) => None,
        })
        .collect();
    let logged: Vec<String> = FIRST_HOUR
        .lines()
        .filter_map(|line| command(line.trim_start_matches("$ ")))
        .collect();
    assert!(logged.len() >= 5, "{logged:?}");
    for line in logged {
        let verb = line.split_whitespace().next().unwrap();
        assert!(
            verb == "demo" || known.iter().any(|known| known == verb),
            "{line}"
        );
    }
}

#[test]
fn equations_of_the_theory_are_numbered_in_order() {
    let label = |line: &str| -> Option<usize> {
        line.trim_end()
            .strip_suffix(')')?
            .rsplit_once('(')?
            .1
            .parse()
            .ok()
    };
    let labels: Vec<usize> = THEORY
        .lines()
        .filter(|line| line.starts_with("    "))
        .filter_map(label)
        .collect();
    assert!(labels.len() > 30, "{labels:?}");
    assert_eq!(labels, (1..=labels.len()).collect::<Vec<_>>());
}

/// Folders and files below `folder`.
fn places(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            places(&path, out);
        }
        out.push(path);
    }
}

#[test]
fn sources_that_pages_name_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut known = Vec::new();
    ["crates", "benches", "fixtures"]
        .iter()
        .for_each(|folder| places(&root.join(folder), &mut known));
    for page in [ARCHITECTURE, THEORY, CONTRIBUTING, FIXTURES] {
        // every other part is a block of code
        let words = page.split("```").step_by(2).flat_map(|text| {
            let quoted = text.split('`').skip(1).step_by(2);
            quoted.filter(|word| {
                let is_place = [".rs", ".js", "/"].iter().any(|end| word.ends_with(end));
                is_place && !word.contains(['*', ' ', '\n'])
            })
        });
        for word in words {
            let is_there = known.iter().any(|path| path.ends_with(word));
            assert!(is_there || root.join(word).exists(), "{word}");
        }
    }
}

#[test]
fn every_help_page_says_its_purpose_and_examples_before_options() {
    let folder = Folder::new();
    let overview = folder.run("--help").exits(0).stdout;
    assert!(purpose_comes_first(&overview), "{overview}");
    let verbs: Vec<&str> = overview
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(verbs.contains(&"studio") && verbs.len() > 12, "{verbs:?}");
    for verb in verbs
        .into_iter()
        .filter(|verb| !matches!(*verb, "help" | "bench"))
    {
        let help = folder.run(&format!("{verb} --help")).exits(0).stdout;
        assert!(
            purpose_comes_first(&help),
            "{verb}: {}",
            &help[..help.len().min(200)]
        );
        let short = folder.run(&format!("{verb} -h")).exits(0).stdout;
        assert!(
            !short.contains("--threads") && (short.len() < help.len() || verb == "block"),
            "{verb}: {short}"
        );
    }
}

/// Checks that a help page has its purpose in a line or two, then examples, then usage.
fn purpose_comes_first(help: &str) -> bool {
    let place = |words: &str| help.find(words).unwrap_or(usize::MAX);
    (10..300).contains(&place("Examples:")) && place("Examples:") < place("Usage:")
}
