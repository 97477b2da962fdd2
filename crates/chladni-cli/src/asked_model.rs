//! Constraints on the model: the arguments that `fit` and `block solve` share.

use chladni_frf::Damping;
use chladni_rfp::{FitOptions, ShapeModel};
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// The arguments. One that is left out is decided by evidence; without a decay no
/// exponential window is taken off.
#[derive(Debug, clap::Args)]
pub struct AskedModel {
    /// Number of modes in the band; auto: decided by evidence [default: auto]
    #[arg(long, value_name = "auto|N", value_parser = parse_modes, allow_negative_numbers = true)]
    pub modes: Option<ModeCount>,
    /// Damping law; auto: decided by evidence [default: auto]
    #[arg(long, value_name = "LAW", value_parser = PossibleValuesParser::new(["auto", "structural", "viscous"]))]
    pub damping: Option<String>,
    /// What shapes may be while poles are refined: every pair by itself (free), one shape
    /// for all references (rank1), one real shape (real); auto: the narrowest that the
    /// data do not contradict [default: auto]
    #[arg(long, value_name = "SHAPES", value_parser = PossibleValuesParser::new(ShapeModel::ALL.map(ShapeModel::as_str))
        .try_map(|name| name.parse::<ShapeModel>()))]
    pub shapes: Option<ShapeModel>,
    /// Decay α of the exponential window e^(-αt) on the responses of a hammer test, 1/s:
    /// taken off the poles
    #[arg(long, value_name = "1/S", value_parser = parse_decay)]
    pub exponential_window: Option<f64>,
}

impl AskedModel {
    /// Options of a fit with these constraints, the others at their defaults.
    pub fn options(&self) -> FitOptions {
        FitOptions {
            modes: self.modes.and_then(|count| count.0),
            damping: match self.damping.as_deref() {
                Some("structural") => Some(Damping::Structural),
                Some("viscous") => Some(Damping::Viscous),
                _ => None,
            },
            shapes: self.shapes.unwrap_or_default(),
            exponential_window_per_s: self.exponential_window,
            ..FitOptions::default()
        }
    }
}

/// `--modes`: a number, or none for `auto`.
#[derive(Debug, Clone, Copy)]
pub struct ModeCount(Option<usize>);

fn parse_modes(text: &str) -> Result<ModeCount, String> {
    match text {
        "auto" => Ok(ModeCount(None)),
        _ => match text.parse() {
            Ok(count) if (1..=10_000).contains(&count) => Ok(ModeCount(Some(count))),
            _ => Err("neither auto nor a number of modes from 1 to 10000".into()),
        },
    }
}

fn parse_decay(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(decay) if decay.is_finite() && decay > 0.0 => Ok(decay),
        _ => Err("no decay in 1/s such as 3.7 (α = ln(1/end value)/record length)".into()),
    }
}
