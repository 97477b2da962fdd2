//! The measured structure in space: nodes, the lines and faces between them, and the motion of
//! the nodes.

use crate::sizes::{ALONG, ON_LINE};
use chladni_frf::{Dof, Geometry, ModalModel, Mode};
use num_complex::Complex64;
use std::collections::HashMap;

/// A place or a direction in space.
pub(crate) type Vector = [f64; 3];

/// The structure as it is drawn.
pub(crate) struct Structure {
    /// Places of the nodes, m.
    pub places_m: Vec<Vector>,
    /// Polylines, as indices of nodes.
    pub lines: Vec<Vec<usize>>,
    /// Polygons, as indices of nodes.
    pub faces: Vec<Vec<usize>>,
    /// Node and direction of each response of the model; `None` for rotations, and for
    /// nodes without a place.
    pub moves: Vec<Option<(usize, Vector)>>,
    /// True where all responses point along a beam. They are drawn across it, since the axes of
    /// the file are not those of the beam.
    pub is_turned: bool,
}

impl Structure {
    /// The structure of a model; `None` where fewer than two nodes have a place, or no response
    /// moves one.
    pub fn of(model: &ModalModel) -> Option<Self> {
        let Geometry {
            nodes,
            lines,
            faces,
        } = model.geometry();
        let index: HashMap<u64, usize> = nodes.iter().map(|node| node.label).zip(0..).collect();
        let known = |lists: &[Vec<u64>], least: usize| -> Vec<Vec<usize>> {
            let corners = |list: &Vec<u64>| -> Option<Vec<usize>> {
                list.iter().map(|label| index.get(label).copied()).collect()
            };
            let lists = lists.iter().filter_map(corners);
            lists.filter(|list| list.len() >= least).collect()
        };
        let places_m: Vec<Vector> = nodes.iter().map(|node| node.xyz_m).collect();
        let axis = line_through(&places_m);
        let mut structure = Self {
            lines: known(&lines, 2),
            faces: known(&faces, 3),
            moves: Vec::new(),
            is_turned: false,
            places_m,
        };
        let of_dof = |dof: &Dof| Some((*index.get(&dof.node)?, direction(dof)?));
        structure.moves = model.responses.iter().map(of_dof).collect();
        let moved: Vec<Vector> = structure
            .moves
            .iter()
            .flatten()
            .map(|(_, to)| *to)
            .collect();
        if structure.places_m.len() < 2 || moved.is_empty() {
            return None;
        }
        if let Some(axis) = axis {
            structure.as_beam(axis, &moved);
        }
        Some(structure)
    }

    /// Completes a structure with all nodes on one line: joins them along it where the file has
    /// no lines, and turns responses along the line across it.
    fn as_beam(&mut self, axis: Vector, moved: &[Vector]) {
        if self.lines.is_empty() && self.faces.is_empty() {
            let mut order: Vec<usize> = (0..self.places_m.len()).collect();
            let along = |&k: &usize| dot(self.places_m[k], axis);
            order.sort_by(|a, b| along(a).total_cmp(&along(b)));
            self.lines.push(order);
        }
        self.is_turned = moved.iter().all(|to| dot(*to, axis).abs() > ALONG);
        if self.is_turned {
            let across = across(axis);
            for (_, to) in self.moves.iter_mut().flatten() {
                *to = across.map(|part| part * dot(*to, axis).signum());
            }
        }
    }

    /// Motion of every node in a mode, turned to the phase at which it is most real and scaled to
    /// a largest part of 1; `None` at nodes that were not measured.
    pub fn motion(&self, mode: &Mode) -> Vec<Option<[Complex64; 3]>> {
        let mut motion = vec![None; self.places_m.len()];
        let square: Complex64 = mode.shape.0.iter().map(|value| value * value).sum();
        let turn = Complex64::from_polar(1.0, -0.5 * square.arg());
        for (value, moves) in mode.shape.0.iter().zip(&self.moves) {
            let Some((node, to)) = moves else { continue };
            let at = motion[*node].get_or_insert([Complex64::ZERO; 3]);
            for (at, part) in at.iter_mut().zip(to) {
                *at += turn * value * part;
            }
        }
        let all = motion.iter().flatten().flatten();
        let largest = all.map(|part| part.norm()).fold(0.0, f64::max);
        if largest > 0.0 {
            let parts = motion.iter_mut().flatten().flatten();
            parts.for_each(|part| *part /= largest);
        }
        motion
    }
}

