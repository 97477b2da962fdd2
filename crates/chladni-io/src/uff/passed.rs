//! A dataset whose data were passed over.

use super::container::Block;
use super::lines::Lines;
use crate::DatasetInfo;
use chladni_frf::{Error, Finding};

/// A dataset with its data left out.
pub(super) struct Passed {
    pub number: Option<u32>,
    /// Line and byte of the opening marker.
    pub line: u64,
    pub byte: u64,
    /// Offset from which lines are counted; 0 is the beginning of the file.
    pub counted_from: u64,
    /// The records that were kept, and the line of the first.
    pub records: Vec<u8>,
    pub first_record: u64,
    /// Number of values in the file, of a 58.
    pub values: Option<u64>,
    /// True where it is too long to be read, and listed by its name.
    pub too_large: bool,
    pub fault: Option<Error>,
    pub closed: bool,
    pub warnings: Vec<Finding>,
}

impl Passed {
    /// The dataset as a block without data.
    pub fn block(&self) -> Block<'_> {
        Block {
            number: self.number,
            line: self.line,
            records: Lines {
                bytes: &self.records,
                line: self.first_record,
            },
            payload: None,
            passed_over: self.values,
            listed_only: self.too_large,
            fault: self.fault.clone(),
            closed: self.closed,
            warnings: self.warnings.clone(),
        }
    }

    /// Reports the byte of the dataset where its lines are not counted from the beginning of
    /// the file.
    pub fn place(&self, info: &mut DatasetInfo, error: &mut Option<Error>) {
        if self.counted_from == 0 {
            return;
        }
        info.line = None;
        if !info.warnings.is_empty() {
            info.warnings.insert(
                0,
                Finding::note(
                    "loosely-written",
                    format!(
                        "this dataset begins at byte {}; lines are counted from byte {}",
                        self.byte, self.counted_from
                    ),
                ),
            );
        }
        if let Some(error) = error {
            error.byte.get_or_insert(self.byte);
        }
    }
}
