//! Sets that break lesser chains: a hundred modes, a band of three decades, one bound for
//! all error bars.

use chladni_frf::{Damping, FrfValues, ModalModel, Mode};
use chladni_plate::{add_white_noise, synthesise_by_products, Synthetic, SyntheticSet};
use chladni_rfp::FitOptions;
use ndarray::Array1;

fn fitted(set: &SyntheticSet) -> ModalModel {
    crate::common::fitted(
        &set.frf,
        &FitOptions {
            damping: Some(Damping::Structural),
            ..Default::default()
        },
    )
}

#[test]
fn a_hundred_modes_without_noise_are_exact() {
    let set = Synthetic {
        natural_frequency_hz: (0..100).map(|n| 100.0 + 9.0 * n as f64).collect(),
        loss_factor: vec![0.005],
        responses: 6,
        references: 2,
        frequency_hz: Array1::linspace(50.0, 1040.0, 1601),
        snr_db: f64::INFINITY,
        ..Synthetic::default()
    }
    .build()
    .expect("a set");
    let model = fitted(&set);
    let modes: Vec<&Mode> = model.in_band_modes().collect();
    assert_eq!(modes.len(), 100, "{:?}", model.quality);
    let worst = modes.iter().zip(set.truth.in_band_modes()).map(|(m, t)| {
        let complex =
            |m: &Mode| num_complex::Complex64::new(1.0, m.loss_factor) * m.frequency_hz.powi(2);
        (complex(m) - complex(t)).norm() / complex(t).norm()
    });
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 1e-10, "{worst}");
}

#[test]
fn three_decades_of_frequency_on_a_linear_axis_are_one_fit() {
    // 60 modes, widths from a seventh of a line to 160 lines; modes nearer than two lines
    // are left out of the set
    let natural_frequency_hz: Vec<f64> = (0..60)
        .map(|n| 5.5 * (3800.0f64 / 5.5).powf(n as f64 / 59.0))
        .collect();
    let set = Synthetic {
        natural_frequency_hz,
        responses: 6,
        references: 2,
        frequency_hz: Array1::linspace(5.0, 4000.0, 16001),
        snr_db: 60.0,
        ..Synthetic::default()
    }
    .build()
    .expect("a set");
    let model = fitted(&set);
    let (missed, spurious) = crate::common::missed_and_spurious(&set.truth, &model);
    let [missed, spurious] =
        [missed, spurious].map(|modes| modes.iter().map(|m| m.frequency_hz).collect::<Vec<f64>>());
    assert!(
        missed.is_empty() && spurious.is_empty(),
        "missed {missed:?}, spurious {spurious:?}: {:?}",
        model.quality.path
    );
}

#[test]
fn error_bars_of_shapes_cover_what_they_promise() {
    let (mut covered, mut count) = (0, 0);
    for seed in 0..12 {
        let set = Synthetic {
            responses: 6,
            references: 2,
            snr_db: 40.0,
            seed,
            ..Synthetic::default()
        }
        .build()
        .expect("a set");
        let model = fitted(&set);
        for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
            let along: f64 = mode
                .shape
                .0
                .iter()
                .zip(&truth.shape.0)
                .map(|(a, b)| (a.conj() * b).re)
                .sum();
            for ((a, b), std) in mode.shape.0.iter().zip(&truth.shape.0).zip(&mode.shape_std) {
                // real shapes have one real error each
                covered += usize::from((a * along.signum() - b).norm() < 1.96 * std);
                count += 1;
            }
        }
    }
    let share = covered as f64 / count as f64;
    assert!((0.90..0.99).contains(&share), "{share} of {count}");
}

#[test]
fn a_driving_point_at_a_node_is_named_and_its_error_bars_hold_all_the_same() {
    let synthetic = Synthetic {
        responses: 12,
        references: 1,
        ..Synthetic::default()
    };
    let (mut covered, mut count) = (0, 0);
    for seed in 0..12 {
        let mut truth = synthetic.build().expect("a set").truth;
        let at_node = &mut truth.modes[1];
        // ψ at the driving point, which is the first response: its residue is the square,
        // and the others shrink with it
        at_node.shape.0[0] *= 0.002;
        at_node.participation.0[0] *= 0.002;
        let mut frf = synthetic.build().expect("a set").frf;
        let mut values = synthesise_by_products(&truth, &synthetic.frequency_hz);
        add_white_noise(&mut values, 60.0, seed).expect("noise");
        frf.values = FrfValues::F64(values);
        let model = crate::common::fitted(
            &frf,
            &FitOptions {
                damping: Some(Damping::Structural),
                modes: Some(3),
                ..Default::default()
            },
        );
        let named: Vec<&chladni_frf::Finding> = model
            .quality
            .findings
            .iter()
            .filter(|warning| warning.contains("scale to unit modal mass"))
            .collect();
        let [warning] = named[..] else {
            panic!("{:?}", model.quality.findings)
        };
        assert!(
            warning.contains("70.0 Hz") && !warning.contains("40.0") && !warning.contains("110.0"),
            "{warning}"
        );
        let (mode, known) = (
            model.in_band_modes().nth(1).expect("a mode"),
            &truth.modes[1],
        );
        let along: f64 = mode
            .shape
            .0
            .iter()
            .zip(&known.shape.0)
            .map(|(a, b)| (a.conj() * b).re)
            .sum();
        for ((a, b), std) in mode.shape.0.iter().zip(&known.shape.0).zip(&mode.shape_std) {
            covered += usize::from((a * along.signum() - b).norm() < 1.96 * std);
            count += 1;
        }
    }
    assert!(covered * 10 >= count * 9, "{covered} of {count}");
}

/// One pole beyond the band stands for several modes there. Its shapes may mix, which changes no
/// FRF: that is no error of theirs.
#[test]
fn shapes_that_share_a_pole_beyond_the_band_are_known() {
    let set = Synthetic {
        natural_frequency_hz: vec![40.0, 70.0, 110.0, 160.0, 165.0, 170.0, 175.0],
        responses: 12,
        references: 6,
        snr_db: 60.0,
        ..Synthetic::default()
    }
    .build()
    .expect("a set");
    let model = fitted(&set);
    let outside = || model.modes.iter().filter(|mode| !mode.in_band);
    let shares = |mode: &&Mode| {
        let same = |other: &&Mode| other.frequency_hz == mode.frequency_hz;
        outside().filter(same).count() > 1
    };
    let sharing: Vec<&Mode> = outside().filter(shares).collect();
    assert!(!sharing.is_empty(), "{:?}", model.quality.path);
    for mode in sharing {
        let peak = mode.shape.0.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let known = |std: &f64| *std > 0.0 && *std < 0.5 * peak;
        assert!(
            mode.shape_std.iter().all(known),
            "{:?} of {peak} at {} Hz",
            mode.shape_std,
            mode.frequency_hz
        );
    }
}
