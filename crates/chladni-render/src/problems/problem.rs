//! The problem that every method solves: judged rows, limits, and how good a drive is in
//! the model.

use crate::panel::covariance::Covariance;
use crate::panel::drive::{amplitude, Drive, DriveLimits};
use crate::scene::limits::Limits;
use crate::scene::plane::Position;
use crate::scene::zones::ZoneMap;
use crate::tolerances;
use ndarray::{concatenate, s, Array1, Array2, ArrayView2, Axis};
use num_complex::Complex64;

/// Rows of the operator on judged ground, hot ones first.
#[derive(Clone)]
pub(crate) struct Rows {
    /// Mobility, axes (row, actuator).
    pub(crate) mobility: Array2<Complex64>,
    /// Number of hot rows.
    pub(crate) hot: usize,
    /// Position of each row, m.
    pub(crate) positions_m: Vec<Position>,
    /// Factor of each row's limit over the scene's; the mobility of the row is divided by it
    /// already.
    pub(crate) levels: Array1<f64>,
}

/// Judged rows (the transition left out), the limits, and the error bar of a drive.
#[derive(Clone)]
pub(crate) struct Problem {
    /// Judged responses.
    pub(crate) rows: Rows,
    /// Weight of the squared error of each row in least squares; 1 for measured
    /// responses.
    pub(crate) row_weights: Array1<f64>,
    /// Error of the mobility.
    pub(crate) covariance: Covariance,
    /// Velocity limits.
    pub(crate) limits: Limits,
    /// Threshold, m/s: the unit of error bars in conic programs.
    pub(crate) threshold_m_per_s: f64,
    /// Force or voltage limits.
    pub(crate) drive_limits: DriveLimits,
    /// κ that the responses keep even if ground between them is lost: `tolerances::KAPPA_LEAST`,
    /// or more once fields have corrected the mobility.
    pub(crate) kappa_least: f64,
}

/// Performance of a drive in the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score {
    /// Smaller of the hot and the cold ratio.
    pub(crate) min_ratio: f64,
    /// Rows inside their limit over all rows.
    pub(crate) success_ratio: f64,
    /// Largest κ with every row inside its limit by κ·‖L·A‖; negative where one misses,
    /// infinite without any model error.
    pub(crate) kappa: f64,
}

/// Chance that an amplitude `slack` inside its limit stays inside, under a complex error of
/// the standard deviation `deviation`, of which 1/√2 lies along its phase.
pub(crate) fn chance_above(slack: f64, deviation: f64) -> f64 {
    0.5 * libm::erfc(-slack / deviation)
}

impl Problem {
    /// A problem of measured responses, all of weight 1.
    pub(crate) fn new(
        rows: Rows,
        covariance: Covariance,
        limits: Limits,
        drive_limits: DriveLimits,
    ) -> Self {
        let row_weights = Array1::ones(rows.mobility.nrows());
        Self {
            rows,
            row_weights,
            covariance,
            limits,
            threshold_m_per_s: limits.threshold_m_per_s,
            drive_limits,
            kappa_least: tolerances::KAPPA_LEAST,
        }
    }

    /// True for the rows that [`Self::with_between`] took from `measured`.
    pub(crate) fn is_measured(&self, measured: &Self, row: usize) -> bool {
        self.rows.is_measured(&measured.rows, row)
    }

    /// The limit of a row, m/s.
    #[inline]
    pub(crate) fn limit_m_per_s(&self, row: usize) -> f64 {
        match self.rows.is_hot(row) {
            true => self.limits.hot_m_per_s,
            false => self.limits.cold_m_per_s,
        }
    }

    /// The limit of each row, m/s.
    pub(crate) fn limits_m_per_s(&self) -> Array1<f64> {
        let rows = 0..self.rows.mobility.nrows();
        rows.map(|row| self.limit_m_per_s(row)).collect()
    }

    /// The same problem with the columns `actuators` alone.
    pub(crate) fn with_actuators(&self, actuators: &[usize]) -> Self {
        let rows = self.rows.with_actuators(actuators);
        Self {
            rows,
            covariance: self.covariance.with_actuators(actuators),
            ..self.clone()
        }
    }

