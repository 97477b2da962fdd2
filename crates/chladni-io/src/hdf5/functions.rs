//! `/functions/K`: functions of a source file that are no FRFs (time records, spectra,
//! ...), kept as they were read.
//!
//! Each is a group with `values` [n] in the units of the source, `abscissa` [n] where it
//! is uneven, and the header of its dataset 58 as attributes.

use super::attributes::{each, Required, ID_LINES};
use super::own::Own;
use crate::arrays::tree::{Attribute, Entry, Group, Values};
use crate::arrays::values::{reals, wrong_type};
use crate::{Abscissa, Axis, Function, Ordinate};
use chladni_frf::{Error, ReferenceUnit, Result};

/// Names of the four axes, in the order of [`Function::axes`].
const AXES: [&str; 4] = ["abscissa", "ordinate", "ordinate_denominator", "z_axis"];
/// Names of the three exponents of an axis.
const EXPONENTS: [&str; 3] = ["length_exponent", "force_exponent", "temperature_exponent"];
/// Names of [`Function::ids`].
const IDS: [&str; 3] = ["function_id", "version", "load_case"];
/// Names of [`Function::entity_names`].
const ENTITIES: [&str; 2] = ["response_entity", "reference_entity"];

/// Group `/functions`.
pub(super) fn functions_group(functions: &[Function]) -> Group<'_> {
    let mut all = Group::new("functions");
    all.groups = functions
        .iter()
        .enumerate()
        .map(|(k, function)| function_group(k + 1, function))
        .collect();
    all
}

fn function_group(number: usize, function: &Function) -> Group<'_> {
    let mut group = Group::new(number.to_string());
    group.set("function_type", integer(function.function_type.into()));
    for (name, line) in ID_LINES.iter().zip(&function.id_lines) {
        group.set(name, text(line.as_str()));
    }
    for (name, &value) in IDS.iter().zip(&function.ids) {
        group.set(name, integer(value));
    }
    for (name, value) in ENTITIES.iter().zip(&function.entity_names) {
        group.set(name, text(value.as_str()));
    }
    group.set("response", text(function.response.to_string()));
    group.set("reference", text(function.reference.to_string()));
    group.set("z", Attribute::Real(function.z));
    for (name, axis) in AXES.iter().zip(&function.axes) {
        group.set(&format!("{name}_quantity"), integer(axis.quantity.into()));
        for (exponent, &value) in EXPONENTS.iter().zip(&axis.exponents) {
            group.set(&format!("{name}_{exponent}"), integer(value.into()));
        }
        group.set(&format!("{name}_label"), text(axis.label.as_str()));
        group.set(&format!("{name}_unit"), text(axis.unit.as_str()));
    }
    if let Some(kind) = function.kind {
        group.set("frf_kind", text(kind.as_str()));
    }
    group.set("reference_unit", text(function.reference_unit.to_string()));
    group.set("scale_to_si", Attribute::Real(function.scale_to_si));
    group.set("abscissa_to_si", Attribute::Real(function.abscissa_to_si));
    let count = function.ordinate.len();
    match &function.abscissa {
        Abscissa::Even { start, step } => {
            group.set("abscissa_start", Attribute::Real(*start));
            group.set("abscissa_step", Attribute::Real(*step));
        }
        Abscissa::Uneven(values) => {
            group.add("abscissa", &[values.len()], Values::Real64(values.into()))
        }
    }
    group.add("values", &[count], ordinate_values(&function.ordinate));
    group
}

fn text(text: impl Into<String>) -> Attribute {
    Attribute::FixedText(text.into())
}

fn integer(value: i64) -> Attribute {
    Attribute::Integer(value)
}

fn ordinate_values(ordinate: &Ordinate) -> Values<'_> {
    match ordinate {
        Ordinate::Real32(values) => Values::Real32(values.into()),
        Ordinate::Real64(values) => Values::Real64(values.into()),
        Ordinate::Complex32(values) => Values::Complex32(values.into()),
        Ordinate::Complex64(values) => Values::Complex64(values.into()),
    }
}

/// All functions of a file, by rising number.
pub(super) fn read_functions(own: &Own<'_>) -> Result<Vec<Function>> {
    own.numbered("/functions")?
        .into_iter()
        .map(|entry| read_function(own, entry))
        .collect()
}

/// The uneven abscissa of a function, of `count` values; `None` for an even one.
fn uneven(own: &Own<'_>, group: &Entry, count: usize) -> Result<Option<Vec<f64>>> {
    let path = format!("{}/abscissa", group.path);
    let Some(entry) = own.find(&path) else {
        return Ok(None);
    };
    let values = reals(entry, own.file.read(entry)?)?;
    if values.len() != count {
        return Err(Error::bad_data("sizes disagree")
            .field(path)
            .found(values.len())
            .expected(format!("{count}, as many as values")));
    }
    Ok(Some(values))
}

fn read_function(own: &Own<'_>, group: &Entry) -> Result<Function> {
    let said = Required {
        group,
        holds: "function",
    };
    let dof = |name: &str| {
        let text = said.text(name)?;
        text.parse()
            .map_err(|message: String| Error::bad_word(&message, &text).field(said.field(name)))
    };
    let (entry, values) = own.dataset(&format!("{}/values", group.path))?;
    let ordinate = match values {
        Values::Real32(values) => Ordinate::Real32(values.into_owned()),
        Values::Real64(values) => Ordinate::Real64(values.into_owned()),
        Values::Complex32(values) => Ordinate::Complex32(values.into_owned()),
        Values::Complex64(values) => Ordinate::Complex64(values.into_owned()),
        _ => return Err(wrong_type(entry, "real or complex numbers")),
    };
    let abscissa = match uneven(own, group, ordinate.len())? {
        Some(values) => Abscissa::Uneven(values),
        None => Abscissa::Even {
            start: said.real("abscissa_start")?,
            step: said.real("abscissa_step")?,
        },
    };
    Ok(Function {
        function_type: said.small("function_type")?,
        id_lines: each(ID_LINES, |name| said.text(name))?,
        ids: each(IDS, |name| said.whole(name))?,
        entity_names: each(ENTITIES, |name| said.text(name))?,
        response: dof("response")?,
        reference: dof("reference")?,
        abscissa,
        z: said.real("z")?,
        axes: each(AXES, |name| axis(&said, name))?,
        ordinate,
        kind: group.text("frf_kind").and_then(|kind| kind.parse().ok()),
        reference_unit: match group.text("reference_unit") {
            Some("V") => ReferenceUnit::Volt,
            _ => ReferenceUnit::Newton,
        },
        scale_to_si: said.real("scale_to_si")?,
        abscissa_to_si: said.real("abscissa_to_si")?,
        line: 0,
        warnings: Vec::new(),
    })
}

fn axis(said: &Required<'_>, name: &str) -> Result<Axis> {
    let of_axis = |what: &str| format!("{name}_{what}");
    Ok(Axis {
        quantity: said.small(&of_axis("quantity"))?,
        exponents: each(EXPONENTS, |exponent| said.small(&of_axis(exponent)))?,
        label: said.text(&of_axis("label"))?,
        unit: said.text(&of_axis("unit"))?,
    })
}
