//! Universal files (UFF, UNV): datasets 15, 18, 55, 58 and 58b, 82, 151, 164, 2411, 2412,
//! 2414, 2420.
//!
//! The way of the data:
//!
//! - `container` cuts the file into datasets.
//! - `function58` reads one function: its header in `header58`, its layout in `layout`, its
//!   numbers in `values`. `identifier` and `binary` find the payload of a binary one.
//! - `scaling` derives kind and units from codes, labels (`unit_label`) and dataset 164
//!   (`header`). `step` finds the exact step of an axis.
//! - `nodes` and `mesh` read the parts of the `geometry`.
//! - `shapes` reads mode shapes and fields; `shape_head` reads their codes.
//! - `scan` lists a file without holding it. Its lines come from `stream`, and `passed` is the
//!   part of a dataset that is kept.
//! - `write` writes a file, with `write58`, `write_mesh` and `write_shape`.
//!
//! Definitions: the pages of UC-SDRL on universal files and on the binary 58. Mistakes of
//! real writers are described beside the code that handles them. A damaged dataset does not
//! affect the others.

mod binary;
mod container;
mod decimal;
mod fields;
mod function58;
mod geometry;
mod header;
mod header58;
mod identifier;
mod layout;
mod lines;
mod mesh;
mod nodes;
mod number;
mod passed;
mod places;
mod scaling;
mod scan;
mod shape_head;
mod shapes;
mod step;
mod stream;
mod values;
mod write;
mod write58;
mod write_function;
mod write_mesh;
mod write_options;
mod write_shape;

pub(crate) use places::{places, DatasetPlace, PlacedFunction};
pub use scan::scan;
pub use write::{write, Plan};
pub use write_options::WriteOptions;

use super::{DatasetInfo, Document, FileFormat, Function, ReadOptions, Shape};
use chladni_frf::{Error, Finding, Result};
use container::Block;
use header::Units;
use mesh::Mesh;
use nodes::{FileNode, System};
use rayon::prelude::*;
use std::path::Path;

