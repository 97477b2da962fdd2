//! Records as a bench leaves them: cables that are off, offsets, drives that are no reference.

use super::*;
use chladni_frf::{Finding, Forcing, Severity};

#[test]
fn drives_that_are_no_reference_neither_excite_nor_answer() {
    let x = Noise::new(41).take(BLOCK * 40);
    let second = Noise::new(42).take(BLOCK * 40);
    let force = || channel("1:+Z", SignalUnit::Force, x.clone());
    let moving = || channel("2:+Z", SignalUnit::Velocity, filtered(&x, FILTER));
    let beside = |dof: &str, unit| Channel {
        is_reference: false,
        ..channel(dof, unit, second.clone())
    };
    let h1 = options(Estimator::H1);
    let alone = estimate(&[run(vec![force(), moving()])], &h1).unwrap();
    let voltage = beside("1:+Z", SignalUnit::Volt);
    let other_force = beside("3:+Z", SignalUnit::Force);
    for (idle, severity) in [(voltage, Severity::Note), (other_force, Severity::Caution)] {
        let dof = idle.dof;
        let result = estimate(&[run(vec![force(), idle, moving()])], &h1).unwrap();
        assert_eq!(result.frf, alone.frf);
        let named = |finding: &&Finding| finding.code == "drives-left-out";
        let finding = result.findings.iter().find(named).unwrap();
        assert_eq!(
            (finding.severity, &finding.dofs[..]),
            (severity, &[dof][..])
        );
    }
}

#[test]
fn one_record_whose_force_ends_before_it_is_one_block() {
    let samples = 40 * BLOCK;
    let mut noise = Noise::new(43);
    let mut force = |acting: usize| -> Vec<f64> {
        let acts = |k| f64::from(u8::from(k < acting));
        (0..samples)
            .map(|k| acts(k) * (2.0 + noise.next()))
            .collect()
    };
    for (acting, window) in [
        (3, BlockWindow::Rectangular),
        (samples / 2, BlockWindow::Rectangular),
        (samples, BlockWindow::Hann),
    ] {
        let x = force(acting);
        let echo = (0..samples).map(|k| x[k] + 0.5 * x[k.saturating_sub(7)]);
        let moving = channel("1:+Z", SignalUnit::Velocity, echo.collect());
        let record = run(vec![channel("101:+Z", SignalUnit::Force, x), moving]);
        let h1 = EstimateOptions {
            estimator: Some(Estimator::H1),
            ..EstimateOptions::default()
        };
        let result = estimate(&[record], &h1).unwrap();
        assert_eq!(result.estimation.window, window, "{acting}");
        let is_whole = result.estimation.transform_s == samples as f64 / RATE_HZ;
        assert_eq!(is_whole, window == BlockWindow::Rectangular, "{acting}");
    }
}

#[test]
fn a_record_in_which_a_response_is_constant_is_left_out_of_its_average() {
    let mut noise = Noise::new(44);
    let mut blow = |place: &str, dead: bool| {
        let x: Vec<f64> = (0..BLOCK)
            .map(|k| f64::from(u8::from(k < 4)) + 1e-3 * noise.next())
            .collect();
        let y = if dead {
            vec![0.7; BLOCK]
        } else {
            filtered(&x, FILTER)
        };
        let first = channel("1:+Z", SignalUnit::Velocity, filtered(&x, FILTER));
        run(vec![
            channel(place, SignalUnit::Force, x),
            first,
            channel("2:+Z", SignalUnit::Velocity, y),
        ])
    };
    let runs = [("101:+Z", false), ("101:+Z", true), ("102:+Z", true)];
    let runs = runs.map(|(place, dead)| blow(place, dead));
    let result = estimate(&runs, &options(Estimator::H1)).unwrap();
    for (k, &hz) in result.frf.frequency_hz.iter().enumerate() {
        let of = |row, column| result.frf.values.get(row, column, k);
        for value in [of(0, 0), of(0, 1), of(1, 0)] {
            assert!((value - truth(FILTER, hz)).norm() < 1e-9);
        }
        assert!(of(1, 1).re.is_nan());
    }
    let named = |finding: &&Finding| finding.code == "still-responses";
    let finding = result.findings.iter().find(named).unwrap();
    assert!(
        finding.contains("2 records of single responses"),
        "{finding:?}"
    );
}

