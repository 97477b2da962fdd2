//! Runs of time records: channels that were measured together.

mod even_times;

use crate::limits::{STARTS_APART, STEP_TOLERANCE};
use crate::{Abscissa, Document, Function, Ordinate};
use chladni_frf::{Channel, Dof, Error, Result, Run, SignalUnit};
use even_times::even_step;

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
/// Channels of one run that differ in length, sampling rate or start; an uneven time axis;
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
    let mut start_s = 0.0; // of the last run
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
            if let Some((channel, sampling)) = taken {
                match run.channels.is_empty() {
                    true => (run.sample_rate_hz, start_s) = (sampling.rate_hz, sampling.start_s),
                    false => refuse_other_sampling(run, &channel, &sampling)
                        .and_then(|()| refuse_other_start(run, &channel, start_s, &sampling))
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

/// The times of the samples of a channel.
struct Sampling {
    rate_hz: f64,
    /// Time of the first sample.
    start_s: f64,
}

/// A channel with its sampling.
fn taken(
    function: &Function,
    k: usize,
    overrides: &ChannelOverride,
) -> Result<(Channel, Sampling)> {
    let start = match &function.abscissa {
        Abscissa::Even { start, .. } => *start,
        Abscissa::Uneven(times) => times.first().copied().unwrap_or_default(),
    };
    let sampling = Sampling {
        rate_hz: sample_rate(function)?,
        start_s: start * function.abscissa_to_si,
    };
    Ok((channel(function, k, overrides)?, sampling))
}

/// Refuses a channel that was not sampled as the others of its run.
fn refuse_other_sampling(run: &Run, channel: &Channel, sampling: &Sampling) -> Result<()> {
    let (samples, of_run, of_run_hz) = (channel.samples.len(), run.samples(), run.sample_rate_hz);
    let rate_hz = sampling.rate_hz;
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

/// Refuses a channel that starts at another time than the first one of its run: its samples
/// would be compared with those of other times.
fn refuse_other_start(
    run: &Run,
    channel: &Channel,
    of_run_s: f64,
    sampling: &Sampling,
) -> Result<()> {
    let late_samples = (sampling.start_s - of_run_s) * run.sample_rate_hz;
    if late_samples.abs() <= STARTS_APART {
        return Ok(());
    }
    let first = run.channels.first().map(|channel| channel.dof.to_string());
    Err(Error::bad_data("channels of one run differ")
        .field(channel.dof.to_string())
        .found(format!(
            "a start at {} s, {late_samples:.3} samples from that of the run",
            sampling.start_s
        ))
        .expected(format!(
            "the start at {of_run_s} s of {}",
            first.unwrap_or_default()
        ))
        .help(
            "cut all channels of a run to the same times, or correct the start in the file; give \
             runs that started at different times as files of their own",
        ))
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

    /// Runs of records of (DOF, start in s, unit) with 8 samples at 100 Hz each.
    fn runs_from(records: &[(&str, f64, &str)]) -> Result<Vec<Run>> {
        let record = |&(dof, start, unit): &(&str, f64, &str)| {
            let times = Abscissa::Even { start, step: 0.01 };
            let axis = crate::Axis {
                unit: unit.into(),
                ..crate::Axis::default()
            };
            let samples = Ordinate::Real64(vec![1.0; 8]);
            Function::time_record(dof.parse().unwrap(), times, axis, samples)
        };
        let mut document = Document::new(std::path::Path::new("take.uff"), crate::FileFormat::Uff);
        document.functions = records.iter().map(record).collect();
        runs_of(&document, &ChannelOverride::default())
    }

    #[test]
    fn channels_of_one_run_that_start_at_other_times_are_refused() {
        let error = runs_from(&[("9:+Z", 0.0, "N"), ("1:+Z", 0.1, "m/s")]).unwrap_err();
        let told = error.to_string();
        for words in [
            "channels of one run differ",
            "1:+Z",
            "a start at 0.1 s, 10.000 samples",
            "the start at 0 s of 9:+Z",
            "cut all channels",
        ] {
            assert!(told.contains(words), "{words}: {told}");
        }
        // printed digits, and runs of a roving sensor
        assert!(runs_from(&[("9:+Z", 2.0, "N"), ("1:+Z", 2.000_05, "m/s")]).is_ok());
        let roving = [
            ("9:+Z", 0.0, "N"),
            ("1:+Z", 0.0, "m/s"),
            ("9:+Z", 5.0, "N"),
            ("2:+Z", 5.0, "m/s"),
        ];
        assert_eq!(runs_from(&roving).unwrap().len(), 2);
    }
}
