//! Options that a user may set.

use crate::damping::window_kernel::{WindowKernel, BLACKMAN, FLATTOP, HAMMING, HANN};
use crate::data::limits;
use crate::tolerances as tol;
use chladni_frf::{Damping, ModalModel};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

/// Identification method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// The fast chain where its residual is white, the measured-data path where it is
    /// not.
    #[default]
    Auto,
    /// The fast chain with the order given (else the visible peaks): vector fitting,
    /// maximum likelihood, no order loop.
    Lean,
    /// Relaxed vector fitting alone (Gustavsen 2006).
    Vf,
    /// Least-squares complex frequency, common denominator (Van der Auweraer et al.
    /// 2001). Even frequency axis.
    Lscf,
    /// Poly-reference least-squares complex frequency (Guillaume et al. 2003). Even
    /// frequency axis, whole FRF matrix.
    Plscf,
    /// Set-valued adaptive Antoulas–Anderson in x = ω² (Lietaert et al. 2022).
    Aaa,
    /// Rational fraction polynomials, one denominator for all FRFs (Richardson & Formenti
    /// 1985), reweighted to the likeliest poles. [`RfpOptions`] says how far.
    Rfp,
    /// Another name of the same.
    Grfp,
    /// Peak picking with half-power bandwidths.
    Peak,
    /// Circle fit (Kennedy & Pancu 1947).
    Circle,
}

impl Method {
    /// All methods, in the order of the documentation.
    pub const ALL: [Self; 10] = [
        Self::Auto,
        Self::Lean,
        Self::Vf,
        Self::Lscf,
        Self::Plscf,
        Self::Aaa,
        Self::Rfp,
        Self::Grfp,
        Self::Peak,
        Self::Circle,
    ];
    /// True of rational fraction polynomials, which [`RfpOptions`] are for.
    pub fn is_fraction(self) -> bool {
        matches!(self, Self::Rfp | Self::Grfp)
    }
    /// Name on the command line and in result files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Lean => "lean",
            Self::Vf => "vf",
            Self::Lscf => "lscf",
            Self::Plscf => "plscf",
            Self::Aaa => "aaa",
            Self::Rfp => "rfp",
            Self::Grfp => "grfp",
            Self::Peak => "peak",
            Self::Circle => "circle",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for Method {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        named(&Self::ALL, Self::as_str, text, "method")
    }
}

/// The one of `all` whose name is `text`.
fn named<T: Copy>(
    all: &[T],
    name: fn(T) -> &'static str,
    text: &str,
    kind: &str,
) -> Result<T, String> {
    let found = all.iter().copied().find(|&one| name(one) == text);
    found.ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|&one| name(one)).collect();
        format!("`{text}` is no {kind}; write {}", names.join(", "))
    })
}

/// Ways of fitting the polynomials of `rfp`; each does what those before it do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum RfpWeight {
    /// The linear equation error of 1985.
    Linear,
    /// Reweighted by the denominator of the step before (Sanathanan & Koerner 1963).
    Sk,
    /// Instrumental-variable steps to the likeliest poles.
    #[default]
    Iv,
    /// Gauss–Newton steps to the same.
    Gn,
}

impl RfpWeight {
    /// All, in the order of the documentation.
    pub const ALL: [Self; 4] = [Self::Linear, Self::Sk, Self::Iv, Self::Gn];
    /// Name on the command line and in result files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Sk => "sk",
            Self::Iv => "iv",
            Self::Gn => "gn",
        }
    }
}

impl FromStr for RfpWeight {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        named(&Self::ALL, Self::as_str, text, "weight")
    }
}

/// Options of `rfp` alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RfpOptions {
    /// The way of fitting the polynomials.
    pub weight: RfpWeight,
    /// Number of bands; `None`: by the peaks that show.
    pub bands: Option<usize>,
    /// The form of 1982: each FRF by itself, linear, viscous; poles by agreement.
    pub local: bool,
}

/// Constraints on residues (several references, or real modes).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ShapeModel {
    /// The narrowest of the others that the data do not contradict.
    #[default]
    Auto,
    /// Every pair of response and reference has a residue of its own while poles are
    /// sought.
    Free,
    /// One complex shape for all references.
    Rank1,
    /// One real shape for all references.
    Real,
}

impl ShapeModel {
    /// All, in the order of the documentation.
    pub const ALL: [Self; 4] = [Self::Auto, Self::Free, Self::Rank1, Self::Real];
    /// Name on the command line and in result files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Free => "free",
            Self::Rank1 => "rank1",
            Self::Real => "real",
        }
    }
}

impl FromStr for ShapeModel {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        named(&Self::ALL, Self::as_str, text, "model of shapes")
    }
}

/// Effort spent on finding poles: it moves a fit along the front of speed and accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Columns of the count sketch, of the first pass over the data.
    pub sketch_columns: usize,
    /// Relaxed vector-fitting steps of the pole pool.
    pub pool_iterations: usize,
    /// Most passes over the data beyond the two.
    pub extra_passes: usize,
    /// Most steps of a final refinement to the maximum-likelihood poles.
    pub likelihood_steps: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            sketch_columns: limits::SKETCH_COLUMNS,
            pool_iterations: tol::POOL_ITERATIONS,
            extra_passes: limits::EXTRA_PASSES,
            likelihood_steps: tol::REFINE_FINE,
        }
    }
}

