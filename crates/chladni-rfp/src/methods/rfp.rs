//! Rational fraction polynomials with one denominator for all FRFs, to the likeliest
//! poles.
//!
//! The form of 1985 (one denominator, a numerator for each FRF) in polynomials orthogonal
//! on the lines, on the compressed columns of all FRFs:
//!
//! 1. bands by evidence ([`super::overlapping_bands`]), more poles in each than it shows modes;
//! 2. in each a linear fit and three with the weight 1/|a|² of the one before, the
//!    polynomials made anew for each weight ([`super::sanathanan_koerner`]);
//! 3. poles that explain no more than noise would are taken out (theory.md, eq. 8);
//! 4. one fraction for all that is left, three instrumental-variable steps
//!    ([`super::instrumental`]), and the poles that fell out by then once more.
//!
//! The result is that of maximum likelihood in the poles with free residues, without
//! partial fractions on the way. In ω² for structural damping (one root a mode, complex
//! coefficients), in s for viscous damping (real coefficients). The law not said is told
//! by the turn of the residues, as in `auto`; where that tells nothing, structural.
//!
//! Cost: about twice that of [`super::lean`]; the last steps dominate, 8·lines·modes²
//! per column each.
//!
//! Avoid it where `auto` or `lean` do: they are as exact and cheaper up to some forty
//! modes, and `auto` alone knows what to do where the residual is not white.
//! The weight `linear` is the form of 1985 as published, kept to show what it loses.
//!
//! M. H. Richardson, D. L. Formenti, *Global curve fitting of frequency response
//! measurements using the rational fraction polynomial method*, Proc. IMAC 3 (1985).

use super::limits::LEAST_LEADING;
use crate::damping::law::FIRST;
use crate::damping::plane::Plane;
use crate::data::error::FitError;
use crate::data::options::{FitOptions, RfpWeight};
use crate::methods::found::negative_damping;
use crate::methods::found::MethodPoles;
use crate::methods::local::local;
use crate::methods::rfp_search::Search;
use crate::methods::selection::{fewer, inside};
use crate::methods::survey::{Compressed, Survey};
use chladni_frf::Finding;

/// Common poles by orthogonal polynomials.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn rfp(
    survey: &Survey,
    columns: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    if options.rfp.local {
        return Ok(local(survey, options)?.into());
    }
    let run = |law| Search::new(survey, columns, options, law).run();
    let mut found = run(options.damping.unwrap_or(FIRST))?;
    if options.damping.is_none() {
        match columns
            .law_verdict(survey.data, &found.poles, options)?
            .law()
        {
            Some(law) if law != found.law => found = run(law)?,
            _ => {}
        }
    }
    let mut warnings = Vec::new();
    if 2 * found.turned > found.all {
        warnings.push(negative_damping("", found.turned, found.all));
    }
    if found.leading < LEAST_LEADING {
        warnings.push(ill_conditioned(found.leading));
    }
    warnings.extend(fewer(options, inside(&columns.work, &found.poles)));
    let plane = Plane::new(found.law, &columns.work.x);
    Ok(MethodPoles {
        poles: found
            .poles
            .into_iter()
            .map(|pole| plane.in_s(pole))
            .collect(),
        deviation: None,
        law: found.law,
        warnings,
        how: match options.rfp.weight {
            RfpWeight::Linear => "linear equation error in orthogonal polynomials",
            RfpWeight::Sk => "reweighted equation error in orthogonal polynomials",
            RfpWeight::Iv => "orthogonal polynomials, instrumental-variable steps",
            RfpWeight::Gn => "orthogonal polynomials, Gauss-Newton steps",
        },
        stabilization: None,
    })
}

