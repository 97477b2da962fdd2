//! Rational fraction polynomials with one denominator for all FRFs, to the likeliest
//! poles.
//!
//! The form of 1985 (one denominator, a numerator for each FRF) in polynomials orthogonal
//! on the lines, on the compressed columns of all FRFs:
//!
//! 1. bands by evidence ([`super::windows`]), more poles in each than it shows modes;
//! 2. in each a linear fit and three with the weight 1/|a|² of the one before, the
//!    polynomials made anew for each weight ([`super::sanathanan_koerner()`]);
//! 3. poles that explain no more than noise would are taken out (theory.md, eq. 8);
//! 4. one fraction for all that is left, three instrumental-variable steps
//!    ([`super::instrumental`]), and the poles that fell out by then once more.
//!
//! The result is that of maximum likelihood in the poles with free residues, without
//! partial fractions on the way. In ω² for structural damping (one root a mode, complex
//! coefficients), in s for viscous damping (real coefficients). The law not said is the
//! structural one where that leaves no more than noise, else the one that leaves less.
//!
//! Cost: about twice that of [`super::lean()`]; the last steps dominate, 8·lines·modes²
//! per column each.
//!
//! When not to use it: where `auto` or `lean` do, they are as exact and cheaper up to some
//! forty modes, and `auto` alone knows what to do where the residual is not white.
//! `--rfp-weight linear` is the form of 1985 as published, kept to show what it loses.
//!
//! M. H. Richardson, D. L. Formenti, *Global curve fitting of frequency response
//! measurements using the rational fraction polynomial method*, Proc. IMAC 3 (1985).

