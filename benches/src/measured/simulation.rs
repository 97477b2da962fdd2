//! A test in time: viscous modes, driven from sample to sample.
//!
//! The response of a mode to impulses is sampled: its poles are exact, and what sampling
//! adds to an FRF is smooth. Where the force drops, white noise goes through a filter with a
//! zero at every pole s of the structure and a pole at d·Re s + j·Im s: at resonance the
//! force lies 20·lg d dB lower.

use super::cell::{MeasuredCell, MeasuredForce, RECORD_S};
use chladni_frf::{
    Channel, Direction, Dof, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit, Run, SignalUnit,
};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// High enough that what sampling adds to an FRF is smooth in the band: at 512 Hz a fit of
/// exact FRFs was off by 0.014 % in damping, as much as the local rational method is by
/// noise; at 1024 Hz by 2e-6 %.
const RATE_HZ: f64 = 1024.0;
/// Samples of a record.
pub(super) const RECORD: usize = 2048;
/// Band that is fitted, Hz.
pub(super) const BAND_HZ: [f64; 2] = [20.0, 245.0];
/// Natural frequencies, Hz, before each structure moves its own.
const MODES_HZ: [f64; 4] = [60.0, 112.0, 168.0, 221.0];
/// ... by so much of themselves (rms).
const MOVED: f64 = 0.01;
/// Records before the first that counts, of a continuous force.
const SETTLING: usize = 6;

/// A mode as it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TrueMode {
    pub frequency_hz: f64,
    pub loss_factor: f64,
    /// At the responses.
    pub shape: Vec<f64>,
}

impl TrueMode {
    fn pole(&self) -> Complex64 {
        let (omega, zeta) = (TAU * self.frequency_hz, 0.5 * self.loss_factor);
        omega * Complex64::new(-zeta, (1.0 - zeta * zeta).sqrt())
    }
}

/// A test: what was measured, and the truth.
pub(super) struct Simulated {
    pub runs: Vec<Run>,
    /// FRFs that need no estimation.
    pub frf: Option<FrfSet>,
    pub modes: Vec<TrueMode>,
}

/// The test of a seed.
pub(super) fn simulated(cell: &MeasuredCell, seed: u64) -> Simulated {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let modes = structure(cell, &mut normal);
    if cell.force == MeasuredForce::Sines {
        return Simulated {
            runs: Vec::new(),
            frf: Some(sines(cell, &modes, &mut normal)),
            modes,
        };
    }
    let mut channels = responses(cell, &modes, &mut normal);
    let (forces, velocities) = channels.split_at_mut(cell.forces);
    for (channels, snr_db) in [(forces, cell.force_snr_db), (velocities, cell.snr_db)] {
        let power = mean_square(channels.iter().flatten());
        let sigma = (power * 10f64.powf(-0.1 * snr_db)).sqrt();
        for value in channels.iter_mut().flatten() {
            *value += sigma * normal();
        }
    }
    let length = match cell.force {
        MeasuredForce::Random => channels[0].len(),
        _ => RECORD,
    };
    let runs = (0..channels[0].len() / length)
        .map(|run| as_run(&channels, cell.forces, run * length..(run + 1) * length))
        .collect();
    Simulated {
        runs,
        frf: None,
        modes,
    }
}

/// Mobilities with white noise on the lines of a record.
fn sines(cell: &MeasuredCell, modes: &[TrueMode], normal: &mut impl FnMut() -> f64) -> FrfSet {
    let lines = (BAND_HZ[1] * RECORD_S) as usize;
    let frequency_hz = Array1::from_shape_fn(lines, |k| (k + 1) as f64 / RECORD_S);
    let mut values = Array3::from_shape_fn((cell.responses, 1, lines), |(i, _, k)| {
        let jw = Complex64::new(0.0, TAU * frequency_hz[k]);
        let of_mode = |mode: &TrueMode| {
            let s = mode.pole();
            let residue = mode.shape[i] * mode.shape[0] * s / Complex64::new(0.0, 2.0 * s.im);
            residue / (jw - s) + residue.conj() / (jw - s.conj())
        };
        modes.iter().map(of_mode).sum::<Complex64>()
    });
    let power = values.iter().map(Complex64::norm_sqr).sum::<f64>() / values.len() as f64;
    let sigma = (0.5 * power * 10f64.powf(-0.1 * cell.snr_db)).sqrt();
    values.mapv_inplace(|v| v + sigma * Complex64::new(normal(), normal()));
    let dof = |n: usize| Dof::new(n as u64, Direction::PLUS_Z);
    FrfSet {
        frequency_hz,
        values: FrfValues::F64(values),
        responses: (1..=cell.responses).map(dof).collect(),
        references: vec![dof(1)],
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: Geometry::default(),
    }
}

fn mean_square<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    sum / count
}

/// Modes that every response shows.
fn structure(cell: &MeasuredCell, normal: &mut impl FnMut() -> f64) -> Vec<TrueMode> {
    let bandwidth_hz = cell.lines_per_bandwidth / RECORD_S;
    let mode = |hz: &f64| {
        let frequency_hz = hz * (1.0 + MOVED * normal());
        let value = || {
            let x = normal();
            x.signum() * (0.4 + x.abs())
        };
        TrueMode {
            frequency_hz,
            loss_factor: bandwidth_hz / frequency_hz,
            shape: std::iter::repeat_with(value).take(cell.responses).collect(),
        }
    };
    MODES_HZ.iter().map(mode).collect()
}

