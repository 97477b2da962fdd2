//! The fewest actuators that serve a scene.
//!
//! Which ones is a combinatorial question; its usual convex stand-in is the sum of amplitudes, reweighted by the amplitudes it
//! led to (Candès, Wakin and Boyd 2008): min Σ|A_i|/(|A_i|′ + ε) with every response inside its limit by some κ (theory.md,
//! eq. 48). What is left is pruned: an actuator goes, the weakest first, while the others still serve the scene without it. The
//! study compared: forward and backward searches by least squares need one to six more, evenly spread ones three to five.

use crate::climb::Climb;
use crate::count::Count;
use crate::drive_program::{Asked, DriveProgram};
use crate::methods::mls;
use crate::problem::{Drive, Problem};
use crate::setup::Setup;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array1;

/// Columns of the operator to use, rising, and what must be said about them.
pub(crate) struct Choice {
    pub(crate) columns: Vec<usize>,
    pub(crate) warning: Option<String>,
}

/// Chooses among the actuators of `setup`.
///
/// # Errors
/// Those of the kernels: a broken promise.
pub(crate) fn choose(setup: &Setup, count: Count) -> Result<Choice> {
    let problem = &setup.problem;
    let all = problem.rows.mobility.ncols();
    let target = match count {
        Count::All => return Ok(Choice { columns: (0..all).collect(), warning: None }),
        Count::Number(number) if number >= all => {
            let warning = (number > all).then(|| format!("{number} actuators were asked for, {all} may be used"));
            return Ok(Choice { columns: (0..all).collect(), warning });
        }
        Count::Number(number) => number,
        Count::Auto => 1,
    };
    let start = mls::leading_drives(problem, None, 1)?.swap_remove(0);
    let (kappa, drive) = Climb::new(problem)?.raise_kappa(&start)?;
    if kappa == 0.0 && count == Count::Auto {
        let warning = "all actuators are used: not even all of them serve every response of the scene".to_owned();
        return Ok(Choice { columns: (0..all).collect(), warning: Some(warning) });
    }
    let asked = Asked { kappa: tolerances::KAPPA_EFFORT.min(tolerances::KEEP * kappa), factor: 1.0 };
    let sparse = if kappa == 0.0 { drive } else { reweighted(problem, drive, asked)? };
    let mut subset = Subset::strongest(&sparse, if count == Count::Auto { 1 } else { target });
    subset.complete(problem, asked)?;
    subset.prune(problem, asked, target)?;
    let forced = subset.columns.len().saturating_sub(target);
    let warning = (count != Count::Auto && forced > 0).then(|| {
        format!(
            "{} actuators serve every response of this scene, {target} were asked for: the weakest {forced} were left out",
            subset.columns.len()
        )
    });
    if count != Count::Auto {
        subset.columns.truncate(target);
    }
    subset.columns.sort_unstable();
    Ok(Choice { columns: subset.columns, warning })
}

/// Rounds of the reweighted sum of amplitudes.
fn reweighted(problem: &Problem, start: Drive, asked: Asked) -> Result<Drive> {
    let program = DriveProgram::new(problem)?;
    let rows: Vec<usize> = (0..problem.rows.mobility.nrows()).collect();
    let mut drive = start;
    let mut prices = vec![1.0; drive.len()];
    for _ in 0..tolerances::REWEIGHTINGS {
        let Some(next) = program.least_sum(&program.phases(&drive), &rows, asked, &prices)? else { break };
        drive = next;
        let largest = amplitudes(&drive).fold(0.0, f64::max);
        prices = amplitudes(&drive).map(|a| tolerances::PRICE_FLOOR / (a / largest + tolerances::PRICE_FLOOR)).collect();
    }
    Ok(drive)
}

fn amplitudes(drive: &Drive) -> impl Iterator<Item = f64> + '_ {
    drive.iter().map(|weight| weight.norm())
}

/// Actuators, the strongest first, and all of them in that order.
struct Subset {
    columns: Vec<usize>,
    order: Vec<usize>,
    drive: Drive,
}

impl Subset {
    /// Those that `drive` uses, and at least so many.
    fn strongest(drive: &Drive, least: usize) -> Self {
        let size: Vec<f64> = amplitudes(drive).collect();
        let mut order: Vec<usize> = (0..size.len()).collect();
        order.sort_by(|&a, &b| size[b].total_cmp(&size[a]).then(a.cmp(&b)));
        let used = size.iter().filter(|&&a| a > tolerances::UNUSED * size[order[0]]).count();
        Self { columns: order[..used.max(least)].to_vec(), order, drive: drive.clone() }
    }

    /// Adds actuators until those in use serve the scene.
    fn complete(&mut self, problem: &Problem, asked: Asked) -> Result<()> {
        while self.columns.len() < self.order.len() && !self.serves(problem, &self.columns.clone(), asked)? {
            self.columns.push(self.order[self.columns.len()]);
        }
        Ok(())
    }

    /// Drops actuators, the weakest first, while the others serve the scene and more than `target` are left.
    fn prune(&mut self, problem: &Problem, asked: Asked, target: usize) -> Result<()> {
        let mut tried = self.columns.len();
        while tried > 0 && self.columns.len() > target {
            tried -= 1;
            let mut fewer = self.columns.clone();
            fewer.remove(tried);
            if self.serves(problem, &fewer, asked)? {
                let drive = &self.drive;
                fewer.sort_by(|&a, &b| drive[b].norm().total_cmp(&drive[a].norm()).then(a.cmp(&b)));
                tried = fewer.len();
                self.columns = fewer;
            }
        }
        Ok(())
    }

    /// True where the actuators `columns` serve every response by `asked`; their drive is kept for the next start.
    fn serves(&mut self, problem: &Problem, columns: &[usize], asked: Asked) -> Result<bool> {
        let fewer = problem.with_actuators(columns);
        let start = Array1::from_shape_fn(columns.len(), |i| self.drive[columns[i]]);
        let (kappa, drive) = Climb::new(&fewer)?.reach_kappa(&start, asked.kappa)?;
        if kappa < asked.kappa * (1.0 - tolerances::KAPPA_GAIN) {
            return Ok(false);
        }
        self.drive = Array1::zeros(self.order.len());
        for (&column, &weight) in columns.iter().zip(&drive) {
            self.drive[column] = weight;
        }
        Ok(true)
    }
}
