//! The endurance of a drive: the share of rigs on which its scene survives.
//!
//! κ speaks of the errors that were assumed. A rig as one finds it has amplifiers of 2 %
//! and 2°, natural frequencies 0.1 % off, and a light finger on its hot zone, all at once.
//! Such rigs are drawn from a seed and simulated in the model with the drive as it is: some
//! hundred fields, all by a few products of matrices, some rigs at a time so that these stay
//! in the cache; no more programs.

use crate::judging::rig_draw::{Draw, StressOptions};
use crate::panel::drive::Drive;
use crate::panel::finger::Finger;
use crate::panel::modal_field::{answer, guessed_scale, halves};
use crate::problems::problem::Problem;
use crate::problems::setup::Setup;
use crate::tolerances;
use chladni_frf::{Finding, ModalModel, Mode, Scaling, Trust};
use chladni_linalg::matmul;
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The endurance of a drive, simulated in its model. It serves a rig where it serves 95 % of
/// the hot and of the cold responses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Endurance {
    /// Share of the rigs that it serves.
    pub survival_ratio: f64,
    /// Rigs that were simulated.
    pub rigs: usize,
    /// Error of their gains, rms of the complex factor: that of amplifiers of 2 % and 2°, or
    /// what a calibration has left.
    pub gain_error: f64,
    /// The same share where only amplifiers err.
    pub amplifiers_alone: f64,
    /// The same where only natural frequencies are off.
    pub frequencies_alone: f64,
    /// The same where only a finger touches, over all hot responses.
    pub finger_alone: f64,
    /// False where the model is not mass-scaled, so that the size of the modes under the
    /// finger had to be guessed.
    pub touch_is_known: bool,
}

impl Endurance {
    /// Of `drive` in the scene that `setup` lays over `model`; `calibrated` is the error of
    /// the gains that a calibration has left.
    pub(crate) fn of(
        setup: &Setup,
        model: &ModalModel,
        drive: &Drive,
        calibrated: Option<f64>,
    ) -> Self {
        let finger = Finger::LIGHT;
        let mut amplifiers = StressOptions::default();
        let usual = amplifiers.gain_error();
        let gain_error = calibrated.unwrap_or(usual);
        amplifiers.amplitude_relative *= gain_error / usual;
        amplifiers.phase_deg *= gain_error / usual;
        let panel = Panel::new(setup, model);
        let modes = panel.modes.len();
        let alone = drive.view().insert_axis(Axis(1));
        let (still, forces) = (
            panel.answers(&Array2::ones((modes, 1))),
            panel.forces(alone),
        );
        let free = matmul(panel.mobility.view(), alone);
        let mut draw = Draw::new(tolerances::ENDURANCE_SEED);
        let firsts = (0..tolerances::ENDURANCE_RIGS).step_by(tolerances::RIGS_AT_ONCE);
        let some = firsts.map(|first| {
            let rigs = tolerances::RIGS_AT_ONCE.min(tolerances::ENDURANCE_RIGS - first);
            (first, drawn(&mut draw, &amplifiers, rigs, drive, modes))
        });
        let served = |(first, (driven, factors)): (usize, (Array2<Complex64>, Array2<f64>))| {
            let (driven, moved) = (driven.t(), panel.answers(&factors.reversed_axes()));
            let of_amplifiers = matmul(panel.mobility.view(), driven);
            let change = &moved - &still;
            let of_frequencies = &change * &forces;
            let of_both = change * panel.forces(driven);
            let of_all = panel.touched(&finger, first, &moved, &of_amplifiers, of_both);
            let of_frequencies = panel.of_modes(&of_frequencies) + &free;
            [&of_all, &of_amplifiers, &of_frequencies].map(|fields| panel.served(fields))
        };
        let served = some.collect::<Vec<_>>().into_par_iter().map(served);
        let add = |a: [usize; 3], b: [usize; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let served = served.reduce(|| [0; 3], add);
        let hot = setup.problem.rows.hot;
        let everywhere = Array2::zeros((free.nrows(), hot)) + free;
        let none = Array2::zeros((panel.shapes.ncols(), hot));
        let touched = panel.served(&panel.touched(&finger, 0, &still, &everywhere, none));
        let [survival_ratio, amplifiers_alone, frequencies_alone] =
            served.map(|count| count as f64 / tolerances::ENDURANCE_RIGS as f64);
        Self {
            survival_ratio,
            rigs: tolerances::ENDURANCE_RIGS,
            gain_error,
            amplifiers_alone,
            frequencies_alone,
            finger_alone: touched as f64 / hot as f64,
            touch_is_known: model.scaling == Scaling::UnitModalMass,
        }
    }

    /// A caution where too few rigs are served.
    pub(crate) fn finding(&self) -> Option<Finding> {
        if self.survival_ratio >= tolerances::SERVES {
            return None;
        }
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let how = match self.touch_is_known {
            true => "",
            false => " (estimated: no driving point was measured)",
        };
        let words = format!(
            "the scene survives on {} of {} simulated rigs (gains off by {:.1} % rms, natural \
             frequencies by {:.1} %, a light finger); with the gains alone on {}, the frequencies \
             alone on {}, the finger alone on {}{how}",
            percent(self.survival_ratio),
            self.rigs,
            100.0 * self.gain_error,
            100.0 * tolerances::ENDURANCE_FREQUENCY_ERROR,
            percent(self.amplifiers_alone),
            percent(self.frequencies_alone),
            percent(self.finger_alone)
        );
        let of_panel = self.frequencies_alone.min(self.finger_alone);
        let help = match self.amplifiers_alone < of_panel {
            true => "measure the field and correct the drive",
            false => "choose a less sensitive frequency",
        };
        Some(
            Finding::caution("rig-sensitive", words)
                .value("survival_ratio", self.survival_ratio)
                .value("amplifiers_alone", self.amplifiers_alone)
                .value("frequencies_alone", self.frequencies_alone)
                .value("finger_alone", self.finger_alone)
                .help(help),
        )
    }
}

/// The forces of the actuators for `drive`, axes (rig, actuator), and factors on the frequencies of
/// the modes, axes (rig, mode), of the next rigs.
fn drawn(
    draw: &mut Draw,
    amplifiers: &StressOptions,
    rigs: usize,
    drive: &Drive,
    modes: usize,
) -> (Array2<Complex64>, Array2<f64>) {
    let mut driven = Array2::zeros((rigs, drive.len()));
    let mut factors = Array2::zeros((rigs, modes));
    for (mut driven, mut factors) in driven.rows_mut().into_iter().zip(factors.rows_mut()) {
        driven.zip_mut_with(drive, |driven, weight| {
            *driven = weight * draw.gain(amplifiers);
        });
        let drawn = draw.factors(modes, tolerances::ENDURANCE_FREQUENCY_ERROR);
        factors.assign(&Array1::from(drawn));
    }
    (driven, factors)
}

/// The judged responses of a model, for many rigs at a time. A mode is one half where its
/// damping is structural, two of conjugates where it is viscous.
struct Panel<'a> {
    setup: &'a Setup,
    model: &'a ModalModel,
    modes: Vec<&'a Mode>,
    /// Axes (response, actuator).
    mobility: Array2<Complex64>,
    /// Axes (response, half).
    shapes: Array2<Complex64>,
    /// Axes (half, actuator).
    participations: Array2<Complex64>,
    /// Of each half; see [`guessed_scale`].
    scales: Array1<Complex64>,
    /// Squares of the velocities between which responses keep their limits and miss them.
    bounds: Vec<f64>,
}

