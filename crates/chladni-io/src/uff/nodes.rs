//! Nodes (datasets 15 and 2411) and the coordinate systems that they name (18, 2420).
//!
//! * 15: one record per node, 4I10,1P3E13.5: label, definition system, displacement
//!   system, colour, x, y, z.
//! * 2411: two records per node, 4I10 (label, export system, displacement system, colour)
//!   and 1P3D25.16 (x, y, z).
//! * 2420: part, name, then per system label/type/colour, name, four rows. 18 (older):
//!   four records per system.

use super::fields::{numbers, whole, Column, Record};
use chladni_frf::{Error, Finding, Result};

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

const NODE_FIELDS: [Column; 4] = [
    ("node label", 10),
    ("position system", 10),
    ("displacement system", 10),
    ("colour", 10),
];

/// Reads dataset 15.
///
/// # Errors
/// A field that is no number.
pub(super) fn read_15<'a>(
    records: impl Iterator<Item = Record<'a>>,
    warnings: &mut Vec<Finding>,
) -> Result<Vec<FileNode>> {
    let [label, position, displacement, colour] = NODE_FIELDS;
    let columns = [
        label,
        position,
        displacement,
        colour,
        ("x", 13),
        ("y", 13),
        ("z", 13),
    ];
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
pub(super) fn read_2411<'a>(
    records: impl Iterator<Item = Record<'a>>,
    warnings: &mut Vec<Finding>,
) -> Result<Vec<FileNode>> {
    let mut records = records.filter(|record| !record.text.trim_ascii().is_empty());
    let mut nodes = Vec::new();
    while let Some(record) = records.next() {
        let [label, position, displacement, _] = numbers(record, NODE_FIELDS, warnings)?;
        let Some(coordinates) = records.next() else {
            return Err(
                Error::bad_data("the dataset ends after a node's first record")
                    .at_line(record.line)
                    .field("node label")
                    .found(label)
                    .expected("a second record with x, y, z"),
            );
        };
        let xyz = numbers(coordinates, [("x", 25), ("y", 25), ("z", 25)], warnings)?;
        nodes.push(node(record, [label, position, displacement], xyz)?);
    }
    Ok(nodes)
}

fn node(
    record: Record<'_>,
    [label, position, displacement]: [f64; 3],
    xyz: [f64; 3],
) -> Result<FileNode> {
    let number = whole(record, "node label", label)?;
    let label = u64::try_from(number)
        .ok()
        .filter(|&label| label > 0)
        .ok_or_else(|| {
            let error = Error::bad_data("a node label must be positive")
                .at_line(record.line)
                .field("node label");
            error.found(number).expected("a whole number, 1 or more")
        })?;
    let position_system = whole(record, "position system", position)?;
    let displacement_system = whole(record, "displacement system", displacement)?;
    Ok(FileNode {
        label,
        position_system,
        displacement_system,
        xyz,
    })
}

/// A coordinate system that dataset 18 or 2420 defines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct System {
    pub label: i64,
    /// True for a Cartesian system along the global axes from the global origin: it is the
    /// global system.
    pub is_global: bool,
}

const NEW_SYSTEM: [Column; 3] = [
    ("coordinate system label", 10),
    ("coordinate system type", 10),
    ("colour", 10),
];
const OLD_SYSTEM: [Column; 5] = [
    ("coordinate system label", 10),
    ("coordinate system type", 10),
    ("reference system", 10),
    ("colour", 10),
    ("method", 10),
];
const ROW: [Column; 3] = [("x", 25), ("y", 25), ("z", 25)];
const SIX: [Column; 6] = [
    ("origin x", 13),
    ("origin y", 13),
    ("origin z", 13),
    ("x axis x", 13),
    ("x axis y", 13),
    ("x axis z", 13),
];

