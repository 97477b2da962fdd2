//! Estimators against closed forms: filters whose response is known, noise whose effect
//! is known.

use chladni_frf::{BlockWindow, Channel, Dof, ErrorKind, Estimator, FrfKind, Run, SignalUnit};
use chladni_signal::{estimate, Estimate, EstimateOptions};
use ndarray::Array3;
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

mod contradictions;
mod records;

/// E|δH|² of each value.
fn variance_of(result: &Estimate) -> &Array3<f64> {
    result.frf.variance.as_ref().unwrap()
}

/// White noise of variance 1, the same every time.
struct Noise(ChaCha8Rng);

impl Noise {
    fn new(seed: u8) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed.into()))
    }
    fn next(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }
    fn take(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.next()).collect()
    }
}

const RATE_HZ: f64 = 1000.0;
const BLOCK: usize = 64;

/// y_k = b0·x_k + b1·x_{k−1} over blocks that repeat: H = b0 + b1·e^{−jωΔ} exactly.
fn filtered(x: &[f64], [b0, b1]: [f64; 2]) -> Vec<f64> {
    let blocks = x.chunks(BLOCK);
    blocks
        .flat_map(|block| {
            (0..block.len())
                .map(move |k| b0 * block[k] + b1 * block[(k + block.len() - 1) % block.len()])
        })
        .collect()
}

fn truth([b0, b1]: [f64; 2], frequency_hz: f64) -> Complex64 {
    b0 + b1 * Complex64::from_polar(1.0, -TAU * frequency_hz / RATE_HZ)
}

fn channel(dof: &str, unit: SignalUnit, samples: Vec<f64>) -> Channel {
    Channel {
        dof: dof.parse().unwrap(),
        unit,
        is_reference: unit == SignalUnit::Force,
        samples,
    }
}

fn run(channels: Vec<Channel>) -> Run {
    Run {
        file: "test".into(),
        line: 0,
        sample_rate_hz: RATE_HZ,
        channels,
    }
}

fn options(estimator: Estimator) -> EstimateOptions {
    EstimateOptions {
        estimator: Some(estimator),
        window: Some(BlockWindow::Rectangular),
        block: Some(BLOCK),
        overlap: Some(0.0),
    }
}

const FILTER: [f64; 2] = [0.8, -0.5];
const OTHER: [f64; 2] = [-0.3, 1.2];

#[test]
fn a_filter_without_noise_is_found_by_every_estimator() {
    let x = Noise::new(1).take(BLOCK * 4);
    let y = filtered(&x, FILTER);
    for estimator in [Estimator::H1, Estimator::H2, Estimator::Hv] {
        let channels = vec![
            channel("101:+Z", SignalUnit::Force, x.clone()),
            channel("1:+Z", SignalUnit::Velocity, y.clone()),
        ];
        let result = estimate(&[run(channels)], &options(estimator)).unwrap();
        assert_eq!(result.frf.kind, Some(FrfKind::Mobility));
        assert_eq!(
            (result.frf.frequency_hz.len(), result.estimation.averages),
            (BLOCK / 2 - 1, [4, 4])
        );
        for (k, &f) in result.frf.frequency_hz.iter().enumerate() {
            assert!(
                (result.frf.values.get(0, 0, k) - truth(FILTER, f)).norm() < 1e-12,
                "{estimator:?} {f}"
            );
            assert!((result.frf.coherence.as_ref().unwrap()[[0, 0, k]] - 1.0).abs() < 1e-6);
            assert!(variance_of(&result)[[0, 0, k]] < 1e-12);
        }
    }
}

#[test]
fn two_references_at_once_are_told_apart() {
    let mut noise = Noise::new(2);
    let (a, b) = (noise.take(BLOCK * 8), noise.take(BLOCK * 8));
    let y: Vec<f64> = filtered(&a, FILTER)
        .iter()
        .zip(filtered(&b, OTHER))
        .map(|(p, q)| p + q)
        .collect();
    for estimator in [Estimator::H1, Estimator::Hv] {
        let channels = vec![
            channel("102:+Z", SignalUnit::Force, b.clone()),
            channel("101:+Z", SignalUnit::Force, a.clone()),
            channel("1:+Z", SignalUnit::Acceleration, y.clone()),
        ];
        let result = estimate(&[run(channels)], &options(estimator)).unwrap();
        assert_eq!(
            result
                .frf
                .references
                .iter()
                .map(Dof::to_string)
                .collect::<Vec<_>>(),
            ["101:+Z", "102:+Z"]
        );
        for (k, &f) in result.frf.frequency_hz.iter().enumerate() {
            assert!(
                (result.frf.values.get(0, 0, k) - truth(FILTER, f)).norm() < 1e-9,
                "{estimator:?}"
            );
            assert!(
                (result.frf.values.get(0, 1, k) - truth(OTHER, f)).norm() < 1e-9,
                "{estimator:?}"
            );
        }
    }
}

