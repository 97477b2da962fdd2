//! Cramér-Rao bounds against a closed form, against derivatives by differences, and
//! against an efficient estimator.

use chladni_frf::{Damping, FrfKind};
use chladni_plate::{
    cramer_rao, cramer_rao_rank_one, cramer_rao_real, synthesise_by_products, Synthetic,
    SyntheticShapes,
};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

#[test]
fn a_lone_mode_with_many_lines_has_the_bound_of_the_continuous_integral() {
    // Receptance, no residual terms, lines δ apart in x: with ∫|λ−x|⁻⁴ = π/(2 Im³λ),
    // ∫|λ−x|⁻² = π/Im λ and
    // |∫ (λ−x)*⁻¹ (λ−x)⁻²| = π/(2 Im²λ) the projected slope has the energy π/(4 δ Im³λ), hence C = 4 δ σ² Im³λ/(π|R|²).
    // so small that the tails beyond the axis weigh 0.03 per cent
    const LOSS_FACTOR: f64 = 2e-4;
    let spec = Synthetic {
        natural_frequency_hz: vec![100.0],
        loss_factor: vec![LOSS_FACTOR],
        responses: 1,
        references: 1,
        kind: FrfKind::Receptance,
        // lines evenly spaced in x = f²: the integral is over x
        frequency_hz: Array1::linspace(90.0f64.powi(2), 110.0f64.powi(2), 20001).mapv(f64::sqrt),
        ..Synthetic::default()
    };
    let truth = spec.build().unwrap().truth;
    let residue = truth.modes[0].shape.0[0].norm_sqr();
    let variance = 1e-20;
    let bound = cramer_rao(&truth, &spec.frequency_hz, variance, &[]).unwrap();
    let tau2 = std::f64::consts::TAU.powi(2);
    let step = tau2 * (110.0f64.powi(2) - 90.0f64.powi(2)) / 20000.0;
    let (re, im) = (tau2 * 1e4, tau2 * 1e4 * LOSS_FACTOR);
    let covariance =
        variance * step / (residue * residue) / (std::f64::consts::PI / (4.0 * im.powi(3)));
    let expected = (covariance / 2.0).sqrt() / (2.0 * re) * 100.0;
    assert!(
        (bound.frequency_std_hz[0] / expected - 1.0).abs() < 1e-3,
        "{} against {expected}",
        bound.frequency_std_hz[0]
    );
    assert!((bound.loss_factor_std[0] / (2.0 * expected / 100.0) - 1.0).abs() < 1e-3);
}

#[test]
fn the_bound_is_the_inverse_of_the_full_information_matrix() {
    // every unknown (poles, residues of each FRF, residual coefficients of each FRF) in
    // one big Jacobian by differences
    let spec = Synthetic {
        natural_frequency_hz: vec![50.0, 50.6],
        loss_factor: vec![0.02, 0.03],
        responses: 2,
        references: 2,
        frequency_hz: Array1::range(40.0, 60.0, 0.5),
        ..Synthetic::default()
    };
    let truth = spec.build().unwrap().truth;
    let powers = [-2, 0];
    let bound = cramer_rao(&truth, &spec.frequency_hz, 1.0, &powers).unwrap();
    let (lines, pairs) = (spec.frequency_hz.len(), 4);
    let unknowns = 2 + 2 * pairs + powers.len() * pairs;
    let tau = std::f64::consts::TAU;
    let pole = |n: usize| {
        (tau * truth.modes[n].frequency_hz).powi(2)
            * Complex64::new(1.0, truth.modes[n].loss_factor)
    };
    let mut jacobian = Array2::<Complex64>::zeros((lines * pairs, unknowns));
    for pair in 0..pairs {
        for (k, &f) in spec.frequency_hz.iter().enumerate() {
            let (row, omega) = (pair * lines + k, tau * f);
            let mobility = Complex64::new(0.0, omega);
            for n in 0..2 {
                let residue =
                    truth.modes[n].shape.0[pair / 2] * truth.modes[n].participation.0[pair % 2];
                let value = |pole: Complex64| mobility * residue / (pole - omega * omega);
                let step = 1e-6 * pole(n);
                // unknowns in relative size, so that the matrix is well scaled
                jacobian[[row, n]] = (value(pole(n) + step) - value(pole(n) - step)) / 2e-6;
                jacobian[[row, 2 + 2 * pair + n]] =
                    mobility / (pole(n) - omega * omega) * pole(n).norm() * 0.02;
            }
            for (p, &power) in powers.iter().enumerate() {
                jacobian[[row, 2 + 2 * pairs + powers.len() * pair + p]] =
                    mobility * (f / 60.0f64).powi(power);
            }
        }
    }
    let scale: Vec<f64> = jacobian
        .columns()
        .into_iter()
        .map(|c| c.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt())
        .collect();
    let jacobian = Array2::from_shape_fn(jacobian.dim(), |(i, j)| jacobian[[i, j]] / scale[j]);
    let information = chladni_linalg::matmul_h(jacobian.view(), jacobian.view());
    let covariance = chladni_linalg::inverse_hermitian(information.view()).unwrap();
    for n in 0..2 {
        let relative =
            (covariance[[n, n]].re / 2.0).sqrt() / scale[n] * pole(n).norm() / pole(n).re;
        let found = bound.frequency_std_hz[n] / truth.modes[n].frequency_hz * 2.0;
        assert!(
            (found / relative - 1.0).abs() < 1e-5,
            "mode {n}: {found:e} against {relative:e}"
        );
    }
}

