//! Scenes in time that cannot be: each refused by the name of what is wrong.

use crate::common::cell_scene;
use crate::time::{played, truth, BURST};
use chladni_frf::ErrorKind;
use chladni_render::{play, PlayOptions, Ramps, Scene, SignalOptions};
use std::path::Path;

#[test]
fn tables_that_cannot_be_are_refused_by_name() {
    let zones = "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\narea_m = [0.034, 0.025, \
                 0.234, 0.145]\n[time]\n";
    let moving = |start: f64| {
        format!(
            "[[time.move]]\nstart_s = {start}\npath_m = [[0.07, 0.085], [0.198, \
             0.085]]\nspeed_m_per_s = 0.2\nhot_radius_m = 0.025\nquiet_from_m = 0.06\n"
        )
    };
    for (text, named) in [
        ("".to_owned(), "time"),
        ("measure = \"loud\"\n".into(), "measure"),
        ("ramps = \"linear\"\n".into(), "ramps"),
        ("[[time.burst]]\nduration_s = -0.1\n".into(), "duration_s"),
        (
            "[[time.burst]]\nduration_s = 0.1\nstart_s = -1\n".into(),
            "start_s",
        ),
        (
            "[[time.burst]]\nduration_s = 0.1\nramp_s = 0.06\n".into(),
            "ramp_s",
        ),
        (
            "[[time.burst]]\nduration_s = 0.1\nramp_s = \"soft\"\n".into(),
            "ramp_s",
        ),
        (
            "[[time.burst]]\nduration_s = 0.1\nrepeat = [3, 0.05]\n".into(),
            "repeat",
        ),
        (
            "[[time.burst]]\nduration_s = 0.1\nhot = [5]\n".into(),
            "hot",
        ),
        (
            "[[time.burst]]\nduration_s = 0.1\nlength = 1\n".into(),
            "length",
        ),
        (
            "[[time.fade]]\nfrom = [1]\nto = [1]\nstart_s = 1\nfade_s = 0.1\n".into(),
            "to",
        ),
        (
            "[[time.fade]]\nfrom = [1]\nto = [2]\nstart_s = 1\nfade_s = 0\n".into(),
            "fade_s",
        ),
        (moving(0.0) + &moving(0.3), "[[time.move]] 2"),
        (moving(0.0).replace("0.198", "0.298"), "path_m"),
        (moving(0.0).replace("0.06\n", "0.02\n"), "quiet_from_m"),
        (moving(0.0).replace("= 0.2\n", "= 0\n"), "speed_m_per_s"),
        (moving(0.0).replace("= 0.2\n", "= 1e9\n"), "speed_m_per_s"),
        (moving(0.0).replace("0.198", "0.07"), "path_m"),
    ] {
        let error = Scene::parse(&format!("{zones}{text}"), Path::new("")).unwrap_err();
        assert_eq!(error.kind, ErrorKind::BadData, "{text}");
        assert!(
            error.field.as_deref().unwrap().contains(named),
            "{text}: {error}"
        );
    }
}

#[test]
fn moves_that_the_responses_cannot_judge_are_refused_by_name() {
    for (end_x_m, hot_radius_m, quiet_from_m, key) in [
        (0.398, 0.025, 0.060, "path_m"),
        (0.198, 0.002, 0.060, "hot_radius_m"),
        (0.198, 0.025, 0.400, "quiet_from_m"),
    ] {
        let text = format!(
            "[time]\n[[time.move]]\npath_m = [[0.070, 0.085], [{end_x_m}, \
             0.085]]\nspeed_m_per_s = 0.2\nhot_radius_m = {hot_radius_m}\nquiet_from_m = \
             {quiet_from_m}\n"
        );
        let scene = cell_scene([2, 2], 1, &text);
        let error = play(truth(), &scene, None, &PlayOptions::default()).unwrap_err();
        assert_eq!(error.kind, ErrorKind::BadData);
        let named = format!("[[time.move]] 1 {key}");
        assert_eq!(error.field.as_deref(), Some(named.as_str()), "{error}");
    }
}

#[test]
fn a_fade_that_ends_with_its_burst_leaves_no_time_for_the_ramps() {
    // 0.1 + 0.2 is more than 0.3
    let table = "[time]\n[[time.burst]]\nduration_s = 0.3\n[[time.fade]]\nfrom = [1]\nto = \
                 [2]\nstart_s = 0.1\nfade_s = 0.2\n";
    let scene = cell_scene([2, 2], 1, table);
    let error = play(truth(), &scene, None, &PlayOptions::default()).unwrap_err();
    assert_eq!(error.field.as_deref(), Some("[[time.burst]] 1"), "{error}");
    let found = error.found.as_deref();
    assert_eq!(found, Some("0.0 ms beside what sounds in it"), "{error}");
    assert!(!error.to_string().contains("ramp_s"), "{error}");
}