/// Coordinate systems of dataset 18 (four records each: numbers, name, origin and a point
/// of the x axis, a point of the x-z plane) or 2420 (part and its name, then six each:
/// numbers, name, three rows of the rotation, origin).
///
/// # Errors
/// A field that is no number, an unknown type, a system that ends early.
pub(super) fn read_systems<'a>(
    number: u32,
    records: impl Iterator<Item = Record<'a>>,
    warnings: &mut Vec<Finding>,
) -> Result<Vec<System>> {
    let mut records = records.skip(if number == 2420 { 2 } else { 0 });
    let mut systems = Vec::new();
    while let Some(record) = records.next() {
        if record.text.trim_ascii().is_empty() {
            continue;
        }
        let [label, kind] = match number {
            2420 => numbers(record, NEW_SYSTEM, warnings).map(|[label, kind, _]| [label, kind])?,
            _ => numbers(record, OLD_SYSTEM, warnings).map(|[label, kind, ..]| [label, kind])?,
        };
        let label = whole(record, "coordinate system label", label)?;
        if ![0.0, 1.0, 2.0].contains(&kind) {
            return Err(Error::bad_data("unknown code")
                .at_line(record.line)
                .field("coordinate system type")
                .found(kind)
                .expected("0 cartesian, 1 cylindrical or 2 spherical"));
        }
        let mut next = |what: &str| {
            records.next().ok_or_else(|| {
                Error::bad_data("the dataset ends inside a coordinate system")
                    .at_line(record.line)
                    .field(what)
                    .found("the end of the dataset")
                    .expected("name, axes and origin")
                    .help("the file is cut short; copy or export it again")
            })
        };
        next("name")?;
        let along_global = if number == 2420 {
            let mut rows = [[0.0; 3]; 4];
            for row in &mut rows {
                *row = numbers(next("rotation and origin")?, ROW, warnings)?;
            }
            rows == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]
        } else {
            let [ox, oy, oz, x, xy, xz] = numbers(next("origin and x axis")?, SIX, warnings)?;
            let [px, py, pz] = numbers(
                next("x-z plane")?,
                [("plane x", 13), ("plane y", 13), ("plane z", 13)],
                warnings,
            )?;
            [ox, oy, oz, xy, xz, px, py] == [0.0; 7] && x > 0.0 && pz > 0.0
        };
        systems.push(System {
            label,
            is_global: kind == 0.0 && along_global,
        });
    }
    Ok(systems)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uff::geometry::geometry;
    use crate::uff::header::Units;

    fn records(text: &'static str) -> impl Iterator<Item = Record<'static>> {
        text.lines().zip(1..).map(|(text, line)| Record {
            line,
            text: text.as_bytes(),
        })
    }

    #[test]
    fn single_and_double_precision_nodes_are_read() {
        let mut warnings = Vec::new();
        let single = read_15(
            records(
                "         3         1         0         1  1.00000E+00  2.00000E+00 -3.00000E+00",
            ),
            &mut warnings,
        );
        assert_eq!(single.unwrap()[0].xyz, [1.0, 2.0, -3.0]);
        let double = "9999999999         0         7        11\n   1.0000000000000001D-01   \
             0.0000000000000000D+00  -2.5000000000000000D+02";
        let nodes = read_2411(records(double), &mut warnings).unwrap();
        assert_eq!(
            (nodes[0].label, nodes[0].displacement_system, nodes[0].xyz),
            (9999999999, 7, [0.1, 0.0, -250.0])
        );
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn a_node_without_position_and_one_that_is_no_number_are_refused() {
        let mut warnings = Vec::new();
        assert!(read_2411(
            records("         1         0         0        11"),
            &mut warnings
        )
        .unwrap_err()
        .to_string()
        .contains("line 1"));
        assert!(read_15(
            records("       abc         1         0         1"),
            &mut warnings
        )
        .unwrap_err()
        .to_string()
        .contains("node label"));
        assert!(read_15(
            records("        -1         1         0         1"),
            &mut warnings
        )
        .is_err());
    }

    fn one_node(displacement_system: i64) -> Vec<(Vec<FileNode>, Units)> {
        let node = FileNode {
            label: 12,
            position_system: 0,
            displacement_system,
            xyz: [1000.0, 0.0, 0.0],
        };
        vec![(
            vec![node],
            Units {
                length: 1000.0,
                force: 1.0,
            },
        )]
    }

    #[test]
    fn an_undefined_displacement_system_is_reported_with_its_node() {
        let mut warnings = Vec::new();
        let geometry = geometry(
            &one_node(5),
            &[System {
                label: 4,
                is_global: false,
            }],
            &mut warnings,
        );
        assert_eq!(geometry.nodes[0].xyz_m, [1.0, 0.0, 0.0]);
        assert!(
            warnings[0].contains("nodes 12 ")
                && warnings[0].contains("no dataset 18 or 2420 defines"),
            "{warnings:?}"
        );
    }

    #[test]
    fn global_systems_need_no_definition() {
        let mut warnings = Vec::new();
        geometry(&one_node(1), &[], &mut warnings);
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn systems_of_18_and_2420_are_read_and_the_global_one_is_known() {
        let mut warnings = Vec::new();
        let rows = |origin: &str| {
            format!("  1.0 0.0 0.0\n  0.0 1.0 0.0\n  0.0 0.0 1.0\n  {origin} 0.0 0.0\n")
        };
        let new = format!(
            "         1\nNone\n         4         0         8\nCS4\n{}         5         0         \
             8\nCS5\n{}",
            rows("0.0"),
            rows("0.1")
        );
        let systems = read_systems(2420, records(new.leak()), &mut warnings).unwrap();
        assert_eq!(
            systems,
            [
                System {
                    label: 4,
                    is_global: true
                },
                System {
                    label: 5,
                    is_global: false
                }
            ]
        );
        let old = "         1         0         0         1         1\nCS1\n  0.0 0.0 0.0 1.0 0.0 \
                   0.0\n  0.0 0.0 1.0\n";
        assert_eq!(
            read_systems(18, records(old), &mut warnings).unwrap(),
            [System {
                label: 1,
                is_global: true
            }]
        );
        assert!(read_systems(
            18,
            records("         1         7         0         1         1"),
            &mut warnings
        )
        .is_err());
        assert!(read_systems(
            18,
            records("         1         0         0         1         1\nCS1"),
            &mut warnings
        )
        .is_err());
        let global = geometry(&one_node(4), &systems, &mut Vec::new());
        assert_eq!(global.nodes.len(), 1);
        let mut warnings = Vec::new();
        geometry(&one_node(4), &systems, &mut warnings);
        assert!(
            warnings.is_empty(),
            "system 4 is the global one: {warnings:?}"
        );
        geometry(&one_node(5), &systems, &mut warnings);
        assert!(
            warnings[0].contains("along their own coordinate systems"),
            "{warnings:?}"
        );
    }
}
