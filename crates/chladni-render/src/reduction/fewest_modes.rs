//! The fewest modes that a scene needs.
//!
//! Modes are ranked by what folding them into residual terms would leave out at the drive
//! frequency (module `folding`); the best M stay explicit, and what the others leave out
//! counts as an error of the model, so that no drive leans on it. M grows until the drive
//! found by the reduced model alone, replayed through the whole model or through the
//! measured line, keeps every response inside its limit: the error e_k = |(H_M − H)_k·A|
//! must fit into the slack that A has in H_M (theory.md, eq. 51). Where not even the
//! whole model serves every response, the reduced one must serve as many.

use crate::methods::choice::Decision;
use crate::methods::options::RenderOptions;
use crate::panel::drive::Drive;
use crate::panel::operator::Operator;
use crate::problems::problem::{Problem, Rows};
use crate::problems::setup::Setup;
use crate::reduction::folding::{self, Foldable};
use crate::rig::gain_of;
use crate::scene::actuators::Actuators;
use crate::scene::count::Count;
use crate::tolerances;
use chladni_frf::{Dof, Error, Finding, FrfSet, ModalModel, Result};
use ndarray::Array2;
use num_complex::Complex64;

/// Replays the drives of reduced models: in the whole model, or on the measured line at the drive
/// frequency.
pub(crate) struct Judge {
    /// Judged responses, as the whole model or the measured line has them.
    points: Problem,
    /// Rows of `points` among the judged rows of the setup.
    rows: Vec<usize>,
    /// The whole model at all judged rows.
    whole: Array2<Complex64>,
    /// Findings about it.
    pub(crate) findings: Vec<Finding>,
    /// Responses and ground between them; only the whole model knows it.
    ground: Option<Problem>,
}

impl Judge {
    /// The whole model of `setup`, also `between` the responses.
    pub(crate) fn of_model(setup: &Setup, between: bool) -> Self {
        let ground = Some(setup)
            .filter(|_| between)
            .and_then(Setup::between)
            .map(|rows| setup.problem.with_between(rows, 1.0));
        Self {
            points: setup.problem.clone(),
            rows: (0..setup.judged.len()).collect(),
            whole: setup.problem.rows.mobility.clone(),
            findings: Vec::new(),
            ground,
        }
    }

    /// The measured line at the drive frequency, with the gains that `actuators` says.
    ///
    /// # Errors
    /// No such line; an actuator in use, or every response, was not measured; other
    /// units.
    pub(crate) fn of_line(setup: &Setup, frf: &FrfSet, actuators: &Actuators) -> Result<Self> {
        let operator = &setup.operator;
        let line = Operator::of_line(frf, operator.frequency_hz, Some(&operator.references))?;
        if line.unit != operator.unit {
            return Err(
                Error::bad_data("the measured FRFs and the model have different units")
                    .field("measured")
                    .found(line.unit)
                    .expected(format!(
                        "{}, the unit of the model's references",
                        operator.unit
                    )),
            );
        }
        let place = |known: &[Dof], dof: Dof| known.iter().position(|other| other.same_axis(dof));
        let column = |&dof: &Dof| {
            let column = place(&line.references, dof)?;
            let sign = dof.direction.sign() * line.references[column].direction.sign();
            Some((column, sign))
        };
        let columns: Vec<(usize, f64)> = operator.references.iter().filter_map(column).collect();
        let gains = line.references.iter();
        let gains: Vec<Complex64> = gains
            .map(|&reference| gain_of(actuators, reference, operator.frequency_hz))
            .collect::<Result<_>>()?;
        let row = |k: usize| {
            let dof = operator.responses[setup.judged[k]];
            Some((k, place(&line.responses, dof)?))
        };
        let pairs: Vec<(usize, usize)> = (0..setup.judged.len()).filter_map(row).collect();
        let hot = pairs
            .iter()
            .filter(|(k, _)| *k < setup.problem.rows.hot)
            .count();
        if hot == 0 || hot == pairs.len() {
            return Err(cannot_judge(hot, pairs.len() - hot));
        }
        let mobility = Array2::from_shape_fn((pairs.len(), columns.len()), |(i, j)| {
            let (column, sign) = columns[j];
            line.mobility[[pairs[i].1, column]] * gains[column] * sign
        });
        let positions_m = pairs
            .iter()
            .map(|&(k, _)| setup.problem.rows.positions_m[k])
            .collect();
        let rows = Rows::new(mobility, hot, positions_m, &setup.zones);
        let points = Problem::new(
            rows,
            setup.problem.covariance.clone(),
            setup.limits,
            setup.problem.drive_limits,
        );
        Ok(Self {
            points,
            rows: pairs.into_iter().map(|(k, _)| k).collect(),
            whole: setup.problem.rows.mobility.clone(),
            findings: line.findings,
            ground: None,
        })
    }

    /// Shares of responses (least zone, all) and of ground that `drive` serves.
    pub(crate) fn served(&self, drive: &Drive) -> [f64; 3] {
        let score = self.points.score(drive);
        let ground = self
            .ground
            .as_ref()
            .map_or(1.0, |ground| ground.score(drive).success_ratio);
        [score.min_ratio, score.success_ratio, ground]
    }

