//! The fewest actuators that serve a scene, or several.
//!
//! Their choice is a combinatorial question; its usual convex stand-in is the sum of
//! amplitudes, reweighted by the amplitudes it led to (Candès, Wakin and Boyd 2008): min
//! Σ|A_i|/(|A_i|′ + ε) with every response inside its limit by some κ (theory.md, eq.
//! 48). What is left is pruned: an actuator goes, the weakest first, while the others
//! still serve the scene without it. The study compared: forward and backward searches by
//! least squares need one to six more, evenly spread ones three to five.
//!
//! Many subsets of one size serve every response, and not all of them the ground between:
//! where that is lost, actuators are exchanged one by one for others with which less of
//! it is.

use crate::methods::mls;
use crate::panel::drive::{amplitude, Drive};
use crate::problems::problem::Problem;
use crate::problems::setup::Setup;
use crate::scene::count::Count;
use crate::solving::climb::Climb;
use crate::solving::drive_program::{Asked, DriveProgram};
use crate::tolerances;
use chladni_frf::{Finding, Result};
use ndarray::Array1;
use rayon::prelude::*;

/// Columns of the operator to use, rising, and what must be said about them.
#[derive(Clone)]
pub(crate) struct Choice {
    pub(crate) columns: Vec<usize>,
    pub(crate) finding: Option<Finding>,
}

/// Chooses among the actuators of `setups`, the same for all: those that serve every
/// scene, in whatever order the scenes are named.
///
/// # Errors
/// Those of the kernels: a broken promise.
pub(crate) fn choose(setups: &[&Setup], count: Count) -> Result<Choice> {
    let all = setups[0].problem.rows.mobility.ncols();
    let every = |finding: Option<Finding>| {
        Ok(Choice {
            columns: (0..all).collect(),
            finding,
        })
    };
    let target = match count {
        Count::All => return every(None),
        Count::Number(number) if number >= all => {
            return every((number > all).then(|| {
                let words = format!("{number} actuators were asked for, {all} may be used");
                Finding::note("fewer-actuators", words)
            }));
        }
        Count::Number(number) => number,
        Count::Auto => 1,
    };
    let mut stages = setups
        .iter()
        .map(|setup| Stage::new(setup))
        .collect::<Result<Vec<_>>>()?;
    // sums over scenes round by their order
    stages.sort_by(|a, b| a.kappa.total_cmp(&b.kappa));
    let possible = stages.iter().all(|stage| stage.kappa > 0.0);
    if !possible && count == Count::Auto {
        return every(Some(all_needed(setups.len())));
    }
    if possible {
        reweighted(&mut stages)?;
    }
    let mut subset = Subset::strongest(stages, if count == Count::Auto { 1 } else { target });
    subset.complete()?;
    subset.prune(target)?;
    if possible && (count == Count::Auto || subset.columns.len() == target) {
        subset.exchange()?;
    }
    let forced = subset.columns.len().saturating_sub(target);
    let finding = (count != Count::Auto && forced > 0).then(|| {
        let (asked, others) = match target {
            1 => ("1 was".to_owned(), "another one".to_owned()),
            _ => (format!("{target} were"), format!("other {target}")),
        };
        let left_out = match forced {
            1 => "the weakest was".to_owned(),
            _ => format!("the weakest {forced} were"),
        };
        let words = format!(
            "{} actuators were found that serve every response, {asked} asked for: {left_out} left \
             out; {others} may serve more",
            subset.columns.len()
        );
        Finding::caution("too-few-actuators", words)
            .help("let the scene choose their number (`actuators`: `auto`)")
    });
    if count != Count::Auto {
        subset.columns.truncate(target);
    }
    subset.columns.sort_unstable();
    Ok(Choice {
        columns: subset.columns,
        finding,
    })
}

/// The finding of scenes that not even all actuators serve.
fn all_needed(scenes: usize) -> Finding {
    let which = if scenes == 1 {
        "the scene"
    } else {
        "every scene"
    };
    let words =
        format!("all actuators are used: not even all of them serve every response of {which}");
    Finding::caution("all-actuators-needed", words)
        .help("widen transition_m, use more actuators, or another frequency")
}

