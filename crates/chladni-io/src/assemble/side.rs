//! Nodes that the user names for one side of all FRFs of a file.

use super::is_measured;
use crate::Document;
use chladni_frf::{Dof, Error, ErrorKind, Result};
use std::collections::BTreeSet;
use std::path::Path;

/// One of the two DOFs of an FRF.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Side {
    Response,
    Reference,
}

impl Side {
    /// Its name, which is also that of its setting.
    fn name(self) -> &'static str {
        match self {
            Self::Response => "response",
            Self::Reference => "reference",
        }
    }
}

/// The node of one side: one node for all files, or one per file.
pub(crate) fn node_for(
    side: Side,
    nodes: &[u64],
    number: usize,
    count: usize,
) -> Result<Option<u64>> {
    let name = side.name();
    match nodes {
        [] => Ok(None),
        &[node] => Ok(Some(node)),
        nodes if nodes.len() == count => Ok(Some(nodes[number])),
        nodes => Err(Error::new(
            ErrorKind::Usage,
            format!("the count of {name} nodes does not fit the count of files"),
        )
        .field(name)
        .found(nodes.len())
        .expected(format!("one for all, or {count}, one per file"))),
    }
}

/// Gives all FRFs of a file with one response, or one reference, another node.
pub(super) fn override_node(document: &mut Document, side: Side, node: Option<u64>) -> Result<()> {
    let Some(node) = node else { return Ok(()) };
    let mut dofs: Vec<&mut Dof> = document
        .functions
        .iter_mut()
        .filter(|function| is_measured(function))
        .map(|function| match side {
            Side::Response => &mut function.response,
            Side::Reference => &mut function.reference,
        })
        .collect();
    if let Some(set) = &mut document.frf {
        dofs.extend(match side {
            Side::Response => &mut set.responses,
            Side::Reference => &mut set.references,
        });
    }
    let nodes = dofs.iter().map(|dof| dof.node).collect();
    refuse_several(side, &nodes, &document.file)?;
    dofs.into_iter().for_each(|dof| dof.node = node);
    Ok(())
}

/// Refuses a file with several nodes on a side for which one was given.
pub(crate) fn refuse_several(side: Side, nodes: &BTreeSet<u64>, file: &Path) -> Result<()> {
    if nodes.len() < 2 {
        return Ok(());
    }
    let name = side.name();
    let shown: Vec<String> = nodes.iter().take(10).map(u64::to_string).collect();
    Err(Error::new(
        ErrorKind::Usage,
        format!("the file holds more than one {name}; one node cannot stand for all"),
    )
    .file(file)
    .field(name)
    .found(shown.join(", "))
    .expected(format!("one {name} node"))
    .help(format!("leave `{name}` out for this file")))
}
