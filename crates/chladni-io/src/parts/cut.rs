//! A file that is read part by part: the places at which it is cut, and its parts.

use super::functions::Groups;
use super::stretches::Joined;
use crate::assemble::{refuse_several, Side};
use crate::read::read_numbered;
use crate::{hdf5, uff, Document, FileFormat, ReadOptions};
use chladni_frf::{Finding, Result};
use chladni_text::door::size_of;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file, and the share of it that belongs to the set.
#[derive(Debug, Clone)]
pub(super) struct Parted {
    pub(super) path: PathBuf,
    /// Place among the measured files.
    pub(super) number: usize,
    /// Size of its FRFs in memory, about.
    pub(super) bytes: u64,
    pub(super) cut: Cut,
    /// The units of `cut` that belong to the set.
    pub(super) units: Range<usize>,
}

/// Places at which a file can be cut.
#[derive(Debug, Clone)]
pub(super) enum Cut {
    /// Nowhere.
    Nowhere,
    /// Between the responses of our own layout.
    Responses(Box<hdf5::Rows>),
    /// Between the functions of different pairs of DOFs.
    Functions(Arc<Groups>),
}

impl Cut {
    /// Number of units between which the file can be cut: responses, pairs of DOFs, or the
    /// file.
    pub(super) fn unit_count(&self) -> usize {
        match self {
            Self::Nowhere => 1,
            Self::Responses(rows) => rows.count(),
            Self::Functions(groups) => groups.count(),
        }
    }

    /// The places of a universal file.
    fn between_functions(path: &Path, lenient: bool) -> Result<Self> {
        let places = uff::places(path, lenient)?;
        // units hold for what follows them: with two, the units of a function depend on its place
        let is_units = |place: &&uff::DatasetPlace| place.number == Some(164);
        if places.iter().filter(is_units).count() > 1 {
            return Ok(Self::Nowhere);
        }
        Ok(Self::Functions(Arc::new(Groups::of(places))))
    }
}

impl Parted {
    /// Finds the places at which the file can be cut.
    pub(super) fn open(
        path: &Path,
        format: FileFormat,
        number: usize,
        options: &ReadOptions,
    ) -> Result<Self> {
        let cut = match format {
            FileFormat::Hdf5 => match hdf5::Rows::open(path)? {
                Some(rows) if options.map.is_empty() => Cut::Responses(Box::new(rows)),
                _ => Cut::Nowhere,
            },
            FileFormat::Uff => Cut::between_functions(path, options.lenient)?,
            _ => Cut::Nowhere,
        };
        let bytes = match &cut {
            Cut::Nowhere => size_of(path)?,
            Cut::Responses(rows) => rows.bytes(),
            Cut::Functions(groups) => groups.bytes(),
        };
        Ok(Self {
            path: path.to_owned(),
            number,
            bytes,
            units: 0..cut.unit_count(),
            cut,
        })
    }

    /// Refuses a node of the caller for a side on which the file has several. A part may have
    /// only one of them, and could not tell. A file that is not cut tells it when it is read.
    pub(super) fn check_nodes(&self, options: &ReadOptions) -> Result<()> {
        let sides = [
            (Side::Response, &options.responses),
            (Side::Reference, &options.references),
        ];
        for (at, (side, asked)) in sides.into_iter().enumerate() {
            let nodes: BTreeSet<u64> = match &self.cut {
                Cut::Nowhere => continue,
                _ if asked.is_empty() => continue,
                Cut::Responses(rows) => rows.dofs()[at].iter().map(|dof| dof.node).collect(),
                Cut::Functions(groups) => groups.nodes[at].clone(),
            };
            refuse_several(side, &nodes, &self.path)?;
        }
        Ok(())
    }

    /// Number of functions that are neither FRFs nor coherence.
    pub(super) fn others(&self) -> usize {
        match &self.cut {
            Cut::Functions(groups) => groups.others,
            _ => 0,
        }
    }

    /// The finding about content that parts do not use.
    pub(super) fn finding(&self) -> Option<Finding> {
        match &self.cut {
            Cut::Functions(groups) => groups.finding(&self.path),
            _ => None,
        }
    }

    /// The datasets other than functions, of a universal file without FRFs.
    pub(super) fn beside_no_frf(&self, options: &ReadOptions) -> Result<Option<Document>> {
        match &self.cut {
            Cut::Functions(groups) if groups.count() == 0 && !groups.beside.is_empty() => {
                self.read_groups(groups, 0..0, options).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Some groups of functions, with all other datasets.
    pub(super) fn read_groups(
        &self,
        groups: &Groups,
        units: Range<usize>,
        options: &ReadOptions,
    ) -> Result<Document> {
        let wanted = groups.beside.iter().chain(groups.functions_of(units));
        let joined = Joined::read(&self.path, wanted.collect())?;
        let mut document = uff::read(&joined.bytes, &self.path, options)?;
        joined.tell_places(&mut document);
        Ok(document)
    }

    /// The whole file; FRFs without a DOF are numbered from `first_node` on.
    pub(super) fn read_whole(
        &self,
        options: &ReadOptions,
        mut first_node: u64,
    ) -> Result<Document> {
        read_numbered(&self.path, options, &mut first_node)
    }
}
