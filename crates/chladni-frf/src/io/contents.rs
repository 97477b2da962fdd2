//! Everything that was read from some files and can be written to another.

use super::{Document, FileFormat, Function};
use crate::{FrfSet, Geometry, Source};

/// What the files of one command hold together.
#[derive(Debug, Clone, Default)]
pub struct Contents {
    /// All FRFs, where there are any.
    pub frf: Option<FrfSet>,
    /// Nodes, lines and faces of files without FRFs; otherwise they are in `frf`.
    pub other_geometry: Geometry,
    /// Functions that are no FRFs of the set: time records, spectra, ...
    pub functions: Vec<Function>,
    /// The files, in the order read.
    pub sources: Vec<Source>,
    /// Datasets that are not here because nothing here can hold them (mode shapes, unknown datasets): `convert` names them.
    pub not_carried: Vec<String>,
    /// Everything the user must know.
    pub warnings: Vec<String>,
}

impl Contents {
    /// Nodes, lines and faces.
    pub fn geometry(&self) -> &Geometry {
        self.frf.as_ref().map_or(&self.other_geometry, |frf| &frf.geometry)
    }
}

/// Universal-file datasets whose content is in the document, or is written anew (header, units).
const CARRIED: [u32; 6] = [15, 58, 151, 164, 2411, 2420];

/// The datasets of a document that stay behind.
pub(super) fn not_carried(document: &Document) -> Vec<String> {
    let file = document.file.display();
    let left = |name: &str, line: Option<u64>| match line {
        Some(line) => format!("{file}: {name} in line {line} is not carried over"),
        None => format!("{file}: {name} is not carried over"),
    };
    match document.format {
        FileFormat::Uff => document
            .datasets
            .iter()
            .filter_map(|info| Some((info.number.filter(|number| !CARRIED.contains(number))?, info)))
            .map(|(number, info)| left(&format!("dataset {number} ({})", info.name), info.line))
            .collect(),
        FileFormat::Model | FileFormat::Weights => vec![left("the content of a result file", None)],
        FileFormat::Hdf5 => {
            let model = document.datasets.iter().find(|info| info.name.starts_with("/model/"));
            model.map(|_| left("the model under /model", None)).into_iter().collect()
        }
        FileFormat::Csv => Vec::new(),
    }
}

/// The word for a function type of dataset 58.
pub(super) fn function_name(function_type: i32) -> &'static str {
    match function_type {
        1 => "time",
        2 => "auto spectrum",
        3 => "cross spectrum",
        4 => "frf",
        5 => "transmissibility",
        6 => "coherence",
        7 => "auto correlation",
        8 => "cross correlation",
        9 => "power spectral density",
        10 => "energy spectral density",
        12 => "spectrum",
        18 => "mode indicator",
        26 => "multiple coherence",
        27 => "order",
        _ => "function",
    }
}
