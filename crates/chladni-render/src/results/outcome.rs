//! The outcome of a drive in its scene, and the weights file that says so.

use crate::judging::indices::{AreaIndices, Indices, PointIndices};
use crate::methods::method::Method;
use crate::panel::drive::Drive;
use crate::panel::field::{AreaField, Field};
use crate::problems::setup::Setup;
use crate::results::weights::{weight_list, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
use crate::scene::scene_file::Scene;
use chladni_frf::{Result, CREATED_BY};

/// The field of a drive, and its indices.
pub(crate) struct Outcome {
    /// Velocities at the responses.
    pub(crate) field: Field,
    /// Velocities between them; `None` where they carry no area.
    pub(crate) area: Option<AreaField>,
    pub(crate) indices: Indices,
}

impl Outcome {
    /// Judges `drive` in the model of `setup`.
    ///
    /// # Errors
    /// As [`PointIndices::of_field`].
    pub(crate) fn of(setup: &Setup, drive: &Drive) -> Result<Self> {
        let (zones, limits) = (&setup.zones, &setup.limits);
        let field = Field::new(&setup.operator, zones, drive);
        let area = setup
            .nodes()
            .and_then(|nodes| field.area_from(nodes, zones));
        let points = PointIndices::of_field(&field, zones, limits, drive, setup.operator.unit)?;
        let of_area = |area| AreaIndices::of_area(area, zones, limits);
        let indices = Indices {
            points,
            area: area.as_ref().map(of_area),
        };
        Ok(Self {
            field,
            area,
            indices,
        })
    }

    /// True where every response keeps its limit.
    pub(crate) fn is_feasible(&self) -> bool {
        self.indices.points.min_ratio == 1.0
    }

    /// The weights file of the drive; what only some drives have is left open.
    pub(crate) fn weights(
        &self,
        setup: &Setup,
        scene: &Scene,
        drive: &Drive,
        method: Method,
    ) -> Weights {
        let kappa = setup.problem.score(drive).kappa;
        Weights {
            format: WEIGHTS_FORMAT.into(),
            version: WEIGHTS_VERSION,
            created_by: CREATED_BY.into(),
            source: Vec::new(),
            options: Default::default(),
            frequency_hz: scene.frequency_hz,
            method: method.to_string(),
            scene: scene.name(),
            weights: weight_list(&setup.operator.references, drive, setup.operator.unit),
            modes_used: setup.modes.len(),
            actuators_used: drive.iter().filter(|weight| weight.norm() > 0.0).count(),
            feasible: self.is_feasible(),
            ceiling: None,
            kappa: Some(kappa).filter(|kappa| kappa.is_finite()),
            endurance: None,
            modal: None,
            indices: self.indices,
            stress: None,
            touch: None,
            sweep: None,
            correction: None,
            findings: Default::default(),
            other_tones: Vec::new(),
        }
    }
}
