//! Shapes and fields for ParaView: VTU (an unstructured grid, XML) and PVD (a list of
//! them, one step per shape).
//!
//! Points are the nodes; cells the faces and lines, or the nodes themselves where there
//! are none. Each shape is a vector `re` and, where it is complex, `im`: "Warp By Vector"
//! draws them, and cos ωt·re − sin ωt·im is the motion. Numbers are printed with the
//! shortest digits that read back the same. The format: VTK user's guide, "XML file
//! formats".

use super::atomic::write_atomically;
use super::{Contents, Shape, ShapeForm, TRANSLATION};
use chladni_frf::{Error, ErrorKind, Finding, Geometry, Result};
use num_complex::Complex64;
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Cell types of VTK.
const VERTEX: u8 = 1;
const POLYLINE: u8 = 4;
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
const QUADRILATERAL: u8 = 9;

/// Writes all shapes into one VTU file. Returns findings on what it cannot hold.
///
/// # Errors
/// [`ErrorKind::Usage`] without nodes and shapes; else as [`write_atomically`].
pub(super) fn write_vtu(path: &Path, contents: &Contents, force: bool) -> Result<Vec<Finding>> {
    let lost = check(path, contents)?;
    let shapes: Vec<&Shape> = contents.shapes.iter().collect();
    let grid = Grid::new(contents.geometry());
    write_atomically(path, force, |out| grid.write(out, &shapes))?;
    Ok(lost)
}

/// Writes a PVD file and, beside it, one VTU file per shape, whose time is its frequency in Hz.
///
/// # Errors
/// As [`write_vtu`]. Without `force`, existing files are refused before anything is written.
pub(super) fn write_pvd(path: &Path, contents: &Contents, force: bool) -> Result<Vec<Finding>> {
    let lost = check(path, contents)?;
    let parts: Vec<PathBuf> = (1..=contents.shapes.len()).map(|k| part(path, k)).collect();
    if let Some(taken) = parts.iter().find(|part| !force && part.exists()) {
        return Err(
            Error::new(ErrorKind::CannotCreate, "a file of the list exists")
                .file(taken)
                .found("a file of that name")
                .expected("a new name, or `force`")
                .help("choose another name, or overwrite it with `force`"),
        );
    }
    let grid = Grid::new(contents.geometry());
    for (part, shape) in parts.iter().zip(&contents.shapes) {
        write_atomically(part, force, |out| grid.write(out, &[shape]))?;
    }
    let steps = steps(&contents.shapes);
    write_atomically(path, force, |out| {
        out.write_all(
            b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n",
        )?;
        for (part, step) in parts.iter().zip(steps) {
            writeln!(
                out,
                "<DataSet timestep=\"{step:?}\" part=\"0\" file=\"{}\"/>",
                escaped(&chladni_text::file_name(part))
            )?;
        }
        out.write_all(b"</Collection>\n</VTKFile>\n")
    })?;
    Ok(lost)
}

/// Path of a part: `shapes.pvd` lists `shapes_1.vtu`, `shapes_2.vtu`, ...
fn part(path: &Path, number: usize) -> PathBuf {
    let stem = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default();
    path.with_file_name(format!("{stem}_{number}.vtu"))
}

/// Steps of the shapes: their frequencies where these rise, else 1, 2, ...
fn steps(shapes: &[Shape]) -> Vec<f64> {
    let frequencies: Option<Vec<f64>> = shapes.iter().map(Shape::frequency_hz).collect();
    let rising = |steps: &Vec<f64>| steps.windows(2).all(|pair| pair[0] < pair[1]);
    frequencies
        .filter(rising)
        .unwrap_or_else(|| (1..=shapes.len()).map(|k| k as f64).collect())
}

fn check(path: &Path, contents: &Contents) -> Result<Vec<Finding>> {
    let missing = |what: &str, help: &str| {
        Err(
            Error::new(ErrorKind::Usage, format!("there is no {what} to draw"))
                .file(path)
                .found("none")
                .expected(what)
                .help(help),
        )
    };
    let geometry = contents.geometry();
    if geometry.nodes.is_empty() {
        return missing(
            "node with coordinates",
            "give a file with the geometry (dataset 15 or 2411) too",
        );
    }
    if contents.shapes.is_empty() && contents.frf.is_some() {
        return missing(
            "shape",
            "FRFs are no shapes: fit them first, and convert the model",
        );
    }
    let mut lost = Vec::new();
    if contents.frf.is_some() || !contents.functions.is_empty() {
        lost.push(Finding::caution(
            "not-carried",
            "FRFs and other functions are not drawn: only nodes, lines, faces and shapes are \
             written",
        ));
    }
    if contents
        .shapes
        .iter()
        .any(|shape| shape.values.ncols() > TRANSLATION)
    {
        lost.push(Finding::caution(
            "not-carried",
            "rotations and tensors are left out: the first three components are written",
        ));
    }
    let known: HashMap<u64, usize> = index_of(geometry);
    let without = |shape: &&Shape| shape.nodes.iter().any(|node| !known.contains_key(node));
    let count = contents.shapes.iter().filter(without).count();
    if count > 0 {
        lost.push(Finding::caution(
            "not-carried",
            format!("{count} shapes have values at nodes without coordinates: these are left out"),
        ));
    }
    Ok(lost)
}

