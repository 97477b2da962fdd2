//! Mass-scaled shapes without a driving point.
//!
//! FRFs between responses S and references T, none of them shared, leave one factor of each
//! mode open: ψ_n|S → t·ψ_n, ψ_n|T → ψ_n/t changes none of them, the rigid-body residual
//! included (theory.md, section 15). The geometry of the plate closes it, by two routes of
//! `routes`: shapes go on smoothly from S to T (continuity), and their modal mass is 1
//! (mass). Their disagreement is the error bar. `rigid` reads what the rigid-body residual
//! does say: mass, inertia, gains of the channels, mass of the coils.

mod places;
mod rigid;
mod routes;

pub use rigid::RigidBody;

use crate::modes::PlateModes;
use crate::panel::Panel;
use crate::point_mass::PointMass;
use crate::point_spring::PointSpring;
use crate::tolerances;
use chladni_frf::{Error, Finding, ModalModel, Mode, Result, Scaling};
use places::Places;
use routes::{Routes, Scales};

/// Code of the finding that shapes have no scale.
const UNSCALED: &str = "unscaled";

/// A way to the scale of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScaleRoute {
    /// Shapes go on smoothly from the responses to the references.
    Continuity,
    /// The modal mass of each shape is 1.
    Mass,
}

impl ScaleRoute {
    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Continuity => "continuity",
            Self::Mass => "mass",
        }
    }
}

/// A model with mass-scaled shapes, and how they were found.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct PanelScale {
    /// The model; its FRFs are those of before.
    pub model: ModalModel,
    /// Rms over the modes in the band of what the routes say of ψψᵀ, relative.
    pub disagreement: f64,
    /// The panel as a rigid body; `None` where the band begins above the first mode.
    pub rigid: Option<RigidBody>,
}

/// Scales the shapes of `model` to unit modal mass by the geometry of `panel`.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`]: a DOF without a place on the panel or not normal to
/// it, references in volts, too few responses, no mode in the band, or routes that disagree
/// by more than 10 %: the panel is not the one that was measured.
pub fn scale_by_panel(model: &ModalModel, panel: &Panel, route: ScaleRoute) -> Result<PanelScale> {
    if model.reference_unit != chladni_frf::ReferenceUnit::Newton {
        return Err(
            Error::bad_data("a mass needs forces: the references are volts")
                .field("scaling")
                .found(model.reference_unit)
                .expected("references in N")
                .help("measure a driving point, or leave the scale open"),
        );
    }
    let places = Places::of(model)?;
    let rigid = RigidBody::of(model, &places, panel)?;
    let coils = rigid.as_ref().map_or(0.0, |body| body.coil_mass_kg);
    let coil_kg = match coils > 0.0 {
        true => coils,
        false => panel.references.mass_kg,
    };
    let ritz = plate_modes(model, panel, &places, coil_kg)?;
    let nominal_kg = panel.plate.mass() + coil_kg * places.references_m.len() as f64;
    let mass_ratio = rigid.as_ref().map_or(1.0, |body| body.mass_kg / nominal_kg);
    let routes = Routes::new(&ritz, &places, rigid.as_ref(), mass_ratio)?;
    let scales = model
        .modes
        .iter()
        .map(|mode| routes.scales(mode, &places))
        .collect::<Result<Vec<_>>>()?;
    let disagreement = disagreement(model, &scales)?;
    if disagreement.is_nan() || disagreement > tolerances::SCALE_DISAGREEMENT {
        return Err(disagree(disagreement, rigid.as_ref(), panel));
    }
    let mut scaled = model.clone();
    scaled.scaling = Scaling::UnitModalMass;
    let usual = usual_ratio(model, &scales, route);
    for (mode, scales) in scaled.modes.iter_mut().zip(&scales) {
        let factor = match (mode.in_band, scales) {
            (true, Some(scales)) => scales.of(route),
            _ => ratio(mode) * usual,
        };
        rescale(mode, factor.abs().sqrt(), disagreement);
    }
    let findings = &mut scaled.quality.findings;
    findings.retain(|finding| finding.code != UNSCALED);
    findings.push(told(route, disagreement, rigid.as_ref()));
    Ok(PanelScale {
        model: scaled,
        disagreement,
        rigid,
    })
}

/// Modes of the plate up to those of the band, with coils of `coil_kg` at the references.
fn plate_modes(
    model: &ModalModel,
    panel: &Panel,
    places: &Places,
    coil_kg: f64,
) -> Result<PlateModes> {
    let masses = places.references_m.iter().map(|&position_m| PointMass {
        position_m,
        mass_kg: coil_kg,
    });
    let top_hz = model
        .in_band_modes()
        .map(|mode| mode.frequency_hz)
        .fold(0.0, f64::max);
    let springs = places.references_m.iter().map(|&position_m| PointSpring {
        position_m,
        stiffness_n_per_m: panel.references.stiffness_n_per_m,
    });
    PlateModes::held(
        &panel.plate,
        &masses.collect::<Vec<_>>(),
        &springs.collect::<Vec<_>>(),
        top_hz,
        tolerances::MOST_SCALING_SHAPES,
    )
}

