//! Gain of a channel over frequency: a table, from a data sheet or a bench measurement.
//!
//! Between two entries the logarithm of the gain and the phase are linear in frequency, so
//! that a delay is exact. The phase turns the nearer way from one entry to the next.

use crate::tolerances;
use chladni_frf::{Dof, Error, Result};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Gain of a channel at some frequencies: its motion on the rig over that in the model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainTable {
    /// Reference DOF; `None`: every channel without a table of its own.
    #[serde(default)]
    pub reference: Option<Dof>,
    /// Hz, rising; empty: one gain at every frequency.
    #[serde(default)]
    pub frequency_hz: Vec<f64>,
    /// Factor on the weight at each, above 0.
    pub gain: Vec<f64>,
    /// Phase of the factor, degrees; empty: 0.
    #[serde(default)]
    pub phase_deg: Vec<f64>,
    /// Standard deviation of the factor; empty: not known.
    #[serde(default)]
    pub std: Vec<f64>,
}

/// The gain of a table at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableGain {
    /// Factor on the weight.
    pub factor: Complex64,
    /// Its standard deviation over its amount; `None` where the table gives none.
    pub std_relative: Option<f64>,
}

impl GainTable {
    /// Name of the channel in messages.
    pub fn channel(&self) -> String {
        self.reference
            .map_or("every channel".into(), |dof| dof.to_string())
    }

    /// The gain at `frequency_hz`.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: a frequency that the table does not cover.
    pub fn at(&self, frequency_hz: f64) -> Result<TableGain> {
        let Some((before, share)) = self.place(frequency_hz) else {
            let (low, high) = (self.frequency_hz.first(), self.frequency_hz.last());
            return Err(
                Error::bad_data("the calibration holds no gain at this frequency")
                    .field("actuators.calibration")
                    .found(format!("{frequency_hz} Hz, {}", self.channel()))
                    .expected(format!(
                        "{} to {} Hz, which its table covers",
                        low.copied().unwrap_or_default(),
                        high.copied().unwrap_or_default()
                    ))
                    .help("choose a frequency inside, or measure the gain there and add it"),
            );
        };
        let after = (before + 1).min(self.gain.len() - 1);
        let between = |a: f64, b: f64| a + share * (b - a);
        let [log, next_log] = [before, after].map(|k| self.gain[k].ln());
        let phase = |k: usize| self.phase_deg.get(k).copied().unwrap_or(0.0);
        let turn = nearer_turn_deg(phase(before), phase(after));
        let radians = (phase(before) + share * turn).to_radians();
        let relative = |k: usize| self.std.get(k).map(|std| std / self.gain[k]);
        Ok(TableGain {
            factor: Complex64::from_polar(between(log, next_log).exp(), radians),
            std_relative: relative(before)
                .zip(relative(after))
                .map(|(a, b)| between(a, b)),
        })
    }

    /// The entry at or below `frequency_hz`, and the share of the way to the next one;
    /// `None` outside of the table.
    fn place(&self, frequency_hz: f64) -> Option<(usize, f64)> {
        let (Some(&low), Some(&high)) = (self.frequency_hz.first(), self.frequency_hz.last())
        else {
            return Some((0, 0.0));
        };
        let slack = tolerances::SAME_FREQUENCY * frequency_hz;
        if !(low - slack..=high + slack).contains(&frequency_hz) {
            return None;
        }
        let hz = frequency_hz.clamp(low, high);
        let above = self.frequency_hz.partition_point(|&entry| entry <= hz);
        let before = above.saturating_sub(1);
        let Some(next) = self.frequency_hz.get(before + 1) else {
            return Some((before, 0.0));
        };
        let own = self.frequency_hz[before];
        Some((before, (hz - own) / (next - own)))
    }

    /// Checks that the table can be used.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: lists of other lengths, frequencies that do not
    /// rise, a gain not above 0 or above [`tolerances::MOST_GAIN`], a phase that turns too far from one entry to the next.
    pub(crate) fn check(&self) -> Result<()> {
        let wrong = |field: &str, found: String, expected: &str| {
            Err(Error::bad_data("not a usable gain table")
                .field(field)
                .found(format!("{found}, {}", self.channel()))
                .expected(expected))
        };
        let count = self.frequency_hz.len().max(1);
        for (name, length, may_miss) in [
            ("gain", self.gain.len(), false),
            ("phase_deg", self.phase_deg.len(), true),
            ("std", self.std.len(), true),
        ] {
            if length != count && !(may_miss && length == 0) {
                let expected = "one for each frequency, or one where no frequency is given";
                return wrong(name, format!("{length} values"), expected);
            }
        }
        for (k, &gain) in self.gain.iter().enumerate() {
            if !(gain.is_finite() && gain > 0.0) {
                let expected = "a number above 0; a dead channel belongs into `dead`";
                return wrong("gain", format!("entry {}: {gain}", k + 1), expected);
            }
            if gain > tolerances::MOST_GAIN {
                let found = format!("entry {}: {gain}, {}", k + 1, self.channel());
                return Err(too_large("gain", found));
            }
        }
        if let Some(phase) = self.phase_deg.iter().find(|phase| !phase.is_finite()) {
            return wrong("phase_deg", phase.to_string(), "a number of degrees");
        }
        if let Some(std) = self.std.iter().find(|s| !(s.is_finite() && **s >= 0.0)) {
            return wrong("std", std.to_string(), "a number, 0 or more");
        }
        let is_frequency = |hz: &f64| hz.is_finite() && *hz > 0.0;
        if let Some(hz) = self.frequency_hz.iter().find(|hz| !is_frequency(hz)) {
            return wrong("frequency_hz", hz.to_string(), "a frequency above 0 Hz");
        }
        self.check_steps()
    }

