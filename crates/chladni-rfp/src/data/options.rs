//! Options that a user may set.

use crate::data::limits;
use crate::data::window::kinds::Window;
use crate::tolerances as tol;
use chladni_frf::{Damping, ModalModel};
use serde_json::Value;
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
    /// The fast chain with the order given (else the visible peaks): vector fitting, maximum
    /// likelihood. Poles are exchanged or removed, but the order is not searched for.
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
            likelihood_steps: tol::FINE.steps,
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

    /// The most modes that the band may have; `None`: as many as the data show.
    pub(crate) fn most_modes(&self) -> Option<usize> {
        self.modes
            .map(|modes| modes.saturating_add(self.added_hz.len()))
    }
}
