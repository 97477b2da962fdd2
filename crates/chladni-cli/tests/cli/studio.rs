//! The studio's server: access, and the questions that it answers.

use crate::common::studio::Studio;
use crate::common::Folder;
use serde_json::{json, Value};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

/// A scene with a hot zone on the small panel.
const SCENE: &str = "frequency_hz = 300.0\n[zones]\n[[zones.polygon]]\nkind = \"hot\"\n\
                     points_m = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]]\n";

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or("no answer")
}

/// The studio's reason for refusing a question.
fn complaint(answer: &Value) -> &str {
    answer["error"]
        .as_str()
        .unwrap_or_else(|| panic!("no complaint: {answer}"))
}

#[test]
fn without_the_token_everything_is_refused() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["truth.json"]);
    assert!(
        studio.url.starts_with("http://127.0.0.1:") && studio.token.len() >= 32,
        "{}",
        studio.url
    );
    let token = &studio.token;
    let other = if token.starts_with('0') { "1" } else { "0" };
    let wrong = [
        String::new(),
        format!("{}{}", other, &token[1..]),
        format!("{}x", &token[..token.len() - 1]),
        token[..token.len() - 1].to_owned(),
        format!("{token}0"),
        format!("{token},{token}"),
        "0".repeat(4000),
    ];
    let questions = [
        ("GET", "/"),
        ("HEAD", "/"),
        ("POST", "/"),
        ("GET", "/api/fit"),
        ("POST", "/api/fit"),
        ("POST", "/api/scene"),
        ("POST", "/api/start"),
        ("POST", "/api/data"),
        ("POST", "/api/progress"),
        ("POST", "/api/cancel"),
        ("POST", "/api/sweep"),
        ("POST", "/api/file"),
        ("OPTIONS", "/api/scene"),
        ("DELETE", "/nowhere"),
        ("GET", "/../../etc/hostname"),
    ];
    for (method, path) in questions {
        let plain = format!("{method} {path} HTTP/1.1\r\nHost: HERE");
        let mut heads = vec![plain.clone()];
        for token in &wrong {
            heads.push(format!("{plain}\r\nAuthorization: Bearer {token}"));
            heads.push(format!(
                "{method} {path}?token={token} HTTP/1.1\r\nHost: HERE"
            ));
        }
        for head in heads {
            let form = format!("{head}\r\nContent-Type: text/plain\r\nContent-Length: 9");
            for (head, body) in [(head.as_str(), ""), (&form, "number=1&")] {
                let answer = studio.asked(head, body);
                assert_eq!(status(&answer), "403", "{head}: {answer}");
            }
        }
    }
    let again = Studio::start(&folder, &["truth.json"]);
    assert_ne!(again.token, *token, "every run has a token of its own");
}

/// Page and questions carry the token, each in its own place. Another host or origin is refused
/// even with the token.
#[test]
fn with_the_token_only_the_page_and_its_own_questions_are_let_in() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["truth.json"]);
    let page = "GET /?token=TOKEN HTTP/1.1";
    let answer = studio.asked(&format!("{page}\r\nHost: HERE"), "");
    assert_eq!(status(&answer), "200");
    assert!(
        !answer.contains(&studio.token),
        "the page repeats the token"
    );
    for head in [
        "GET / HTTP/1.1\r\nHost: HERE\r\nAuthorization: Bearer TOKEN".to_owned(),
        "GET /?token=TOKEN HTTP/1.1\r\nHost: elsewhere.example".to_owned(),
        format!("{page}\r\nHost: HERE\r\nOrigin: http://elsewhere.example"),
        "POST /api/fit?token=TOKEN HTTP/1.1\r\nHost: HERE\r\nContent-Length: 0".to_owned(),
    ] {
        assert_eq!(status(&studio.asked(&head, "")), "403", "{head}");
    }
    // only questions in the form of the page
    let form = studio
        .head("fit", "")
        .replace("application/json", "text/plain");
    assert_eq!(status(&studio.asked(&form, "")), "415");
}

