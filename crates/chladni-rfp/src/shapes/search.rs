//! Structured refinement: one shape per mode for all references, real where the data
//! admit it (theory.md, section 4).
//!
//! Free residues spend most of their freedom on differences that no structure has.
//! Rank-one residues R_n = ψ_n·L_nᵀ lower the bound of close poles by up to an order of
//! magnitude, real shapes by √2 in frequency on top. Either is taken only where the sum
//! of squares rises by no more than chance (likelihood ratio); where rank one does not
//! hold, modes may be missing, and one at a time is added while it pays.
//!
//! Needs every pair of response and reference. In the viscous law the steps replace the derivative
//! by Re λ as [`crate::damping::columns`] does.

use crate::data::layout::DataLayout;
use crate::data::options::ShapeModel;
use crate::poles::estimate::PoleEstimate;
use crate::shapes::attempt::{is_chance, Attempt};
use crate::shapes::limits;
use crate::shapes::structure::Search;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Refines the poles of the band under the shape model asked for; where one just beyond
/// its ends has one shape too, that one with them: left free it takes most of what is
/// known of its neighbour inside.
///
/// `fixed_order`: no mode may be added.
pub(crate) fn structured(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
) -> Result<Search, LinalgError> {
    match attempted(data, found, asked, fixed_order) {
        // no structure can be tested on columns that cannot be told apart
        Err(LinalgError::NotPositiveDefinite { .. }) => Ok(Search::Inapplicable),
        other => other,
    }
}

fn attempted(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
) -> Result<Search, LinalgError> {
    let (work, lambda) = (&found.work, &found.refined.lambda);
    let complete = data.pairs.len() == data.responses.len() * data.references.len();
    if asked == ShapeModel::Free || !complete || !lambda.iter().any(|l| work.in_band(*l)) {
        return Ok(Search::Inapplicable);
    }
    let (low, high) = work.range();
    let beside = |l: &Complex64| (low - l.re).max(l.re - high) < limits::BESIDE_HALF_WIDTHS * l.im;
    let mut known = None;
    if asked == ShapeModel::Auto && lambda.iter().any(|l| beside(l) && !work.in_band(*l)) {
        let attempt = Attempt::new(data, found, (asked, fixed_order), beside)?;
        let state = attempt.one_shape_each(None)?;
        if is_chance(attempt.beyond_free(&state)) {
            if !attempt.is_hopeless(&state)? {
                match attempt.searched(state.clone())? {
                    Search::Found(own) if own.borne && own.stays_outside(work) => {
                        return Ok(Search::Found(own));
                    }
                    _ => {}
                }
            }
            known = Some(state);
        }
    }
    let attempt = Attempt::new(data, found, (asked, fixed_order), |l| work.in_band(*l))?;
    let state = attempt.one_shape_each(known.as_ref())?;
    let sigmas = attempt.beyond_free(&state);
    match asked {
        ShapeModel::Auto if !is_chance(sigmas) => Ok(Search::Refused(sigmas)),
        _ => attempt.searched(state),
    }
}
