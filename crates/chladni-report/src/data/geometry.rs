//! Places of responses and actuators in the plane of the maps, and the shape of every mode on a
//! grid between the responses.

use super::array::{drawn, f32s};
use crate::figures::plane::Plane;
use crate::figures::shown_responses;
use crate::input::ReportInput;
use crate::sizes;
use crate::structure::Structure;
use chladni_frf::{Dof, FrfSet, ModalModel};
use chladni_render::{AreaGrid, Position, Rectangle, AREA_STEP_M};
use num_complex::Complex64;
use serde_json::{json, Value};

/// The plane of the maps, with responses and grid.
pub(crate) struct Geometry<'a> {
    model: &'a ModalModel,
    plane: Plane,
    /// Indices of the responses along the common axis.
    pub(crate) shown: Vec<usize>,
    places: Vec<Position>,
    pub(crate) grid: Option<AreaGrid>,
}

impl<'a> Geometry<'a> {
    /// `None` without a model or without positions.
    pub(crate) fn of(input: &ReportInput<'a>) -> Option<Self> {
        let model = input.model?;
        let plane = Plane::of(model)?;
        let shown = shown_responses(&model.responses);
        let places: Vec<Position> = shown
            .iter()
            .map(|&k| plane.position(&model.nodes, &model.responses[k]))
            .collect::<Option<_>>()?;
        let around = Rectangle::around(&places)?;
        let area = (around.x_max - around.x_min) * (around.y_max - around.y_min);
        let step = AREA_STEP_M.max((area / sizes::GRID_POINTS).sqrt());
        let grid = AreaGrid::new(&places, around, step);
        Some(Self {
            model,
            plane,
            shown,
            places,
            grid,
        })
    }

    /// A motion of the model's responses, interpolated on the grid, row by row; NaN outside the
    /// responses.
    pub(crate) fn on_grid(&self, at_responses: &[Complex64]) -> Option<Vec<Complex64>> {
        let grid = self.grid.as_ref()?;
        let along = |&k: &usize| at_responses[k] * self.model.responses[k].direction.sign();
        Some(
            grid.field(&self.shown.iter().map(along).collect::<Vec<_>>())
                .into_iter()
                .collect(),
        )
    }

    /// The place of a reference.
    pub(crate) fn place(&self, reference: Dof) -> Option<Position> {
        self.plane.position(&self.model.nodes, &reference)
    }

    pub(crate) fn value(&self) -> Value {
        let model = self.model;
        let around = self.plane.around;
        let references = model
            .references
            .iter()
            .map(|dof| self.plane.position(&model.nodes, dof))
            .collect::<Vec<_>>();
        let grid = self.grid.as_ref().map(|grid| {
            let shapes = model
                .modes
                .iter()
                .filter_map(|mode| self.on_grid(&mode.shape.0))
                .flatten()
                .collect::<Vec<_>>();
            json!({"x": grid.x_m, "y": grid.y_m, "shapes": drawn(&shapes)})
        });
        json!({
            "axes": self.plane.names(),
            "box": [around.x_min, around.y_min, around.x_max, around.y_max],
            "shown": self.shown,
            "places": self.places,
            "references": references,
            "reference_names": model.references,
            "grid": grid,
        })
    }
}

/// The structure in space: nodes, lines, faces, and the node and direction of each response.
pub(crate) fn structure(model: &ModalModel) -> Option<Value> {
    let structure = Structure::of(model)?;
    let moves = structure.moves.iter().map(|moves| {
        let (node, [x, y, z]) = (*moves)?;
        Some(json!([node, x, y, z]))
    });
    Some(json!({
        "xyz": f32s(structure.places_m.iter().flatten().copied()),
        "lines": structure.lines,
        "faces": structure.faces,
        "moves": moves.collect::<Vec<_>>(),
        "turned": structure.is_turned,
    }))
}

/// The plane with the places of an [`FrfSet`], for drawing zones before a fit; `None` without
/// positions.
pub(crate) fn board(set: &FrfSet) -> Option<Value> {
    let nodes = &set.geometry.nodes;
    let plane = Plane::of_nodes(nodes)?;
    let shown = shown_responses(&set.responses);
    let place = |dof: &Dof| plane.position(nodes, dof);
    let around = plane.around;
    Some(json!({
        "axes": plane.names(),
        "box": [around.x_min, around.y_min, around.x_max, around.y_max],
        "places": shown.iter().filter_map(|&k| place(&set.responses[k])).collect::<Vec<_>>(),
        "references": set.references.iter().map(place).collect::<Vec<_>>(),
        "reference_names": set.references,
    }))
}
