//! Nodes that the caller lists, one per file: those of a file that is read by itself.

use crate::assemble::{node_for, Side};
use crate::read::nodes_of_file;
use crate::ReadOptions;
use chladni_frf::Result;

/// Lists of nodes that fit the number of files.
#[derive(Debug, Clone)]
pub(super) struct NodeLists {
    /// Number of files.
    count: usize,
}

impl NodeLists {
    /// Checks the lists of the caller.
    ///
    /// # Errors
    /// A list that is neither one node nor one node per file.
    pub(super) fn new(options: &ReadOptions, count: usize) -> Result<Self> {
        node_for(Side::Response, &options.responses, 0, count)?;
        node_for(Side::Reference, &options.references, 0, count)?;
        Ok(Self { count })
    }

    /// The options for reading file `number` by itself.
    pub(super) fn of_file(&self, options: &ReadOptions, number: usize) -> ReadOptions {
        ReadOptions {
            references: nodes_of_file(&options.references, number, self.count),
            responses: nodes_of_file(&options.responses, number, self.count),
            ..options.clone()
        }
    }
}
