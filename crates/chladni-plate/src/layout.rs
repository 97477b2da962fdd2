//! Places where a panel is measured and driven: nodes, labels and DOFs.

use crate::panel::Panel;
use crate::point_mass::PointMass;
use chladni_frf::{Direction, Dof, Geometry, Node};

/// Positions and labels of all measured and driven points of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Response positions, m: the grid row by row, then the references where the panel
    /// asks for driving points.
    pub responses_m: Vec<[f64; 2]>,
    /// Reference positions, m, counter-clockwise from the corner x = 0, y = 0.
    pub references_m: Vec<[f64; 2]>,
    /// Response DOFs, all along +Z.
    pub response_dofs: Vec<Dof>,
    /// Reference DOFs, all along +Z; a driving point has the same DOF here and among the
    /// responses.
    pub reference_dofs: Vec<Dof>,
    /// All nodes once, and the meshes of the grid as faces.
    pub geometry: Geometry,
    /// The actuators as loads of the plate; empty where they weigh nothing.
    pub masses: Vec<PointMass>,
}

impl Panel {
    /// Nodes and DOFs of the measurement.
    pub fn layout(&self) -> Layout {
        Layout::new(self)
    }
}

impl Layout {
    pub(crate) fn new(panel: &Panel) -> Self {
        let grid_m = grid(panel);
        let references_m = frame(panel);
        let first_reference = next_hundred(grid_m.len()) + 1;
        let label = |first: usize, count: usize| (first..first + count).map(|node| node as u64);
        let grid_labels: Vec<u64> = label(1, grid_m.len()).collect();
        let reference_labels: Vec<u64> = label(first_reference, references_m.len()).collect();

        let (mut responses_m, mut response_labels) = (grid_m.clone(), grid_labels.clone());
        let driving_points = match (panel.responses.at_references, panel.responses.driving_point) {
            (true, _) => references_m.len(),
            (false, is_one) => usize::from(is_one).min(references_m.len()),
        };
        responses_m.extend(&references_m[..driving_points]);
        response_labels.extend(&reference_labels[..driving_points]);
        let nodes = grid_labels
            .iter()
            .zip(&grid_m)
            .chain(reference_labels.iter().zip(&references_m));
        let nodes = nodes
            .map(|(&label, &[x, y])| Node {
                label,
                xyz_m: [x, y, 0.0],
            })
            .collect();
        let dofs = |labels: &[u64]| {
            labels
                .iter()
                .map(|&node| Dof::new(node, Direction::PLUS_Z))
                .collect()
        };
        let mass_kg = panel.references.mass_kg;
        let loads = if mass_kg > 0.0 {
            references_m.as_slice()
        } else {
            &[]
        };
        Self {
            response_dofs: dofs(&response_labels),
            reference_dofs: dofs(&reference_labels),
            masses: loads
                .iter()
                .map(|&position_m| PointMass {
                    position_m,
                    mass_kg,
                })
                .collect(),
            geometry: Geometry {
                nodes,
                lines: Vec::new(),
                faces: meshes(panel.responses.grid),
            },
            responses_m,
            references_m,
        }
    }
}

/// 100, or the next hundred that holds `count` nodes.
fn next_hundred(count: usize) -> usize {
    count.div_ceil(100).max(1) * 100
}

/// `count` positions along a side, centred.
fn centred(count: usize, spacing: f64, side: f64) -> impl DoubleEndedIterator<Item = f64> + Clone {
    (0..count).map(move |i| side / 2.0 + spacing * (i as f64 - (count as f64 - 1.0) / 2.0))
}

fn grid(panel: &Panel) -> Vec<[f64; 2]> {
    let [columns, rows] = panel.responses.grid;
    let spacing = panel.responses.spacing_m;
    let x = centred(columns, spacing, panel.plate.length_m);
    centred(rows, spacing, panel.plate.width_m)
        .flat_map(|y| x.clone().map(move |x| [x, y]))
        .collect()
}