#[test]
fn noise_biases_h1_and_h2_by_the_known_factors_and_hv_by_their_geometric_mean() {
    const BLOCKS: usize = 4000;
    let mut noise = Noise::new(3);
    let x = noise.take(BLOCK * BLOCKS);
    let y: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
    // a quarter of the power at the reference, an ninth at the response
    let measured = |signal: &[f64], sigma: f64, noise: &mut Noise| -> Vec<f64> {
        signal.iter().map(|x| x + sigma * noise.next()).collect()
    };
    let (xn, yn) = (
        measured(&x, 0.5, &mut noise),
        measured(&y, 2.0 / 3.0, &mut noise),
    );
    let (at_x, at_y) = (1.25_f64, 1.0 + 1.0 / 9.0);
    for (estimator, factor) in [
        (Estimator::H1, 1.0 / at_x),
        (Estimator::H2, at_y),
        (Estimator::Hv, (at_y / at_x).sqrt()),
    ] {
        let channels = vec![
            channel("101:+Z", SignalUnit::Force, xn.clone()),
            channel("1:+Z", SignalUnit::Velocity, yn.clone()),
        ];
        let result = estimate(&[run(channels)], &options(estimator)).unwrap();
        let mean: Complex64 = (0..result.frf.frequency_hz.len())
            .map(|k| result.frf.values.get(0, 0, k))
            .sum();
        let mean = mean / result.frf.frequency_hz.len() as f64;
        // the scatter of a line is about 0.01 of it, that of the mean of 31 about 0.002
        assert!(
            (mean.re / 2.0 - factor).abs() < 0.01,
            "{estimator:?}: {mean} for {}",
            2.0 * factor
        );
        let coherence = result.frf.coherence.unwrap().mean().unwrap();
        assert!(
            (f64::from(coherence) - 1.0 / (at_x * at_y)).abs() < 0.01,
            "{coherence}"
        );
    }
}

#[test]
fn the_variance_is_that_of_repeated_measurements() {
    const REPEATS: u8 = 200;
    let mut squares = 0.0;
    let mut said = 0.0;
    let mut lines = 0;
    for (window, overlap) in [(BlockWindow::Rectangular, 0.0), (BlockWindow::Hann, 0.5)] {
        for seed in 0..REPEATS {
            let mut noise = Noise::new(seed);
            let x = noise.take(BLOCK * 20);
            let y: Vec<f64> = x.iter().map(|x| 3.0 * x + noise.next()).collect();
            let channels = vec![
                channel("101:+Z", SignalUnit::Force, x),
                channel("1:+Z", SignalUnit::Velocity, y),
            ];
            let options = EstimateOptions {
                window: Some(window),
                overlap: Some(overlap),
                ..options(Estimator::H1)
            };
            let result = estimate(&[run(channels)], &options).unwrap();
            // every third line: a Hann window ties neighbours together
            for k in (2..result.frf.frequency_hz.len()).step_by(3) {
                squares += (result.frf.values.get(0, 0, k) - 3.0).norm_sqr();
                said += variance_of(&result)[[0, 0, k]];
                lines += 1;
            }
        }
    }
    // the mean of n squares of complex errors scatters by 1/√n of it, heavier tails of
    // few averages by somewhat more
    let ratio = squares / said;
    assert!(
        (ratio - 1.0).abs() < 6.0 / f64::from(lines).sqrt(),
        "{ratio} over {lines} lines"
    );
}

