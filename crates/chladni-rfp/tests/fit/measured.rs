//! Measured beams: what independent methods found on them, where the files are present
//! (outside the project).

use chladni_frf::{FrfKind, FrfSet, ModalModel, Trust};
use chladni_io::{read_frf, ReadOptions};
use chladni_rfp::{fit, FitOptions};
use std::io::Write;
use std::path::PathBuf;

fn data(file: &str) -> Option<PathBuf> {
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(file);
    if path.exists() {
        return Some(path);
    }
    // past the test harness, which would keep it to itself
    drop(writeln!(
        std::io::stderr(),
        "skipped: {} is not present",
        path.display()
    ));
    None
}

fn read(paths: &[PathBuf]) -> FrfSet {
    let options = ReadOptions {
        frf_kind: Some(FrfKind::Accelerance),
        ..ReadOptions::default()
    };
    read_frf(paths, &options).expect("readable").0
}

/// One reference mode: frequency, its spread over methods (Hz), damping ratio and its
/// spread.
struct Reference(f64, f64, f64, f64);

/// Every reference mode is found within the spread of the methods plus two of our
/// standard deviations, and no mode that is no reference is `sure`.
fn judge(model: &ModalModel, references: &[Reference]) {
    for &Reference(frequency, spread, zeta, zeta_spread) in references {
        let mode = model
            .in_band_modes()
            .min_by(|a, b| {
                (a.frequency_hz - frequency)
                    .abs()
                    .total_cmp(&(b.frequency_hz - frequency).abs())
            })
            .expect("a mode");
        let off = (mode.frequency_hz - frequency).abs();
        assert!(
            off <= spread + 2.0 * mode.frequency_std_hz,
            "{frequency} Hz: found {} ± {}",
            mode.frequency_hz,
            mode.frequency_std_hz
        );
        let off = (mode.damping_ratio - zeta).abs();
        assert!(
            off <= zeta_spread + mode.loss_factor_std,
            "{frequency} Hz: damping {} ± {}",
            mode.damping_ratio,
            0.5 * mode.loss_factor_std
        );
        // bars that are too wide would make the above empty
        assert!(
            mode.frequency_std_hz < mode.damping_ratio * frequency,
            "{frequency} Hz: bar {}",
            mode.frequency_std_hz
        );
    }
    for mode in model.in_band_modes().filter(|m| m.trust == Trust::Sure) {
        let known = references
            .iter()
            .any(|r| (r.0 - mode.frequency_hz).abs() < 0.002 * r.0);
        assert!(
            known,
            "{} Hz is sure, and nobody knows it",
            mode.frequency_hz
        );
    }
}

#[test]
fn the_beam_of_64000_lines_has_its_eight_bending_modes() {
    let Some(path) = data("pyuff-beam/beam.uff") else {
        return;
    };
    let frf = read(&[path]);
    let model = fit(
        &frf,
        &FitOptions {
            band_hz: Some([20.0, 1900.0]),
            ..FitOptions::default()
        },
    )
    .unwrap()
    .model;
    judge(
        &model,
        &[
            Reference(52.554, 0.003, 0.00181, 0.00001),
            Reference(144.632, 0.002, 0.000714, 0.000006),
            Reference(283.127, 0.003, 0.000392, 0.000005),
            Reference(468.278, 0.003, 0.000216, 0.000009),
            Reference(698.464, 0.010, 0.000187, 0.000009),
            Reference(972.979, 0.009, 0.000230, 0.000018),
            Reference(1292.95, 0.04, 0.000216, 0.000001),
            Reference(1655.40, 0.14, 0.00034, 0.00011),
        ],
    );
    assert_eq!(
        model
            .in_band_modes()
            .filter(|m| m.trust == Trust::Sure)
            .count(),
        8
    );
    assert!(model
        .quality
        .path
        .as_deref()
        .is_some_and(|p| p.starts_with("measured-data path")));
}

#[test]
fn the_whole_record_of_64000_lines_ends_and_keeps_the_eight() {
    let Some(path) = data("pyuff-beam/beam.uff") else {
        return;
    };
    let model = fit(&read(&[path]), &FitOptions::default()).unwrap().model;
    for (frequency, spread) in [
        (52.554, 0.003),
        (144.632, 0.002),
        (283.127, 0.003),
        (468.278, 0.003),
        (698.464, 0.010),
        (972.979, 0.009),
    ] {
        let near = |m: &&chladni_frf::Mode| {
            (m.frequency_hz - frequency).abs() <= spread + 2.0 * m.frequency_std_hz
        };
        assert!(
            model
                .in_band_modes()
                .filter(|m| m.trust == Trust::Sure)
                .any(|m| near(&m)),
            "{frequency} Hz"
        );
    }
    // noise dominates there: what stands in one FRF alone, or has another phase than all
    // modes, is no mode beyond doubt
    let above = model
        .in_band_modes()
        .filter(|m| m.trust == Trust::Sure && m.frequency_hz > 2000.0)
        .count();
    assert!(above <= 1, "{above} sure above 2 kHz");
    // sharp lines that no beam mode explains (the data's own notes)
    for line in [1926.0, 2128.0, 2255.0] {
        let sure = model
            .in_band_modes()
            .find(|m| m.trust == Trust::Sure && (m.frequency_hz - line).abs() < 1.0);
        assert!(sure.is_none(), "{line} Hz is sure");
    }
}

#[test]
fn modes_narrower_than_a_line_are_found_between_the_lines() {
    let Some(first) = data("pyuff-measured-beam-txt/meas_point_1.txt") else {
        return;
    };
    // the files hold one complex value a line, without a frequency axis: 0, 1, ..., 1000
    // Hz
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for point in 1..=3 {
        let text = std::fs::read_to_string(first.with_file_name(format!("meas_point_{point}.txt")))
            .unwrap();
        let mut csv = String::from("frequency_hz,re,im\n");
        for (k, line) in text.lines().filter(|l| !l.trim().is_empty()).enumerate() {
            let value: num_complex::Complex64 =
                line.trim().trim_matches(['(', ')']).parse().unwrap();
            csv += &format!("{k},{:e},{:e}\n", value.re, value.im);
        }
        let path = folder.path().join(format!("point_{point}.csv"));
        std::fs::write(&path, csv).unwrap();
        paths.push(path);
    }
    let model = fit(&read(&paths), &FitOptions::default()).unwrap().model;
    judge(
        &model,
        &[
            Reference(51.517, 0.001, 0.000555, 0.000055),
            Reference(142.177, 0.001, 0.0003625, 0.0000055),
            Reference(278.667, 0.003, 0.000186, 0.000005),
            Reference(460.400, 0.004, 0.0001915, 0.0000035),
            Reference(687.166, 0.001, 0.000161, 0.000004),
            Reference(958.530, 0.002, 0.0001345, 0.0000015),
        ],
    );
}

#[test]
fn one_measured_frf_has_its_published_mode() {
    let Some(path) = data("vtb-case1/case1_frf.csv") else {
        return;
    };
    let model = fit(&read(&[path]), &FitOptions::default()).unwrap().model;
    judge(&model, &[Reference(212.0925, 0.003, 0.0008625, 0.0000035)]);
    assert!(model.quality.trusted);
}
