//! Writes universal files: 151, 164 (SI), 2411 or 15, 82, 2412, one 55 or 2414 per shape, and one 58 or 58b per function.
//!
//! A [`Plan`] first decides and checks, so that nothing is found out in the middle of a file:
//!
//! * Every pair of an FRF set becomes a function of type 4 and its coherence one of type 6; pairs that were not measured are
//!   left out. Other functions are written as they are, in SI.
//! * An even axis gets spacing 1 and its exact step as `df=` in ID line 4, because record 7 prints six digits of it. An uneven
//!   axis gets spacing 0; as text it keeps six digits only.
//! * Binary values are exact. Text keeps 13 digits of doubles and 6 of singles.
//! * Masked lines (NaN) stay NaN in the binary form, where readers mask them again. As text they are refused: dropping them
//!   would give every FRF an axis of its own.
//! * Dates are blank: the same data give the same bytes.

use super::scaling::{exponents, motion_code, COHERENCE, EXCITATION_FORCE, FREQUENCY, FRF};
use super::{write58, write_mesh, write_shape};
use crate::io::unit_label;
use crate::io::{Abscissa, Axis, Contents, Function, Ordinate, Shape, ShapeForm};
use crate::{Dof, Error, ErrorKind, FrfKind, FrfSet, FrfValues, ReferenceUnit, Result, CREATED_BY};
use std::borrow::Cow;
use std::io::{self, Write};

/// How a universal file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// Binary 58 (IEEE 754, little endian): exact, and much smaller and faster than text.
    pub binary: bool,
    /// Datasets 15 and 55 in place of 2411 and 2414, for programs that know nothing newer: six digits.
    pub old_datasets: bool,
}

/// Largest number that a field of ten columns holds.
pub(super) const LARGEST_NODE: u64 = 9_999_999_999;

/// A checked intention to write a universal file.
#[derive(Debug)]
pub struct Plan<'a> {
    contents: &'a Contents,
    options: WriteOptions,
    /// Axis of the FRF set.
    axis: Abscissa,
    warnings: Vec<String>,
}

/// Writes `contents` at once and returns what the format could not carry; see [`Plan`] to check first.
///
/// # Errors
/// As [`Plan::new`], and [`ErrorKind::Io`].
pub fn write(sink: &mut dyn Write, contents: &Contents, options: WriteOptions) -> Result<Vec<String>> {
    let plan = Plan::new(contents, options)?;
    plan.write(sink).map_err(|error| Error::new(ErrorKind::Io, format!("cannot write: {error}")))?;
    Ok(plan.warnings)
}

impl<'a> Plan<'a> {
    /// Checks that everything fits the format.
    ///
    /// # Errors
    /// A node number of more than ten digits, and masked values where text is to be written.
    pub fn new(contents: &'a Contents, options: WriteOptions) -> Result<Self> {
        let axis = contents.frf.as_ref().map_or(Abscissa::Even { start: 0.0, step: 1.0 }, |set| axis_of(&set.frequency_hz.to_vec()));
        let mut plan = Self { contents, options, axis, warnings: Vec::new() };
        let geometry = contents.geometry();
        for node in &geometry.nodes {
            check_node(node.label)?;
        }
        for label in geometry.lines.iter().chain(&geometry.faces).flatten().chain(contents.shapes.iter().flat_map(|shape| &shape.nodes)) {
            check_node(*label)?;
        }
        let many_cornered = write_mesh::faces_as_lines(geometry);
        if many_cornered > 0 {
            plan.warnings.push(format!("{many_cornered} faces with more than four corners are written as closed trace lines (82)"));
        }
        if options.old_datasets && !geometry.nodes.is_empty() {
            plan.warnings.push("dataset 15 keeps 6 digits of the coordinates; 2411 (.uff, .unv) and HDF5 keep all".into());
        }
        plan.check_shapes()?;
        let mut count = 0;
        let mut lost: Vec<String> = Vec::new();
        plan.each_function(|function| {
            count += 1;
            check_node(function.response.node)?;
            check_node(function.reference.node)?;
            for warning in write58::check(function, options)? {
                // once, however many functions it concerns
                if !lost.contains(&warning) {
                    lost.push(warning);
                }
            }
            Ok::<(), Error>(())
        })?;
        plan.warnings.append(&mut lost);
        if count > 0 && !options.binary {
            plan.warnings.push("text keeps 13 digits of double and 6 of single precision; the binary form and HDF5 are exact".into());
        }
        Ok(plan)
    }

