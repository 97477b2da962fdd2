//! The calibration file: what measured fields, a bench or data sheets tell of a rig, for the
//! next scene.
//!
//! Gains of the channels and poles hold at every frequency; a gain table says how the gain
//! of a channel goes over frequency, and both multiply. The mobility that fields
//! corrected holds at the frequency where they were measured; with it goes the covariance
//! of its rows.

use super::gain_file;
use super::gain_table::{too_large, GainTable};
use super::known_keys;
use crate::panel::operator::Operator;
use crate::scene::other_kind::{self, parse_as};
use crate::tolerances;
use chladni_frf::{ComplexMatrix, Dof, Error, Finding, ReferenceUnit, Result, Source, CREATED_BY};
use chladni_text::read_text;
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Value of `format` in a calibration file.
pub const CALIBRATION_FORMAT: &str = other_kind::CALIBRATION;
/// Version of the layout.
pub const CALIBRATION_VERSION: u32 = 1;

/// A way to correct the operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Estimator {
    /// Gains and poles, then an operator update on what they leave.
    Structured,
    /// The operator update alone.
    Kalman,
}

impl Estimator {
    /// Name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Structured => "structured",
            Self::Kalman => "kalman",
        }
    }
}

/// The gain of one channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelGain {
    /// Reference DOF.
    pub reference: Dof,
    /// Real part of the factor on its weight.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Standard deviation of the factor.
    pub std: f64,
    /// True where it lies beyond what the other channels show.
    pub odd: bool,
}

impl ChannelGain {
    /// Amount of the factor.
    fn size(&self) -> f64 {
        self.re.hypot(self.im)
    }

    /// True where the channel moves nothing beside others whose factors have the size `level`,
    /// and that is known.
    pub(crate) fn is_dead_beside(&self, level: f64) -> bool {
        let size = self.size();
        let known = self.std <= level * tolerances::DEAD_GAIN_STD;
        self.odd && known && size <= level * tolerances::DEAD_GAIN
    }
}

/// A calibrated rig. Field by field the calibration file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Always [`CALIBRATION_FORMAT`].
    pub format: String,
    /// Version of the layout: 1.
    pub version: u32,
    /// Program and version; empty where a person wrote it.
    #[serde(default)]
    pub created_by: String,
    /// The files it was learned from; filled by whoever read them.
    #[serde(default, deserialize_with = "known_keys::sources")]
    pub source: Vec<Source>,
    /// Unit of the references, N or V; `None`: any, the factors have none.
    #[serde(default)]
    pub unit: Option<ReferenceUnit>,
    /// Number of measured fields, of all frequencies.
    #[serde(default)]
    pub fields: usize,
    /// A new scan of FRFs is due.
    #[serde(default)]
    pub scan_due: bool,
    /// The reason that it is due.
    #[serde(default)]
    pub scan_reason: Option<String>,
    /// Factor of each channel on its weight, at every frequency.
    #[serde(default)]
    pub gains: Vec<ChannelGain>,
    /// Gains over frequency; what fields taught comes on top.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gain_tables: Vec<GainTable>,
    /// Channels that do not move the panel.
    #[serde(default)]
    pub dead: Vec<Dof>,
    /// Modes of the model as the fields tell them.
    #[serde(default)]
    pub modes: Vec<CalibratedMode>,
    /// The mobility at the frequencies where fields were measured.
    #[serde(default)]
    pub operators: Vec<CalibratedOperator>,
}

/// The pole of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedMode {
    /// Natural frequency in the model, Hz: names the mode.
    pub model_hz: f64,
    /// Natural frequency on the rig, Hz.
    pub frequency_hz: f64,
    /// Loss factor on the rig.
    pub loss_factor: f64,
    /// Standard deviation of the relative shift.
    pub std: f64,
}

