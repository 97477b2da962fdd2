//! Damping law: structural, viscous, or decided by evidence (theory.md, eq. 16–17).
//!
//! Both laws describe a single light resonance almost equally well: the wrong one shifts the frequency by η²/4 and the loss
//! factor by about 0.28η² (relative). The sums of squares decide where they differ by more than chance; otherwise the
//! question is undecidable on these data, and the answer says so.

use crate::order::POWERS;
use crate::prune::threshold;
use crate::refine::Refined;
use crate::tolerances as tol;
use crate::viscous::{from_structural, refine_viscous, ViscousFit};
use crate::work::Work;
use chladni_frf::Damping;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Part of the difference that decides, below which what a step takes off no longer matters: steps shrink from one to the next.
const LAW_SETTLED: f64 = 1e-2;

/// Poles of the chosen law with their covariance.
#[derive(Debug)]
pub(crate) struct Law {
    /// The law of the numbers below.
    pub damping: Damping,
    /// Viscous fit where it was made and chosen.
    pub viscous: Option<ViscousFit>,
    /// The viscous fit where free residues cannot decide.
    pub undecided: Option<ViscousFit>,
}

/// True where both laws can express the pole: Re λ > 0 (ζ < 0.71), stable. Others are background, and the viscous twin has
/// no need of what the structural law needed to mimic it.
pub(crate) fn expressible_pole(lambda: Complex64) -> bool {
    lambda.re > 0.0 && lambda.im > 0.0
}

/// Rise of the sum of squares that tells one law from the other: chance, for white noise of this variance.
pub(crate) fn chance(work: &Work, variance: f64) -> f64 {
    threshold(work.columns(), work.lines()) * variance
}

/// Fits the viscous twin where it is asked for or the evidence must decide: by a difference of more than `least_gain`, or
/// not at all for light damping where line shapes are no pure resonances: `heaviest_sure` is the largest loss factor that is
/// sure on measured data, `None` where the residual is white.
pub(crate) fn choose(
    work: &Work,
    refined: &Refined,
    least_gain: f64,
    heaviest_sure: Option<f64>,
    asked: Option<Damping>,
) -> Result<Law, LinalgError> {
    let structural = |undecided| Law { damping: Damping::Structural, viscous: None, undecided };
    if asked == Some(Damping::Structural) || refined.lambda.is_empty() {
        return Ok(structural(None));
    }
    if asked.is_none() && heaviest_sure.is_some_and(|loss| loss < tol::LAW_ALIKE) {
        return Ok(structural(None));
    }
    let start: Vec<Complex64> = refined.lambda.iter().copied().filter(|l| expressible_pole(*l)).map(from_structural).collect();
    let tolerance = if asked.is_some() { tol::FINE_STEP } else { tol::ROUGH_STEP };
    // a race is over once the steps left can no longer change who wins
    let structural_sse = refined.projection.sse;
    let decided = |sse: f64, drop: f64, left: usize| {
        asked.is_none() && (sse - drop * left as f64 > structural_sse + least_gain || drop < LAW_SETTLED * least_gain)
    };
    let fit = refine_viscous(work, &start, &POWERS, tol::REFINE_FINE, tolerance, decided)?;
    let gain = structural_sse - fit.sse;
    if asked == Some(Damping::Viscous) || gain > least_gain {
        return Ok(Law { damping: Damping::Viscous, viscous: Some(fit), undecided: None });
    }
    // poles that the viscous law cannot express make it poorer: a narrow loss proves nothing then
    let comparable = start.len() == refined.lambda.len();
    Ok(structural((gain > -least_gain || !comparable).then_some(fit)))
}

/// What is said where neither free residues nor common shapes decide.
pub(crate) const UNDECIDABLE: &str =
    "damping law undecidable: structural and viscous damping explain these data equally well; the numbers follow the \
    structural law (say --damping viscous for the other; frequencies differ by about η²/4)";
