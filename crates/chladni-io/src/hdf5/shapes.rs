//! `/shapes/K`: mode shapes and fields of a source file, K = 1, 2, ...: `nodes` [node],
//! `values` [node, component] in the units of the source, everything else as attributes
//! named as in [`Shape`].

use super::attributes::{each, Required, ID_LINES};
use super::own::Own;
use crate::arrays::tree::{Attribute, Entry, Group, Values};
use crate::arrays::values::{integers, wrong_type, ComplexArray};
use crate::{Analysis, Shape, ShapeForm, ShapeNumbers};
use chladni_frf::{Dof, Error, Result};
use ndarray::{Array2, Ix2};
use num_complex::Complex64;

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
    let dataset = match form {
        ShapeForm::AtNodes55 => 55,
        ShapeForm::Analysis2414 => 2414,
    };
    group.set("dataset", Attribute::Integer(dataset));
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
    let said = Required {
        group,
        holds: "shape",
    };
    let (nodes, values) = read_values(own, group)?;
    let reference = match group.text("reference") {
        None => None,
        Some(text) => Some(text.parse::<Dof>().map_err(|message| {
            Error::bad_data(message)
                .field(said.field("reference"))
                .found(text)
                .expected("a DOF, as in 12:+Z")
        })?),
    };
    Ok(Shape {
        form: match said.whole("dataset")? {
            55 => ShapeForm::AtNodes55,
            _ => ShapeForm::Analysis2414,
        },
        name: said.text("name")?,
        id_lines: each(ID_LINES, |name| said.text(name))?,
        model_type: said.whole("model_type")?,
        analysis: Analysis::from_code(said.whole("analysis")?),
        characteristic: said.whole("characteristic")?,
        quantity: said.whole("quantity")?,
        reference,
        numbers: read_numbers(&said)?,
        complex: said.whole("complex")? != 0,
        nodes,
        values,
        scale_to_si: said.real("scale_to_si")?,
        line: 0,
        warnings: Vec::new(),
    })
}

fn read_values(own: &Own<'_>, group: &Entry) -> Result<(Vec<u64>, Array2<Complex64>)> {
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
    Ok((nodes, values))
}

fn read_numbers(said: &Required<'_>) -> Result<ShapeNumbers> {
    Ok(ShapeNumbers {
        load_case: said.whole("load_case")?,
        number: said.whole("number")?,
        time_s: said.real("time_s")?,
        frequency_hz: said.real("frequency_hz")?,
        modal_mass: said.real("modal_mass")?,
        viscous: said.real("viscous")?,
        hysteretic: said.real("hysteretic")?,
        eigenvalue: said.complex("eigenvalue")?,
        modal_a: said.complex("modal_a")?,
        modal_b: said.complex("modal_b")?,
    })
}