/// The mobility at one frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedOperator {
    /// Hz.
    pub frequency_hz: f64,
    /// Number of fields measured there.
    pub fields: usize,
    /// The estimator that made it.
    pub estimator: Estimator,
    /// Response DOFs, one per row.
    pub responses: Vec<Dof>,
    /// Reference DOFs, one per column.
    pub references: Vec<Dof>,
    /// Velocity along +Z per unit weight, (m/s)/N or (m/s)/V.
    #[serde(deserialize_with = "known_keys::matrix")]
    pub mobility: ComplexMatrix,
    /// Covariance of its rows, mean of δhᴴδh.
    #[serde(deserialize_with = "known_keys::matrix")]
    pub covariance: ComplexMatrix,
}

impl Calibration {
    /// Reads a calibration file.
    ///
    /// # Errors
    /// No such file, or what [`Self::parse`] finds.
    pub fn read(file: &Path) -> Result<Self> {
        let text = read_text(file, "a calibration, JSON or CSV")?;
        Self::parse(&text).map_err(|error| error.file(file))
    }

    /// Reads a calibration file's text, JSON or a table of gains as CSV.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with the line: no JSON, a missing or an unknown
    /// field, another format, sizes that disagree, gains that cannot be used.
    pub fn parse(text: &str) -> Result<Self> {
        const AGAIN: &str = "give a calibration file of Chladni, or a table of gains (CSV)";
        if !text
            .trim_start_matches('\u{feff}')
            .trim_start()
            .starts_with('{')
        {
            return Ok(Self::of_tables(gain_file::parse(text)?));
        }
        let kind = (CALIBRATION_FORMAT, CALIBRATION_VERSION);
        let calibration: Self = parse_as(text, kind, "not a calibration file", AGAIN)?;
        calibration.checked().map_err(|error| Error {
            help: error.help.or_else(|| Some(AGAIN.into())),
            ..error
        })
    }

    /// A calibration of gains alone.
    pub fn of_tables(gain_tables: Vec<GainTable>) -> Self {
        Self {
            format: CALIBRATION_FORMAT.into(),
            version: CALIBRATION_VERSION,
            created_by: CREATED_BY.into(),
            source: Vec::new(),
            unit: None,
            fields: 0,
            scan_due: false,
            scan_reason: None,
            gains: Vec::new(),
            gain_tables,
            dead: Vec::new(),
            modes: Vec::new(),
            operators: Vec::new(),
        }
    }

    /// The text of a calibration file.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Internal`] where a number is not finite: a bug.
    pub fn to_json(&self) -> Result<String> {
        let text = serde_json::to_string(self);
        text.map(|text| text + "\n")
            .map_err(|error| Error::new(chladni_frf::ErrorKind::Internal, error.to_string()))
    }

    fn checked(self) -> Result<Self> {
        if self.format != CALIBRATION_FORMAT || self.version != CALIBRATION_VERSION {
            return Err(
                Error::bad_data("not a calibration file that this version reads")
                    .field("format")
                    .found(format!("{} version {}", self.format, self.version))
                    .expected(format!(
                        "{CALIBRATION_FORMAT} version {CALIBRATION_VERSION}"
                    )),
            );
        }
        self.check_gains()?;
        for (k, mode) in self.modes.iter().enumerate() {
            let sound = mode.model_hz > 0.0 && mode.frequency_hz > 0.0 && mode.loss_factor >= 0.0;
            if !sound {
                return Err(Error::bad_data("no natural frequency and loss factor")
                    .field(format!("modes[{}]", k + 1))
                    .found(format!("{} Hz, {}", mode.frequency_hz, mode.loss_factor))
                    .expected("a frequency above 0 Hz and a loss factor of 0 or more"));
            }
        }
        for (k, operator) in self.operators.iter().enumerate() {
            let [rows, columns] = [operator.responses.len(), operator.references.len()];
            let sizes = [operator.mobility.0.dim(), operator.covariance.0.dim()];
            if sizes != [(rows, columns), (columns, columns)] {
                return Err(Error::bad_data("sizes disagree")
                    .field(format!("operators[{}]", k + 1))
                    .found(format!("mobility and covariance of {sizes:?} entries"))
                    .expected(format!("{rows} responses, {columns} references")));
            }
        }
        Ok(self)
    }