#[test]
fn neighbouring_values_of_local_methods_err_nearly_independently() {
    // three responses of a constant FRF, noise 30 dB below each: D follows nothing but noise
    let mut noise = Noise::new(7);
    let x = noise.take(40_000);
    let gains = [1.0, -0.4, 2.0];
    // eq. F4k, and what D adds
    for (estimator, expected) in [(Estimator::Lpm, -0.107), (Estimator::Lrm, 0.14)] {
        let mut channels = vec![channel("101:+Z", SignalUnit::Force, x.clone())];
        for (gain, dof) in gains.iter().zip(["1:+Z", "2:+Z", "3:+Z"]) {
            let answer = |x: &f64| gain * (x + 0.0316 * noise.next());
            channels.push(channel(
                dof,
                SignalUnit::Velocity,
                x.iter().map(answer).collect(),
            ));
        }
        let local = EstimateOptions {
            estimator: Some(estimator),
            ..EstimateOptions::default()
        };
        let result = estimate(&[run(channels)], &local).unwrap();
        assert_eq!(result.estimation.lines_per_value, 13);
        let lines = result.frf.frequency_hz.len();
        assert_eq!(lines, 20_000 / 8 - 1);
        let mut sums = [0.0; 3];
        for (i, gain) in gains.into_iter().enumerate() {
            let error = |k: usize| {
                let deviation = variance_of(&result)[[i, 0, k]].sqrt();
                (result.frf.values.get(i, 0, k) - gain) / deviation
            };
            for k in 2..lines {
                let lags = sums.iter_mut().enumerate();
                lags.for_each(|(lag, sum)| *sum += (error(k) * error(k - lag).conj()).re);
            }
        }
        let [square, next, second] = sums;
        println!("{estimator}: {:.3}, {:.3}", next / square, second / square);
        assert!((next / square - expected).abs() < 0.04 && second.abs() < 0.04 * square);
    }
}

#[test]
fn an_exponential_window_moves_every_pole_by_its_rate() {
    // y = x * e^{−σt}: one pole; with the window the same at σ + α
    let sigma = 40.0;
    let alpha = 25.0;
    let count = 4096;
    let decay = |rate: f64| -> Vec<f64> {
        (0..count)
            .map(|k| (-rate * k as f64 / RATE_HZ).exp())
            .collect()
    };
    let mut blow = vec![0.0; count];
    blow[0] = 1.0;
    let of = |rate: f64, window: BlockWindow| {
        let channels = vec![
            channel("101:+Z", SignalUnit::Force, blow.clone()),
            channel("1:+Z", SignalUnit::Velocity, decay(rate)),
        ];
        let options = EstimateOptions {
            window: Some(window),
            block: Some(count),
            ..EstimateOptions::default()
        };
        estimate(&[run(channels)], &options).unwrap()
    };
    let windowed = of(sigma, BlockWindow::Exponential { rate_per_s: alpha });
    let moved = of(sigma + alpha, BlockWindow::Rectangular);
    for k in 0..windowed.frf.frequency_hz.len() {
        let (a, b) = (
            windowed.frf.values.get(0, 0, k),
            moved.frf.values.get(0, 0, k),
        );
        assert!((a - b).norm() < 1e-9 * b.norm());
    }
    assert!(
        windowed
            .findings
            .iter()
            .any(|warning| warning.contains("`exponential_window 25`")),
        "{:?}",
        windowed.findings
    );
    assert!(
        variance_of(&windowed)
            .iter()
            .all(|variance| variance.is_nan()),
        "one block says nothing of its scatter"
    );
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let x = Noise::new(9).take(BLOCK * 2);
    let force = || channel("101:+Z", SignalUnit::Force, x.clone());
    let velocity = || channel("1:+Z", SignalUnit::Velocity, x.clone());
    let message =
        |runs: &[Run], options: &EstimateOptions| estimate(runs, options).unwrap_err().to_string();
    let h1 = options(Estimator::H1);
    assert!(message(&[], &h1).contains("no time record"));
    assert!(message(&[run(vec![force()])], &h1).contains("without reference or without response"));
    assert!(
        message(&[run(vec![velocity()])], &h1).contains("without reference or without response")
    );
    assert!(message(
        &[run(vec![force(), velocity()])],
        &EstimateOptions {
            block: Some(10_000),
            ..h1
        }
    )
    .contains("no possible block"));
    // no record has such a block: the setting is wrong, not the file
    for (block, kind) in [(0, ErrorKind::Usage), (10_000, ErrorKind::BadData)] {
        let options = EstimateOptions {
            block: Some(block),
            ..h1
        };
        let error = estimate(&[run(vec![force(), velocity()])], &options).unwrap_err();
        assert_eq!(error.kind, kind, "{error}");
        assert_eq!(error.field.as_deref(), Some("block"), "{error}");
    }
    // no block fits: the record is at fault
    let samples = |unit, place: &str| channel(place, unit, vec![0.0, 1.0, 0.5]);
    let few = vec![
        samples(SignalUnit::Force, "101:+Z"),
        samples(SignalUnit::Velocity, "1:+Z"),
    ];
    let error = estimate(&[run(few)], &h1).unwrap_err();
    assert_eq!(error.field.as_deref(), Some("record"), "{error}");
    assert!(message(
        &[run(vec![force(), velocity()])],
        &EstimateOptions {
            overlap: Some(1.0),
            ..h1
        }
    )
    .contains("overlap"));
    let other = channel("2:+Z", SignalUnit::Acceleration, x.clone());
    assert!(message(&[run(vec![force(), velocity(), other])], &h1).contains("different quantities"));
    let second = channel("102:+Z", SignalUnit::Force, x.clone());
    let same_twice = message(&[run(vec![force(), second, velocity()])], &h1);
    assert!(same_twice.contains("tell no FRF"), "{same_twice}");
    let dead = channel("101:+Z", SignalUnit::Force, vec![0.5; x.len()]);
    assert!(message(&[run(vec![dead, velocity()])], &h1).contains("101:+Z is constant"));
    let slower = Run {
        sample_rate_hz: 500.0,
        ..run(vec![force(), velocity()])
    };
    assert!(message(&[run(vec![force(), velocity()]), slower], &h1).contains("sampling rates"));
    // times of printed digits: less than a tenth of a sample over the record
    let rounded = Run {
        sample_rate_hz: RATE_HZ * (1.0 + 0.05 / x.len() as f64),
        ..run(vec![force(), velocity()])
    };
    assert!(estimate(&[run(vec![force(), velocity()]), rounded], &h1).is_ok());
    // neither of two FRFs of one pair is the better one
    let both = Noise::new(10).take(x.len());
    let second = channel("102:+Z", SignalUnit::Force, both);
    let runs = [
        run(vec![force(), velocity()]),
        run(vec![force(), second, velocity()]),
    ];
    let told = message(&runs, &h1);
    assert!(
        told.contains("response 1:+Z, reference 101:+Z") && told.contains("101:+Z, 102:+Z"),
        "{told}"
    );
    let endless = EstimateOptions {
        block: Some(usize::MAX),
        ..EstimateOptions::default()
    };
    assert!(message(&[run(vec![force(), velocity()])], &endless).contains("no possible block"));
}

