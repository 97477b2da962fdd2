//! One fit or one drive against its truth, and whether it knew that it failed.

use crate::journal::nan;
use crate::mode_columns::{columns_of_unit_length, residue_factor};
use crate::problem::{Bounds, Problem};
use crate::score::Score;
use crate::statistics::root_mean_square;
use chladni_frf::{FrfSet, ModalModel, Mode, Trust};
use chladni_linalg::{matmul, matmul_h, qr_thin, svd_thin};
use chladni_rfp::{fit, FitOptions};
use ndarray::{Array1, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// An error beyond so many of its own standard deviations is a wrong result.
pub(crate) const BEYOND: f64 = 5.0;
/// Beginnings of the warnings that speak of the damping law alone, or of the scale of
/// shapes alone.
const LAW_ALONE: [&str; 2] = [
    "damping law undecidable",
    "the damping law rests on the phases",
];
const SCALE_ALONE: [&str; 2] = ["the driving point lies near", "shapes are not mass-scaled"];
/// Standard deviations of the noise that a mode must stand out by for the data to show
/// it.
const VISIBLE: f64 = 5.0;
/// Powers of ω that stand for the world outside in what the data can show.
const RESIDUAL_POWERS: [i32; 4] = [-2, 0, 2, 4];
/// Powers of x = (ω/ω_max)² that stand for the world outside in the basis whose condition
/// is told.
const BASIS_POWERS: [i32; 4] = [-1, 0, 1, 2];

/// A measurement that a stability map asks for.
pub(crate) struct Measured {
    /// With noise and whatever else went wrong.
    pub(crate) frf: FrfSet,
    /// Its truth.
    pub(crate) problem: Problem,
    /// The options of its fit; the method is put in later.
    pub(crate) options: FitOptions,
    /// White noise is all that stands between data and model, so that bounds hold.
    pub(crate) bounded: bool,
}

/// The outcome of one try.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Trial {
    /// True modes that were found; of a drive: 1 where it serves.
    pub found: usize,
    /// True modes that were not.
    pub missed: usize,
    /// Missed ones that the data do not show: what no other mode could stand in for lies
    /// within five standard deviations of the noise.
    pub hidden: usize,
    /// Modes without a partner, said to be sure.
    pub spurious_sure: usize,
    /// The same, said to be weak.
    pub spurious_weak: usize,
    /// Found modes whose error is beyond five of its stated standard deviations.
    pub beyond: usize,
    /// Modes said to be weak.
    pub weak: usize,
    /// The result says that it can be trusted; of a drive: that it is feasible.
    pub trusted: bool,
    /// Warnings of the result, or the refusal.
    pub warnings: Vec<String>,
    /// No result at all.
    pub refused: bool,
    /// χ² per degree of freedom as the result states it; of a drive: κ.
    #[serde(deserialize_with = "nan")]
    pub chi2: f64,
    /// Condition number of the basis of the true model.
    #[serde(deserialize_with = "nan")]
    pub condition: f64,
    /// Root mean square error of the natural frequencies found, over the Cramér-Rao bound
    /// of real shapes.
    #[serde(deserialize_with = "nan")]
    pub error_over_bound: f64,
    /// Largest error of a found mode over its stated standard deviation; of a drive: the
    /// share of ground that is served, the smaller one of hot and cold.
    #[serde(deserialize_with = "nan")]
    pub error: f64,
    /// Errors of natural frequency and loss factor over their stated standard deviations.
    pub standardised: Vec<[f64; 2]>,
}

impl Trial {
    /// Missed, spurious or merged modes, or an error beyond what the result states; a
    /// drive that does not serve.
    pub fn wrong(&self) -> bool {
        self.missed + self.spurious_sure + self.spurious_weak + self.beyond > 0
    }

    /// Wrong in more than that modes are missed which the data do not show.
    pub fn visibly_wrong(&self) -> bool {
        self.missed - self.hidden + self.spurious_sure + self.spurious_weak + self.beyond > 0
    }

    /// A weak mode, a warning, a refusal, or a result that says it is not to be trusted.
    /// That the damping law is undecidable counts where the law can be what is wrong, and
    /// tells nothing of missed or spurious modes; nor does what is said of the scale of
    /// shapes alone.
    pub fn announced(&self) -> bool {
        let of_law = self.beyond > 0 && self.missed + self.spurious_sure + self.spurious_weak == 0;
        let begins = |text: &str, with: &[&str]| with.iter().any(|words| text.starts_with(words));
        let tells =
            |text: &String| (of_law || !begins(text, &LAW_ALONE)) && !begins(text, &SCALE_ALONE);
        self.weak > 0 || !self.trusted || self.refused || self.warnings.iter().any(tells)
    }

