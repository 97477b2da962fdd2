//! Nodes that the user names for one side of all FRFs of a file.

use super::is_measured;
use crate::Document;
use chladni_frf::{Dof, Error, ErrorKind, Result};

/// One of the two DOFs of an FRF.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
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
pub(super) fn node_for(
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
    let name = side.name();
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
    let mut nodes: Vec<u64> = dofs.iter().map(|dof| dof.node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    if nodes.len() > 1 {
        return Err(Error::new(
            ErrorKind::Usage,
            format!("the file holds more than one {name}; one node cannot stand for all"),
        )
        .file(&document.file)
        .field(name)
        .found(
            nodes
                .iter()
                .take(10)
                .map(u64::to_string)
                .collect::<Vec<_>>()
                .join(", "),
        )
        .expected(format!("one {name} node"))
        .help(format!("leave `{name}` out for this file")));
    }
    dofs.into_iter().for_each(|dof| dof.node = node);
    Ok(())
}
