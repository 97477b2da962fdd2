//! The damping law by the number of poles that each law needs (theory.md, section 2).
//!
//! Poles can make good what the wrong law misses: with enough of them both leave noise alone. The
//! right law needs fewer, and no phase and no complex shape changes that.

use crate::damping::verdict::shift;
use crate::data::grade::Grade;
use crate::model::limits;
use crate::poles::estimate::PoleEstimate;
use chladni_frf::{Damping, Trust};
use num_complex::Complex64;

/// True if a search in the other law can tell: the residual is noise, and so small that a mode of
/// the band is far from itself in the other law. Without noise a search ends anywhere: many poles
/// that nearly cancel leave as little as the few of the structure.
pub(crate) fn may_tell(found: &PoleEstimate) -> bool {
    let poles = found.refined.lambda.iter().zip(&found.grades);
    let mut poles = poles.zip(&found.spread);
    let is_far = |((pole, grade), spread): ((&Complex64, &Grade), &f64)| {
        let deviation = (0.5 * spread).sqrt() / pole.re;
        grade.trust == Trust::Sure
            && found.work.in_band(*pole)
            && shift(pole.im / pole.re, 0.5 * deviation, deviation) > limits::LAW_COSTS_POLES
    };
    found.residual_is_noise && !found.is_rounding() && poles.any(is_far)
}

/// The law that needs clearly fewer poles and leaves no more, of a search in each law; `None` where
/// neither does. Where both need many, neither law holds, and their numbers tell nothing.
pub(crate) fn law_of_fewer_poles(first: &PoleEstimate, other: &PoleEstimate) -> Option<Damping> {
    let needs_fewer = |(fewer, more): &(&PoleEstimate, &PoleEstimate)| {
        let [few, many] = [fewer, more].map(|found| beside_modes(found));
        many >= limits::POLES_TELL + few
            && many >= limits::TIMES_AS_MANY * few
            && fewer.residual_is_noise
            && !fewer.is_rounding()
            && fewer.variance <= limits::SAME_NOISE * more.variance
    };
    let found = [(first, other), (other, first)]
        .into_iter()
        .find(needs_fewer);
    found.map(|(fewer, _)| fewer.work.law)
}

/// Number of poles that are no sure modes of the band.
fn beside_modes(found: &PoleEstimate) -> usize {
    let poles = found.refined.lambda.iter().zip(&found.grades);
    let is_beside = |(pole, grade): &(&Complex64, &Grade)| {
        grade.trust != Trust::Sure || !found.work.in_band(**pole)
    };
    poles.filter(is_beside).count()
}
