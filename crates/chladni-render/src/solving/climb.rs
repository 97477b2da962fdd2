//! From a drive to a better one by conic programs: the phases of the hot rows follow the
//! solution, missed rows join.
//!
//! Each program holds the phases of its hot rows, so that |v| is replaced by its part
//! along them, which is no more than |v|: what it finds is never worse than what it
//! started from (the convex-concave procedure, Lipp and Boyd 2016). The study found the
//! end within 0.0 to 0.2 dB of a certified bound.

use crate::panel::drive::{amplitude, Drive};
use crate::problems::problem::Problem;
use crate::solving::drive_program::{Asked, DriveProgram};
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array1;
use num_complex::Complex64;

/// A climb over the rows of one problem.
pub(crate) struct Climb<'a> {
    problem: &'a Problem,
    program: DriveProgram<'a>,
    /// Rows that take part, rising.
    active: Vec<usize>,
    /// Most programs in a row for each thing that is sought.
    rounds: usize,
    /// Rows that join at once.
    joining: usize,
}

impl<'a> Climb<'a> {
    /// Over all rows of `problem`.
    pub(crate) fn new(problem: &'a Problem) -> Result<Self> {
        let active = (0..problem.rows.mobility.nrows()).collect();
        Ok(Self {
            problem,
            program: DriveProgram::new(problem)?,
            active,
            rounds: tolerances::ROUNDS,
            joining: tolerances::ROWS_JOINING,
        })
    }

    /// The same with at most so many programs in a row.
    pub(crate) fn rounds(self, rounds: usize) -> Self {
        Self { rounds, ..self }
    }

    /// The same with so many rows that join at once.
    pub(crate) fn joining(self, joining: usize) -> Self {
        Self { joining, ..self }
    }

    /// The same over the `measured` rows alone at first; others join where they are
    /// missed.
    pub(crate) fn by_need(mut self, measured: impl Fn(usize) -> bool) -> Self {
        self.active.retain(|&k| measured(k));
        self
    }

    /// The most robust drive that `start` leads to at little force: the largest κ up to
    /// `enough`, most of it at the least peak force; then the largest margin that little
    /// force gives, most of it at the least peak force, too.
    pub(crate) fn climb(&mut self, start: &Drive, enough: f64) -> Result<Drive> {
        let most = enough / tolerances::KEEP;
        let (kappa, drive) = self.reach_kappa(start, most)?;
        if kappa == 0.0 {
            return Ok(drive);
        }
        let asked = Asked {
            kappa: f64::max(
                kappa * tolerances::KEEP,
                kappa.min(self.problem.kappa_least),
            ),
            factor: 1.0,
        };
        let drive = self.lower_peak(drive, asked)?;
        if kappa < most * (1.0 - tolerances::KAPPA_GAIN) {
            return Ok(drive);
        }
        self.take_margin(drive, asked.kappa)
    }

    /// The largest margin that little force gives, inside by `kappa` standard deviations
    /// besides, most of it at the least peak force.
    pub(crate) fn take_margin(&mut self, drive: Drive, kappa: f64) -> Result<Drive> {
        let given = self.problem.drive_limits.each;
        let little = if given.is_finite() {
            tolerances::LITTLE_FORCE * given
        } else {
            tolerances::MARGIN_RISE * peak(&drive)
        };
        self.program
            .limit_each(f64::max(little, peak(&drive)).min(given));
        let (factor, drive) = self.widen(drive, kappa)?;
        let factor = factor.powf(tolerances::KEEP);
        let drive = self.lower_peak(drive, Asked { kappa, factor })?;
        self.program.limit_each(given);
        Ok(drive)
    }

    /// The largest margin within the limits of the drive, inside by `kappa` standard
    /// deviations besides; and its factor.
    fn widen(&mut self, start: Drive, kappa: f64) -> Result<(f64, Drive)> {
        let (mut factor, mut drive) = (1.0, start);
        for _ in 0..self.rounds {
            let Some((found, next)) =
                self.program
                    .wider(&self.program.phases(&drive), &self.active, kappa, factor)?
            else {
                break;
            };
            drive = next;
            let joined = self.let_missed_join(&drive, kappa, found);
            let gained = found / factor - 1.0;
            factor = found;
            if !joined && gained < tolerances::MARGIN_GAIN {
                break;
            }
        }
        Ok((factor, drive))
    }