    /// The same problem with rows between the responses, of weight `weight` each.
    pub(crate) fn with_between(&self, between: &Rows, weight: f64) -> Self {
        let (measured, extra) = (&self.rows, between);
        let mobility = concatenate(
            Axis(0),
            &[
                measured.hot_rows(),
                extra.hot_rows(),
                measured.cold_rows(),
                extra.cold_rows(),
            ],
        );
        let (hot_m, cold_m) = measured.positions_m.split_at(measured.hot);
        let (hot_between_m, cold_between_m) = extra.positions_m.split_at(extra.hot);
        let rows = Rows {
            mobility: mobility.expect("rows of one operator"),
            hot: measured.hot + extra.hot,
            positions_m: [hot_m, hot_between_m, cold_m, cold_between_m].concat(),
            levels: concatenate![
                Axis(0),
                measured.levels.slice(s![..measured.hot]),
                extra.levels.slice(s![..extra.hot]),
                measured.levels.slice(s![measured.hot..]),
                extra.levels.slice(s![extra.hot..])
            ],
        };
        let weight_of = |row: usize| match rows.is_measured(measured, row) {
            true => 1.0,
            false => weight,
        };
        let row_weights = Array1::from_shape_fn(rows.mobility.nrows(), weight_of);
        Self {
            rows,
            row_weights,
            ..self.clone()
        }
    }

    /// Velocity on the rows, m/s.
    pub(crate) fn field(&self, drive: &Drive) -> Array1<Complex64> {
        self.rows.mobility.dot(drive)
    }

    /// The drive, turned so that the mean velocity of the hot rows has phase 0. A free phase
    /// then depends on no order of rows or axes.
    pub(crate) fn in_phase(&self, drive: Drive) -> Drive {
        let mean = self.rows.hot_rows().dot(&drive).sum();
        match mean.norm() {
            size if size > 0.0 => drive * (mean.conj() / size),
            _ => drive,
        }
    }

    /// Distance of a row of this amplitude from its limit, m/s of the panel; negative where it
    /// misses.
    pub(crate) fn slack(&self, row: usize, amplitude: f64) -> f64 {
        (amplitude - self.limit_m_per_s(row)) * self.slack_per_speed(row)
    }

    /// Slope of [`Self::slack`] over the amplitude: the level of a hot row, −1 of a cold one.
    pub(crate) fn slack_per_speed(&self, row: usize) -> f64 {
        match self.rows.is_hot(row) {
            true => self.rows.levels[row],
            false => -1.0,
        }
    }

    /// Amplitudes on the rows and standard deviation of each of the drives, m/s; axes
    /// (actuator, drive).
    pub(crate) fn fields(&self, drives: ArrayView2<Complex64>) -> Vec<(Array1<f64>, f64)> {
        let fields = chladni_linalg::matmul(self.rows.mobility.view(), drives);
        let amplitudes = fields
            .columns()
            .into_iter()
            .map(|field| field.map(amplitude));
        amplitudes.zip(self.covariance.deviations(drives)).collect()
    }

    /// Scores each of the drives; axes (actuator, drive).
    pub(crate) fn scores(&self, drives: ArrayView2<Complex64>) -> Vec<Score> {
        let fields = self.fields(drives).into_iter();
        fields
            .map(|(amplitudes, deviation)| self.score_of(&amplitudes, deviation))
            .collect()
    }

    /// Scores `drive`.
    pub(crate) fn score(&self, drive: &Drive) -> Score {
        self.score_of(
            &self.field(drive).map(amplitude),
            self.covariance.deviation(drive),
        )
    }

    /// The smaller share of hot and cold rows to be expected inside their limit.
    pub(crate) fn expected_ratio(&self, drive: &Drive) -> f64 {
        let mean = |chances: &[f64]| chances.iter().sum::<f64>() / chances.len() as f64;
        let [hot, cold] = self.chances(drive);
        mean(&hot).min(mean(&cold))
    }

    /// The chance of each hot and of each cold row to be inside its limit under `drive`, each
    /// amplitude with the standard deviation ‖L·A‖/√2 along its phase.
    pub(crate) fn chances(&self, drive: &Drive) -> [Vec<f64>; 2] {
        let spread = self.covariance.deviation(drive).max(f64::MIN_POSITIVE);
        let amplitudes = self.field(drive).map(amplitude);
        let chance = |(k, amplitude)| chance_above(self.slack(k, amplitude), spread);
        let mut hot: Vec<f64> = amplitudes.into_iter().enumerate().map(chance).collect();
        let cold = hot.split_off(self.rows.hot);
        [hot, cold]
    }

