//! Functions to be written: those of a set, and all others in SI.

use super::scaling::{exponents, motion_code, COHERENCE, EXCITATION_FORCE, FREQUENCY, FRF};
use crate::unit_label;
use crate::{Abscissa, Axis, Function, Ordinate};
use chladni_frf::{Dof, FrfKind, FrfSet, FrfValues, ReferenceUnit};
use std::borrow::Cow;

/// One FRF of a set; `None` where it was not measured.
pub(super) fn frf(set: &FrfSet, response: usize, reference: usize) -> Option<Function> {
    let pair = ndarray::s![response, reference, ..];
    let ordinate = match &set.values {
        FrfValues::F64(values) => Ordinate::Complex64(values.slice(pair).to_vec()),
        FrfValues::F32(values) => Ordinate::Complex32(values.slice(pair).to_vec()),
    };
    let measured = match &ordinate {
        Ordinate::Complex64(values) => values.iter().any(|v| !v.re.is_nan()),
        Ordinate::Complex32(values) => values.iter().any(|v| !v.re.is_nan()),
        Ordinate::Real32(_) | Ordinate::Real64(_) => false,
    };
    let dofs = [set.responses[response], set.references[reference]];
    let axes = [
        frequency_axis(),
        response_axis(set.kind, dofs[0]),
        reference_axis(set, dofs[1]),
        Axis::default(),
    ];
    measured.then(|| function(set, FRF, dofs, axes, ordinate))
}

/// Coherence of a pair; `None` where it was not measured.
pub(super) fn coherence(set: &FrfSet, response: usize, reference: usize) -> Option<Function> {
    let values = set
        .coherence
        .as_ref()?
        .slice(ndarray::s![response, reference, ..])
        .to_vec();
    let dofs = [set.responses[response], set.references[reference]];
    let axes = [
        frequency_axis(),
        Axis::default(),
        Axis::default(),
        Axis::default(),
    ];
    values
        .iter()
        .any(|v| !v.is_nan())
        .then(|| function(set, COHERENCE, dofs, axes, Ordinate::Real32(values)))
}

/// ID lines with the estimation of the set, where it is known.
fn estimated(set: &FrfSet) -> [String; 5] {
    let mut lines: [String; 5] = Default::default();
    if let Some(made) = &set.estimation {
        lines[4] = made.to_string();
    }
    lines
}

fn function(
    set: &FrfSet,
    function_type: i32,
    [response, reference]: [Dof; 2],
    axes: [Axis; 4],
    ordinate: Ordinate,
) -> Function {
    Function {
        function_type,
        id_lines: estimated(set),
        ids: [0; 3],
        entity_names: Default::default(),
        response,
        reference,
        abscissa: Abscissa::Even {
            start: 0.0,
            step: 1.0,
        },
        z: 0.0,
        axes,
        ordinate,
        kind: set.kind,
        reference_unit: set.reference_unit,
        scale_to_si: 1.0,
        abscissa_to_si: 1.0,
        line: 0,
        warnings: Vec::new(),
    }
}

fn frequency_axis() -> Axis {
    Axis {
        quantity: FREQUENCY,
        exponents: [0; 3],
        label: "Frequency".into(),
        unit: "Hz".into(),
    }
}

fn response_axis(kind: Option<FrfKind>, dof: Dof) -> Axis {
    let Some(kind) = kind else {
        return Axis::default();
    };
    let (label, translation, rotation) = match kind {
        FrfKind::Receptance => ("Displacement", "m", "rad"),
        FrfKind::Mobility => ("Velocity", "m/s", "rad/s"),
        FrfKind::Accelerance => ("Acceleration", "m/s^2", "rad/s^2"),
    };
    with_exponents(
        motion_code(kind),
        label,
        if is_rotation(dof) {
            rotation
        } else {
            translation
        },
        dof,
    )
}

fn reference_axis(set: &FrfSet, dof: Dof) -> Axis {
    match (set.reference_unit, set.kind) {
        (ReferenceUnit::Newton, Some(_)) => with_exponents(
            EXCITATION_FORCE,
            "Force",
            if is_rotation(dof) { "N*m" } else { "N" },
            dof,
        ),
        (ReferenceUnit::Newton, None) => Axis::default(),
        (ReferenceUnit::Volt, _) => Axis {
            quantity: 1,
            exponents: [0; 3],
            label: "Voltage".into(),
            unit: "V".into(),
        },
    }
}

fn is_rotation(dof: Dof) -> bool {
    dof.direction.axis().code() >= 4
}

fn with_exponents(quantity: i32, label: &str, unit: &str, dof: Dof) -> Axis {
    let axis = Axis {
        quantity,
        exponents: [0; 3],
        label: label.into(),
        unit: unit.into(),
    };
    let [length, force] = exponents(&axis, dof.direction).unwrap_or([0, 0]);
    Axis {
        exponents: [length, force, 0],
        ..axis
    }
}

/// The function with values and abscissa in SI, the units of dataset 164 in our files.
pub(super) fn in_si(function: &Function) -> Cow<'_, Function> {
    if function.scale_to_si == 1.0 && function.abscissa_to_si == 1.0 {
        return Cow::Borrowed(function);
    }
    let mut scaled = function.clone();
    let scale = function.scale_to_si;
    if scale != 1.0 {
        let single = |y: f32| (f64::from(y) * scale) as f32;
        match &mut scaled.ordinate {
            Ordinate::Real32(values) => values.iter_mut().for_each(|y| *y = single(*y)),
            Ordinate::Real64(values) => values.iter_mut().for_each(|y| *y *= scale),
            Ordinate::Complex32(values) => values
                .iter_mut()
                .for_each(|y| *y = num_complex::Complex32::new(single(y.re), single(y.im))),
            Ordinate::Complex64(values) => values.iter_mut().for_each(|y| *y *= scale),
        }
        si_labels(&mut scaled);
        scaled.scale_to_si = 1.0;
    }
    if function.abscissa_to_si != 1.0 {
        let factor = function.abscissa_to_si;
        match &mut scaled.abscissa {
            Abscissa::Even { start, step } => (*start, *step) = (*start * factor, *step * factor),
            Abscissa::Uneven(values) => values.iter_mut().for_each(|x| *x *= factor),
        }
        scaled.axes[0].unit = si_unit(scaled.axes[0].quantity).into();
        scaled.abscissa_to_si = 1.0;
    }
    Cow::Owned(scaled)
}

/// Puts SI into the unit labels of a function whose values were scaled.
fn si_labels(function: &mut Function) {
    let [_, numerator, denominator, _] = &mut function.axes;
    match function.kind {
        // where codes do not tell the kind, the label of the numerator has the whole unit
        Some(kind)
            if numerator.quantity != motion_code(kind)
                || (denominator.quantity != EXCITATION_FORCE
                    && function.reference_unit == ReferenceUnit::Newton) =>
        {
            numerator.unit = kind.unit(function.reference_unit);
            denominator.unit.clear();
        }
        _ => {
            for axis in [numerator, denominator] {
                match unit_label::parse(&axis.unit) {
                    Some(unit) if unit.factor == 1.0 => {}
                    Some(unit) if unit.is_voltage() => axis.unit = "V".into(),
                    _ => axis.unit = si_unit(axis.quantity).into(),
                }
            }
        }
    }
}

/// SI unit of a quantity code, translations.
fn si_unit(quantity: i32) -> &'static str {
    match quantity {
        8 => "m",
        11 => "m/s",
        12 => "m/s^2",
        9 | 13 => "N",
        2 | 15 => "Pa",
        16 => "kg",
        17 => "s",
        18 => "Hz",
        _ => "",
    }
}