#[test]
fn bounds_scale_with_noise_and_shrink_with_more_frfs() {
    let spec = Synthetic::default();
    let truth = spec.build().unwrap().truth;
    let bound = |variance: f64, powers: &[i32]| {
        cramer_rao(&truth, &spec.frequency_hz, variance, powers).unwrap()
    };
    let (one, four) = (bound(1.0, &[]), bound(4.0, &[]));
    let free = bound(1.0, &[-2, 0, 2]);
    for n in 0..3 {
        assert!((four.frequency_std_hz[n] / one.frequency_std_hz[n] - 2.0).abs() < 1e-9);
        assert!(free.frequency_std_hz[n] > one.frequency_std_hz[n]);
    }
    let more = Synthetic {
        responses: 50,
        ..spec.clone()
    }
    .build()
    .unwrap()
    .truth;
    let more = cramer_rao(&more, &spec.frequency_hz, 1.0, &[]).unwrap();
    assert!((0..3).all(|n| more.loss_factor_std[n] < one.loss_factor_std[n]));
}

#[test]
fn one_newton_step_from_the_truth_scatters_as_the_bound_says() {
    // Gauss-Newton from the true poles with free residues is the maximum-likelihood
    // estimate to first order
    let spec = Synthetic {
        frequency_hz: Array1::range(30.0, 130.0, 0.25),
        snr_db: 40.0,
        ..Synthetic::default()
    };
    let (runs, tau) = (40, std::f64::consts::TAU);
    let mut square = [0.0f64; 3];
    let mut bound = None;
    for seed in 0..runs {
        let set = spec.build().unwrap();
        let clean = synthesise_by_products(&set.truth, &spec.frequency_hz);
        let mut noisy = clean.clone();
        chladni_plate::add_noise_of_variance(&mut noisy, set.noise_variance, 100 + seed);
        bound.get_or_insert_with(|| {
            cramer_rao(&set.truth, &spec.frequency_hz, set.noise_variance, &[]).unwrap()
        });
        // columns per FRF: own residues, common poles; solved together by elimination of
        // the residues
        let poles: Vec<Complex64> = set
            .truth
            .modes
            .iter()
            .map(|m| (tau * m.frequency_hz).powi(2) * Complex64::new(1.0, m.loss_factor))
            .collect();
        let lines = spec.frequency_hz.len();
        let basis = Array2::from_shape_fn((lines, 3), |(k, n)| {
            let omega = tau * spec.frequency_hz[k];
            Complex64::new(0.0, omega) * poles[n].norm() / (poles[n] - omega * omega)
        });
        let slope = Array2::from_shape_fn((lines, 3), |(k, n)| {
            -basis[[k, n]] * poles[n].norm() / (poles[n] - (tau * spec.frequency_hz[k]).powi(2))
        });
        let project = |b: &Array2<Complex64>| {
            b - &chladni_linalg::matmul(
                basis.view(),
                chladni_linalg::lstsq(basis.view(), b.view())
                    .unwrap()
                    .view(),
            )
        };
        let slope = project(&slope);
        let (mut rows, mut error) = (
            Array2::zeros((lines * 10, 3)),
            Array2::zeros((lines * 10, 1)),
        );
        for pair in 0..10 {
            let column = Array2::from_shape_fn((lines, 1), |(k, _)| noisy[[pair / 2, pair % 2, k]]);
            let left = project(&column);
            for k in 0..lines {
                error[[pair * lines + k, 0]] = left[[k, 0]];
                for n in 0..3 {
                    let mode = &set.truth.modes[n];
                    rows[[pair * lines + k, n]] =
                        slope[[k, n]] * mode.shape.0[pair / 2] * mode.participation.0[pair % 2]
                            / poles[n].norm();
                }
            }
        }
        let step = chladni_linalg::lstsq(rows.view(), error.view()).unwrap();
        for n in 0..3 {
            let moved = (poles[n] + step[[n, 0]] * poles[n].norm()).re.sqrt() / tau;
            square[n] += (moved - set.truth.modes[n].frequency_hz).powi(2) / runs as f64;
        }
    }
    let bound = bound.unwrap();
    for n in 0..3 {
        // 40 runs: the root mean square scatters by 1/√80 = 11 %, three sigma
        let ratio = square[n].sqrt() / bound.frequency_std_hz[n];
        assert!((ratio - 1.0).abs() < 0.35, "mode {n}: {ratio}");
    }
}