/// Options of a fit. `Default` is what the command line does without flags.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FitOptions {
    /// Band, Hz; `None`: all lines.
    pub band_hz: Option<[f64; 2]>,
    /// Number of modes in the band; `None`: decided by evidence.
    pub modes: Option<usize>,
    /// Damping law; `None`: decided by evidence.
    pub damping: Option<Damping>,
    /// Method.
    pub method: Method,
    /// Options of `rfp` and `grfp` alone.
    pub rfp: RfpOptions,
    /// Constraints on shapes while poles are refined (`auto` only).
    pub shapes: ShapeModel,
    /// Window of the records that the FRFs were averaged from; `None`: as the set says
    /// itself, else not known: nothing leaks, and the possible bias is named.
    pub window: Option<Window>,
    /// Decay of the exponential window that the responses were multiplied with (hammer
    /// tests), 1/s: e^{−αt}; `None`: as the set says itself.
    pub exponential_window_per_s: Option<f64>,
    /// Frequencies at which the user has seen a mode, Hz: a pole is fitted there with the
    /// others, whatever the evidence, and graded like them (`auto` only).
    pub added_hz: Vec<f64>,
    /// Seed of the random sketch and mixtures.
    pub seed: u64,
    /// Effort spent on finding poles.
    pub effort: Effort,
}

/// The user's knowledge of the modes before the fit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked<'a> {
    /// Number of modes in the band; `None`: decided by evidence.
    pub modes: Option<usize>,
    /// Frequencies of modes that were seen, Hz.
    pub added_hz: &'a [f64],
}

impl FitOptions {
    /// The options that a model was fitted with, as its file tells them, with modes at
    /// these frequencies (Hz) beside its own.
    pub fn adding_to(model: &ModalModel, added_hz: &[f64]) -> Self {
        let echo = &model.options;
        let text = |name: &str| echo.get(name).and_then(Value::as_str);
        let number = |name: &str| echo.get(name).and_then(Value::as_u64);
        let list = echo.get("added_hz").and_then(Value::as_array);
        let before = list.into_iter().flatten().filter_map(Value::as_f64);
        Self {
            band_hz: Some(model.band_hz),
            modes: number("modes").and_then(|modes| usize::try_from(modes).ok()),
            damping: match text("damping") {
                Some("structural") => Some(Damping::Structural),
                Some("viscous") => Some(Damping::Viscous),
                _ => None,
            },
            method: model.method.parse().unwrap_or_default(),
            shapes: text("shapes")
                .and_then(|name| name.parse().ok())
                .unwrap_or_default(),
            window: text("window").and_then(|name| name.parse().ok()),
            exponential_window_per_s: echo.get("exponential_window_per_s").and_then(Value::as_f64),
            rfp: RfpOptions {
                weight: text("rfp_weight")
                    .and_then(|name| name.parse().ok())
                    .unwrap_or_default(),
                bands: number("rfp_bands").and_then(|bands| usize::try_from(bands).ok()),
                local: echo.get("rfp_local").and_then(Value::as_bool) == Some(true),
            },
            added_hz: before.chain(added_hz.iter().copied()).collect(),
            seed: number("seed").unwrap_or_default(),
            ..Self::default()
        }
    }

    /// The user's knowledge of the modes.
    pub(crate) fn asked(&self) -> Asked<'_> {
        Asked {
            modes: self.modes,
            added_hz: &self.added_hz,
        }
    }
}

/// Excitation and window of the records that FRFs were estimated from: both decide what
/// leaks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Window {
    /// No bias: stepped or periodic signals, local methods, simulated data; nothing is
    /// done, and nothing said.
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
        }
    }
}

impl Window {
    /// Those without a number.
    const NAMED: [Self; 7] = [
        Self::None,
        Self::Transient,
        Self::Hann,
        Self::Hamming,
        Self::Blackman,
        Self::Flattop,
        Self::Rectangular,
    ];
    /// All, as they are written.
    pub const WORDS: &'static str = "none, transient, hann, hamming, blackman, flattop, \
                                     rectangular, kaiser:BETA (0 to 40) or burst:PART (above 0 to 1)";

    /// Its effect on the columns of a fit; `None`: nothing.
    pub(crate) fn kernel(self) -> Option<WindowKernel> {
        Some(match self {
            Self::None => return None,
            Self::Transient => WindowKernel::Transient,
            Self::Burst { part } => WindowKernel::Burst { part },
            Self::Kaiser { .. } => {
                let (values, harmonics) = limits::BY_VALUES;
                WindowKernel::of_values(&self.values(values), harmonics)
            }
            _ => WindowKernel::cosines(self.cosines()),
        })
    }

    /// Coefficients c_n of Σ c_n e^{2πjnu}, n ≥ 0; of other windows those of none.
    fn cosines(self) -> &'static [f64] {
        match self {
            Self::Hann => &HANN,
            Self::Hamming => &HAMMING,
            Self::Blackman => &BLACKMAN,
            Self::Flattop => &FLATTOP,
            _ => &[1.0],
        }
    }

    /// Factors on continuous noise at the middles of `points` equal parts of a record.
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
        for window in Window::NAMED
            .into_iter()
            .chain([Window::Kaiser { beta: 8.6 }, Window::Burst { part: 0.5 }])
        {
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