fn frame(panel: &Panel) -> Vec<[f64; 2]> {
    let ([length, width], inset) = (
        [panel.plate.length_m, panel.plate.width_m],
        panel.references.inset_m,
    );
    let [long, short] = panel.references.edge_count;
    let (along_x, along_y) = if length >= width {
        (long, short)
    } else {
        (short, long)
    };
    let x = centred(along_x, panel.references.spacing_m, length);
    let y = centred(along_y, panel.references.spacing_m, width);
    let bottom = x.clone().map(|x| [x, inset]);
    let right = y.clone().map(|y| [length - inset, y]);
    let top = x.rev().map(|x| [x, width - inset]);
    let left = y.rev().map(|y| [inset, y]);
    bottom.chain(right).chain(top).chain(left).collect()
}

/// The quadrilaterals between neighbouring grid nodes.
fn meshes([columns, rows]: [usize; 2]) -> Vec<Vec<u64>> {
    let label = |column: usize, row: usize| (1 + column + row * columns) as u64;
    let mesh = |c, r| {
        vec![
            label(c, r),
            label(c + 1, r),
            label(c + 1, r + 1),
            label(c, r + 1),
        ]
    };
    (1..rows)
        .flat_map(|r| (1..columns).map(move |c| mesh(c - 1, r - 1)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (0..2).all(|d| (a[d] - b[d]).abs() < 1e-12)
    }

    #[test]
    fn the_default_panel_has_77_responses_and_34_references_in_order() {
        let layout = Panel::default().layout();
        assert_eq!(
            (layout.response_dofs.len(), layout.reference_dofs.len()),
            (77, 34)
        );
        assert_eq!(layout.response_dofs[76].to_string(), "77:+Z");
        assert_eq!(layout.reference_dofs[0].to_string(), "101:+Z");
        assert!(
            near(layout.responses_m[0], [0.034, 0.025]),
            "{:?}",
            layout.responses_m[0]
        );
        assert!(near(layout.responses_m[1], [0.054, 0.025]));
        assert!(near(layout.responses_m[11], [0.034, 0.045]));
        // bottom from the left, right from below, top from the right, left from above
        assert!(near(layout.references_m[0], [0.034, 0.005]));
        assert!(near(layout.references_m[11], [0.263, 0.035]));
        assert!(near(layout.references_m[17], [0.234, 0.165]));
        assert!(near(layout.references_m[28], [0.005, 0.135]));
        assert_eq!(
            (layout.geometry.nodes.len(), layout.geometry.faces.len()),
            (111, 60)
        );
        assert_eq!(layout.geometry.faces[0], [1, 2, 13, 12]);
    }

    #[test]
    fn driving_points_carry_the_labels_of_their_references() {
        let mut panel = Panel::default();
        panel.responses.at_references = true;
        let layout = panel.layout();
        assert_eq!(layout.response_dofs.len(), 111);
        assert_eq!(layout.response_dofs[77..], layout.reference_dofs[..]);
        assert_eq!(layout.responses_m[77..], layout.references_m[..]);
        assert_eq!(layout.geometry.nodes.len(), 111, "each node stands once");
        panel.responses.at_references = false;
        panel.responses.driving_point = true;
        let layout = panel.layout();
        assert_eq!(layout.response_dofs.len(), 78);
        assert_eq!(layout.response_dofs[77], layout.reference_dofs[0]);
    }

    #[test]
    fn references_start_at_the_next_free_hundred() {
        assert_eq!(
            [1, 77, 100, 101, 200, 201].map(next_hundred),
            [100, 100, 100, 200, 200, 300]
        );
    }

    #[test]
    fn on_an_upright_panel_the_long_edges_run_along_y() {
        let mut panel = Panel::default();
        (panel.plate.length_m, panel.plate.width_m) = (panel.plate.width_m, panel.plate.length_m);
        let layout = panel.layout();
        assert!(near(layout.references_m[0], [0.035, 0.005]));
        assert_eq!(
            layout.references_m.iter().filter(|p| p[0] == 0.005).count(),
            11
        );
    }
}
