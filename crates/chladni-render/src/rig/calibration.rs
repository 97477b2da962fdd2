//! The calibration file: what measured fields have taught of a rig, for the next scene.
//!
//! Gains of the channels and poles hold at every frequency. The mobility that fields
//! corrected holds at the frequency where they were measured; with it goes the covariance
//! of its rows.

use crate::operator::Operator;
use crate::tolerances;
use chladni_frf::{ComplexMatrix, Dof, Error, Finding, ReferenceUnit, Result, Source};
use chladni_text::{json_error, read_text};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Value of `format` in a calibration file.
pub const CALIBRATION_FORMAT: &str = "chladni.calibration";
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
    /// True where the channel moves nothing.
    pub fn is_dead(&self) -> bool {
        self.odd && self.re.hypot(self.im) <= tolerances::DEAD_GAIN
    }
}

/// A calibrated rig. Field by field the calibration file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Always [`CALIBRATION_FORMAT`].
    pub format: String,
    /// Version of the layout: 1.
    pub version: u32,
    /// Program and version.
    pub created_by: String,
    /// The files it was learned from; filled by whoever read them.
    pub source: Vec<Source>,
    /// Unit of the references, N or V.
    pub unit: ReferenceUnit,
    /// Number of measured fields, of all frequencies.
    pub fields: usize,
    /// A new scan of FRFs is due.
    pub scan_due: bool,
    /// The reason that it is due.
    pub scan_reason: Option<String>,
    /// Factor of each channel on its weight.
    pub gains: Vec<ChannelGain>,
    /// Channels that do not move the panel.
    pub dead: Vec<Dof>,
    /// Modes of the model as the fields tell them.
    pub modes: Vec<CalibratedMode>,
    /// The mobility at the frequencies where fields were measured.
    pub operators: Vec<CalibratedOperator>,
}

/// The pole of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
    pub mobility: ComplexMatrix,
    /// Covariance of its rows, mean of δhᴴδh.
    pub covariance: ComplexMatrix,
}

impl Calibration {
    /// Reads a calibration file.
    ///
    /// # Errors
    /// No such file, or what [`Self::parse`] finds.
    pub fn read(file: &Path) -> Result<Self> {
        let text = read_text(file, "a calibration, JSON")?;
        Self::parse(&text).map_err(|error| error.file(file))
    }

    /// Reads a calibration file's text.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with the line: no JSON, a missing field, another
    /// format, sizes that disagree.
    pub fn parse(text: &str) -> Result<Self> {
        const AGAIN: &str = "give a file that `chladni correct` wrote, or correct again";
        let calibration: Self = serde_json::from_str(text)
            .map_err(|error| json_error("not a calibration file", &error).help(AGAIN))?;
        calibration.checked().map_err(|error| error.help(AGAIN))
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
        for (k, gain) in self.gains.iter().enumerate() {
            if gain.std < 0.0 {
                return Err(Error::bad_data("a standard deviation below zero")
                    .field(format!("gains[{}].std", k + 1))
                    .found(gain.std)
                    .expected("0 or more"));
            }
        }
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

    /// The factor of a channel on its weight; 1 where none is known.
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

    /// The mobility that fields taught at a frequency.
    pub fn at(&self, frequency_hz: f64) -> Option<&CalibratedOperator> {
        let is_same =
            |hz: f64| (hz - frequency_hz).abs() <= tolerances::SAME_FREQUENCY * frequency_hz;
        self.operators
            .iter()
            .find(|known| is_same(known.frequency_hz))
    }

    /// Error that is left of the gains, rms; `None` where no gain is known.
    pub(crate) fn gain_error(&self) -> Option<f64> {
        let living =
            |gain: &&ChannelGain| !self.dead.iter().any(|dead| dead.same_axis(gain.reference));
        let squares: Vec<f64> = self
            .gains
            .iter()
            .filter(living)
            .map(|gain| gain.std.powi(2))
            .collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        (!squares.is_empty()).then(|| mean.sqrt().max(tolerances::CALIBRATED_DRIVE_ERROR))
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
