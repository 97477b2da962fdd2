//! The geometry of several files as one.

use crate::limits::SAME_PLACE_M;
use chladni_frf::{Error, Finding, FrfSet, Geometry, Result};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Adds nodes, lines and faces of `more`, each once.
pub(crate) fn merge(geometry: &mut Geometry, more: Geometry, file: &Path) -> Result<()> {
    if geometry.nodes.is_empty() && geometry.lines.is_empty() && geometry.faces.is_empty() {
        *geometry = more;
        return Ok(());
    }
    let places: HashMap<u64, [f64; 3]> = geometry
        .nodes
        .iter()
        .map(|node| (node.label, node.xyz_m))
        .collect();
    for node in more.nodes {
        match places.get(&node.label) {
            None => geometry.nodes.push(node),
            Some(known) => {
                let same = known
                    .iter()
                    .zip(&node.xyz_m)
                    .all(|(a, b)| (a - b).abs() <= SAME_PLACE_M);
                if !same {
                    return Err(Error::bad_data(format!(
                        "node {} stands at two places",
                        node.label
                    ))
                    .file(file)
                    .field("nodes")
                    .found(format!("{:?} m", node.xyz_m))
                    .expected(format!("{known:?} m as in a file before"))
                    .help("files of one set must share node numbers and coordinates"));
                }
            }
        }
    }
    add_new(&mut geometry.lines, more.lines);
    add_new(&mut geometry.faces, more.faces);
    Ok(())
}

fn add_new(known: &mut Vec<Vec<u64>>, more: Vec<Vec<u64>>) {
    let seen: HashSet<Vec<u64>> = known.iter().cloned().collect();
    known.extend(more.into_iter().filter(|list| !seen.contains(list)));
}

/// Reports responses without a position: they can be fitted, but not drawn or rendered.
pub(super) fn note_nodes_without_place(
    geometry: &Geometry,
    set: &FrfSet,
    warnings: &mut Vec<Finding>,
) {
    if geometry.nodes.is_empty() {
        return;
    }
    let known: HashSet<u64> = geometry.nodes.iter().map(|node| node.label).collect();
    let mut lost: Vec<u64> = set
        .responses
        .iter()
        .map(|dof| dof.node)
        .filter(|node| !known.contains(node))
        .collect();
    lost.dedup();
    if !lost.is_empty() {
        let shown: Vec<String> = lost.iter().take(10).map(u64::to_string).collect();
        warnings.push(Finding::note(
            "nodes-without-place",
            format!(
                "{} response nodes have no coordinates: {}{}",
                lost.len(),
                shown.join(", "),
                if lost.len() > 10 { ", ..." } else { "" }
            ),
        ));
    }
}