#[test]
fn a_fade_at_the_beginning_is_told_to_start_later() {
    let table = "[time]\n[[time.fade]]\nfrom = [1]\nto = [2]\nstart_s = 0\nfade_s = 0.1\n";
    let scene = cell_scene([2, 2], 1, table);
    let error = play(truth(), &scene, None, &PlayOptions::default()).unwrap_err();
    let help = error.help.as_deref().unwrap();
    assert!(
        help.contains("later start_s") && !help.contains("earlier"),
        "{error}"
    );
}

#[test]
fn a_ramp_that_the_band_cannot_describe_and_a_rate_below_it_are_refused() {
    let scene = cell_scene(
        [2, 2],
        1,
        "[time]\n[[time.burst]]\nduration_s = 0.1\nramp_s = 0.001\n",
    );
    let error = play(truth(), &scene, None, &PlayOptions::default()).unwrap_err();
    assert!(error.to_string().contains("band"), "{error}");
    assert_eq!(
        error.field.as_deref(),
        Some("time.burst[1].ramp_s"),
        "{error}"
    );
    assert_eq!(error.line, Some(9), "the line of ramp_s: {error}");
    let scene = cell_scene([2, 2], 1, BURST);
    let made = played(truth(), &scene, Ramps::Plain);
    let slow = SignalOptions {
        rate_hz: 600,
        ..SignalOptions::default()
    };
    let error = made.signal(&slow, "").unwrap_err();
    assert!(
        error.kind == ErrorKind::Usage && error.field.as_deref() == Some("rate_hz"),
        "{error}"
    );
}

#[test]
fn a_burst_or_a_fade_whose_cells_leave_nothing_quiet_is_blamed_itself() {
    let burst = "[[time.burst]]\nduration_s = 0.1\n";
    let all = "[1, 2, 3, 4]";
    for (events, named) in [
        (
            format!("{burst}hot = [4, 3, 2, 1]\n"),
            "[[time.burst]] 1 hot",
        ),
        (
            format!("{burst}{burst}start_s = 1\nhot = {all}\n"),
            "[[time.burst]] 2 hot",
        ),
        (
            format!("[[time.fade]]\nfrom = [1]\nto = {all}\nstart_s = 1\nfade_s = 0.1\n"),
            "[[time.fade]] 1 to",
        ),
    ] {
        let scene = cell_scene([2, 2], 1, &format!("[time]\n{events}"));
        let error = play(truth(), &scene, None, &PlayOptions::default()).unwrap_err();
        assert_eq!(error.field.as_deref(), Some(named), "{error}");
        assert_eq!(error.found.as_deref(), Some(all), "{error}");
        assert!(error.message.contains("left to keep quiet"), "{error}");
        assert!(error.line.is_some() && error.expected.is_some(), "{error}");
        assert!(error.help.unwrap().starts_with("name fewer cells"));
    }
}

#[test]
fn a_burst_or_a_fade_whose_cells_hold_no_response_is_blamed_itself() {
    let burst = "[[time.burst]]\nduration_s = 0.1\n";
    for (events, named, cells) in [
        (format!("{burst}hot = [2]\n"), "[[time.burst]] 1 hot", "[2]"),
        (
            format!("{burst}{burst}start_s = 1\nhot = [4, 2]\n"),
            "[[time.burst]] 2 hot",
            "[2, 4]",
        ),
        (
            "[[time.fade]]\nfrom = [1]\nto = [4]\nstart_s = 1\nfade_s = 0.1\n".to_owned(),
            "[[time.fade]] 1 to",
            "[4]",
        ),
    ] {
        // what is judged ends before the cells on the right
        let area = "area_m = [0.034, 0.025, 0.120, 0.145]\n";
        let scene = cell_scene([2, 2], 1, &format!("{area}[time]\n{events}"));
        let error = play(truth(), &scene, None, &PlayOptions::default()).unwrap_err();
        assert_eq!(error.field.as_deref(), Some(named), "{error}");
        assert_eq!(error.found.as_deref(), Some(cells), "{error}");
        assert_eq!(error.message, "no response lies in these cells");
        assert!(error.line.is_some() && error.expected.is_some(), "{error}");
        assert!(error.help.unwrap().starts_with("compare area_m"));
    }
}
