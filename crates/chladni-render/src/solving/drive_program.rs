//! The conic programs of a scene: what a drive must keep, and what of it is to be largest
//! or least.
//!
//! With the phases φ_k of the hot rows held, all of these are convex in the drive A
//! (theory.md, eq. 44 to 47). Rows are divided by their limits V_k, forces by
//! [`DriveProgram::unit_drive`], and the error bar ‖L·A‖ by the threshold, so that every
//! number is of order one.

use crate::panel::drive::{Drive, DriveLimits};
use crate::problems::problem::Problem;
use crate::solving::conic::program::{Affine, ConicProgram, ConicSolution};
use crate::tolerances;
use chladni_frf::Result;
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::cell::{Cell, RefCell};

/// A problem scaled for conic programs.
pub(crate) struct DriveProgram<'a> {
    problem: &'a Problem,
    /// Drive that moves a typical row at its limit, N or V.
    unit_drive: f64,
    /// Mobility over the limit of each row, per unit drive; axes (row, actuator).
    rows: Array2<Complex64>,
    /// Threshold over the limit of each row.
    error_scale: Array1<f64>,
    /// Square root of the covariance over the threshold, per unit drive.
    root: Array2<Complex64>,
    /// Force or voltage limits.
    limits: DriveLimits,
    /// True once a drive went beyond the force limits: most scenes stay far below, and do
    /// without their cones.
    limited: Cell<bool>,
    /// Rows near their limits in the last solution: of many rows only these are in the next
    /// program at first.
    near: RefCell<Vec<usize>>,
}

/// The right-hand sides of the constraints, each an expression of the program's own
/// variables.
struct Sides {
    /// Hot rows: at least this, in their limits.
    hot: Affine,
    /// Cold rows: at most this, in their limits.
    cold: Affine,
    /// By so many thresholds every row must stay inside.
    slack: Affine,
    /// Bound of ‖L·A‖, in thresholds.
    deviation: Affine,
    /// Factor on the force limits.
    drive: f64,
    /// Variable that multiplies that factor.
    drive_variable: Option<usize>,
}

/// Margin inside their limits that the rows must keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Asked {
    /// Standard deviations.
    pub(crate) kappa: f64,
    /// Factor between hot rows and their limit, and between the limit of cold rows and
    /// them.
    pub(crate) factor: f64,
}

/// The largest κ of some phases, and the drive that has it.
pub(crate) struct Robust {
    /// Every row keeps its limit under errors of so many standard deviations; 0: some row
    /// cannot keep it.
    pub(crate) kappa: f64,
    /// The drive; `None` with κ = 0.
    pub(crate) drive: Option<Drive>,
}

impl<'a> DriveProgram<'a> {
    /// Scales `problem`.
    ///
    /// # Errors
    /// Those of the factorisation: a broken promise.
    pub(crate) fn new(problem: &'a Problem) -> Result<Self> {
        let mobility = &problem.rows.mobility;
        let limits = problem.limits_m_per_s();
        let mut rows = mobility.clone();
        for (mut row, &limit) in rows.rows_mut().into_iter().zip(&limits) {
            row.mapv_inplace(|value| value / limit);
        }
        let mean_square = rows.iter().map(Complex64::norm_sqr).sum::<f64>() / rows.len() as f64;
        let unit_drive = 1.0 / mean_square.sqrt();
        rows.mapv_inplace(|value| value * unit_drive);
        let threshold = problem.threshold_m_per_s;
        let root = problem
            .covariance
            .triangular_root()?
            .mapv(|value| value * (unit_drive / threshold));
        let error_scale = limits.mapv(|limit| threshold / limit) / &problem.rows.levels;
        Ok(Self {
            problem,
            unit_drive,
            rows,
            error_scale,
            root,
            limits: problem.drive_limits,
            limited: Cell::new(false),
            near: RefCell::default(),
        })
    }

