//! A response whose phase is turned by one angle in every mode: an amplifier, a filter, an
//! integrator.
//!
//! As a delayed response it is told by the common phase of the others; its phases lie on a constant
//! instead of a line through zero. One constant must be likelier than phases of no order, and
//! clearly likelier than a delay (theory.md, eq. F2b).

use crate::checks::case::{Case, Checked};
use crate::checks::delay::Trials;
use crate::checks::delayed_response::{at_few_responses, ModePhases, OfResponse};
use crate::checks::limits;
use chladni_frf::Finding;

/// A response with its angle.
struct Turned {
    /// Its place.
    response: usize,
    /// rad, modulo 180°.
    angle: f64,
    /// rad, one sigma.
    deviation: f64,
}

/// Names responses that are turned against the others.
pub(crate) fn turned_responses(case: &Case) -> Option<Checked> {
    let responses = &case.model.responses;
    let found = at_few_responses(case, |response, seen, trials, natural| {
        turn_of(response, responses.len(), seen, trials, natural)
    })?;
    let named: Vec<String> = found
        .iter()
        .map(|own| {
            format!(
                "{} by {:+.1}° (± {:.1})",
                responses[own.response],
                own.angle.to_degrees(),
                own.deviation.to_degrees()
            )
        })
        .collect();
    let words = format!(
        "turned against the other responses in every mode alike, up to its sign: {}; poles are not \
         touched, but shapes are wrong there, and their scale where it is a driving point",
        named.join(", ")
    );
    let finding = Finding::caution("turned-response", words)
        .list("turn_deg", found.iter().map(|own| own.angle.to_degrees()))
        .dofs(found.iter().map(|own| responses[own.response]))
        .help("look at the signal path of the channel");
    Some(finding.into())
}

/// Angle by which a response is turned where the modes show one.
fn turn_of(
    response: usize,
    responses: usize,
    seen: &[ModePhases],
    trials: &Trials,
    natural: f64,
) -> Option<Turned> {
    let own = OfResponse::new(response, seen, natural)?;
    let phases = &own.phases;
    let (angle, left) = phases.turn();
    let known = phases.weight.iter().sum::<f64>().sqrt();
    let deviation = (left / (phases.count() - 1.0)).max(1.0).sqrt() / known;
    let looks = (1.0 + 2.0 * angle.abs() * known).ln() + (responses as f64).ln();
    let turned = phases.likelihood(left);
    let shown = turned - phases.of_no_order() > looks + limits::DELAY_LIKELIER
        && turned - phases.likelihood(own.delay(trials).left) > limits::DELAY_LIKELIER
        && phases.misfit(&phases.radians) - left > limits::DELAY_SIGMAS.powi(2)
        && angle.abs() > limits::DELAY_SIGMAS * deviation
        && angle.abs() > limits::LEAST_TURN;
    shown.then_some(Turned {
        response,
        angle,
        deviation,
    })
}
