//! Rational fraction polynomials, each FRF by itself, per band.
//!
//! Every FRF is fitted with N(jω)/D(jω) in the measured kind ([`super::equation_error`]):
//! mobility as mobility, accelerance as accelerance, with as many more numerator terms as
//! the kind has powers of jω. Its roots are estimates of the poles as seen from one pair
//! of points. A mode shows in many FRFs at the same place, a computational pole does not:
//! poles of all FRFs are gathered into clusters no wider than half a half-bandwidth, one
//! pole per FRF, and clusters that fewer than a third of the FRFs (or one of several)
//! join are dropped. The pole is the median over its cluster, its standard deviation that
//! of the median (normal scatter from the median absolute deviation). Clusters too small
//! for a scatter take the linearised deviation of the single fits instead.
//!
//! Cost: one small least-squares problem per FRF and band; [`FRFS_USED`] FRFs at most.
//!
//! Avoid it for estimates to report. The equation error is weighted by |D|², so poles
//! come out biased on noisy data and weak modes next to strong ones are missed. Measured
//! here: of well-separated modes that all show, none is missed up to 34 modes at 40 dB,
//! with errors of 1 to 2·10⁻⁴; but fewer spare pole pairs, or one band instead of
//! several, and modes go. Errors are one standard deviation at 60 dB, 1.5 at 40 dB, and
//! five at 20 dB: that is the bias. On the default panel of the simulator (25 modes of
//! uneven strength in the band, 2618 FRFs) 7 of 25 are missed. A mode with a node at two
//! thirds of the points is lost by rule. The method is here because published results
//! were made with it, and because on a few well-separated modes of clean data it is fast
//! and good.
//!
//! M. H. Richardson, D. L. Formenti, *Parameter estimation from frequency response
//! measurements using rational fraction polynomials*, Proc. IMAC 1 (1982) 167–181.

use super::limits::{
    CLUSTER_SHARE, CLUSTER_SPACINGS, FRFS_USED, MEDIAN_OVER_MEAN, SCATTER_MEMBERS,
};
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::methods::band_lines::{health, BandLines};
use crate::methods::bands::{in_hertz, Band, BandPlan};
use crate::methods::clusters::{clusters, median, median_pole};
use crate::methods::equation_error::{Denominator, Root};
use crate::methods::found::LocalPoles;
use crate::methods::survey::Survey;
use crate::tolerances::SIGMA_OF_MEDIAN;
use chladni_frf::Finding;
use num_complex::Complex64;
use rayon::prelude::*;

/// Common poles by clustering those of each FRF.
///
/// * returns poles as viscous s/ω_max, upper half plane
///
/// # Errors
/// [`FitError::Kernel`] where the bands cannot be set up; an FRF that cannot be fitted is
/// left out, said in the warnings.
pub(crate) fn local(survey: &Survey, options: &FitOptions) -> Result<LocalPoles, FitError> {
    let data = survey.data;
    let plan = BandPlan::new(survey, options);
    let mut found = LocalPoles {
        warnings: plan.warnings,
        ..LocalPoles::default()
    };
    let used = evenly(data.pairs.len(), FRFS_USED);
    if used.len() < data.pairs.len() {
        found.warnings.push(Finding::note(
            "some-frfs-used",
            format!(
                "poles come from {} of {} FRFs, evenly chosen",
                used.len(),
                data.pairs.len()
            ),
        ));
    }
    let mut modes = Vec::new();
    for band in &plan.bands {
        let lines = BandLines::new(data, band)?;
        let fits = fit_each(data, band, &lines, &used);
        if fits.len() < used.len() {
            let label = in_hertz(data, &band.rows);
            found.warnings.push(Finding::caution(
                "frfs-not-fitted",
                format!(
                    "{label}: {} of {} FRFs could not be fitted",
                    used.len() - fits.len(),
                    used.len()
                ),
            ));
        }
        let conditions: Vec<f64> = fits.iter().map(|fit| fit.condition).collect();
        let roots: Vec<Root> = fits.iter().flat_map(|fit| fit.roots.clone()).collect();
        found.warnings.extend(health(
            &in_hertz(data, &band.rows),
            &conditions,
            &roots,
            &lines,
        ));
        modes.extend(common(&fits, &lines));
    }
    Ok(found.with_modes(modes, options.modes))
}

