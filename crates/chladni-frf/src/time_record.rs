//! Time records: channels that were measured together.

use crate::{Dof, FrfKind};
use std::path::PathBuf;

/// The quantity that a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalUnit {
    /// Force, N.
    Force,
    /// Drive voltage, V.
    Volt,
    /// Displacement, m.
    Displacement,
    /// Velocity, m/s.
    Velocity,
    /// Acceleration, m/s².
    Acceleration,
    /// The file does not say.
    Unknown,
}

impl SignalUnit {
    /// As a user would call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Volt => "voltage",
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Unknown => "an unknown quantity",
        }
    }

    /// Kind of an FRF of this motion over a force or voltage.
    pub fn frf_kind(self) -> Option<FrfKind> {
        match self {
            Self::Displacement => Some(FrfKind::Receptance),
            Self::Velocity => Some(FrfKind::Mobility),
            Self::Acceleration => Some(FrfKind::Accelerance),
            _ => None,
        }
    }

    /// True for a force or voltage.
    pub fn is_drive(self) -> bool {
        matches!(self, Self::Force | Self::Volt)
    }
}

/// One signal of a run, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The DOF where it was measured.
    pub dof: Dof,
    /// The quantity that it measures.
    pub unit: SignalUnit,
    /// A force or voltage that excites.
    pub is_reference: bool,
    /// Samples.
    pub samples: Vec<f64>,
}

/// Channels of equal length that were measured together.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// File.
    pub file: PathBuf,
    /// Line of its first record in the file, counted from 1; 0 in other formats.
    pub line: u64,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Channels.
    pub channels: Vec<Channel>,
}

impl Run {
    /// Samples of each channel.
    pub fn samples(&self) -> usize {
        self.channels
            .first()
            .map_or(0, |channel| channel.samples.len())
    }
    /// Channels that excite.
    pub fn references(&self) -> impl Iterator<Item = &Channel> {
        self.channels.iter().filter(|channel| channel.is_reference)
    }
    /// Channels that answer. Beside channels of motion, forces and voltages do not.
    pub fn responses(&self) -> impl Iterator<Item = &Channel> {
        let moves = self.moves();
        self.channels
            .iter()
            .filter(move |channel| !(channel.is_reference || moves && channel.unit.is_drive()))
    }
    /// Channels that neither excite nor answer: forces and voltages that are no reference,
    /// beside channels of motion.
    pub fn idle(&self) -> impl Iterator<Item = &Channel> {
        let moves = self.moves();
        self.channels
            .iter()
            .filter(move |channel| moves && !channel.is_reference && channel.unit.is_drive())
    }
    /// True where a channel that is no reference measures a motion, or a quantity that the file
    /// does not tell.
    fn moves(&self) -> bool {
        let mut channels = self.channels.iter();
        channels.any(|channel| !channel.is_reference && !channel.unit.is_drive())
    }
}
