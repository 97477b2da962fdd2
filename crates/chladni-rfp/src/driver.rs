//! The driver of every fit, in memory or in pieces: find poles, choose the damping law, turn
//! residues into shapes and a model, check the data.
//!
//! The walk is written once over a [`Source`]. In memory it runs to its end. Over partials it
//! stops at a pass that is not made yet, and goes on from there once other machines have made
//! it.

use crate::checks::case::Noise;
use crate::checks::examine::examine;
use crate::data::error::FitError;
use crate::data::layout::{DataLayout, Weighting};
use crate::data::options::{FitOptions, Method};
use crate::data::outliers::{self, OutlierLines};
use crate::data::pair_weights::{NextWeights, NoiseSource, PairWeights};
use crate::data::screening::Screened;
use crate::data::source::Source;
use crate::data::watch::Watch;
use crate::methods::aaa::aaa;
use crate::methods::auto::auto;
use crate::methods::bars::fit_by_method;
use crate::methods::circle::circle;
use crate::methods::fit::{Fit, FitToCheck, MethodRun};
use crate::methods::found::Finder;
use crate::methods::lean::lean;
use crate::methods::lscf::lscf;
use crate::methods::peak::peak;
use crate::methods::plscf::plscf;
use crate::methods::rfp::rfp;
use crate::methods::survey::Survey;
use crate::methods::vf::vf;
use crate::model::build::Shaped;
use crate::model::decide::with_free_residues;
use crate::model::exponential;
use crate::poles::whiteness::Residual;
use crate::tolerances::OUTLIER_ROUNDS;
use chladni_frf::{Finding, ModalModel};

/// Fits `data`, each FRF weighted by its noise if that is known:
///
/// 1. Weights from the set, if it gives its noise.
/// 2. Else no weights; then those from the residual, if it shows unequal noise.
/// 3. Once more those from the residual of the weighted fit, if they still differ.
///
/// Weights from a residual are dropped if the residual of the weighted fit is not white. Weights
/// by coherence give way to those from the residual if that contradicts them.
///
/// # Errors
/// A fit that cannot be made; a pass that others must make.
pub(crate) fn walk<S: Source>(
    mut data: S,
    options: &FitOptions,
    watch: &Watch,
) -> Result<Fit, S::Stop> {
    loop {
        let weighted = weighted_by_set(&data)?;
        let (fitted, found) = without_outliers(weighted, options, watch)?;
        let weighted_residual_energy = weighted_residual_energy(&fitted, &found);
        data = match next_fit(&fitted, &found, &weighted_residual_energy) {
            NextFit::None => {
                let FitToCheck {
                    mut fit, residual, ..
                } = found;
                name_weighting(&fitted, &mut fit.model);
                let energy = &weighted_residual_energy;
                checked(&fitted, energy, options, residual, &mut fit.model);
                return Ok(fit);
            }
            NextFit::Weighted { weights, next } => {
                watch.stage(match next {
                    NextWeights::None => "FRFs weighted by their noise once more",
                    _ => "FRFs weighted by their noise",
                })?;
                fitted.weighted(Some((weights, None)), next)?
            }
            NextFit::Unweighted => fitted.weighted(None, NextWeights::None)?,
            NextFit::WithoutCoherence { finding } => data
                .noted(finding)
                .weighted(None, NextWeights::FromResidual)?,
        };
    }
}

/// `data` weighted by the noise that the set gives, if those weights are the next to try.
fn weighted_by_set<S: Source>(data: &S) -> Result<S, S::Stop> {
    let given = match data.next_weights {
        NextWeights::FromSet => data.given_noise(),
        NextWeights::FromResidual | NextWeights::FromWeightedResidual | NextWeights::None => None,
    };
    let weights = given.and_then(|(noise, noise_source)| {
        let weights = PairWeights::by_noise(data, &noise)?;
        Some((weights, Some(noise_source)))
    });
    match weights {
        Some(weights) => data.weighted(Some(weights), NextWeights::FromResidual),
        None => Ok(data.clone()),
    }
}

/// The fit of `data` without outlier lines, and the data that were fitted.
fn without_outliers<S: Source>(
    mut data: S,
    options: &FitOptions,
    watch: &Watch,
) -> Result<(S, FitToCheck), S::Stop> {
    loop {
        match identify(&data, options, outlier_lines(&data), watch)? {
            MethodRun::LeaveOut(lines) => data = data.without(&lines),
            MethodRun::Fitted(found) => return Ok((data, *found)),
        }
    }
}

/// Residual energy of each measured FRF times the square of its weight.
fn weighted_residual_energy(fitted: &DataLayout, found: &FitToCheck) -> Vec<f64> {
    fitted
        .pairs
        .iter()
        .zip(&found.residual_energy_of_frfs)
        .map(|(&pair, energy)| energy * fitted.weight_of(pair).powi(2))
        .collect()
}

/// The fit that follows another one.
enum NextFit {
    /// No further fit: this one stands.
    None,
    /// A fit with these weights from the residual; `next`: those that may be tried after it.
    Weighted {
        weights: PairWeights,
        next: NextWeights,
    },
    /// A fit without the weights that were taken from a residual.
    Unweighted,
    /// A fit without the weights by coherence; `finding`: the residual contradicts them.
    WithoutCoherence { finding: Option<Finding> },
}