fn fit_each(data: &Screened, band: &Band, lines: &BandLines, used: &[usize]) -> Vec<Denominator> {
    // receptance·g back to the measured kind: its phase jᵖ, so that numerators are real
    // polynomials in jω
    let phase = data.kind.from_receptance(1.0);
    used.par_iter()
        .filter_map(|&l| {
            let column = data.block(l..l + 1, band.rows.clone());
            let frf: Vec<Complex64> = column.iter().map(|v| v * phase).collect();
            lines.equations.solve(&frf).ok()
        })
        .collect()
}

/// `most` of 0..total, evenly spread.
fn evenly(total: usize, most: usize) -> Vec<usize> {
    let count = total.min(most);
    (0..count)
        .map(|i| (2 * i + 1) * total / (2 * count))
        .collect()
}

/// Modes that at least a third of the FRFs share, best supported first.
fn common(fits: &[Denominator], lines: &BandLines) -> Vec<Root> {
    let physical: Vec<(usize, Root)> = fits
        .iter()
        .enumerate()
        .flat_map(|(frf, fit)| {
            fit.roots
                .iter()
                .filter(|root| lines.physical(root))
                .map(move |&root| (frf, root))
        })
        .collect();
    let poles: Vec<(usize, Complex64)> =
        physical.iter().map(|&(frf, root)| (frf, root.s)).collect();
    let enough =
        |members: usize| CLUSTER_SHARE * members >= fits.len() && members >= fits.len().min(2);
    clusters(&poles, CLUSTER_SPACINGS * lines.spacing, enough)
        .into_iter()
        .map(|members| {
            summary(
                &members
                    .into_iter()
                    .map(|i| physical[i].1)
                    .collect::<Vec<_>>(),
            )
        })
        .collect()
}

