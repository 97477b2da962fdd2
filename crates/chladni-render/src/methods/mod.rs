//! The methods, one file each. All see the same [`Problem`] and return a drive; none knows files or flags.

pub(crate) mod contrast;
pub(crate) mod mls;
pub(crate) mod modal;
pub(crate) mod pressure_matching;

use crate::problem::Drive;
use chladni_frf::{Error, ErrorKind};
use std::fmt;
use std::str::FromStr;

/// How the weights are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Method {
    /// One regularised least-squares solution with one phase all over the hot zone: instant, and several points worse.
    PressureMatching,
    /// Least squares of magnitudes: the phase of the hot zone is free.
    #[default]
    Mls,
    /// The two-step inverse of the seed paper, by pseudo-inverses. A baseline: `methods/modal.rs` says why not to use it.
    Modal,
}

impl Method {
    /// All methods, in the order of their names' listing.
    pub const ALL: [Self; 3] = [Self::PressureMatching, Self::Mls, Self::Modal];

    /// Name as on the command line and in results.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PressureMatching => "pressure-matching",
            Self::Mls => "mls",
            Self::Modal => "modal",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for Method {
    type Err = Error;
    /// The names of [`Method::ALL`], and `default` and `fast`.
    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "default" => Ok(Self::default()),
            "fast" => Ok(Self::PressureMatching),
            _ => Self::ALL.into_iter().find(|method| method.as_str() == text).ok_or_else(|| {
                let known: Vec<&str> = ["default", "fast"].into_iter().chain(Self::ALL.map(Self::as_str)).collect();
                Error::new(ErrorKind::Usage, "no such rendering method").field("method").found(text).expected(known.join(", "))
            }),
        }
    }
}

/// A drive and what must be said about how it was found.
pub(crate) struct Solution {
    pub(crate) drive: Drive,
    pub(crate) warnings: Vec<String>,
}
