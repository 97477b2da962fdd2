//! `/shapes/K`: mode shapes and fields of a source file, K = 1, 2, ...: `nodes` [node],
//! `values` [node, component] in the units of the source, everything else as attributes
//! named as in [`Shape`].

use super::own::Own;
use crate::arrays::tree::{Attribute, Entry, Group, Values};
use crate::arrays::values::{integers, wrong_type, ComplexArray};
use crate::{Analysis, Shape, ShapeForm, ShapeNumbers};
use chladni_frf::{Dof, Error, Result};
use ndarray::{Array2, Ix2};
use num_complex::Complex64;

/// Names of the ID lines.
const ID_LINES: [&str; 5] = [
    "id_line_1",
    "id_line_2",
    "id_line_3",
    "id_line_4",
    "id_line_5",
];

/// Group `/shapes`.
pub(super) fn shapes_group(shapes: &[Shape]) -> Group<'_> {
    let mut all = Group::new("shapes");
    all.groups = shapes
        .iter()
        .enumerate()
        .map(|(k, shape)| shape_group(k + 1, shape))
        .collect();
    all
}

fn shape_group(number: usize, shape: &Shape) -> Group<'_> {
    let mut group = Group::new(number.to_string());
    let Shape {
        form,
        name,
        id_lines,
        numbers,
        reference,
        nodes,
        values,
        ..
    } = shape;
    group.set(
        "dataset",
        Attribute::Integer(if *form == ShapeForm::AtNodes55 {
            55
        } else {
            2414
        }),
    );
    group.set("name", Attribute::FixedText(name.clone()));
    for (key, line) in ID_LINES.iter().zip(id_lines) {
        group.set(key, Attribute::FixedText(line.clone()));
    }
    for (key, value) in [
        ("model_type", shape.model_type),
        ("analysis", shape.analysis.code()),
        ("characteristic", shape.characteristic),
        ("quantity", shape.quantity),
        ("complex", i64::from(shape.complex)),
        ("load_case", numbers.load_case),
        ("number", numbers.number),
    ] {
        group.set(key, Attribute::Integer(value));
    }
    if let Some(dof) = reference {
        group.set("reference", Attribute::FixedText(dof.to_string()));
    }
    for (key, value) in [
        ("time_s", numbers.time_s),
        ("frequency_hz", numbers.frequency_hz),
        ("modal_mass", numbers.modal_mass),
        ("viscous", numbers.viscous),
        ("hysteretic", numbers.hysteretic),
        ("eigenvalue_re", numbers.eigenvalue.re),
        ("eigenvalue_im", numbers.eigenvalue.im),
        ("modal_a_re", numbers.modal_a.re),
        ("modal_a_im", numbers.modal_a.im),
        ("modal_b_re", numbers.modal_b.re),
        ("modal_b_im", numbers.modal_b.im),
        ("scale_to_si", shape.scale_to_si),
    ] {
        group.set(key, Attribute::Real(value));
    }
    group.add("nodes", &[nodes.len()], Values::Unsigned(nodes.into()));
    let flat: Vec<Complex64> = values.iter().copied().collect();
    group.add(
        "values",
        &[values.nrows(), values.ncols()],
        Values::Complex64(flat.into()),
    );
    group
}

/// All shapes of a file, by rising number.
pub(super) fn read_shapes(own: &Own<'_>) -> Result<Vec<Shape>> {
    own.numbered("/shapes")?
        .into_iter()
        .map(|entry| read_shape(own, entry))
        .collect()
}

fn read_shape(own: &Own<'_>, group: &Entry) -> Result<Shape> {
    let missing = |name: &str| {
        let error =
            Error::bad_data("an attribute is missing").field(format!("{name} of {}", group.path));
        error
            .found("nothing")
            .expected("every attribute of a shape")
    };
    let text = |name: &str| {
        group
            .text(name)
            .map(str::to_owned)
            .ok_or_else(|| missing(name))
    };
    let whole = |name: &str| group.integer(name).ok_or_else(|| missing(name));
    let real = |name: &str| group.real(name).ok_or_else(|| missing(name));
    let complex = |name: &str| {
        Ok::<_, Error>(Complex64::new(
            real(&format!("{name}_re"))?,
            real(&format!("{name}_im"))?,
        ))
    };
    let (entry, nodes) = own.dataset(&format!("{}/nodes", group.path))?;
    let nodes = integers(entry, nodes)?;
    let (entry, values) = own.dataset(&format!("{}/values", group.path))?;
    let values: Array2<Complex64> = match ComplexArray::new(entry, values)? {
        ComplexArray::Double(array) => array
            .into_dimensionality::<Ix2>()
            .map_err(|_| wrong_type(entry, "two axes: node, component"))?,
        ComplexArray::Single(_) => {
            return Err(wrong_type(entry, "complex numbers in double precision"))
        }
    };
    if nodes.len() != values.nrows() {
        return Err(Error::bad_data("sizes disagree")
            .field(format!("{}/nodes", group.path))
            .found(nodes.len())
            .expected(format!("{}, one per row of values", values.nrows())));
    }
    let reference = match group.text("reference") {
        None => None,
        Some(text) => Some(text.parse::<Dof>().map_err(|message| {
            Error::bad_data(message)
                .field(format!("reference of {}", group.path))
                .found(text)
                .expected("a DOF, as in 12:+Z")
        })?),
    };
    Ok(Shape {
        form: if whole("dataset")? == 55 {
            ShapeForm::AtNodes55
        } else {
            ShapeForm::Analysis2414
        },
        name: text("name")?,
        id_lines: [
            text(ID_LINES[0])?,
            text(ID_LINES[1])?,
            text(ID_LINES[2])?,
            text(ID_LINES[3])?,
            text(ID_LINES[4])?,
        ],
        model_type: whole("model_type")?,
        analysis: Analysis::from_code(whole("analysis")?),
        characteristic: whole("characteristic")?,
        quantity: whole("quantity")?,
        reference,
        numbers: ShapeNumbers {
            load_case: whole("load_case")?,
            number: whole("number")?,
            time_s: real("time_s")?,
            frequency_hz: real("frequency_hz")?,
            modal_mass: real("modal_mass")?,
            viscous: real("viscous")?,
            hysteretic: real("hysteretic")?,
            eigenvalue: complex("eigenvalue")?,
            modal_a: complex("modal_a")?,
            modal_b: complex("modal_b")?,
        },
        complex: whole("complex")? != 0,
        nodes,
        values,
        scale_to_si: real("scale_to_si")?,
        line: 0,
        warnings: Vec::new(),
    })
}
