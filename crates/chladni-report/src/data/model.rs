//! The modal model: facts in words, poles with bounds and reasons, and the numbers of its
//! synthesis.

use super::array::{complex, f64s};
use crate::sizes::SOURCES_LISTED;
use crate::text::{counted, plain, significant};
use chladni_frf::{Damping, ModalModel, Mode, Scaling, Source, Trust};
use chladni_rfp::{mean_phase_deviation_deg, modal_complexity_factor};
use serde_json::{json, Value};

/// The model as the page uses it.
pub(crate) fn value(model: &ModalModel, file: Option<&str>) -> Value {
    json!({
        "file": file,
        "facts": facts(model),
        "band_hz": model.band_hz,
        "damping": model.damping,
        "kind": model.frf_kind,
        "relative_error": model.quality.relative_error,
        "chi2_per_dof": model.quality.chi2_per_dof,
        "unit_modal_mass": model.scaling == Scaling::UnitModalMass,
        "source": model.source.first().map(|source| &source.file),
        "responses": model.responses,
        "references": model.references,
        "omega_scale": model.residual_terms.omega_scale_rad_per_s,
        "powers": model.residual_terms.terms.iter().map(|term| term.power).collect::<Vec<_>>(),
        "modes": model.modes.iter().map(mode).collect::<Vec<_>>(),
        "frequency_hz": f64s(model.modes.iter().map(|mode| &mode.frequency_hz)),
        "shapes": complex(model.modes.iter().flat_map(|mode| &mode.shape.0)),
        "participations": complex(model.modes.iter().flat_map(|mode| &mode.participation.0)),
    })
}

fn mode(mode: &Mode) -> Value {
    json!({
        "frequency_hz": mode.frequency_hz,
        "frequency_std_hz": mode.frequency_std_hz,
        "loss_factor": mode.loss_factor,
        "loss_factor_std": mode.loss_factor_std,
        "in_band": mode.in_band,
        "trust": mode.trust,
        "reasons": mode.reasons.sentences(),
        "mpc": mode.mpc,
        "mpd_deg": mean_phase_deviation_deg(&mode.shape.0),
        "mcf": modal_complexity_factor(&mode.shape.0),
    })
}

/// Facts on the model and its quality: pairs of a label and a text.
fn facts(model: &ModalModel) -> Vec<[String; 2]> {
    let damping = match model.damping {
        Damping::Structural => "structural (hysteretic): loss factor η",
        Damping::Viscous => "viscous: η = 2ζ",
    };
    let scaling = match model.scaling {
        Scaling::UnitModalMass => "unit modal mass",
        Scaling::Unscaled => {
            "unscaled (no driving point): shapes have largest motion 1, \
                              participations carry the rest"
        }
    };
    let path = model
        .quality
        .path
        .as_ref()
        .map(|path| format!("; {path}"))
        .unwrap_or_default();
    let mut rows = vec![
        ("Source", sources(&model.source)),
        (
            "FRFs",
            format!(
                "{} in {}, {} × {}",
                model.frf_kind,
                model.frf_kind.unit(model.reference_unit).replace("^2", "²"),
                counted(model.responses.len(), "response"),
                counted(model.references.len(), "reference")
            ),
        ),
        (
            "Fitted band",
            format!(
                "{} to {} Hz",
                plain(model.band_hz[0]),
                plain(model.band_hz[1])
            ),
        ),
        ("Method", format!("{}{path}", model.method)),
        ("Found", modes_found(model)),
        ("Damping", damping.into()),
        ("Scaling", scaling.into()),
        (
            "Misfit",
            format!(
                "{} % of the data's rms; χ² per degree of freedom {}",
                significant(100.0 * model.quality.relative_error, 3),
                significant(model.quality.chi2_per_dof, 4)
            ),
        ),
    ];
    if !model.quality.trusted {
        rows.push(("Doubt", "not to be used as it is: see the findings".into()));
    }
    let named = |(word, text): (&str, String)| [word.to_owned(), text];
    rows.into_iter().map(named).collect()
}

/// Numbers of modes in the band and of poles outside, in words.
fn modes_found(model: &ModalModel) -> String {
    let (sure, weak) = (count(model, Trust::Sure), count(model, Trust::Weak));
    let outside = model
        .modes
        .iter()
        .filter(|mode| !mode.in_band && mode.trust != Trust::Rejected)
        .count();
    let mut modes = counted(sure + weak, "mode");
    if weak > 0 {
        modes += &format!(" ({sure} sure, {weak} weak)");
    }
    if outside > 0 {
        modes += &format!(", and {} outside the band", counted(outside, "pole"));
    }
    modes
}

/// The source files in words: a few with their hashes, of many the first ones without.
fn sources(sources: &[Source]) -> String {
    match sources {
        [] => "not recorded".into(),
        few if few.len() <= SOURCES_LISTED => few
            .iter()
            .map(|source| format!("{} ({})", source.file, source.checksum))
            .collect::<Vec<_>>()
            .join(", "),
        many => {
            let first: Vec<&str> = many
                .iter()
                .take(SOURCES_LISTED)
                .map(|source| source.file.as_str())
                .collect();
            format!(
                "{} and {} more",
                first.join(", "),
                many.len() - SOURCES_LISTED
            )
        }
    }
}

fn count(model: &ModalModel, trust: Trust) -> usize {
    model
        .in_band_modes()
        .filter(|mode| mode.trust == trust)
        .count()
}
