//! The fit: screen, find poles, choose the damping law, residues, shapes, model.

use crate::error::FitError;
use crate::law::{chance, choose, Law, UNDECIDABLE};
use crate::measured::measured_path;
use crate::methods::{grfp, rfp, ClassicPoles};
use crate::model::{uncertainty_grade, Found, Identified, Pole, Shaped, UNCERTAIN};
use crate::options::{FitOptions, Method, ShapeModel};
use crate::order::{fast_chain, Chain, Outcome, POWERS};
use crate::project::project;
use crate::refine::{refine, Projection};
use crate::screen::Screened;
use crate::structured::{structured, Structured};
use chladni_frf::{Damping, FrfSet, ModalModel, Trust};
use chladni_linalg::{inverse_hermitian, LinalgError};
use num_complex::Complex64;

/// A fit with its history.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model, ready to be saved.
    pub model: ModalModel,
    /// Orders tried: (poles, residual variance relative to the data's mean square), in order.
    pub history: Vec<(usize, f64)>,
}

/// Identifies the modes in `frf`.
///
/// `progress` is told the name of each stage as it begins.
///
/// # Errors
/// [`FitError`]: unknown kind, a band outside the data, too few lines, no data. A fit that was made but cannot be trusted is
/// no error: `model.quality.trusted` says so, with the reasons in its warnings.
pub fn fit(frf: &FrfSet, options: &FitOptions, progress: &dyn Fn(&str)) -> Result<Fit, FitError> {
    let data = Screened::new(frf, options)?;
    match options.method {
        Method::Auto => fit_auto(&data, options, progress),
        Method::Rfp => fit_classic(&data, options, rfp, progress),
        Method::Grfp => fit_classic(&data, options, grfp, progress),
    }
}

/// Poles of a classic method, residues of every FRF by least squares at these poles.
fn fit_classic(
    data: &Screened,
    options: &FitOptions,
    method: fn(&Screened, &FitOptions) -> Result<ClassicPoles, FitError>,
    progress: &dyn Fn(&str),
) -> Result<Fit, FitError> {
    progress("poles");
    let classic = method(data, options)?;
    progress("residues");
    let damping = options.damping.unwrap_or(Damping::Viscous);
    let lambda: Vec<Complex64> = classic.poles.iter().map(|s| -s * s).collect();
    let (sketch, energy) = data.sketch(options.seed);
    let q = Projection::new(&sketch, &lambda, &POWERS)?.q;
    let projected = project(data, &q, &energy)?;
    let dof = (data.lines.len() - q.ncols().min(data.lines.len() - 1)) * data.pairs.len();
    let variance = projected.line_residual.sum() / dof as f64;
    let poles = classic
        .poles
        .iter()
        .zip(&lambda)
        .zip(&classic.deviation)
        .map(|((&s, &lambda), &[omega_std, loss_factor_std])| {
            let (omega, loss_factor) = match damping {
                Damping::Viscous => (s.norm(), -2.0 * s.re / s.norm()),
                Damping::Structural => (lambda.re.max(0.0).sqrt(), lambda.im / lambda.re),
            };
            let uncertain = 2.0 * omega_std / (omega * loss_factor);
            let grade = if uncertain > UNCERTAIN {
                (Trust::Weak, vec![format!("uncertain by {uncertain:.1} half-bandwidths (one sigma)")])
            } else {
                (Trust::Sure, Vec::new())
            };
            let value = if damping == Damping::Viscous { s } else { lambda };
            Pole { value, omega, loss_factor, omega_std, loss_factor_std, grade, given: None }
        })
        .collect();
    let identified = Identified {
        damping,
        poles,
        powers: POWERS.to_vec(),
        work: projected.work,
        back: Some(projected.back),
        variance,
        path: format!("{}: linear equation error in orthogonal polynomials, no maximum-likelihood step", options.method),
        warnings: classic.warnings,
        consistent: true,
        real_shapes: false,
    };
    let mut model = Shaped::new(data, identified)?.model(data, options);
    if model.quality.relative_error > CLASSIC_RESIDUAL {
        model.quality.trusted = false;
        model.quality.warnings.push(format!(
            "{:.0} % of the data are left unexplained: modes are missing or wrong; use --method auto, or a narrower --band",
            100.0 * model.quality.relative_error
        ));
    }
    Ok(Fit { model, history: Vec::new() })
}

/// Rms residual over rms data beyond which a classic fit is not trusted: it has no other way to know that it failed.
const CLASSIC_RESIDUAL: f64 = 0.2;

