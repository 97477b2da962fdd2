//! Noise of the force, an error that all its FRFs share: more of them do not average it
//! out, and error bars hold it.

use crate::common::{easy, fitted};
use chladni_frf::{BlockWindow, Estimation, Estimator, Forcing, FrfSet, FrfValues};
use chladni_plate::{add_noise_of_variance, Synthetic, SyntheticSet};
use chladni_rfp::FitOptions;
use ndarray::{s, Array3, Axis, Zip};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Variance of the noise on each line over the power of the force.
const SHARE: f64 = 1e-4;

/// FRFs by a local method: H·(1 + ν) with one ν for all FRFs.
fn noisy(seed: u64) -> SyntheticSet {
    let one_force = Synthetic {
        references: 1,
        ..easy(100.0, seed)
    };
    let mut set = one_force.build().unwrap();
    let FrfValues::F64(values) = &mut set.frf.values else {
        panic!("synthetic sets are in double precision")
    };
    let variance = values.mapv(|v| SHARE * v.norm_sqr());
    let mut noise = Array3::zeros(values.dim());
    add_noise_of_variance(&mut noise, SHARE, 100 + seed);
    let first = noise.slice(s![..1, .., ..]).to_owned();
    noise.zip_mut_with(&first, |own, first| *own = *first);
    Zip::from(values).and(&noise).for_each(|value, noise| {
        *value *= 1.0 + noise;
    });
    let step_hz = 0.1;
    set.frf = FrfSet {
        variance: Some(variance),
        estimation: Some(Estimation {
            estimator: Estimator::Lrm,
            window: BlockWindow::Rectangular,
            forcing: None,
            transform_s: 13.0 / step_hz,
            gate_s: 13.0 / step_hz,
            hop_s: 13.0 / step_hz,
            averages: [1; 2],
            lines_per_value: 13,
        }),
        ..set.frf
    };
    set
}

/// Decay of an exponential window over a record, nepers.
const DECAY: f64 = 2.0;
/// Places of a record.
const PLACES: usize = 2048;

/// FRFs of blows: H·(1 + ν), ν the transform of noise under an exponential window, far above
/// noise of the responses. The window's share of the damping is left in the truth.
fn noisy_blows(seed: u64) -> SyntheticSet {
    let one_force = Synthetic {
        references: 1,
        ..easy(100.0, seed)
    };
    let mut set = one_force.build().unwrap();
    let mut samples = Array3::zeros((1, 1, PLACES));
    add_noise_of_variance(&mut samples, SHARE, 100 + seed);
    let factor = |t: usize| (-DECAY * (t as f64 + 0.5) / PLACES as f64).exp();
    let power = (0..PLACES).map(|t| factor(t).powi(2)).sum::<f64>();
    let noise = |line: usize| -> Complex64 {
        let at = |t: usize| {
            let turn = -TAU * (line * t % PLACES) as f64 / PLACES as f64;
            samples[[0, 0, t]] * Complex64::from_polar(factor(t) / power.sqrt(), turn)
        };
        (0..PLACES).map(at).sum()
    };
    let step_hz = set.frf.frequency_hz[1] - set.frf.frequency_hz[0];
    let FrfValues::F64(values) = &mut set.frf.values else {
        panic!("synthetic sets are in double precision")
    };
    for (line, mut of_line) in values.axis_iter_mut(Axis(2)).enumerate() {
        let noise = noise(line);
        of_line.mapv_inplace(|v| v * (1.0 + noise));
    }
    let record_s = 1.0 / step_hz;
    set.frf.estimation = Some(Estimation {
        estimator: Estimator::H1,
        window: BlockWindow::Exponential {
            rate_per_s: DECAY / record_s,
        },
        forcing: Some(Forcing::Transient),
        transform_s: record_s,
        gate_s: record_s,
        hop_s: record_s,
        averages: [5; 2],
        lines_per_value: 1,
    });
    let modes = set.truth.modes.iter_mut();
    modes.for_each(|mode| mode.loss_factor -= 2.0 * DECAY / record_s / (TAU * mode.frequency_hz));
    set
}

/// Rms of errors of loss factors over their bars.
fn over_bars(made: fn(u64) -> SyntheticSet) -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for seed in 0..6 {
        let set = made(seed);
        let model = fitted(&set.frf, &FitOptions::default());
        for own in set.truth.in_band_modes() {
            let off = |f: f64| (f - own.frequency_hz).abs();
            let found = model
                .in_band_modes()
                .min_by(|a, b| off(a.frequency_hz).total_cmp(&off(b.frequency_hz)))
                .unwrap();
            squares += ((found.loss_factor - own.loss_factor) / found.loss_factor_std).powi(2);
            count += 1;
        }
    }
    (squares / f64::from(count)).sqrt()
}

#[test]
fn bars_hold_errors_that_all_frfs_share() {
    let shared = over_bars(noisy);
    assert!((0.6..1.4).contains(&shared), "{shared}");
}

#[test]
fn bars_of_blows_hold_the_noise_of_the_hammer() {
    let shared = over_bars(noisy_blows);
    assert!((0.5..1.5).contains(&shared), "{shared}");
}