/// The finding where the order is higher than the polynomials tell.
fn ill_conditioned(leading: f64) -> Finding {
    Finding::caution(
        "ill-conditioned",
        format!(
            "the leading coefficient of the denominator is {leading:.0e} of all: its roots lose \
             digits"
        ),
    )
    .value("leading_coefficient", leading)
    .help("ask for fewer modes, or fit a narrower band")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::options::RfpOptions;
    use crate::data::screening::Screened;
    use crate::methods::synthetic::even;
    use chladni_frf::Damping;
    use chladni_frf::Mode;
    use chladni_plate::{cramer_rao, simulate, Panel, Synthetic, SyntheticSet};
    use ndarray::Array1;

    /// The abstract panel: 34 modes, three pairs closer than their bandwidth. The lowest is
    /// twice as broad: what is narrower than a fifth of the line spacing counts as a spike.
    fn abstract_panel(snr_db: f64, seed: u64) -> SyntheticSet {
        let mut natural: Vec<f64> = (0..31)
            .map(|n| 14.0 + 22.7 * f64::from(n) + 4.0 * (1.7 * f64::from(n)).sin())
            .collect();
        for n in [6, 15, 25] {
            natural.push(natural[n] * 1.006);
        }
        let mut loss_factor = vec![0.01; natural.len()];
        loss_factor[0] = 0.02;
        Synthetic {
            natural_frequency_hz: natural,
            loss_factor,
            responses: 77,
            references: 34,
            frequency_hz: Array1::linspace(10.0, 700.0, 1601),
            residual_powers: vec![-2, 0],
            residual_level: 0.02,
            snr_db,
            seed,
            ..Synthetic::default()
        }
        .build()
        .unwrap()
    }

    /// The glass panel of the bench: 34 modes from 10 to 700 Hz, one at 702 Hz.
    fn glass_panel(snr_db: f64, seed: u64) -> SyntheticSet {
        let mut panel = Panel::default();
        panel.plate.thickness_m = 0.000_376_03;
        (panel.frf.start_hz, panel.frf.stop_hz, panel.frf.step_hz) = (10.0, 700.0, 690.0 / 1600.0);
        (panel.frf.snr_db, panel.frf.seed) = (snr_db, seed);
        let simulated = simulate(&panel, None, None).unwrap();
        SyntheticSet {
            frf: simulated.frf,
            truth: simulated.truth,
            noise_variance: simulated.noise_variance,
        }
    }

    /// Errors of natural frequencies over their bound, root mean square over the seeds:
    /// median and worst mode; modes missed and poles that are none, over all seeds.
    #[derive(Debug)]
    struct Judged {
        median: f64,
        worst: f64,
        missed: usize,
        spurious: usize,
    }

    /// Error over the bound of each mode in the band, if found, and spurious poles.
    fn errors(set: &SyntheticSet, options: &FitOptions) -> (Vec<Option<f64>>, usize) {
        let data = Screened::new(&set.frf, options).unwrap();
        let survey = Survey::new(&data, options.seed);
        let columns = survey.compress().unwrap();
        let found = rfp(&survey, &columns, options).unwrap();
        let mut hz: Vec<f64> = found
            .poles
            .iter()
            .map(|s| match found.law {
                Damping::Structural => (-s * s).re.max(0.0).sqrt(),
                Damping::Viscous => s.norm(),
            })
            .map(|omega| omega * data.hz())
            .collect();
        let powers = [-2, 0, 2, 4];
        let bound = cramer_rao(
            &set.truth,
            &set.frf.frequency_hz,
            set.noise_variance,
            &powers,
        )
        .unwrap();
        let of_mode = |(mode, std): (&Mode, &f64)| {
            let off = |f: &f64| (f - mode.frequency_hz).abs();
            let nearest = (0..hz.len()).min_by(|&a, &b| off(&hz[a]).total_cmp(&off(&hz[b])))?;
            let half_bandwidth = 0.5 * mode.loss_factor * mode.frequency_hz;
            let off = off(&hz[nearest]);
            (off < half_bandwidth).then(|| {
                hz.remove(nearest);
                off / std
            })
        };
        let errors = set
            .truth
            .in_band_modes()
            .zip(&bound.frequency_std_hz)
            .map(of_mode)
            .collect();
        let [low, high] = data.band_hz;
        let spurious = hz.iter().filter(|f| (low..=high).contains(*f)).count();
        (errors, spurious)
    }

    fn judged(make: &dyn Fn(u64) -> SyntheticSet, seeds: u64, options: &FitOptions) -> Judged {
        let fits: Vec<_> = (1..=seeds)
            .map(|seed| errors(&make(seed), options))
            .collect();
        let mut rms: Vec<f64> = (0..fits[0].0.len())
            .map(|mode| {
                let found: Vec<f64> = fits.iter().filter_map(|(errors, _)| errors[mode]).collect();
                (found.iter().map(|e| e * e).sum::<f64>() / found.len() as f64).sqrt()
            })
            .collect();
        rms.sort_by(f64::total_cmp);
        Judged {
            median: rms[rms.len() / 2],
            worst: rms[rms.len() - 1],
            missed: fits
                .iter()
                .flat_map(|(e, _)| e)
                .filter(|e| e.is_none())
                .count(),
            spurious: fits.iter().map(|(_, spurious)| spurious).sum(),
        }
    }

    fn with(weight: RfpWeight) -> FitOptions {
        FitOptions {
            rfp: RfpOptions {
                weight,
                ..RfpOptions::default()
            },
            ..FitOptions::default()
        }
    }

    /// No mode missed, none spurious, errors within these bounds.
    fn assert_exact(name: &str, outcome: &Judged, median: f64, worst: f64) {
        println!("{name}: {outcome:?}");
        assert_eq!((outcome.missed, outcome.spurious), (0, 0), "{name}");
        assert!(outcome.median < median, "{name}: {outcome:?}");
        assert!(outcome.worst < worst, "{name}: {outcome:?}");
    }

    /// One seed each, six with `CHLADNI_SEEDS=6`; the bounds are those of six, and of one
    /// error in 34 beyond 3.5 standard deviations once in 60 panels.
    #[test]
    fn panels_lose_no_mode() {
        let seeds = std::env::var("CHLADNI_SEEDS").map_or(1, |count| count.parse().unwrap());
        let worst = |many: f64| if seeds < 6 { 3.5 } else { many };
        for snr_db in [20.0, 40.0] {
            let made = |seed| abstract_panel(snr_db, seed);
            let outcome = judged(&made, seeds, &with(RfpWeight::Iv));
            assert_exact("abstract", &outcome, 1.1, worst(2.0));
            let made = |seed| glass_panel(snr_db, seed);
            let outcome = judged(&made, seeds, &with(RfpWeight::Iv));
            assert_exact("glass", &outcome, 1.1, worst(3.0));
        }
        let outcome = judged(&|seed| abstract_panel(40.0, seed), 1, &with(RfpWeight::Gn));
        assert_exact("abstract, Gauss-Newton", &outcome, 1.1, 3.5);
    }

    #[test]
    fn a_hundred_modes_are_found() {
        let make = |seed| even(100, 60.0, Damping::Structural, seed);
        // one error of 100 is beyond 3.5 standard deviations once in 20 sets
        assert_exact(
            "100 modes",
            &judged(&make, 1, &with(RfpWeight::Iv)),
            1.1,
            3.5,
        );
    }

    #[test]
    fn each_weight_does_better_than_the_one_before() {
        let [linear, sk, iv] = [RfpWeight::Linear, RfpWeight::Sk, RfpWeight::Iv].map(|weight| {
            judged(
                &|seed| even(12, 40.0, Damping::Structural, seed),
                4,
                &with(weight),
            )
        });
        assert!(
            linear.median > sk.median && sk.worst > iv.worst,
            "{linear:?} {sk:?} {iv:?}"
        );
    }

    #[test]
    fn viscous_damping_is_found_by_itself() {
        let make = |seed| even(12, 40.0, Damping::Viscous, seed);
        assert_exact("viscous", &judged(&make, 4, &with(RfpWeight::Iv)), 1.2, 2.5);
    }
}
