//! A possible fault of the rig.

use crate::scene::plane::Position;
use chladni_frf::Dof;
use serde::{Deserialize, Serialize};

/// A cause, where it sits, how large it is, and what speaks for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hypothesis {
    /// `nothing`, `gain`, `dead`, `reversed`, `channel`, `channels`, `mode`, `modes`, `load`
    /// or `unexplained`.
    pub kind: String,
    /// The channel, the mode's natural frequency in Hz, or the place in m.
    pub place: Option<Place>,
    /// Size, real and imaginary part: gain error of a channel or of all, relative shift of
    /// natural frequencies, impedance of a load in N·s/m, unexplained part of the field.
    pub value: Option<[f64; 2]>,
    /// Standard deviation of the size.
    pub std: Option<f64>,
    /// ln of the evidence over that of `nothing`.
    pub ln_evidence: f64,
}

/// The place of a cause.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Place {
    /// A channel.
    Channel(Dof),
    /// Natural frequency of a mode, Hz.
    Mode(f64),
    /// A place on the panel, m.
    Point(Position),
}