    fn check_shapes(&mut self) -> Result<()> {
        let shapes = &self.contents.shapes;
        shapes.iter().try_for_each(write_shape::check)?;
        if !shapes.is_empty() {
            self.warnings.push("datasets 55 and 2414 keep 6 digits of shapes; HDF5 keeps all".into());
        }
        let at_rest = |shape: &&Shape| {
            let becomes_55 = self.options.old_datasets && shape.form == ShapeForm::Analysis2414;
            becomes_55 && shape.nodes.len() < self.contents.geometry().nodes.len()
        };
        let count = shapes.iter().filter(at_rest).count();
        if count > 0 {
            self.warnings.push(format!("{count} shapes have no value at some nodes: dataset 55 takes these as at rest"));
        }
        Ok(())
    }

    /// What the format cannot carry.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Those of `sink`.
    pub fn write(&self, sink: &mut dyn Write) -> io::Result<()> {
        write_header(sink)?;
        let old = self.options.old_datasets;
        write_mesh::write_nodes(sink, self.contents.geometry(), old)?;
        write_mesh::write_mesh(sink, self.contents.geometry())?;
        for (k, shape) in self.contents.shapes.iter().enumerate() {
            write_shape::write(sink, shape, k + 1, old)?;
        }
        self.each_function(|function| write58::write(sink, function, self.options))
    }

    /// Calls `each` with every function of the file, in order.
    fn each_function<E>(&self, mut each: impl FnMut(&Function) -> std::result::Result<(), E>) -> std::result::Result<(), E> {
        if let Some(set) = &self.contents.frf {
            for response in 0..set.responses.len() {
                for reference in 0..set.references.len() {
                    for function in [frf(set, response, reference), coherence(set, response, reference)].into_iter().flatten() {
                        each(&Function { abscissa: self.axis.clone(), ..function })?;
                    }
                }
            }
        }
        self.contents.functions.iter().try_for_each(|function| each(&in_si(function)))
    }
}

fn check_node(label: u64) -> Result<()> {
    if label <= LARGEST_NODE {
        return Ok(());
    }
    Err(Error::bad_data("the node number does not fit a universal file")
        .field("node number")
        .found(label)
        .expected("at most ten digits")
        .help("renumber the nodes, or write HDF5"))
}

/// The axis as start and step where all its steps are equal to rounding.
fn axis_of(frequency_hz: &[f64]) -> Abscissa {
    /// Rounding of a computed axis, in units of the last place of its largest value.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    let (Some(&first), Some(&last)) = (frequency_hz.first(), frequency_hz.last()) else {
        return Abscissa::Even { start: 0.0, step: 1.0 };
    };
    if frequency_hz.len() == 1 {
        return Abscissa::Even { start: first, step: 1.0 };
    }
    let mean = (last - first) / (frequency_hz.len() - 1) as f64;
    // The step that the axis was computed from is usually a short decimal number.
    let short = |digits: usize| format!("{mean:.digits$e}").parse().unwrap_or(mean);
    let error =
        |step: f64| -> f64 { frequency_hz.iter().enumerate().map(|(k, x)| (first + step * k as f64 - x).abs()).fold(0.0, f64::max) };
    let candidates = [mean, frequency_hz[1] - first, short(14), short(11)];
    let (step, error) =
        candidates.map(|step| (step, error(step))).into_iter().fold(
            (mean, f64::INFINITY),
            |best, next| {
                if next.1 < best.1 {
                    next
                } else {
                    best
                }
            },
        );
    if error <= ROUNDING * first.abs().max(last.abs()) {
        Abscissa::Even { start: first, step }
    } else {
        Abscissa::Uneven(frequency_hz.to_vec())
    }
}

/// One FRF of a set; `None` where it was not measured.
fn frf(set: &FrfSet, response: usize, reference: usize) -> Option<Function> {
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
    let axes = [frequency_axis(), response_axis(set.kind, dofs[0]), reference_axis(set, dofs[1]), Axis::default()];
    measured.then(|| function(set, FRF, dofs, axes, ordinate))
}

/// Coherence of a pair; `None` where it was not measured.
fn coherence(set: &FrfSet, response: usize, reference: usize) -> Option<Function> {
    let values = set.coherence.as_ref()?.slice(ndarray::s![response, reference, ..]).to_vec();
    let dofs = [set.responses[response], set.references[reference]];
    let axes = [frequency_axis(), Axis::default(), Axis::default(), Axis::default()];
    values.iter().any(|v| !v.is_nan()).then(|| function(set, COHERENCE, dofs, axes, Ordinate::Real32(values)))
}

