//! Estimation of a set of FRFs from time records.

use crate::limits::DECIMALS;
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

/// Course of the force over a block: with the window it decides what leaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Forcing {
    /// Random from before the block to after it.
    Continuous,
    /// Random in the first part of the block, then silent.
    Burst {
        /// That part, above 0 to 1.
        part: f64,
    },
    /// Blows, sweeps and what else is silent at the end of the block.
    Transient,
    /// The same in every block, and before them.
    Periodic,
}

impl Forcing {
    /// As in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Continuous => "continuous",
            Self::Burst { .. } => "burst",
            Self::Transient => "transient",
            Self::Periodic => "periodic",
        }
    }

    /// The course of this name; `part` is that of a burst.
    pub fn named(name: &str, part: Option<f64>) -> Option<Self> {
        match (name, part) {
            ("continuous", None) => Some(Self::Continuous),
            ("transient", None) => Some(Self::Transient),
            ("periodic", None) => Some(Self::Periodic),
            ("burst", Some(part)) if part > 0.0 && part <= 1.0 => Some(Self::Burst { part }),
            _ => None,
        }
    }

    /// Part of the block with noise, of a burst.
    pub fn part(self) -> Option<f64> {
        match self {
            Self::Burst { part } => Some(part),
            _ => None,
        }
    }
}

/// The processing of time records into FRFs. The variance of each value stands beside the
/// values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimation {
    /// Estimator.
    pub estimator: Estimator,
    /// Window of each block.
    pub window: BlockWindow,
    /// Course of the force, where it is known; with a local estimator only one that it cannot
    /// bear.
    pub forcing: Option<Forcing>,
    /// Length T of the transform, s: of a block, or of the shortest record of a local
    /// method.
    pub transform_s: f64,
    /// Part of T that holds samples, s; the rest are zeros.
    pub gate_s: f64,
    /// From the start of one block to that of the next, s.
    pub hop_s: f64,
    /// Blocks averaged, least and most of all FRFs; of a local method the records.
    pub averages: [usize; 2],
    /// Lines of the transform that one value is fitted to: 1 for averaged blocks.
    pub lines_per_value: usize,
}

impl Estimation {
    /// Decay that an exponential window added to every pole, 1/s; `None` where there was none, or
    /// the force is not known. Under noise that goes on more than that is added (theory.md, eq. F4).
    pub fn added_decay_per_s(&self) -> Option<f64> {
        let moved = self.forcing? != Forcing::Continuous;
        self.window.rate_per_s().filter(|_| moved)
    }

    /// True for blows, or sweeps, under a Hann window: it weighs early and late parts of a
    /// response unlike, broadens every line and sets others at 1/`gate_s` beside it.
    pub fn hann_on_blows(&self) -> bool {
        self.forcing == Some(Forcing::Transient) && self.window == BlockWindow::Hann
    }

    /// True for local fits to a force whose neighbouring lines are alike, or that repeats: leakage
    /// cannot be told from the response.
    pub fn local_on_smooth_force(&self) -> bool {
        let unsuited = matches!(self.forcing, Some(Forcing::Transient | Forcing::Periodic));
        self.estimator.is_local() && unsuited
    }

    /// The estimation of two sets at once; `None` where they differ in more than
    /// averages. Of local estimators a force that does not suit them stands for both.
    pub fn joined(self, other: Self) -> Option<Self> {
        let forcing = match self.estimator.is_local() {
            true => self.forcing.or(other.forcing),
            false => self.forcing,
        };
        let other = match other.estimator.is_local() {
            true => Self { forcing, ..other },
            false => other,
        };
        let averages = [
            self.averages[0].min(other.averages[0]),
            self.averages[1].max(other.averages[1]),
        ];
        let joined = Self {
            averages,
            forcing,
            ..self
        };
        (joined == Self { averages, ..other }).then_some(joined)
    }
}

/// Rounded to [`DECIMALS`].
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powi(DECIMALS);
    (value * unit).round() / unit
}