    /// Requires [`Self::kappa_of_confidence`] of the responses, even if ground between them is
    /// lost. For a mobility that fields have corrected: no field shows that ground.
    pub(crate) fn require_confident_kappa(&mut self) {
        self.kappa_least = self.kappa_of_confidence();
    }

    /// κ at which every row keeps its limit with `tolerances::CONFIDENCE`, or more
    /// (theory.md, section 10).
    pub(crate) fn kappa_of_confidence(&self) -> f64 {
        let each = (1.0 - tolerances::CONFIDENCE) / self.rows.mobility.nrows() as f64;
        (0.5 / each).ln().sqrt()
    }

    /// Scores a drive whose field has these amplitudes and this standard deviation, m/s.
    pub(crate) fn score_of(&self, amplitudes: &Array1<f64>, deviation: f64) -> Score {
        let (hot, cold) = self.counts(amplitudes, 1.0);
        let least = amplitudes
            .iter()
            .enumerate()
            .map(|(k, &amplitude)| self.slack(k, amplitude))
            .fold(f64::INFINITY, f64::min);
        Score {
            min_ratio: self.min_ratio(hot, cold),
            success_ratio: (hot + cold) as f64 / amplitudes.len() as f64,
            kappa: if deviation > 0.0 {
                least / deviation
            } else {
                f64::INFINITY.copysign(least)
            },
        }
    }

    /// Hot and cold rows inside their limit with the field scaled by `gain`.
    pub(crate) fn counts(&self, amplitudes: &Array1<f64>, gain: f64) -> (usize, usize) {
        let (hot, cold) = amplitudes.view().split_at(Axis(0), self.rows.hot);
        let felt = hot
            .iter()
            .filter(|&&v| self.limits.is_felt(gain * v))
            .count();
        (
            felt,
            cold.iter()
                .filter(|&&v| self.limits.is_quiet(gain * v))
                .count(),
        )
    }

    /// The smaller of both ratios.
    pub(crate) fn min_ratio(&self, hot: usize, cold: usize) -> f64 {
        (hot as f64 / self.rows.hot as f64).min(cold as f64 / self.rows.cold() as f64)
    }
}

impl Rows {
    /// Rows of mobility at `positions_m`, the first `hot` of them hot, with the levels of
    /// the zones they lie in.
    pub(crate) fn new(
        mut mobility: Array2<Complex64>,
        hot: usize,
        positions_m: Vec<Position>,
        zones: &ZoneMap,
    ) -> Self {
        let levels: Array1<f64> = positions_m
            .iter()
            .map(|&point| zones.level_at(point))
            .collect();
        let scaled = mobility.rows_mut().into_iter().zip(&levels);
        for (mut row, &level) in scaled.filter(|(_, &level)| level != 1.0) {
            row.mapv_inplace(|value| value / level);
        }
        Self {
            mobility,
            hot,
            positions_m,
            levels,
        }
    }

    /// True for a row to be felt.
    #[inline]
    pub(crate) fn is_hot(&self, row: usize) -> bool {
        row < self.hot
    }

    /// True for the rows that come from `measured`, with rows between them.
    fn is_measured(&self, measured: &Self, row: usize) -> bool {
        row < measured.hot || (self.hot..self.hot + measured.cold()).contains(&row)
    }

    /// The same rows with the columns `actuators` alone.
    pub(crate) fn with_actuators(&self, actuators: &[usize]) -> Self {
        Self {
            mobility: self.mobility.select(Axis(1), actuators),
            ..self.clone()
        }
    }

    /// Number of cold rows.
    pub(crate) fn cold(&self) -> usize {
        self.mobility.nrows() - self.hot
    }

    /// Rows to be felt.
    pub(crate) fn hot_rows(&self) -> ArrayView2<'_, Complex64> {
        self.mobility.slice(s![..self.hot, ..])
    }

    /// Rows to be quiet.
    pub(crate) fn cold_rows(&self) -> ArrayView2<'_, Complex64> {
        self.mobility.slice(s![self.hot.., ..])
    }
}
