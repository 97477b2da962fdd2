//! Windows and excitations of the records that FRFs come from, and their names.

use crate::data::limits;
use crate::data::window::kernel::{WindowKernel, BLACKMAN, FLATTOP, HAMMING, HANN};
use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

/// Excitation and window of the records that FRFs were estimated from: both decide what
/// leaks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Window {
    /// No bias: stepped or periodic signals, local methods, simulated data. Nothing is
    /// corrected, and no bias is named.
    None,
    /// Blows and what else ends inside the record, the response to the end of it: damping
    /// has no bias, residues lose what is cut off.
    Transient,
    /// Continuous random excitation without a window.
    Rectangular,
    /// Continuous random excitation, sin²(πt/T).
    Hann,
    /// Continuous random excitation, 0.54 − 0.46 cos(2πt/T).
    Hamming,
    /// Continuous random excitation, 0.42 − 0.5 cos(2πt/T) + 0.08 cos(4πt/T).
    Blackman,
    /// Continuous random excitation, the flat top of ISO 18431-2.
    Flattop,
    /// Continuous random excitation, Kaiser's window.
    Kaiser {
        /// Its parameter β, 0 to 40.
        beta: f64,
    },
    /// Random excitation in the first part of each record alone, the response to its end.
    Burst {
        /// That part, above 0 to 1.
        part: f64,
    },
    /// The same with Hann's window over the whole of each record.
    HannBurst {
        /// Part of the record with noise, 0.05 to 1.
        part: f64,
    },
}

impl FromStr for Window {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, number) = match text.split_once(':') {
            Some((name, number)) => (name, number.parse::<f64>().ok().filter(|n| n.is_finite())),
            None => (text, None),
        };
        match (name, number) {
            ("kaiser", Some(beta)) if (0.0..=limits::BETA_MOST).contains(&beta) => {
                Ok(Self::Kaiser { beta })
            }
            ("burst", Some(part)) if part > 0.0 && part <= 1.0 => Ok(Self::Burst { part }),
            ("hann-burst", Some(part)) if limits::HANN_BURST_PARTS.contains(&part) => {
                Ok(Self::HannBurst { part })
            }
            _ => Self::NAMED
                .into_iter()
                .find(|window| window.to_string() == text)
                .ok_or_else(|| {
                    format!(
                        "`{text}` is no window that FRFs can have; write {}",
                        Self::WORDS
                    )
                }),
        }
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Transient => f.write_str("transient"),
            Self::Rectangular => f.write_str("rectangular"),
            Self::Hann => f.write_str("hann"),
            Self::Hamming => f.write_str("hamming"),
            Self::Blackman => f.write_str("blackman"),
            Self::Flattop => f.write_str("flattop"),
            Self::Kaiser { beta } => write!(f, "kaiser:{beta}"),
            Self::Burst { part } => write!(f, "burst:{part}"),
            Self::HannBurst { part } => write!(f, "hann-burst:{part}"),
        }
    }
}

impl Window {
    /// Windows without a parameter.
    const NAMED: [Self; 7] = [
        Self::None,
        Self::Transient,
        Self::Hann,
        Self::Hamming,
        Self::Blackman,
        Self::Flattop,
        Self::Rectangular,
    ];
    /// All names, for messages.
    pub const WORDS: &'static str = "none, transient, hann, hamming, blackman, flattop, \
                                     rectangular, kaiser:BETA (0 to 40), burst:PART (above 0 to 1) \
                                     or hann-burst:PART (0.05 to 1)";

    /// True for the windows of continuous random excitation.
    pub(crate) fn is_continuous(self) -> bool {
        !matches!(self, Self::None | Self::Transient) && self.part().is_none()
    }

    /// Part of each record that a burst takes; `None` for other excitations.
    pub(crate) fn part(self) -> Option<f64> {
        match self {
            Self::Burst { part } | Self::HannBurst { part } => Some(part),
            _ => None,
        }
    }

    /// Effect of the window on the columns of a fit; `None`: no effect.
    pub(crate) fn kernel(self) -> Option<WindowKernel> {
        Some(match self {
            Self::None => return None,
            Self::Transient => WindowKernel::Transient,
            Self::Burst { part } | Self::HannBurst { part } => {
                WindowKernel::burst(part, self.cosines())
            }
            Self::Kaiser { .. } => {
                let (values, harmonics) = limits::BY_VALUES;
                WindowKernel::of_values(&self.values(values), harmonics)
            }
            _ => WindowKernel::cosines(self.cosines()),
        })
    }

    /// Coefficients c_n, n ≥ 0, of Σ c_n e^{2πjnu}; that of the rectangular window for windows that are
    /// no such sums.
    fn cosines(self) -> &'static [f64] {
        match self {
            Self::Hann | Self::HannBurst { .. } => &HANN,
            Self::Hamming => &HAMMING,
            Self::Blackman => &BLACKMAN,
            Self::Flattop => &FLATTOP,
            _ => &[1.0],
        }
    }

    /// The window at the middles of `points` equal parts of a record.
    pub(crate) fn values(self, points: usize) -> Vec<f64> {
        let value = |k: usize| {
            let u = (k as f64 + 0.5) / points as f64;
            if let Self::Kaiser { beta } = self {
                return bessel_0(beta * (1.0 - (2.0 * u - 1.0).powi(2)).sqrt());
            }
            let term = |(n, c): (usize, &f64)| {
                let sides = if n == 0 { 1.0 } else { 2.0 };
                sides * c * (TAU * n as f64 * u).cos()
            };
            self.cosines().iter().enumerate().map(term).sum()
        };
        (0..points).map(value).collect()
    }
}

/// I₀(x), the modified Bessel function of the first kind: Σ_k (x²/4)^k/(k!)².
fn bessel_0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum, mut k) = (1.0, 1.0, 0.0);
    while term > f64::EPSILON * sum {
        k += 1.0;
        term *= quarter / (k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;

    #[test]
    fn windows_are_read_as_they_are_written() {
        for window in Window::NAMED.into_iter().chain([
            Window::Kaiser { beta: 8.6 },
            Window::Burst { part: 0.5 },
            Window::HannBurst { part: 0.6 },
        ]) {
            assert_eq!(window.to_string().parse(), Ok(window));
            assert!(Window::WORDS.contains(window.to_string().split(':').next().unwrap()));
        }
        for wrong in [
            "",
            "hanning",
            "kaiser",
            "kaiser:-1",
            "kaiser:nan",
            "burst:0",
            "burst:1.5",
            "hann-burst",
            "hann-burst:0.01",
        ] {
            let message = wrong.parse::<Window>().unwrap_err();
            assert!(message.contains("burst:PART"), "{message}");
        }
    }

    #[test]
    fn kaisers_window_without_a_taper_is_rectangular() {
        assert!((bessel_0(5.0) - 27.239_871_823_604_44).abs() < 1e-12);
        let z = Complex64::new(2.0, 3.0);
        let [kaiser, rectangular] = [Window::Kaiser { beta: 0.0 }, Window::Rectangular]
            .map(|window| window.kernel().unwrap().value_and_slope(z)[0]);
        // the series of a triangle converges slowly
        assert!(
            (kaiser - rectangular).norm() < 1e-3,
            "{kaiser} {rectangular}"
        );
    }
}
