//! Driving points of a set: responses measured at the DOFs of references.

use crate::Dof;

/// A response and a reference at one DOF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivingPoint {
    /// Position of the response.
    pub response: usize,
    /// Position of the reference.
    pub reference: usize,
    /// Sign between their directions.
    pub sign: f64,
}

/// All driving points, response by response.
pub fn driving_points(responses: &[Dof], references: &[Dof]) -> Vec<DrivingPoint> {
    let of_response = |(i, response): (usize, &Dof)| {
        let response = *response;
        let references = references.iter().enumerate();
        references
            .filter(move |(_, reference)| response.same_axis(**reference))
            .map(move |(j, reference)| DrivingPoint {
                response: i,
                reference: j,
                sign: response.direction.sign() * reference.direction.sign(),
            })
    };
    responses.iter().enumerate().flat_map(of_response).collect()
}