    /// Less peak force, inside by `asked`.
    pub(crate) fn lower_peak(&mut self, start: Drive, asked: Asked) -> Result<Drive> {
        self.lower(start, asked, DriveProgram::least_peak, peak)
    }

    /// Less effort √Σ|A_i|², inside by `asked`.
    pub(crate) fn lower_effort(&mut self, start: Drive, asked: Asked) -> Result<Drive> {
        self.lower(start, asked, DriveProgram::least_effort, |drive| {
            drive.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
        })
    }

    /// Repeats `program` until it lowers `cost` no more.
    fn lower(
        &mut self,
        start: Drive,
        asked: Asked,
        program: impl Fn(
            &DriveProgram<'a>,
            &Array1<Complex64>,
            &[usize],
            Asked,
        ) -> Result<Option<Drive>>,
        cost: impl Fn(&Drive) -> f64,
    ) -> Result<Drive> {
        let mut drive = start;
        for _ in 0..self.rounds {
            let Some(next) = program(
                &self.program,
                &self.program.phases(&drive),
                &self.active,
                asked,
            )?
            else {
                break;
            };
            let before = cost(&drive);
            drive = next;
            let joined = self.let_missed_join(&drive, asked.kappa, asked.factor);
            if !joined && cost(&drive) > before * (1.0 - tolerances::COST_GAIN) {
                break;
            }
        }
        Ok(drive)
    }

    /// The largest κ, up to `cap`; 0 where no row set of these phases can be kept, with
    /// the drive that comes nearest.
    pub(crate) fn reach_kappa(&mut self, start: &Drive, cap: f64) -> Result<(f64, Drive)> {
        let (mut kappa, mut drive) = (0.0, start.clone());
        let mut feasible = false;
        for _ in 0..self.rounds {
            let found =
                self.program
                    .largest_kappa(&self.program.phases(&drive), &self.active, cap)?;
            let Some(next) = found.drive else {
                if feasible {
                    break;
                }
                let (factor, nearer) = self.raise_margin(drive.clone())?;
                drive = nearer;
                if factor < 1.0 {
                    return Ok((0.0, drive));
                }
                continue;
            };
            feasible = true;
            drive = next;
            let joined = self.let_missed_join(&drive, found.kappa, 1.0);
            let gained = found.kappa - kappa;
            kappa = found.kappa;
            if !joined
                && (gained < tolerances::KAPPA_GAIN
                    || kappa >= cap * (1.0 - tolerances::KAPPA_GAIN))
            {
                break;
            }
        }
        Ok((kappa, drive))
    }

    /// The largest factor between every row and its limit; below 1 where some miss.
    fn raise_margin(&mut self, start: Drive) -> Result<(f64, Drive)> {
        // hot and cold rows share the margin: in the end the drive is divided by the factor,
        // so that before it may exceed its limits by as much
        self.raise_contrast(start, |factor| factor.max(1.0))
    }

    /// The same with cold rows at their limit and all of the margin on the hot side: its
    /// square is the largest hot over limit. The drive shares the margin between both sides.
    pub(crate) fn raise_hot(&mut self, start: Drive) -> Result<(f64, Drive)> {
        let (factor, drive) = self.raise_contrast(start, |_| 1.0)?;
        Ok((factor.powi(2), drive))
    }

    fn raise_contrast(
        &mut self,
        start: Drive,
        larger_drive: impl Fn(f64) -> f64,
    ) -> Result<(f64, Drive)> {
        let (mut factor, mut drive) = (0.0, start);
        for _ in 0..self.rounds {
            let phases = self.program.phases(&drive);
            let Some((found, next)) =
                self.program
                    .largest_margin(&phases, &self.active, larger_drive(factor))?
            else {
                break;
            };
            drive = next;
            let joined = self.let_missed_join(&drive, 0.0, found);
            let gained = found / factor - 1.0;
            factor = found;
            if !joined && gained < tolerances::MARGIN_GAIN {
                break;
            }
        }
        Ok((factor, drive))
    }

