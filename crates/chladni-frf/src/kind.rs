//! FRF kinds, units of the reference, and the time sign.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// The quantity measured per unit of the reference. Velocity per volt is
/// [`FrfKind::Mobility`] with [`ReferenceUnit::Volt`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrfKind {
    /// Displacement per force, α, m/N.
    Receptance,
    /// Velocity per force, jω·α, (m/s)/N.
    Mobility,
    /// Acceleration per force, −ω²·α, (m/s²)/N.
    Accelerance,
}

impl FrfKind {
    /// The factor that turns receptance into this kind at `omega` rad/s: 1, jω or −ω².
    pub fn from_receptance(self, omega: f64) -> Complex64 {
        match self {
            Self::Receptance => Complex64::new(1.0, 0.0),
            Self::Mobility => Complex64::new(0.0, omega),
            Self::Accelerance => Complex64::new(-omega * omega, 0.0),
        }
    }
    /// Power of ω in [`Self::from_receptance`]: 0, 1 or 2.
    pub fn omega_power(self) -> i32 {
        self as i32
    }
    /// SI unit per unit of the reference, as text: `m/s/N`.
    pub fn unit(self, reference: ReferenceUnit) -> String {
        let numerator = match self {
            Self::Receptance => "m",
            Self::Mobility => "m/s",
            Self::Accelerance => "m/s^2",
        };
        format!("{numerator}/{reference}")
    }
    /// Name as in files and on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Receptance => "receptance",
            Self::Mobility => "mobility",
            Self::Accelerance => "accelerance",
        }
    }
}

impl fmt::Display for FrfKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for FrfKind {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "receptance" => Ok(Self::Receptance),
            "mobility" => Ok(Self::Mobility),
            "accelerance" => Ok(Self::Accelerance),
            other => Err(format!(
                "`{other}` is no FRF kind; write receptance, mobility or accelerance"
            )),
        }
    }
}

/// Unit of the reference: a force, or the drive voltage of an actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Default)]
pub enum ReferenceUnit {
    /// Newton.
    #[default]
    #[serde(rename = "N")]
    Newton,
    /// Volt: shapes cannot be mass-scaled then.
    #[serde(rename = "V")]
    Volt,
}

impl fmt::Display for ReferenceUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Newton => "N",
            Self::Volt => "V",
        })
    }
}

/// Sign in e^{±jωt} of measured phasors; inside, always plus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum TimeSign {
    /// e^{+jωt}.
    #[default]
    Plus,
    /// e^{−jωt}: conjugate on reading.
    Minus,
}

impl FromStr for TimeSign {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "+" => Ok(Self::Plus),
            "-" => Ok(Self::Minus),
            other => Err(format!("`{other}` is no time sign; write + or -")),
        }
    }
}
