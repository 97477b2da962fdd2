//! Edges of a plate: free, simply supported, clamped or elastic.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Support of one edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// Neither displacement nor slope is held.
    Free,
    /// Displacement is zero.
    Supported,
    /// Displacement and slope are zero.
    Clamped,
    /// Displacement is held by springs along the edge, the slope is free.
    Elastic,
}

impl Edge {
    /// Power of the distance from the edge that every admissible shape carries: 0, 1
    /// or 2.
    pub fn power(self) -> usize {
        match self {
            Self::Free | Self::Elastic => 0,
            Self::Supported => 1,
            Self::Clamped => 2,
        }
    }
    fn letter(self) -> char {
        match self {
            Self::Free => 'F',
            Self::Supported => 'S',
            Self::Clamped => 'C',
            Self::Elastic => 'E',
        }
    }
}

/// The four edges, written as four letters F, S, C or E in the order x = 0, y = 0, x
/// = length, y = width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Edges {
    /// Edges at x = 0 and x = length.
    pub x: [Edge; 2],
    /// Edges at y = 0 and y = width.
    pub y: [Edge; 2],
}

impl TryFrom<String> for Edges {
    type Error = String;
    fn try_from(text: String) -> std::result::Result<Self, String> {
        let letter = |c| match c {
            'F' => Some(Edge::Free),
            'S' => Some(Edge::Supported),
            'C' => Some(Edge::Clamped),
            'E' => Some(Edge::Elastic),
            _ => None,
        };
        match text.chars().map(letter).collect::<Option<Vec<_>>>().as_deref() {
            Some(&[x0, y0, x1, y1]) => Ok(Self { x: [x0, x1], y: [y0, y1] }),
            _ => Err(format!(
                "`{text}` names no four edges; write four letters F (free), S (simply supported), C (clamped) or E (elastic) \
                 in the order x=0, y=0, x=length, y=width, for example \"FFFF\""
            )),
        }
    }
}

impl fmt::Display for Edges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        [self.x[0], self.y[0], self.x[1], self.y[1]]
            .iter()
            .try_for_each(|edge| write!(f, "{}", edge.letter()))
    }
}

impl From<Edges> for String {
    fn from(edges: Edges) -> Self {
        edges.to_string()
    }
}

impl Edges {
    /// All four free.
    pub const FREE: Self = Self {
        x: [Edge::Free; 2],
        y: [Edge::Free; 2],
    };

    /// True where an edge is elastic.
    pub fn is_elastic(&self) -> bool {
        let elastic = |pair: [Edge; 2]| pair.contains(&Edge::Elastic);
        elastic(self.x) || elastic(self.y)
    }

    /// Products (x degree, y degree) of the edge basis that cost no bending energy: the
    /// rigid-body motions that the edges allow.
    ///
    /// Three on free edges (up and down, two tilts), one about a single simply supported
    /// edge, none otherwise. Springs of an elastic edge hold some; which, the eigenvalues
    /// tell.
    pub fn rigid_products(&self) -> Vec<(usize, usize)> {
        if self.is_elastic() {
            return Vec::new();
        }
        let held = |pair: [Edge; 2]| pair[0].power() + pair[1].power();
        match (held(self.x), held(self.y)) {
            (0, 0) => vec![(0, 0), (1, 0), (0, 1)],
            (1, 0) | (0, 1) => vec![(0, 0)],
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_written_as_they_are_read() {
        let edges = Edges::try_from("FSCF".to_string()).unwrap();
        let elastic = Edges::try_from("FEFE".to_string()).unwrap();
        assert!(elastic.is_elastic() && elastic.to_string() == "FEFE" && !edges.is_elastic());
        assert_eq!(
            (edges.x, edges.y),
            ([Edge::Free, Edge::Clamped], [Edge::Supported, Edge::Free])
        );
        assert_eq!(edges.to_string(), "FSCF");
        for text in ["", "FFF", "FFFFF", "ffff", "FFXF"] {
            assert!(Edges::try_from(text.to_string()).is_err(), "{text}");
        }
    }
}
