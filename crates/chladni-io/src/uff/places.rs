//! Places of the datasets of a universal file, and the DOFs of its functions: what is needed
//! to read some of them.

use super::function58;
use super::passed::Passed;
use super::scan::Datasets;
use chladni_frf::{Dof, Error, Result};
use chladni_text::door::{place_of, size_of};
use std::io;
use std::ops::Range;
use std::path::Path;

/// The place of a dataset in its file.
pub(crate) struct DatasetPlace {
    /// `None` where the number line holds no number.
    pub(crate) number: Option<u32>,
    /// Its bytes, both markers included.
    pub(crate) bytes: Range<u64>,
    /// Line of its opening marker, counted from 1; `None` behind a binary dataset.
    pub(crate) line: Option<u64>,
    /// The function of a 58; `None` where its header cannot be read.
    pub(crate) function: Option<PlacedFunction>,
    /// True where nothing is missing, as far as is seen without the values.
    pub(crate) is_whole: bool,
}

/// Type and DOFs of a function.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedFunction {
    pub(crate) function_type: i32,
    pub(crate) response: Dof,
    pub(crate) reference: Dof,
}

/// The place of each dataset of a file.
///
/// # Errors
/// Those of reading.
pub(crate) fn places(path: &Path, lenient: bool) -> Result<Vec<DatasetPlace>> {
    let on_read = |error: io::Error| Error::from_read(&error, path);
    let place = place_of(path)?;
    let mut datasets = Datasets::open(&place).map_err(on_read)?;
    let mut places: Vec<DatasetPlace> = Vec::new();
    while let Some(passed) = datasets.next_dataset(lenient).map_err(on_read)? {
        if let Some(before) = places.last_mut() {
            before.bytes.end = passed.byte;
        }
        places.push(DatasetPlace::of(&passed));
    }
    if let Some(last) = places.last_mut() {
        last.bytes.end = size_of(path)?;
    }
    Ok(places)
}

impl DatasetPlace {
    /// The place of a dataset whose end is not known yet.
    fn of(passed: &Passed) -> Self {
        let is_cut = (passed.warnings.iter()).any(|warning| warning.code == "values-missing");
        Self {
            number: passed.number,
            bytes: passed.byte..passed.byte,
            line: (passed.counted_from == 0).then_some(passed.line),
            function: (passed.number == Some(58))
                .then(|| function58::placed(&passed.block()))
                .flatten(),
            is_whole: passed.fault.is_none() && passed.closed && !is_cut,
        }
    }
}