    /// Refuses gains that fields taught and that no calibration file may hold: products of those
    /// before and of what the fields tell now.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: a gain above [`tolerances::MOST_GAIN`].
    pub(super) fn check_learned(&self) -> Result<()> {
        let is_too_large = |gain: &&ChannelGain| {
            let size = gain.size();
            size.is_nan() || size > tolerances::MOST_GAIN
        };
        let Some(gain) = self.gains.iter().find(is_too_large) else {
            return Ok(());
        };
        let size = gain.size();
        Err(Error::bad_data("the fields tell a gain that no channel has")
            .field("gains")
            .found(format!(
                "a factor of {size:.3e} ({:+.1} dB), {}",
                20.0 * size.log10(),
                gain.reference
            ))
            .expected(format!(
                "at most {} dB, with that of a calibration before",
                tolerances::LEVEL_REFUSED_DB
            ))
            .help(
                "check the unit of the field (m/s, mm/s, um/s; peak) and the amplifiers; where a \
                 calibration before is of another rig, correct without it",
            ))
    }

    /// Checks gains and gain tables.
    fn check_gains(&self) -> Result<()> {
        for (k, gain) in self.gains.iter().enumerate() {
            if gain.std < 0.0 {
                return Err(Error::bad_data("a standard deviation below zero")
                    .field(format!("gains[{}].std", k + 1))
                    .found(gain.std)
                    .expected("0 or more"));
            }
            let size = gain.size();
            if size > tolerances::MOST_GAIN {
                let found = format!("a factor of {size:.3e}, {}", gain.reference);
                return Err(too_large(format!("gains[{}]", k + 1), found));
            }
            let is_same = |other: &ChannelGain| other.reference.same_axis(gain.reference);
            if self.gains[..k].iter().any(is_same) {
                return Err(Error::bad_data("a channel has two gains")
                    .field(format!("gains[{}].reference", k + 1))
                    .found(gain.reference)
                    .expected("one gain for each channel")
                    .help("leave one of them out"));
            }
        }
        for (k, table) in self.gain_tables.iter().enumerate() {
            let of_table = |error: Error| {
                let field = error.field.clone().unwrap_or_default();
                Error {
                    field: Some(format!("gain_tables[{}].{field}", k + 1)),
                    ..error
                }
            };
            table.check().map_err(of_table)?;
            let is_same = |other: &GainTable| match (other.reference, table.reference) {
                (Some(one), Some(other)) => one.same_axis(other),
                (one, other) => one == other,
            };
            if self.gain_tables[..k].iter().any(is_same) {
                return Err(Error::bad_data("a channel has two gain tables")
                    .field(format!("gain_tables[{}].reference", k + 1))
                    .found(table.channel())
                    .expected("one table for each channel"));
            }
        }
        Ok(())
    }

    /// The factor of a channel on its weight at every
    /// frequency, without its table; 1 where none is known.
    pub fn gain_of(&self, reference: Dof) -> Complex64 {
        if self.dead.iter().any(|dead| dead.same_axis(reference)) {
            return Complex64::ZERO;
        }
        let gain = self
            .gains
            .iter()
            .find(|gain| gain.reference.same_axis(reference));
        gain.map_or(Complex64::ONE, |gain| Complex64::new(gain.re, gain.im))
    }

    /// The table of a channel: its own, or that of every channel.
    fn table_of(&self, reference: Dof) -> Option<&GainTable> {
        let own = |table: &&GainTable| table.reference.is_some_and(|dof| dof.same_axis(reference));
        let every = |table: &&GainTable| table.reference.is_none();
        let tables = || self.gain_tables.iter();
        tables().find(own).or_else(|| tables().find(every))
    }

    /// The factor that the table of a channel says at a frequency; 1 where it has none.
    ///
    /// # Errors
    /// A frequency that the table does not cover.
    pub fn table_gain_of(&self, reference: Dof, frequency_hz: f64) -> Result<Complex64> {
        let table = self.table_of(reference);
        table.map_or(Ok(Complex64::ONE), |table| {
            table.at(frequency_hz).map(|gain| gain.factor)
        })
    }

