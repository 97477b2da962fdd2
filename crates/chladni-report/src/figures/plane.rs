//! The plane of the maps: the two coordinates that are drawn, in mm, and the extent of the nodes.

use crate::chart::{Axis, Chart, Height, Place};
use crate::sizes;
use chladni_frf::{Dof, ModalModel, Node};
use chladni_render::{Position, Rectangle};

/// The two coordinates in which the structure extends most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plane {
    axes: [usize; 2],
    /// Rectangle around all nodes, m.
    pub(crate) around: Rectangle,
}

impl Plane {
    /// The plane of a model; `None` without nodes, or where all lie on one line.
    pub(crate) fn of(model: &ModalModel) -> Option<Self> {
        Self::of_nodes(&model.nodes)
    }

    /// The plane of nodes without a model.
    pub(crate) fn of_nodes(nodes: &[Node]) -> Option<Self> {
        let extent = |axis: usize| {
            let values = nodes.iter().map(|node| node.xyz_m[axis]);
            values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
        };
        let mut axes = [0, 1, 2];
        // the sort is stable: among equal extents x comes before y, and y before z
        axes.sort_by(|&a, &b| extent(b).total_cmp(&extent(a)));
        let mut axes = [axes[0], axes[1]];
        axes.sort_unstable();
        let positions: Vec<Position> = nodes
            .iter()
            .map(|node| axes.map(|axis| node.xyz_m[axis]))
            .collect();
        let around = Rectangle::around(&positions)?;
        let is_plane = around.x_max > around.x_min && around.y_max > around.y_min;
        is_plane.then_some(Self { axes, around })
    }

    /// The plane x, y around given positions, m.
    pub(crate) fn around(positions: &[Position]) -> Option<Self> {
        let around = Rectangle::around(positions)?;
        (around.x_max > around.x_min && around.y_max > around.y_min).then_some(Self {
            axes: [0, 1],
            around,
        })
    }

    /// The same plane with the extent of the given positions.
    pub(crate) fn over(&self, positions: &[Position]) -> Option<Self> {
        Some(Self {
            around: Rectangle::around(positions)?,
            ..*self
        })
    }

    /// Position of a DOF's node, m.
    pub(crate) fn position(&self, nodes: &[Node], dof: &Dof) -> Option<Position> {
        let node = nodes.iter().find(|node| node.label == dof.node)?;
        Some(self.axes.map(|axis| node.xyz_m[axis]))
    }

    /// Names of both coordinates.
    pub(crate) fn names(&self) -> [&'static str; 2] {
        self.axes.map(|axis| ["x", "y", "z"][axis])
    }

    /// A map of this plane without layers.
    pub(crate) fn chart(&self, highest_px: f64) -> Chart {
        let Rectangle {
            x_min,
            y_min,
            x_max,
            y_max,
        } = self.around;
        let border = sizes::MAP_BORDER * (x_max - x_min).max(y_max - y_min);
        let axis = |which: usize, low: f64, high: f64| {
            Axis::linear(self.names()[which], "mm")
                .range([1e3 * (low - border), 1e3 * (high + border)])
        };
        let mut chart = Chart::new(axis(0, x_min, x_max), axis(1, y_min, y_max))
            .height(Height::EqualScales(highest_px));
        chart.grid = false;
        chart
    }
}

/// A position in m as a place on a map, mm.
pub(crate) fn mm(position: Position) -> Place {
    position.map(|value| 1e3 * value)
}

/// Corners of a rectangle, mm.
pub(crate) fn corners_mm(rectangle: Rectangle) -> Vec<Place> {
    rectangle.corners().into_iter().map(mm).collect()
}
