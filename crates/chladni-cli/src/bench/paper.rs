//! `chladni bench scene --paper`: the seed paper reproduced.

use super::Place;
use crate::console::Console;
use crate::outcome::Outcome;
use chladni_bench::{paper, paper_csv};
use chladni_frf::Result;
use serde_json::json;

/// The table.
const TABLE: &str = "paper.csv";

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(place: &Place, console: &Console) -> Result<Outcome> {
    place.prepare(&[TABLE], console)?;
    let run = paper(&|stage| console.stage(stage))?;
    let files = place.write(&[(TABLE, paper_csv(&run.rows))], &[], console)?;
    let json = json!({
        "output": place.output.display().to_string(),
        "files": files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        "rows": run.rows.len(),
        "warnings": console.warnings(),
    });
    Ok(Outcome::written(&place.output, json, String::new()))
}