#[test]
fn noise_of_the_force_is_taken_off_where_responses_share_it() {
    const GAINS: [f64; 3] = [2.0, -1.0, 0.5];
    /// Noise of the force over the force.
    const SHARE: f64 = 0.1;
    let samples = 1 << 14;
    let made = |share: f64, responses: usize, seed: u8| {
        let mut noise = Noise::new(seed);
        let x = noise.take(samples);
        let read = x.iter().map(|x| x + share.sqrt() * noise.next());
        let mut channels = vec![channel("101:+Z", SignalUnit::Force, read.collect())];
        for (n, gain) in GAINS[..responses].iter().enumerate() {
            let y = x.iter().map(|x| gain * x + 1e-3 * noise.next()).collect();
            channels.push(channel(&format!("{}:+Z", n + 1), SignalUnit::Velocity, y));
        }
        estimate(
            &[run(channels)],
            &EstimateOptions {
                estimator: Some(Estimator::Lrm),
                ..EstimateOptions::default()
            },
        )
        .unwrap()
    };
    let mean = |result: &Estimate, row: usize| {
        let lines = result.frf.frequency_hz.len();
        let sum: f64 = (0..lines)
            .map(|k| result.frf.values.get(row, 0, k).re)
            .sum();
        sum / lines as f64
    };
    let says = |result: &Estimate| result.findings.iter().any(|f| f.code == "force-noise");
    // what is left of the bias, beside the scatter of a record
    let mut left = [0.0; 3];
    for seed in [29, 30, 31] {
        let result = made(SHARE, 3, seed);
        assert!(says(&result), "{:?}", result.findings);
        for (row, gain) in GAINS.iter().enumerate() {
            left[row] += (mean(&result, row) / gain - 1.0) / 3.0;
        }
    }
    assert!(left.iter().all(|left| left.abs() < 0.015), "{left:?}");
    // one response cannot tell: H1 is low by 1/(1 + share)
    let alone = made(SHARE, 1, 31);
    assert!(!says(&alone));
    let ratio = mean(&alone, 0) / GAINS[0];
    assert!((ratio * (1.0 + SHARE) - 1.0).abs() < 0.015, "{ratio}");
    let clean = made(0.0, 3, 31);
    assert!(!says(&clean), "{:?}", clean.findings);
}
