//! Time of each estimator on a long record of noise, by the clock and over H1's.
//!
//! `cargo run --release -p chladni-signal --example estimate_time [SECONDS] [CHANNELS]`:
//! one force and CHANNELS − 1 responses at 25.6 kHz, 10 minutes and 16 unless said.

use chladni_frf::{Channel, Dof, Estimator, Result, Run, SignalUnit};
use chladni_signal::{estimate, EstimateOptions};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::Instant;

const RATE_HZ: f64 = 25_600.0;

fn number(at: usize, default: usize) -> usize {
    let argument = std::env::args().nth(at);
    argument
        .and_then(|text| text.parse().ok())
        .unwrap_or(default)
}

/// White force, and responses of one resonator each, 1 % noise on them.
fn record(samples: usize, channels: usize) -> Result<Run> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = || random.random::<f64>() - 0.5;
    let force: Vec<f64> = (0..samples).map(|_| uniform()).collect();
    let dof = |text: String| -> Result<Dof> { text.parse().map_err(chladni_frf::Error::bad_data) };
    let mut all = vec![Channel {
        dof: dof("1000:+Z".to_owned())?,
        unit: SignalUnit::Force,
        is_reference: true,
        samples: force.clone(),
    }];
    for response in 1..channels {
        let turn = 2.0 * (0.05 + 0.1 * response as f64).cos() * 0.9995;
        let mut last = [0.0; 2];
        let mut answer = |x: f64| {
            let y = x + turn * last[0] - 0.999 * last[1];
            last = [y, last[0]];
            y + 0.01 * uniform()
        };
        all.push(Channel {
            dof: dof(format!("{response}:+Z"))?,
            unit: SignalUnit::Velocity,
            is_reference: false,
            samples: force.iter().map(|&x| answer(x)).collect(),
        });
    }
    Ok(Run {
        file: "noise".into(),
        line: 0,
        sample_rate_hz: RATE_HZ,
        channels: all,
    })
}

fn main() -> Result<()> {
    let (seconds, channels) = (number(1, 600), number(2, 16));
    let runs = [record(seconds * RATE_HZ as usize, channels)?];
    let mut of_h1 = None;
    for estimator in [
        Some(Estimator::H1),
        Some(Estimator::Lpm),
        Some(Estimator::Lrm),
        None,
    ] {
        let options = EstimateOptions {
            estimator,
            ..EstimateOptions::default()
        };
        let start = Instant::now();
        let result = estimate(&runs, &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let of_h1 = *of_h1.get_or_insert(seconds);
        println!(
            "{:8} {seconds:8.2} s, {:5.2} of H1, {} lines: {}",
            estimator.map_or("chosen", Estimator::name),
            seconds / of_h1,
            result.frf.frequency_hz.len(),
            result.estimation
        );
    }
    Ok(())
}
