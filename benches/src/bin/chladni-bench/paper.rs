//! `chladni bench scene --paper`: the seed paper reproduced.

use super::{names, shown, Place};
use chladni_bench::{paper, paper_csv, paper_figures, PaperRow, PAPER_MODES};
use chladni_console::table::{significant, table};
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use serde_json::json;

/// The table.
const TABLE: &str = "paper.csv";
/// Above the figures of the page.
const WORDS: &str = "Target field, modal coefficients, actuator weightings: the two steps of the paper on the virtual panel, with the lowest modes of the plate, for \
every place of the hot zone, beside the default method. Every drive is judged by the true plate.";

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(place: &Place, console: &Console) -> Result<Outcome> {
    place.prepare(&[TABLE], console)?;
    let run = paper(&|stage| console.stage(stage))?;
    let figures = paper_figures(&run)?;
    let mut files = place.write(&[(TABLE, paper_csv(&run.rows))], &figures, console)?;
    files.push(place.page(
        "paper",
        "The seed paper on the virtual panel",
        WORDS,
        &figures,
        console,
    )?);
    let json = json!({
        "output": place.output.display().to_string(),
        "files": names(&files),
        "rows": run.rows.len(),
    });
    Ok(Outcome::written(&place.output, json, text(&run.rows)))
}

/// The drives with as many modes as the paper takes, and those of other methods.
fn text(rows: &[PaperRow]) -> String {
    const HEADER: [&str; 11] = [
        "scene",
        "method",
        "modes",
        "both",
        "hot",
        "cold",
        "silence",
        "ground: hot",
        "cold",
        "total",
        "force, mN",
    ];
    let whole = rows
        .iter()
        .filter(|row| row.weights.modes_used == PAPER_MODES);
    let cells: Vec<Vec<String>> = whole
        .map(|row| {
            let indices = &row.weights.indices.points;
            let PaperRow { points, window, .. } = row;
            let shares = [
                points.total,
                points.hot,
                points.cold,
                indices.silence_ratio,
                window.hot,
                window.cold,
                window.total,
            ];
            [
                row.case.name.to_owned(),
                match row.cut {
                    Some(cut) => format!("{}, cut {cut}", row.weights.method),
                    None => row.weights.method.clone(),
                },
                format!("{} {}", row.weights.modes_used, row.modes_of.as_str()),
            ]
            .into_iter()
            .chain(shares.map(|share| shown(share, 3)))
            .chain([significant(
                1e3 * indices.max_force_n.unwrap_or(f64::NAN),
                3,
            )])
            .collect()
        })
        .collect();
    table(&HEADER, &cells)
}
