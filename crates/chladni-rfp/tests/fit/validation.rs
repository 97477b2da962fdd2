//! Yardsticks through the public door, on sets whose figures follow in closed form.

use crate::common::fitted;
use chladni_frf::{FrfValues, ShapeSet};
use chladni_plate::{simulate, Panel, Synthetic, SyntheticSet};
use chladni_rfp::{auto_mac, cmif, compare, mac, CompareOptions, FitOptions};
use num_complex::Complex64;

fn clean() -> SyntheticSet {
    Synthetic {
        snr_db: f64::INFINITY,
        ..Synthetic::default()
    }
    .build()
    .unwrap()
}

#[test]
fn auto_mac_is_one_on_its_diagonal_and_symmetric() {
    let set = clean();
    let shapes: Vec<&[Complex64]> = set
        .truth
        .in_band_modes()
        .map(|mode| mode.shape.0.as_slice())
        .collect();
    let table = auto_mac(&set.truth);
    assert_eq!(table.dim(), (shapes.len(), shapes.len()));
    for ((a, b), value) in table.indexed_iter() {
        assert!(
            (value
                - if a == b {
                    1.0
                } else {
                    mac(shapes[b], shapes[a])
                })
            .abs()
                < 1e-12,
            "{a} {b}: {value}"
        );
    }
}

#[test]
fn the_mode_indicator_shows_the_singular_values_of_each_line() {
    let mut set = Synthetic {
        responses: 2,
        references: 2,
        ..Synthetic::default()
    }
    .build()
    .unwrap();
    if let FrfValues::F64(values) = &mut set.frf.values {
        // a diagonal matrix on every line: its entries' moduli, falling; and one line
        // without a value
        values.indexed_iter_mut().for_each(|((i, j, k), v)| {
            *v = if i != j {
                Complex64::default()
            } else {
                Complex64::from_polar((1 + i) as f64 * (1 + k) as f64, k as f64)
            };
        });
        values[[0, 1, 5]] = Complex64::new(f64::NAN, f64::NAN);
    }
    let table = cmif(&set.frf).unwrap();
    for k in (0..20).filter(|k| *k != 5) {
        let size = (1 + k) as f64;
        assert!(
            (table[[k, 0]] / size - 2.0).abs() < 1e-12
                && (table[[k, 1]] / size - 1.0).abs() < 1e-12,
            "{:?}",
            table.row(k)
        );
    }
    assert!(table.row(5).iter().all(|v| v.is_nan()));
}

/// 24 responses, 10 references, some modes; shapes are scaled to 1 at their largest
/// response.
const PANEL: &str = "[responses]\ngrid = [6, 4]\nspacing_m = 0.035\n[references]\nedge_count = \
                     [3, 2]\nspacing_m = 0.06\n[frf]\nstart_hz = 20.0\nstop_hz = 400.0\nstep_hz = 1.0\n";

#[test]
fn the_exact_mac_lies_within_the_bar_of_a_fitted_model() {
    let panel = Panel::from_toml(PANEL, 1 << 30).unwrap();
    let (mut all, mut within, mut before) = (0, 0, None);
    for seed in 0..30 {
        let set = simulate(&panel, Some(seed), Some(40.0)).unwrap();
        let model = ShapeSet::from(&fitted(&set.frf, &FitOptions::default()));
        let truth = ShapeSet::from(&set.truth);
        for other in [Some(truth), before.take()].into_iter().flatten() {
            for pair in compare(&model, &other, &CompareOptions::default())
                .unwrap()
                .pairs
            {
                assert_eq!(pair.a, pair.b);
                all += 1;
                let error = pair.mac - pair.mac_noise_bias - 1.0;
                within += usize::from(error.abs() <= 1.96 * pair.mac_std);
            }
        }
        before = Some(model);
    }
    let part = within as f64 / all as f64;
    println!("{within} of {all} pairs");
    // some 600 pairs, each model in three of them: 95 % less three standard errors
    assert!((0.92..=1.0).contains(&part), "{within} of {all}");
}
