//! A burst in the studio, in a real headless Chromium: the ground over time, and back to a
//! steady tone.

use crate::common::browser::Page;
use crate::workbench::{workbench, AT_REST};

#[test]
fn a_burst_is_shown_over_time_with_forces_responses_and_a_slider() {
    let Some((_folder, _studio, mut page)) = workbench("truth.json") else {
        return;
    };
    page.eval("document.querySelector('#tab-time').click()");
    assert!(page.text("#in-time").contains("steady tone"));
    let set = |page: &mut Page, id: &str, ms: &str| {
        page.eval(&format!(
            "(() => {{ const i = document.querySelector('{id}'); i.value = '{ms}'; i.dispatchEvent(new Event('change')); }})()"
        ));
    };
    set(&mut page, "#burst-duration", "150");
    page.wait("document.querySelector('#in-time').dataset.burst === '0.15'");
    page.wait(AT_REST);
    let toml = page.text("#scene-toml");
    assert!(
        toml.contains("[[time.burst]]\nduration_s = 0.15\nramp_s = \"auto\""),
        "{toml}"
    );
    assert!(page
        .text("#play-command")
        .starts_with("chladni play truth.json scene.toml"));
    assert!(page.text("#in-time").contains("cold "), "the sentence");
    let counts = page.eval(
        "[document.querySelectorAll('#in-time .of-series-1:not(.thin)').length, document.querySelectorAll('#in-time .of-series-1.thin').length, \
         document.querySelectorAll('#in-time .of-series-2').length, document.querySelectorAll('#in-time .time-places path[stroke]').length]",
    );
    let counts: Vec<u64> = serde_json::from_value(counts).unwrap();
    let references = page.eval("document.querySelectorAll('#result details tbody tr').length");
    assert!(
        counts[0] >= 2 && counts[1] >= 2,
        "modal and plain: {counts:?}"
    );
    assert_eq!(references, counts[2], "one line per actuator");
    assert_eq!(counts[3], 24, "shades");
    let canvas = "document.querySelector('#in-time .map-holder canvas').toDataURL()";
    page.place("#time-field");
    let silent = page.eval(canvas);
    page.eval("(() => { const s = document.querySelector('#in-time input[type=range]'); s.value = Math.round(s.max * 0.2); s.dispatchEvent(new Event('input')); })()");
    assert_ne!(page.eval(canvas), silent, "the ground moves in the hold");
    // longer ramps, and a steady tone again
    set(&mut page, "#burst-ramp", "40");
    page.wait("document.querySelector('#play-command').value !== ''");
    page.wait(AT_REST);
    assert!(page.text("#scene-toml").contains("ramp_s = 0.04"));
    set(&mut page, "#burst-duration", "");
    assert!(!page.text("#scene-toml").contains("[time]"));
    assert!(page.text("#in-time").contains("steady tone"));
    assert_eq!(page.complaints(), Vec::<String>::new());
}
