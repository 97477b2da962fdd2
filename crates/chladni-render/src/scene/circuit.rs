//! Electrical limits of an actuator, as a limit of its voltage.
//!
//! A coil is R + jωL, a piezo 1/(jωC). At one frequency each limit is one of the voltage
//! (peaks): I ≤ I_max is |V| ≤ I_max·|Z|, and the apparent power |V|²/(2|Z|) ≤ S_max is
//! |V| ≤ √(2·S_max·|Z|).

use chladni_frf::{Error, Result};
use chladni_text::toml_reader::Table;
use std::f64::consts::TAU;

/// Impedance of each actuator, and what its amplifier can give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circuit {
    /// The impedance.
    pub load: Load,
    /// Largest current, A peak; infinite where there is none.
    pub max_current_a: f64,
    /// Largest apparent power, VA; infinite where there is none.
    pub max_apparent_power_va: f64,
}

/// Electrical load of an amplifier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// A coil: resistance and inductance in series.
    Coil {
        /// Ω.
        resistance_ohm: f64,
        /// H.
        inductance_h: f64,
    },
    /// A piezo.
    Piezo {
        /// F.
        capacitance_f: f64,
    },
}

impl Load {
    /// |Z|, Ω.
    pub fn impedance_ohm(self, frequency_hz: f64) -> f64 {
        let omega = TAU * frequency_hz;
        match self {
            Self::Coil {
                resistance_ohm,
                inductance_h,
            } => resistance_ohm.hypot(omega * inductance_h),
            Self::Piezo { capacitance_f } => (omega * capacitance_f).recip(),
        }
    }
}

impl Circuit {
    /// The largest voltage that both limits allow, V peak.
    pub fn max_voltage_v(&self, frequency_hz: f64) -> f64 {
        let ohm = self.load.impedance_ohm(frequency_hz);
        let of_power = (2.0 * self.max_apparent_power_va * ohm).sqrt();
        (self.max_current_a * ohm).min(of_power)
    }

    /// The circuit of `[actuators]`; `None` where it names neither current nor power.
    ///
    /// # Errors
    /// A limit without an impedance, coil and piezo at once.
    pub(super) fn read(table: &Table) -> Result<Option<Self>> {
        let number = |key: &str| table.get(key).map(|value| value.positive()).transpose();
        let [current, power] = [number("max_current_a")?, number("max_apparent_power_va")?];
        let [resistance, inductance] = [number("resistance_ohm")?, number("inductance_h")?];
        let load = match (resistance, inductance, number("capacitance_f")?) {
            (None, None, None) => None,
            (resistance, inductance, None) => Some(Load::Coil {
                resistance_ohm: resistance.unwrap_or(0.0),
                inductance_h: inductance.unwrap_or(0.0),
            }),
            (None, None, Some(capacitance_f)) => Some(Load::Piezo { capacitance_f }),
            _ => {
                return Err(
                    Error::bad_data("an actuator is a coil or a piezo, not both")
                        .field("actuators.capacitance_f")
                        .found("capacitance_f beside resistance_ohm or inductance_h")
                        .expected("resistance_ohm and inductance_h, or capacitance_f"),
                )
            }
        };
        let limited = current.is_some() || power.is_some();
        match load {
            _ if !limited => Ok(None),
            Some(load) => Ok(Some(Self {
                load,
                max_current_a: current.unwrap_or(f64::INFINITY),
                max_apparent_power_va: power.unwrap_or(f64::INFINITY),
            })),
            None => Err(
                Error::bad_data("a limit of current or power needs the impedance")
                    .field("actuators")
                    .found("neither resistance_ohm and inductance_h nor capacitance_f")
                    .expected("those of a coil, or that of a piezo")
                    .help("read them off the data sheet, or measure them"),
            ),
        }
    }
}