    /// True where the error of `reduced` fits into the slack that `drive` has in it, at
    /// every response. The part of a measured line that not even the whole model explains
    /// is noise, and asks for no more modes.
    fn error_fits(&self, reduced: &Problem, drive: &Drive) -> bool {
        let (seen, predicted, whole) = (
            self.points.field(drive),
            reduced.field(drive),
            self.whole.dot(drive),
        );
        let limits = reduced.limits_m_per_s();
        self.rows.iter().enumerate().all(|(i, &k)| {
            let amplitude = predicted[k].norm();
            let slack = if reduced.rows.is_hot(k) {
                amplitude - limits[k]
            } else {
                limits[k] - amplitude
            };
            (seen[i] - predicted[k]).norm() <= slack.max(0.0) + (seen[i] - whole[k]).norm()
        })
    }
}

/// The error of a measured line without hot or without cold responses.
fn cannot_judge(hot: usize, cold: usize) -> Error {
    Error::bad_data("the measured FRFs cannot judge this scene")
        .field("measured")
        .found(format!(
            "{hot} hot and {cold} cold responses of the scene among the measured ones"
        ))
        .expected("at least one of each")
        .help("give the FRFs that the model was fitted to")
}

/// A setup whose model sums so many modes explicitly.
pub(crate) struct Reduced {
    pub(crate) setup: Setup,
    pub(crate) finding: Option<Finding>,
}

/// Chooses the modes of `model` that stay explicit for the scene of `setup`.
///
/// # Errors
/// Those of the methods.
pub(crate) fn choose(
    setup: Setup,
    model: &ModalModel,
    judge: &Judge,
    options: &RenderOptions,
) -> Result<Reduced> {
    match options.modes {
        Count::All => Ok(Reduced {
            setup,
            finding: None,
        }),
        Count::Number(number) => {
            let ranked = folding::ranked(model, &setup.operator);
            let finding = (number > ranked.len()).then(|| {
                let words = format!(
                    "{} asked for, the model has {}",
                    if number == 1 {
                        "1 mode was".to_owned()
                    } else {
                        format!("{number} modes were")
                    },
                    ranked.len()
                );
                Finding::note("fewer-modes-in-model", words)
            });
            Ok(Reduced {
                setup: reduced(&setup, model, &ranked, number.min(ranked.len())),
                finding,
            })
        }
        Count::Auto => fewest(setup, model, judge, options),
    }
}

/// The fewest modes with which the scene of `setup` is served as well.
fn fewest(
    setup: Setup,
    model: &ModalModel,
    judge: &Judge,
    options: &RenderOptions,
) -> Result<Reduced> {
    let solve = |setup: &Setup| -> Result<Drive> {
        let Decision { method, effort, .. } = options.method.decide(&setup.problem, options.effort);
        Ok(method.solve(setup, model, effort, options.cut)?.drive)
    };
    let (ranked, whole) = (folding::ranked(model, &setup.operator), solve(&setup)?);
    let wanted = judge.served(&whole);
    let Decision { method, .. } = options.method.decide(&setup.problem, options.effort);
    for explicit in method.least_modes()..ranked.len() {
        let smaller = reduced(&setup, model, &ranked, explicit);
        // the drive of the whole model is a cheap test: where the error of so few modes does
        // not fit into its slack, the search goes on without a solution
        if wanted[0] == 1.0 && !judge.error_fits(&smaller.problem, &whole) {
            continue;
        }
        let drive = solve(&smaller)?;
        let served = judge.served(&drive);
        let as_good = served[0] >= wanted[0]
            && served[1] >= wanted[1]
            && served[2] >= wanted[2] - tolerances::LOSS_OF_GROUND;
        if as_good && (wanted[0] < 1.0 || judge.error_fits(&smaller.problem, &drive)) {
            return Ok(Reduced {
                setup: smaller,
                finding: None,
            });
        }
    }
    Ok(Reduced {
        setup,
        finding: Some(Finding::note(
            "all-modes-needed",
            "no smaller number of modes serves the scene as well: all are used",
        )),
    })
}

/// The setup with the first `explicit` modes of `ranked` summed, the others folded.
fn reduced(setup: &Setup, model: &ModalModel, ranked: &[Foldable], explicit: usize) -> Setup {
    let mut mobility = setup.operator.mobility.clone();
    let folded = &ranked[explicit..];
    let mut errors = Array2::zeros((folded.len(), setup.operator.references.len()));
    for (foldable, mut error) in folded.iter().zip(errors.rows_mut()) {
        let mode = &model.modes[foldable.mode];
        foldable
            .remainder
            .take_from(&mut mobility, mode, &setup.operator);
        let columns = &setup.operator.reference_columns;
        let rms = (columns
            .iter()
            .map(|&j| mode.participation.0[j].norm_sqr())
            .sum::<f64>()
            / columns.len() as f64)
            .sqrt();
        let scale = if rms > 0.0 { foldable.size / rms } else { 0.0 };
        for (value, &column) in error.iter_mut().zip(columns) {
            *value = mode.participation.0[column] * Complex64::from(scale);
        }
    }
    let modes = ranked[..explicit]
        .iter()
        .map(|foldable| foldable.mode)
        .collect();
    setup.with_model(mobility, errors, modes)
}