/// Rms of the references over the rms of the responses of a mode, squared: 1/t² of a shape
/// that moves both alike.
fn ratio(mode: &Mode) -> f64 {
    let square = |values: &[num_complex::Complex64]| {
        values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64
    };
    let [own, other] = [&mode.shape.0, &mode.participation.0].map(|values| square(values));
    match own > 0.0 && other > 0.0 {
        true => (other / own).sqrt(),
        false => 1.0,
    }
}

/// Median over the modes in the band of their factor over [`ratio`]: what poles outside the
/// band get, whose shapes stand for several modes.
fn usual_ratio(model: &ModalModel, scales: &[Option<Scales>], route: ScaleRoute) -> f64 {
    let own = counted(model).filter_map(|n| {
        let scales = scales[n].as_ref()?;
        Some(scales.of(route).abs() / ratio(&model.modes[n]))
    });
    let mut own: Vec<f64> = own.collect();
    own.sort_by(f64::total_cmp);
    own[own.len() / 2]
}

/// Numbers of the modes that count.
fn counted(model: &ModalModel) -> impl Iterator<Item = usize> + '_ {
    (0..model.modes.len()).filter(|&n| model.modes[n].counts())
}

/// Multiplies the shape, and divides the participation.
fn rescale(mode: &mut Mode, factor: f64, error: f64) {
    mode.shape.0.iter_mut().for_each(|value| *value *= factor);
    mode.participation
        .0
        .iter_mut()
        .for_each(|value| *value /= factor);
    // ψψᵀ errs by the disagreement and by what both routes share, ψ by half of it
    let of_scale = 0.5 * error.hypot(tolerances::SHARED_SCALE_ERROR);
    for (std, value) in mode.shape_std.iter_mut().zip(&mode.shape.0) {
        *std = (*std * factor).hypot(of_scale * value.norm());
    }
    mode.scale_std = Some(of_scale);
}

/// Rms difference of the routes over the modes in the band.
fn disagreement(model: &ModalModel, scales: &[Option<Scales>]) -> Result<f64> {
    let own: Vec<f64> = counted(model)
        .map(|n| scales[n].as_ref().map_or(f64::INFINITY, Scales::difference))
        .collect();
    if own.is_empty() {
        return Err(Error::bad_data("no mode to scale")
            .field("modes")
            .found("none in the band")
            .expected("at least one mode")
            .help("widen the band"));
    }
    Ok((own.iter().map(|d| d * d).sum::<f64>() / own.len() as f64).sqrt())
}

fn disagree(disagreement: f64, rigid: Option<&RigidBody>, panel: &Panel) -> Error {
    let found = match disagreement.is_finite() {
        true => format!("{:.0} % between continuity and mass", 100.0 * disagreement),
        false => "shapes whose signs contradict each other".into(),
    };
    let help = match rigid {
        Some(body) => format!(
            "check the panel: the residual says {:.4} kg and coils of {:.2} g, the panel {:.4} kg; \
             or measure a driving point",
            body.mass_kg,
            1e3 * body.coil_mass_kg,
            panel.plate.mass()
        ),
        None => "give the mass of the coils (references.mass_kg of the panel), begin the band \
                 below the first mode so that it can be found, or measure a driving point"
            .into(),
    };
    Error::bad_data("the shapes cannot be scaled by this panel")
        .field("scaling")
        .found(found)
        .expected(format!(
            "at most {:.0} %",
            100.0 * tolerances::SCALE_DISAGREEMENT
        ))
        .help(help)
}

fn told(route: ScaleRoute, disagreement: f64, rigid: Option<&RigidBody>) -> Finding {
    let mut words = format!(
        "shapes scaled by {} of the panel; the other route differs by {:.1} %",
        route.name(),
        100.0 * disagreement
    );
    if let Some(body) = rigid {
        words += &format!(
            "; the panel weighs {:.4} kg, each coil {:.2} g",
            body.mass_kg,
            1e3 * body.coil_mass_kg
        );
    }
    let finding = Finding::note("scaled-by-panel", words).value("disagreement", disagreement);
    match rigid {
        None => finding,
        Some(body) => finding
            .value("mass_kg", body.mass_kg)
            .value("coil_mass_kg", body.coil_mass_kg)
            .list("centre_m", body.centre_m)
            .list("inertia_kg_m2", body.inertia_kg_m2)
            .list("channel_gains", body.gains.iter().copied()),
    }
}
