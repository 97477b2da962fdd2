//! Numbers of FRFs in tables that name no DOF: as when all files are read together, they
//! are counted from one table to the next.

use super::NodeLists;
use crate::limits::FIRST_NODE;
use crate::{csv, FileFormat, ReadOptions};
use chladni_frf::Result;
use chladni_text::door::read_bytes;
use std::path::PathBuf;
use std::sync::OnceLock;

/// The tables among files, in their order, with their places among the files.
#[derive(Debug)]
pub(super) struct Tables {
    tables: Vec<(PathBuf, usize)>,
    /// The first number of each table. All tables are read for it once: which FRFs lack a DOF
    /// is only known from their headers and rows.
    first_nodes: OnceLock<Result<Vec<u64>>>,
}

impl Tables {
    /// The tables among files of these formats.
    pub(super) fn among(files: &[(&PathBuf, FileFormat)]) -> Self {
        let numbered = files.iter().enumerate();
        let tables = numbered.filter(|(_, (_, format))| *format == FileFormat::Csv);
        Self {
            tables: tables
                .map(|(number, (path, _))| ((*path).clone(), number))
                .collect(),
            first_nodes: OnceLock::new(),
        }
    }

    /// The node that the first FRF without a DOF gets in file `number`.
    ///
    /// # Errors
    /// Those of reading the tables.
    pub(super) fn first_node(
        &self,
        number: usize,
        options: &ReadOptions,
        lists: &NodeLists,
    ) -> Result<u64> {
        let at = self.tables.iter().position(|table| table.1 == number);
        let Some(at) = at.filter(|&at| at > 0) else {
            return Ok(FIRST_NODE);
        };
        let counted = (self.first_nodes).get_or_init(|| self.count(options, lists));
        counted.clone().map(|first_nodes| first_nodes[at])
    }

    fn count(&self, options: &ReadOptions, lists: &NodeLists) -> Result<Vec<u64>> {
        let (mut next, mut first_nodes) = (FIRST_NODE, vec![FIRST_NODE]);
        for (path, number) in &self.tables[..self.tables.len().saturating_sub(1)] {
            let own = lists.of_file(options, *number);
            csv::read(&read_bytes(path)?, path, &own, &mut next)?;
            first_nodes.push(next);
        }
        Ok(first_nodes)
    }
}
