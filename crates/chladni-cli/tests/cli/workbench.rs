//! The studio in a real headless Chromium: changes of zones, band and poles, and the results that
//! follow.

use crate::common::browser::Page;
use crate::common::studio::Studio;
use crate::common::Folder;
use serde_json::Value;

/// The best drive is shown, and nothing is being computed.
pub const AT_REST: &str = "document.querySelector('#result')?.dataset.method === 'robust' && \
                       document.querySelector('#scene-status').textContent === ''";
pub const CTRL: u32 = 2;

/// A studio of the small panel in a window of 1280 × 800 px, after the first drive; `None`
/// without a browser.
pub fn workbench(input: &str) -> Option<(Folder, Studio, Page)> {
    let mut page = Page::new(1280, 800, false)?;
    let folder = Folder::with_panel();
    let studio = Studio::start(&folder, &[input]);
    page.open(&studio.url);
    page.wait(AT_REST);
    Some((folder, studio, page))
}

/// The weights that the studio shows, as its table has them.
pub fn shown_weights(page: &mut Page) -> Vec<(String, f64)> {
    let rows = page.eval(
        "[...document.querySelectorAll('#result details tbody tr')].map((row) => \
         [...row.cells].map((cell) => cell.textContent))",
    );
    let rows: Vec<Vec<String>> = serde_json::from_value(rows).unwrap();
    rows.into_iter()
        .map(|row| (row[0].clone(), row[1].parse().unwrap()))
        .collect()
}

/// Left, top, right and bottom of a zone's outline in the window.
fn zone(page: &mut Page, number: usize) -> [f64; 4] {
    let found = format!(
        "(() => {{ const r = document.querySelector('#zone-board path[data-zone=\"{number}\"]').getBoundingClientRect(); \
         return [r.left, r.top, r.right, r.bottom]; }})()"
    );
    serde_json::from_value(page.eval(&found)).unwrap()
}

/// The changes by `act`: the scene's text, and the best weights.
fn changes(page: &mut Page, what: &str, act: impl FnOnce(&mut Page)) -> String {
    let (text, weights) = (page.text("#scene-toml"), shown_weights(page));
    act(page);
    assert_ne!(page.text("#scene-toml"), text, "{what}");
    page.wait(AT_REST);
    let after = shown_weights(page);
    let moved = |(a, b): (&(String, f64), &(String, f64))| (a.1 - b.1).abs() > 1e-3;
    assert!(
        weights.len() != after.len() || weights.iter().zip(&after).any(moved),
        "{what}: {weights:?} {after:?}"
    );
    page.text("#scene-toml")
}

fn zones_in(toml: &str) -> usize {
    toml.matches("[[zones.polygon]]").count()
}

