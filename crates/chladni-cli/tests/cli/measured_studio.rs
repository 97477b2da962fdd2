//! A measured field in the studio, in a real headless Chromium: opened, explained, corrected and
//! downloaded.

use crate::common::browser::Page;
use crate::common::Folder;
use crate::workbench::{shown_weights, workbench, AT_REST};
use serde_json::Value;

/// Keeps the text of every file that the page saves, by its name.
pub const SAVED: &str = "(() => { window.saved = {}; const make = URL.createObjectURL; \
    let last = null; URL.createObjectURL = (blob) => { last = blob.text(); return make.call(URL, blob); }; \
    HTMLAnchorElement.prototype.click = function () { const name = this.download; last.then((text) => { window.saved[name] = text; }); }; })()";

/// Opens text as the measured field, as if a file was chosen.
fn open_field(page: &mut Page, name: &str, csv: &str) {
    page.eval(&format!(
        "(() => {{ const files = new DataTransfer(); files.items.add(new File([{csv:?}], {name:?})); \
         const input = document.querySelector('#measured-file'); input.files = files.files; \
         input.dispatchEvent(new Event('change')); }})()"
    ));
}

/// A file of the download menu.
pub fn downloaded(page: &mut Page, name: &str) -> Value {
    page.eval(&format!(
        "(() => {{ delete window.saved[{name:?}]; document.querySelector('#download [data-file=\"{name}\"]').click(); }})()"
    ));
    let text = page.wait(&format!("window.saved[{name:?}]"));
    serde_json::from_str(text.as_str().unwrap()).unwrap()
}

/// Amplitude of a channel in a weights file, N; 0 where the file lacks it.
fn amplitude(weights: &Value, reference: &str) -> f64 {
    let list = weights["weights"].as_array().unwrap();
    let same = list.iter().find(|one| one["reference"] == reference);
    same.map_or(0.0, |one| one["amplitude"].as_f64().unwrap())
}

/// The scene of the page rendered by the program, its strongest channel dead, and the
/// field that the panel then makes: the channel and the field's file.
fn played(folder: &Folder, toml: &str) -> (String, String) {
    folder.write("shown.toml", toml);
    // a scene that is not met is rendered all the same
    let run = folder.run("render truth.json shown.toml --method best -o w0.json -q");
    assert!(run.code <= 1, "{}", run.stderr);
    let mut weights: Value = serde_json::from_str(&folder.text("w0.json")).unwrap();
    let list = weights["weights"].as_array_mut().unwrap();
    let size = |one: &Value| one["amplitude"].as_f64().unwrap();
    let strongest = list
        .iter_mut()
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .unwrap();
    for key in ["re", "im", "amplitude"] {
        strongest[key] = 0.0.into();
    }
    let dead = strongest["reference"].as_str().unwrap().to_owned();
    folder.write("dead.json", weights.to_string());
    folder
        .run("simulate panel.toml --play dead.json -o played.csv --snr-db 40 --seed 3 -q")
        .exits(0);
    (dead, folder.text("played.csv"))
}

/// The field without the checksum of the weights that it was played by.
fn unnamed(field: &str) -> String {
    let lines = field
        .lines()
        .filter(|line| !line.contains("weights_sha256"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The drive of the page and its file are those of the command that the page shows.
fn is_what_the_command_gives(
    folder: &Folder,
    field: &str,
    shown: &[(String, f64)],
    downloaded: &Value,
) {
    folder.write("field-1.csv", field);
    let run = folder
        .run("correct truth.json shown.toml --weights w0.json --field field-1.csv -o w1.json -q");
    assert!(run.code <= 1, "{}", run.stderr);
    let w1: Value = serde_json::from_str(&folder.text("w1.json")).unwrap();
    for (reference, millinewton) in shown {
        for weights in [&w1, downloaded] {
            let amplitude = 1e3 * amplitude(weights, reference);
            assert!(
                (amplitude - millinewton).abs() <= 0.01 * amplitude + 1e-3,
                "{reference}: {amplitude} {millinewton}"
            );
        }
    }
}

#[test]
fn a_measured_field_is_explained_corrected_and_taken_along() {
    let Some((folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    page.eval(SAVED);
    let (dead, field) = played(&folder, &page.text("#scene-toml"));
    let field = unnamed(&field);
    open_field(&mut page, "field-1.csv", &field);
    page.wait("document.documentElement.dataset.measuredFields === '1'");
    assert_eq!(
        page.eval("document.querySelector('#tab-measured').getAttribute('aria-selected')"),
        "true"
    );
    let responses = field.lines().filter(|line| line.contains(":+Z")).count();
    // a map is drawn once its place has a size
    page.wait(&format!(
        "document.querySelectorAll('#measured-field .measured-point').length === {responses}"
    ));
    let said = page.text(".sentence");
    assert!(
        said.contains("The measured field") && said.contains(&dead),
        "{said}"
    );
    assert!(page
        .text("#causes tbody tr")
        .contains(&format!("channel {dead} gives no force")));
    assert!(page
        .text("#measured-command")
        .contains("--field field-1.csv"));
    let before = shown_weights(&mut page);
    let rendered = downloaded(&mut page, "weights.json");
    assert!(amplitude(&rendered, &dead) > 0.0);
    assert_eq!(page.text("#use"), "Correct");
    page.eval("document.querySelector('#use').click()");
    page.wait("document.documentElement.dataset.corrections === '1'");
    assert!(page.text(".sentence").starts_with("Corrected from 1 field"));
    let after = shown_weights(&mut page);
    assert_ne!(before, after);
    let corrected = downloaded(&mut page, "weights.json");
    let calibration = downloaded(&mut page, "calibration.json");
    assert_eq!(calibration["dead"][0], dead.as_str());
    is_what_the_command_gives(&folder, &field, &after, &corrected);
    assert!(page
        .text("#correct-command")
        .contains("--weights weights.json --field field-1.csv -o weights-1.json"));
    // after another drive the measured field is forgotten
    page.key("]");
    page.wait(AT_REST);
    assert!(!page.text(".sentence").contains("Corrected"));
    assert_eq!(page.text("#measured-command"), "");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn a_bad_field_is_refused_by_name_and_changes_nothing() {
    let Some((folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let (_, field) = played(&folder, &page.text("#scene-toml"));
    let good = unnamed(&field);
    let sentence = page.text(".sentence");
    let unit = good.lines().find(|line| line.contains("unit")).unwrap();
    for (name, csv, words) in [
        ("other.csv", field.clone(), "of other weights"),
        ("unit.csv", good.replace(unit, ""), "does not say its unit"),
        (
            "stranger.csv",
            good.replace("\n1:+Z", "\n4711:+Z"),
            "4711:+Z",
        ),
        ("notes.csv", "dear diary\n".to_owned(), "notes.csv"),
    ] {
        open_field(&mut page, name, &csv);
        page.wait(&format!(
            "document.querySelector('#field-error').textContent.includes({name:?})"
        ));
        let said = page.text("#field-error");
        assert!(said.contains(words), "{name}: {said}");
        assert_eq!(page.text(".sentence"), sentence, "{name}");
        assert_eq!(
            page.eval("document.querySelectorAll('.measured-point').length"),
            0,
            "{name}"
        );
        let [_, _, wide, high] = page.place("#field-error");
        assert!(wide > 200.0 && high > 10.0, "{name}: {wide} × {high}");
    }
    assert_eq!(page.text("#measured-command"), "");
}