/// A scene on its way to few actuators.
struct Stage<'a> {
    problem: &'a Problem,
    /// Responses, and the ground between them where they carry an area.
    ground: Option<Problem>,
    /// The largest κ with all actuators.
    kappa: f64,
    /// The margin that every response must keep.
    asked: Asked,
    /// The last drive that kept it, with a weight for each of all actuators.
    drive: Drive,
}

impl<'a> Stage<'a> {
    /// With all actuators.
    fn new(setup: &'a Setup) -> Result<Self> {
        let problem = &setup.problem;
        let ground = setup
            .finely_between()
            .map(|rows| problem.with_between(rows, 1.0));
        let start = mls::leading_drives(problem, None)?.swap_remove(0);
        let (kappa, drive) =
            Climb::new(problem)?.reach_kappa(&start, problem.kappa_of_confidence())?;
        let asked = Asked {
            kappa: tolerances::KAPPA_EFFORT.min(tolerances::KEEP * kappa),
            factor: 1.0,
        };
        Ok(Self {
            problem,
            ground,
            kappa,
            asked,
            drive,
        })
    }

    /// The drive of the actuators `columns` that keeps what is asked, as one of all
    /// actuators; `None` where there is none.
    fn served(&self, columns: &[usize]) -> Result<Option<Drive>> {
        let fewer = self.problem.with_actuators(columns);
        let start = Array1::from_shape_fn(columns.len(), |i| self.drive[columns[i]]);
        let (kappa, drive) = Climb::new(&fewer)?.reach_kappa(&start, self.asked.kappa)?;
        if kappa < self.asked.kappa * (1.0 - tolerances::KAPPA_GAIN) {
            return Ok(None);
        }
        let mut whole = Drive::zeros(self.drive.len());
        for (&column, &weight) in columns.iter().zip(&drive) {
            whole[column] = weight;
        }
        Ok(Some(whole))
    }

    /// The share of hot or of cold ground, the smaller, that the actuators `columns` can
    /// serve while they serve every response from `drive`.
    fn ground_served(&self, columns: &[usize], drive: &Drive) -> Result<f64> {
        let Some(ground) = &self.ground else {
            return Ok(1.0);
        };
        let fewer = ground.with_actuators(columns);
        let start = Array1::from_shape_fn(columns.len(), |i| drive[columns[i]]);
        let mut climb = Climb::new(&fewer)?
            .by_need(|k| ground.is_measured(self.problem, k))
            .rounds(tolerances::EXCHANGE_ROUNDS);
        Ok(fewer
            .score(&climb.serve_ground(start, self.asked)?)
            .min_ratio)
    }
}

/// Amplitudes over the largest of each scene, summed over the scenes.
fn shares(stages: &[Stage]) -> Vec<f64> {
    let mut sum = vec![0.0; stages[0].drive.len()];
    for stage in stages {
        let largest = stage
            .drive
            .iter()
            .map(amplitude)
            .fold(f64::MIN_POSITIVE, f64::max);
        sum.iter_mut()
            .zip(&stage.drive)
            .for_each(|(sum, weight)| *sum += amplitude(weight) / largest);
    }
    sum
}

/// Rounds of the reweighted sum of amplitudes. The scenes share their prices, so that an
/// actuator which one of them needs is cheap for the others: the sum of logarithms over
/// actuators of what all scenes together ask of each falls from round to round.
fn reweighted(stages: &mut [Stage]) -> Result<()> {
    let mut prices = vec![1.0; stages[0].drive.len()];
    for _ in 0..tolerances::REWEIGHTINGS {
        for stage in stages.iter_mut() {
            let program = DriveProgram::new(stage.problem)?;
            let rows: Vec<usize> = (0..stage.problem.rows.mobility.nrows()).collect();
            if let Some(next) =
                program.least_sum(&program.phases(&stage.drive), &rows, stage.asked, &prices)?
            {
                stage.drive = next;
            }
        }
        prices = shares(stages)
            .into_iter()
            .map(|share| tolerances::PRICE_FLOOR / (share + tolerances::PRICE_FLOOR))
            .collect();
    }
    Ok(())
}