use crate::damping::structural::POWERS;
use crate::damping::viscous::{from_structural, viscous_basis};
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::options::{FitOptions, RfpWeight};
use crate::methods::found::MethodPoles;
use crate::methods::fraction::{damped, Lines};
use crate::methods::instrumental::{improved, Steps};
use crate::methods::local::local;
use crate::methods::plane::Plane;
use crate::methods::sanathanan_koerner::sanathanan_koerner;
use crate::methods::selection::{fewer, inside, left_by};
use crate::methods::survey::{Compressed, Survey};
use crate::methods::windows::{order, windows, Window};
use crate::poles::prune::{threshold, unphysical};
use crate::poles::refine::{removable, Projection};
use crate::poles::scan::usual_loss;
use chladni_frf::Damping;
use chladni_linalg::blocked::{projected, stacked, tall_qr};
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Reweighted fits after the linear one.
const REWEIGHTED: usize = 3;
/// Steps of the last fraction.
const LAST_STEPS: usize = 3;
/// Half-bandwidths beyond its core at which a band may still claim a pole.
const CLAIM: f64 = 0.25;
/// Half-bandwidths within which two poles of neighbouring bands are one.
const TWINS: f64 = 0.5;
/// Loss factor and bandwidth over their medians, both, from which a pole of the band
/// serves the background.
const BACKGROUND: f64 = 4.0;
/// Variance of a residue over that of its pole alone beyond which the pole adds nothing.
const MOST_INFLATION: f64 = 1e10;
/// Variance left over that of the noise from which the structural law is in doubt.
const DOUBT: f64 = 1.1;

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
    let search = Search::new(survey, columns, options);
    let law = options.damping.unwrap_or(Damping::Structural);
    let mut found = search.run(law)?;
    let mut taken = law;
    if options.damping.is_none() {
        let left = search.left(&found.poles, law)?;
        if left > DOUBT * search.noise {
            let other = search.run(Damping::Viscous)?;
            if search.left(&other.poles, Damping::Viscous)? < left {
                (found, taken) = (other, Damping::Viscous);
            }
        }
    }
    let mut warnings = Vec::new();
    if 2 * found.turned > found.all {
        warnings.push(format!(
            "{} of {} poles in the band have negative damping; the data may follow \
             e^(-jwt), or hold no mode",
            found.turned, found.all
        ));
    }
    warnings.extend(fewer(options, inside(&columns.work, &found.poles)));
    Ok(MethodPoles {
        poles: found.poles.into_iter().map(from_structural).collect(),
        deviation: None,
        law: taken,
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

/// Poles λ, and how many roots in the band turned the wrong way.
#[derive(Default)]
struct Found {
    poles: Vec<Complex64>,
    turned: usize,
    all: usize,
}

struct Search<'a> {
    survey: &'a Survey<'a>,
    columns: &'a Compressed,
    options: &'a FitOptions,
    /// Noise variance of one value in the compressed columns; 0 where only the residual
    /// tells it.
    noise: f64,
}

impl<'a> Search<'a> {
    fn new(survey: &'a Survey, columns: &'a Compressed, options: &'a FitOptions) -> Self {
        let (lines, frfs) = (
            survey.data.lines.len() as f64,
            survey.data.pairs.len() as f64,
        );
        // directions were chosen by the data, so that noise weighs more in them
        let chosen = (1.0 + (frfs / (2.0 * lines)).sqrt()).powi(2);
        let beyond = frfs - columns.work.columns() as f64;
        Self {
            survey,
            columns,
            options,
            noise: if beyond > 0.0 {
                chosen * columns.outside / (lines * beyond)
            } else {
                0.0
            },
        }
    }

    /// All steps in one law.
    fn run(&self, law: Damping) -> Result<Found, LinalgError> {
        let work = &self.columns.work;
        let mut found = Found::default();
        let energy = &self.survey.energy;
        let windows = windows(&self.survey.peaks, energy, self.options.rfp.bands);
        for window in &windows {
            self.search(law, window, windows.len(), &mut found)?;
        }
        found.poles = without_twins(found.poles);
        self.thin(work, &mut found.poles, true)?;
        let steps = match self.options.rfp.weight {
            RfpWeight::Linear | RfpWeight::Sk => return Ok(found),
            RfpWeight::Iv => Steps::Instrumental,
            RfpWeight::Gn => Steps::GaussNewton,
        };
        let helpers: Vec<Complex64> = helpers(work, &found.poles).collect();
        found.poles.extend(helpers);
        let lines = Lines::new(Plane::new(law, &work.x), work);
        loop {
            let before = found.poles.len();
            found.poles = improved(&lines, &found.poles, steps, LAST_STEPS)?;
            self.thin(work, &mut found.poles, false)?;
            if found.poles.len() == before || found.poles.is_empty() {
                return Ok(found);
            }
        }
    }

    /// Poles of one band.
    fn search(
        &self,
        law: Damping,
        window: &Window,
        bands: usize,
        found: &mut Found,
    ) -> Result<(), LinalgError> {
        let whole = &self.columns.work;
        let work = whole.rows(window.rows.clone());
        let peaks = &self.survey.peaks;
        let visible = peaks
            .iter()
            .filter(|p| window.rows.contains(&p.row))
            .count();
        let asked = self.options.modes.map(|modes| modes.div_ceil(bands));
        let order = order(&work, visible, asked)?;
        let lines = Lines::new(Plane::new(law, &work.x), &work);
        let steps = match self.options.rfp.weight {
            RfpWeight::Linear => 0,
            _ => REWEIGHTED,
        };
        let roots = sanathanan_koerner(&lines, order, steps)?;
        let (stable, turned): (Vec<Complex64>, Vec<Complex64>) =
            roots.iter().partition(|root| root.im > 0.0);
        let mut poles = lines.plane.poles(&stable);
        let wrong = inside(&work, &lines.plane.poles(&damped(&turned)));
        found.turned += wrong;
        found.all += wrong + inside(&work, &poles);
        self.thin(&work, &mut poles, self.options.modes.is_none())?;
        let last = whole.lines();
        found.poles.extend(poles.into_iter().filter(|pole| {
            let claim = CLAIM * pole.im;
            (window.core.start == 0 || pole.re + claim >= whole.x[window.core.start])
                && (window.core.end == last || pole.re - claim < whole.x[window.core.end])
        }));
        Ok(())
    }

    /// Takes out what `work` does not tell from noise, down to the modes asked for; with
    /// `background` also what is much broader than the rest.
    fn thin(
        &self,
        work: &Columns,
        poles: &mut Vec<Complex64>,
        background: bool,
    ) -> Result<(), LinalgError> {
        poles.retain(|pole| !unphysical(work, *pole));
        if background {
            drop_background(work, poles);
        }
        if poles.is_empty() {
            return Ok(());
        }
        let whole = work.lines() == self.columns.work.lines();
        let asked = self.options.modes;
        let all = removable(work, poles, &POWERS)?;
        let variance = self.noise.max(left_by(work, all.sse, all.alone.len()));
        let limit = threshold(work.columns(), work.lines()) * variance;
        *poles = all.thin_out(poles, |kept, q, rise, inflation| {
            let within = kept.iter().filter(|&&k| work.in_band(poles[k])).count();
            match (work.in_band(poles[q]), asked) {
                _ if inflation > MOST_INFLATION => true,
                (true, Some(asked)) => whole && within > asked,
                _ => rise < limit,
            }
        });
        Ok(())
    }

    /// Variance of one value that the poles leave in the compressed columns.
    fn left(&self, lambda: &[Complex64], law: Damping) -> Result<f64, LinalgError> {
        let work = &self.columns.work;
        let unknowns = lambda.len() + POWERS.len();
        let sse = match law {
            Damping::Structural => Projection::new(work, lambda, &POWERS)?.sse,
            Damping::Viscous => {
                let poles: Vec<Complex64> = lambda.iter().map(|l| from_structural(*l)).collect();
                let (q, _) = tall_qr(viscous_basis(work, &poles, &POWERS).view())?;
                let (_, residual) = projected(q.view(), stacked(&work.b).view());
                residual.iter().map(|v| v * v).sum()
            }
        };
        let freedom = work.lines().saturating_sub(unknowns).max(1) * work.columns();
        Ok(sse / freedom as f64)
    }
}

/// Poles without those that two bands found.
fn without_twins(poles: Vec<Complex64>) -> Vec<Complex64> {
    let mut kept: Vec<Complex64> = Vec::new();
    for pole in poles {
        let twin = |other: &Complex64| (other - pole).norm() < TWINS * other.im.min(pole.im);
        if !kept.iter().any(twin) {
            kept.push(pole);
        }
    }
    kept
}

/// Drops poles of the band that are broad in bandwidth and in loss factor.
fn drop_background(work: &Columns, poles: &mut Vec<Complex64>) {
    let median = |measure: &dyn Fn(&Complex64) -> f64| {
        let mut values: Vec<f64> = poles
            .iter()
            .filter(|pole| work.in_band(**pole))
            .map(measure)
            .collect();
        values.sort_by(f64::total_cmp);
        values
            .get(values.len() / 2)
            .copied()
            .unwrap_or(f64::INFINITY)
    };
    let loss = |pole: &Complex64| pole.im / pole.re;
    let width = |pole: &Complex64| pole.im / pole.re.abs().sqrt();
    let (most_loss, most_width) = (BACKGROUND * median(&loss), BACKGROUND * median(&width));
    poles.retain(|pole| !work.in_band(*pole) || loss(pole) < most_loss || width(pole) < most_width);
}

/// A pole beyond each end that has none.
fn helpers<'a>(work: &'a Columns, poles: &'a [Complex64]) -> impl Iterator<Item = Complex64> + 'a {
    let (low, high) = work.range();
    let reach = 2.0 * (high - low) / poles.len().max(1) as f64;
    let loss = usual_loss(work, poles);
    [
        (low - reach, poles.iter().any(|pole| pole.re < low)),
        (high + reach, poles.iter().any(|pole| pole.re > high)),
    ]
    .into_iter()
    .filter(|(x, there)| *x > 0.0 && !there)
    .map(move |(x, _)| Complex64::new(1.0, loss) * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::options::RfpOptions;
    use crate::data::screening::Screened;
    use chladni_plate::{cramer_rao, Synthetic, SyntheticSet};
    use ndarray::Array1;
    use std::f64::consts::TAU;

    /// The abstract panel: 34 modes, three pairs closer than their bandwidth, and one
    /// more above the band.
    fn abstract_panel(responses: usize, references: usize, snr_db: f64, seed: u64) -> Synthetic {
        let mut natural: Vec<f64> = (0..31)
            .map(|n| 14.0 + 22.8 * f64::from(n) + 4.0 * (1.7 * f64::from(n)).sin())
            .collect();
        for n in [6, 15, 25] {
            natural.push(natural[n] * 1.006);
        }
        natural.push(704.0);
        Synthetic {
            natural_frequency_hz: natural,
            loss_factor: vec![0.01],
            responses,
            references,
            frequency_hz: Array1::linspace(10.0, 700.0, 1601),
            residual_powers: vec![-2, 0],
            residual_level: 0.02,
            snr_db,
            seed,
            ..Synthetic::default()
        }
    }

    fn even(modes: usize, snr_db: f64, seed: u64) -> Synthetic {
        let natural: Vec<f64> = (0..modes).map(|n| 20.0 + 10.0 * n as f64).collect();
        let top = 25.0 + 10.0 * modes as f64;
        Synthetic {
            loss_factor: natural.iter().map(|f| 1.0 / f).collect(),
            natural_frequency_hz: natural,
            responses: 6,
            references: 2,
            frequency_hz: Array1::linspace(10.0, top, 16 * modes * 4 + 1),
            snr_db,
            seed,
            ..Synthetic::default()
        }
    }

    /// |error|/bound of each frequency, and spurious poles in the band.
    fn judged(set: &SyntheticSet, options: &FitOptions) -> (Vec<f64>, usize) {
        let data = Screened::new(&set.frf, options).unwrap();
        let survey = Survey::new(&data, options.seed);
        let columns = survey.compress().unwrap();
        let found = rfp(&survey, &columns, options).unwrap();
        let hz: Vec<f64> = found
            .poles
            .iter()
            .map(|s| match found.law {
                Damping::Structural => (-s * s).re.sqrt(),
                Damping::Viscous => s.norm(),
            })
            .map(|omega| omega * data.omega_max / TAU)
            .collect();
        let bound = cramer_rao(
            &set.truth,
            &set.frf.frequency_hz,
            set.noise_variance,
            &[-2, 0, 2, 4],
        )
        .unwrap();
        let errors: Vec<f64> = set
            .truth
            .in_band_modes()
            .zip(&bound.frequency_std_hz)
            .map(|(mode, std)| {
                hz.iter()
                    .map(|f| (f - mode.frequency_hz).abs() / std)
                    .fold(f64::INFINITY, f64::min)
            })
            .collect();
        let inside = found
            .poles
            .iter()
            .filter(|s| columns.work.in_band(-*s * *s))
            .count();
        let spurious = inside.saturating_sub(errors.len());
        (errors, spurious)
    }

    /// Median, worst error over the bound, modes missed and spurious poles.
    fn shown(spec: &Synthetic, options: &FitOptions) -> (f64, f64, usize, usize) {
        let (mut errors, spurious) = judged(&spec.build().unwrap(), options);
        errors.sort_by(f64::total_cmp);
        // beyond a hundred standard deviations it is another pole
        let missed = errors.iter().filter(|error| **error > 100.0).count();
        let outcome = (
            errors[errors.len() / 2],
            errors[errors.len() - 1],
            missed,
            spurious,
        );
        println!("{} dB, {:?}: {outcome:?}", spec.snr_db, options.rfp);
        outcome
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

    #[test]
    fn the_panel_loses_no_mode() {
        for snr_db in [40.0, 20.0] {
            for weight in [RfpWeight::Iv, RfpWeight::Gn] {
                let spec = abstract_panel(77, 34, snr_db, 1);
                let (median, worst, _, spurious) = shown(&spec, &with(weight));
                assert_eq!(spurious, 0);
                assert!(median < 1.1 && worst < 4.5, "{median} {worst}");
            }
        }
    }

    #[test]
    fn a_hundred_modes_are_at_the_bound() {
        let (median, worst, _, spurious) = shown(&even(100, 60.0, 1), &with(RfpWeight::Iv));
        assert_eq!(spurious, 0);
        assert!(median < 1.1 && worst < 4.5, "{median} {worst}");
    }

    #[test]
    fn each_weight_does_better_than_the_one_before() {
        let spec = abstract_panel(12, 3, 40.0, 1);
        let [linear, sk, iv] = [RfpWeight::Linear, RfpWeight::Sk, RfpWeight::Iv]
            .map(|weight| shown(&spec, &with(weight)));
        assert!(linear.0 > sk.0 && sk.1 > iv.1, "{linear:?} {sk:?} {iv:?}");
    }

    #[test]
    fn viscous_damping_is_found_by_itself() {
        let spec = Synthetic {
            damping: Damping::Viscous,
            ..even(12, 40.0, 1)
        };
        let (median, worst, _, spurious) = shown(&spec, &with(RfpWeight::Iv));
        assert_eq!(spurious, 0);
        assert!(median < 1.1 && worst < 4.5, "{median} {worst}");
    }
}