    /// Number of actuators.
    fn actuators(&self) -> usize {
        self.rows.ncols()
    }

    /// Sets the largest |A_i|.
    pub(crate) fn limit_each(&mut self, each: f64) {
        self.limited.set(true);
        self.limits.each = each;
    }

    /// Phases of the hot rows under `drive`, as e^{−jφ}.
    pub(crate) fn phases(&self, drive: &Drive) -> Array1<Complex64> {
        let field = self.problem.rows.hot_rows().dot(drive);
        field.mapv(|value| {
            if value.norm() > 0.0 {
                value.conj() / value.norm()
            } else {
                Complex64::ONE
            }
        })
    }

    /// The drive with the largest κ up to `cap` for the hot `phases`, over the rows
    /// `active` (theory.md, eq. 45).
    ///
    /// κ·‖L·A‖ is a product of unknowns; divided by ‖L·A‖ the program is linear in κ,
    /// A/‖L·A‖ and 1/‖L·A‖.
    pub(crate) fn largest_kappa(
        &self,
        phases: &Array1<Complex64>,
        active: &[usize],
        cap: f64,
    ) -> Result<Robust> {
        let (kappa, inverse) = (2 * self.actuators(), 2 * self.actuators() + 1);
        let mut program = ConicProgram::new(inverse + 1);
        program.minimise(kappa, -1.0);
        program.not_negative(Affine::of(inverse, 1.0));
        program.not_negative(Affine::of(kappa, -1.0).plus_constant(cap));
        let sides = Sides {
            hot: Affine::of(inverse, 1.0),
            cold: Affine::of(inverse, 1.0),
            slack: Affine::of(kappa, 1.0),
            deviation: Affine::constant(1.0),
            drive: 1.0,
            drive_variable: Some(inverse),
        };
        let solution = self
            .solve(program, phases, active, &sides)?
            .filter(|solution| solution.x[kappa] > tolerances::NO_KAPPA);
        Ok(match solution {
            Some(solution) if solution.x[inverse] > 0.0 => Robust {
                kappa: solution.x[kappa],
                drive: Some(self.drive(&solution.x, 1.0 / solution.x[inverse])),
            },
            _ => Robust {
                kappa: 0.0,
                drive: None,
            },
        })
    }

    /// The drive of most contrast, hot rows at least and cold ones at most their limit by
    /// the same factor; and that factor, below 1 where not all can be had.
    ///
    /// * `reached`: a factor that is known to be possible, for the force limits; 1 where
    ///   none is
    pub(crate) fn largest_margin(
        &self,
        phases: &Array1<Complex64>,
        active: &[usize],
        reached: f64,
    ) -> Result<Option<(f64, Drive)>> {
        let (deviation, contrast) = (2 * self.actuators(), 2 * self.actuators() + 1);
        let mut program = ConicProgram::new(contrast + 1);
        program.minimise(contrast, -1.0);
        program.minimise(deviation, tolerances::DEVIATION_PRICE);
        let sides = Sides {
            hot: Affine::of(contrast, 1.0),
            cold: Affine::constant(1.0),
            slack: Affine::constant(0.0),
            deviation: Affine::of(deviation, 1.0),
            drive: reached,
            drive_variable: None,
        };
        let solution = self
            .solve(program, phases, active, &sides)?
            .filter(|solution| solution.x[contrast] > 0.0);
        Ok(solution.map(|solution| {
            // cold rows stand at their limit and hot ones at `contrast` times theirs:
            // share it
            let factor = solution.x[contrast].sqrt();
            (factor, self.drive(&solution.x, 1.0 / factor))
        }))
    }

