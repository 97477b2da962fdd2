//! Writes nodes (2411, or 15 for old programs), trace lines (82) and elements (2412).

use super::write58::fortran;
use super::WriteOptions;
use chladni_frf::Geometry;
use std::io::{self, Write};

/// Most labels of a trace line by the definition.
const MOST_TRACE_LABELS: usize = 250;
/// Labels in a line of 8I10.
const LABELS_PER_LINE: usize = 8;
/// Element descriptors of thin shells.
const TRIANGLE: u32 = 91;
const QUADRILATERAL: u32 = 94;
/// Colours, as test programs number them: green nodes, yellow lines.
const NODE_COLOUR: u32 = 11;
const LINE_COLOUR: u32 = 7;

/// Writes nodes: 2411 with 17 digits, or 15 with six.
pub(super) fn write_nodes(
    sink: &mut dyn Write,
    geometry: &Geometry,
    options: WriteOptions,
) -> io::Result<()> {
    if geometry.nodes.is_empty() {
        return Ok(());
    }
    let number = if options.old_datasets { 15 } else { 2411 };
    writeln!(sink, "    -1\n{number:6}")?;
    for node in &geometry.nodes {
        write!(sink, "{:10}{:10}{:10}{NODE_COLOUR:10}", node.label, 0, 0)?;
        if options.old_datasets {
            let [x, y, z] = node.xyz_m.map(|x| fortran(x, 13, 5, 'E'));
            writeln!(sink, "{x}{y}{z}")?;
        } else {
            let [x, y, z] = node.xyz_m.map(|x| fortran(x, 25, 16, 'D'));
            writeln!(sink, "\n{x}{y}{z}")?;
        }
    }
    sink.write_all(b"    -1\n")
}

/// Writes lines as trace lines, a dataset each; triangles and quadrilaterals as thin shells;
/// faces with more corners, which no element has, as closed trace lines.
pub(super) fn write_mesh(sink: &mut dyn Write, geometry: &Geometry) -> io::Result<()> {
    let is_shell = |face: &&Vec<u64>| matches!(face.len(), 3 | 4);
    let closed = geometry
        .faces
        .iter()
        .filter(|face| !is_shell(face))
        .map(|face| face.iter().chain(face.first()).copied().collect());
    let lines = geometry.lines.iter().cloned().chain(closed);
    let mut number = 0;
    for line in lines {
        let mut start = 0;
        while start + 1 < line.len() {
            // neighbouring parts of a long line share a node
            let end = (start + MOST_TRACE_LABELS).min(line.len());
            number += 1;
            writeln!(
                sink,
                "    -1\n    82\n{number:10}{:10}{LINE_COLOUR:10}\nNONE",
                end - start
            )?;
            write_labels(sink, &line[start..end])?;
            sink.write_all(b"    -1\n")?;
            start = end - 1;
        }
    }
    let shells: Vec<&Vec<u64>> = geometry.faces.iter().filter(is_shell).collect();
    if shells.is_empty() {
        return Ok(());
    }
    sink.write_all(b"    -1\n  2412\n")?;
    for (k, face) in shells.into_iter().enumerate() {
        let descriptor = if face.len() == 3 {
            TRIANGLE
        } else {
            QUADRILATERAL
        };
        writeln!(
            sink,
            "{:10}{descriptor:10}{:10}{:10}{LINE_COLOUR:10}{:10}",
            k + 1,
            1,
            1,
            face.len()
        )?;
        write_labels(sink, face)?;
    }
    sink.write_all(b"    -1\n")
}

/// Number of faces with too many corners for an element.
pub(super) fn faces_as_lines(geometry: &Geometry) -> usize {
    geometry
        .faces
        .iter()
        .filter(|face| !matches!(face.len(), 3 | 4))
        .count()
}

fn write_labels(sink: &mut dyn Write, labels: &[u64]) -> io::Result<()> {
    for labels in labels.chunks(LABELS_PER_LINE) {
        labels
            .iter()
            .try_for_each(|label| write!(sink, "{label:10}"))?;
        sink.write_all(b"\n")?;
    }
    Ok(())
}
