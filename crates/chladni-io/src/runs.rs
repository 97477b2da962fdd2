//! Runs of time records: channels that were measured together.

use crate::limits::{LATE_SAMPLES, LATE_STEPS, STEP_TOLERANCE, TIME_PIECES};
use crate::{Abscissa, Document, Function, Ordinate};
use chladni_frf::{Channel, Dof, Error, Result, Run, SignalUnit};

/// Function type of time records, dataset 58.
const TIME: i32 = 1;

/// Entry in place of a unit that leaves the channel out.
const LEFT_OUT: &str = "-";

/// The user's settings of the channels of each file, in their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChannelOverride {
    /// DOFs; empty: as in the file.
    pub dofs: Vec<Dof>,
    /// Units, or `-` where the channel is left out; empty: as in the file.
    pub units: Vec<String>,
    /// Units per unit of the file (of full scale, in WAV); empty: 1.
    pub scales: Vec<f64>,
    /// DOFs that excite; empty: forces, and voltages where there is no force.
    pub references: Vec<Dof>,
}

impl ChannelOverride {
    /// True where DOFs, units and factors of the channels are all given.
    pub fn says_all(&self) -> bool {
        self.lists().count() == 3
    }

    /// True where channel `k` of the file is left out.
    fn leaves_out(&self, k: usize) -> bool {
        !self.units.is_empty() && self.units[k % self.units.len()] == LEFT_OUT
    }

    /// The lists that are given, with their lengths.
    fn lists(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let lists = [
            ("dofs", self.dofs.len()),
            ("units", self.units.len()),
            ("scales", self.scales.len()),
        ];
        lists.into_iter().filter(|(_, count)| *count > 0)
    }

    /// Refuses lists whose length does not divide the number of time records.
    fn check_lengths(&self, records: usize) -> Result<()> {
        let misfit = self.lists().find(|(_, n)| !records.is_multiple_of(*n));
        misfit.map_or(Ok(()), |list| Err(no_fit(list, records)))
    }

    /// True where record `k` begins a run, by a list of units that leaves channels of each run
    /// out.
    fn begins_run(&self, k: usize, records: usize) -> bool {
        let in_run = self.units.len();
        let leaves_out = self.units.iter().any(|unit| unit == LEFT_OUT);
        leaves_out && in_run < records && k.is_multiple_of(in_run)
    }

    /// Refuses lists with neither one entry per time record nor one per channel of a run.
    /// `sizes`: number of channels of each run, with those left out.
    fn check_runs(&self, records: usize, sizes: &[usize]) -> Result<()> {
        let fits = |&(name, count): &(&str, usize)| {
            // one factor may be that of all channels
            let of_all = count == records || (count, name) == (1, "scales");
            of_all || sizes.iter().all(|size| *size == count)
        };
        let misfit = self.lists().find(|list| !fits(list));
        misfit.map_or(Ok(()), |list| Err(no_fit(list, records)))
    }
}

