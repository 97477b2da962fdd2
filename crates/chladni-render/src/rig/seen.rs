//! Measured fields as updates of the operator take them.

use super::agreement::Likeness;
use super::diagnosis::diagnose;
use super::field::{noise_assumed, LaidField, Prediction};
use super::lone_points::without_lone_points;
use super::played_field::PlayedField;
use crate::panel::drive::Drive;
use crate::problems::setup::Setup;
use crate::results::evaluate::{laid, Laid, On};
use crate::scene::scene_file::Scene;
use crate::tolerances;
use chladni_frf::{Dof, Error, Finding, ModalModel, Result};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// A measured field as an update takes it.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    /// The drive that made it.
    pub(crate) drive: Drive,
    /// Rows of the operator that were measured.
    pub(crate) rows: Vec<usize>,
    /// Velocities there, m/s; magnitudes where phases are unknown.
    pub(crate) velocity: Array1<Complex64>,
    /// Root of the mean square of their standard deviations, m/s.
    pub(crate) noise: f64,
    /// True where phases are unknown.
    pub(crate) magnitudes_only: bool,
}

impl Seen {
    /// A laid field, under the drive that made it.
    pub(crate) fn of(field: LaidField, drive: Drive) -> Self {
        let square = field.std.iter().map(|std| std * std).sum::<f64>() / field.std.len() as f64;
        Self {
            drive,
            rows: field.rows,
            velocity: field.velocity,
            noise: square.sqrt(),
            magnitudes_only: field.magnitudes_only,
        }
    }

    /// The values with the phases that `mobility` foretells, where they have none.
    pub(crate) fn phased(&self, mobility: &Array2<Complex64>) -> Array1<Complex64> {
        if !self.magnitudes_only {
            return self.velocity.clone();
        }
        let foretold = mobility.select(Axis(0), &self.rows).dot(&self.drive);
        let pairs = self.velocity.iter().zip(&foretold);
        pairs
            .map(|(seen, foretold)| {
                foretold * (seen.norm() / foretold.norm().max(f64::MIN_POSITIVE))
            })
            .collect()
    }

    /// Form and level against what `mobility` foretells.
    pub(super) fn likeness(&self, mobility: &Array2<Complex64>) -> Likeness {
        let foretold = mobility.select(Axis(0), &self.rows).dot(&self.drive);
        Likeness::between(&foretold, &self.phased(mobility), self.magnitudes_only)
    }
}

/// The fields laid over the operator, each with its drive. The newest tells two swapped cables.
pub(super) fn see(
    setup: &Setup,
    scene: &Scene,
    model: &ModalModel,
    played: &[PlayedField],
    dead: &[Dof],
    findings: &mut Vec<Finding>,
) -> Result<Vec<Seen>> {
    let mut assumed = false;
    let mut all = Vec::with_capacity(played.len());
    for (number, pair) in (1..).zip(played) {
        let weights = &pair.weights;
        let asked = scene.frequency_hz;
        if (weights.frequency_hz - asked).abs() > tolerances::SAME_FREQUENCY * asked {
            return Err(Error::bad_data("the weights are for another frequency")
                .field("weights.frequency_hz")
                .found(format!("{} Hz", weights.frequency_hz))
                .expected(format!("{asked} Hz, as the scene"))
                .help("give weights that were rendered for this scene"));
        }
        let Laid {
            operator, drive, ..
        } = laid(weights, scene, On::Model(model))?;
        let mut whole = Drive::zeros(setup.operator.references.len());
        for (reference, &weight) in operator.references.iter().zip(&drive) {
            // what was played into a dead channel moved nothing
            if dead.iter().any(|dead| dead.same_axis(*reference)) {
                continue;
            }
            let place = setup
                .operator
                .references
                .iter()
                .position(|known| known == reference);
            let place = place.ok_or_else(|| {
                Error::bad_data("the weights drive an actuator that the scene does not use")
                    .field("weights")
                    .found(reference)
                    .expected("the actuators of the scene")
                    .help("use the same actuators in the scene, or render its weights anew")
            })?;
            whole[place] = weight;
        }
        if whole.iter().all(|weight| weight.norm() == 0.0) {
            return Err(Error::bad_data("a field without a drive tells nothing")
                .field("weights")
                .found("weights of zero")
                .expected("weights that drive at least one sound actuator")
                .help("give the weights that were played"));
        }
        let mut field =
            LaidField::new(&pair.field, &setup.operator, pair.weights_sha256.as_deref())?;
        let mobility = setup.operator.mobility.select(Axis(0), &field.rows);
        let responses = &setup.operator.responses;
        let off = without_lone_points(&mut field, &mobility, responses)?;
        let predicted = mobility.dot(&whole);
        let of_field = |finding: Finding| match played.len() {
            1 => finding,
            _ => finding.about(format_args!("field {number}")),
        };
        let mut told: Vec<Finding> = Vec::from_iter(off);
        let likeness = Likeness::of(&predicted, &field);
        likeness.check_level()?;
        if number == 1 {
            // the form of a later one is held against what those before it taught
            likeness.check()?;
            told.extend(likeness.finding());
        }
        told.extend(few_responses(field.rows.len()));
        if number == played.len() {
            // cables may have been exchanged since the fields before
            let prediction = Prediction {
                velocity: predicted,
                mobility,
                drive: whole.clone(),
            };
            let (_, swapped) = diagnose(model, &setup.operator, &field, &prediction)?;
            told.extend(swapped);
        }
        findings.extend(told.into_iter().map(of_field));
        assumed |= field.noise_assumed;
        all.push(Seen::of(field, whole));
    }
    if assumed {
        findings.push(noise_assumed());
    }
    Ok(all)
}

/// The finding of a field with too few responses to learn from.
fn few_responses(held: usize) -> Option<Finding> {
    let responses = match held {
        1 => "one response".to_owned(),
        _ => format!("{held} responses"),
    };
    let words = format!(
        "a field of {responses} cannot tell one fault from another: what is corrected by it is \
         hardly more than a guess"
    );
    (held < tolerances::FEW_RESPONSES).then(|| {
        Finding::caution("field-few-responses", words)
            .value("responses", held as f64)
            .help("measure eight responses or more, spread over the panel")
    })
}