    /// Identifies what was measured.
    pub(crate) fn identify(measured: &Measured, method: chladni_rfp::Method) -> Self {
        let Measured {
            frf,
            problem,
            options,
            bounded,
        } = measured;
        let lean = method.as_str() == "lean" && options.modes.is_none();
        // `lean` is for those who know the order
        let modes = if lean {
            Some(problem.truth.in_band_modes().count())
        } else {
            options.modes
        };
        let fitted = fit(
            frf,
            &FitOptions {
                method,
                modes,
                ..options.clone()
            },
        );
        let condition = condition(&problem.truth, &problem.clean.frequency_hz);
        match fitted {
            Ok(fitted) => Self {
                condition,
                ..Self::of_model(&fitted.model, problem, *bounded)
            },
            Err(error) => Self {
                missed: problem.truth.in_band_modes().count(),
                refused: true,
                warnings: vec![error.to_string()],
                chi2: f64::NAN,
                error_over_bound: f64::NAN,
                error: f64::NAN,
                condition,
                ..Self::default()
            },
        }
    }

    fn of_model(model: &ModalModel, problem: &Problem, bounded: bool) -> Self {
        let score = Score::new(model, problem);
        let bounds = match bounded {
            true => problem.bounds().ok().flatten(),
            false => None,
        };
        let known: Vec<&Mode> = problem.truth.in_band_modes().collect();
        let found: Vec<_> = score
            .matches
            .iter()
            .enumerate()
            .filter_map(|(n, found)| Some((n, found.as_ref()?)))
            .collect();
        let standardised: Vec<[f64; 2]> =
            found.iter().map(|(_, found)| found.over_stated).collect();
        let worst = |pair: &[f64; 2]| pair[0].abs().max(pair[1].abs());
        let hidden = |n: usize| evidence(problem, known[n]) < VISIBLE;
        let over_bound = |bounds: &Bounds| {
            let bounds_hz = &bounds.real.frequency_std_hz;
            let errors = found.iter();
            root_mean_square(errors.map(|(n, found)| found.frequency_hz / bounds_hz[*n]))
        };
        Self {
            found: found.len(),
            missed: score.missed(),
            hidden: score
                .matches
                .iter()
                .enumerate()
                .filter(|(n, found)| found.is_none() && hidden(*n))
                .count(),
            spurious_sure: score.spurious_sure,
            spurious_weak: score.spurious_weak,
            beyond: standardised
                .iter()
                .filter(|pair| worst(pair) > BEYOND)
                .count(),
            weak: model
                .in_band_modes()
                .filter(|mode| mode.trust == Trust::Weak)
                .count(),
            trusted: model.quality.trusted,
            warnings: model
                .quality
                .findings
                .iter()
                .map(|f| f.text.clone())
                .collect(),
            refused: false,
            chi2: model.quality.chi2_per_dof,
            condition: f64::NAN,
            error_over_bound: bounds.as_ref().map_or(f64::NAN, over_bound),
            error: standardised.iter().map(worst).fold(f64::NAN, f64::max),
            standardised,
        }
    }
}

/// Level of a mode above the noise, in standard deviations: the part of its FRFs that
/// neither the other modes, with their poles free to move, nor residual terms can take
/// over. Infinite without noise.
fn evidence(problem: &Problem, mode: &Mode) -> f64 {
    let omega: Vec<f64> = problem.clean.frequency_hz.iter().map(|f| TAU * f).collect();
    let kind: Vec<Complex64> = omega
        .iter()
        .map(|&w| problem.truth.frf_kind.from_receptance(w))
        .collect();
    let factor = |mode: &Mode| {
        omega
            .iter()
            .map(|&w| residue_factor(mode, problem.truth.damping, w))
            .collect::<Vec<_>>()
    };
    let column = |values: &dyn Fn(usize) -> Complex64| {
        (0..omega.len())
            .map(|k| kind[k] * values(k))
            .collect::<Array1<_>>()
    };
    let mut columns = Vec::new();
    for other in problem.truth.modes.iter().filter(|other| *other != mode) {
        let own = factor(other);
        columns.push(column(&|k| own[k]));
        columns.push(column(&|k| own[k] * own[k]));
    }
    columns.extend(RESIDUAL_POWERS.map(|power| {
        column(&|k| Complex64::from((omega[k] / omega[omega.len() - 1]).powi(power)))
    }));
    let own = factor(mode);
    let wanted = column(&|k| own[k]).insert_axis(Axis(1));
    let Ok((q, _)) = qr_thin(columns_of_unit_length(&columns).view()) else {
        return f64::NAN;
    };
    let left = &wanted - &matmul(q.view(), matmul_h(q.view(), wanted.view()).view());
    let energy = |values: &[Complex64]| values.iter().map(|value| value.norm_sqr()).sum::<f64>();
    let residues = energy(&mode.shape.0) * energy(&mode.participation.0);
    (2.0 * residues * left.iter().map(|value| value.norm_sqr()).sum::<f64>()
        / problem.noise_variance)
        .sqrt()
}