fn no_fit((name, count): (&'static str, usize), records: usize) -> Error {
    let error = Error::new(
        chladni_frf::ErrorKind::Usage,
        "the list does not fit the channels of the file",
    );
    error
        .field(name)
        .found(format!("{count} entries for {records} time records"))
        .expected("one entry per channel")
        .help("list the channels of one run in the order of the file")
}

/// Runs of a file: its time records in their order. A DOF that occurs again begins the next
/// run. So repeated records are averaged, and records of a roving sensor or hammer become
/// runs of their own.
///
/// # Errors
/// Channels of one run that differ in length or sampling rate; an uneven time axis;
/// masked samples; settings that do not fit.
pub fn runs_of(document: &Document, overrides: &ChannelOverride) -> Result<Vec<Run>> {
    let at = |function: &Function, error: Error| {
        let error = error.file(&document.file);
        if function.line > 0 {
            error.at_line(function.line)
        } else {
            error
        }
    };
    let records: Vec<&Function> = document
        .functions
        .iter()
        .filter(|function| function.function_type == TIME)
        .collect();
    let count = records.len();
    overrides
        .check_lengths(count)
        .map_err(|error| error.file(&document.file))?;
    let mut runs: Vec<Run> = Vec::new();
    // number of channels of each run, with those left out
    let mut sizes: Vec<usize> = Vec::new();
    for (k, function) in records.into_iter().enumerate() {
        let taken = match overrides.leaves_out(k) {
            true => None,
            false => Some(taken(function, k, overrides).map_err(|error| at(function, error))?),
        };
        let fits = |run: &Run| match &taken {
            None => true,
            Some((channel, _)) => !run
                .channels
                .iter()
                .any(|known| known.dof == channel.dof && known.unit == channel.unit),
        };
        if overrides.begins_run(k, count) || !runs.last().is_some_and(fits) {
            runs.push(Run {
                file: document.file.clone(),
                line: function.line,
                sample_rate_hz: 0.0,
                channels: Vec::new(),
            });
            sizes.push(0);
        }
        if let (Some(run), Some(size)) = (runs.last_mut(), sizes.last_mut()) {
            *size += 1;
            if let Some((channel, rate)) = taken {
                match run.channels.is_empty() {
                    true => run.sample_rate_hz = rate,
                    false => refuse_other_sampling(run, &channel, rate)
                        .map_err(|error| at(function, error))?,
                }
                run.channels.push(channel);
            }
        }
    }
    overrides
        .check_runs(count, &sizes)
        .map_err(|error| error.file(&document.file))?;
    runs.retain(|run| !run.channels.is_empty());
    for run in &mut runs {
        mark_references(run, &overrides.references);
    }
    Ok(runs)
}

/// A channel with its sampling rate, Hz.
fn taken(function: &Function, k: usize, overrides: &ChannelOverride) -> Result<(Channel, f64)> {
    let rate = sample_rate(function)?;
    Ok((channel(function, k, overrides)?, rate))
}

/// Refuses a channel that was not sampled as the others of its run.
fn refuse_other_sampling(run: &Run, channel: &Channel, rate_hz: f64) -> Result<()> {
    let (samples, of_run, of_run_hz) = (channel.samples.len(), run.samples(), run.sample_rate_hz);
    let differs = of_run != samples || (of_run_hz / rate_hz - 1.0).abs() > STEP_TOLERANCE;
    if !differs {
        return Ok(());
    }
    Err(Error::bad_data("channels of one run differ")
        .field(channel.dof.to_string())
        .found(format!("{samples} samples at {rate_hz} Hz"))
        .expected(format!("{of_run} samples at {of_run_hz} Hz"))
        .help("give runs of different lengths as files of their own"))
}

/// The unit of a channel: by quantity code of dataset 58, else by unit label.
fn unit_of(function: &Function) -> SignalUnit {
    let axis = &function.axes[1];
    match axis.quantity {
        8 => SignalUnit::Displacement,
        11 => SignalUnit::Velocity,
        12 => SignalUnit::Acceleration,
        9 | 13 => SignalUnit::Force,
        _ => signal_unit(&axis.unit).map_or(SignalUnit::Unknown, |(unit, _)| unit),
    }
}

/// The SI unit that a unit label stands for, and the factor to it.
pub(crate) fn signal_unit(label: &str) -> Option<(SignalUnit, f64)> {
    let unit = crate::unit_label::parse(label)?;
    let measured = match unit.powers {
        [1, 1, -2, 0, 0, 0] => SignalUnit::Force,
        [0, 0, 0, 1, 0, 0] => SignalUnit::Volt,
        [1, 0, 0, 0, 0, 0] => SignalUnit::Displacement,
        [1, 0, -1, 0, 0, 0] => SignalUnit::Velocity,
        [1, 0, -2, 0, 0, 0] => SignalUnit::Acceleration,
        _ => return None,
    };
    Some((measured, unit.factor))
}

/// Marks the channels that excite: forces, or voltages where there is no force; at the DOFs in
/// `named`, all but motions.
fn mark_references(run: &mut Run, named: &[Dof]) {
    let has_force = run
        .channels
        .iter()
        .any(|channel| channel.unit == SignalUnit::Force);
    let excites = if has_force {
        SignalUnit::Force
    } else {
        SignalUnit::Volt
    };
    let of_drives: Vec<Dof> = run
        .channels
        .iter()
        .filter(|channel| channel.unit == excites)
        .map(|channel| channel.dof)
        .collect();
    for channel in &mut run.channels {
        let excites = channel.unit == excites;
        channel.is_reference = match named {
            [] => excites,
            named => {
                let could = channel.unit.frf_kind().is_none() && !of_drives.contains(&channel.dof);
                named.contains(&channel.dof) && (excites || could)
            }
        };
    }
}

fn channel(function: &Function, k: usize, overrides: &ChannelOverride) -> Result<Channel> {
    let of = |count: usize| if count == 0 { None } else { Some(k % count) };
    let dof = of(overrides.dofs.len()).map_or(function.response, |at| overrides.dofs[at]);
    let (unit, factor) = match of(overrides.units.len()) {
        None => (unit_of(function), function.scale_to_si),
        Some(at) => signal_unit(&overrides.units[at]).ok_or_else(|| {
            Error::new(
                chladni_frf::ErrorKind::Usage,
                "no unit of a force, voltage or motion",
            )
            .field("units")
            .found(&overrides.units[at])
            .expected("N, V, m, m/s, m/s^2, g or the like; - leaves a channel out")
        })?,
    };
    let scale = factor * of(overrides.scales.len()).map_or(1.0, |at| overrides.scales[at]);
    let samples: Vec<f64> = match &function.ordinate {
        Ordinate::Real32(values) => values
            .iter()
            .map(|&value| f64::from(value) * scale)
            .collect(),
        Ordinate::Real64(values) => values.iter().map(|&value| value * scale).collect(),
        Ordinate::Complex32(_) | Ordinate::Complex64(_) => {
            return Err(Error::bad_data("a time record of complex values")
                .field("ordinate")
                .found("complex")
                .expected("real samples"))
        }
    };
    if let Some(masked) = samples.iter().position(|sample| !sample.is_finite()) {
        return Err(
            Error::bad_data("a time record with a sample that is not finite")
                .field(format!("sample {}", masked + 1))
                .found(samples[masked])
                .expected("finite samples without gaps")
                .help("cut the record, or leave this run or channel out"),
        );
    }
    Ok(Channel {
        dof,
        unit,
        is_reference: false,
        samples,
    })
}

/// The step of times that are even but for printed digits; `to_s`: one unit of them.
fn even_step(times: &[f64], to_s: f64) -> Result<f64> {
    let steps = times.len().saturating_sub(1);
    let (Some(first), Some(last), 1..) = (times.first(), times.last(), steps) else {
        return Ok(0.0);
    };
    let mean = (last - first) / steps as f64;
    // printed times round at the last of their digits
    let largest = first.abs().max(last.abs());
    let rounding = STEP_TOLERANCE.max(1e-5 * largest / mean.abs().max(f64::MIN_POSITIVE));
    let single = times.windows(2).map(|pair| (1, pair[1] - pair[0]));
    // steps that differ little from one to the next may add up
    let pieces = TIME_PIECES.min(steps);
    let of_pieces = (0..pieces).map(|n| {
        let (from, to) = (n * steps / pieces, (n + 1) * steps / pieces);
        (to - from, times[to] - times[from])
    });
    check_steps(single, mean, |_| rounding.min(0.1), to_s)?;
    check_steps(
        of_pieces,
        mean,
        |count| LATE_STEPS.max(LATE_SAMPLES / count as f64),
        to_s,
    )?;
    Ok(mean)
}

/// Refuses times that differ from even ones.
///
/// * `spans`: numbers of steps, and the time that they take
/// * `most`: relative difference up to which so many steps are even
fn check_steps(
    spans: impl Iterator<Item = (usize, f64)>,
    mean: f64,
    most: impl Fn(usize) -> f64,
    to_s: f64,
) -> Result<()> {
    let (mut least, mut largest, mut is_even) = (f64::INFINITY, f64::NEG_INFINITY, true);
    for (count, span) in spans {
        let step = span / count as f64;
        (least, largest) = (least.min(step), largest.max(step));
        is_even &= (step / mean - 1.0).abs() <= most(count);
    }
    if is_even {
        return Ok(());
    }
    Err(Error::bad_data("the samples are not evenly spaced in time")
        .field("time axis")
        .found(format!(
            "steps from {:.4e} to {:.4e} s",
            least * to_s,
            largest * to_s
        ))
        .expected("one step: one sampling rate")
        .help("resample the record first"))
}

fn sample_rate(function: &Function) -> Result<f64> {
    let step = match &function.abscissa {
        Abscissa::Even { step, .. } => *step,
        Abscissa::Uneven(times) => even_step(times, function.abscissa_to_si)?,
    };
    let step = step * function.abscissa_to_si;
    match step.is_finite() && step > 0.0 {
        true => Ok(1.0 / step),
        false => Err(Error::bad_data("no sampling rate")
            .field("time step")
            .found(step)
            .expected("a time step above 0 s")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_of_all_records_or_of_the_channels_of_each_run() {
        let taken = |scales: usize, units: usize, sizes: &[usize]| {
            let overrides = ChannelOverride {
                scales: vec![1.0; scales],
                units: vec!["m/s".into(); units],
                ..ChannelOverride::default()
            };
            overrides.check_runs(4, sizes).is_ok()
        };
        let (one, two) = ([4], [2, 2]);
        assert!(taken(4, 4, &one) && taken(2, 2, &two) && taken(1, 0, &one));
        assert!(!taken(2, 0, &one) && !taken(0, 2, &one) && !taken(0, 1, &one));
    }

    #[test]
    fn a_dash_in_place_of_a_unit_leaves_its_channel_out() {
        let text = "t,1:+Z_N,1:+Z_N,2:+Z_m/s\n0,1,5,2\n1,3,5,4\n2,5,5,6\n";
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("take.csv");
        std::fs::write(&file, text).unwrap();
        let document = crate::read_documents(&[file], &crate::ReadOptions::default()).unwrap();
        let overrides = ChannelOverride {
            units: ["N", "-", "m/s"].map(String::from).to_vec(),
            ..ChannelOverride::default()
        };
        let runs = runs_of(&document[0], &overrides).unwrap();
        let [run] = &runs[..] else {
            panic!("{runs:?}");
        };
        let units: Vec<SignalUnit> = run.channels.iter().map(|channel| channel.unit).collect();
        assert_eq!(units, [SignalUnit::Force, SignalUnit::Velocity]);
        assert_eq!(run.channels[1].samples, [2.0, 4.0, 6.0]);
        // with it, the DOF that comes again begins a run
        let all = runs_of(&document[0], &ChannelOverride::default()).unwrap();
        assert_eq!(all.len(), 2);
    }

    #[test]
    fn times_whose_steps_change_on_the_way_are_refused_and_printed_digits_are_not() {
        let read = |time: &dyn Fn(usize) -> String| {
            let rows = (0..20_000).map(|k| format!("{},{},0\n", time(k), k % 7));
            let text = format!("t,1:+Z_N,2:+Z_m/s\n{}", rows.collect::<String>());
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("take.csv");
            std::fs::write(&file, text).unwrap();
            let document = crate::read_documents(&[file], &crate::ReadOptions::default()).unwrap();
            runs_of(&document[0], &ChannelOverride::default())
        };
        let rounded = read(&|k| format!("{:.6}", k as f64 / 51_200.0)).unwrap();
        assert!((rounded[0].sample_rate_hz / 51_200.0 - 1.0).abs() < 1e-5);
        let error = read(&|k| format!("{:.6}", k as f64 * 1e-3 + 5e-5 * k.max(10_000) as f64));
        let told = error.unwrap_err().to_string();
        assert!(
            told.contains("not evenly spaced")
                && told.contains("steps from 1.0000e-3 to 1.0500e-3 s"),
            "{told}"
        );
        // times summed up in single precision, and those that end at the trigger
        let mut sum = 0.0_f32;
        let summed = std::iter::repeat_with(|| {
            sum += 1e-4;
            f64::from(sum)
        });
        let summed: Vec<f64> = summed.take(20_000).collect();
        assert!(read(&|k| format!("{:.7}", summed[k])).is_ok());
        assert!(read(&|k| format!("{:.6}", (k as f64 - 19_999.0) / 51_200.0)).is_ok());
        for slips in [0.028, 0.004] {
            let slipping = |k: usize| 1e-3 * (k as f64 + slips * k.max(10_000) as f64);
            assert!(read(&|k| slipping(k).to_string()).is_err(), "{slips}");
        }
        let falling = even_step(&[2.0, 1.0, 0.0], 1.0).unwrap();
        assert_eq!(falling, -1.0);
        assert!(even_step(&[0.0, f64::NAN, 2.0, 3.0], 1.0).is_err());
    }
}