/// Direction of a translation, z where the DOF has no direction; `None` for rotations.
fn direction(dof: &Dof) -> Option<Vector> {
    let sign = dof.direction.sign();
    match dof.direction.axis().code() {
        1 => Some([sign, 0.0, 0.0]),
        2 => Some([0.0, sign, 0.0]),
        0 | 3 => Some([0.0, 0.0, sign]),
        _ => None,
    }
}

/// Unit vector of the line through all places; `None` where they are not on one line.
fn line_through(places: &[Vector]) -> Option<Vector> {
    let first = *places.first()?;
    let from_first = |place: &Vector| [0, 1, 2].map(|k| place[k] - first[k]);
    let length = |v: Vector| dot(v, v).sqrt();
    let far = places
        .iter()
        .map(from_first)
        .max_by(|a, b| length(*a).total_cmp(&length(*b)))?;
    let whole = length(far);
    if whole == 0.0 {
        return None;
    }
    let axis = far.map(|part| part / whole);
    let off = |place: &Vector| {
        let along = dot(from_first(place), axis);
        length([0, 1, 2].map(|k| place[k] - first[k] - along * axis[k]))
    };
    places
        .iter()
        .all(|place| off(place) <= ON_LINE * whole)
        .then_some(axis)
}

/// A unit vector across `axis`: upwards, or along x for a vertical line.
fn across(axis: Vector) -> Vector {
    let up = if axis[2].abs() < ALONG {
        [0.0, 0.0, 1.0]
    } else {
        [1.0, 0.0, 0.0]
    };
    let along = dot(up, axis);
    let across = [0, 1, 2].map(|k| up[k] - along * axis[k]);
    let length = dot(across, across).sqrt();
    across.map(|part| part / length)
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Node;

    /// A model of one mode at nodes with these places, measured along `direction`.
    fn model(places: &[Vector], direction: &str) -> ModalModel {
        let mut model = chladni_plate::simulate(&chladni_plate::Panel::default(), None, None)
            .map(|simulated| simulated.truth)
            .unwrap();
        let node = |(label, &xyz_m): (u64, &Vector)| Node { label, xyz_m };
        model.nodes = (1..).zip(places).map(node).collect();
        (model.lines, model.faces) = (Vec::new(), Vec::new());
        model.responses = (1..=places.len())
            .map(|node| format!("{node}:{direction}").parse().unwrap())
            .collect();
        model.modes.truncate(1);
        let count = places.len();
        model.modes[0].shape.0 = (0..count).map(|k| Complex64::new(k as f64, 0.0)).collect();
        model
    }

    #[test]
    fn a_beam_is_joined_and_moves_across_itself() {
        let places: Vec<Vector> = [0.0, 0.2, 0.1].map(|x| [x, 0.0, 0.0]).to_vec();
        let beam = Structure::of(&model(&places, "+X")).unwrap();
        assert_eq!(beam.lines, [[0, 2, 1]]);
        assert!(beam.is_turned);
        assert_eq!(beam.moves[1], Some((1, [0.0, 0.0, 1.0])));
        let beam = Structure::of(&model(&places, "-Y")).unwrap();
        assert!(!beam.is_turned);
        assert_eq!(beam.moves[1], Some((1, [0.0, -1.0, 0.0])));
    }

    #[test]
    fn nodes_that_were_not_measured_stand_still() {
        let places: Vec<Vector> = (0..4).map(|k| [0.1 * f64::from(k), 0.0, 0.0]).collect();
        let mut model = model(&places, "+Z");
        model.responses.truncate(3);
        model.modes[0].shape.0.truncate(3);
        let beam = Structure::of(&model).unwrap();
        let motion = beam.motion(&model.modes[0]);
        assert_eq!(motion[3], None);
        assert!((motion[2].unwrap()[2].re.abs() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn lines_of_unknown_nodes_are_left_out() {
        let places = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]];
        let mut model = model(&places, "+Z");
        model.lines = vec![vec![1, 2], vec![1, 99]];
        model.faces = vec![vec![1, 2, 3], vec![1, 2]];
        let structure = Structure::of(&model).unwrap();
        assert_eq!(structure.lines, [[0, 1]]);
        assert_eq!(structure.faces, [[0, 1, 2]]);
        model.nodes.clear();
        assert!(Structure::of(&model).is_none());
    }
}
