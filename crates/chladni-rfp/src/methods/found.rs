//! Poles of one method, and what it says of them.

use crate::damping::law::CLASSIC;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::methods::equation_error::Root;
use crate::methods::survey::{Compressed, Survey};
use crate::poles::estimate::fewer_modes;
use chladni_frf::{Damping, Finding};
use num_complex::Complex64;

/// The poles that a method found.
#[derive(Debug, Clone)]
pub(crate) struct MethodPoles {
    /// s/ω_max, upper half plane, Re s < 0; those outside the band represent out-of-band modes.
    pub poles: Vec<Complex64>,
    /// One sigma of |s|/ω_max and of η per pole where the method knows its own scatter.
    pub deviation: Option<Vec<[f64; 2]>>,
    /// Damping law of the result where none was asked for and the data do not tell.
    pub law: Damping,
    /// Warnings to the user.
    pub warnings: Vec<Finding>,
    /// The way in which they were found, in words.
    pub how: &'static str,
    /// Poles by order, where the method looks at several.
    pub stabilization: Option<Stabilization>,
}

impl From<LocalPoles> for MethodPoles {
    fn from(found: LocalPoles) -> Self {
        Self {
            poles: found.poles,
            deviation: Some(found.deviation),
            law: CLASSIC,
            warnings: found.warnings,
            how: "linear equation error in orthogonal polynomials",
            stabilization: None,
        }
    }
}

/// The poles of fits to single FRFs (`local`).
#[derive(Debug, Clone, Default)]
pub(crate) struct LocalPoles {
    /// s/ω_max, viscous, upper half plane, Re s < 0, rising in frequency.
    pub poles: Vec<Complex64>,
    /// One sigma of |s|/ω_max and of η = 2ζ per pole: scatter, not the method's bias.
    pub deviation: Vec<[f64; 2]>,
    /// Warnings to the user.
    pub warnings: Vec<Finding>,
}

impl LocalPoles {
    /// Sorts out of `modes` what the user asked for: the most certain ones, all if no
    /// number was given.
    pub(crate) fn with_modes(mut self, mut modes: Vec<Root>, asked: Option<usize>) -> Self {
        modes.sort_by(|a, b| a.uncertainty().total_cmp(&b.uncertainty()));
        modes.truncate(asked.unwrap_or(usize::MAX));
        modes.sort_by(|a, b| a.s.im.total_cmp(&b.s.im));
        if let Some(asked) = asked.filter(|asked| *asked > modes.len()) {
            self.warnings.push(fewer_modes(
                asked,
                modes.len(),
                ": no further damped pole in the band is certain enough",
            ));
        }
        self.poles = modes.iter().map(|root| root.s).collect();
        self.deviation = modes.iter().map(|root| root.deviation).collect();
        self
    }
}

/// A method: poles from the two passes over the data.
pub(crate) type Finder = fn(&Survey, &Compressed, &FitOptions) -> Result<MethodPoles, FitError>;

/// Comparison of a pole with those of the order before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stability {
    /// No pole of the order before is near.
    New,
    /// One has nearly the same natural frequency, but another damping.
    Frequency,
    /// Frequency and damping are those of the order before.
    Stable,
}

/// A damped pole (Re s < 0) of one order.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OrderPole {
    /// Order of the denominator.
    pub order: usize,
    /// |s|/2π.
    pub frequency_hz: f64,
    /// −Re s/|s|.
    pub damping_ratio: f64,
    /// Compared with the order before.
    pub stability: Stability,
}

/// Data of a stabilization diagram.
#[derive(Debug, Clone, PartialEq, Default)]
#[must_use]
#[non_exhaustive]
pub struct Stabilization {
    /// Orders, rising.
    pub orders: Vec<usize>,
    /// Poles by order, then by frequency.
    pub poles: Vec<OrderPole>,
}

/// The finding where most poles of a band gain energy; `label` ends with a colon and a
/// blank, or is empty.
pub(crate) fn negative_damping(label: &str, negative: usize, all: usize) -> Finding {
    Finding::caution(
        "negative-damping",
        format!(
            "{label}{negative} of {all} poles in the band have negative damping; the data may \
             follow e^(-jwt), or hold no mode"
        ),
    )
    .value("poles_negative", negative as f64)
    .value("poles", all as f64)
    .help("read the data with the other time sign, if they follow e^(-jwt)")
}
