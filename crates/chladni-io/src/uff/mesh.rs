//! Reads the connections of nodes: trace lines (dataset 82) and elements (2412).
//!
//! * 82: 3I10 number, count of labels, colour; 80A1 name; 8I10 labels, 0 lifts the pen.
//!   Repeats.
//! * 2412: 6I10 label, descriptor, physical property, material, colour, count of nodes;
//!   for beams 3I10 orientation; 8I10 labels. Repeats.
//!
//! Beams become lines, shells faces. Of solids only the faces are kept, for pictures.

use super::fields::{line_numbers, numbers, warn_split, whole, Column, FieldLayout, Record};
use chladni_frf::{Error, Finding, Result};

/// Polylines and polygons of node labels.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Mesh {
    pub lines: Vec<Vec<u64>>,
    pub faces: Vec<Vec<u64>>,
}

const TRACE_FIELDS: [Column; 3] = [
    ("trace line number", 10),
    ("count of labels", 10),
    ("colour", 10),
];
const ELEMENT_FIELDS: [Column; 6] = [
    ("element label", 10),
    ("descriptor", 10),
    ("physical property", 10),
    ("material", 10),
    ("colour", 10),
    ("count of nodes", 10),
];
const LABELS_PER_LINE: usize = 8;
/// Most nodes of an element. Those of known descriptors have at most 20; others are skipped.
const MOST_ELEMENT_NODES: i64 = 1000;

/// Descriptors of beams, which have an orientation record before their nodes.
const BEAMS: [i64; 5] = [11, 21, 22, 23, 24];

/// Faces of linear solids as positions in their node list.
const TETRAHEDRON: [&[usize]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]];
const WEDGE: [&[usize]; 5] = [
    &[0, 2, 1],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[0, 3, 5, 2],
];
const BRICK: [&[usize]; 6] = [
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
    &[0, 1, 5, 4],
    &[1, 2, 6, 5],
    &[2, 3, 7, 6],
    &[0, 4, 7, 3],
];

/// Reads dataset 82.
///
/// # Errors
/// A field that is no number, fewer or more labels than a line declares.
pub(super) fn read_82<'a>(
    records: impl Iterator<Item = Record<'a>>,
    warnings: &mut Vec<Finding>,
) -> Result<Mesh> {
    let mut records = records.peekable();
    let mut mesh = Mesh::default();
    while let Some(record) = records.next() {
        if record.text.trim_ascii().is_empty() {
            continue;
        }
        let [_, count, _] = numbers(record, TRACE_FIELDS, warnings)?;
        let count = whole(record, TRACE_FIELDS[1].0, count)?;
        if count < 0 {
            return Err(Error::bad_data("a count cannot be negative")
                .at_line(record.line)
                .field(TRACE_FIELDS[1].0)
                .found(count)
                .expected("0 or more"));
        }
        records.next(); // the name
        let labels = labels(&mut records, record, count as u64, warnings)?;
        mesh.lines.extend(
            labels
                .split(|&label| label == 0)
                .filter(|line| line.len() > 1)
                .map(<[u64]>::to_vec),
        );
    }
    Ok(mesh)
}

/// Reads dataset 2412.
///
/// # Errors
/// As [`read_82`].
pub(super) fn read_2412<'a>(
    records: impl Iterator<Item = Record<'a>>,
    warnings: &mut Vec<Finding>,
) -> Result<(Mesh, usize)> {
    let mut records = records
        .filter(|record| !record.text.trim_ascii().is_empty())
        .peekable();
    let mut mesh = Mesh::default();
    let mut unknown: Vec<i64> = Vec::new();
    let mut elements = 0;
    while let Some(record) = records.next() {
        let values = numbers(record, ELEMENT_FIELDS, warnings)?;
        let descriptor = whole(record, ELEMENT_FIELDS[1].0, values[1])?;
        let count = whole(record, ELEMENT_FIELDS[5].0, values[5])?;
        if !(1..=MOST_ELEMENT_NODES).contains(&count) {
            return Err(Error::bad_data("impossible count of nodes")
                .at_line(record.line)
                .field(ELEMENT_FIELDS[5].0)
                .found(count)
                .expected(format!("1 to {MOST_ELEMENT_NODES}")));
        }
        if BEAMS.contains(&descriptor) {
            records
                .next()
                .ok_or_else(|| ends_early(record, 0, count as u64))?;
        }
        let nodes = labels(&mut records, record, count as u64, warnings)?;
        if nodes.contains(&0) {
            let error = Error::bad_data("a node label must be positive")
                .at_line(record.line)
                .field("nodes of the element");
            return Err(error.found(0).expected("1 or more"));
        }
        elements += 1;
        if !mesh.add(descriptor, nodes) && !unknown.contains(&descriptor) {
            unknown.push(descriptor);
        }
    }
    for descriptor in unknown {
        warnings.push(Finding::caution(
            "not-carried",
            format!(
                "elements with descriptor {descriptor} are no lines, faces or solids \
                               that are known here: not carried"
            ),
        ));
    }
    Ok((mesh, elements))
}

