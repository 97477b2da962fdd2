//! A signal that someone recorded or made, judged like a drive of our own.
//!
//! Each channel becomes a complex envelope about the carrier: its spectrum from 0 to twice
//! the carrier, moved down by it. What lies beyond does not take part.

use crate::field::AreaGrid;
use crate::operator::Operator;
use crate::plane::Rectangle;
use crate::scene::Scene;
use crate::time::causal::CausalModel;
use crate::time::judge::TimeMeasure;
use crate::time::listener::{Judging, Listener, Sounds, ToneLimits};
use crate::time::plan::{Chain, Plan};
use crate::time::play::{AreaMeasures, TimeEvent, TimeIndices};
use crate::time::signal::Sidecar;
use crate::time::simulate::SampledDrive;
use crate::time::table::{Measure, RampTime};
use crate::time::timeline::zones_of;
use crate::tolerances;
use crate::zones::ZoneMap;
use chladni_frf::{Dof, Error, ErrorKind, Finding, ModalModel, Result};
use ndarray::{s, Array2, Axis};
use num_complex::Complex64;
use rustfft::FftPlanner;
use std::f64::consts::TAU;

/// A drive as it is played.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Samples per second.
    pub rate_hz: f64,
    /// Actuators.
    pub references: Vec<Dof>,
    /// N or V; axes (frame, actuator).
    pub drive: Array2<f64>,
}

impl Recorded {
    /// From the samples of a sound file, −1 to 1, axes (frame, channel), and the file
    /// beside it.
    ///
    /// # Errors
    /// [`ErrorKind::BadData`]: another rate, a channel that the samples lack.
    pub fn from_samples(samples: &Array2<f64>, rate_hz: f64, sidecar: &Sidecar) -> Result<Self> {
        if rate_hz != f64::from(sidecar.rate_hz) {
            return Err(
                Error::bad_data("the sound file and its sidecar have different rates")
                    .field("rate_hz")
                    .found(format!("{rate_hz} Hz in the sound file"))
                    .expected(format!("{} Hz", sidecar.rate_hz)),
            );
        }
        let mut drive = Array2::zeros((samples.nrows(), sidecar.channels.len()));
        for (mut column, channel) in drive.columns_mut().into_iter().zip(&sidecar.channels) {
            if channel.channel > samples.ncols() {
                return Err(
                    Error::bad_data("the sound file lacks a channel of its sidecar")
                        .field("channels")
                        .found(format!("{} channels", samples.ncols()))
                        .expected(format!(
                            "channel {} of {}",
                            channel.channel, channel.reference
                        )),
                );
            }
            column.assign(&samples.column(channel.channel - 1));
            column.mapv_inplace(|value| value * channel.full_scale);
        }
        Ok(Self {
            rate_hz,
            references: sidecar
                .channels
                .iter()
                .map(|channel| channel.reference)
                .collect(),
            drive,
        })
    }
}

/// Envelopes of a recording on even samples.
struct Envelopes {
    step_s: f64,
    /// Axes (sample, actuator).
    values: Array2<Complex64>,
}

impl Envelopes {
    /// About `frequency_hz`, on samples `step_s` apart, in the order of `references`.
    fn new(recorded: &Recorded, operator: &Operator, step_s: f64) -> Result<Self> {
        let frames = recorded.drive.nrows();
        let count = (frames as f64 / recorded.rate_hz / step_s).ceil() as usize + 1;
        // so many frames that both rates have whole samples in the same time
        let length_s = step_s * count as f64;
        let padded = (length_s * recorded.rate_hz).round() as usize;
        let mut planner = FftPlanner::new();
        let (forward, back) = (
            planner.plan_fft_forward(padded),
            planner.plan_fft_inverse(count),
        );
        let line_hz = recorded.rate_hz / padded as f64;
        let carrier = (operator.frequency_hz / line_hz).round() as i64;
        let half = carrier.min(count as i64 / 2 - 1);
        let offset_hz = operator.frequency_hz - line_hz * carrier as f64;
        let mut values = Array2::zeros((count, operator.references.len()));
        for (k, reference) in recorded.references.iter().enumerate() {
            let Some(column) = operator
                .references
                .iter()
                .position(|r| r.same_axis(*reference))
            else {
                return Err(
                    Error::bad_data("the signal drives an actuator that the model lacks")
                        .field("channels")
                        .found(reference)
                        .expected(format!("one of {} references", operator.references.len())),
                );
            };
            let sign = reference.direction.sign() * operator.references[column].direction.sign();
            let mut spectrum = vec![Complex64::ZERO; padded];
            for (to, from) in spectrum.iter_mut().zip(recorded.drive.column(k)) {
                *to = (from * sign).into();
            }
            forward.process(&mut spectrum);
            let mut low = vec![Complex64::ZERO; count];
            for line in -half..half {
                let from = carrier + line;
                if (1..padded as i64 / 2).contains(&from) {
                    let to = line.rem_euclid(count as i64) as usize;
                    low[to] = spectrum[from as usize] * (2.0 / padded as f64);
                }
            }
            back.process(&mut low);
            for (n, value) in low.into_iter().enumerate() {
                let time_s = step_s * n as f64;
                values[[n, column]] = value * Complex64::from_polar(1.0, -TAU * offset_hz * time_s);
            }
        }
        Ok(Self { step_s, values })
    }

    fn at(&self, sample: usize) -> Option<ndarray::ArrayView1<'_, Complex64>> {
        (sample < self.values.nrows()).then(|| self.values.row(sample))
    }
}

