//! The report in a real headless Chromium: clicks, drags, keys, and the content of the page.

use crate::common::browser::Page;
use crate::common::Folder;
use serde_json::Value;

/// Largest work for opening a page, s. Without other programs it is about the time.
const OPENS_WITHIN_S: f64 = 2.0;

/// A folder with panel, model, weights and report.
fn folder_with_report() -> Folder {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    let rendered =
        folder.run("render model.json scene.toml -o weights.json --sweep 290:310 --stress -q");
    assert!(rendered.code <= 1, "{}", rendered.stderr);
    folder
        .run("report model.json weights.json -o report.html -q")
        .exits(0);
    folder
}

/// That report in a window of 1280 × 800 px; `None` where there is no browser.
fn report_in_a_browser() -> Option<(Folder, Page)> {
    let mut page = Page::new(1280, 800, false)?;
    let folder = folder_with_report();
    page.open_file(&folder.path().join("report.html"));
    Some((folder, page))
}

fn model_of(folder: &Folder) -> chladni_frf::ModalModel {
    chladni_io::read_model(&folder.path().join("model.json")).unwrap()
}

/// Place of the mark of the `k`-th mode's pole in the stabilization diagram, in the
/// window.
fn pole_mark(page: &mut Page, name: &str, k: usize) -> [f64; 2] {
    page.place("#stabilization-chart");
    let found = format!(
        "(() => {{ const svg = document.querySelector('#stabilization-chart'); const r = svg.getBoundingClientRect(); \
         const scale = r.width / svg.viewBox.baseVal.width; \
         const [, x, y] = svg.querySelector('path[data-name=\"{name}\"]').getAttribute('d').split('M')[{}].match(/([\\d.]+) ([\\d.]+)/); \
         return [r.left + x * scale, r.top + y * scale]; }})()",
        k + 1
    );
    serde_json::from_value(page.eval(&found)).unwrap()
}