#[test]
fn zones_are_drawn_moved_resized_and_deleted_and_the_weights_follow() {
    let Some((_folder, studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let [x, y, width, height] = page.place("#zone-board");
    let board = |a: f64, b: f64| [x + a * width, y + b * height];
    let drawn = changes(&mut page, "drawn", |page| {
        page.eval("document.querySelector('input[value=hot]').click()");
        page.drag(board(0.55, 0.2), board(0.85, 0.45));
    });
    assert_eq!(zones_in(&drawn), 2);
    let [left, top, right, bottom] = zone(&mut page, 1);
    let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
    changes(&mut page, "moved", |page| {
        page.drag(middle, [middle[0] - 60.0, middle[1] + 40.0])
    });
    let [.., right, bottom] = zone(&mut page, 1);
    let resized = changes(&mut page, "resized", |page| {
        page.drag([right, bottom], [right + 50.0, bottom + 30.0])
    });
    let louder = changes(&mut page, "louder", |page| {
        page.eval("(() => { const i = document.querySelector('#zone-level'); i.value = 3; i.dispatchEvent(new Event('change')); })()");
    });
    assert!(louder.contains("level_db = 3.0"), "{louder}");
    let deleted = changes(&mut page, "deleted", |page| {
        page.eval("document.querySelector('#zone-delete').click()");
    });
    assert_eq!(zones_in(&deleted), 1);
    // undo and redo; the same after the page is opened again
    for wanted in [&louder, &resized] {
        page.eval("document.querySelector('#undo').click()");
        assert_eq!(&page.text("#scene-toml"), wanted);
    }
    page.eval("document.querySelector('#redo').click()");
    assert_eq!(page.text("#scene-toml"), louder);
    let address = page.eval("location.href");
    assert!(address.as_str().unwrap().starts_with(&studio.url));
    page.reload();
    page.wait(AT_REST);
    assert_eq!(page.text("#scene-toml"), louder);
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn zones_are_worked_by_keys_and_say_what_they_are() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let named =
        "document.querySelector('#zone-board [data-focus=\"zone-0\"]').getAttribute('aria-label')";
    page.eval("document.querySelector('#zone-board [data-focus=\"zone-0\"]').focus()");
    let before = page.eval(named);
    page.keys("ArrowRight", 3);
    let moved = page.eval(named);
    assert_ne!(before, moved);
    page.key_with("ArrowUp", CTRL);
    assert_ne!(page.eval(named), moved, "resized");
    assert_eq!(
        page.eval("document.activeElement.dataset.focus"),
        "zone-0",
        "the focus stays on the zone"
    );
    page.key("Delete");
    assert_eq!(zones_in(&page.text("#scene-toml")), 0);
    assert_eq!(page.text("#scene-status"), "draw a hot zone");
    page.key_with("z", CTRL);
    assert_eq!(zones_in(&page.text("#scene-toml")), 1);
    // the drive, by its grip and by the keys of the page
    let hz = "Number(document.querySelector('#scene-frequency').value)";
    let drive = page.eval(hz).as_f64().unwrap();
    page.eval("document.querySelector('#drive').focus()");
    page.keys("ArrowRight", 2);
    page.key("]");
    assert_eq!(page.eval(hz).as_f64().unwrap(), drive + 3.0);
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn an_actuator_that_is_switched_off_drives_nothing() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let before = shown_weights(&mut page);
    let place = "(() => { const r = document.querySelector('#zone-board circle.actuator').getBoundingClientRect(); \
                 return [r.left + r.width / 2, r.top + r.height / 2]; })()";
    let at: [f64; 2] = serde_json::from_value(page.eval(place)).unwrap();
    let toml = changes(&mut page, "switched off", |page| page.click(at));
    assert!(toml.contains("[actuators]\nuse = ["), "{toml}");
    let driven = |weights: &[(String, f64)]| weights.iter().filter(|weight| weight.1 > 0.0).count();
    assert!(driven(&shown_weights(&mut page)) < driven(&before));
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn commands_of_the_studio_do_the_same_again() {
    let Some((folder, _studio, mut page)) = workbench("panel.h5") else {
        return;
    };
    // a narrower band is fitted, and every command shown gives what is shown
    page.eval("(() => { const i = document.querySelector('#pane-1 input[aria-label^=\"band from\"]'); i.value = 100; i.dispatchEvent(new Event('change')); })()");
    page.wait("document.documentElement.dataset.fits === '2'");
    page.wait(AT_REST);
    let [fit, render] = ["#fit-command", "#scene-command"].map(|id| page.text(id));
    assert!(fit.contains("--band 100"), "{fit}");
    folder.write("scene.toml", page.text("#scene-toml"));
    let bare = |command: &str| command.strip_prefix("chladni ").unwrap().to_owned();
    folder.run(&bare(&fit)).exits(0);
    assert!(folder.run(&bare(&render)).code <= 1);
    let weights: Value = serde_json::from_str(&folder.text("weights.json")).unwrap();
    for (written, (reference, amplitude)) in weights["weights"]
        .as_array()
        .unwrap()
        .iter()
        .zip(shown_weights(&mut page))
    {
        assert_eq!(written["reference"], reference.as_str());
        assert!(
            (1e3 * written["amplitude"].as_f64().unwrap() - amplitude).abs()
                < 1e-3 * amplitude.max(0.1),
            "{reference}: {amplitude} {written}"
        );
    }
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn a_threshold_is_chosen_by_name_or_sent_along_as_a_table() {
    let Some((folder, studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let plain = page.text("#scene-toml");
    assert!(!plain.contains("profile"), "{plain}");
    page.eval("(() => { const s = document.querySelector('#scene-threshold'); s.value = 'classic'; s.dispatchEvent(new Event('change')); })()");
    page.wait(AT_REST);
    assert!(page.text("#scene-toml").contains("profile = \"classic\""));
    page.eval(
        "(() => { const list = new DataTransfer(); list.items.add(new File(['100,1e-5\\n900,1e-5\\n'], 'it\"s mine.csv')); \
         const input = document.querySelector('#scene-threshold-table'); input.files = list.files; input.dispatchEvent(new Event('change')); })()",
    );
    page.wait("document.querySelector('#scene-toml').value.includes('mine.csv')");
    page.wait(AT_REST);
    let toml = page.text("#scene-toml");
    assert!(toml.contains(r#"profile = "it\"s mine.csv""#), "{toml}");
    // the shown drive is that of the command for the scene beside that table
    folder.write("scene.toml", &toml);
    folder.write("it\"s mine.csv", "100,1e-5\n900,1e-5\n");
    let command = page.text("#scene-command");
    let rendered = folder.run(&format!(
        "{} --json",
        command.strip_prefix("chladni ").unwrap()
    ));
    assert!(rendered.code <= 1, "{}", rendered.stderr);
    // opened again, the page continues
    page.open(&studio.url);
    page.wait(AT_REST);
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// Natural frequencies that the pole table shows, Hz.
fn shown_frequencies(page: &mut Page) -> Vec<f64> {
    let cells = page.eval("[...document.querySelector('.pole-table').tBodies[0].rows].map((row) => parseFloat(row.cells[2].textContent))");
    serde_json::from_value(cells).unwrap()
}

#[test]
fn fit_weights_and_field_follow_the_band_while_it_is_dragged() {
    let Some((_folder, _studio, mut page)) = workbench("panel.h5") else {
        return;
    };
    let all = shown_frequencies(&mut page);
    let measured = "document.querySelector('#frf-magnitude path[data-name=measured]')";

    // the lower end of the band is dragged and held
    let [x, y, width, height] = page.place("#band-from");
    let (from, to) = (
        [x + width / 2.0, y + height / 2.0],
        [x + width / 2.0 + 80.0, y + height / 2.0],
    );
    page.drag_and_hold(from, to);
    page.wait("document.querySelector('#fit-status').textContent.endsWith('modes, draft')");
    page.wait("document.querySelector('#result').dataset.method === 'pressure-matching'");
    assert_eq!(
        page.eval("document.documentElement.dataset.fits"),
        "1",
        "no full fit while the hand holds on"
    );
    let low = page
        .eval("Number(document.querySelector('#band-from').getAttribute('aria-valuenow'))")
        .as_f64()
        .unwrap();
    assert!(low > 80.0, "{low}");
    let wanted = all.iter().filter(|&&hz| hz > low).count();
    page.wait(&format!(
        "document.querySelector('.pole-table').tBodies[0].rows.length === {wanted}"
    ));
    let draft = shown_frequencies(&mut page);
    assert!(draft.iter().all(|&hz| hz > low), "{draft:?}");
    let points = page.eval(&format!("{measured}.getAttribute('d').length"));
    assert!(points.as_u64().unwrap() > 1000, "measured FRFs stay");
    assert!(!page.text("#fit-command").contains("--band"));

    // and released
    page.release(to);
    page.wait("document.documentElement.dataset.fits === '2'");
    page.wait(AT_REST);
    assert!(page.text("#fit-command").contains("--band"));
    let full = shown_frequencies(&mut page);
    assert_eq!(full.len(), draft.len());
    let near = |(full, draft): (&f64, &f64)| (full / draft - 1.0).abs() < 1e-4;
    assert!(full.iter().zip(&draft).all(near), "{full:?} {draft:?}");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn a_dropped_pole_leaves_the_rendering_and_the_file() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let before = shown_weights(&mut page);
    page.eval("document.querySelector('input[data-mode=\"3\"]').click()");
    page.wait("document.querySelector('#scene-status').textContent !== ''");
    page.wait(AT_REST);
    assert!(page.text("#selection-toml").contains("drop = [3]"));
    assert!(page.text("#scene-command").contains("selected.json"));
    assert_ne!(shown_weights(&mut page), before);
    page.key_with("z", CTRL);
    assert!(!page.text("#selection-toml").contains("drop ="));
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn a_pole_added_by_hand_changes_the_model() {
    let Some((_folder, _studio, mut page)) = workbench("panel.h5") else {
        return;
    };
    let all = shown_frequencies(&mut page);
    // fewer modes than in the band
    page.eval(&format!(
        "(() => {{ const i = document.querySelector('#modes'); i.value = {}; i.dispatchEvent(new Event('change')); }})()",
        all.len() - 4
    ));
    page.wait("document.documentElement.dataset.fits === '2'");
    page.wait(AT_REST);
    let few = shown_frequencies(&mut page);
    let missing = all
        .iter()
        .find(|hz| few.iter().all(|other| (*hz / other - 1.0).abs() > 1e-3));
    let missing = *missing.unwrap();
    page.eval("document.querySelector('#add-pole').click()");
    page.eval(&format!(
        "(() => {{ document.querySelector('#add-hz').value = {missing:.1}; document.querySelector('#add-there').click(); }})()"
    ));
    page.wait("document.documentElement.dataset.fits === '3'");
    page.wait(AT_REST);
    let more = shown_frequencies(&mut page);
    assert_eq!(more.len(), few.len() + 1);
    assert!(more.iter().any(|hz| (hz / missing - 1.0).abs() < 1e-3));
    let added = page.text(".added-row");
    assert!(added.contains("sure") || added.contains("weak"), "{added}");
    assert!(page.text("#added-toml").contains("add = [{frequency_hz = "));
    assert!(page.text("#add-command").contains("-o added.json"));
    assert!(page.text("#scene-command").contains("render added.json"));
    page.eval("document.querySelector('#undo').click()");
    page.wait("document.documentElement.dataset.fits === '4'");
    assert_eq!(shown_frequencies(&mut page).len(), few.len());
    // far beyond the band there is no mode
    page.eval("document.querySelector('#add-pole').click()");
    page.eval("(() => { document.querySelector('#add-hz').value = 5000; document.querySelector('#add-there').click(); })()");
    page.wait("document.documentElement.dataset.fits === '5'");
    let added = page.text(".added-row");
    assert!(added.contains("5000 Hz: no mode came of it"), "{added}");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn a_drive_outside_the_band_of_the_model_is_met_with_a_reservation() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    page.eval("(() => { const i = document.querySelector('#scene-frequency'); i.value = 480; i.dispatchEvent(new Event('change')); })()");
    page.wait(AT_REST);
    let said = page.text(".sentence");
    assert!(said.contains("Scene met at 480"), "{said}");
    let but = "but only in a model of other frequencies";
    assert!(said.contains(but), "{said}");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// Number of pointer moves.
const MOVES: usize = 50;
/// 2·10⁷ square roots in the page, whose time measures the speed of the machine, and the number
/// of repetitions; the first warms up.
const ROOTS: &str =
    "(() => { let sum = 0; for (let k = 0; k < 2e7; k++) sum += Math.sqrt(k); return sum; })()";
const ROOTS_TAKEN: usize = 3;
/// The page's work for a move, over that: a picture in 50 ms on a machine that takes a
/// root in 3.1 ns, and sooner on one that is not as busy.
const MOVE_OVER_ROOTS: f64 = 0.8;

/// From a move of the hand to the field that it makes, measured in the page.
const LATENCY: &str = "(() => { window.waits = []; let since = 0; \
    document.querySelector('#zone-board').addEventListener('pointermove', () => { since = performance.now(); }, true); \
    new MutationObserver(() => { if (since) { window.waits.push(performance.now() - since); since = 0; } }) \
      .observe(document.querySelector('#result'), { attributes: true, attributeFilter: ['data-answers'] }); })()";

#[test]
fn a_drag_shows_the_field_at_once_on_the_demonstration_panel() {
    let Some(mut page) = Page::new(1280, 800, false) else {
        return;
    };
    let folder = Folder::new();
    folder.write("panel.toml", "");
    folder
        .run("simulate panel.toml -o panel.h5 --truth truth.json -q")
        .exits(0);
    let studio = Studio::start(&folder, &["panel.h5"]);
    let first_ms = page.open(&studio.url);
    page.wait(AT_REST);
    page.wait("document.documentElement.dataset.fits === '1'");
    page.eval(LATENCY);
    let [left, top, right, bottom] = zone(&mut page, 0);
    let from = [0.5 * (left + right) + 5.0, 0.5 * (top + bottom)];
    page.drag_and_hold(from, [from[0] - 20.0, from[1]]);
    let before_s = page.worked_s();
    let answered = "window.waits.length";
    for k in 0..MOVES {
        let known = page.eval(answered).as_u64().unwrap();
        let to = [
            from[0] + 10.0 * (k % 7) as f64,
            from[1] - 10.0 * (k % 5) as f64,
        ];
        page.move_to(to);
        page.wait(&format!("{answered} > {known}"));
    }
    let work_s = (page.worked_s() - before_s) / MOVES as f64;
    page.release(from);
    let waits = page.eval("window.waits.sort((a, b) => a - b)");
    let waits: Vec<f64> = serde_json::from_value(waits).unwrap();
    println!(
        "first picture after {first_ms} ms; a move shows its field after {:.0} ms (median of {}), \
         {:.0} ms of work in the page",
        waits[waits.len() / 2],
        waits.len(),
        1e3 * work_s
    );
    assert!(waits.len() >= MOVES);
    let roots_s = (0..ROOTS_TAKEN)
        .map(|_| {
            let before_s = page.worked_s();
            page.eval(ROOTS);
            page.worked_s() - before_s
        })
        .fold(f64::INFINITY, f64::min);
    println!(
        "a move works {:.2} times as long as 2·10⁷ roots",
        work_s / roots_s
    );
    assert!(
        work_s < MOVE_OVER_ROOTS * roots_s,
        "{work_s} s, {roots_s} s"
    );
    assert_eq!(page.complaints(), Vec::<String>::new());
}