#[test]
fn what_cannot_be_told_apart_is_said() {
    let spec = Synthetic {
        natural_frequency_hz: vec![50.0, 50.0],
        loss_factor: vec![0.02],
        damping: Damping::Structural,
        ..Synthetic::default()
    };
    let truth = spec.build().unwrap().truth;
    let error = cramer_rao(&truth, &spec.frequency_hz, 1.0, &[]).unwrap_err();
    assert!(error.to_string().contains("undetermined"), "{error}");
    let mut empty = truth;
    empty.modes.clear();
    assert!(cramer_rao(&empty, &spec.frequency_hz, 1.0, &[])
        .unwrap()
        .frequency_std_hz
        .is_empty());
}

#[test]
fn with_one_shape_per_mode_the_bound_is_the_inverse_of_the_full_information_matrix() {
    // every unknown (poles, shapes, participations but one of each mode, residual
    // coefficients of each FRF), by differences
    let spec = Synthetic {
        natural_frequency_hz: vec![50.0, 50.4],
        loss_factor: vec![0.02, 0.03],
        responses: 2,
        references: 3,
        frequency_hz: Array1::range(40.0, 60.0, 0.5),
        ..Synthetic::default()
    };
    for (responses, references, real) in [(2, 3, false), (3, 2, false), (2, 3, true), (3, 2, true)]
    {
        let shapes = if real {
            SyntheticShapes::Real
        } else {
            SyntheticShapes::Complex
        };
        let truth = Synthetic {
            responses,
            references,
            shapes,
            ..spec.clone()
        }
        .build()
        .unwrap()
        .truth;
        let powers = [-2, 0];
        let bound = if real {
            cramer_rao_real
        } else {
            cramer_rao_rank_one
        };
        let bound = bound(&truth, &spec.frequency_hz, 1.0, &powers).unwrap();
        let tau = std::f64::consts::TAU;
        // unknowns in order: Re-scaled poles, shapes, participations after the first,
        // residual terms
        let pole = |n: usize| {
            (tau * truth.modes[n].frequency_hz).powi(2)
                * Complex64::new(1.0, truth.modes[n].loss_factor)
        };
        let per_mode = 1 + responses + references - 1;
        let start: Vec<Complex64> = (0..2)
            .flat_map(|n| {
                let mode = &truth.modes[n];
                std::iter::once(pole(n))
                    .chain(mode.shape.0.clone())
                    .chain(mode.participation.0[1..].to_vec())
            })
            .chain(std::iter::repeat_n(
                Complex64::default(),
                powers.len() * responses * references,
            ))
            .collect();
        let frf = |unknowns: &[Complex64]| -> Vec<Complex64> {
            let mut all = Vec::new();
            for pair in 0..responses * references {
                let (i, j) = (pair / references, pair % references);
                for &f in &spec.frequency_hz {
                    let omega = tau * f;
                    let mut value = Complex64::default();
                    for n in 0..2 {
                        let own = &unknowns[n * per_mode..(n + 1) * per_mode];
                        let participation = if j == 0 {
                            truth.modes[n].participation.0[0]
                        } else {
                            own[responses + j]
                        };
                        value += own[1 + i] * participation / (own[0] - omega * omega);
                    }
                    for (p, &power) in powers.iter().enumerate() {
                        value += unknowns[2 * per_mode + pair * powers.len() + p]
                            * (f / 60.0f64).powi(power)
                            * 1e-6;
                    }
                    all.push(value * Complex64::new(0.0, omega));
                }
            }
            all
        };
        let columns: Vec<Vec<Complex64>> = (0..start.len())
            .map(|u| {
                let step = 1e-6 * start[u].norm().max(1.0);
                let moved = |sign: f64| {
                    let mut unknowns = start.clone();
                    unknowns[u] += sign * step;
                    frf(&unknowns)
                };
                moved(1.0)
                    .iter()
                    .zip(moved(-1.0))
                    .map(|(up, down)| (up - down) / (2.0 * step))
                    .collect()
            })
            .collect();
        let scale: Vec<f64> = columns
            .iter()
            .map(|c| c.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt())
            .collect();
        let jacobian = Array2::from_shape_fn((columns[0].len(), columns.len()), |(k, u)| {
            columns[u][k] / scale[u]
        });
        // real unknowns: the real parts of all, the imaginary parts of those that may be
        // complex
        let (height, count) = jacobian.dim();
        let complex = (0..count)
            .filter(|&u| !real || u % per_mode == 0 || u >= 2 * per_mode)
            .collect::<Vec<_>>();
        let stacked = Array2::from_shape_fn((2 * height, count + complex.len()), |(k, u)| {
            let value = if u < count {
                jacobian[[k % height, u]]
            } else {
                jacobian[[k % height, complex[u - count]]] * Complex64::i()
            };
            if k < height {
                value.re
            } else {
                value.im
            }
        });
        let information = chladni_linalg::matmul_h(stacked.view(), stacked.view());
        let covariance = chladni_linalg::inverse_hermitian(information.view()).unwrap();
        for n in 0..2 {
            let (re, im) = (
                n * per_mode,
                count + complex.iter().position(|&u| u == n * per_mode).unwrap(),
            );
            let eta = truth.modes[n].loss_factor;
            let unit = (0.5f64).sqrt() / scale[re] / pole(n).re;
            let frequency = unit * covariance[[re, re]].sqrt();
            let loss_factor = unit
                * (covariance[[im, im]] + eta * eta * covariance[[re, re]]
                    - 2.0 * eta * covariance[[re, im]])
                .sqrt();
            let found = bound.frequency_std_hz[n] / truth.modes[n].frequency_hz * 2.0;
            assert!(
                (found / frequency - 1.0).abs() < 1e-4,
                "mode {n}, real {real}: {found:e} against {frequency:e}"
            );
            let found = bound.loss_factor_std[n];
            assert!(
                (found / loss_factor - 1.0).abs() < 1e-4,
                "mode {n}, real {real}: {found:e} against {loss_factor:e}"
            );
        }
    }
}

