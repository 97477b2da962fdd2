//! Files of named arrays (HDF5, MATLAB, NumPy): what their libraries speak ([`tree`]),
//! how values become arrays ([`values`]), and which of them are the FRFs ([`foreign`]).

pub(in crate::io) mod foreign;
pub(in crate::io) mod memory;
pub(in crate::io) mod tree;
pub(in crate::io) mod values;

use crate::Result;
use tree::{Entry, Values};

/// A file whose arrays are read one by one.
pub(in crate::io) trait ArrayFile {
    /// All values of a dataset.
    ///
    /// # Errors
    /// [`crate::ErrorKind::BadData`] where they are damaged, or of a type that cannot be
    /// read.
    fn read(&self, entry: &Entry) -> Result<Values<'static>>;
}