    /// Checks what lies between the entries.
    fn check_steps(&self) -> Result<()> {
        for (k, pair) in self.frequency_hz.windows(2).enumerate() {
            let [low, high] = [pair[0], pair[1]];
            if high <= low {
                return Err(Error::bad_data("not a usable gain table")
                    .field("frequency_hz")
                    .found(format!("{high} Hz after {low} Hz, {}", self.channel()))
                    .expected("each frequency once, rising"));
            }
            let turn = match self.phase_deg.get(k..k + 2) {
                Some(phases) => nearer_turn_deg(phases[0], phases[1]),
                None => 0.0,
            };
            if turn.abs() > tolerances::MOST_TURN_DEG {
                return Err(Error::bad_data("the phase turns too far to be followed")
                    .field("phase_deg")
                    .found(format!(
                        "{turn:.0}° between {low} and {high} Hz, {}",
                        self.channel()
                    ))
                    .expected(format!(
                        "at most {}° from entry to entry",
                        tolerances::MOST_TURN_DEG
                    ))
                    .help("add entries between these two"));
            }
        }
        Ok(())
    }
}

/// The error of a gain above [`tolerances::MOST_GAIN`].
pub(super) fn too_large(field: impl Into<String>, found: String) -> Error {
    Error::bad_data("too large for a gain")
        .field(field)
        .found(found)
        .expected("a ratio, the motion on the rig over that in the model: at most 30 dB")
        .help("divide percents by 100; divide volts per volt by the nominal ones")
}

/// The turn from one phase to another, the nearer way, degrees.
fn nearer_turn_deg(from_deg: f64, to_deg: f64) -> f64 {
    let turn = (to_deg - from_deg).rem_euclid(360.0);
    match turn > 180.0 {
        true => turn - 360.0,
        false => turn,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A low pass of first order with a corner at 1500 Hz, and a delay of 0.2 ms.
    fn truth(hz: f64) -> Complex64 {
        let delay = Complex64::from_polar(1.0, -std::f64::consts::TAU * hz * 2e-4);
        delay / Complex64::new(1.0, hz / 1500.0)
    }

    fn table(count: u32, step_hz: f64) -> GainTable {
        let frequency_hz: Vec<f64> = (0..count).map(|k| 50.0 + step_hz * f64::from(k)).collect();
        let values: Vec<Complex64> = frequency_hz.iter().map(|&hz| truth(hz)).collect();
        GainTable {
            gain: values.iter().map(|value| value.norm()).collect(),
            phase_deg: values.iter().map(|v| v.arg().to_degrees()).collect(),
            frequency_hz,
            ..GainTable::default()
        }
    }

    #[test]
    fn a_coarse_table_follows_a_low_pass_with_a_delay() {
        // to 4500 Hz the phase turns by more than 360 degrees: wrapped entries
        let table = table(90, 50.0);
        assert!(table.phase_deg.iter().any(|&phase| phase > 90.0));
        table.check().unwrap();
        for k in 0..400 {
            let hz = 60.0 + 11.0 * f64::from(k);
            let gain = table.at(hz).unwrap();
            let error = (gain.factor / truth(hz) - 1.0).norm();
            // h²/8 of the curvature of ln g: (50/1500)²/8
            assert!(error < 1.5e-4, "{hz} Hz: {error}");
            assert_eq!(gain.std_relative, None);
        }
    }

    #[test]
    fn entries_are_taken_as_they_are_and_nothing_is_extrapolated() {
        let table = table(9, 50.0);
        for &hz in &table.frequency_hz {
            let error = (table.at(hz).unwrap().factor - truth(hz)).norm();
            assert!(error < 1e-14, "{hz} Hz: {error}");
        }
        for hz in [49.0, 451.0] {
            let error = table.at(hz).unwrap_err();
            assert_eq!(error.field.as_deref(), Some("actuators.calibration"));
            assert!(error.to_string().contains("50 to 450 Hz"), "{error}");
        }
    }

    #[test]
    fn the_standard_deviation_is_that_of_the_gain_over_it() {
        let table = GainTable {
            frequency_hz: vec![100.0, 200.0],
            gain: vec![2.0, 0.5],
            std: vec![0.02, 0.015],
            ..GainTable::default()
        };
        let middle = table.at(150.0).unwrap();
        assert!((middle.factor - 1.0).norm() < 1e-14, "{middle:?}");
        assert!((middle.std_relative.unwrap() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn tables_that_say_too_little_are_refused() {
        let good = table(9, 50.0);
        let mut cases = vec![good.clone(); 5];
        cases[0].gain[3] = 0.0;
        cases[1].gain.pop();
        cases[2].frequency_hz[4] = cases[2].frequency_hz[3];
        cases[3].phase_deg[5] += 150.0;
        cases[4].std = vec![0.1, 0.1];
        let fields = ["gain", "gain", "frequency_hz", "phase_deg", "std"];
        for (case, field) in cases.iter().zip(fields) {
            assert_eq!(case.check().unwrap_err().field.as_deref(), Some(field));
        }
    }
}