#[test]
fn one_shape_per_mode_helps_close_modes_and_only_with_several_references() {
    let bounds = |references: usize, bandwidths: f64| {
        let spec = Synthetic {
            natural_frequency_hz: vec![50.0, 50.0 + bandwidths],
            loss_factor: vec![0.02],
            responses: 12,
            references,
            frequency_hz: Array1::range(30.0, 70.0, 0.1),
            ..Synthetic::default()
        };
        let truth = spec.build().unwrap().truth;
        let free = cramer_rao(&truth, &spec.frequency_hz, 1.0, &[0]).unwrap();
        let rank_one = cramer_rao_rank_one(&truth, &spec.frequency_hz, 1.0, &[0]).unwrap();
        let real = cramer_rao_real(&truth, &spec.frequency_hz, 1.0, &[0]).unwrap();
        [
            free.frequency_std_hz[0] / rank_one.frequency_std_hz[0],
            rank_one.frequency_std_hz[0] / real.frequency_std_hz[0],
        ]
    };
    assert!(
        (bounds(1, 0.1)[0] - 1.0).abs() < 1e-6,
        "one reference says nothing more"
    );
    let ([near, _], [middle, _], [far, real]) = (bounds(3, 0.1), bounds(3, 1.0), bounds(3, 10.0));
    assert!(
        near > 4.0 && near > middle && middle > 1.05,
        "{near} {middle}"
    );
    assert!((1.0..1.02).contains(&far), "{far}");
    // a phase known to be zero is worth √2 in the frequency of a lone mode, and a little
    // more beside a residual term
    assert!((1.41..1.5).contains(&real), "{real}");
}