    /// The drive with the largest margin that its force limits allow, inside by `kappa`
    /// standard deviations besides (eq. 46); and that factor.
    ///
    /// Hot rows stand at f times their limit, cold ones at 1/f of it, replaced by its
    /// tangent at `factor`: at most as much, and the same where f ends.
    pub(crate) fn wider(
        &self,
        phases: &Array1<Complex64>,
        active: &[usize],
        kappa: f64,
        factor: f64,
    ) -> Result<Option<(f64, Drive)>> {
        let (deviation, margin) = (2 * self.actuators(), 2 * self.actuators() + 1);
        let mut program = ConicProgram::new(margin + 1);
        program.minimise(margin, -1.0);
        program.minimise(deviation, tolerances::DEVIATION_PRICE);
        let sides = Sides {
            hot: Affine::of(margin, 1.0),
            cold: Affine::of(margin, -factor.powi(-2)).plus_constant(2.0 / factor),
            ..Sides::plain(deviation, Asked { kappa, factor })
        };
        let solution = self.solve(program, phases, active, &sides)?;
        Ok(solution.map(|solution| (solution.x[margin], self.drive(&solution.x, 1.0))))
    }

    /// The drive of least √Σ|A_i|² that keeps every row inside by `asked` (eq. 47).
    pub(crate) fn least_effort(
        &self,
        phases: &Array1<Complex64>,
        active: &[usize],
        asked: Asked,
    ) -> Result<Option<Drive>> {
        let (deviation, effort) = (2 * self.actuators(), 2 * self.actuators() + 1);
        let mut program = ConicProgram::new(effort + 1);
        program.minimise(effort, 1.0);
        program.norm_at_most(
            Affine::of(effort, 1.0),
            (0..2 * self.actuators()).map(|i| Affine::of(i, 1.0)),
        );
        Ok(self
            .solve(program, phases, active, &Sides::plain(deviation, asked))?
            .map(|solution| self.drive(&solution.x, 1.0)))
    }

    /// The drive of least max|A_i| that keeps every row inside by `asked`.
    pub(crate) fn least_peak(
        &self,
        phases: &Array1<Complex64>,
        active: &[usize],
        asked: Asked,
    ) -> Result<Option<Drive>> {
        let (deviation, peak) = (2 * self.actuators(), 2 * self.actuators() + 1);
        let mut program = ConicProgram::new(peak + 1);
        program.minimise(peak, 1.0);
        for i in 0..self.actuators() {
            program.norm_at_most(Affine::of(peak, 1.0), self.weight(i));
        }
        Ok(self
            .solve(program, phases, active, &Sides::plain(deviation, asked))?
            .map(|solution| self.drive(&solution.x, 1.0)))
    }

    /// The drive of least Σ price_i·|A_i| that keeps every row inside by `asked` (eq.
    /// 48).
    pub(crate) fn least_sum(
        &self,
        phases: &Array1<Complex64>,
        active: &[usize],
        asked: Asked,
        prices: &[f64],
    ) -> Result<Option<Drive>> {
        let deviation = 2 * self.actuators();
        let amplitude = |i: usize| deviation + 1 + i;
        let mut program = ConicProgram::new(amplitude(self.actuators()));
        for (i, &price) in prices.iter().enumerate() {
            program.minimise(amplitude(i), price);
            program.norm_at_most(Affine::of(amplitude(i), 1.0), self.weight(i));
        }
        Ok(self
            .solve(program, phases, active, &Sides::plain(deviation, asked))?
            .map(|solution| self.drive(&solution.x, 1.0)))
    }