impl Sounds for Envelopes {
    fn block(&self, step_s: f64, first: usize, count: usize) -> SampledDrive {
        let actuators = self.values.ncols();
        let mut values = Array2::zeros((count, actuators));
        let mut slopes = Array2::zeros((count, actuators));
        for k in 0..count {
            if let Some(row) = self.at(first + k) {
                values.row_mut(k).assign(&row);
            }
            let [before, after] = [(first + k).checked_sub(1), Some(first + k + 1)]
                .map(|sample| sample.and_then(|sample| self.at(sample)));
            let mut slope = slopes.slice_mut(s![k, ..]);
            if let Some(after) = after {
                slope += &after;
            }
            if let Some(before) = before {
                slope -= &before;
            }
            slope.mapv_inplace(|value| value / (2.0 * self.step_s));
        }
        SampledDrive {
            step_s,
            patterns: Array2::from_diag_elem(actuators, Complex64::ONE),
            values,
            slopes,
        }
    }
}

/// How a recorded drive does in `scene` on the panel of `model`, and what the user must
/// know.
///
/// * `events`: those of its sidecar, where it has them: ramps that the scene leaves open
///
/// # Errors
/// As [`crate::play`]; a scene with several tones.
pub fn evaluate_signal(
    recorded: &Recorded,
    events: &[TimeEvent],
    scene: &Scene,
    model: &ModalModel,
) -> Result<(TimeIndices, Vec<Finding>)> {
    if !scene.other_tones.is_empty() {
        return Err(
            Error::new(ErrorKind::Usage, "a signal is judged at one frequency")
                .field("frequency_hz")
                .found(format!("{} tones", 1 + scene.other_tones.len()))
                .expected("a scene with one frequency")
                .help("judge the weights instead, tone by tone"),
        );
    }
    let table = scene.time.clone().unwrap_or_default();
    let plan = Plan::new(&table, &scene.zones)?;
    let mut findings = Vec::new();
    let mut guessed = false;
    let chains = plan.chains(|_, event| match event.ramp {
        RampTime::Seconds(seconds) => seconds,
        RampTime::Auto => events
            .iter()
            .find(|known| known.event == event.name)
            .map_or(tolerances::GUESSED_RAMP_S, |known| known.ramp_s)
            .min(event.longest_ramp_s()),
    })?;
    for event in &plan.events {
        let known = events.iter().any(|known| known.event == event.name);
        guessed |= event.ramp == RampTime::Auto && !known;
    }
    if guessed {
        let taken_ms = 1e3 * tolerances::GUESSED_RAMP_S;
        findings.push(
            Finding::caution(
                "time-ramps-guessed",
                format!(
                    "the scene leaves its ramps open and the signal does not say them: \
                     {taken_ms:.0} ms are taken"
                ),
            )
            .value("ramp_s", tolerances::GUESSED_RAMP_S)
            .help("write ramp_s into the scene"),
        );
    }
    let operator = Operator::of_model(model, scene.frequency_hz, scene.actuators.only.as_deref())?;
    let step_s = tolerances::JUDGE_STEP_S;
    let envelopes = Envelopes::new(recorded, &operator, step_s)?;
    let scanned = Rectangle::around(&operator.positions_m)
        .ok_or_else(|| Error::new(ErrorKind::Internal, "an operator without responses"))?;
    let maps: Vec<ZoneMap> = plan
        .places
        .iter()
        .map(|place| zones_of(place, &scene.zones).over(scanned))
        .collect();
    let judging = Judging {
        zones: &scene.zones,
        maps: &maps,
        scanned,
        summation_s: table.summation_s,
    };
    let causal = CausalModel::new(model, &operator);
    let limits = vec![ToneLimits::of(scene)?];
    let points = Listener {
        positions_m: operator.positions_m.clone(),
        models: vec![causal.clone()],
        limits: limits.clone(),
        touch: None,
    };
    let envelopes = [envelopes];
    let heard = points.hear(&envelopes, &chains, &judging, &Measure::ALL);
    let area = AreaGrid::new(
        &operator.positions_m,
        maps[0].area(),
        tolerances::AREA_STEP_M,
    )
    .map(|grid| {
        let there = Listener {
            positions_m: grid.places.iter().map(|place| place.1).collect(),
            models: vec![causal.at(grid.interpolation())],
            limits,
            touch: None,
        };
        of_three(
            &there
                .hear(&envelopes, &chains, &judging, &Measure::ALL)
                .measures,
        )
    });
    let AreaMeasures { summed, peak, rms } = of_three(&heard.measures);
    let events = chains.iter().map(event_of).collect::<Vec<_>>();
    let indices = TimeIndices {
        summed,
        peak,
        rms,
        area,
        ramp_s: events.iter().map(|event| event.ramp_s).fold(0.0, f64::max),
        peak_drive: heard.peaks.iter().copied().fold(0.0, f64::max),
        steady_drive: 0.0,
        events,
    };
    let outside = recorded.drive.len_of(Axis(0)) as f64 / recorded.rate_hz
        < chains.iter().map(Chain::end_s).fold(0.0, f64::max) - step_s;
    if outside {
        findings.push(
            Finding::caution(
                "time-signal-short",
                "the signal ends before the last event of the scene",
            )
            .help("play the scene again"),
        );
    }
    Ok((indices, findings))
}

fn of_three(measures: &[TimeMeasure]) -> AreaMeasures {
    AreaMeasures {
        summed: measures[0],
        peak: measures[1],
        rms: measures[2],
    }
}

fn event_of(chain: &Chain) -> TimeEvent {
    TimeEvent {
        event: chain.name.clone(),
        start_s: chain.start_s(),
        end_s: chain.end_s(),
        ramp_s: chain.ramp_s,
        gain: 1.0,
    }
}