fn function(set: &FrfSet, function_type: i32, [response, reference]: [Dof; 2], axes: [Axis; 4], ordinate: Ordinate) -> Function {
    Function {
        function_type,
        id_lines: Default::default(),
        ids: [0; 3],
        entity_names: Default::default(),
        response,
        reference,
        abscissa: Abscissa::Even { start: 0.0, step: 1.0 },
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
    Axis { quantity: FREQUENCY, exponents: [0; 3], label: "Frequency".into(), unit: "Hz".into() }
}

fn response_axis(kind: Option<FrfKind>, dof: Dof) -> Axis {
    let Some(kind) = kind else { return Axis::default() };
    let (label, translation, rotation) = match kind {
        FrfKind::Receptance => ("Displacement", "m", "rad"),
        FrfKind::Mobility => ("Velocity", "m/s", "rad/s"),
        FrfKind::Accelerance => ("Acceleration", "m/s^2", "rad/s^2"),
    };
    with_exponents(motion_code(kind), label, if is_rotation(dof) { rotation } else { translation }, dof)
}

fn reference_axis(set: &FrfSet, dof: Dof) -> Axis {
    match (set.reference_unit, set.kind) {
        (ReferenceUnit::Newton, Some(_)) => with_exponents(EXCITATION_FORCE, "Force", if is_rotation(dof) { "N*m" } else { "N" }, dof),
        (ReferenceUnit::Newton, None) => Axis::default(),
        (ReferenceUnit::Volt, _) => Axis { quantity: 1, exponents: [0; 3], label: "Voltage".into(), unit: "V".into() },
    }
}

fn is_rotation(dof: Dof) -> bool {
    dof.direction.axis().code() >= 4
}

fn with_exponents(quantity: i32, label: &str, unit: &str, dof: Dof) -> Axis {
    let axis = Axis { quantity, exponents: [0; 3], label: label.into(), unit: unit.into() };
    let [length, force] = exponents(&axis, dof.direction).unwrap_or([0, 0]);
    Axis { exponents: [length, force, 0], ..axis }
}

/// The function with its values and abscissa in SI, as dataset 164 of our files says.
fn in_si(function: &Function) -> Cow<'_, Function> {
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
            Ordinate::Complex32(values) => values.iter_mut().for_each(|y| *y = num_complex::Complex32::new(single(y.re), single(y.im))),
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
        // codes that do not say the kind: the numerator's label carries the whole ratio
        Some(kind)
            if numerator.quantity != motion_code(kind)
                || (denominator.quantity != EXCITATION_FORCE && function.reference_unit == ReferenceUnit::Newton) =>
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

fn write_header(sink: &mut dyn Write) -> io::Result<()> {
    let no_date = format!("{:20}", "");
    write!(
        sink,
        "    -1\n   151\nNONE\nNONE\n{CREATED_BY}\n{no_date}{:10}{:10}{:10}\n{no_date}\n{CREATED_BY}\n{no_date}\n    -1\n",
        0, 0, 0
    )?;
    write!(sink, "    -1\n   164\n{:10}{:<20}{:10}\n", 1, "SI: Meter (newton)", 2)?;
    write!(sink, "{0}{0}{0}\n{1}\n    -1\n", write58::fortran(1.0, 25, 17, 'D'), write58::fortran(273.15, 25, 17, 'D'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn computed_even_axes_are_recognised_and_keep_their_step() {
        for step in [0.1, 0.3125, 1.0 / 3.0, 2.44140625, 0.5] {
            for first in [0.0, 10.0] {
                let axis: Vec<f64> = (0..6400).map(|k| first + step * f64::from(k)).collect();
                assert_eq!(axis_of(&axis), Abscissa::Even { start: first, step }, "{first} {step}");
            }
        }
    }

    #[test]
    fn an_axis_with_one_line_missing_is_uneven() {
        let axis: Vec<f64> = (0..100).filter(|k| *k != 50).map(f64::from).collect();
        assert_eq!(axis_of(&axis), Abscissa::Uneven(axis.clone()));
        assert_eq!(axis_of(&[7.0]), Abscissa::Even { start: 7.0, step: 1.0 });
    }
}