/// Median pole of a cluster and the standard deviation of that median.
fn summary(roots: &[Root]) -> Root {
    let quantities = |root: &Root| [root.s.norm(), -2.0 * root.s.re / root.s.norm()];
    // standard deviation from the median absolute deviation, and of a median relative to
    // that of a mean, normal scatter
    let (from_mad, of_median) = (SIGMA_OF_MEDIAN, MEDIAN_OVER_MEAN);
    let shrink = |members: usize| {
        if members > 2 {
            of_median / (members as f64).sqrt()
        } else {
            1.0 / (members as f64).sqrt()
        }
    };
    let deviation = [0, 1].map(|q| {
        let single = if roots.len() >= SCATTER_MEMBERS {
            let middle = median(roots.iter().map(|r| quantities(r)[q]));
            from_mad * median(roots.iter().map(|r| (quantities(r)[q] - middle).abs()))
        } else {
            median(roots.iter().map(|r| r.deviation[q]))
        };
        single * shrink(roots.len())
    });
    Root {
        s: median_pole(roots.iter().map(|root| root.s)),
        deviation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::synthetic::{run, Structure};
    use chladni_frf::FrfKind;

    fn says(found: &LocalPoles, words: &str) -> bool {
        found.warnings.iter().any(|warning| warning.contains(words))
    }

    #[test]
    fn poles_without_noise_are_exact_in_every_kind() {
        for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
            let structure = Structure {
                kind,
                ..Structure::four_modes()
            };
            for modes in [None, Some(4)] {
                let found = run(local, &structure.frf(1), modes);
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
        for modes in [None, Some(4)] {
            let found = run(local, &structure.frf(2), modes);
            assert_eq!(found.poles.len(), 4);
            assert!(structure.worst(&found) < 1e-4);
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        }
    }

    #[test]
    fn one_frf_is_enough() {
        let structure = Structure {
            responses: 1,
            snr_db: Some(60.0),
            ..Structure::four_modes()
        };
        let found = run(local, &structure.frf(3), None);
        assert_eq!(found.poles.len(), 4);
        assert!(structure.worst(&found) < 1e-4);
    }

    #[test]
    fn deviation_is_the_size_of_the_error_where_bias_is_small() {
        for responses in [1, 3, 24] {
            let structure = Structure {
                responses,
                snr_db: Some(60.0),
                ..Structure::four_modes()
            };
            let mut squares = [0.0; 2];
            let seeds = 20;
            for seed in 0..seeds {
                let found = run(local, &structure.frf(seed), None);
                assert_eq!(found.poles.len(), 4);
                for ((pole, sigma), truth) in found
                    .poles
                    .iter()
                    .zip(&found.deviation)
                    .zip(structure.scaled_poles())
                {
                    let eta = |s: Complex64| -2.0 * s.re / s.norm();
                    squares[0] += ((pole.norm() - truth.norm()) / sigma[0]).powi(2);
                    squares[1] += ((eta(*pole) - eta(truth)) / sigma[1]).powi(2);
                }
            }
            for sum in squares {
                let ratio = (sum / (4 * seeds) as f64).sqrt();
                assert!((0.6..1.6).contains(&ratio), "{responses} FRFs: {ratio}");
            }
        }
    }

    #[test]
    fn twenty_modes_are_found_band_by_band() {
        let structure = Structure {
            snr_db: Some(60.0),
            responses: 12,
            ..Structure::even_modes(20)
        };
        let found = run(local, &structure.frf(4), None);
        assert_eq!(found.poles.len(), 20);
        assert!(structure.worst(&found) < 1e-4);
    }

    #[test]
    fn a_subset_of_many_frfs_is_said() {
        let structure = Structure {
            responses: 230,
            lines: 120,
            snr_db: Some(60.0),
            ..Structure::four_modes()
        };
        let found = run(local, &structure.frf(5), None);
        assert!(says(&found, "200 of 230 FRFs"), "{:?}", found.warnings);
        assert_eq!(evenly(7, 3), [1, 3, 5]);
        assert_eq!(evenly(3, 200), [0, 1, 2]);
    }

    #[test]
    fn the_other_time_sign_is_said() {
        let mut frf = Structure {
            snr_db: Some(60.0),
            ..Structure::four_modes()
        }
        .frf(6);
        frf.conjugate();
        let found = run(local, &frf, None);
        assert!(found.poles.is_empty(), "{found:?}");
        assert!(says(&found, "negative damping"), "{:?}", found.warnings);
    }

    #[test]
    fn an_order_beyond_the_method_is_said() {
        let structure = Structure {
            snr_db: Some(60.0),
            ..Structure::four_modes()
        };
        let found = run(local, &structure.frf(7), Some(15));
        assert!(
            says(&found, "more than this method holds"),
            "{:?}",
            found.warnings
        );
        assert!(says(&found, "15 modes asked for") || found.poles.len() == 15);
    }

    #[test]
    fn poles_that_no_two_frfs_share_are_dropped() {
        let lines = Structure::four_modes().lines();
        let root = |re: f64, im: f64| Root {
            s: Complex64::new(re, im),
            deviation: [1e-4, 1e-4],
        };
        let fit = |roots: Vec<Root>| Denominator {
            roots,
            condition: 1.0,
        };
        let fits = [
            fit(vec![root(-0.01, 0.501), root(-0.01, 0.7)]),
            fit(vec![root(-0.011, 0.5), root(-0.01, 0.8)]),
            fit(vec![
                root(-0.012, 0.502),
                root(-0.01, 0.6),
                root(-0.01, 0.5045),
            ]),
        ];
        let modes = common(&fits, &lines);
        assert_eq!(modes.len(), 1, "{modes:?}");
        assert!((modes[0].s - Complex64::new(-0.011, 0.501)).norm() < 1e-12);
    }
}