#[test]
fn no_question_reads_a_file() {
    let folder = Folder::with_panel();
    folder.write("table.csv", "secret,of,mine\n");
    let studio = Studio::start(&folder, &["truth.json"]);
    let scene = |profile: &str, threshold: Value| {
        let toml = format!("{SCENE}[threshold]\nprofile = {profile:?}\n");
        let question = json!({"toml": toml, "method": "fast", "threshold": threshold});
        studio.asked_about("scene", &question.to_string())
    };
    let there = folder.path().join("table.csv");
    for path in [
        "/etc/hostname",
        "/etc/passwd",
        "/dev/zero",
        "table.csv",
        "./table.csv",
        there.to_str().unwrap(),
        "/no/such/file",
    ] {
        for sent in [
            Value::Null,
            json!({"name": "mine.csv", "csv": "100,1e-4\n400,1e-4\n"}),
        ] {
            let answer = scene(path, sent);
            let said = complaint(&answer);
            assert!(
                said.contains("threshold.profile") && said.contains("no file is looked for"),
                "{path}: {said}"
            );
            assert!(!said.contains("secret"), "{said}");
        }
    }
    // a built-in profile by its name, and a table by its content
    assert!(scene("classic", Value::Null)["scene"].is_object());
    let table = json!({"name": "mine.csv", "csv": "100,1e-4\n400,1e-4\n"});
    let answer = scene("mine.csv", table);
    assert!(answer["scene"].is_object(), "{answer}");
    let damaged = scene("mine.csv", json!({"name": "mine.csv", "csv": "100,x\n"}));
    assert!(complaint(&damaged).contains("mine.csv"), "{damaged}");
    let disguised = scene(
        "paper",
        json!({"name": "paper", "csv": "100,1e-4\n400,1e-4\n"}),
    );
    assert!(
        complaint(&disguised).contains("threshold.name"),
        "{disguised}"
    );
}

