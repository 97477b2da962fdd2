//! Places of the DOFs of a model on its panel.

use chladni_frf::{Dof, Error, ModalModel, Result};

/// Positions of responses and references, m, and the sense of each along z.
pub(super) struct Places {
    pub(super) responses_m: Vec<[f64; 2]>,
    pub(super) references_m: Vec<[f64; 2]>,
    pub(super) response_signs: Vec<f64>,
    pub(super) reference_signs: Vec<f64>,
}

impl Places {
    /// # Errors
    /// A DOF without a position, or not along z.
    pub(super) fn of(model: &ModalModel) -> Result<Self> {
        let all = |dofs: &[Dof]| -> Result<(Vec<[f64; 2]>, Vec<f64>)> {
            dofs.iter().map(|&dof| place(model, dof)).collect()
        };
        let (responses_m, response_signs) = all(&model.responses)?;
        let (references_m, reference_signs) = all(&model.references)?;
        Ok(Self {
            responses_m,
            references_m,
            response_signs,
            reference_signs,
        })
    }
}

fn place(model: &ModalModel, dof: Dof) -> Result<([f64; 2], f64)> {
    let node = model.nodes.iter().find(|node| node.label == dof.node);
    match node {
        Some(node) if dof.same_axis(Dof::new(dof.node, chladni_frf::Direction::PLUS_Z)) => {
            Ok(([node.xyz_m[0], node.xyz_m[1]], dof.direction.sign()))
        }
        Some(_) => Err(Error::bad_data("a DOF does not point along z")
            .field("scaling")
            .found(dof)
            .expected("responses and references normal to the panel")),
        None => Err(Error::bad_data("a DOF has no position")
            .field("nodes")
            .found(dof)
            .expected("the nodes of all responses and references, in the panel's coordinates")
            .help("add the geometry to the file of the FRFs")),
    }
}