impl Mesh {
    /// Adds an element; returns false where its descriptor, or the number of nodes for it, is
    /// not known.
    fn add(&mut self, descriptor: i64, nodes: Vec<u64>) -> bool {
        let solid = |faces: &[&[usize]]| -> Vec<Vec<u64>> {
            faces
                .iter()
                .map(|face| face.iter().map(|&k| nodes[k]).collect())
                .collect()
        };
        match (descriptor, nodes.len()) {
            // rods and beams, linear and parabolic
            (11 | 21..=24 | 31 | 121 | 122, 2..) => self.lines.push(nodes),
            // plane stress, plane strain, plate, membrane, axisymmetric and thin shell:
            // triangles and quadrilaterals, the nodes of parabolic ones in the order of
            // the boundary
            (41..=46 | 51..=56 | 61..=66 | 71..=76 | 81 | 82 | 84 | 85 | 91..=96, 3..) => {
                self.faces.push(nodes)
            }
            (111, 4) => self.faces.extend(solid(&TETRAHEDRON)),
            (112, 6) => self.faces.extend(solid(&WEDGE)),
            (115, 8) => self.faces.extend(solid(&BRICK)),
            _ => return false,
        }
        true
    }
}

fn ends_early(record: Record<'_>, present: usize, declared: u64) -> Error {
    Error::bad_data("fewer labels than declared")
        .at_line(record.line)
        .field("count of labels")
        .found(format!("{declared} declared, {present} present"))
        .expected("equal numbers")
        .help("the file is cut short or was changed by hand; export it again")
}

/// `count` labels in lines of eight. The count may be wrong: memory is not allocated by it.
fn labels<'a>(
    records: &mut impl Iterator<Item = Record<'a>>,
    head: Record<'a>,
    count: u64,
    warnings: &mut Vec<Finding>,
) -> Result<Vec<u64>> {
    let mut labels = Vec::new();
    while (labels.len() as u64) < count {
        let record = records
            .next()
            .ok_or_else(|| ends_early(head, labels.len(), count))?;
        let left = (count - labels.len() as u64).min(LABELS_PER_LINE as u64) as usize;
        let mut values = [0.0; LABELS_PER_LINE];
        let filled = match line_numbers(record.text, &[10; LABELS_PER_LINE], &mut values) {
            Ok(FieldLayout::Columns(filled)) => filled,
            Ok(FieldLayout::Blanks(filled)) => {
                warn_split(record.line, warnings);
                filled
            }
            Err(bad) => return Err(super::fields::bad_field(record, "label", bad)),
        };
        if filled > left {
            return Err(Error::bad_data("more labels than declared")
                .at_line(record.line)
                .field("count of labels")
                .found(format!("{count} declared, more present"))
                .expected("equal numbers"));
        }
        if filled < left {
            return Err(ends_early(head, labels.len() + filled, count));
        }
        for &value in &values[..left] {
            let number = whole(record, "label", value)?;
            labels.push(u64::try_from(number).map_err(|_| {
                Error::bad_data("a label cannot be negative")
                    .at_line(record.line)
                    .field("label")
                    .found(number)
                    .expected("0 or more")
            })?);
        }
    }
    Ok(labels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(text: &str) -> impl Iterator<Item = Record<'_>> {
        text.lines().zip(1..).map(|(text, line)| Record {
            line,
            text: text.as_bytes(),
        })
    }

    #[test]
    fn the_pen_is_lifted_at_zero() {
        let text = "         1         7         3\nOutline\n         1         2         \
                    3         0         7         8         0\n";
        let text = format!("{text}         2         2         3\nNONE\n         3         1\n");
        let mesh = read_82(records(&text), &mut Vec::new()).unwrap();
        assert_eq!(mesh.lines, [vec![1, 2, 3], vec![7, 8], vec![3, 1]]);
    }

    #[test]
    fn labels_go_on_over_lines_and_must_be_as_many_as_declared() {
        let eight: String = (1..=8).map(|k| format!("{k:10}")).collect();
        let nine = format!("         1         9         0\nNONE\n{eight}\n         9\n");
        assert_eq!(
            read_82(records(&nine), &mut Vec::new()).unwrap().lines,
            [(1..=9).collect::<Vec<u64>>()]
        );
        let ten = nine.replace("         9         0\n", "        10         0\n");
        assert!(read_82(records(&ten), &mut Vec::new())
            .unwrap_err()
            .to_string()
            .contains("10 declared, 9 present"));
        let more = "         1         2         0\nNONE\n         1         2         3\n";
        assert!(read_82(records(more), &mut Vec::new())
            .unwrap_err()
            .to_string()
            .contains("more labels"));
        assert!(read_82(
            records("         1 999999999         0\nNONE\n"),
            &mut Vec::new()
        )
        .is_err());
    }

    #[test]
    fn beams_shells_and_solids_are_told_apart() {
        let text = "         1        21         1         1         7         2\n         0         1         1\n         1         2\n\
                    \u{20}        2        94         1         1         7         4\n         1         2         3         4\n\
                    \u{20}        3       111         1         1         7         4\n         1         2         3         9\n\
                    \u{20}        4       999         1         1         7         1\n         1\n";
        let mut warnings = Vec::new();
        let (mesh, elements) = read_2412(records(text), &mut warnings).unwrap();
        assert_eq!(elements, 4);
        assert_eq!(mesh.lines, [vec![1, 2]]);
        assert_eq!(mesh.faces.len(), 1 + 4);
        assert!(
            warnings.len() == 1 && warnings[0].contains("999"),
            "{warnings:?}"
        );
    }
}