#[test]
fn numbers_out_of_bounds_are_refused_by_name_and_the_next_question_is_answered() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["panel.h5"]);
    for (field, question) in [
        ("number", r#"{"number": 18446744073709551615}"#),
        ("number", r#"{"number": 9007199254740992}"#),
        ("page", r#"{"number": 1, "page": 1}"#),
        ("page", r#"{"number": 1, "page": 18446744073709551615}"#),
        ("modes", r#"{"number": 1, "modes": 18446744073709551615}"#),
        ("modes", r#"{"number": 1, "modes": 1001, "draft": true}"#),
        ("modes", r#"{"number": 1, "modes": 0}"#),
        ("band_hz", r#"{"number": 1, "band_hz": [0, 1e300]}"#),
        ("band_hz", r#"{"number": 1, "band_hz": [-1, 300]}"#),
        ("added_hz", r#"{"number": 1, "added_hz": [100, 0]}"#),
        ("added_hz", r#"{"number": 1, "added_hz": [-100]}"#),
    ] {
        let answer = studio.asked_about("fit", question);
        assert!(complaint(&answer).contains(field), "{question}: {answer}");
    }
    for question in [
        r#"{"number": -1}"#,
        r#"{"number": 1.5}"#,
        r#"{"number": 1, "modes": 1e300}"#,
        r#"{"number": 1, "band_hz": [0, 1e999]}"#,
        r#"{"number": 1, "file": "/etc/hostname"}"#,
    ] {
        let answer = studio.asked(&studio.head("fit", question), question);
        assert!(["400", "422"].contains(&status(&answer)), "{answer}");
    }
    // numbers within their bounds that ask too much are refused in words too
    for question in [
        r#"{"number": 1, "modes": 1000}"#,
        r#"{"number": 2, "modes": 1000, "draft": true}"#,
        r#"{"number": 3, "band_hz": [300, 300], "modes": 900}"#,
        r#"{"number": 4, "band_hz": [1e9, 1]}"#,
    ] {
        let answer = studio.asked_about("fit", question);
        assert!(
            !complaint(&answer).contains("internal"),
            "{question}: {answer}"
        );
    }
    let answer = studio.asked_about("fit", r#"{"number": 5}"#);
    assert!(answer["data"].is_object(), "{answer}");
}

#[test]
fn the_last_question_of_one_page_does_not_stop_those_of_the_next() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["panel.h5"]);
    for page in 1..=2 {
        let answer = studio.asked("GET /?token=TOKEN HTTP/1.1\r\nHost: HERE", "");
        assert!(answer.contains(&format!("{{\"page\":{page},")), "{answer}");
        let question = json!({"page": page, "number": 9007199254740991_u64, "draft": true});
        let answer = studio.asked_about("fit", &question.to_string());
        assert!(answer["draft"].is_object(), "{answer}");
    }
    let late = json!({"page": 1, "number": 9007199254740991_u64});
    assert_eq!(
        studio.asked_about("fit", &late.to_string()),
        json!({"overtaken": true})
    );
}

#[test]
fn a_fit_that_a_newer_question_has_overtaken_is_given_up() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["panel.h5"]);
    assert!(studio.asked_about("fit", r#"{"number": 5, "draft": true}"#)["draft"].is_object());
    assert_eq!(
        studio.asked_about("fit", r#"{"number": 3}"#),
        serde_json::json!({"overtaken": true})
    );
    // the last question is answered
    assert!(studio.asked_about("fit", r#"{"number": 6}"#)["data"].is_object());
}

#[test]
fn the_data_are_shown_before_any_fit_and_a_fit_tells_its_stages() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["panel.h5"]);
    let start = studio.asked_about("start", "{}");
    let data = &start["data"];
    assert_eq!(data["responses"], 24, "{start}");
    assert!(data["frfs"]["sums"]["measured"].is_object());
    assert_eq!(data["geometry"]["places"].as_array().unwrap().len(), 24);
    let over = |studio: &Studio| studio.asked_about("progress", "{}")["over"].clone();
    assert_eq!(over(&studio), json!([]), "nothing was asked for yet");
    assert!(studio.asked_about("fit", r#"{"number": 1}"#)["data"].is_object());
    let stages = over(&studio);
    assert!(stages.as_array().unwrap().len() >= 3, "{stages}");
    // the other data are drawn afterwards, while that fit is the last one
    let light = studio.asked_about("fit", r#"{"number": 2, "light": true}"#);
    assert!(light["draft"]["model"].is_object() && light["data"].is_null());
    assert!(light["head"]["sentence"]
        .as_str()
        .unwrap()
        .contains("sure modes"));
    let drawn = studio.asked_about("data", r#"{"number": 2}"#);
    assert!(drawn["data"]["frfs"]["residuals"].is_object());
    let overtaken = json!({"overtaken": true});
    assert_eq!(studio.asked_about("data", r#"{"number": 1}"#), overtaken);
    // cancelling after the end of a fit does not cancel the next one
    studio.asked_about("cancel", "{}");
    assert!(studio.asked_about("fit", r#"{"number": 3}"#)["data"].is_object());
}

#[test]
fn files_that_the_studio_hands_over_are_those_of_the_command_line() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["truth.json"]);
    let scene = json!({"toml": SCENE, "method": "mls", "selection": "drop = [1]\n"});
    let file = |name: &str, scene: Option<&Value>| -> Vec<u8> {
        let question =
            json!({"name": name, "selection": "drop = [1]\n", "scene": scene}).to_string();
        let answer = studio.asked_bytes(&studio.head("file", &question), &question);
        let split = answer
            .windows(4)
            .position(|four| four == b"\r\n\r\n")
            .unwrap();
        assert!(answer.starts_with(b"HTTP/1.1 200"), "{name}");
        answer[split + 4..].to_vec()
    };
    for (selection, words) in [
        ("drop = [0]", "drop[1]"),
        ("drop = [99]", "no such mode"),
        ("dear diary", "selection.toml"),
        ("add = [{frequency_hz = 100.0}]", "a new fit"),
    ] {
        let question = json!({"toml": SCENE, "method": "mls", "selection": selection});
        let said = studio.asked_about("scene", &question.to_string());
        assert!(complaint(&said).contains(words), "{selection}: {said}");
    }
    folder.write("selection.toml", "drop = [1]\n");
    folder.write("scene.toml", SCENE);
    folder
        .run("select truth.json selection.toml -o selected.json -q")
        .exits(0);
    let modes = |text: &[u8]| {
        let model: Value = serde_json::from_slice(text).unwrap();
        model["modes"].as_array().unwrap().len()
    };
    assert_eq!(
        modes(&file("model.json", None)),
        modes(&folder.read("selected.json"))
    );
    let rendered = folder
        .run("render selected.json scene.toml --method mls -o weights.json -q --wav drive.wav");
    assert!(rendered.code <= 1, "{}", rendered.stderr);
    let amplitudes = |text: &[u8]| {
        let weights: Value = serde_json::from_slice(text).unwrap();
        weights["weights"].clone()
    };
    let weights = file("weights.json", Some(&scene));
    assert_eq!(
        amplitudes(&weights),
        amplitudes(&folder.read("weights.json"))
    );
    assert!(file("drive.wav", Some(&scene)) == folder.read("drive.wav"));
    assert!(file("report.html", Some(&scene)).starts_with(b"<!doctype html>"));
    let unknown = r#"{"name": "../secret"}"#;
    let refused = studio.asked(&studio.head("file", unknown), unknown);
    assert_eq!(status(&refused), "422");
    let without = r#"{"name": "weights.json"}"#;
    let refused = studio.asked(&studio.head("file", without), without);
    assert!(
        status(&refused) == "422" && refused.contains("no scene"),
        "{refused}"
    );
}

#[test]
fn a_sweep_has_bounds() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["truth.json"]);
    let sweep = |range: Value| {
        let question = json!({"toml": SCENE, "method": "default", "range_hz": range});
        studio.asked_about("sweep", &question.to_string())
    };
    let found = sweep(json!([298.0, 301.0]));
    assert_eq!(
        found["sweep"]["frequencies"].as_array().unwrap().len(),
        2,
        "{found}"
    );
    assert!(complaint(&sweep(Value::Null)).contains("range_hz"));
    assert!(complaint(&sweep(json!([1.0, 1e9]))).contains("sweep"));
    assert!(complaint(&sweep(json!([1.0, 1e300]))).contains("range_hz"));
}

/// Connections that send half of a request.
fn slow_connections(studio: &Studio, count: usize) -> Vec<TcpStream> {
    (0..count)
        .map(|_| {
            let mut stream = TcpStream::connect(&studio.address).unwrap();
            stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect()
}

#[test]
fn slow_connections_cost_no_threads_and_hold_nobody_up() {
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &["truth.json"]);
    let threads = || {
        std::fs::read_dir(format!("/proc/{}/task", studio.id()))
            .map_or(0, |threads| threads.count())
    };
    studio.asked("GET / HTTP/1.1\r\nHost: HERE", "");
    let before = threads();
    let held = slow_connections(&studio, 300);
    let start = Instant::now();
    let answer = studio.asked("GET /?token=TOKEN HTTP/1.1\r\nHost: HERE", "");
    assert_eq!(status(&answer), "200");
    assert!(start.elapsed() < Duration::from_secs(10));
    assert!(
        threads() <= before,
        "{} threads, {before} before",
        threads()
    );
    // each is closed after the deadline
    let mut answer = Vec::new();
    for mut stream in held {
        stream
            .set_read_timeout(Some(Duration::from_secs(30)))
            .unwrap();
        let end = stream.read_to_end(&mut answer);
        assert!(end.is_ok() || start.elapsed() < Duration::from_secs(30));
    }
    assert!(start.elapsed() < Duration::from_secs(30));
}

#[cfg(unix)]
#[test]
fn more_connections_than_the_system_allows_do_not_end_the_studio() {
    let folder = Folder::with_panel();
    let mut limited = Command::new("bash");
    limited
        .args(["-c", "ulimit -n 64; exec \"$0\" studio truth.json"])
        .arg(env!("CARGO_BIN_EXE_chladni"));
    let studio = Studio::of_command(&folder, limited);
    drop(slow_connections(&studio, 100));
    let answer = studio.asked("GET /?token=TOKEN HTTP/1.1\r\nHost: HERE", "");
    assert_eq!(status(&answer), "200", "{answer}");
}

/// The commands that the page offers for copying name the right files, whatever characters the
/// names contain.
#[cfg(unix)]
#[test]
fn commands_that_are_copied_quote_file_names() {
    let folder = Folder::with_panel();
    let names = [
        "; touch X",
        "$(touch X)",
        "it's `touch X` & more",
        "-X",
        "a\nb",
    ];
    for name in names {
        let (data, model) = (format!("{name}.h5"), format!("{name}.json"));
        folder.write(&data, folder.read("panel.h5"));
        folder.write(&model, folder.read("truth.json"));
        let of_data = Studio::start(&folder, &["--frf-kind", "mobility", "--", &data]);
        let fitted = of_data.asked_about("fit", r#"{"number": 1}"#);
        let of_model = Studio::start(&folder, &["--", &model]);
        let question = json!({"toml": SCENE, "method": "fast"});
        let rendered = of_model.asked_about("scene", &question.to_string());
        let shown = of_model.asked_about("fit", r#"{"number": 1}"#);
        folder.write("scene.toml", SCENE);
        let select = format!(
            "chladni select {} selection.toml -o selected.json",
            shown["model_file"].as_str().unwrap()
        );
        folder.write("selection.toml", "drop = [1]\n");
        let commands = [
            fitted["command"].as_str().unwrap(),
            rendered["command"].as_str().unwrap(),
            &select,
        ];
        for (command, output) in commands.into_iter().zip(["model", "weights", "selected"]) {
            let script = format!(
                "chladni() {{ {:?} \"$@\" -q; }}\n{command}",
                env!("CARGO_BIN_EXE_chladni")
            );
            let run = Command::new("bash")
                .args(["-c", &script])
                .current_dir(folder.path())
                .output()
                .unwrap();
            let stderr = String::from_utf8_lossy(&run.stderr);
            assert!(
                matches!(run.status.code(), Some(0 | 1)),
                "{command}: {stderr}"
            );
            let written = folder.path().join(format!("{output}.json"));
            std::fs::remove_file(written).unwrap_or_else(|error| panic!("{command}: {error}"));
        }
        assert!(!folder.names().contains(&"X".to_owned()), "{name} was run");
    }
}
