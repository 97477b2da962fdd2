//! The least velocity that a fingertip feels: threshold profiles over frequency, peak
//! values.
//!
//! The threshold is a profile because real conditions move it by 25 to 40 dB: a small
//! passive contactor is far less sensitive than a finger pressed flat on glass. The
//! contrast in dB, which needs no threshold, is reported beside it.
//!
//! Source of the table: minimum perceptible acceleration of the Android platform
//! (digitised displacement threshold of the Verrillo and Bolanowski kind; Bolanowski et
//! al., JASA 84, 1680-1694, 1988). Between two entries the level in dB is linear in log
//! f; outside the table there is no threshold, and nothing is extrapolated.

use crate::digits::hertz;
use chladni_frf::{Error, Finding, Result};
use chladni_text::read_text;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Threshold of the profile `paper`, m/s peak, at any frequency.
pub const PAPER_VELOCITY_M_PER_S: f64 = 0.2e-3;
/// The band that the profile `paper` is meant for, Hz.
pub const PAPER_BAND_HZ: [f64; 2] = [250.0, 350.0];
/// Distance of `press-flat` below `classic`, dB.
pub const PRESS_FLAT_DB: f64 = 25.0;
/// One g, m/s².
const STANDARD_GRAVITY: f64 = 9.80665;

/// Frequency in Hz, least perceptible acceleration in dB re 1 g peak.
const CLASSIC: [(f64, f64); 19] = [
    (4.0, -58.81),
    (10.0, -48.90),
    (20.0, -40.36),
    (30.0, -34.31),
    (40.0, -32.81),
    (50.0, -31.94),
    (60.0, -31.77),
    (70.0, -31.59),
    (80.0, -31.77),
    (90.0, -31.73),
    (100.0, -31.90),
    (124.42, -31.70),
    (150.0, -31.35),
    (179.16, -31.02),
    (200.0, -30.86),
    (215.0, -30.35),
    (250.0, -28.98),
    (300.0, -26.81),
    (400.0, -19.81),
];

/// A threshold over frequency.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Threshold {
    /// 0.2 mm/s peak at any frequency.
    Paper,
    /// The table above: a small passive contactor, 4 to 400 Hz.
    Classic,
    /// `Classic` − 25 dB: a finger pressed flat on the panel.
    PressFlat,
    /// A table of one's own.
    Table(ThresholdTable),
}

/// A threshold table read from a CSV file.
#[derive(Debug, Clone, PartialEq)]
pub struct ThresholdTable {
    /// The file that it was read from.
    pub file: PathBuf,
    /// Frequencies, Hz, strictly rising.
    pub frequency_hz: Vec<f64>,
    /// Least perceptible velocity at each, m/s peak, greater than 0.
    pub velocity_m_per_s: Vec<f64>,
}

