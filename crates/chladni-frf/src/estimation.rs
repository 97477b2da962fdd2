//! How a set of FRFs was estimated from time records.

use std::fmt;
use std::str::FromStr;

/// Estimator of FRFs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// Averaged blocks, noise at the responses: least squares, biased low by noise at the
    /// references.
    H1,
    /// Averaged blocks, noise at the references: biased high by noise at the responses;
    /// one reference at a time.
    H2,
    /// Averaged blocks, noise at both in proportion to their power: total least squares.
    Hv,
    /// Local polynomial method on the transform of the whole record, noise at the
    /// responses.
    Lpm,
    /// Local rational method on the transform of the whole record, noise at the responses.
    Lrm,
}

impl Estimator {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::H1, Self::H2, Self::Hv, Self::Lpm, Self::Lrm];

    /// As on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::H1 => "h1",
            Self::H2 => "h2",
            Self::Hv => "hv",
            Self::Lpm => "lpm",
            Self::Lrm => "lrm",
        }
    }

    /// True where each value is fitted to lines of the whole record instead of averaged
    /// over blocks.
    pub fn is_local(self) -> bool {
        matches!(self, Self::Lpm | Self::Lrm)
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Estimator {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|estimator| estimator.name() == text)
            .ok_or_else(|| "unknown estimator: h1, h2, hv, lpm or lrm".to_owned())
    }
}

/// Factor of a block before its transform, references and responses alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlockWindow {
    /// Nothing: transients that die inside the block, periodic excitation.
    Rectangular,
    /// sin²(πt/T): continuous random excitation.
    Hann,
    /// e^{−αt}: hammer tests whose response does not die inside the block. It adds α to
    /// every decay.
    Exponential {
        /// α, 1/s.
        rate_per_s: f64,
    },
}

impl BlockWindow {
    /// As on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rectangular => "rectangular",
            Self::Hann => "hann",
            Self::Exponential { .. } => "exponential",
        }
    }

    /// The window of this name; `rate_per_s` is α of an exponential one.
    pub fn named(name: &str, rate_per_s: Option<f64>) -> Option<Self> {
        match (name, rate_per_s) {
            ("rectangular", None) => Some(Self::Rectangular),
            ("hann", None) => Some(Self::Hann),
            ("exponential", Some(rate_per_s)) if rate_per_s.is_finite() && rate_per_s >= 0.0 => {
                Some(Self::Exponential { rate_per_s })
            }
            _ => None,
        }
    }

    /// α of an exponential window, 1/s.
    pub fn rate_per_s(self) -> Option<f64> {
        match self {
            Self::Exponential { rate_per_s } => Some(rate_per_s),
            _ => None,
        }
    }
}

/// What was done to time records to make FRFs of them. The variance of each value stands
/// beside the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimation {
    /// Estimator.
    pub estimator: Estimator,
    /// Window of each block.
    pub window: BlockWindow,
    /// Length T of the transform, s: of a block, or of the shortest record of a local
    /// method.
    pub transform_s: f64,
    /// Part of T that holds samples, s; the rest are zeros.
    pub gate_s: f64,
    /// From the start of one block to that of the next, s.
    pub hop_s: f64,
    /// Blocks averaged, least and most of all FRFs; of a local method the records.
    pub averages: [usize; 2],
    /// Lines of the transform that one value stands for: 1 for averaged blocks.
    pub lines_per_value: usize,
}

impl Estimation {
    /// What is said of two sets at once; `None` where they differ in more than averages.
    pub fn joined(self, other: Self) -> Option<Self> {
        let averages = [
            self.averages[0].min(other.averages[0]),
            self.averages[1].max(other.averages[1]),
        ];
        let joined = Self { averages, ..self };
        (joined == Self { averages, ..other }).then_some(joined)
    }
}

impl fmt::Display for Estimation {
    /// In one line, short enough for those of universal files.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.estimator)?;
        if self.estimator.is_local() {
            write!(f, " lines={}", self.lines_per_value)?;
        } else {
            write!(f, " window={}", self.window.name())?;
            if let Some(rate_per_s) = self.window.rate_per_s() {
                write!(f, " alpha={rate_per_s:.6}/s")?;
            }
            write!(f, " hop={:.6}s", self.hop_s)?;
        }
        let [least, most] = self.averages;
        write!(f, " T={:.6}s n={least}", self.transform_s)?;
        if most != least {
            write!(f, "-{most}")?;
        }
        Ok(())
    }
}
