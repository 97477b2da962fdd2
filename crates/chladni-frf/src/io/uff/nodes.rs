//! Nodes (datasets 15 and 2411) and whether the coordinate systems they name are defined (18, 2420).
//!
//! * 15: one record per node, 4I10,1P3E13.5: label, definition system, displacement system, colour, x, y, z.
//! * 2411: two records per node, 4I10 (label, export system, displacement system, colour) and 1P3D25.16 (x, y, z).
//! * 2420: part, name, then per system label/type/colour, name, four rows. 18 (older): four records per system.

use super::fields::{numbers, whole, Column, Record};
use super::header::Units;
use crate::{Error, Geometry, Node, Result};
use std::collections::{HashMap, HashSet};

/// A node with the coordinate systems that it names.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileNode {
    pub label: u64,
    /// System of the position.
    pub position_system: i64,
    /// System of the directions.
    pub displacement_system: i64,
    /// Position in the units of the file.
    pub xyz: [f64; 3],
}

const NODE_FIELDS: [Column; 4] = [("node label", 10), ("position system", 10), ("displacement system", 10), ("colour", 10)];

/// Reads dataset 15.
///
/// # Errors
/// A field that is no number.
pub(super) fn read_15<'a>(records: impl Iterator<Item = Record<'a>>, warnings: &mut Vec<String>) -> Result<Vec<FileNode>> {
    let [label, position, displacement, colour] = NODE_FIELDS;
    let columns = [label, position, displacement, colour, ("x", 13), ("y", 13), ("z", 13)];
    let mut nodes = Vec::new();
    for record in records.filter(|record| !record.text.trim_ascii().is_empty()) {
        let [label, position, displacement, _, x, y, z] = numbers(record, columns, warnings)?;
        nodes.push(node(record, [label, position, displacement], [x, y, z])?);
    }
    Ok(nodes)
}

/// Reads dataset 2411.
///
/// # Errors
/// A field that is no number, or a node without its position.
pub(super) fn read_2411<'a>(records: impl Iterator<Item = Record<'a>>, warnings: &mut Vec<String>) -> Result<Vec<FileNode>> {
    let mut records = records.filter(|record| !record.text.trim_ascii().is_empty());
    let mut nodes = Vec::new();
    while let Some(record) = records.next() {
        let [label, position, displacement, _] = numbers(record, NODE_FIELDS, warnings)?;
        let Some(coordinates) = records.next() else {
            return Err(Error::bad_data("the dataset ends after a node's first record")
                .at_line(record.line)
                .field("node label")
                .found(label)
                .expected("a second record with x, y, z"));
        };
        let xyz = numbers(coordinates, [("x", 25), ("y", 25), ("z", 25)], warnings)?;
        nodes.push(node(record, [label, position, displacement], xyz)?);
    }
    Ok(nodes)
}

fn node(record: Record<'_>, [label, position, displacement]: [f64; 3], xyz: [f64; 3]) -> Result<FileNode> {
    let number = whole(record, "node label", label)?;
    let label = u64::try_from(number).ok().filter(|&label| label > 0).ok_or_else(|| {
        let error = Error::bad_data("a node label must be positive").at_line(record.line).field("node label");
        error.found(number).expected("a whole number, 1 or more")
    })?;
    let position_system = whole(record, "position system", position)?;
    let displacement_system = whole(record, "displacement system", displacement)?;
    Ok(FileNode { label, position_system, displacement_system, xyz })
}

/// Labels of the coordinate systems that dataset 18 or 2420 defines.
///
/// # Errors
/// A label that is no number.
pub(super) fn read_systems<'a>(number: u32, records: impl Iterator<Item = Record<'a>>, warnings: &mut Vec<String>) -> Result<Vec<i64>> {
    let (skipped, per_system) = if number == 2420 { (2, 6) } else { (0, 4) };
    let mut labels = Vec::new();
    for record in records.skip(skipped).step_by(per_system).filter(|record| !record.text.trim_ascii().is_empty()) {
        let label_field = Record { text: &record.text[..record.text.len().min(10)], ..record };
        let [label] = numbers(label_field, [("coordinate system label", 10)], warnings)?;
        labels.push(whole(record, "coordinate system label", label)?);
    }
    Ok(labels)
}