impl Threshold {
    /// Names of the built-in profiles.
    pub const NAMES: [&'static str; 3] = ["paper", "classic", "press-flat"];

    /// The built-in profile of this name.
    pub fn built_in(name: &str) -> Option<Self> {
        match name {
            "paper" => Some(Self::Paper),
            "classic" => Some(Self::Classic),
            "press-flat" => Some(Self::PressFlat),
            _ => None,
        }
    }

    /// Name as in the scene; the file name of a table.
    pub fn name(&self) -> String {
        match self {
            Self::Paper => "paper".into(),
            Self::Classic => "classic".into(),
            Self::PressFlat => "press-flat".into(),
            Self::Table(table) => table
                .file
                .file_name()
                .unwrap_or(table.file.as_os_str())
                .to_string_lossy()
                .into_owned(),
        }
    }

    /// Least perceptible velocity at `frequency_hz`, m/s peak.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] outside the profile's frequencies.
    pub fn velocity_m_per_s(&self, frequency_hz: f64) -> Result<f64> {
        match self {
            Self::Paper => Ok(PAPER_VELOCITY_M_PER_S),
            Self::Classic => self.classic(frequency_hz),
            Self::PressFlat => Ok(self.classic(frequency_hz)? * 10f64.powf(-PRESS_FLAT_DB / 20.0)),
            Self::Table(table) => {
                let points = table
                    .frequency_hz
                    .iter()
                    .zip(&table.velocity_m_per_s)
                    .map(|(&f, &v)| (f, 20.0 * v.log10()));
                Ok(10f64.powf(self.level(&points.collect::<Vec<_>>(), frequency_hz)? / 20.0))
            }
        }
    }

    /// The finding on the profile at this frequency.
    pub fn finding(&self, frequency_hz: f64) -> Option<Finding> {
        let [low, high] = PAPER_BAND_HZ;
        (*self == Self::Paper && !(low..=high).contains(&frequency_hz)).then(|| {
            Finding::caution(
                "threshold-unknown-here",
                format!(
                    "threshold profile `paper` (0.2 mm/s) is stated for {low} to {high} Hz, not \
                     for {} Hz",
                    hertz(frequency_hz)
                ),
            )
            .help("profile `classic` covers 4 to 400 Hz")
        })
    }

    fn classic(&self, frequency_hz: f64) -> Result<f64> {
        let acceleration =
            STANDARD_GRAVITY * 10f64.powf(self.level(&CLASSIC, frequency_hz)? / 20.0);
        Ok(acceleration / (TAU * frequency_hz))
    }

    /// dB linear in log f.
    fn level(&self, points: &[(f64, f64)], frequency_hz: f64) -> Result<f64> {
        let known = |&(f, _): &(f64, f64)| f == frequency_hz;
        if let Some(&(_, level)) = points.iter().find(|point| known(point)) {
            return Ok(level);
        }
        let mut pairs = points.iter().zip(points.iter().skip(1));
        let Some((&(f0, level0), &(f1, level1))) =
            pairs.find(|(a, b)| a.0 <= frequency_hz && frequency_hz <= b.0)
        else {
            let (low, high) = (
                points.first().map_or(0.0, |p| p.0),
                points.last().map_or(0.0, |p| p.0),
            );
            return Err(Error::bad_data("no threshold known at the drive frequency")
                .field("frequency_hz")
                .found(format!("{frequency_hz} Hz"))
                .expected(format!("{low} to {high} Hz, which threshold profile `{}` \
                                   covers", self.name()))
                .help("choose a frequency inside, or give threshold.profile a CSV file that covers it"));
        };
        Ok(level0 + (level1 - level0) * (frequency_hz / f0).ln() / (f1 / f0).ln())
    }
}

impl ThresholdTable {
    /// Reads `frequency_hz,velocity_m_per_s` (peak), one pair a line; a header and lines
    /// with `#` may stand in it.
    ///
    /// # Errors
    /// No such file, text instead of numbers, a threshold of zero, frequencies that do
    /// not rise.
    pub fn read(file: &Path) -> Result<Self> {
        let text = read_text(file, "lines of frequency_hz,velocity_m_per_s")?;
        Self::parse(&text, file).map_err(|error| error.file(file))
    }

