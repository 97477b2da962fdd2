//! The default method on the named cases, few seeds and generous bounds; the full figures
//! are in `docs/accuracy.md`.

use chladni_bench::{
    accuracy, accuracy_csv, accuracy_figures, accuracy_modes_csv, AccuracyOptions, AccuracyRow,
    Case, Journal,
};
use chladni_rfp::{Method, ShapeModel};

const SEEDS: usize = 8;

fn run(case: &str, seeds: usize) -> AccuracyRow {
    run_with(case, seeds, ShapeModel::Auto)
}

fn run_with(case: &str, seeds: usize, shapes: ShapeModel) -> AccuracyRow {
    let case = Case::named(case).expect("a named case");
    let options = AccuracyOptions {
        cases: vec![case],
        methods: vec![Method::Auto],
        shapes,
        seeds,
        first_seed: 0,
        knobs: false,
    };
    accuracy(&options, &mut Journal::none(), &|_| {})
        .expect("constant cases")
        .remove(0)
}

#[test]
fn free_residues_stand_at_their_bound_and_common_shapes_below_it() {
    for case in [
        "easy",
        "easy-20-db",
        "close",
        "few-lines",
        "single-reference",
        "overlap-1",
    ] {
        for shapes in [ShapeModel::Free, ShapeModel::Auto] {
            let row = run_with(case, SEEDS, shapes);
            assert_eq!(
                row.exact, 1.0,
                "{case}: wrong count with the seeds {:?}",
                row.wrong_seeds
            );
            // eight seeds: a mode's rms error scatters by 1/√16 = 25 %, the median of
            // eight modes by some 10 %; one mode in 1e4 exceeds twice its bound
            let own = if shapes == ShapeModel::Free {
                row.over_free
            } else {
                row.over_real
            };
            for (own, free) in own.iter().zip(row.over_free) {
                assert!(
                    (0.7..1.6).contains(&own.median) && own.worst < 2.5,
                    "{case}, {}: {own:?}",
                    shapes.as_str()
                );
                assert!(
                    free.median < 1.4 && free.worst < 2.2,
                    "{case}, {}: {free:?}",
                    shapes.as_str()
                );
            }
            // 64 intervals and more: five standard deviations below 95 % are 82 %
            assert!(
                row.coverage[..2].iter().all(|covered| *covered > 0.82),
                "{case}: {:?}",
                row.coverage
            );
        }
    }
}

#[test]
fn noise_alone_holds_no_mode() {
    let row = run("only-noise", SEEDS);
    assert_eq!(
        (row.modes.len(), row.miscounts, row.exact),
        (0, [0.0; 3], 1.0)
    );
    assert!(row.over_free[0].median.is_nan() && row.with_missed.is_nan());
}

#[test]
fn the_same_seeds_give_the_same_errors_bit_by_bit() {
    let errors = || {
        let row = run("few-lines", 3);
        [
            row.over_free[0].median,
            row.over_free[1].worst,
            row.with_missed,
            row.mac[1],
            row.frf_error_db,
        ]
        .map(f64::to_bits)
    };
    assert_eq!(errors(), errors());
}

#[test]
fn a_case_with_a_bound_has_a_row_and_a_chart() {
    let rows = [run("few-lines", 2), run("only-noise", 2)];
    let csv = accuracy_csv(&rows, &[]);
    let lines: Vec<&str> = csv.lines().collect();
    assert!(
        lines[0].starts_with('#')
            && lines[1].starts_with("case,method,time_s,frequency_rmse_over_crlb,")
    );
    assert!(lines[2].starts_with("few-lines,auto,") && lines[3].starts_with("only-noise,auto,"));
    assert!(lines[1..]
        .iter()
        .all(|line| line.split(',').count() == lines[1].split(',').count()));
    assert_eq!(accuracy_modes_csv(&rows).lines().count(), 2 + 8);
    let names: Vec<String> = accuracy_figures(&rows, &[])
        .into_iter()
        .map(|figure| figure.name)
        .collect();
    assert_eq!(
        names,
        ["accuracy-few-lines"],
        "noise alone has no bound to compare with"
    );
}