/// Actuators, the strongest first, and all of them in that order.
struct Subset<'a> {
    columns: Vec<usize>,
    order: Vec<usize>,
    stages: Vec<Stage<'a>>,
}

impl<'a> Subset<'a> {
    /// Those that the drives use, and at least so many.
    fn strongest(stages: Vec<Stage<'a>>, least: usize) -> Self {
        let size = shares(&stages);
        let mut order: Vec<usize> = (0..size.len()).collect();
        order.sort_by(|&a, &b| size[b].total_cmp(&size[a]).then(a.cmp(&b)));
        let used = size
            .iter()
            .filter(|&&a| a > tolerances::UNUSED * size[order[0]])
            .count();
        Self {
            columns: order[..used.max(least)].to_vec(),
            order,
            stages,
        }
    }

    /// Adds actuators until those in use serve every scene.
    fn complete(&mut self) -> Result<()> {
        while self.columns.len() < self.order.len() && !self.serves(&self.columns.clone())? {
            self.columns.push(self.order[self.columns.len()]);
        }
        Ok(())
    }

    /// Drops actuators, the weakest first, while the others serve every scene and more
    /// than `target` are left.
    fn prune(&mut self, target: usize) -> Result<()> {
        let mut tried = self.columns.len();
        while tried > 0 && self.columns.len() > target {
            tried -= 1;
            let mut fewer = self.columns.clone();
            fewer.remove(tried);
            if self.serves(&fewer)? {
                let size = shares(&self.stages);
                fewer.sort_by(|&a, &b| size[b].total_cmp(&size[a]).then(a.cmp(&b)));
                tried = fewer.len();
                self.columns = fewer;
            }
        }
        Ok(())
    }

    /// Exchanges one actuator for another, the exchange by which most ground is served
    /// first, until all scenes serve enough of it or nothing is gained.
    fn exchange(&mut self) -> Result<()> {
        let mut served = self.ground_served(&self.columns)?.unwrap_or(0.0);
        for _ in 0..tolerances::MOST_EXCHANGES {
            if served >= tolerances::SERVES {
                break;
            }
            let others: Vec<usize> = self
                .order
                .iter()
                .copied()
                .filter(|column| !self.columns.contains(column))
                .collect();
            let exchanges: Vec<(usize, usize)> = (0..self.columns.len())
                .flat_map(|place| others.iter().map(move |&other| (place, other)))
                .collect();
            let tried = exchanges.into_par_iter().map(|(place, other)| {
                let mut columns = self.columns.clone();
                columns[place] = other;
                Ok((self.ground_served(&columns)?.unwrap_or(0.0), columns))
            });
            let tried = tried.collect::<Result<Vec<_>>>()?;
            let Some((more, columns)) =
                tried
                    .into_iter()
                    .reduce(|best, other| if other.0 > best.0 { other } else { best })
            else {
                break;
            };
            if more <= served {
                break;
            }
            (served, self.columns) = (more, columns);
        }
        Ok(())
    }

    /// The least share of ground that the actuators `columns` serve in all scenes; `None`
    /// where they do not serve every response.
    fn ground_served(&self, columns: &[usize]) -> Result<Option<f64>> {
        let Some(drives) = self.drives(columns)? else {
            return Ok(None);
        };
        let shares = self
            .stages
            .iter()
            .zip(&drives)
            .map(|(stage, drive)| stage.ground_served(columns, drive));
        Ok(Some(
            shares
                .collect::<Result<Vec<_>>>()?
                .into_iter()
                .fold(1.0, f64::min),
        ))
    }

    /// Drives of the actuators `columns` that serve every response of every scene; `None`
    /// where one has none.
    fn drives(&self, columns: &[usize]) -> Result<Option<Vec<Drive>>> {
        self.stages
            .iter()
            .map(|stage| stage.served(columns))
            .collect()
    }

    /// True where the actuators `columns` serve every response of every scene; their
    /// drives are kept for the next start.
    fn serves(&mut self, columns: &[usize]) -> Result<bool> {
        let Some(drives) = self.drives(columns)? else {
            return Ok(false);
        };
        self.stages
            .iter_mut()
            .zip(drives)
            .for_each(|(stage, drive)| stage.drive = drive);
        Ok(true)
    }
}
