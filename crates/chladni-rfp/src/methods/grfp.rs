//! Global rational fraction polynomials: one denominator for all FRFs.
//!
//! Natural frequency and damping belong to the structure, not to a pair of points. The
//! global form estimates one D from all FRFs at once, each with its own numerator
//! ([`super::equation_error`]); it needs no matching of poles afterwards, and a mode with
//! a node at one response is held up by the others. Many FRFs enter through the count
//! sketch, signed sums of FRFs, which have the same poles: beyond its columns the cost no
//! longer depends on the number of FRFs.
//!
//! Standard deviations are linearised, from the residual of the equations themselves. The
//! alternative, scatter between halves of the lines, was not taken: one difference per
//! pole is a standard deviation with one degree of freedom. Neither sees the bias of the
//! equation error, which on noisy data is the larger part.
//!
//! When not to use it: as [`super::rfp()`]; on the simulated plate named there it misses
//! 9 of 25 modes and adds 8 poles that are none. One denominator for all FRFs also means
//! that a mode that moves between measurements (roving hammer, mass loading, temperature)
//! is smeared into a broader one or split in two.
//!
//! M. H. Richardson, D. L. Formenti, *Global curve fitting of frequency response
//! measurements using the rational fraction polynomial method*, Proc. IMAC 3 (1985).

use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::methods::bands::{in_hertz, BandPlan};
use crate::methods::classic::{health, BandLines};
use crate::methods::found::ClassicPoles;
use crate::methods::survey::Survey;
use ndarray::s;

/// Common poles of all FRFs by one denominator per band.
///
/// * returns poles as viscous s/ω_max, upper half plane
///
/// # Errors
/// [`FitError::Kernel`] where a decomposition fails.
pub(crate) fn grfp(survey: &Survey, options: &FitOptions) -> Result<ClassicPoles, FitError> {
    let data = survey.data;
    let plan = BandPlan::new(survey, options);
    let mut found = ClassicPoles {
        warnings: plan.warnings,
        ..ClassicPoles::default()
    };
    // receptance·g back to the measured kind: its phase jᵖ, so that numerators are real
    // polynomials in jω
    let measured = survey.sketch.b.mapv(|v| v * data.kind.from_receptance(1.0));
    let mut modes = Vec::new();
    for band in &plan.bands {
        let lines = BandLines::new(data, band)?;
        let solved = lines
            .equations
            .solve(measured.slice(s![band.rows.clone(), ..]))?;
        found.warnings.extend(health(
            &in_hertz(data, &band.rows),
            &[solved.condition],
            &solved.roots,
            &lines,
        ));
        modes.extend(solved.roots.into_iter().filter(|root| lines.physical(root)));
    }
    Ok(found.with_modes(modes, options.modes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::synthetic::{run, Structure};
    use chladni_frf::FrfKind;

    #[test]
    fn poles_without_noise_are_exact_in_every_kind() {
        for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
            let structure = Structure {
                kind,
                ..Structure::four_modes()
            };
            for modes in [None, Some(4)] {
                let found = run(grfp, &structure.frf(1), modes);
                assert_eq!(found.poles.len(), 4, "{kind}: {found:?}");
                let worst = structure.worst(&found);
                assert!(worst < 1e-8, "{kind}: {worst:e}");
            }
        }
    }

    #[test]
    fn frequencies_at_60_db() {
        let structure = Structure {
            snr_db: Some(60.0),
            ..Structure::four_modes()
        };
        let found = run(grfp, &structure.frf(2), None);
        assert_eq!(found.poles.len(), 4);
        assert!(structure.worst(&found) < 1e-4);
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    }

    #[test]
    fn deviation_is_the_size_of_the_error_where_bias_is_small() {
        let structure = Structure {
            responses: 24,
            snr_db: Some(60.0),
            ..Structure::four_modes()
        };
        let mut squares = 0.0;
        let seeds = 20;
        for seed in 0..seeds {
            let found = run(grfp, &structure.frf(seed), None);
            for ((pole, sigma), truth) in found
                .poles
                .iter()
                .zip(&found.deviation)
                .zip(structure.scaled_poles())
            {
                squares += ((pole.norm() - truth.norm()) / sigma[0]).powi(2);
            }
        }
        let ratio = (squares / (4 * seeds) as f64).sqrt();
        assert!((0.6..1.6).contains(&ratio), "{ratio}");
    }

    #[test]
    fn more_frfs_than_sketch_columns() {
        let structure = Structure {
            responses: 200,
            lines: 200,
            snr_db: Some(60.0),
            ..Structure::four_modes()
        };
        let found = run(grfp, &structure.frf(3), None);
        assert_eq!(found.poles.len(), 4);
        assert!(structure.worst(&found) < 1e-4);
    }

    /// An order no data can support must be said, whatever comes out.
    #[test]
    fn ill_conditioning_is_never_silent() {
        for modes in [Some(9), Some(20), Some(60)] {
            let found = run(grfp, &Structure::four_modes().frf(1), modes);
            let said = chladni_frf::warnings(&found.warnings).join("; ");
            assert!(said.contains("ill-conditioned"), "{modes:?}: {said}");
            assert!(
                said.contains("more than this method holds"),
                "{modes:?}: {said}"
            );
        }
    }
}
