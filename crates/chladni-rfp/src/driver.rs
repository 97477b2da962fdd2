//! The fit: screen, find poles, choose the damping law, residues, shapes, model.

use crate::checks::examine::examine;
use crate::damping::structural::POWERS;
use crate::data::error::FitError;
use crate::data::given_noise::{given_noise, Giver};
use crate::data::layout::DataLayout;
use crate::data::options::{FitOptions, Method};
use crate::data::pair_weights::PairWeights;
use crate::data::products::{project, Projected};
use crate::data::screening::Screened;
use crate::data::{outliers, window};
use crate::measured::path::measured_path;
use crate::methods::aaa::aaa;
use crate::methods::bars::fit_by_method;
use crate::methods::circle::circle;
use crate::methods::found::Finder;
use crate::methods::found::Stabilization;
use crate::methods::grfp::grfp;
use crate::methods::lean::lean;
use crate::methods::lscf::lscf;
use crate::methods::peak::peak;
use crate::methods::plscf::plscf;
use crate::methods::rfp::rfp;
use crate::methods::survey::Survey;
use crate::methods::vf::vf;
use crate::model::build::Shaped;
use crate::model::decide::decide;
use crate::model::exponential;
use crate::model::identified::Identified;
use crate::model::in_law::in_law;
use crate::poles::chain::{fast_chain, Chain, Doubt, Outcome};
use crate::poles::estimate::{graded, more_than_asked, PoleEstimate};
use crate::poles::refine::{refine, Projection, Refined};
use chladni_frf::{Damping, Finding, FrfSet, ModalModel};
use chladni_linalg::blocked::in_pool;
use chladni_linalg::LinalgError;

/// A fit with its history.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model, ready to be saved.
    pub model: ModalModel,
    /// Orders tried: (poles, residual variance relative to the data's mean square), in
    /// order.
    pub history: Vec<(usize, f64)>,
    /// Poles by order, where the method looks at several.
    pub stabilization: Option<Stabilization>,
}