    /// The drive that keeps the rows `sure` by `asked` and misses the limits of the rows
    /// `wished` by the least sum, each over its limit.
    ///
    /// A sum of shortfalls leaves most of them at zero, so that most ground is served
    /// where not all can be.
    pub(crate) fn least_missed(
        &self,
        phases: &Array1<Complex64>,
        sure: &[usize],
        wished: &[usize],
        asked: Asked,
    ) -> Result<Option<Drive>> {
        let deviation = 2 * self.actuators();
        let shortfall = |number: usize| deviation + 1 + number;
        let mut program = ConicProgram::new(shortfall(wished.len()));
        program.minimise(deviation, tolerances::DEVIATION_PRICE);
        for (number, &k) in wished.iter().enumerate() {
            program.minimise(shortfall(number), 1.0);
            program.not_negative(Affine::of(shortfall(number), 1.0));
            if self.problem.rows.is_hot(k) {
                program.not_negative(
                    self.along(k, phases)
                        .plus(shortfall(number), 1.0)
                        .plus_constant(-1.0),
                );
            } else {
                let bound = Affine::of(shortfall(number), 1.0).plus_constant(1.0);
                program.norm_at_most(bound, Affine::complex_row(self.rows.row(k)));
            }
        }
        Ok(self
            .solve(program, phases, sure, &Sides::plain(deviation, asked))?
            .map(|solution| self.drive(&solution.x, 1.0)))
    }

    /// Hot row `k` along its phase.
    fn along(&self, k: usize, phases: &Array1<Complex64>) -> Affine {
        let [along, _] =
            Affine::complex_row(self.rows.row(k).mapv(|value| value * phases[k]).view());
        along
    }

    fn weight(&self, i: usize) -> [Affine; 2] {
        [Affine::of(i, 1.0), Affine::of(self.actuators() + i, 1.0)]
    }

    /// The variables of a solution as a drive, times `factor`.
    fn drive(&self, x: &[f64], factor: f64) -> Drive {
        let count = self.actuators();
        Array1::from_shape_fn(count, |i| {
            Complex64::new(x[i], x[count + i]) * (self.unit_drive * factor)
        })
    }

    /// Solves `program` with rows, error bar and force limits besides.
    ///
    /// Few rows bind. Of many `active` ones, rising, those take part that were near their limits
    /// before, then those that the solution misses, until it misses none: the solution over all
    /// of them. Of very many only some begin, and the worst of each stretch join.
    fn solve(
        &self,
        program: ConicProgram,
        phases: &Array1<Complex64>,
        active: &[usize],
        sides: &Sides,
    ) -> Result<Option<ConicSolution>> {
        let (at_once, near_limit) = match active.len() > tolerances::VERY_MANY_ROWS {
            true => (tolerances::ROWS_AT_ONCE, tolerances::NEAR_LIMIT_OF_MANY),
            false => (active.len().max(1), tolerances::NEAR_LIMIT),
        };
        let mut part = self.near.take();
        part.retain(|k| active.binary_search(k).is_ok());
        if active.len() <= tolerances::FEW_ROWS || part.is_empty() {
            let step = active.len().div_ceil(at_once).max(1);
            part = active.iter().copied().step_by(step).collect();
        }
        loop {
            let solution = self.solve_over(program.clone(), phases, &part, sides)?;
            let Some(found) = solution.as_ref() else {
                // rows that are left out may be what bounds it
                if part.len() == active.len() {
                    return Ok(solution);
                }
                part = active.to_vec();
                continue;
            };
            let slack = self.slack(&found.x, phases, sides);
            let joins =
                |k: &usize| slack[*k] < -tolerances::CONIC_GAP && part.binary_search(k).is_err();
            let missed: Vec<usize> = active.iter().copied().filter(joins).collect();
            if missed.is_empty() {
                let taken = if at_once < active.len() {
                    &part
                } else {
                    active
                };
                let near = |k: &usize| slack[*k] < near_limit;
                *self.near.borrow_mut() = taken.iter().copied().filter(near).collect();
                return Ok(solution);
            }
            // the rows of one finger lie side by side and are alike
            let worst = missed
                .chunks(missed.len().div_ceil(at_once))
                .filter_map(|rows| {
                    let rows = rows.iter().copied();
                    rows.min_by(|a, b| slack[*a].total_cmp(&slack[*b]))
                });
            part.extend(worst);
            part.sort_unstable();
        }
    }