impl<'a> Panel<'a> {
    fn new(setup: &'a Setup, model: &'a ModalModel) -> Self {
        let (operator, judged) = (&setup.operator, &setup.judged);
        let counts = |mode: &&Mode| mode.trust != Trust::Rejected;
        let modes: Vec<&Mode> = model.modes.iter().filter(counts).collect();
        let [shapes, participations] = halves(model.damping, &modes, operator, judged);
        let scale = |n: usize| guessed_scale(model, operator, modes[n % modes.len()]).into();
        let scales = (0..shapes.ncols()).map(scale).collect();
        let Problem { rows, limits, .. } = &setup.problem;
        let bound = |(k, level): (usize, &f64)| match rows.is_hot(k) {
            true => (limits.felt_from_m_per_s() * level).powi(2),
            false => (limits.quiet_to_m_per_s() * level).powi(2),
        };
        Self {
            bounds: rows.levels.iter().enumerate().map(bound).collect(),
            setup,
            model,
            scales,
            modes,
            mobility: operator.mobility.select(Axis(0), judged),
            shapes,
            participations,
        }
    }

    /// Modal forces; axes (half, rig).
    fn forces(&self, drives: ArrayView2<Complex64>) -> Array2<Complex64> {
        matmul(self.participations.view(), drives)
    }

    /// Velocities over shape times modal force, with the natural frequencies multiplied by
    /// `factors`, axes (mode, rig); axes (half, rig).
    fn answers(&self, factors: &Array2<f64>) -> Array2<Complex64> {
        let modes = self.modes.len();
        let mut answers = Array2::zeros((self.shapes.ncols(), factors.ncols()));
        for ((n, rig), &factor) in factors.indexed_iter() {
            let frequency_hz = self.setup.operator.frequency_hz;
            let halves = answer(self.model.damping, self.modes[n], frequency_hz, factor);
            for (half, value) in (n..self.shapes.ncols()).step_by(modes).zip(halves) {
                answers[[half, rig]] = value;
            }
        }
        answers
    }

    /// Velocities of what the halves do; axes (response, rig).
    fn of_modes(&self, halves: &Array2<Complex64>) -> Array2<Complex64> {
        matmul(self.shapes.view(), halves.view())
    }

