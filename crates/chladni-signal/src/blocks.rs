//! FRFs from averaged blocks, of runs with the same references.

use super::contradictions;
use super::estimators::{estimate_line, LineEstimate};
use super::setting::BlockSetting;
use super::spectra::Averages;
use super::table::Table;
use super::unheard::is_heard;
use super::Group;
use chladni_frf::{Dof, Error, ErrorKind, Estimator, Finding, Result};
use rayon::prelude::*;

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
    let tells = |averages: &Averages| averages.blocks >= references.len();
    let done: Vec<(Dof, Averages, Vec<LineEstimate>)> = group
        .responses
        .par_iter()
        .map(|&response| {
            let averages = Averages::of(group.runs, references, response, setting);
            let lines = (0..averages.lines()).filter(|_| tells(&averages));
            let lines = lines.map(|k| estimate_line(&averages, k, setting.estimator));
            let lines = lines.collect();
            (response, averages, lines)
        })
        .collect();
    // a response may lack records; that of all of them is an error
    let none_tells = !done.iter().any(|(_, averages, _)| tells(averages));
    if let Some((_, averages, _)) = done.first().filter(|_| none_tells) {
        return Err(too_few_blocks(averages.blocks, group));
    }
    let columns = table.columns(group);
    let apart = done.par_iter();
    let apart =
        apart.map(|(response, of, _)| contradictions::of_response(group, *response, &of.takes));
    table.contradict(apart.collect::<Vec<_>>().concat());
    for (response, averages, lines) in done.into_iter().filter(|(_, of, _)| tells(of)) {
        table.count(averages.blocks);
        let row = table.row(response);
        table.hear(response, is_heard(&averages, &lines, references.len()));
        let too_few = averages.blocks <= references.len();
        for (k, line) in lines.iter().enumerate() {
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