/// Identifies the modes in `frf`.
///
/// `progress` is told the name of each stage as it begins.
///
/// # Errors
/// [`FitError`]: unknown kind, a band outside the data, too few lines, no data, a window
/// that cannot be undone on these lines. A fit that was made but cannot be trusted is no
/// error: `model.quality.trusted` says so, with the reasons in its warnings.
pub fn fit(
    frf: &FrfSet,
    options: &FitOptions,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Fit, FitError> {
    in_pool(|| fit_here(frf, options, progress))
}

fn fit_here(frf: &FrfSet, options: &FitOptions, progress: &dyn Fn(&str)) -> Result<Fit, FitError> {
    let unbiased = options
        .window
        .map_or(Ok(None), |window| window::undo(frf, window))?;
    let frf = unbiased.as_ref().unwrap_or(frf);
    let screened = Screened::new(frf, options)?;
    let known = given_noise(&screened)
        .and_then(|(noise, giver)| Some((PairWeights::of_given(&screened, &noise)?, giver)));
    weighted_fit(screened, known, options, progress)
}

/// Fits data whose noise is `known`, or with weights as the residual tells them.
fn weighted_fit(
    screened: Screened,
    known: Option<(PairWeights, Giver)>,
    options: &FitOptions,
    progress: &dyn Fn(&str),
) -> Result<Fit, FitError> {
    let weighted = known
        .as_ref()
        .map(|(weights, _)| weights.applied(screened.frf));
    let mut data = match (&known, &weighted) {
        (Some((weights, _)), Some(weighted)) => screened.weighted(weighted, weights.clone()),
        _ => screened.clone(),
    };
    let mut dropped = Vec::new();
    let mut rounds = 0;
    let (mut fit, white, left) = loop {
        match identify(&data, options, rounds < OUTLIER_ROUNDS, progress)? {
            Attempt::Outliers(places) => {
                dropped.extend(places.iter().map(|&place| data.line_hz[place]));
                data = data.without(&places);
                rounds += 1;
            }
            Attempt::Fitted(fit, white, left) => break (*fit, white, left),
        }
    };
    // what is left in measured units, seen with the weights
    let seen: Vec<f64> = data
        .pairs
        .iter()
        .zip(&left)
        .map(|(&(i, j), left)| left * data.weight(i, j).iter().product::<f64>().powi(2))
        .collect();
    let still_unequal =
        PairWeights::new(&data, &seen, fit.model.quality.relative_error).filter(|_| white);
    match (known, still_unequal) {
        // the measured-data path has an error model of its own
        (Some((_, Giver::Coherence)), unequal) if !white || unequal.is_some() => {
            let mut fit = weighted_fit(screened, None, options, progress)?;
            fit.model
                .quality
                .findings
                .extend(unequal.map(|_| coherence_contradicted()));
            return Ok(fit);
        }
        (Some((weights, giver)), _) => {
            fit.model.quality.path = fit
                .model
                .quality
                .path
                .map(|path| format!("{path}; {}, as {}", weights.words(), giver.words()));
        }
        (None, Some(weights)) => {
            progress("FRFs weighted by their noise");
            let weighted = weights.applied(data.frf);
            if let Attempt::Fitted(mut again, true, _) = identify(
                &data.weighted(&weighted, weights.clone()),
                options,
                false,
                progress,
            )? {
                again.model.quality.path = again
                    .model
                    .quality
                    .path
                    .map(|path| format!("{path}; {}", weights.words()));
                fit = *again;
            }
        }
        (None, None) => {}
    }
    if !dropped.is_empty() {
        fit.model
            .quality
            .findings
            .push(outliers::words(&data, &mut dropped));
    }
    examine(&data, Some(&data), options, white, &mut fit.model);
    if let Some(alpha) = options.exponential_window_per_s {
        exponential::undo(&mut fit.model, alpha);
    }
    Ok(fit)
}

/// The finding where a coherence was given and not used.
fn coherence_contradicted() -> Finding {
    Finding::note(
        "coherence-contradicted",
        "the coherence of the set does not tell its noise: the residuals of the FRFs differ \
         otherwise; weighted by those instead",
    )
}

/// Rounds of leaving out outlier lines and fitting again: the second finds those that hid
/// beside the first.
pub(crate) const OUTLIER_ROUNDS: usize = 5;

/// What a run of a method came to.
enum Attempt {
    /// A fit, whether its residual is white, and the sum of squares left of each FRF
    /// where that tells its noise.
    Fitted(Box<Fit>, bool, Vec<f64>),
    /// Lines (positions among those used) that must go first.
    Outliers(Vec<usize>),
}

impl Attempt {
    /// A fit whose checks go by the noise that it found.
    fn whole(fit: Fit) -> Self {
        Self::Fitted(Box::new(fit), true, Vec::new())
    }
}

/// Runs the method asked for. Outlier lines end a run only where they are `sought`.
fn identify(
    data: &Screened,
    options: &FitOptions,
    sought: bool,
    progress: &dyn Fn(&str),
) -> Result<Attempt, FitError> {
    let by = |method: Finder| {
        let (model, stabilization) = fit_by_method(data, options, method, progress)?;
        let history = Vec::new();
        Ok(Attempt::whole(Fit {
            model,
            history,
            stabilization,
        }))
    };
    match options.method {
        Method::Auto => fit_auto(data, options, sought, progress),
        Method::Lean => Ok(Attempt::whole(fit_lean(data, options, progress)?)),
        Method::Vf => by(vf),
        Method::Lscf => by(lscf),
        Method::Plscf => by(plscf),
        Method::Aaa => by(aaa),
        Method::Rfp => by(|survey, _, options| Ok(rfp(survey, options)?.into())),
        Method::Grfp => by(|survey, _, options| Ok(grfp(survey, options)?.into())),
        Method::Peak => by(peak),
        Method::Circle => by(circle),
    }
}

/// The fast chain with the order given.
fn fit_lean(
    data: &Screened,
    options: &FitOptions,
    progress: &dyn Fn(&str),
) -> Result<Fit, FitError> {
    progress("sketch");
    let survey = Survey::new(data, options.seed);
    progress("poles");
    let mut found = lean(&survey, options)?;
    progress("shapes");
    if options.damping == Some(Damping::Viscous) {
        found = in_law(found, Damping::Viscous, None)?;
    }
    let shaped = Shaped::new(data, Identified::new(found))?;
    let left = shaped.left(data);
    let model = shaped.model(data, options, &left);
    Ok(Fit {
        model,
        history: Vec::new(),
        stabilization: None,
    })
}

fn fit_auto(
    data: &Screened,
    options: &FitOptions,
    sought: bool,
    progress: &dyn Fn(&str),
) -> Result<Attempt, FitError> {
    let (found, history) = match chain(data, options, progress)? {
        Outcome::White(chain) => {
            let history = chain.history.clone();
            (from_chain(*chain, options.modes, data.hz()), history)
        }
        Outcome::Ended(Doubt::Outliers(lines)) if sought => return Ok(Attempt::Outliers(lines)),
        Outcome::Ended(Doubt::Conjugated) => (from_conjugated(data, options)?, Vec::new()),
        Outcome::Ended(doubt) => (
            from_measured(data, options, &doubt.words(), progress)?,
            Vec::new(),
        ),
    };
    let measured = found.measured;
    let again = |found: PoleEstimate, law: Damping| match found.measured {
        true => in_law(found, law, None),
        false => match fast_chain(&data.in_law(law), options.seed, options.modes, progress)? {
            Outcome::White(chain) => Ok(from_chain(*chain, options.modes, data.hz())),
            Outcome::Ended(_) => in_law(found, law, Some(data.pairs.len())),
        },
    };
    let (model, left) = finished(data, found, options, progress, again, |shaped| {
        shaped.left(data)
    })?;
    let outliers = if sought && measured {
        outliers::outliers(data, &model)
    } else {
        Vec::new()
    };
    match outliers.is_empty() {
        true => Ok(Attempt::Fitted(
            Box::new(Fit {
                model,
                history,
                stabilization: None,
            }),
            !measured,
            left,
        )),
        false => Ok(Attempt::Outliers(outliers)),
    }
}

/// The fast chain in the law asked for, in the structural one where none is; in the other
/// where what that leaves is no noise.
fn chain(
    data: &Screened,
    options: &FitOptions,
    progress: &dyn Fn(&str),
) -> Result<Outcome, LinalgError> {
    let in_law = |law| fast_chain(&data.in_law(law), options.seed, options.modes, progress);
    let law = options.damping.unwrap_or(Damping::Structural);
    let first = in_law(law)?;
    let Outcome::Ended(Doubt::NotWhite(_)) = first else {
        return Ok(first);
    };
    let other = in_law(match law {
        Damping::Structural => Damping::Viscous,
        Damping::Viscous => Damping::Structural,
    })?;
    Ok(match other {
        Outcome::White(_) => other,
        Outcome::Ended(_) => first,
    })
}

/// The model that poles lead to, and what it leaves of each FRF; `again`: the poles in
/// another law.
pub(crate) fn finished(
    data: &DataLayout,
    found: PoleEstimate,
    options: &FitOptions,
    progress: &dyn Fn(&str),
    again: impl Fn(PoleEstimate, Damping) -> Result<PoleEstimate, LinalgError>,
    left: impl Fn(&Shaped) -> Vec<f64>,
) -> Result<(ModalModel, Vec<f64>), LinalgError> {
    let (identified, mut warnings) = decide(data, found, options, progress, &again)?;
    let shaped = Shaped::new(data, identified)?;
    let left = left(&shaped);
    let mut model = shaped.model(data, options, &left);
    if model.quality.relative_error > MOSTLY_LEFT {
        warnings.push(
            Finding::caution(
                "mostly-unexplained",
                format!(
                    "the model leaves {:.0} % of the data: most of this band holds noise, or \
                     motion that no resonance explains",
                    100.0 * model.quality.relative_error
                ),
            )
            .value("relative_error", model.quality.relative_error)
            .help("fit the band in which peaks stand clear of the noise"),
        );
    }
    model.quality.findings.append(&mut warnings);
    model.number_findings();
    Ok((model, left))
}

/// Residual over data beyond which the band as a whole is not explained, whatever single
/// peaks are.
const MOSTLY_LEFT: f64 = 0.5;

pub(crate) fn from_chain(chain: Chain, asked: Option<usize>, hz: f64) -> PoleEstimate {
    let (grades, spread) = graded(&chain.refined, &chain.projected.work, chain.variance);
    PoleEstimate {
        grades,
        spread,
        measured: false,
        work: chain.projected.work,
        back: Some(chain.projected.back),
        variance: chain.variance,
        path: format!("fast chain: {}", chain.whiteness.evidence),
        warnings: asked
            .and_then(|asked| more_than_asked(asked, &chain.dropped, hz))
            .into_iter()
            .collect(),
        consistent: true,
        refined: chain.refined,
    }
}

fn from_conjugated(data: &Screened, options: &FitOptions) -> Result<PoleEstimate, FitError> {
    let (sketch, energy) = data.sketch(options.seed);
    Ok(conjugated(project(
        data,
        &Projection::new(&sketch, &[], &POWERS)?.q,
        &energy,
    )?)?)
}

/// No modes: the data contradict any passive structure in e^{+jωt}; they are not
/// corrected without being told.
pub(crate) fn conjugated(projected: Projected) -> Result<PoleEstimate, LinalgError> {
    let refined = refine(&projected.work, &[], &POWERS, 0, 0.0)?;
    let variance = refined.variance(&projected.work);
    Ok(PoleEstimate {
        refined,
        work: projected.work,
        back: Some(projected.back),
        variance,
        spread: Vec::new(),
        measured: true,
        grades: Vec::new(),
        path: "stopped after the pole pool".into(),
        warnings: vec![Finding::fault(
            "conjugated",
            "every resonance turns the wrong way: the data follow e^(-jwt)",
        )
        .help("read the data with the other time sign")],
        consistent: false,
    })
}

fn from_measured(
    data: &Screened,
    options: &FitOptions,
    evidence: &str,
    progress: &dyn Fn(&str),
) -> Result<PoleEstimate, FitError> {
    let found = measured_path(data, options.seed, options.modes, progress)?;
    let (refined, work, back) = match found.back {
        Some(back) => (found.refined, found.work, back),
        None => {
            // the path ran on mixtures: residues come from one pass over all FRFs
            let Refined { lambda, powers, .. } = &found.refined;
            let (sketch, energy) = data.sketch(options.seed);
            let projected = project(data, &Projection::new(&sketch, lambda, powers)?.q, &energy)?;
            (
                refine(&projected.work, lambda, powers, 0, 0.0)?,
                projected.work,
                projected.back,
            )
        }
    };
    let variance = refined.variance(&work);
    Ok(PoleEstimate {
        refined,
        work,
        back: Some(back),
        variance,
        spread: found.variance,
        measured: true,
        grades: found.grades,
        path: format!("measured-data path: {evidence}"),
        warnings: found.warnings,
        consistent: true,
    })
}
