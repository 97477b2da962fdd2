//! The table `[actuators]`.

use super::beside::Beside;
use super::circuit::Circuit;
use super::keys::KEYS;
use crate::rig::calibration::Calibration;
use chladni_frf::{Dof, Result};
use chladni_text::toml_reader::{Table, Value};
use std::path::PathBuf;
use std::sync::Arc;

/// Force limit of each actuator, N peak, where the scene gives none.
pub const DEFAULT_MAX_FORCE_N: f64 = 0.1;

/// The actuators that may be used, and their limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuators {
    /// Reference DOFs that may be driven; `None`: all.
    pub only: Option<Vec<Dof>>,
    /// Force limit of each, N peak; `None`: not given, [`DEFAULT_MAX_FORCE_N`] holds.
    pub max_force_n: Option<f64>,
    /// Voltage limit of each, V peak, where the references are volts.
    pub max_voltage_v: Option<f64>,
    /// Limits of current and apparent power of each, where the references are volts.
    pub circuit: Option<Circuit>,
    /// Limit of √Σ|A_i|² over all actuators, N or V peak.
    pub max_effort: Option<f64>,
    /// Reference DOFs that do not move the panel, and are known not to.
    pub dead: Vec<Dof>,
    /// Knowledge of the rig from earlier fields.
    pub calibration: Option<Arc<Calibration>>,
    /// The file that says so.
    pub calibration_file: Option<PathBuf>,
}

impl Actuators {
    /// True where a limit is given, of whatever kind.
    pub(crate) fn names_limit(&self) -> bool {
        self.max_force_n.is_some()
            || self.max_voltage_v.is_some()
            || self.max_effort.is_some()
            || self.circuit.is_some()
    }
}

pub(super) fn read_actuators(table: &Table, beside: Beside) -> Result<Actuators> {
    table.only_keys(KEYS, "actuators")?;
    let limit = |key| {
        table
            .get(key)
            .map(|value: Value| value.positive())
            .transpose()
    };
    let calibration = table
        .get("calibration")
        .map(|value| calibration_file(&value, beside))
        .transpose()?;
    Ok(Actuators {
        only: table
            .get("use")
            .map(|value| read_use(&value))
            .transpose()?
            .flatten(),
        max_force_n: limit("max_force_n")?,
        max_voltage_v: limit("max_voltage_v")?,
        circuit: Circuit::read(table)?,
        max_effort: limit("max_effort")?,
        dead: table
            .get("dead")
            .map(|value| read_dofs(&value, "a list of reference DOFs like \"110:+Z\""))
            .transpose()?
            .unwrap_or_default(),
        calibration: calibration
            .as_deref()
            .map(|file| Calibration::read(file).map(Arc::new))
            .transpose()?,
        calibration_file: calibration,
    })
}

/// The calibration file that a scene names.
fn calibration_file(value: &Value, beside: Beside) -> Result<PathBuf> {
    let name = value.string()?;
    let Beside::Folder(folder) = beside else {
        return Err(value
            .error(
                "no file is looked for here",
                "a scene without a calibration",
            )
            .help("take the line out, or give the scene as a file"));
    };
    let file = folder.join(name);
    if !file.exists() {
        return Err(value
            .error(
                "no such file",
                "the path of a calibration, from the scene file's folder",
            )
            .help(
                "correct the path; give a calibration file of Chladni, or a table of gains (CSV)",
            ));
    }
    Ok(file)
}

fn read_dofs(list: &Value, expected: &str) -> Result<Vec<Dof>> {
    let entry = |entry: &Value| {
        entry
            .string()?
            .parse::<Dof>()
            .map_err(|reason| entry.error(&reason, expected))
    };
    list.list()?.iter().map(entry).collect()
}

fn read_use(value: &Value) -> Result<Option<Vec<Dof>>> {
    const EXPECTED: &str = "\"all\" or a list of reference DOFs like \"101:+Z\"";
    if value.is_string() {
        return if value.string()? == "all" {
            Ok(None)
        } else {
            Err(value.error("no list of actuators", EXPECTED))
        };
    }
    let only = read_dofs(value, EXPECTED)?;
    if only.is_empty() {
        return Err(value.error("no actuator is left", EXPECTED));
    }
    Ok(Some(only))
}