    /// True where every gain table covers this frequency.
    pub(crate) fn covers(&self, frequency_hz: f64) -> bool {
        self.gain_tables
            .iter()
            .all(|table| table.at(frequency_hz).is_ok())
    }

    /// The mobility that fields taught at a frequency.
    pub fn at(&self, frequency_hz: f64) -> Option<&CalibratedOperator> {
        let is_same =
            |hz: f64| (hz - frequency_hz).abs() <= tolerances::SAME_FREQUENCY * frequency_hz;
        self.operators
            .iter()
            .find(|known| is_same(known.frequency_hz))
    }

    /// Error that is left of the gains at a frequency, rms over the living channels; `None`
    /// where it is not known of one of them.
    pub(crate) fn gain_error(&self, frequency_hz: f64) -> Option<f64> {
        let is_dead = |dof: &Dof| self.dead.iter().any(|dead| dead.same_axis(*dof));
        let mut channels: Vec<Option<Dof>> =
            self.gains.iter().map(|gain| Some(gain.reference)).collect();
        for table in &self.gain_tables {
            let known = |dof: &Option<Dof>| match (dof, table.reference) {
                (Some(one), Some(other)) => one.same_axis(other),
                // a table of every channel counts by itself where no channel is named
                (Some(_), None) => true,
                (one, other) => *one == other,
            };
            if !channels.iter().any(known) {
                channels.push(table.reference);
            }
        }
        let living = channels
            .into_iter()
            .filter(|dof| !dof.as_ref().is_some_and(is_dead));
        let squares: Vec<f64> = living
            .map(|dof| self.square_error(dof, frequency_hz))
            .collect::<Option<_>>()?;
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        (!squares.is_empty()).then(|| mean.sqrt().max(tolerances::CALIBRATED_DRIVE_ERROR))
    }

    /// Square of the relative error of a channel: of its gain, and of its table. Fields tell
    /// the error of the product where the table gives none.
    fn square_error(&self, reference: Option<Dof>, frequency_hz: f64) -> Option<f64> {
        let own = |gain: &&ChannelGain| reference.is_some_and(|dof| gain.reference.same_axis(dof));
        let of_gain = self.gains.iter().find(own).map(|gain| gain.std.powi(2));
        let table = match reference {
            Some(dof) => self.table_of(dof),
            None => self
                .gain_tables
                .iter()
                .find(|table| table.reference.is_none()),
        };
        let at = table.and_then(|table| table.at(frequency_hz).ok());
        let of_table = at.and_then(|gain| gain.std_relative).map(|std| std.powi(2));
        match (of_gain, of_table) {
            (None, None) => None,
            (one, other) => Some(one.unwrap_or(0.0) + other.unwrap_or(0.0)),
        }
    }

    /// The finding that a new scan is due.
    pub(crate) fn scan_finding(&self) -> Option<Finding> {
        self.scan_reason.as_deref().map(scan_due)
    }
}

impl CalibratedOperator {
    /// Covariance over the actuators of `operator`; `None` at another frequency, or where one
    /// of them is not known.
    pub(crate) fn covariance_of(&self, operator: &Operator) -> Option<Array2<Complex64>> {
        let apart = (self.frequency_hz - operator.frequency_hz).abs();
        if apart > tolerances::SAME_FREQUENCY * operator.frequency_hz {
            return None;
        }
        let place = |dof: &Dof| {
            self.references
                .iter()
                .position(|known| known.same_axis(*dof))
        };
        let references = operator.references.iter();
        let columns: Vec<usize> = references.map(place).collect::<Option<_>>()?;
        let some = self.covariance.0.select(Axis(0), &columns);
        Some(some.select(Axis(1), &columns))
    }
}

/// The finding that a new scan is due.
pub(crate) fn scan_due(reason: &str) -> Finding {
    let words = format!("a new scan of the FRFs is due: {reason}");
    Finding::caution("scan-due", words)
        .help("take away what lies on the panel, or measure the FRFs again")
}
