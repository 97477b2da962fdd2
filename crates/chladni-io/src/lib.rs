//! File formats: the content of one file ([`Document`]), the content of several files
//! together ([`Contents`]), and the FRF sets in it.
//!
//! Formats are told apart by content when read and by extension when written. Every result
//! is written under a temporary name and renamed.
//!
//! ```
//! use chladni_io::{read_frf, write_frf, ReadOptions};
//! # let folder = tempfile::tempdir()?;
//! # let (scan, copy) = (folder.path().join("scan.csv"), folder.path().join("scan.h5"));
//! # std::fs::write(&scan, "# unit = m/s/N\nf,1:+Z:101:+Z re,1:+Z:101:+Z im\n10,1,2\n20,3,4\n")?;
//!
//! let (frf, sources, findings) = read_frf(&[scan], &ReadOptions::default())?;
//! println!("{} responses, from {}", frf.responses.len(), sources[0].file);
//! write_frf(&copy, &frf, false)?;
//! # assert_eq!(frf.values.dim(), (1, 1, 2), "{findings:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | in | out |
//! |---|---|---|
//! | FRFs | [`read_frf`], [`FrfParts`] for sets that do not fit into memory | [`write_frf`], [`write_contents`] |
//! | everything in a file | [`read_document`], [`read_contents`], [`list_document`] | [`write_contents`] |
//! | models, shapes | [`read_model`], [`read_shape_set`] | [`write_model`], [`model_shapes`] |
//! | time records | [`runs_of`] | |
//! | fields of drives | [`read_field`] | [`field_csv`] |
//!
//! Errors are [`chladni_frf::Error`]. The feature `system` reads and writes HDF5 by the C
//! library.

mod arrays;
mod assemble;
mod atomic;
#[cfg(not(feature = "system"))] // the C library reads files by itself
mod bulk;
mod checksums;
mod contents;
mod csv;
mod declared;
mod detect;
mod document;
mod field_file;
mod hdf5;
mod json;
mod limits;
mod mat;
mod model_file;
mod model_shapes;
mod model_table;
mod numpy;
mod parts;
mod paths;
mod phase_unit;
mod read;
mod runs;
mod save;
mod selection;
mod shape;
mod shape_set;
mod signatures;
mod temporary;
mod time_sign;
pub mod uff;
mod unit_label;
mod vtk;
mod wav;

pub use assemble::{assemble, same_files};
pub use atomic::{
    create_atomically, is_same_place, refuse_output_among_inputs, try_place, write_atomically,
    write_together,
};
pub use checksums::{
    checksum_of, checksum_of_bytes, sha256_of, sha256_of_bytes, stamp_of, Checksums, Turn,
};
pub use contents::Contents;
pub use declared::{DeclaredDofs, DeclaredRow};
pub use detect::detect_format;
pub use document::{
    Abscissa, Axis, DatasetInfo, Document, Duplicates, FileFormat, Function, Ordinate, ReadOptions,
};
pub use field_file::{field_csv, parse_field, read_field};
pub use json::write_json;
pub use model_file::{model_json, not_a_model, read_model, write_model};
pub use model_shapes::{field_shape, model_shapes};
pub use numpy::{write_npz, NamedArray};
pub use parts::{frf_bytes, FrfParts, Part};
pub use paths::{expand_paths, Inputs};
pub use phase_unit::PhaseUnit;
pub use read::{list_document, read_contents, read_document, read_documents, read_frf};
pub use runs::{runs_of, ChannelOverride};
pub use save::{extension_of, write_contents, write_frf};
pub use selection::{read_selection, selection_from_toml};
pub use shape::{Analysis, Shape, ShapeForm, ShapeNumbers, TRANSLATION};
pub use shape_set::{read_shape_set, shape_set};

use contents::{function_name, not_carried};
use save::unknown_extension;
