//! The nodes of all datasets of a universal file as one geometry.

use super::header::Units;
use super::nodes::{FileNode, System};
use chladni_frf::{Finding, Geometry, Node};
use std::collections::HashMap;

/// Nodes of all datasets, in metres, with unique labels; adds findings to `warnings`.
pub(super) fn geometry(
    datasets: &[(Vec<FileNode>, Units)],
    systems: &[System],
    warnings: &mut Vec<Finding>,
) -> Geometry {
    let mut geometry = Geometry::default();
    let known: HashMap<i64, System> = systems
        .iter()
        .map(|system| (system.label, *system))
        .collect();
    let is_global = |label: i64| {
        known
            .get(&label)
            .map_or(is_global(label), |system| system.is_global)
    };
    let mut index_of: HashMap<u64, usize> = HashMap::new();
    let mut odd = OddNodes::default();
    for (nodes, units) in datasets {
        let length = units.factor([1, 0]);
        for node in nodes {
            let xyz_m = node.xyz.map(|x| x / length);
            if let Some(&first) = index_of.get(&node.label) {
                if geometry.nodes[first].xyz_m != xyz_m {
                    odd.moved.push(node.label);
                }
                continue;
            }
            index_of.insert(node.label, geometry.nodes.len());
            geometry.nodes.push(Node {
                label: node.label,
                xyz_m,
            });
            if !is_global(node.displacement_system) {
                let names = if known.contains_key(&node.displacement_system) {
                    &mut odd.local
                } else {
                    &mut odd.undefined
                };
                names.push(node.label);
            }
            if !is_global(node.position_system) {
                odd.displaced.push(node.label);
            }
        }
    }
    odd.warn(warnings);
    geometry
}

/// True for the global system: 0, or 1, its usual other number.
fn is_global(system: i64) -> bool {
    matches!(system, 0 | 1)
}

/// Labels of nodes with an irregularity, for the warnings.
#[derive(Default)]
struct OddNodes {
    /// Nodes with two positions.
    moved: Names,
    /// Nodes with directions in a system that no dataset defines.
    undefined: Names,
    /// Nodes with directions in a local system.
    local: Names,
    /// Nodes with positions in a local system.
    displaced: Names,
}

impl OddNodes {
    fn warn(&self, warnings: &mut Vec<Finding>) {
        let moved = Finding::caution(
            "node-moved",
            "occur twice with different positions; the first is kept",
        );
        let undefined = Finding::caution(
            "coordinate-systems",
            "name a displacement coordinate system that no dataset 18 or 2420 defines; their \
             directions cannot be trusted",
        );
        let local = Finding::note(
            "own-directions",
            "measure along their own coordinate systems (18 or 2420); directions are kept as in \
             the file, not turned to global axes",
        );
        let displaced = Finding::caution(
            "coordinate-systems",
            "are placed in a coordinate system of their own; positions are kept as in the file, \
             not turned to global axes",
        );
        self.moved.warn(warnings, moved);
        self.undefined.warn(warnings, undefined);
        self.local.warn(warnings, local);
        self.displaced.warn(warnings, displaced);
    }
}

/// Node labels for one message: the first few, and how many there are.
#[derive(Default)]
struct Names {
    first: Vec<String>,
    count: usize,
}

impl Names {
    fn push(&mut self, label: u64) {
        const SHOWN: usize = 5;
        self.count += 1;
        if self.first.len() < SHOWN {
            self.first.push(label.to_string());
        }
    }
    fn warn(&self, warnings: &mut Vec<Finding>, finding: Finding) {
        if self.count > 0 {
            let more = if self.count > self.first.len() {
                format!(" and {} more", self.count - self.first.len())
            } else {
                String::new()
            };
            let text = format!("nodes {}{more} {}", self.first.join(", "), finding.text);
            warnings.push(Finding { text, ..finding });
        }
    }
}
