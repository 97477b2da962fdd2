//! File formats: what is in a file ([`Document`]), and FRF sets made of it.

mod document;

pub use document::{Abscissa, Axis, DatasetInfo, Document, Duplicates, FileFormat, Function, Ordinate, ReadOptions};
