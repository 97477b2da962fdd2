//! The cases in which methods fail, and whether they know it: maps over two things at a
//! time, many seeds in each cell.

mod calibration;
mod drives;
mod figures;
mod maps;
mod measured;
mod tables;
mod trial;

pub use calibration::{calibration, Calibration};
pub use figures::stability_figures;
pub use maps::{Map, MapAxis, MAPS};
pub use tables::{calibration_csv, failures_csv, stability_csv};
pub use trial::Trial;

use crate::countdown::Countdown;
use crate::journal::Journal;
use crate::problem::Problem;
use crate::solver::Solver;
use chladni_frf::{FrfSet, Result};
use drives::Stage;
use rayon::prelude::*;

/// Methods beside the defaults take one seed in so many: their maps show where they
/// stand, not how often they fail.
const FEWER_SEEDS: usize = 4;

/// Settings of the runs.
#[derive(Debug, Clone)]
pub struct StabilityOptions {
    /// Maps.
    pub maps: Vec<&'static Map>,
    /// Methods of both kinds.
    pub solvers: Vec<Solver>,
    /// Tries in each cell with the default of each kind; others take a quarter of them,
    /// one at least.
    pub seeds: usize,
    /// The first seed; the others follow it.
    pub first_seed: u64,
    /// Only the ends and the middle of each axis.
    pub coarse: bool,
}

/// One method in one cell of a map.
#[derive(Debug, Clone)]
pub struct StabilityRow {
    /// The map.
    pub map: &'static Map,
    /// The method.
    pub solver: Solver,
    /// Steps along both axes, counted from 0.
    pub cell: [usize; 2],
    /// Every try with its seed.
    pub trials: Vec<(u64, Trial)>,
}

/// Runs every method in every cell of every map of its kind.
///
/// # Errors
/// None for the maps of this crate, but those of the journal.
pub fn stability(
    options: &StabilityOptions,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<StabilityRow>> {
    let pieces = pieces(options);
    let mut countdown = Countdown::new(pieces.len(), progress);
    let mut stage = None;
    let mut rows = Vec::new();
    for (map, solver, cell) in pieces {
        let name = format!("{} {solver} {} {}", map.name, cell[0], cell[1]);
        let done = journal.has(&name);
        if !map.identifies() && !done && stage.is_none() {
            progress("measuring and fitting the panel");
            stage = Some(Stage::new()?);
        }
        let place = format!(
            "{} {}, {} {}",
            map.x.column,
            map.x.text(cell[0]),
            map.y.column,
            map.y.text(cell[1])
        );
        countdown.next(&format!("{}: {solver}, {place}", map.name), done);
        let trials = journal.once(&name, || {
            let seeds: Vec<u64> = (options.first_seed..)
                .take(options.seeds_of(solver))
                .collect();
            let tried = seeds
                .into_par_iter()
                .map(|seed| Ok((seed, map.try_once(stage.as_ref(), solver, cell, seed)?)));
            let tried: Vec<(u64, Option<Trial>)> = tried.collect::<Result<_>>()?;
            Ok(tried
                .into_iter()
                .filter_map(|(seed, trial)| Some((seed, trial?)))
                .collect::<Vec<(u64, Trial)>>())
        })?;
        rows.push(StabilityRow {
            map,
            solver,
            cell,
            trials,
        });
    }
    Ok(rows)
}

/// Every cell to be run: map by map, method by method.
fn pieces(options: &StabilityOptions) -> Vec<(&'static Map, Solver, [usize; 2])> {
    let steps = |count: usize| -> Vec<usize> {
        match options.coarse && count > 3 {
            true => vec![0, count / 2, count - 1],
            false => (0..count).collect(),
        }
    };
    let mut pieces = Vec::new();
    for &map in &options.maps {
        for &solver in options
            .solvers
            .iter()
            .filter(|solver| solver.identifies() == map.identifies())
        {
            for y in steps(map.y.len()) {
                pieces.extend(
                    steps(map.x.len())
                        .into_iter()
                        .map(|x| (map, solver, [x, y])),
                );
            }
        }
    }
    pieces
}

impl StabilityOptions {
    fn seeds_of(&self, solver: Solver) -> usize {
        if solver.is_default() {
            self.seeds
        } else {
            (self.seeds / FEWER_SEEDS).max(1)
        }
    }
}

impl StabilityRow {
    /// Tries that went wrong and do not say so, by seed.
    pub fn silent(&self) -> impl Iterator<Item = &(u64, Trial)> {
        self.trials
            .iter()
            .filter(|(_, trial)| trial.wrong() && !trial.announced())
    }

    /// The measurement with this seed, and its truth; `None` for drives.
    ///
    /// # Errors
    /// None for the maps of this crate.
    pub fn measurement(&self, seed: u64) -> Result<Option<(FrfSet, Problem)>> {
        Ok(self
            .map
            .measured(self.cell, seed)?
            .map(|measured| (measured.frf, measured.problem)))
    }
}
