//! Positions of the nodes.

use serde::{Deserialize, Serialize};

/// A node of the measured structure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// Label: any number, sparse, never an index.
    pub label: u64,
    /// Global cartesian position, m.
    pub xyz_m: [f64; 3],
}

/// Nodes, and the lines and faces that join them for pictures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// Nodes, in the order of the file, labels unique.
    pub nodes: Vec<Node>,
    /// Polylines of node labels.
    pub lines: Vec<Vec<u64>>,
    /// Polygons of node labels.
    pub faces: Vec<Vec<u64>>,
}

impl Geometry {
    /// The node with this label.
    pub fn node(&self, label: u64) -> Option<&Node> {
        self.nodes.iter().find(|node| node.label == label)
    }
}