    /// Most ground served by the rows that join by need, with the measured rows inside by
    /// `asked`. Of very many rows, whose programs take seconds, the first drive that serves all
    /// of them is taken.
    pub(crate) fn serve_ground(&mut self, start: Drive, asked: Asked) -> Result<Drive> {
        let sure = self.active.clone();
        let mut drive = start;
        for _ in 0..self.rounds {
            let joined = self.let_missed_join(&drive, 0.0, 1.0);
            let wished: Vec<usize> = self
                .active
                .iter()
                .copied()
                .filter(|k| sure.binary_search(k).is_err())
                .collect();
            let Some(next) =
                self.program
                    .least_missed(&self.program.phases(&drive), &sure, &wished, asked)?
            else {
                break;
            };
            let change = (&next - &drive)
                .iter()
                .map(Complex64::norm_sqr)
                .sum::<f64>()
                .sqrt();
            let size = next.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
            drive = next;
            let serves = sure.len() > tolerances::VERY_MANY_ROWS
                && self.problem.score(&drive).min_ratio == 1.0;
            if !joined && (serves || change < tolerances::SAME_DRIVE * size) {
                break;
            }
        }
        Ok(drive)
    }

    /// Adds the rows that miss most of what was asked; false where none does.
    fn let_missed_join(&mut self, drive: &Drive, kappa: f64, factor: f64) -> bool {
        let field = self.problem.field(drive).map(amplitude);
        let limits = self.problem.limits_m_per_s();
        let deviation = self.problem.covariance.deviation(drive);
        let slack = |k: usize| {
            let error = kappa * deviation / (limits[k] * self.problem.rows.levels[k]);
            match self.problem.rows.is_hot(k) {
                true => field[k] / limits[k] - factor - error,
                false => 1.0 / factor - field[k] / limits[k] - error,
            }
        };
        let mut missed: Vec<(f64, usize)> = (0..field.len())
            .filter(|k| self.active.binary_search(k).is_err())
            .map(|k| (slack(k), k))
            .filter(|&(slack, _)| slack < -tolerances::JOIN_SLACK)
            .collect();
        missed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        missed.truncate(self.joining);
        self.active.extend(missed.iter().map(|&(_, k)| k));
        self.active.sort_unstable();
        !missed.is_empty()
    }
}

/// Largest |A_i|.
pub(crate) fn peak(drive: &Drive) -> f64 {
    drive.iter().map(amplitude).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_model::test_problem;
    use ndarray::{Array2, Axis};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A problem of two hot rows and others that are cold.
    fn problem(mobility: Array2<Complex64>) -> Problem {
        let levels = Array1::ones(mobility.nrows());
        test_problem((mobility, levels), 2, 0.01, 100.0)
    }

    /// Of many rows that are alike one binds: it is found among very many rows as among few.
    #[test]
    fn very_many_rows_lead_to_the_drive_of_those_that_bind() {
        const COPIES: usize = 1000;
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut draw = || random.random_range(-1.0..1.0);
        let few = Array2::from_shape_fn((6, 5), |_| Complex64::new(draw(), draw()));
        let mut rows = vec![0, 1];
        rows.extend((2..6).flat_map(|row| [row; COPIES]));
        let mut many = few.select(Axis(0), &rows);
        for (k, mut row) in many.rows_mut().into_iter().enumerate().skip(2) {
            let binds = (k - 2) % COPIES == 73;
            row.mapv_inplace(|value| if binds { value } else { value * 0.3 });
        }
        assert!(many.nrows() > tolerances::VERY_MANY_ROWS);
        let asked = Asked {
            kappa: 1.0,
            factor: 1.0,
        };
        let solved = |mobility: Array2<Complex64>| {
            let problem = problem(mobility);
            let program = DriveProgram::new(&problem).unwrap();
            let all: Vec<usize> = (0..problem.rows.mobility.nrows()).collect();
            let phases = Array1::from_elem(2, Complex64::ONE);
            let found = program.least_peak(&phases, &all, asked).unwrap();
            let drive = found.expect("a drive");
            (peak(&drive), problem.score(&drive).kappa)
        };
        let ((of_few, _), (of_many, kappa)) = (solved(few), solved(many));
        assert!((of_many / of_few - 1.0).abs() < 1e-5, "{of_many} {of_few}");
        assert!(kappa > 1.0 - 1e-4, "{kappa}");
    }
}
