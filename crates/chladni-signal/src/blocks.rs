//! FRFs from averaged blocks, of runs with the same references.

use super::contradictions::{self, Contradiction};
use super::estimators::{estimate_line, LineEstimate};
use super::setting::BlockSetting;
use super::spectra::Averages;
use super::table::Table;
use super::unheard::is_heard;
use super::Group;
use chladni_frf::{Dof, Error, ErrorKind, Estimator, Finding, Result};
use rayon::prelude::*;

/// One response. Its averages and blocks are gone: of many responses they fill the memory.
struct Estimated {
    response: Dof,
    /// Blocks averaged.
    blocks: usize,
    /// None where there are fewer blocks than references.
    lines: Vec<LineEstimate>,
    is_heard: bool,
    contradictions: Vec<Contradiction>,
}

impl Estimated {
    fn of(group: &Group, response: Dof, setting: &BlockSetting) -> Self {
        let references = &group.references;
        let averages = Averages::of(group.runs, references, response, setting);
        let lines = (0..averages.lines()).filter(|_| averages.blocks >= references.len());
        let lines = lines.map(|k| estimate_line(&averages, k, setting.estimator));
        let lines: Vec<LineEstimate> = lines.collect();
        Self {
            response,
            blocks: averages.blocks,
            is_heard: is_heard(&averages, &lines, references.len()),
            contradictions: contradictions::of_response(group, response, &averages.takes),
            lines,
        }
    }
}

/// Adds the FRFs of a group.
pub(super) fn add_group(table: &mut Table, group: &Group, setting: &BlockSetting) -> Result<()> {
    let references = &group.references;
    if setting.estimator == Estimator::H2 && references.len() > 1 {
        return Err(Error::new(
            ErrorKind::Usage,
            "H2 is defined for one reference at a time",
        )
        .field("estimator")
        .found(format!("{} references at once", references.len()))
        .expected("one")
        .help("use h1 or hv"));
    }
    let of_response = |&response| Estimated::of(group, response, setting);
    let done: Vec<Estimated> = group.responses.par_iter().map(of_response).collect();
    let tells = |one: &Estimated| one.blocks >= references.len();
    // a response may lack records; that of all of them is an error
    let none_tells = !done.iter().any(tells);
    if let Some(first) = done.first().filter(|_| none_tells) {
        return Err(too_few_blocks(first.blocks, group));
    }
    let columns = table.columns(group);
    for one in done {
        let is_told = tells(&one);
        table.contradict(one.contradictions);
        if !is_told {
            continue;
        }
        table.count(one.blocks);
        let row = table.row(one.response);
        table.hear(one.response, one.is_heard);
        let too_few = one.blocks <= references.len();
        for (k, line) in one.lines.iter().enumerate() {
            // one block is coherent with itself, whatever it holds
            let coherence = if too_few { f64::NAN } else { line.coherence };
            for (j, &column) in columns.iter().enumerate() {
                let value = (line.frf[j], line.variance[j]);
                table.set([row, column, k], value, coherence);
            }
            if line.frf.iter().any(|value| value.re.is_nan()) {
                table.mask(k);
            }
        }
        if too_few {
            table.warn_once(
                Finding::caution(
                    "few-averages",
                    "too few blocks were averaged for a coherence and a variance",
                )
                .help("average more blows or records; of continuous noise, set a shorter `block`"),
            );
        }
    }
    Ok(())
}

fn too_few_blocks(blocks: usize, group: &Group) -> Error {
    let references = group.references.len();
    Error::bad_data("fewer blocks than references: their FRFs cannot be told apart")
        .file(&group.runs[0].file)
        .field("block")
        .found(format!("{blocks} blocks for {references} references"))
        .expected("at least as many blocks as references, better ten times as many")
        .help("choose a shorter `block`, or measure more records")
}