    /// [`Self::read`] on text; `file` is kept as its name.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(text: &str, file: &Path) -> Result<Self> {
        let mut table = Self {
            file: file.to_path_buf(),
            frequency_hz: Vec::new(),
            velocity_m_per_s: Vec::new(),
        };
        let lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(k, line)| (k as u64 + 1, line.trim()));
        let mut header_may_come = true;
        for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
            let is_header = header_may_come && line.starts_with(|c: char| c.is_alphabetic());
            header_may_come = false;
            if !is_header {
                table.push(line).map_err(|error| error.at_line(number))?;
            }
        }
        if table.frequency_hz.is_empty() {
            return Err(Error::bad_data("no threshold in the file")
                .found("no line of numbers")
                .expected("lines of frequency_hz,velocity_m_per_s"));
        }
        Ok(table)
    }

    fn push(&mut self, line: &str) -> Result<()> {
        let numbers: Option<Vec<f64>> = line
            .split(',')
            .map(|cell| cell.trim().parse().ok().filter(|n: &f64| n.is_finite()))
            .collect();
        let Some(&[frequency, velocity]) = numbers.as_deref() else {
            return Err(Error::bad_data("not a pair of numbers")
                .found(line)
                .expected("frequency_hz,velocity_m_per_s"));
        };
        if velocity <= 0.0 {
            return Err(Error::bad_data("a threshold must be greater than zero")
                .field("velocity_m_per_s")
                .found(velocity)
                .expected("m/s peak"));
        }
        if frequency <= self.frequency_hz.last().copied().unwrap_or(0.0) {
            return Err(Error::bad_data(
                "frequencies must be greater than zero and rise from line to line",
            )
            .field("frequency_hz")
            .found(frequency)
            .expected(format!(
                "more than {}",
                self.frequency_hz.last().copied().unwrap_or(0.0)
            )));
        }
        self.frequency_hz.push(frequency);
        self.velocity_m_per_s.push(velocity);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocities of the same source, mm/s, computed apart from this code.
    const PUBLISHED_MM_PER_S: [(f64, f64); 8] = [
        (4.0, 0.448),
        (30.0, 1.002),
        (100.0, 0.397),
        (150.0, 0.282),
        (215.0, 0.221),
        (250.0, 0.222),
        (300.0, 0.237),
        (400.0, 0.399),
    ];

    #[test]
    fn the_classic_table_gives_its_published_velocities() {
        for (frequency, mm_per_s) in PUBLISHED_MM_PER_S {
            let velocity = Threshold::Classic.velocity_m_per_s(frequency).unwrap() * 1e3;
            assert!(
                (velocity - mm_per_s).abs() < 0.0006,
                "{frequency} Hz: {velocity} mm/s"
            );
        }
    }

    #[test]
    fn between_two_entries_the_level_is_linear_in_log_f() {
        let middle = (300.0_f64 * 400.0).sqrt();
        let level = (-26.81 - 19.81) / 2.0;
        let expected = STANDARD_GRAVITY * 10f64.powf(level / 20.0) / (TAU * middle);
        assert!(
            (Threshold::Classic.velocity_m_per_s(middle).unwrap() / expected - 1.0).abs() < 1e-12
        );
    }

    #[test]
    fn press_flat_lies_25_db_below_classic() {
        let ratio = Threshold::Classic.velocity_m_per_s(250.0).unwrap()
            / Threshold::PressFlat.velocity_m_per_s(250.0).unwrap();
        assert!((20.0 * ratio.log10() - 25.0).abs() < 1e-12);
    }

    #[test]
    fn outside_the_table_no_threshold_is_known() {
        for frequency in [3.9, 400.1] {
            let error = Threshold::Classic
                .velocity_m_per_s(frequency)
                .unwrap_err()
                .to_string();
            assert!(
                error.contains("no threshold known") && error.contains("4 to 400 Hz"),
                "{error}"
            );
        }
    }

    #[test]
    fn the_paper_profile_warns_outside_its_band() {
        assert_eq!(Threshold::Paper.velocity_m_per_s(1000.0).unwrap(), 0.2e-3);
        assert!(
            Threshold::Paper.finding(249.0).is_some() && Threshold::Paper.finding(350.0).is_none()
        );
    }

    #[test]
    fn a_table_of_ones_own_is_read_and_interpolated() {
        let text = "\u{feff}frequency_hz, velocity_m_per_s\n# mine\n100, 1e-3\n\n400, 1e-5\r\n";
        let table = Threshold::Table(ThresholdTable::parse(text, Path::new("mine.csv")).unwrap());
        assert!((table.velocity_m_per_s(200.0).unwrap() / 1e-4 - 1.0).abs() < 1e-12);
        assert_eq!(table.velocity_m_per_s(400.0).unwrap(), 1e-5);
        assert!(table
            .velocity_m_per_s(401.0)
            .unwrap_err()
            .to_string()
            .contains("`mine.csv` covers"));
    }

    #[test]
    fn a_table_that_cannot_be_used_is_refused_with_its_line() {
        for (text, line, message) in [
            ("100,0\n", 1, "greater than zero"),
            ("f,v\n100,1e-3\n100,1e-3\n", 3, "rise from line to line"),
            ("100,1e-3\nabc,2\n", 2, "not a pair"),
            ("100;1e-3\n", 1, "not a pair"),
            ("100,nan\n", 1, "not a pair"),
        ] {
            let error = ThresholdTable::parse(text, Path::new("t.csv")).unwrap_err();
            assert_eq!(error.line, Some(line), "{error}");
            assert!(error.message.contains(message), "{error}");
        }
        assert!(ThresholdTable::parse("f,v\n", Path::new("t.csv")).is_err());
    }
}
