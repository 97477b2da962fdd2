//! File formats: what is in a file ([`Document`]), what files hold together
//! ([`Contents`]), and FRF sets made of it.
//!
//! Formats are told apart by content when read and by extension when written; every
//! result is written beside its place and renamed into it.

mod arrays;
mod assemble;
mod atomic;
#[cfg(not(feature = "system"))] // a library reads the file there
mod bulk;
mod checksums;
mod contents;
mod csv;
mod detect;
mod document;
mod hdf5;
mod json;
mod mat;
mod model_file;
mod model_shapes;
mod numpy;
mod parts;
mod paths;
mod read;
mod save;
mod shape;
mod time_sign;
pub mod uff;
mod unit_label;
mod vtk;
mod wav;

pub use assemble::assemble;
pub use atomic::{create_atomically, refuse_output_among_inputs, write_atomically};
pub use checksums::{sha256_of, Checksums, Turn};
pub use contents::Contents;
pub use detect::detect_format;
pub use document::{
    Abscissa, Axis, DatasetInfo, Document, Duplicates, FileFormat, Function, Ordinate, ReadOptions,
};
pub use json::{json_error, write_json};
pub use model_file::{read_model, write_model};
pub use model_shapes::{field_shape, model_shapes};
pub use numpy::{write_npz, NamedArray};
pub use parts::{frf_bytes, FrfParts, Part};
pub use paths::{expand_paths, file_name, Inputs};
pub use read::{list_document, read_contents, read_document, read_documents, read_frf, read_text};
pub use save::{write_contents, write_frf};
pub use shape::{Analysis, Shape, ShapeForm, ShapeNumbers, TRANSLATION};

/// A unit label: its factor to SI, and its powers of m, kg, s, V, rad, cycle.
pub(crate) fn unit_of(label: &str) -> Option<(f64, [i32; 6])> {
    unit_label::parse(label).map(|unit| (unit.factor, unit.powers))
}

use contents::{function_name, not_carried};
use save::{extension, unknown_extension};