impl fmt::Display for Estimation {
    /// In one line, short enough for those of universal files.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.estimator)?;
        if self.estimator.is_local() {
            write!(f, " lines={}", self.lines_per_value)?;
        } else {
            write!(f, " win={}", self.window.name())?;
            if let Some(rate_per_s) = self.window.rate_per_s() {
                write!(f, " a={}/s", rounded(rate_per_s))?;
            }
            write!(f, " hop={}s", rounded(self.hop_s))?;
        }
        write!(f, " T={}s", rounded(self.transform_s))?;
        if self.gate_s != self.transform_s {
            write!(f, " gate={}s", rounded(self.gate_s))?;
        }
        let [least, most] = self.averages;
        write!(f, " n={least}")?;
        if most != least {
            write!(f, "-{most}")?;
        }
        match self.forcing {
            Some(Forcing::Burst { part }) => write!(f, " force=burst:{:.3}", part),
            Some(forcing) => write!(f, " force={}", forcing.name()),
            None => Ok(()),
        }
    }
}

impl FromStr for Estimation {
    type Err = String;

    /// Reads the line back, times and rates to six decimals.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` does not say how FRFs were estimated");
        let mut words = text.split_whitespace();
        let estimator: Estimator = words.next().ok_or_else(wrong)?.parse()?;
        let said = |name: &str| {
            let of = |word: &str| Some(word.strip_prefix(name)?.strip_prefix('=')?.to_owned());
            text.split_whitespace().find_map(of)
        };
        let number = |name: &str, unit: &str| -> Option<f64> {
            let value: f64 = said(name)?.strip_suffix(unit)?.parse().ok()?;
            (value.is_finite() && value > 0.0).then_some(value)
        };
        let transform_s = number("T", "s").ok_or_else(wrong)?;
        let averages = said("n").ok_or_else(wrong)?;
        let (least, most) = averages.split_once('-').unwrap_or((&averages, &averages));
        let count = |text: &str| text.parse::<usize>().map_err(|_| wrong());
        let local = estimator.is_local();
        let window = match said("win") {
            Some(name) => BlockWindow::named(&name, number("a", "/s")).ok_or_else(wrong)?,
            None if local => BlockWindow::Rectangular,
            None => return Err(wrong()),
        };
        let forcing = match said("force") {
            Some(words) => {
                let (name, part) = words.split_once(':').unwrap_or((&words, ""));
                Some(Forcing::named(name, part.parse().ok()).ok_or_else(wrong)?)
            }
            None => None,
        };
        Ok(Self {
            estimator,
            window,
            forcing,
            transform_s,
            gate_s: number("gate", "s").unwrap_or(transform_s),
            hop_s: number("hop", "s").unwrap_or(transform_s),
            averages: [count(least)?, count(most)?],
            lines_per_value: match said("lines") {
                Some(lines) => count(&lines)?,
                None => 1,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_read_as_it_was_written() {
        let hann = Estimation {
            estimator: Estimator::H1,
            window: BlockWindow::Hann,
            forcing: Some(Forcing::Continuous),
            transform_s: 2.0,
            gate_s: 2.0,
            hop_s: 0.666667,
            averages: [44, 44],
            lines_per_value: 1,
        };
        let all = [
            hann,
            Estimation {
                window: BlockWindow::Exponential { rate_per_s: 3.7 },
                forcing: Some(Forcing::Transient),
                gate_s: 1.5,
                averages: [3, 12],
                ..hann
            },
            Estimation {
                window: BlockWindow::Rectangular,
                forcing: Some(Forcing::Burst { part: 0.625 }),
                ..hann
            },
            Estimation {
                estimator: Estimator::Lrm,
                window: BlockWindow::Rectangular,
                forcing: None,
                hop_s: 2.0,
                lines_per_value: 13,
                ..hann
            },
        ];
        for made in all {
            let words = made.to_string();
            assert!(words.len() <= 80, "{words}");
            assert_eq!(words.parse(), Ok(made));
        }
        for wrong in [
            "",
            "h1",
            "FRF 1",
            "h1 win=hann T=0s n=4",
            "h1 win=hann T=2s n=x",
            "h1 win=hann T=2s n=4 force=burst:7",
            "h1 win=exponential T=2s n=4",
        ] {
            assert!(wrong.parse::<Estimation>().is_err(), "{wrong}");
        }
    }
}