/// Forces and velocities over all that is measured.
fn responses(
    cell: &MeasuredCell,
    modes: &[TrueMode],
    normal: &mut impl FnMut() -> f64,
) -> Vec<Vec<f64>> {
    let poles: Vec<Complex64> = modes.iter().map(TrueMode::pole).collect();
    let steps: Vec<Complex64> = poles.iter().map(|s| (s / RATE_HZ).exp()).collect();
    let gains: Vec<Complex64> = poles
        .iter()
        .map(|s| s / Complex64::new(0.0, s.im))
        .collect();
    let mut filters: Vec<Filter> = (0..cell.forces)
        .map(|_| Filter::new(&poles, cell.drop_db))
        .collect();
    let settling = match cell.force {
        MeasuredForce::Random => SETTLING,
        _ => 0,
    };
    let mut states = vec![Complex64::default(); modes.len()];
    let mut channels = vec![Vec::new(); cell.forces + cell.responses];
    for record in 0..settling + cell.records {
        if cell.force != MeasuredForce::Random {
            states.fill(Complex64::default());
            filters.iter_mut().for_each(Filter::rest);
        }
        for k in 0..RECORD {
            let drive = || match cell.force {
                MeasuredForce::Random => normal(),
                MeasuredForce::Burst(part) if (k as f64) < part * RECORD as f64 => normal(),
                MeasuredForce::Hammer if k == 0 => 1.0,
                _ => 0.0,
            };
            let drives: Vec<f64> = std::iter::repeat_with(drive).take(cell.forces).collect();
            let forces: Vec<f64> = filters
                .iter_mut()
                .zip(drives)
                .map(|(filter, drive)| filter.next(drive))
                .collect();
            let of_mode = |mode: &TrueMode| -> f64 {
                mode.shape.iter().zip(&forces).map(|(at, f)| at * f).sum()
            };
            let felt: Vec<f64> = modes.iter().map(of_mode).collect();
            for ((state, step), felt) in states.iter_mut().zip(&steps).zip(&felt) {
                *state = *state * step + felt;
            }
            if record < settling {
                continue;
            }
            for (channel, force) in channels.iter_mut().zip(&forces) {
                channel.push(*force);
            }
            for (i, channel) in channels[cell.forces..].iter_mut().enumerate() {
                // half of the force that acts now: else every FRF had a constant part, which
                // no structure has
                let velocity = |n: usize| {
                    let here = gains[n] * (states[n] - 0.5 * felt[n]);
                    modes[n].shape[i] * here.re / RATE_HZ
                };
                channel.push((0..modes.len()).map(velocity).sum());
            }
        }
    }
    channels
}

/// Second-order sections, one for each pole.
struct Filter {
    sections: Vec<Section>,
}

struct Section {
    zero: [f64; 2],
    pole: [f64; 2],
    inputs: [f64; 2],
    outputs: [f64; 2],
}

impl Filter {
    fn new(poles: &[Complex64], drop_db: f64) -> Self {
        let wider = 10f64.powf(drop_db / 20.0);
        // 1 − 2 Re(e)·z⁻¹ + |e|²·z⁻²
        let of = |s: Complex64| {
            let e = (s / RATE_HZ).exp();
            [-2.0 * e.re, e.norm_sqr()]
        };
        let section = |s: &Complex64| Section {
            zero: of(*s),
            pole: of(Complex64::new(wider * s.re, s.im)),
            inputs: [0.0; 2],
            outputs: [0.0; 2],
        };
        let sections = if drop_db > 0.0 {
            poles.iter().map(section).collect()
        } else {
            Vec::new()
        };
        Self { sections }
    }

    fn rest(&mut self) {
        for section in &mut self.sections {
            (section.inputs, section.outputs) = ([0.0; 2], [0.0; 2]);
        }
    }

    fn next(&mut self, input: f64) -> f64 {
        self.sections.iter_mut().fold(input, |x, section| {
            let [x1, x2] = section.inputs;
            let [y1, y2] = section.outputs;
            let y = x + section.zero[0] * x1 + section.zero[1] * x2
                - section.pole[0] * y1
                - section.pole[1] * y2;
            (section.inputs, section.outputs) = ([x, x1], [y, y1]);
            y
        })
    }
}

/// A part of the channels, of which the first are forces.
fn as_run(channels: &[Vec<f64>], forces: usize, part: std::ops::Range<usize>) -> Run {
    let channel = |(n, samples): (usize, &Vec<f64>)| {
        let (at, unit) = match n.checked_sub(forces) {
            None => (n, SignalUnit::Force),
            Some(response) => (response, SignalUnit::Velocity),
        };
        Channel {
            dof: Dof::new(1 + at as u64, Direction::PLUS_Z),
            unit,
            is_reference: n < forces,
            samples: samples[part.clone()].to_vec(),
        }
    };
    Run {
        file: "simulated".into(),
        line: 0,
        sample_rate_hz: RATE_HZ,
        channels: channels.iter().enumerate().map(channel).collect(),
    }
}
