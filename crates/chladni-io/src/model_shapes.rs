//! Shapes of a modal model, and the field that a drive causes, for programs that draw them.

use super::{Analysis, Shape, ShapeForm, ShapeNumbers, TRANSLATION};
use chladni_frf::{Dof, Error, FrfKind, ModalModel, Mode, Result, Scaling};
use ndarray::Array2;
use num_complex::Complex64;

/// Components of translations and rotations.
const TRANSLATION_AND_ROTATION: usize = 6;
/// Quantity codes of datasets 55 and 2414.
const DISPLACEMENT: i64 = 8;
const VELOCITY: i64 = 11;

/// One shape for each mode of the band that is not `rejected`.
///
/// A real shape becomes a normal mode (frequency, modal mass, ζ, η). Any other becomes a
/// complex mode of first order with λ = −ζω_n + jω_n√(1−ζ²). Where the model is mass-scaled,
/// that has modal A = 2jω_n√(1−ζ²) and B = −λA.
pub fn model_shapes(model: &ModalModel, form: ShapeForm) -> Vec<Shape> {
    model
        .in_band_modes()
        .enumerate()
        .map(|(k, mode)| mode_shape(model, mode, k as i64 + 1, form))
        .collect()
}

fn mode_shape(model: &ModalModel, mode: &Mode, number: i64, form: ShapeForm) -> Shape {
    let shape = at_nodes(&model.responses, &mode.shape.0, form);
    let scaled = model.scaling == Scaling::UnitModalMass;
    let complex = mode.shape.0.iter().any(|value| value.im != 0.0);
    let eigenvalue = mode.viscous_pole();
    let modal_a = if scaled {
        Complex64::new(0.0, 2.0 * eigenvalue.im)
    } else {
        Complex64::default()
    };
    let numbers = ShapeNumbers {
        load_case: 1,
        number,
        frequency_hz: mode.frequency_hz,
        ..ShapeNumbers::default()
    };
    let numbers = match complex {
        false => ShapeNumbers {
            modal_mass: if scaled { 1.0 } else { 0.0 },
            viscous: mode.damping_ratio,
            hysteretic: mode.loss_factor,
            ..numbers
        },
        true => ShapeNumbers {
            eigenvalue,
            modal_a,
            modal_b: -eigenvalue * modal_a,
            ..numbers
        },
    };
    Shape {
        name: format!("Mode {number}, {} Hz", mode.frequency_hz),
        analysis: if complex {
            Analysis::ComplexModeFirstOrder
        } else {
            Analysis::NormalMode
        },
        quantity: DISPLACEMENT,
        complex,
        numbers,
        ..shape
    }
}

/// The velocities at the responses, m/s, peak, that `drive` causes at `frequency_hz`.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] for an actuator that the model does not have.
pub fn field_shape(
    model: &ModalModel,
    frequency_hz: f64,
    drive: &[(Dof, Complex64)],
    form: ShapeForm,
) -> Result<Shape> {
    let mobility = model.frf_matrix(FrfKind::Mobility, frequency_hz);
    let mut velocity = vec![Complex64::default(); model.responses.len()];
    for (actuator, weight) in drive {
        let column = model
            .references
            .iter()
            .position(|dof| dof == actuator)
            .ok_or_else(|| {
                Error::bad_data("the model has no such actuator")
                    .field("weights")
                    .found(actuator)
                    .expected("references of the model")
                    .help("give the model that the weights were made for")
            })?;
        velocity
            .iter_mut()
            .zip(mobility.column(column))
            .for_each(|(v, y)| *v += y * weight);
    }
    Ok(Shape {
        name: format!("Velocity at {frequency_hz} Hz, m/s peak"),
        analysis: Analysis::FrequencyResponse,
        quantity: VELOCITY,
        complex: true,
        numbers: ShapeNumbers {
            load_case: 1,
            number: 1,
            frequency_hz,
            ..ShapeNumbers::default()
        },
        ..at_nodes(&model.responses, &velocity, form)
    })
}

/// Vectors at nodes from values along DOFs; the value of a DOF along a negative axis changes
/// its sign.
fn at_nodes(dofs: &[Dof], values: &[Complex64], form: ShapeForm) -> Shape {
    let mut nodes: Vec<u64> = dofs.iter().map(|dof| dof.node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let rotates = dofs
        .iter()
        .any(|dof| dof.direction.axis().code() as usize > TRANSLATION);
    let components = if rotates {
        TRANSLATION_AND_ROTATION
    } else {
        TRANSLATION
    };
    let mut at_nodes = Array2::zeros((nodes.len(), components));
    for (dof, value) in dofs.iter().zip(values) {
        let row = nodes.partition_point(|&node| node < dof.node);
        // a scalar has no axis; it is drawn along Z, as plates are measured
        let axis = match dof.direction.axis().code() {
            0 => 2,
            code => code as usize - 1,
        };
        at_nodes[[row, axis]] = value * dof.direction.sign();
    }
    Shape {
        form,
        name: String::new(),
        id_lines: [
            chladni_frf::CREATED_BY.into(),
            String::new(),
            String::new(),
            String::new(),
            String::new(),
        ],
        model_type: 1,
        analysis: Analysis::Other(0),
        characteristic: if rotates { 3 } else { 2 },
        quantity: 0,
        reference: None,
        numbers: ShapeNumbers::default(),
        complex: true,
        nodes,
        values: at_nodes,
        scale_to_si: 1.0,
        line: 0,
        warnings: Vec::new(),
    }
}