/// Nodes of all datasets, in metres, labels unique; what is odd about them goes to `warnings`.
pub(super) fn geometry(datasets: &[(Vec<FileNode>, Units)], systems: &HashSet<i64>, warnings: &mut Vec<String>) -> Geometry {
    let mut geometry = Geometry::default();
    let mut index_of: HashMap<u64, usize> = HashMap::new();
    let mut moved = Names::default();
    let mut undefined = Names::default();
    let mut local = Names::default();
    let mut displaced = Names::default();
    for (nodes, units) in datasets {
        let length = units.factor([1, 0]);
        for node in nodes {
            let xyz_m = node.xyz.map(|x| x / length);
            if let Some(&first) = index_of.get(&node.label) {
                if geometry.nodes[first].xyz_m != xyz_m {
                    moved.push(node.label);
                }
                continue;
            }
            index_of.insert(node.label, geometry.nodes.len());
            geometry.nodes.push(Node { label: node.label, xyz_m });
            if !is_global(node.displacement_system) {
                let names = if systems.contains(&node.displacement_system) { &mut local } else { &mut undefined };
                names.push(node.label);
            }
            if !is_global(node.position_system) {
                displaced.push(node.label);
            }
        }
    }
    moved.warn(warnings, "stand twice with different positions; the first is kept");
    undefined
        .warn(warnings, "name a displacement coordinate system that no dataset 18 or 2420 defines; their directions cannot be trusted");
    local.warn(
        warnings,
        "measure along their own coordinate systems (18 or 2420); directions are kept as in the file, not turned to global axes",
    );
    displaced
        .warn(warnings, "are placed in a coordinate system of their own; positions are kept as in the file, not turned to global axes");
    geometry
}

/// 0 is the global system, and 1 its usual other name.
fn is_global(system: i64) -> bool {
    matches!(system, 0 | 1)
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
    fn warn(&self, warnings: &mut Vec<String>, what: &str) {
        if self.count > 0 {
            let more = if self.count > self.first.len() { format!(" and {} more", self.count - self.first.len()) } else { String::new() };
            warnings.push(format!("nodes {}{more} {what}", self.first.join(", ")));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(text: &'static str) -> impl Iterator<Item = Record<'static>> {
        text.lines().zip(1..).map(|(text, line)| Record { line, text: text.as_bytes() })
    }

    #[test]
    fn single_and_double_precision_nodes_are_read() {
        let mut warnings = Vec::new();
        let single = read_15(records("         3         1         0         1  1.00000E+00  2.00000E+00 -3.00000E+00"), &mut warnings);
        assert_eq!(single.unwrap()[0].xyz, [1.0, 2.0, -3.0]);
        let double =
            "9999999999         0         7        11\n   1.0000000000000001D-01   0.0000000000000000D+00  -2.5000000000000000D+02";
        let nodes = read_2411(records(double), &mut warnings).unwrap();
        assert_eq!((nodes[0].label, nodes[0].displacement_system, nodes[0].xyz), (9999999999, 7, [0.1, 0.0, -250.0]));
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn a_node_without_position_and_one_that_is_no_number_are_refused() {
        let mut warnings = Vec::new();
        assert!(read_2411(records("         1         0         0        11"), &mut warnings).unwrap_err().to_string().contains("line 1"));
        assert!(read_15(records("       abc         1         0         1"), &mut warnings)
            .unwrap_err()
            .to_string()
            .contains("node label"));
        assert!(read_15(records("        -1         1         0         1"), &mut warnings).is_err());
    }

    fn one_node(displacement_system: i64) -> Vec<(Vec<FileNode>, Units)> {
        let node = FileNode { label: 12, position_system: 0, displacement_system, xyz: [1000.0, 0.0, 0.0] };
        vec![(vec![node], Units { length: 1000.0, force: 1.0 })]
    }

    #[test]
    fn an_undefined_displacement_system_is_reported_with_its_node() {
        let mut warnings = Vec::new();
        let geometry = geometry(&one_node(5), &HashSet::from([4]), &mut warnings);
        assert_eq!(geometry.nodes[0].xyz_m, [1.0, 0.0, 0.0]);
        assert!(warnings[0].contains("nodes 12 ") && warnings[0].contains("no dataset 18 or 2420 defines"), "{warnings:?}");
    }

    #[test]
    fn global_systems_need_no_definition() {
        let mut warnings = Vec::new();
        geometry(&one_node(1), &HashSet::new(), &mut warnings);
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn systems_of_18_and_2420_are_listed() {
        let mut warnings = Vec::new();
        let row = "  1.0 0.0 0.0";
        let new = format!(
            "         1\nNone\n         4         0         8\nCS4\n{row}\n{row}\n{row}\n{row}\n         5         0         8\nCS5\n"
        );
        let new: &'static str = new.leak();
        assert_eq!(read_systems(2420, records(new), &mut warnings).unwrap(), [4, 5]);
        assert_eq!(
            read_systems(18, records("         1         0         0         1         1\nCS1\n  0.0\n  1.0"), &mut warnings).unwrap(),
            [1]
        );
    }
}