fn index_of(geometry: &Geometry) -> HashMap<u64, usize> {
    geometry
        .nodes
        .iter()
        .enumerate()
        .map(|(k, node)| (node.label, k))
        .collect()
}

/// Points and cells.
struct Grid<'a> {
    geometry: &'a Geometry,
    index_of: HashMap<u64, usize>,
    /// Points and type of each cell.
    cells: Vec<(Vec<usize>, u8)>,
}

impl<'a> Grid<'a> {
    fn new(geometry: &'a Geometry) -> Self {
        let index_of = index_of(geometry);
        let points = |labels: &Vec<u64>| {
            labels
                .iter()
                .map(|label| index_of.get(label).copied())
                .collect::<Option<Vec<usize>>>()
        };
        let face_type = |count: usize| match count {
            3 => TRIANGLE,
            4 => QUADRILATERAL,
            _ => POLYGON,
        };
        let faces = geometry
            .faces
            .iter()
            .filter_map(points)
            .map(|face| (face.len(), face))
            .map(|(count, face)| (face, face_type(count)));
        let lines = geometry
            .lines
            .iter()
            .filter_map(points)
            .map(|line| (line, POLYLINE));
        let mut cells: Vec<(Vec<usize>, u8)> = faces.chain(lines).collect();
        if cells.is_empty() {
            cells = (0..geometry.nodes.len())
                .map(|k| (vec![k], VERTEX))
                .collect();
        }
        Self {
            geometry,
            index_of,
            cells,
        }
    }

    fn write(&self, out: &mut dyn Write, shapes: &[&Shape]) -> io::Result<()> {
        let nodes = &self.geometry.nodes;
        out.write_all(b"<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n")?;
        writeln!(
            out,
            "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>",
            nodes.len(),
            self.cells.len()
        )?;
        array(out, "Int64", "node", 1, nodes.iter().map(|node| node.label))?;
        for (k, shape) in shapes.iter().enumerate() {
            let name = title(shape, k, shapes.len() == 1);
            let values = self.values(shape);
            let (re, im) = (format!("{name}re"), format!("{name}im"));
            let re_parts = values.iter().flatten().map(|value| Real(value.re));
            array(out, "Float64", &re, TRANSLATION, re_parts)?;
            if shape.complex {
                let im_parts = values.iter().flatten().map(|value| Real(value.im));
                array(out, "Float64", &im, TRANSLATION, im_parts)?;
            }
        }
        out.write_all(b"</PointData>\n<Points>\n")?;
        let places = nodes.iter().flat_map(|node| node.xyz_m).map(Real);
        array(out, "Float64", "xyz_m", 3, places)?;
        out.write_all(b"</Points>\n<Cells>\n")?;
        let corners = self.cells.iter().flat_map(|(points, _)| points);
        array(out, "Int64", "connectivity", 1, corners)?;
        let ends = self.cells.iter().scan(0, |end, (points, _)| {
            *end += points.len();
            Some(*end)
        });
        array(out, "Int64", "offsets", 1, ends)?;
        let kinds = self.cells.iter().map(|(_, kind)| kind);
        array(out, "UInt8", "types", 1, kinds)?;
        out.write_all(b"</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
    }

    /// Three components per point, in SI; for nodes without a value, 0 (dataset 55) or NaN
    /// (2414).
    fn values(&self, shape: &Shape) -> Vec<[Complex64; TRANSLATION]> {
        let nothing = if shape.form == ShapeForm::AtNodes55 {
            0.0
        } else {
            f64::NAN
        };
        let mut values =
            vec![[Complex64::new(nothing, nothing); TRANSLATION]; self.geometry.nodes.len()];
        for (node, row) in shape.nodes.iter().zip(shape.values.rows()) {
            let Some(&point) = self.index_of.get(node) else {
                continue;
            };
            values[point] = [0, 1, 2].map(|k| {
                row.get(k)
                    .map_or(Complex64::default(), |value| value * shape.scale_to_si)
            });
        }
        values
    }
}

/// A number in the syntax of VTK.
struct Real(f64);

impl std::fmt::Display for Real {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0.is_nan() {
            true => f.write_str("nan"),
            false => write!(f, "{:?}", self.0),
        }
    }
}

/// The text before `re` and `im` in names. It is empty where a file has one shape (`alone`), so
/// that the names are the same in a list of files.
fn title(shape: &Shape, k: usize, alone: bool) -> String {
    if alone {
        return String::new();
    }
    let frequency = shape
        .frequency_hz()
        .map(|hz| format!(" {hz:.3} Hz"))
        .unwrap_or_default();
    format!("shape {:02}{frequency} ", k + 1)
}

fn array<T: std::fmt::Display>(
    out: &mut dyn Write,
    kind: &str,
    name: &str,
    components: usize,
    values: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    let name = escaped(name);
    writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
                   format=\"ascii\">"
    )?;
    for (k, value) in values.into_iter().enumerate() {
        write!(out, "{value}{}", if (k + 1) % 12 == 0 { '\n' } else { ' ' })?;
    }
    out.write_all(b"\n</DataArray>\n")
}

/// Text as an XML attribute; control characters become blanks.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_text_cannot_break_the_markup() {
        assert_eq!(escaped("a\"/><b>&\u{1}"), "a&quot;/&gt;&lt;b&gt;&amp; ");
        assert_eq!(
            part(Path::new("x/shapes.pvd"), 3),
            Path::new("x/shapes_3.vtu")
        );
    }
}