/// Condition number of the columns 1/(λ_n − x) of all true poles and the powers of x on
/// these lines, each of unit length; NaN where no singular value can be had.
fn condition(truth: &ModalModel, frequency_hz: &Array1<f64>) -> f64 {
    let top = frequency_hz
        .iter()
        .copied()
        .fold(f64::MIN_POSITIVE, f64::max)
        * TAU;
    let x: Vec<f64> = frequency_hz
        .iter()
        .map(|f| (TAU * f / top).powi(2))
        .collect();
    let poles = truth.modes.iter().map(|mode| {
        let square = (TAU * mode.frequency_hz / top).powi(2);
        Complex64::new(square, square * mode.loss_factor)
    });
    let mut columns: Vec<Array1<Complex64>> = poles
        .map(|pole| x.iter().map(|&x| (pole - x).inv()).collect())
        .collect();
    columns.extend(BASIS_POWERS.map(|power| {
        x.iter()
            .map(|&x| Complex64::from(x.powi(power)))
            .collect::<Array1<_>>()
    }));
    let values = svd_thin(columns_of_unit_length(&columns).view()).map(|(_, values, _)| values);
    values
        .ok()
        .and_then(|values| Some(values.first()? / values.last()?))
        .unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_plate::Synthetic;
    use chladni_rfp::Method;

    fn measured(seed: u64) -> Measured {
        let problem = Problem::of_modes(&Synthetic::default()).unwrap();
        Measured {
            frf: problem.measured(seed),
            problem,
            options: FitOptions::default(),
            bounded: true,
        }
    }

    #[test]
    fn a_good_fit_is_right_and_quiet() {
        let trial = Trial::identify(&measured(3), Method::Auto);
        assert!(!trial.wrong() && !trial.announced(), "{trial:?}");
        assert_eq!((trial.found, trial.standardised.len()), (3, 3));
        assert!(
            trial.error < BEYOND && trial.error_over_bound < 3.0 && trial.condition > 1.0,
            "{trial:?}"
        );
    }

    #[test]
    fn an_error_beyond_its_bar_is_wrong_and_a_refusal_is_announced() {
        let measured = measured(3);
        let mut model = fit(&measured.frf, &FitOptions::default()).unwrap().model;
        // a notice that the law cannot be known would announce errors
        model.quality.findings.clear();
        model
            .modes
            .iter_mut()
            .for_each(|mode| mode.frequency_std_hz /= 1e3);
        let trial = Trial::of_model(&model, &measured.problem, true);
        assert!(
            trial.wrong() && trial.beyond > 0 && !trial.announced(),
            "{trial:?}"
        );

        let nowhere = Measured {
            options: FitOptions {
                band_hz: Some([1e6, 2e6]),
                ..FitOptions::default()
            },
            ..measured
        };
        let trial = Trial::identify(&nowhere, Method::Auto);
        assert!(
            trial.refused && trial.announced() && trial.visibly_wrong() && trial.missed == 3,
            "{trial:?}"
        );
    }

    #[test]
    fn a_mode_stands_out_by_its_energy_and_hides_behind_its_neighbour() {
        let of = |second: f64, snr_db: f64| {
            let spec = Synthetic {
                natural_frequency_hz: vec![40.0, second, 110.0],
                snr_db,
                ..Synthetic::default()
            };
            let problem = Problem::of_modes(&spec).unwrap();
            evidence(&problem, &problem.truth.modes[1])
        };
        // 20 dB less noise: ten times
        assert!((of(70.0, 60.0) / of(70.0, 40.0) - 10.0).abs() < 1e-6);
        assert!(
            of(70.0, 40.0) > 100.0 && of(40.01, 40.0) < 0.01 * of(70.0, 40.0),
            "{} {}",
            of(70.0, 40.0),
            of(40.01, 40.0)
        );
    }

    #[test]
    fn the_condition_rises_where_modes_merge() {
        let of = |second: f64| {
            let spec = Synthetic {
                natural_frequency_hz: vec![40.0, second, 110.0],
                ..Synthetic::default()
            };
            let problem = Problem::of_modes(&spec).unwrap();
            condition(&problem.truth, &problem.clean.frequency_hz)
        };
        // columns of poles that merge differ by their distance to first order
        assert!(
            (of(40.000_1) / of(40.001) - 10.0).abs() < 0.5 && of(40.001) > of(70.0),
            "{} {} {}",
            of(40.000_1),
            of(40.001),
            of(70.0)
        );
    }
}