/// The fit that follows `found` by the rules of [`walk`].
///
/// * `weighted_residual_energy`: of each FRF, as fitted
fn next_fit(fitted: &DataLayout, found: &FitToCheck, weighted_residual_energy: &[f64]) -> NextFit {
    let is_noise = found.residual != Residual::NotWhite;
    let error = found.fit.model.quality.relative_error;
    let unequal = PairWeights::if_unequal(fitted, weighted_residual_energy, error)
        .filter(|_| is_noise && fitted.next_weights != NextWeights::None);
    if fitted.next_weights == NextWeights::FromWeightedResidual && unequal.is_some() {
        // these replace the weights of this fit: they are of the measured FRFs
        let weights = PairWeights::by_noise(fitted, &found.residual_energy_of_frfs);
        if let Some(weights) = weights {
            let next = NextWeights::None;
            return NextFit::Weighted { weights, next };
        }
    }
    let Some(weighting) = &fitted.weighting else {
        let next = NextWeights::FromWeightedResidual;
        return unequal.map_or(NextFit::None, |weights| NextFit::Weighted { weights, next });
    };
    match weighting.noise_source {
        // the measured-data path has an error model of its own
        Some(NoiseSource::Coherence) if !is_noise || unequal.is_some() => {
            let finding = unequal.map(|_| coherence_contradicted());
            NextFit::WithoutCoherence { finding }
        }
        None if !is_noise => NextFit::Unweighted,
        _ => NextFit::None,
    }
}

/// Adds the weighting to the path of the model.
fn name_weighting(fitted: &DataLayout, model: &mut ModalModel) {
    if let Some(weighting) = &fitted.weighting {
        let words = weighting.words();
        let path = model.quality.path.take();
        model.quality.path = path.map(|path| format!("{path}; {words}"));
    }
}

/// Runs the checks of the data, then takes an exponential window off the poles.
/// `weighted_residual_energy`: of each FRF.
fn checked<S: Source>(
    fitted: &S,
    weighted_residual_energy: &[f64],
    options: &FitOptions,
    residual: Residual,
    model: &mut ModalModel,
) {
    model.quality.findings.extend(outliers::finding(fitted));
    let noise = Noise {
        variance: noise_variance(
            fitted,
            weighted_residual_energy,
            model.quality.relative_error,
        ),
        residual_energy_of_frfs: weighted_residual_energy,
    };
    examine(fitted, fitted.values(), options, residual, noise, model);
    if fitted.values().is_none() {
        model.quality.findings.push(not_checked());
    }
    if let Some(alpha) = options.exponential_window_per_s {
        exponential::undo(model, alpha);
    }
}

/// Noise variance of one work value: from the residual `energy` of weighted FRFs if it is known,
/// else from the relative error of the model.
fn noise_variance(data: &DataLayout, energy: &[f64], relative_error: f64) -> f64 {
    match data.weighting.is_some() && !energy.is_empty() {
        true => energy.iter().sum::<f64>() / (data.lines.len() * data.pairs.len()) as f64,
        false => (relative_error * data.measured_over_used()).powi(2),
    }
}

/// The finding where a coherence was given and not used.
fn coherence_contradicted() -> Finding {
    Finding::note(
        "coherence-contradicted",
        "the coherence of the set does not tell its noise: the residuals of the FRFs differ \
         otherwise; weighted by those instead",
    )
}

/// The checks that need single FRFs, where these are not at hand.
fn not_checked() -> Finding {
    Finding::note(
        "not-checked",
        "fitted in pieces; not checked: poles that move or split between FRFs, reciprocity, \
         window broadening, modes made by uneven noise",
    )
    .help("fit some blocks by themselves to see")
}

/// Outlier lines are left out at most [`OUTLIER_ROUNDS`] times, and never after FRFs were
/// weighted by a residual.
fn outlier_lines(data: &DataLayout) -> OutlierLines {
    let by_residual = |weighting: &Weighting| weighting.noise_source.is_none();
    match data.outlier_rounds < OUTLIER_ROUNDS && !data.weighting.as_ref().is_some_and(by_residual)
    {
        true => OutlierLines::LeaveOut,
        false => OutlierLines::Keep,
    }
}

/// Runs the method asked for; the default one where single FRFs are not at hand.
fn identify<S: Source>(
    data: &S,
    options: &FitOptions,
    outlier_lines: OutlierLines,
    watch: &Watch,
) -> Result<MethodRun, S::Stop> {
    let Some(values) = data.values() else {
        return auto(data, options, outlier_lines, watch);
    };
    let by = |method: Finder| -> Result<MethodRun, S::Stop> {
        let (model, stabilization) = fit_by_method(values, options, method, watch)?;
        Ok(MethodRun::not_judged(model, stabilization))
    };
    match options.method {
        Method::Auto => auto(data, options, outlier_lines, watch),
        Method::Lean => Ok(MethodRun::not_judged(
            fit_lean(values, options, watch)?,
            None,
        )),
        Method::Vf => by(vf),
        Method::Lscf => by(lscf),
        Method::Plscf => by(plscf),
        Method::Aaa => by(aaa),
        Method::Rfp | Method::Grfp => by(rfp),
        Method::Peak => by(peak),
        Method::Circle => by(circle),
    }
}

/// The fast chain with the order given.
fn fit_lean(data: &Screened, options: &FitOptions, watch: &Watch) -> Result<ModalModel, FitError> {
    watch.stage("sketch")?;
    let survey = Survey::new(data, options.seed);
    watch.stage("poles")?;
    let found = lean(survey, options)?;
    watch.stage("damping law")?;
    let identified = with_free_residues(data, found, options)?;
    watch.stage("shapes")?;
    let shaped = Shaped::new(data, identified, options.most_modes())?;
    let residual_energy = shaped.residual_energy(data);
    Ok(shaped.model(data, options, &residual_energy)?)
}