    /// The fields `free`, axes (response, rig), where the halves do what `halves` says on
    /// top, axes (half, rig), with a finger on a hot response each (theory.md, eq. 52).
    ///
    /// * `first`: number of the first rig; the finger of rig 0 is on the first response
    /// * `answers`: of each rig, or of all
    fn touched(
        &self,
        finger: &Finger,
        first: usize,
        answers: &Array2<Complex64>,
        free: &Array2<Complex64>,
        mut halves: Array2<Complex64>,
    ) -> Array2<Complex64> {
        let operator = &self.setup.operator;
        let compliance = finger.impedance(operator.frequency_hz).inv();
        let all_answers = answers.broadcast(halves.dim()).expect("of each, or of all");
        let rigs = halves.columns_mut().into_iter().zip(all_answers.columns());
        for (rig, (mut halves, answers)) in rigs.enumerate() {
            let row = (first + rig) % self.setup.problem.rows.hot;
            let shape = self.shapes.row(row);
            let pressed = &shape * &self.scales * answers;
            let velocity = free[[row, rig]] + shape.dot(&halves);
            let force = velocity / (compliance + shape.dot(&pressed));
            halves.scaled_add(-force, &pressed);
        }
        self.of_modes(&halves) + free
    }

    /// The number of fields, axes (response, rig), that serve the responses of both kinds.
    fn served(&self, fields: &Array2<Complex64>) -> usize {
        let problem = &self.setup.problem;
        let serves = |field: &ArrayView1<Complex64>| {
            let squares = field.iter().map(Complex64::norm_sqr).zip(&self.bounds);
            let mut kept = [0; 2];
            for (k, (square, &bound)) in squares.enumerate() {
                match problem.rows.is_hot(k) {
                    true => kept[0] += usize::from(square >= bound),
                    false => kept[1] += usize::from(square <= bound),
                }
            }
            problem.min_ratio(kept[0], kept[1]) >= tolerances::SERVES
        };
        fields.columns().into_iter().filter(serves).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::modal_field::ModalField;
    use crate::scene::drift::Drift;
    use crate::scene::scene_file::Scene;
    use crate::test_model::test_model;
    use chladni_frf::Damping;
    use std::path::Path;

    /// Many rigs at a time are what each is by itself, in both damping laws.
    #[test]
    fn products_of_matrices_are_the_fields_of_single_rigs() {
        let text = "frequency_hz = 100.0\n[zones]\ngrid = [2, 1]\nhot = [1]\n\
                    transition_m = 0.001\n";
        for damping in [Damping::Structural, Damping::Viscous] {
            let modes = [(80.0, 0.08), (99.0, 0.03), (120.0, 0.05)];
            let mut model = test_model(damping, &modes, [12, 3]);
            model.scaling = Scaling::UnitModalMass;
            let scene = Scene::parse(text, Path::new("")).unwrap();
            let setup = Setup::new(&model, &scene, &Drift::default()).unwrap();
            let panel = Panel::new(&setup, &model);
            let drive = Drive::from_shape_fn(3, |j| Complex64::from_polar(1e-3, j as f64));
            let modal = ModalField::new(&model, &setup.operator, &drive);
            let judged = |field: Array1<Complex64>| field.select(Axis(0), &setup.judged);
            let near = |found: ArrayView1<Complex64>, expected: Array1<Complex64>| {
                let size = expected.iter().map(|v| v.norm()).fold(0.0, f64::max);
                let apart = (&found - &expected)
                    .iter()
                    .map(|v| v.norm())
                    .fold(0.0, f64::max);
                assert!(apart < 1e-12 * size, "{damping:?}: {apart} of {size}");
            };
            let still = panel.answers(&Array2::ones((3, 1)));
            let factors = Array2::from_shape_fn((3, 2), |(n, rig)| {
                1.0 + 0.01 * (n as f64 - 1.0) * (rig as f64 + 1.0)
            });
            let column = drive.view().insert_axis(Axis(1));
            let free = matmul(panel.mobility.view(), column);
            let change = &(&panel.answers(&factors) - &still) * &panel.forces(column);
            let moved = &free + &panel.of_modes(&change);
            let none = Array2::zeros((panel.shapes.ncols(), 1));
            let touched = panel.touched(&Finger::MID, 0, &still, &free, none);
            for rig in 0..2 {
                let alone = modal.with_frequencies(|n| factors[[n, rig]]);
                near(moved.column(rig), judged(alone));
            }
            let alone = |row: usize| modal.touched(&Finger::MID, setup.judged[row]).unwrap();
            near(touched.column(0), judged(alone(0)));
            // what the halves do on top, and a finger on the second response
            let resting = &panel.mobility.dot(&column) * 0.0;
            let halves = &still * &panel.forces(column);
            let touched = panel.touched(&Finger::MID, 1, &still, &resting, halves);
            near(touched.column(0), judged(alone(1)));
        }
    }
}
