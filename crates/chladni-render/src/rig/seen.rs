//! Measured fields as updates of the operator take them.

use super::agreement::Likeness;
use super::diagnosis::{diagnose, has_exchanged};
use super::field::{noise_assumed, LaidField, Prediction};
use super::lone_points::without_lone_points;
use super::played_field::PlayedField;
use super::swapped::{exchanged, swap_in_words, Swapped};
use crate::panel::drive::Drive;
use crate::panel::operator::Operator;
use crate::problems::setup::Setup;
use crate::results::evaluate::{laid, Laid, On};
use crate::results::weights::Weights;
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

/// Measured fields as updates take them.
pub(super) struct AllSeen {
    /// Each under the drive that the actuators had: swapped cables exchange two weights.
    pub(super) fields: Vec<Seen>,
    /// The channels whose cables are swapped under the newest one.
    pub(super) swapped: Option<[usize; 2]>,
}

/// The fields laid over the operator, each with its drive. Each tells two swapped cables by itself,
/// since cables may be exchanged from one to the next; where one does, the same cables are asked
/// about in the others.
pub(super) fn see(
    setup: &Setup,
    scene: &Scene,
    model: &ModalModel,
    played: &[PlayedField],
    dead: &[Dof],
    findings: &mut Vec<Finding>,
) -> Result<AllSeen> {
    let operator = &setup.operator;
    let compared: Vec<Compared> = (1..)
        .zip(played)
        .map(|(number, pair)| {
            let drive = drive_of(&pair.weights, setup, scene, model, dead)?;
            Compared::new(setup, model, pair, drive, number == 1)
        })
        .collect::<Result<_>>()?;
    let of_any = compared
        .iter()
        .rev()
        .find_map(|field| field.swapped.as_ref());
    let of_any = of_any.map(|swapped| swapped.channels);
    let mut all = AllSeen {
        fields: Vec::with_capacity(played.len()),
        swapped: None,
    };
    let mut assumed = false;
    for (number, mut compared) in (1..).zip(compared) {
        let swapped = compared.swapped_channels(model, operator, of_any)?;
        let drive = match swapped {
            Some(pair) => exchanged(&compared.prediction.drive, pair),
            None => compared.prediction.drive.clone(),
        };
        let mut told: Vec<Finding> = Vec::from_iter(compared.lone.take());
        if number == 1 {
            let foretold = compared.prediction.mobility.dot(&drive);
            told.extend(Likeness::of(&foretold, &compared.field).finding());
        }
        told.extend(few_responses(compared.field.rows.len()));
        let is_newest = number == played.len();
        if let Some(pair) = swapped {
            let references = pair.map(|channel| operator.references[channel]);
            let own = compared.swapped.map(|swapped| swapped.finding());
            told.push(taken_so(own, references, is_newest));
        }
        let of_field = |finding: Finding| match played.len() {
            1 => finding,
            _ => finding.about(format_args!("field {number}")),
        };
        findings.extend(told.into_iter().map(of_field));
        assumed |= compared.field.noise_assumed;
        all.fields.push(Seen::of(compared.field, drive));
        all.swapped = swapped;
    }
    if assumed {
        findings.push(noise_assumed());
    }
    Ok(all)
}

/// A measured field beside its prediction.
struct Compared {
    field: LaidField,
    prediction: Prediction,
    /// The finding of points that were replaced.
    lone: Option<Finding>,
    /// Swapped cables that it tells by itself.
    swapped: Option<Swapped>,
}

impl Compared {
    /// * `is_first`: its form is checked; that of a later one is held against what those before it
    ///   taught
    ///
    /// # Errors
    /// A field that is not of these weights, at another level, or of another form; those of the
    /// factorisations.
    fn new(
        setup: &Setup,
        model: &ModalModel,
        pair: &PlayedField,
        drive: Drive,
        is_first: bool,
    ) -> Result<Self> {
        let operator = &setup.operator;
        let mut field = LaidField::new(&pair.field, operator, pair.weights_sha256.as_deref())?;
        let prediction = Prediction::of(operator, &field.rows, drive);
        let lone = without_lone_points(&mut field, &prediction.mobility, &operator.responses)?;
        let likeness = Likeness::of(&prediction.velocity, &field);
        likeness.check_level()?;
        if is_first {
            likeness.check()?;
        }
        let deviation = setup.problem.covariance.deviation(&prediction.drive);
        let nis = field.nis(&prediction.velocity, deviation);
        let (_, swapped) = diagnose(model, operator, &field, &prediction, nis)?;
        Ok(Self {
            field,
            prediction,
            lone,
            swapped,
        })
    }

    /// The channels whose cables were swapped under this field: those that it tells by itself, else
    /// `of_any`, which another one tells, where the field is likelier with them exchanged.
    fn swapped_channels(
        &self,
        model: &ModalModel,
        operator: &Operator,
        of_any: Option<[usize; 2]>,
    ) -> Result<Option<[usize; 2]>> {
        if let Some(swapped) = &self.swapped {
            return Ok(Some(swapped.channels));
        }
        let Some(pair) = of_any else {
            return Ok(None);
        };
        let is_exchanged = has_exchanged(model, operator, &self.field, &self.prediction, pair)?;
        Ok(is_exchanged.then_some(pair))
    }
}

/// The finding of a field that is taken as that of swapped cables.
///
/// * `own`: what the field itself tells of them; `None` where another one does
fn taken_so(own: Option<Finding>, references: [Dof; 2], is_newest: bool) -> Finding {
    let code = "channels-swapped";
    if !is_newest {
        let [one, other] = references;
        let words = format!(
            "the cables of {one} and {other} were swapped when this field was measured, and it is \
             taken so"
        );
        let finding = Finding::note(code, words).dofs(references);
        return finding.help("nothing to do: they are no longer swapped under the newest field");
    }
    let finding =
        own.unwrap_or_else(|| Finding::caution(code, swap_in_words(references)).dofs(references));
    finding.help(
        "the corrected weights are for the rig as it is: play them with these cables swapped; what is \
         learned of the rig is for cables in their right places: exchange both before the next scene, \
         and measure the field again",
    )
}

/// The drive of `weights` over the actuators of the scene.
fn drive_of(
    weights: &Weights,
    setup: &Setup,
    scene: &Scene,
    model: &ModalModel,
    dead: &[Dof],
) -> Result<Drive> {
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
    Ok(whole)
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
