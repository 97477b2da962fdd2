//! Global rational fraction polynomials: one denominator for all FRFs.
//!
//! Natural frequency and damping belong to the structure, not to a pair of points. The global form estimates one D from
//! all FRFs at once, each with its own numerator ([`super::equation_error`]); it needs no matching of poles afterwards, and
//! a mode with a node at one response is held up by the others. Many FRFs enter through the count sketch, signed sums of
//! FRFs, which have the same poles: beyond its columns the cost no longer depends on the number of FRFs.
//!
//! Standard deviations are linearised, from the residual of the equations themselves. The alternative, scatter between
//! halves of the lines, was not taken: one difference per pole is a standard deviation with one degree of freedom.
//! Neither sees the bias of the equation error, which on noisy data is the larger part.
//!
//! When not to use it: as [`super::rfp()`]. One denominator for all FRFs also means that a mode that moves between
//! measurements (roving hammer, mass loading, temperature) is smeared into a broader one or split in two.
//!
//! M. H. Richardson, D. L. Formenti, *Global curve fitting of frequency response measurements using the rational fraction
//! polynomial method*, Proc. IMAC 3 (1985).

use super::bands::{in_hertz, BandPlan};
use super::{health, BandLines, ClassicPoles};
use crate::error::FitError;
use crate::options::FitOptions;
use crate::screen::Screened;
use ndarray::s;

/// Common poles of all FRFs by one denominator per band.
///
/// * returns poles as viscous s/ω_max, upper half plane
///
/// # Errors
/// [`FitError::Kernel`] where a decomposition fails.
pub(crate) fn grfp(data: &Screened, options: &FitOptions) -> Result<ClassicPoles, FitError> {
    let (sketch, energy) = data.sketch(options.seed);
    let plan = BandPlan::new(data, &sketch, &energy, options);
    let mut found = ClassicPoles { warnings: plan.warnings, ..ClassicPoles::default() };
    // receptance·g back to the measured kind: its phase jᵖ, so that numerators are real polynomials in jω
    let measured = sketch.b.mapv_into(|v| v * data.kind.from_receptance(1.0));
    let mut modes = Vec::new();
    for band in &plan.bands {
        let lines = BandLines::new(data, band)?;
        let solved = lines.equations.solve(measured.slice(s![band.rows.clone(), ..]))?;
        found.warnings.extend(health(&in_hertz(data, &band.rows), &[solved.condition], &solved.roots, &lines));
        modes.extend(solved.roots.into_iter().filter(|root| lines.physical(root)));
    }
    Ok(found.with_modes(modes, options.modes))
}
