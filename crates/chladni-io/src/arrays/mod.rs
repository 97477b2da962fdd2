//! Files of named arrays (HDF5, MATLAB, NumPy): their content as a tree ([`tree`]), arrays
//! from its values ([`values`]), and the search for FRFs in it ([`foreign`]).

pub(crate) mod foreign;
pub(crate) mod memory;
pub(crate) mod tree;
pub(crate) mod values;

use chladni_frf::Result;
use tree::{Entry, Values};

/// A file whose arrays are read one by one.
pub(crate) trait ArrayFile {
    /// All values of a dataset.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] where they are damaged, or of a type that cannot be
    /// read.
    fn read(&self, entry: &Entry) -> Result<Values<'static>>;
}
