//! Maps of stability: an easy cell is right, an impossible one is wrong and says so, and
//! an interrupted run goes on.

use chladni_bench::{
    calibration, failures_csv, stability, stability_csv, stability_figures, Journal, Map, Solver,
    StabilityOptions, StabilityRow,
};
use std::cell::Cell;

fn options(map: &str, solver: &str, seeds: usize) -> StabilityOptions {
    StabilityOptions {
        maps: vec![Map::named(map).expect("a named map")],
        solvers: vec![Solver::named(solver).expect("a named method")],
        seeds,
        first_seed: 0,
        coarse: true,
    }
}

fn run(map: &str, solver: &str, seeds: usize) -> Vec<StabilityRow> {
    stability(&options(map, solver, seeds), &mut Journal::none(), &|_| {}).expect("a constant map")
}

#[test]
fn separate_modes_in_little_noise_are_right_and_none_are_seen_in_much() {
    let rows = run("snr-overlap", "auto", 2);
    assert_eq!(rows.len(), 9, "three steps along both axes");
    let cell = |x: usize, y: usize| {
        rows.iter()
            .find(|row| row.cell == [x, y])
            .expect("a corner")
    };
    // 60 dB, overlap 0.05
    assert!(cell(5, 0)
        .trials
        .iter()
        .all(|(_, trial)| !trial.wrong() && !trial.announced() && trial.found == 8));
    // 0 dB, overlap 3: eight modes under one hump in as much noise
    assert!(cell(0, 5)
        .trials
        .iter()
        .all(|(_, trial)| trial.wrong() && trial.announced()));
    // modes ten times closer are worse conditioned, whatever the noise
    assert!(cell(5, 5).trials[0].1.condition > 10.0 * cell(5, 0).trials[0].1.condition);

    let csv = stability_csv(&rows);
    let header = csv
        .lines()
        .find(|line| !line.starts_with('#'))
        .expect("a header");
    assert!(
        header.starts_with("case,method,snr_db,modal_overlap,found,missed,spurious,announced,"),
        "{header}"
    );
    assert!(csv
        .lines()
        .skip(1)
        .all(|line| line.split(',').count() == header.split(',').count()));
    let wrong = rows
        .iter()
        .flat_map(|row| &row.trials)
        .filter(|(_, trial)| trial.wrong())
        .count();
    assert_eq!(failures_csv(&rows).lines().count(), 2 + wrong);
    let all = calibration(&rows);
    assert_eq!(
        all[0].quiet + all[0].false_alarms + all[0].announced + all[0].silent,
        18
    );
    let names: Vec<String> = stability_figures(&rows, &all)
        .into_iter()
        .map(|figure| figure.name)
        .collect();
    assert_eq!(
        names,
        [
            "stability-snr-overlap-auto",
            "stability-announced",
            "stability-ranks-auto"
        ]
    );
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_table() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("stability.journal");
    let options = options("spacing-references", "peak", 1);
    let said = Cell::new(0);
    let count = |_: &str| said.set(said.get() + 1);
    let whole = stability(
        &options,
        &mut Journal::open(&path, "test").expect("a journal"),
        &count,
    )
    .expect("a constant map");
    assert_eq!(said.get(), whole.len(), "each piece is announced once");
    // the end of the run never came: the last lines are lost
    let text = std::fs::read_to_string(&path).expect("the journal");
    std::fs::write(
        &path,
        text.lines()
            .take(4)
            .map(|line| format!("{line}\n"))
            .collect::<String>(),
    )
    .expect("room");
    let mut journal = Journal::open(&path, "test").expect("a journal");
    assert_eq!(journal.resumed(), 3);
    said.set(0);
    let again = stability(&options, &mut journal, &count).expect("a constant map");
    assert_eq!(
        (said.get(), stability_csv(&again)),
        (whole.len() - 3, stability_csv(&whole))
    );
    journal.finish();
    assert!(!path.exists());
}

#[test]
fn a_drive_serves_the_panel_it_was_made_for_and_less_of_it_under_a_firm_touch() {
    let rows = run("render-frequency-touch", "default", 1);
    let served = |x: usize, y: usize| {
        rows.iter()
            .find(|row| row.cell == [x, y])
            .expect("a cell")
            .trials[0]
            .1
            .error
    };
    // 255, 320 and 345 Hz, untouched
    assert!(
        [0, 3, 5].iter().all(|&x| served(x, 0) > 0.95),
        "{:?}",
        [served(0, 0), served(3, 0), served(5, 0)]
    );
    assert!(
        served(0, 4) < served(0, 0) - 0.03,
        "{} {}",
        served(0, 4),
        served(0, 0)
    );
}
