//! What the poles found say of the structure: the damping law, and whether one shape per
//! mode, real or not, serves all references.

use crate::damping::verdict::{chance, choose, contradicted as contradicted_words, undecidable};
use crate::data::layout::DataLayout;
use crate::data::options::{FitOptions, ShapeModel};
use crate::model::build::common_shapes;
use crate::model::identified::Identified;
use crate::poles::estimate::PoleEstimate;
use crate::shapes::search::{structured, Search};
use crate::tolerances as tol;
use chladni_frf::Damping;
use chladni_linalg::LinalgError;

/// Where the residual is not noise, one damping law must explain this share of it to be
/// preferred.
const LAW_SHARE: f64 = 0.05;

/// Poles of the law that the data prefer, or that is asked for, structured where that
/// holds; with what is to be said of it.
pub(crate) fn decide(
    data: &DataLayout,
    found: PoleEstimate,
    options: &FitOptions,
    progress: &dyn Fn(&str),
) -> Result<(Identified, Vec<String>), LinalgError> {
    progress("damping law");
    let chance = chance(&found.work, found.variance);
    let measured = found.measured;
    let least_gain = if measured {
        chance.max(LAW_SHARE * found.refined.projection.sse)
    } else {
        chance
    };
    let choice = choose(
        &found.work,
        &found.refined,
        least_gain,
        measured.then(|| found.heaviest_sure()),
        options.damping,
    )?;
    progress("shapes");
    let (law, mut contradicted) = (choice.law, choice.contradicted);
    // where no rival is fitted because such line shapes cannot tell
    let mut undecided =
        measured && found.heaviest_sure() < tol::LAW_ALIKE && !found.refined.lambda.is_empty();
    let other = choice
        .rival
        .map(|rival| Identified::new(found.clone(), rival))
        .transpose()?;
    let (refined, mut unlike) = match shape_search(data, &found, options, law.damping)? {
        Search::Found(structured) => (Some(structured), None),
        Search::Refused(sigmas) => (None, Some(sigmas)),
        Search::Inapplicable => (None, None),
    };
    let mut identified = Identified::new(found, law)?;
    if let Some(other) = other {
        // one shape for all references tells the laws apart where free residues absorb
        // the difference; so does one real shape, which the wrong law does not admit. A
        // mode that only structured refinement saw has to pay for itself
        let real = refined.as_ref().filter(|structured| structured.real);
        let own = real.map_or(f64::INFINITY, |structured| {
            structured.sse + structured.added as f64 * chance
        });
        let gain =
            own.min(common_shapes(data, &identified)?.sse) - common_shapes(data, &other)?.sse;
        undecided = gain.abs() <= least_gain;
        if gain > least_gain && options.damping.is_none() {
            identified = other;
        } else {
            contradicted |= gain > least_gain;
        }
    }
    let mut warnings = Vec::new();
    if contradicted {
        warnings.push(contradicted_words(identified.damping));
    }
    if identified.damping == Damping::Viscous && !measured {
        unlike = Some(common_shapes(data, &identified)?.sigmas)
            .filter(|sigmas| *sigmas > tol::STRUCTURE_SIGMAS);
    }
    warnings.extend(unlike.map(|sigmas| {
        format!(
            "one shape per mode does not explain all references together ({sigmas:.0} sigma beyond chance): modes may hide in each other's \
             overlap, or the references were not measured alike"
        )
    }));
    let shift = identified.shift_by_other_law();
    if undecided && shift > 1.0 {
        warnings.push(undecidable(identified.damping, shift));
    }
    if let Some(structured) = refined.filter(|_| identified.damping == Damping::Structural) {
        identified = identified.structured(structured);
    }
    Ok((identified, warnings))
}

/// Structured refinement where it applies: asked for, or the residual is noise that
/// chance can be judged by.
fn shape_search(
    data: &DataLayout,
    found: &PoleEstimate,
    options: &FitOptions,
    damping: Damping,
) -> Result<Search, LinalgError> {
    let forced = matches!(options.shapes, ShapeModel::Rank1 | ShapeModel::Real);
    if damping == Damping::Viscous || (found.measured && !forced) {
        return Ok(Search::Inapplicable);
    }
    structured(data, found, options.shapes, options.modes.is_some())
}