#[test]
fn roving_hammers_and_offsets_of_sensors_change_nothing() {
    let decaying = |place: &str, offset: f64| {
        let x: Vec<f64> = (0..4096).map(|k| f64::from(u8::from(k < 4))).collect();
        let mut last = [0.0; 2];
        let ring = x.iter().map(|x| {
            let y = x + 1.95 * last[0] - 0.98 * last[1];
            last = [y, last[0]];
            y + 3.0 * offset
        });
        let ring: Vec<f64> = ring.collect();
        let force = x.iter().map(|x| x + offset).collect();
        let velocity = channel("1:+Z", SignalUnit::Velocity, ring);
        run(vec![channel(place, SignalUnit::Force, force), velocity])
    };
    let of = |offset: f64, window: Option<BlockWindow>| {
        let runs = ["11:+Z", "12:+Z", "13:+Z"].map(|place| decaying(place, offset));
        let options = EstimateOptions {
            window,
            ..EstimateOptions::default()
        };
        estimate(&runs, &options).unwrap()
    };
    for window in [None, Some(BlockWindow::Exponential { rate_per_s: 2.0 })] {
        let [plain, shifted] = [0.0, 0.07].map(|offset| of(offset, window));
        assert_eq!(plain.estimation.transform_s, 4096.0 / RATE_HZ);
        assert_eq!(plain.estimation.forcing, Some(Forcing::Transient));
        assert_eq!(shifted.estimation, plain.estimation);
        let lines = 0..plain.frf.frequency_hz.len();
        let apart = |k| (shifted.frf.values.get(0, 2, k) - plain.frf.values.get(0, 2, k)).norm();
        let largest = lines.map(apart).fold(0.0, f64::max);
        assert!(largest < 1e-6, "{window:?}: {largest}");
    }
}

#[test]
fn a_constant_response_is_named_and_left_out() {
    let x = Noise::new(3).take(BLOCK * 4);
    let force = || channel("101:+Z", SignalUnit::Force, x.clone());
    let moving = || channel("1:+Z", SignalUnit::Velocity, filtered(&x, FILTER));
    let stuck = || channel("2:+Z", SignalUnit::Velocity, vec![3.3; x.len()]);
    let h1 = options(Estimator::H1);
    let result = estimate(&[run(vec![force(), moving(), stuck()])], &h1).unwrap();
    let good = estimate(&[run(vec![force(), moving()])], &h1).unwrap();
    assert_eq!(result.frf, good.frf);
    let named = |finding: &Finding| finding.code == "still-responses" && finding.contains("2:+Z");
    assert!(result.findings.iter().any(named), "{:?}", result.findings);
    // nothing moves; and what moves in one run is no constant
    let error = estimate(&[run(vec![force(), stuck()])], &h1).unwrap_err();
    assert!(error.to_string().contains("no response moves"), "{error}");
    let later = channel("2:+Z", SignalUnit::Velocity, filtered(&x, FILTER));
    let runs = [run(vec![force(), stuck()]), run(vec![force(), later])];
    assert!(estimate(&runs, &h1).is_ok());
}

#[test]
fn records_of_two_forces_are_enough_for_all_responses_or_for_some() {
    let blocks = 2;
    let mut noise = Noise::new(45);
    let mut pair = || [noise.take(BLOCK), noise.take(BLOCK)];
    let taken: Vec<Run> = (0..blocks)
        .map(|k| {
            let [a, b] = pair();
            let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - 2.0 * b).collect();
            let second = if k == 0 {
                sum.clone()
            } else {
                vec![0.0; BLOCK]
            };
            run(vec![
                channel("101:+Z", SignalUnit::Force, a),
                channel("102:+Z", SignalUnit::Force, b),
                channel("1:+Z", SignalUnit::Velocity, sum),
                channel("2:+Z", SignalUnit::Velocity, second),
            ])
        })
        .collect();
    let h1 = EstimateOptions {
        window: Some(BlockWindow::Rectangular),
        block: Some(BLOCK),
        ..options(Estimator::H1)
    };
    let frf = estimate(&taken, &h1).unwrap().frf;
    let of = |row, column| frf.values.get(row, column, 3);
    assert!((of(0, 0) - 1.0).norm() < 1e-9 && (of(0, 1) + 2.0).norm() < 1e-9);
    assert!(of(1, 0).re.is_nan());
}

#[test]
fn a_burst_of_two_forces_in_one_record_is_cut_into_blocks() {
    let samples = 64 * BLOCK;
    let mut noise = Noise::new(46);
    let mut burst = || -> Vec<f64> {
        let acts = |k| f64::from(u8::from(k < samples / 2));
        (0..samples).map(|k| acts(k) * noise.next()).collect()
    };
    let [a, b] = [burst(), burst()];
    let sum = a.iter().zip(&b).map(|(a, b)| a - 2.0 * b).collect();
    let record = run(vec![
        channel("101:+Z", SignalUnit::Force, a),
        channel("102:+Z", SignalUnit::Force, b),
        channel("1:+Z", SignalUnit::Velocity, sum),
    ]);
    let h1 = EstimateOptions {
        estimator: Some(Estimator::H1),
        ..EstimateOptions::default()
    };
    let result = estimate(&[record], &h1).unwrap();
    assert!(result.estimation.averages[0] > 2);
    assert!((result.frf.values.get(0, 1, 3) + 2.0).norm() < 1e-9);
}