/// Reads a universal file; `sha256` of the document is left empty.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where no dataset can be found at all. Damaged datasets
/// are listed in `errors` instead.
pub fn read(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<Document> {
    let mut warnings = Vec::new();
    let blocks = container::datasets(bytes, options.lenient, &mut warnings);
    let units = units_in_force(&blocks);
    let parts: Vec<DatasetContent> = blocks
        .par_iter()
        .zip(units.par_iter())
        .map(|(block, units)| part(block, units, options))
        .collect();
    let mut collector = Collector::new(file);
    collector.document.warnings = warnings;
    parts.into_iter().for_each(|part| collector.add(part));
    collector.finish(units.iter().any(|units| matches!(units, Ok(Some(_)))))
}

/// Collects the content of all datasets into the document.
struct Collector {
    document: Document,
    nodes: Vec<(Vec<FileNode>, Units)>,
    systems: Vec<System>,
    mesh: Mesh,
}

impl Collector {
    fn new(file: &Path) -> Self {
        Self {
            document: Document::new(file, FileFormat::Uff),
            nodes: Vec::new(),
            systems: Vec::new(),
            mesh: Mesh::default(),
        }
    }

    fn add(&mut self, part: DatasetContent) {
        let document = &mut self.document;
        document.datasets.push(part.info);
        document.functions.extend(part.function);
        document
            .errors
            .extend(part.error.map(|error| error.file(&document.file)));
        document.shapes.extend(part.shape);
        self.systems.extend(part.systems);
        self.nodes.extend(part.nodes);
        self.mesh.lines.extend(part.mesh.lines);
        self.mesh.faces.extend(part.mesh.faces);
    }

    fn finish(self, has_units: bool) -> Result<Document> {
        let Self {
            mut document,
            nodes,
            systems,
            mesh,
        } = self;
        if document.datasets.is_empty() {
            return Err(Error::bad_data("no dataset of a universal file is in here")
                .file(&document.file)
                .at_line(1)
                .found("no pair of -1 lines")
                .expected("a line with -1 in columns 5 and 6, then a line with a dataset number")
                .help("check that this is a universal file (.uff, .unv) and complete"));
        }
        if !nodes.is_empty() && !has_units {
            document.warnings.push(Finding::note(
                "unit-assumed",
                "the file has nodes and no units dataset (164): metres are assumed",
            ));
        }
        document.geometry = geometry::geometry(&nodes, &systems, &mut document.warnings);
        (document.geometry.lines, document.geometry.faces) = (mesh.lines, mesh.faces);
        note_lost_nodes(&mut document);
        Ok(document)
    }
}

/// Units that hold for one dataset: those of the last 164 before it, else of the first in the
/// file. `Err` where that 164 is damaged.
type UnitsInForce = std::result::Result<Option<Units>, ()>;

fn units_in_force(blocks: &[Block<'_>]) -> Vec<UnitsInForce> {
    let read = |block: &Block<'_>| match block.number {
        Some(164) => Some(
            header::read_units(block.records, &mut Vec::new())
                .map(Some)
                .map_err(|_| ()),
        ),
        _ => None,
    };
    let own: Vec<Option<UnitsInForce>> = blocks.iter().map(read).collect();
    let mut current = own.iter().flatten().next().copied().unwrap_or(Ok(None));
    own.into_iter()
        .map(|units| {
            current = units.unwrap_or(current);
            current
        })
        .collect()
}

/// Reports nodes without coordinates in lines and faces: these cannot be drawn.
fn note_lost_nodes(document: &mut Document) {
    let geometry = &document.geometry;
    let known: std::collections::HashSet<u64> =
        geometry.nodes.iter().map(|node| node.label).collect();
    let mut lost: Vec<u64> = geometry
        .lines
        .iter()
        .chain(&geometry.faces)
        .flatten()
        .copied()
        .filter(|node| !known.contains(node))
        .collect();
    lost.sort_unstable();
    lost.dedup();
    if let Some(first) = lost.first() {
        document.warnings.push(Finding::note(
            "nodes-without-place",
            format!(
                "lines or elements name {} nodes without coordinates, the first is {first}",
                lost.len()
            ),
        ));
    }
}

/// Datasets whose content the document holds, or which are written anew (header, units).
const CARRIED: [u32; 11] = [15, 18, 55, 58, 82, 151, 164, 2411, 2412, 2414, 2420];

/// The content of one dataset.
struct DatasetContent {
    info: DatasetInfo,
    function: Option<Function>,
    nodes: Option<(Vec<FileNode>, Units)>,
    systems: Vec<System>,
    mesh: Mesh,
    shape: Option<Shape>,
    error: Option<Error>,
}

fn part(block: &Block<'_>, units: &UnitsInForce, options: &ReadOptions) -> DatasetContent {
    let name = block
        .number
        .map_or_else(|| "unreadable dataset".to_string(), header::dataset_name);
    let left_behind = block
        .number
        .is_some_and(|number| !CARRIED.contains(&number));
    let info = DatasetInfo {
        number: block.number,
        line: Some(block.line),
        name,
        left_behind,
        ..DatasetInfo::default()
    };
    let mut part = DatasetContent {
        info,
        function: None,
        nodes: None,
        systems: Vec::new(),
        mesh: Mesh::default(),
        shape: None,
        error: None,
    };
    if let Err(error) = fill(&mut part, block, units, options) {
        let error = match block.number {
            Some(number) => error.dataset(number),
            None => error,
        };
        part.info.warnings.push(Finding::fault(
            "damaged",
            error.to_string().replace("\n  help: ", "; help: "),
        ));
        part.error = Some(error);
    }
    part
}

fn damaged_units(block: &Block<'_>) -> Error {
    Error::bad_data("the units dataset (164) in force here is damaged")
        .at_line(block.line)
        .found("values in unknown units")
        .expected("a sound dataset 164 before it")
        .help("correct the dataset 164, or remove it where the file is in SI")
}

fn fill_function(
    part: &mut DatasetContent,
    block: &Block<'_>,
    units: &UnitsInForce,
    options: &ReadOptions,
) -> Result<()> {
    let info = &mut part.info;
    let read = function58::read(block, units.unwrap_or(None), options);
    if let Some(header) = &read.header {
        info.function = Some(super::function_name(header.function_type).to_string());
        info.response = Some(header.response.to_string());
        info.reference = Some(header.reference.to_string());
    }
    info.values = function58::value_count(block, &read.function);
    let kind_of = |function: &Function| function.kind;
    info.frf_kind = read.function.as_ref().ok().and_then(kind_of);
    info.warnings = read.warnings;
    let function = read.function?;
    if units.is_err() {
        return Err(damaged_units(block));
    }
    part.function = Some(function);
    Ok(())
}

fn list_shape(info: &mut DatasetInfo, shape: &Shape) {
    info.function = Some(shape.analysis.name().into());
    info.reference = shape.reference.map(|dof| dof.to_string());
    info.nodes = Some(shape.nodes.len());
    info.frequency_hz = shape.frequency_hz();
    info.damping_ratio = shape.damping_ratio();
}

fn fill(
    part: &mut DatasetContent,
    block: &Block<'_>,
    units: &UnitsInForce,
    options: &ReadOptions,
) -> Result<()> {
    if block.number == Some(58) {
        return fill_function(part, block, units, options);
    }
    let info = &mut part.info;
    info.warnings = block.warnings.clone();
    if let Some(fault) = &block.fault {
        return Err(fault.clone());
    }
    if block.listed_only {
        info.left_behind = true;
        return Ok(());
    }
    if !block.closed && !options.lenient {
        return Err(function58::not_closed(block));
    }
    let warnings = &mut info.warnings;
    match block.number {
        Some(164) => {
            header::read_units(block.records, warnings)?;
        }
        Some(number @ (15 | 2411)) => {
            let nodes = match number {
                15 => nodes::read_15(block.records, warnings)?,
                _ => nodes::read_2411(block.records, warnings)?,
            };
            info.nodes = Some(nodes.len());
            let units = units.map_err(|()| damaged_units(block))?;
            part.nodes = Some((nodes, units.unwrap_or(Units::SI)));
        }
        Some(number @ (18 | 2420)) => {
            part.systems = nodes::read_systems(number, block.records, warnings)?;
            info.values = Some(part.systems.len());
        }
        Some(82) => {
            part.mesh = mesh::read_82(block.records, warnings)?;
            info.values = Some(part.mesh.lines.len());
        }
        Some(2412) => {
            let (mesh, elements) = mesh::read_2412(block.records, warnings)?;
            part.mesh = mesh;
            info.values = Some(elements);
        }
        Some(number @ (55 | 2414)) => {
            let units = units.map_err(|()| damaged_units(block))?;
            part.shape = shapes::read(number, block.line, block.records, units, warnings)?;
            info.left_behind = part.shape.is_none();
            if let Some(shape) = &part.shape {
                list_shape(info, shape);
            }
        }
        _ => {}
    }
    Ok(())
}
