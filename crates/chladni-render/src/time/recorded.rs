//! A signal that someone recorded or made, judged like a drive of our own.
//!
//! Each channel becomes a complex envelope about each tone: the spectrum nearest to it, from
//! 0 to twice the tone where it sounds alone, moved down by it.

use crate::panel::field::AreaGrid;
use crate::panel::operator::Operator;
use crate::scene::scene_file::Scene;
use crate::time::indices::{AreaMeasures, TimeEvent, TimeIndices};
use crate::time::listener::{Judging, Listener, Sounds};
use crate::time::plan::{Chain, Event, Plan};
use crate::time::sidecar::Sidecar;
use crate::time::simulate::SampledDrive;
use crate::time::table::{Measure, RampTime};
use crate::time::timeline::maps_over;
use crate::tolerances;
use chladni_frf::{Dof, Error, Finding, ModalModel, Result};
use chladni_linalg::fft;
use ndarray::{s, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The way out where a sound file and its sidecar contradict each other.
const OF_ONE_RUN: &str = "the two are of different runs, and forces would be judged wrongly: make \
                          both anew, or correct the sidecar of a recording";

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
    /// [`chladni_frf::ErrorKind::BadData`]: another rate or length, a channel that the samples
    /// lack.
    pub fn from_samples(samples: &Array2<f64>, rate_hz: f64, sidecar: &Sidecar) -> Result<Self> {
        if rate_hz != f64::from(sidecar.rate_hz) {
            return Err(
                Error::bad_data("the sound file and its sidecar have different rates")
                    .field("rate_hz")
                    .found(format!("{rate_hz} Hz in the sound file"))
                    .expected(format!("{} Hz, as the sidecar says", sidecar.rate_hz))
                    .help(OF_ONE_RUN),
            );
        }
        if samples.nrows() != sidecar.frames {
            return Err(
                Error::bad_data("the sound file and its sidecar have different lengths")
                    .field("frames")
                    .found(format!("{} frames in the sound file", samples.nrows()))
                    .expected(format!("{}, as the sidecar says", sidecar.frames))
                    .help(OF_ONE_RUN),
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

/// Envelopes of a recording on even samples, with their first and second derivatives by
/// seconds; axes (sample, actuator).
struct Envelopes([Array2<Complex64>; 3]);

impl Envelopes {
    /// About `tone_hz`, from what lies in `band_hz`, on samples `step_s` apart, in the
    /// order of the operator's references.
    fn new(
        recorded: &Recorded,
        operator: &Operator,
        band_hz: [f64; 2],
        step_s: f64,
    ) -> Result<Self> {
        let frames = recorded.drive.nrows();
        let count = (frames as f64 / recorded.rate_hz / step_s).ceil() as usize + 1;
        // so many frames that both rates have whole samples in the same time
        let length_s = step_s * count as f64;
        let padded = (length_s * recorded.rate_hz).round() as usize;
        let (forward, back) = (fft::forward(padded), fft::inverse(count));
        let line_hz = recorded.rate_hz / padded as f64;
        let carrier = (operator.frequency_hz / line_hz).round() as i64;
        let offset_hz = operator.frequency_hz - line_hz * carrier as f64;
        let [low, high] = band_hz.map(|edge_hz| (edge_hz / line_hz).round() as i64);
        let most = count as i64 / 2 - 1;
        let lines = low.max(1).max(carrier - most)..high.min(padded as i64 / 2).min(carrier + most);
        let mut envelopes = [(); 3].map(|()| Array2::zeros((count, operator.references.len())));
        for (k, reference) in recorded.references.iter().enumerate() {
            let (column, sign) = column_of(operator, *reference)?;
            let mut spectrum = vec![Complex64::ZERO; padded];
            for (to, from) in spectrum.iter_mut().zip(recorded.drive.column(k)) {
                *to = (from * sign).into();
            }
            forward.process(&mut spectrum);
            let mut lowered = [(); 3].map(|()| vec![Complex64::ZERO; count]);
            for from in lines.clone() {
                let line = from - carrier;
                let beside_hz = line_hz * line as f64 - offset_hz;
                let to = line.rem_euclid(count as i64) as usize;
                let mut value = spectrum[from as usize] * (2.0 / padded as f64);
                for lowered in &mut lowered {
                    lowered[to] = value;
                    value *= Complex64::new(0.0, TAU * beside_hz);
                }
            }
            for (lowered, to) in lowered.iter_mut().zip(&mut envelopes) {
                back.process(lowered);
                for (n, value) in lowered.iter().enumerate() {
                    let time_s = step_s * n as f64;
                    to[[n, column]] = value * Complex64::from_polar(1.0, -TAU * offset_hz * time_s);
                }
            }
        }
        Ok(Self(envelopes))
    }
}

/// Column of an actuator, and the sign by which its sense differs.
fn column_of(operator: &Operator, reference: Dof) -> Result<(usize, f64)> {
    let column = operator
        .references
        .iter()
        .position(|known| known.same_axis(reference))
        .ok_or_else(|| {
            Error::bad_data("the signal drives an actuator that the model lacks")
                .field("channels")
                .found(reference)
                .expected(format!("one of {} references", operator.references.len()))
        })?;
    let known = operator.references[column];
    Ok((column, reference.direction.sign() * known.direction.sign()))
}

impl Sounds for Envelopes {
    fn block(&self, step_s: f64, first: usize, count: usize) -> SampledDrive {
        let [values, slopes, bends] = self.0.each_ref().map(|from| {
            let mut to = Array2::zeros((count, from.ncols()));
            let end = from.nrows().min(first + count);
            if first < end {
                let known = from.slice(s![first..end, ..]);
                to.slice_mut(s![..end - first, ..]).assign(&known);
            }
            to
        });
        SampledDrive {
            step_s,
            patterns: Array2::from_diag_elem(values.ncols(), Complex64::ONE),
            values,
            slopes,
            bends,
        }
    }
}

/// The band that belongs to each of some tones: up to the middle between it and the next,
/// from 0 to twice the tone where there is none.
fn bands_hz(tones_hz: &[f64]) -> Vec<[f64; 2]> {
    let band = |&tone_hz: &f64| {
        let others = tones_hz.iter().copied();
        let below = others.clone().filter(|&other| other < tone_hz);
        let above = others.filter(|&other| other > tone_hz);
        [
            0.5 * (tone_hz + below.fold(-tone_hz, f64::max)),
            0.5 * (tone_hz + above.fold(3.0 * tone_hz, f64::min)),
        ]
    };
    tones_hz.iter().map(band).collect()
}

/// Judges a recorded drive in `scene` on the panel of `model`, and tells what the user
/// must know.
///
/// * `events`: those of its sidecar, where it has them: ramps that the scene leaves open, and
///   gains
///
/// # Errors
/// As [`crate::play`].
pub fn evaluate_signal(
    recorded: &Recorded,
    events: &[TimeEvent],
    scene: &Scene,
    model: &ModalModel,
) -> Result<(TimeIndices, Vec<Finding>)> {
    let table = scene.time.clone().unwrap_or_default();
    let plan = Plan::new(&table, &scene.zones)?;
    let mut findings = Vec::new();
    let chains = chains(&plan, events, &mut findings)?;
    let events: Vec<TimeEvent> = chains
        .iter()
        .map(|chain| TimeEvent::of(chain, told_gain(chain, events)))
        .collect();
    let ramp_s = events.iter().map(|event| event.ramp_s).fold(0.0, f64::max);
    let tones = scene.tones();
    let tones_hz: Vec<f64> = tones.iter().map(|tone| tone.frequency_hz).collect();
    let bands = bands_hz(&tones_hz);
    findings.extend(too_close(&tones_hz, ramp_s));
    let shortest_s = events
        .iter()
        .map(|event| event.ramp_s)
        .fold(f64::INFINITY, f64::min);
    findings.extend(few_periods(&tones_hz, shortest_s));
    let step_s = tolerances::JUDGE_STEP_S;
    let mut envelopes = Vec::new();
    for (tone, band_hz) in tones.iter().zip(bands) {
        let only = tone.actuators.only.as_deref();
        let operator = Operator::of_model(model, tone.frequency_hz, only)?;
        envelopes.push(Envelopes::new(recorded, &operator, band_hz, step_s)?);
    }
    let points = Listener::at_responses(model, scene)?;
    let (scanned, maps) = maps_over(&points.positions_m, &plan, &scene.zones)?;
    let judging = Judging {
        zones: &scene.zones,
        maps: &maps,
        scanned,
        summation_s: table.summation_s,
    };
    let heard = points.hear(&envelopes, &chains, &judging, &Measure::ALL);
    let grid = AreaGrid::new(&points.positions_m, maps[0].area(), tolerances::AREA_STEP_M);
    let area = grid.map(|grid| {
        let there = points.over(&grid);
        let heard = there.hear(&envelopes, &chains, &judging, &Measure::ALL);
        AreaMeasures::of(&heard.measures)
    });
    let AreaMeasures { summed, peak, rms } = AreaMeasures::of(&heard.measures);
    let end_s = chains.iter().map(Chain::end_s).fold(0.0, f64::max);
    if recorded.drive.nrows() as f64 / recorded.rate_hz < end_s - step_s {
        findings.push(ends_early());
    }
    let indices = TimeIndices {
        summed,
        peak,
        rms,
        area,
        ramp_s,
        peak_drive: heard.peak_together,
        steady_drive: steady_drive(&envelopes, &chains, &events),
        events,
    };
    Ok((indices, findings))
}

/// The entry of an event among `events`: the one of its name. A burst that repeats has several; of
/// these it is the one that begins nearest to the event.
fn told_of<'a>(events: &'a [TimeEvent], name: &str, start_s: f64) -> Option<&'a TimeEvent> {
    let apart = |event: &&TimeEvent| (event.start_s - start_s).abs();
    events
        .iter()
        .filter(|event| event.event == name)
        .min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// The gain of a chain as `events` tell it; 1 where they do not.
fn told_gain(chain: &Chain, events: &[TimeEvent]) -> f64 {
    told_of(events, &chain.name, chain.start_s())
        .map(|event| event.gain)
        .filter(|gain| *gain > 0.0)
        .unwrap_or(1.0)
}

/// The most that the drives of all tones together reach between the ramps, over the gains of
/// `events`, one for each chain.
fn steady_drive(tones: &[Envelopes], chains: &[Chain], events: &[TimeEvent]) -> f64 {
    let actuators = tones.first().map_or(0, |tone| tone.0[0].ncols());
    let mut most = 0.0;
    for (chain, event) in chains.iter().zip(events) {
        for ramps in chain.ramps.windows(2) {
            let middle_s = 0.5 * (ramps[0].end_s() + ramps[1].start_s);
            let sample = (middle_s / tolerances::JUDGE_STEP_S).round() as usize;
            for actuator in 0..actuators {
                let value = |tone: &Envelopes| tone.0[0].get([sample, actuator]).copied();
                let sizes = tones.iter().filter_map(value).map(|value| value.norm());
                most = f64::max(most, sizes.sum::<f64>() / event.gain);
            }
        }
    }
    most
}

/// The events of a scene; ramps that it leaves open are those of `events`, where it has
/// them.
fn chains(plan: &Plan, events: &[TimeEvent], findings: &mut Vec<Finding>) -> Result<Vec<Chain>> {
    let known = |event: &Event| told_of(events, &event.name, event.start_s());
    let is_open = |event: &&Event| event.ramp == RampTime::Auto && known(event).is_none();
    if plan.events.iter().any(|event| is_open(&event)) {
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
    plan.chains(|_, event| match event.ramp {
        RampTime::Seconds(seconds) => seconds,
        RampTime::Auto => known(event)
            .map_or(tolerances::GUESSED_RAMP_S, |known| known.ramp_s)
            .min(event.longest_ramp_s()),
    })
}

/// The finding of a signal that lacks the end of the scene.
fn ends_early() -> Finding {
    let words = "the signal ends before the last event of the scene";
    Finding::caution("time-signal-short", words).help("play the scene again")
}

/// Tones whose ramps reach into each other's bands.
fn too_close(tones_hz: &[f64], ramp_s: f64) -> Option<Finding> {
    let apart = |k: usize| {
        let others = tones_hz[k + 1..].iter();
        others.map(move |other_hz| (other_hz - tones_hz[k]).abs())
    };
    let nearest_hz = (0..tones_hz.len())
        .flat_map(apart)
        .fold(f64::INFINITY, f64::min);
    let needed_hz = 2.0 * tolerances::RAMP_SPREAD / ramp_s;
    (nearest_hz < needed_hz).then(|| {
        Finding::caution(
            "time-tones-close",
            format!(
                "tones lie {nearest_hz:.0} Hz apart, and ramps of {:.0} ms spread over \
                 {needed_hz:.0} Hz: part of one tone's ramp is judged as the other's",
                1e3 * ramp_s
            ),
        )
        .value("nearest_hz", nearest_hz)
        .value("needed_hz", needed_hz)
        .help("judge the weights with their ramps instead of the signal")
    })
}

/// A ramp of so few periods that its spectrum reaches through 0 Hz, where a signal of real numbers
/// does not tell a tone from its mirror image.
fn few_periods(tones_hz: &[f64], ramp_s: f64) -> Option<Finding> {
    let lowest_hz = tones_hz.iter().copied().fold(f64::INFINITY, f64::min);
    let periods = ramp_s * lowest_hz;
    (periods <= tolerances::RAMP_SPREAD).then(|| {
        let words = format!(
            "a ramp of {:.1} ms is {periods:.1} periods of {lowest_hz} Hz: a recording does not tell its \
             envelope to better than some decibels",
            1e3 * ramp_s
        );
        Finding::caution("time-ramp-few-periods", words)
            .value("periods", periods)
            .help("judge the weights with their ramps instead of the signal, or take longer ramps")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn each_burst_of_one_name_has_the_ramp_and_the_gain_that_are_told_of_it() {
        let text = "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[time]\n\
                    [[time.burst]]\nduration_s = 0.2\nramp_s = \"auto\"\nrepeat = [2, 0.5]\n";
        let scene = Scene::parse(text, Path::new("")).unwrap();
        let table = scene.time.clone().unwrap();
        let plan = Plan::new(&table, &scene.zones).unwrap();
        let of = |start_s: f64, ramp_s: f64, gain: f64| TimeEvent {
            event: "[[time.burst]] 1".into(),
            start_s,
            end_s: start_s + 0.2,
            ramp_s,
            gain,
        };
        let events = [of(0.0, 0.02, 1.5), of(0.5, 0.04, 1.2)];
        let mut findings = Vec::new();
        let chains = chains(&plan, &events, &mut findings).unwrap();
        let told: Vec<[f64; 2]> = chains
            .iter()
            .map(|chain| [chain.ramp_s, told_gain(chain, &events)])
            .collect();
        assert_eq!(told, [[0.02, 1.5], [0.04, 1.2]]);
        assert!(findings.is_empty(), "{findings:?}");
    }

    #[test]
    fn ramps_of_few_periods_are_named() {
        assert!(few_periods(&[330.0, 300.0], 0.003).is_some());
        assert!(few_periods(&[300.0], 0.005).is_some());
        assert!(few_periods(&[300.0], 0.008).is_none());
    }

    #[test]
    fn every_line_belongs_to_the_nearest_tone() {
        assert_eq!(bands_hz(&[300.0]), [[0.0, 600.0]]);
        assert_eq!(bands_hz(&[330.0, 250.0]), [[290.0, 660.0], [0.0, 290.0]]);
    }
}