    /// By how much each row keeps what a solution asks of it, over the larger of both;
    /// negative where it misses.
    fn slack(&self, x: &[f64], phases: &Array1<Complex64>, sides: &Sides) -> Vec<f64> {
        let field = self.rows.dot(&self.drive(x, 1.0 / self.unit_drive));
        let [hot, cold, slack] = [&sides.hot, &sides.cold, &sides.slack].map(|side| side.at(x));
        let relative = |least: f64, most: f64| (most - least) / least.abs().max(most.abs());
        let of = |(k, value): (usize, &Complex64)| {
            let error = slack * self.error_scale[k];
            match self.problem.rows.is_hot(k) {
                true => relative(hot + error, (value * phases[k]).re),
                false => relative(value.norm(), cold - error),
            }
        };
        field.iter().enumerate().map(of).collect()
    }

    /// The same over the rows `active` alone, with the force limits only where they are
    /// met.
    fn solve_over(
        &self,
        mut program: ConicProgram,
        phases: &Array1<Complex64>,
        active: &[usize],
        sides: &Sides,
    ) -> Result<Option<ConicSolution>> {
        self.constrain(&mut program, phases, active, sides);
        if !self.limited.get() {
            let solution = program.solve()?;
            if solution
                .as_ref()
                .is_some_and(|solution| self.keeps_limits(&solution.x, sides))
            {
                return Ok(solution);
            }
            // without the limits there may be no largest or least value, or no drive that
            // keeps them
            self.limited.set(true);
        }
        self.limit_drive(&mut program, sides);
        program.solve()
    }

    /// True where the drive of a solution is within the force limits.
    fn keeps_limits(&self, x: &[f64], sides: &Sides) -> bool {
        let factor = sides.drive * sides.drive_variable.map_or(1.0, |variable| x[variable]);
        factor > 0.0 && self.limits.allowed_gain(&self.drive(x, 1.0 / factor)) >= 1.0
    }

    /// Rows and error bar.
    fn constrain(
        &self,
        program: &mut ConicProgram,
        phases: &Array1<Complex64>,
        active: &[usize],
        sides: &Sides,
    ) {
        let hot = self.problem.rows.hot;
        for &k in active.iter().filter(|&&k| k < hot) {
            program.not_negative(
                self.along(k, phases)
                    .minus(&sides.hot, 1.0)
                    .minus(&sides.slack, self.error_scale[k]),
            );
        }
        for &k in active.iter().filter(|&&k| k >= hot) {
            let bound = sides.cold.clone().minus(&sides.slack, self.error_scale[k]);
            program.norm_at_most(bound, Affine::complex_row(self.rows.row(k)));
        }
        let parts = self.root.rows().into_iter().flat_map(Affine::complex_row);
        program.norm_at_most(sides.deviation.clone(), parts);
    }

    fn limit_drive(&self, program: &mut ConicProgram, sides: &Sides) {
        let bound = |limit: f64| match sides.drive_variable {
            Some(variable) => Affine::of(variable, limit * sides.drive / self.unit_drive),
            None => Affine::constant(limit * sides.drive / self.unit_drive),
        };
        if self.limits.each.is_finite() {
            for i in 0..self.actuators() {
                program.norm_at_most(bound(self.limits.each), self.weight(i));
            }
        }
        if self.limits.effort.is_finite() {
            let all = (0..self.actuators()).flat_map(|i| self.weight(i));
            program.norm_at_most(bound(self.limits.effort), all);
        }
    }
}

impl Sides {
    /// Rows inside their limits by a factor and by κ times the variable `deviation`.
    fn plain(deviation: usize, asked: Asked) -> Self {
        Self {
            hot: Affine::constant(asked.factor),
            cold: Affine::constant(1.0 / asked.factor),
            slack: Affine::of(deviation, asked.kappa),
            deviation: Affine::of(deviation, 1.0),
            drive: 1.0,
            drive_variable: None,
        }
    }
}
