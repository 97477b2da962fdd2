//! Noise of the force, an error that all its FRFs share: more of them do not average it
//! out, and error bars hold it.

use crate::common::{easy, fitted};
use chladni_frf::{BlockWindow, Estimation, Estimator, FrfSet, FrfValues};
use chladni_plate::{add_noise_of_variance, Synthetic, SyntheticSet};
use chladni_rfp::FitOptions;
use ndarray::{s, Array3, Zip};

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

/// Rms of errors of loss factors over their bars.
fn over_bars() -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for seed in 0..6 {
        let set = noisy(seed);
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
    let shared = over_bars();
    assert!((0.6..1.4).contains(&shared), "{shared}");
}