fn fit_auto(data: &Screened, options: &FitOptions, progress: &dyn Fn(&str)) -> Result<Fit, FitError> {
    let (found, history) = match fast_chain(data, options.seed, options.modes, progress)? {
        Outcome::White(chain) => {
            let history = chain.history.clone();
            (from_chain(*chain), history)
        }
        Outcome::NotWhite(evidence) => (from_measured(data, options, &evidence, progress)?, Vec::new()),
        Outcome::Conjugated => (from_conjugated(data, options)?, Vec::new()),
    };
    progress("damping law");
    let chance = chance(&found.work, found.variance);
    let measured = found.spread.is_some();
    let least_gain = if measured { chance.max(LAW_SHARE * found.refined.projection.sse) } else { chance };
    let mut law = choose(&found.work, &found.refined, least_gain, measured.then(|| found.heaviest_sure()), options.damping)?;
    progress("shapes");
    let undecided = law.undecided.take();
    let open = options.damping.is_none() && law.damping == Damping::Structural && !found.refined.lambda.is_empty();
    let twin = undecided.map(|fit| Law { damping: Damping::Viscous, viscous: Some(fit), undecided: None });
    let freedom = found.variance * (found.work.lines() * found.work.columns()) as f64;
    let other = twin.map(|twin| Identified::new(found.clone(), twin)).transpose()?;
    let refined = shape_search(data, &found, options, law.damping, measured)?;
    let mut shaped = Shaped::new(data, Identified::new(found, law)?)?;
    let mut warnings = Vec::new();
    match other.map(|other| Shaped::new(data, other)).transpose()? {
        // one shape for all references tells the laws apart where free residues absorb the difference
        Some(other) if (shaped.chi2_per_dof - other.chi2_per_dof) * freedom > least_gain => shaped = other,
        Some(other) if (other.chi2_per_dof - shaped.chi2_per_dof) * freedom > least_gain => {}
        Some(_) => warnings.push(UNDECIDABLE.to_string()),
        None if open && measured => warnings.push(UNDECIDABLE.to_string()),
        None => {}
    }
    if let Some(structured) = refined.filter(|_| shaped.damping() == Damping::Structural) {
        shaped = Shaped::new(data, shaped.into_identified().structured(structured))?;
    }
    let mut model = shaped.model(data, options);
    model.quality.warnings.append(&mut warnings);
    Ok(Fit { model, history })
}

/// Structured refinement where it applies: asked for, or the residual is noise that chance can be judged by.
fn shape_search(
    data: &Screened,
    found: &Found,
    options: &FitOptions,
    damping: Damping,
    measured: bool,
) -> Result<Option<Structured>, LinalgError> {
    let forced = matches!(options.shapes, ShapeModel::Rank1 | ShapeModel::Real);
    if damping == Damping::Viscous || (measured && !forced) {
        return Ok(None);
    }
    structured(data, found, options.shapes, options.modes.is_some())
}

/// Where the residual is not noise, one damping law must explain this share of it to be preferred.
const LAW_SHARE: f64 = 0.05;

fn from_chain(chain: Chain) -> Found {
    let work = &chain.projected.work;
    let inverse = inverse_hermitian(chain.refined.information.view()).ok();
    let grades = (0..chain.refined.lambda.len())
        .map(|q| {
            let pole = chain.refined.lambda[q];
            let deviation = inverse.as_ref().map_or(f64::INFINITY, |c| (chain.variance * c[[q, q]].re).max(0.0).sqrt());
            if work.in_band(pole) {
                uncertainty_grade(pole, [0.5 * deviation.powi(2); 2])
            } else {
                (Trust::Sure, Vec::new())
            }
        })
        .collect();
    Found {
        grades,
        work: chain.projected.work,
        back: Some(chain.projected.back),
        variance: chain.variance,
        spread: None,
        path: format!("fast chain: {}", chain.whiteness.evidence),
        warnings: Vec::new(),
        consistent: true,
        refined: chain.refined,
    }
}

/// No modes: the data contradict any passive structure in e^{+jωt}; they are not corrected without being told.
fn from_conjugated(data: &Screened, options: &FitOptions) -> Result<Found, FitError> {
    let (sketch, energy) = data.sketch(options.seed);
    let projected = project(data, &Projection::new(&sketch, &[], &POWERS)?.q, &energy)?;
    let refined = refine(&projected.work, &[], &POWERS, 0, 0.0)?;
    let variance = refined.variance(&projected.work);
    Ok(Found {
        refined,
        work: projected.work,
        back: Some(projected.back),
        variance,
        spread: Some(Vec::new()),
        grades: Vec::new(),
        path: "stopped after the pole pool".into(),
        warnings: vec!["every resonance turns the wrong way: the data follow e^(-jwt); read them with --time-sign -".into()],
        consistent: false,
    })
}

fn from_measured(data: &Screened, options: &FitOptions, evidence: &str, progress: &dyn Fn(&str)) -> Result<Found, FitError> {
    let found = measured_path(data, options.seed, options.modes, progress)?;
    let variance = found.refined.variance(&found.work);
    let (work, back) = match found.back {
        Some(back) => (found.work, Some(back)),
        None => {
            // the path ran on mixtures: residues come from one pass over all FRFs
            let (sketch, energy) = data.sketch(options.seed);
            let all = Projection::new(&sketch, &found.refined.lambda, &found.refined.powers)?;
            let projected = project(data, &all.q, &energy)?;
            (projected.work, Some(projected.back))
        }
    };
    let variance = if work.columns() == found.refined.projection.residual.ncols() {
        variance
    } else {
        Projection::new(&work, &found.refined.lambda, &found.refined.powers)?.sse / (work.lines() * work.columns()) as f64
    };
    Ok(Found {
        refined: found.refined,
        work,
        back,
        variance,
        spread: Some(found.variance),
        grades: found.grades,
        path: format!("measured-data path: {evidence}"),
        warnings: found.warnings,
        consistent: true,
    })
}
