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

/// Poles of the chosen law with their covariance.
#[derive(Debug)]
pub(crate) struct Law {
    /// The law of the numbers below.
    pub damping: Damping,
    /// Viscous fit where it was made and chosen.
    pub viscous: Option<ViscousFit>,
    /// Warning where the data cannot decide.
    pub warning: Option<String>,
}

/// True where the viscous law can express the pole: stable and under-damped.
pub(crate) fn expressible_pole(lambda: Complex64) -> bool {
    let s = from_structural(lambda);
    s.re < 0.0 && s.im > 0.0 && -s.re < 0.99 * s.norm()
}

/// Rise of the sum of squares that tells one law from the other: chance, for white noise of this variance.
pub(crate) fn chance(work: &Work, variance: f64) -> f64 {
    threshold(work.columns(), work.lines()) * variance
}

/// Fits the viscous twin where it is asked for or the evidence must decide: by a difference of more than `least_gain`.
pub(crate) fn choose(work: &Work, refined: &Refined, least_gain: f64, asked: Option<Damping>) -> Result<Law, LinalgError> {
    let structural = Law { damping: Damping::Structural, viscous: None, warning: None };
    if asked == Some(Damping::Structural) || refined.lambda.is_empty() {
        return Ok(structural);
    }
    let start: Vec<Complex64> = refined.lambda.iter().copied().filter(|l| expressible_pole(*l)).map(from_structural).collect();
    let fit = refine_viscous(work, &start, &POWERS, tol::REFINE_FINE, if asked.is_some() { tol::FINE_STEP } else { tol::ROUGH_STEP })?;
    if asked == Some(Damping::Viscous) {
        return Ok(Law { damping: Damping::Viscous, viscous: Some(fit), warning: None });
    }
    // poles that the viscous law cannot express make it poorer: where it wins all the same, it wins
    let comparable = start.len() == refined.lambda.len();
    let gain = refined.projection.sse - fit.sse;
    if gain > least_gain {
        return Ok(Law { damping: Damping::Viscous, viscous: Some(fit), warning: None });
    }
    let warning = (gain > -least_gain || !comparable).then(|| {
        "damping law undecidable: structural and viscous damping explain these data equally well; the numbers follow the structural law \
         (say --damping viscous for the other; frequencies differ by about η²/4)"
            .to_string()
    });
    Ok(Law { warning, ..structural })
}
