//! The looks of the studio, in a real headless Chromium: nothing is cut off, and scales can be read.

use crate::common::browser::Page;
use crate::common::studio::Studio;
use crate::common::Folder;
use crate::workbench::{workbench, AT_REST, CTRL};

#[test]
fn the_whole_error_of_a_scene_is_readable_and_the_state_is_a_fault() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let worst = "document.querySelector('.result-bar').dataset.worst";
    let before = page.eval(worst);
    // no frequency of the profile: the error names it, its range, and what helps
    for (input, value) in [
        ("#scene-frequency", "50000"),
        ("#scene-threshold", "classic"),
    ] {
        page.eval(&format!("(() => {{ const i = document.querySelector('{input}'); i.value = '{value}'; i.dispatchEvent(new Event('change')); }})()"));
    }
    page.wait("document.querySelector('.sentence .error')");
    let error = page.text(".sentence .error");
    assert!(error.len() > 120 && error.contains("classic"), "{error}");
    assert_eq!(page.eval(worst), "fault");
    for what in [".sentence", "#scene-status"] {
        let cut = format!("(() => {{ const e = document.querySelector('{what}'); return e.scrollHeight > e.clientHeight + 1 || e.scrollWidth > e.clientWidth + 1; }})()");
        assert_eq!(page.eval(&cut), false, "{what} is cut off");
    }
    page.key_with("z", CTRL);
    page.key_with("z", CTRL);
    page.wait("!document.querySelector('.sentence .error')");
    page.wait(AT_REST);
    assert_eq!(page.eval(worst), before);
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn scales_have_numbers_and_levels_their_reference() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    let said = page.text("#frf-magnitude");
    assert!(said.contains("dB re 1 (m/s)/N, mobility"), "{said}");
    let numbers = "(() => { const svg = document.querySelector('#drive').closest('svg'); \
        const left = Number(svg.querySelector('.frame').getAttribute('x')); \
        return [...svg.querySelectorAll('text[text-anchor=end]')].filter((e) => Number(e.getAttribute('x')) < left).map((e) => e.textContent); })()";
    let numbers = page.eval(numbers);
    assert!(numbers.as_array().unwrap().len() > 1, "{numbers}");
}

/// Drawn elements outside the window, and those whose text is cut off.
const BEYOND: &str = "[...document.querySelectorAll('body *')].filter((e) => { \
    const r = e.getBoundingClientRect(); \
    if (!r.width || !r.height || e.closest('svg, .table-scroll, .spoken, option, .menu-body, .drawer-body')) return false; \
    return r.left < -1 || r.top < -1 || r.right > innerWidth + 1 || r.bottom > innerHeight + 1; \
  }).map((e) => `${e.tagName}.${e.className} ${JSON.stringify(e.getBoundingClientRect())}`)";

#[test]
fn the_workbench_fits_its_window_in_either_theme() {
    let folder = Folder::with_panel();
    // a name that takes the room of the buttons in the narrow window
    let model = "panel-of-march-truth.json";
    folder.write(model, folder.text("truth.json"));
    let mut shots = Vec::new();
    for (width, height, dark) in [
        (1280, 800, false),
        (1280, 800, true),
        (1920, 1080, false),
        (400, 800, false),
    ] {
        let Some(mut page) = Page::new(width, height, dark) else {
            return;
        };
        let studio = Studio::start(&folder, &[model]);
        page.open(&studio.url);
        page.wait(AT_REST);
        let scrolls = page.eval(
            "[document.documentElement.scrollWidth - innerWidth, document.documentElement.scrollHeight - innerHeight]",
        );
        assert_eq!(scrolls, serde_json::json!([0, 0]), "{width} × {height}");
        let beside = "[...document.querySelectorAll('.top > *')].map((e) => e.getBoundingClientRect().right).filter((right) => right > innerWidth)";
        assert_eq!(
            page.eval(beside),
            serde_json::json!([]),
            "{width} px: the bar"
        );
        if width > 1100 {
            assert_eq!(
                page.eval(BEYOND),
                serde_json::json!([]),
                "{width} × {height}"
            );
            for view in [
                "#zone-board",
                "#stabilization-chart",
                "#frf-magnitude",
                "#result",
            ] {
                let [_, _, wide, high] = page.place(view);
                assert!(wide > 200.0 && high > 80.0, "{view}: {wide} × {high}");
            }
        }
        shots.push(page.screenshot());
        assert_eq!(page.complaints(), Vec::<String>::new());
    }
    assert!(shots.iter().all(|shot| shot.len() > 20_000));
}
