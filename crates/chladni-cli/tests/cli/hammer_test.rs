//! `fixtures/hammer-test.uff`: a hammer test as an analyser writes it. Simulated in time, with an exponential window that
//! makes every mode seem more damped than it is; `CHLADNI_WRITE_FIXTURES=1` writes it anew.

use crate::common::Folder;
use chladni_frf::{BlockWindow, Estimation, Estimator, Forcing, FrfSet, FrfValues};
use chladni_io::{read_frf, write_frf, ReadOptions};
use chladni_plate::{Excitation, TimeSet, TimeTest};
use num_complex::{Complex32, Complex64};
use serde_json::Value;
use std::path::PathBuf;

const NATURAL_HZ: [f64; 6] = [41.3, 87.7, 140.2, 203.9, 281.4, 352.6];
const DAMPING_RATIO: [f64; 6] = [0.012, 0.007, 0.005, 0.004, 0.006, 0.003];
/// The window falls to e⁻³ over a record.
const RATE_PER_S: f64 = 1.5;
const RECORD_S: f64 = 2.0;
const BLOWS: usize = 5;

fn fixture() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/hammer-test.uff")
}

fn simulated() -> TimeSet {
    let mut set = TimeTest {
        natural_frequency_hz: NATURAL_HZ.to_vec(),
        damping_ratio: DAMPING_RATIO.to_vec(),
        responses: 12,
        sample_rate_hz: 1024.0,
        record_s: RECORD_S,
        padding: 1,
        band_hz: [10.0, 400.0],
        averages: BLOWS,
        excitation: Excitation::Hammer { contact_s: 0.002 },
        window: BlockWindow::Exponential {
            rate_per_s: RATE_PER_S,
        },
        snr_db: 45.0,
        seed: 7,
    }
    .build()
    .unwrap();
    let single = |v: Complex64| Complex32::new(v.re as f32, v.im as f32);
    let FrfValues::F64(values) = &set.frf.values else {
        panic!("simulated values are f64");
    };
    set.frf.values = FrfValues::F32(values.mapv(single));
    set.frf.estimation = Some(Estimation {
        estimator: Estimator::H1,
        window: BlockWindow::Exponential {
            rate_per_s: RATE_PER_S,
        },
        forcing: Some(Forcing::Transient),
        transform_s: RECORD_S,
        gate_s: RECORD_S,
        hop_s: RECORD_S,
        averages: [BLOWS; 2],
        lines_per_value: 1,
    });
    set
}

/// The largest difference of values, relative.
fn difference(a: &FrfSet, b: &FrfSet) -> f64 {
    assert_eq!(a.values.dim(), b.values.dim());
    let (responses, references, lines) = a.values.dim();
    let places = (0..responses)
        .flat_map(|i| (0..references).map(move |j| (i, j)))
        .flat_map(|(i, j)| (0..lines).map(move |k| (i, j, k)));
    let at = |set: &FrfSet, (i, j, k)| set.values.get(i, j, k);
    let largest =
        |of: &dyn Fn((usize, usize, usize)) -> f64| places.clone().map(of).fold(0.0, f64::max);
    largest(&|place| (at(a, place) - at(b, place)).norm()) / largest(&|place| at(a, place).norm())
}

#[test]
fn the_file_is_what_the_simulator_makes() {
    let set = simulated();
    if std::env::var_os("CHLADNI_WRITE_FIXTURES").is_some() {
        write_frf(&fixture(), &set.frf, true).unwrap();
    }
    let (read, _, _) = read_frf(&[fixture()], &ReadOptions::default()).unwrap();
    assert!(difference(&set.frf, &read) < 1e-6);
    assert_eq!(read.estimation, set.frf.estimation);
}

#[test]
fn a_clone_fits_what_a_hammer_test_leaves() {
    let folder = Folder::new();
    std::fs::copy(fixture(), folder.path().join("hammer-test.uff")).unwrap();
    let fit = folder
        .run("fit hammer-test.uff -o model.json --json")
        .exits(0)
        .json();
    let modes = fit["modes"].as_array().unwrap().iter();
    let modes: Vec<_> = modes.filter(|mode| mode["trust"] == "sure").collect();
    assert_eq!(modes.len(), NATURAL_HZ.len());
    for (mode, (natural_hz, ratio)) in modes.iter().zip(NATURAL_HZ.iter().zip(DAMPING_RATIO)) {
        let number = |name: &str| mode[name].as_f64().unwrap();
        // four standard deviations: all twelve numbers are inside in 999 of 1000 sets
        let off_hz = (number("frequency_hz") - natural_hz).abs();
        assert!(off_hz < 4.0 * number("frequency_std_hz"), "{mode}");
        let off = (number("loss_factor") - 2.0 * ratio).abs();
        assert!(off < 4.0 * number("loss_factor_std"), "{mode}");
        assert!(off < 0.05 * 2.0 * ratio, "{mode}");
    }
    // the file names its window, so that its decay is not taken for damping
    let findings = fit["quality"]["findings"].as_array().unwrap();
    let undone = |finding: &&Value| finding["code"] == "window-undone";
    let undone = findings.iter().find(undone).expect("said");
    assert_eq!(undone["values"]["decay_per_s"], RATE_PER_S);
}