#[test]
fn clicks_and_keys_pick_poles_and_the_selection_is_what_select_reads() {
    let Some((folder, mut page)) = report_in_a_browser() else {
        return;
    };
    let modes = model_of(&folder).in_band_modes().count();
    let curve =
        "document.querySelector('#frf-magnitude path[data-name=synthesised]').getAttribute('d')";
    page.place("#frf-magnitude");
    let before = page.eval(curve);

    let second = pole_mark(&mut page, "pole of the model, kept", 1);
    page.click(second);
    assert!(
        page.text("#selection-toml").contains("drop = [2]"),
        "{}",
        page.text("#selection-toml")
    );
    assert_ne!(
        page.eval(curve),
        before,
        "the synthesis leaves the mode out"
    );
    assert_eq!(
        page.eval("document.querySelector('input[data-mode=\"2\"]').checked"),
        Value::Bool(false)
    );

    // two poles onwards from the second, by keys
    page.eval("document.querySelector('#stabilization-chart').focus()");
    for key in ["PageDown", "PageDown", "Enter"] {
        page.key(key);
    }
    let toml = page.text("#selection-toml");
    assert!(toml.contains("drop = [2, 4]"), "{toml}");
    folder.write("selection.toml", &toml);
    let selected = folder
        .run("select model.json selection.toml -o selected.json --json")
        .exits(0)
        .json();
    let kept = selected["modes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|mode| mode["in_band"] == true)
        .count();
    assert_eq!(kept, modes - 2);

    // back, by the table
    let [x, y, width, height] = page.place("input[data-mode=\"2\"]");
    page.click([x + width / 2.0, y + height / 2.0]);
    assert!(page.text("#selection-toml").contains("drop = [4]"));
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn the_page_synthesises_and_measures_what_the_files_hold() {
    let Some((folder, mut page)) = report_in_a_browser() else {
        return;
    };
    let model = model_of(&folder);
    let (frf, ..) =
        chladni_io::read_frf(&[folder.path().join("panel.h5")], &Default::default()).unwrap();
    // a pair that the page has as residuals, not in full
    for (response, reference) in [(3, 4), (20, 9)] {
        page.eval(&format!(
            "(() => {{ for (const [id, k] of [['response', {response}], ['reference', {reference}]]) {{ const s = document.getElementById(id); \
             s.selectedIndex = k; s.dispatchEvent(new Event('change')); }} }})()"
        ));
        let [x, y, width, _] = page.place("#frf-magnitude");
        page.hover([x + 0.4 * width, y + 100.0]);
        let readout = page
            .wait("[...document.querySelectorAll('.readout')].find((r) => !r.hidden)?.textContent");
        let words = readout.as_str().unwrap().replace('−', "-");
        let number = |line: &str| -> f64 {
            line.split_whitespace()
                .find_map(|word| word.parse().ok())
                .unwrap()
        };
        let line = |name: &str| {
            number(
                words
                    .lines()
                    .find_map(|line| line.strip_prefix(name))
                    .unwrap_or_else(|| panic!("{name}: {words}")),
            )
        };
        // the read-out shows the nearest line
        let frequency = number(&words);
        let k = (0..frf.frequency_hz.len())
            .min_by_key(|&k| ((frf.frequency_hz[k] - frequency).abs() * 1e6) as u64)
            .unwrap();
        let db = |value: num_complex::Complex64| 20.0 * value.norm().log10();
        let (i, j) = (response as usize, reference as usize);
        let synthesised = model.frf_matrix(model.frf_kind, frf.frequency_hz[k])[[i, j]];
        let measured = frf.values.get(i, j, k);
        assert!(
            (line("synthesised:") - db(synthesised)).abs() < 0.01,
            "{words} {}",
            db(synthesised)
        );
        assert!(
            (line("measured:") - db(measured)).abs() < 0.05,
            "{words} {}",
            db(measured)
        );
    }
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn the_same_weights_at_another_frequency_score_what_evaluate_says() {
    let Some((folder, mut page)) = report_in_a_browser() else {
        return;
    };
    let other = 303.0;
    page.eval(&format!("(() => {{ const s = document.querySelector('#scene-1 input[type=range]'); s.value = {other}; s.dispatchEvent(new Event('input')); }})()"));
    let said = page.wait(
        "[...document.querySelectorAll('#scene-1 [role=status]')].find((e) => \
                   e.textContent.includes('hot'))?.textContent",
    );
    let mut weights: Value = serde_json::from_str(&folder.text("weights.json")).unwrap();
    weights["frequency_hz"] = other.into();
    folder.write("moved.json", weights.to_string());
    let judged = folder
        .run("evaluate moved.json --scene scene.toml --on model.json --json -q")
        .exits(0)
        .json();
    let points = &judged["indices"]["points"];
    for (name, key) in [
        ("hot", "hot_ratio"),
        ("cold", "cold_ratio"),
        ("both", "success_ratio"),
    ] {
        let wanted = format!("{name} {:.1} %", 100.0 * points[key].as_f64().unwrap());
        assert!(said.as_str().unwrap().contains(&wanted), "{said} {wanted}");
    }
}

#[test]
fn a_scene_drawn_in_the_report_is_what_render_reads() {
    let Some((folder, mut page)) = report_in_a_browser() else {
        return;
    };
    page.eval(
        "[...document.querySelectorAll('#zones button')].find((b) => b.textContent === \
               'Clear').click()",
    );
    assert!(!page.text("#scene-toml").contains("polygon"));
    let [x, y, width, height] = page.place("#zone-board");
    page.drag(
        [x + 0.3 * width, y + 0.3 * height],
        [x + 0.6 * width, y + 0.7 * height],
    );
    let drawn = page.text("#scene-toml");
    assert_eq!(drawn.matches("kind = \"hot\"").count(), 1, "{drawn}");
    // a cold zone by keys
    page.eval(
        "document.querySelector('input[value=cold]').click(); \
               document.querySelector('#zone-board').focus()",
    );
    for (key, times) in [
        ("ArrowUp", 1),
        ("ArrowRight", 11),
        ("Enter", 1),
        ("ArrowRight", 6),
        ("ArrowUp", 5),
        ("Enter", 1),
    ] {
        page.keys(key, times);
    }
    let both = page.text("#scene-toml");
    assert!(
        both.contains("kind = \"cold\"") && both.contains("kind = \"hot\""),
        "{both}"
    );
    folder.write("drawn.toml", &drawn);
    let rendered = folder.run("render model.json drawn.toml --method fast --json -q");
    assert!(rendered.code <= 1, "{}", rendered.stderr);
    assert_eq!(rendered.json()["scene"], "drawn.toml");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn keep_only_sure_is_one_click_and_what_select_reads() {
    let Some(mut page) = Page::new(1280, 800, false) else {
        return;
    };
    let folder = folder_with_report();
    let mut model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    let doubtful = model["modes"]
        .as_array_mut()
        .unwrap()
        .iter_mut()
        .find(|mode| mode["in_band"] == true)
        .unwrap();
    doubtful["trust"] = "weak".into();
    folder.write("doubtful.json", model.to_string());
    folder
        .run("report doubtful.json -o doubtful.html -q")
        .exits(0);
    page.open_file(&folder.path().join("doubtful.html"));
    assert!(page.text(".sentence").contains(", 1 weak"));
    page.eval("document.querySelector('#keep-sure').click()");
    assert_eq!(page.text("#selection-toml"), "keep = \"sure\"\n");
    let command = page.text(".selection pre");
    assert!(
        command.starts_with("chladni select doubtful.json "),
        "{command}"
    );
    folder.write("sure.toml", page.text("#selection-toml"));
    let sure = folder
        .run("select doubtful.json sure.toml -o sure.json --json")
        .exits(0)
        .json();
    let modes = sure["modes"].as_array().unwrap();
    assert!(modes
        .iter()
        .all(|mode| mode["in_band"] != true || mode["trust"] == "sure"));
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn foreign_words_stay_words() {
    const EVIL: &str = "</script><img src=x onerror=document.title=1>";
    let Some(mut page) = Page::new(1280, 800, false) else {
        return;
    };
    let folder = folder_with_report();
    let mut model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    model["quality"]["warnings"] = serde_json::json!([EVIL]);
    // a file of a version without codes
    model["quality"].as_object_mut().unwrap().remove("findings");
    model["method"] = EVIL.into();
    model["modes"][0]["reasons"] = serde_json::json!([EVIL]);
    folder.write("evil.json", model.to_string());
    folder.run("report evil.json -o evil.html -q").exits(0);
    page.open_file(&folder.path().join("evil.html"));
    assert_eq!(page.eval("document.querySelectorAll('img').length"), 0);
    assert!(page.text(".findings").contains(EVIL) && page.text("#model").contains(EVIL));
    // an injected script would not run either
    page.eval("document.body.append(Object.assign(document.createElement('script'), { textContent: 'document.title = \"ran\"' }))");
    assert_ne!(page.eval("document.title"), "ran");
}

#[test]
fn a_slider_shows_the_ground_of_a_burst_at_any_instant() {
    let Some(mut page) = Page::new(1280, 800, false) else {
        return;
    };
    let folder = Folder::new();
    folder.write(
        "panel.toml",
        "[frf]\nstart_hz = 2\nstop_hz = 1000\nstep_hz = 99.8\n",
    );
    folder
        .run("simulate panel.toml -o panel.h5 --truth model.json -q")
        .exits(0);
    folder.write(
        "burst.toml",
        "frequency_hz = 330\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n\
         [time]\n[[time.burst]]\nduration_s = 0.1\nramp_s = 0.015\n",
    );
    folder
        .run("render model.json burst.toml -o weights.json --method mls -q")
        .exits(0);
    folder
        .run("report model.json weights.json -o report.html --charts figures -q")
        .exits(0);
    assert!(folder.read("figures/time-1.png").starts_with(b"\x89PNG"));
    page.open_file(&folder.path().join("report.html"));
    assert!(page.text("#scene-1 .time").contains("hot after 1"));
    page.place("#scene-1 .time");
    let shown = "[...document.querySelectorAll('#time-1')].map((svg) => svg.previousSibling.toDataURL())[0]";
    let lines = page.eval("document.querySelectorAll('#scene-1 .time .of-series-2').length");
    assert_eq!(lines, 34, "one line per actuator");
    // 77 responses in 60 pictures; each row has at least its first one
    let runs = page.eval("[...document.querySelectorAll('#scene-1 .time-places path[stroke]')].map((p) => p.getAttribute('d').split('M').length - 1).reduce((a, b) => a + b)");
    assert!(
        (77 * 5..=77 * 60).contains(&(runs.as_u64().unwrap() as usize)),
        "{runs}"
    );
    let places = page.text("#scene-1 .time-places");
    assert!(
        places.contains("between the lines are not judged"),
        "{places}"
    );
    page.place("#time-1");
    let silent = page.eval(shown);
    page.eval("(() => { const s = document.querySelector('#scene-1 .time input[type=range]'); s.value = Math.round(s.max * 0.2); s.dispatchEvent(new Event('input')); })()");
    assert!(page
        .text("#scene-1 .time figure:last-child .figure-title")
        .contains("51 ms"));
    assert_ne!(page.eval(shown), silent, "the ground moves in the hold");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// Pixels of the bare panel on the map of a shape.
const BARE_PIXELS: &str = "(() => { const c = document.querySelector('#shapes .map-holder canvas'); \
     const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let count = 0; \
     for (let k = 0; k < d.length; k += 4) count += d[k] === 244 && d[k + 1] === 245 && d[k + 2] === 247 && d[k + 3] === 255; \
     return count; })()";

#[test]
fn maps_leave_out_what_is_not_known_and_their_dashes_show() {
    let Some(mut page) = Page::new(1280, 800, false) else {
        return;
    };
    let folder = Folder::with_glass();
    folder.run("report model.json -o report.html -q").exits(0);
    page.open_file(&folder.path().join("report.html"));
    page.place("#shapes .map-holder");
    // the corners of the panel are outside the responses
    let bare = page.eval(BARE_PIXELS);
    assert!(bare.as_u64().unwrap() > 200, "{bare}");
    let d = page.eval("document.querySelector('#shapes path.dashed').getAttribute('d')");
    let count = |letter: char| d.as_str().unwrap().matches(letter).count();
    assert!(
        count('L') > 10 * count('M'),
        "{} lines of {} pieces",
        count('M'),
        count('L')
    );
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn every_view_is_drawn_in_any_window_and_either_theme() {
    let folder = folder_with_report();
    let report = folder.path().join("report.html");
    let views = [
        "#frf-magnitude",
        "#frf-phase",
        "#stabilization-chart",
        "#mac-chart",
        "#complexity-chart",
        "#shape-3d",
        "#field-1",
        "#weights-1",
        "#zone-board",
    ];
    let mut shots = Vec::new();
    for (width, height, dark) in [
        (1280, 800, false),
        (420, 800, false),
        (2200, 1200, false),
        (1280, 800, true),
    ] {
        let Some(mut page) = Page::new(width, height, dark) else {
            return;
        };
        page.open_file(&report);
        let overflow = page.eval("document.documentElement.scrollWidth - innerWidth");
        assert!(
            overflow.as_f64().unwrap() <= 0.0,
            "{width} px: the page is {overflow} px wider than the window"
        );
        for view in views {
            // a view has its height once it is drawn
            page.wait(&format!(
                "document.querySelector('{view}').getBoundingClientRect().height > 100"
            ));
            let [_, _, wide, high] = page.place(view);
            assert!(
                wide > 200.0 && high > 100.0 && wide <= f64::from(width),
                "{view} at {width} px: {wide} × {high}"
            );
        }
        // a canvas with a picture has many colours
        page.place("#shape-3d");
        let colours = page.wait("(() => { const c = document.querySelector('#shape-3d'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; const seen = new Set(); for (let k = 0; k < d.length; k += 4) seen.add((d[k] << 16) | (d[k + 1] << 8) | d[k + 2]); return seen.size > 30 && seen.size; })()");
        assert!(colours.as_u64().unwrap() > 30);
        shots.push(page.screenshot());
        assert_eq!(page.complaints(), Vec::<String>::new());
    }
    assert!(shots
        .iter()
        .all(|shot| shot.starts_with(b"\x89PNG") && shot.len() > 10_000));
}

/// Widths of A4 and of Letter less margins of 12 mm, at 96 px an inch.
const PAPER_PX: [u32; 2] = [703, 725];

#[test]
fn nothing_is_cut_off_folded_or_left_out_on_paper() {
    let Some((_folder, mut page)) = report_in_a_browser() else {
        return;
    };
    // far from the window, nothing is drawn before it is printed
    let empty = "[...document.querySelectorAll('main svg.chart')].filter((svg) => !svg.querySelector('path, rect, circle')).length";
    assert!(page.eval(empty).as_u64() > Some(0));
    let left_out = page.eval(&format!("dispatchEvent(new Event('beforeprint')); {empty}"));
    assert_eq!(left_out, 0);
    page.on_paper();
    for width in PAPER_PX {
        page.resize(width, 1000);
        let beyond = page.eval(
            "[...document.querySelectorAll('header *, main *')].filter((e) => { \
               const r = e.getBoundingClientRect(); \
               return r.width && r.right > innerWidth + 1 && !e.closest('svg'); \
             }).map((e) => `${e.tagName}.${e.className}`)",
        );
        assert_eq!(beyond, serde_json::json!([]), "{width} px");
    }
    let folded = page.eval("document.querySelectorAll('details:not([open])').length");
    assert_eq!(folded, 0);
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn the_report_of_the_demonstration_panel_opens_quickly() {
    let Some(mut page) = Page::new(1280, 800, false) else {
        return;
    };
    let folder = Folder::new();
    folder.run("demo -o demo -q").exits(0);
    let report = folder.path().join("demo/report.html");
    println!("drawn after {} ms", page.open_file(&report));
    let worked_s = page.worked_s();
    assert!(worked_s > 0.0 && worked_s < OPENS_WITHIN_S, "{worked_s} s");
    assert_eq!(
        page.eval("document.querySelectorAll('section[id^=scene-]').length"),
        6,
        "four scenes, the first one with a dead actuator, and corrected"
    );
    let titles = page.eval("[...document.querySelectorAll('.figure-title, .stress h3')].map((title) => title.textContent).join('; ')");
    for view in [
        "root mean square over all FRFs",
        "Stabilization diagram over the CMIF",
        "Loss factor with 95 % bounds",
        "Field at 330.0 Hz",
        "Weights around the panel",
        "at other drive frequencies, each with weights of its own",
        "These weights at other frequencies",
        "Scene 1 with fewer modes",
        "Scene 1 with fewer actuators",
        "When the panel is not the model",
        "Speed against accuracy",
    ] {
        assert!(titles.as_str().unwrap().contains(view), "{view}: {titles}");
    }
    assert!(std::fs::metadata(&report).unwrap().len() < 8_000_000);
}
