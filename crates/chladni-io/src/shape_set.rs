//! The modes of a file as a [`ShapeSet`]: a model, or the shapes of another program.

use super::{
    detect_format, read_contents, read_model, Analysis, Contents, FileFormat, ReadOptions, Shape,
    ShapeForm,
};
use crate::limits;
use chladni_frf::{Direction, Dof, Error, Finding, Result, ShapeMode, ShapeSet};
use num_complex::Complex64;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Data characteristics of values at nodes: one number, three translations, and these
/// with three rotations.
const SCALAR: i64 = 1;
const TRANSLATIONS: i64 = 2;
const TRANSLATIONS_AND_ROTATIONS: i64 = 3;

/// Reads the modes in a file: those of a model, or the shapes of datasets 55 and 2414; with
/// the findings about the file.
///
/// # Errors
/// Those of reading; [`chladni_frf::ErrorKind::BadData`] where the file holds no mode.
pub fn read_shape_set(file: &Path) -> Result<(ShapeSet, Vec<Finding>)> {
    let model = match detect_format(file)? {
        FileFormat::Model => Some(read_model(file)?),
        FileFormat::Hdf5 => match read_model(file) {
            Ok(model) => Some(model),
            Err(error) if error.field.as_deref() == Some("/model") => None,
            Err(error) => return Err(error),
        },
        _ => None,
    };
    if let Some(model) = model {
        return Ok((ShapeSet::from(&model), model.quality.findings));
    }
    let contents = read_contents(&[PathBuf::from(file)], &ReadOptions::default())
        .map_err(|error| error.file(file))?;
    let set = shape_set(&contents).map_err(|error| error.file(file))?;
    Ok((set, contents.warnings))
}

/// The mode shapes of `contents`, without fields, static and buckling shapes.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where there is no mode, or no DOF that all modes
/// share.
pub fn shape_set(contents: &Contents) -> Result<ShapeSet> {
    let shapes: Vec<&Shape> = contents
        .shapes
        .iter()
        .filter(|shape| shape.analysis.is_mode() && components(shape).is_some())
        .collect();
    let Some(first) = shapes.first() else {
        return Err(no_mode_shape(contents));
    };
    let axes = components(first).unwrap_or_default();
    refuse_other_components(&shapes, &axes)?;
    let rows: Vec<HashMap<u64, usize>> = shapes
        .iter()
        .map(|shape| (0..).zip(&shape.nodes).map(|(row, &node)| (node, row)))
        .map(Iterator::collect)
        .collect();
    // a node that dataset 55 leaves out is at rest; one that 2414 leaves out has no value
    let has_value = |node: &u64| {
        (shapes.iter().zip(&rows))
            .all(|(shape, rows)| shape.form == ShapeForm::AtNodes55 || rows.contains_key(node))
    };
    let mut seen = HashSet::new();
    let nodes: Vec<u64> = (shapes.iter().flat_map(|shape| &shape.nodes).copied())
        .filter(|node| has_value(node) && seen.insert(*node))
        .collect();
    let dofs: Vec<Dof> = (nodes.iter())
        .flat_map(|&node| axes.iter().map(move |&axis| Dof::new(node, axis)))
        .collect();
    if dofs.is_empty() {
        return Err(Error::bad_data("no node has a value in every mode shape")
            .found("shapes at different nodes")
            .expected("modes of one structure, at the same nodes"));
    }
    let values = |shape: &Shape, rows: &HashMap<u64, usize>| -> Vec<Complex64> {
        let value = |node: u64, component: usize| {
            let row = rows.get(&node)?;
            shape.values.get([*row, component]).copied()
        };
        nodes
            .iter()
            .flat_map(|&node| (0..axes.len()).map(move |component| (node, component)))
            .map(|(node, component)| value(node, component).unwrap_or_default())
            .collect()
    };
    let modes = shapes.iter().zip(&rows).map(|(shape, rows)| {
        let values = values(shape, rows);
        ShapeMode {
            frequency_hz: shape.frequency_hz().unwrap_or(0.0),
            frequency_std_hz: rounding_of(shape.frequency_hz().unwrap_or(0.0)),
            loss_factor: loss_factor(shape),
            loss_factor_std: 0.0,
            shape_std: vec![0.0; values.len()],
            shape: values,
        }
    });
    Ok(ShapeSet {
        modes: modes.collect(),
        nodes: contents.geometry().nodes.clone(),
        dofs,
    })
}

fn no_mode_shape(contents: &Contents) -> Error {
    let found = match contents.shapes.first() {
        Some(shape) => format!("no mode, but a {}", shape.analysis.name()),
        None if contents.frf.is_some() => "FRFs".into(),
        None => "no shape".into(),
    };
    Error::bad_data("no mode shape in the file")
        .found(found)
        .expected("a model, or mode shapes in datasets 55 or 2414")
        .help("fit a model first, or export the modes of the finite-element program")
}

/// Standard deviation of what rounding leaves of a number in a universal file, which has six digits.
fn rounding_of(value: f64) -> f64 {
    let last_digit = match value.abs() {
        0.0 => 0.0,
        size => 10f64.powf(size.log10().floor() - limits::DECIMALS_55),
    };
    last_digit / 12f64.sqrt()
}

/// η = 2ζ; programs write 0 for modes without damping.
fn loss_factor(shape: &Shape) -> Option<f64> {
    let numbers = &shape.numbers;
    match shape.analysis {
        Analysis::NormalMode if numbers.hysteretic > 0.0 => Some(numbers.hysteretic),
        _ => shape
            .damping_ratio()
            .filter(|&ratio| ratio > 0.0)
            .map(|ratio| 2.0 * ratio),
    }
}

/// Refuses shapes whose components lie along other directions than `axes`.
fn refuse_other_components(shapes: &[&Shape], axes: &[Direction]) -> Result<()> {
    let counts = shapes
        .iter()
        .map(|shape| components(shape).map_or(0, |own| own.len()));
    match counts.into_iter().find(|&count| count != axes.len()) {
        None => Ok(()),
        Some(count) => Err(Error::bad_data("mode shapes have different components")
            .found(format!("{} components and {count}", axes.len()))
            .expected("the same directions in every mode shape")),
    }
}

/// Directions of the components of a shape; `None` for tensors.
fn components(shape: &Shape) -> Option<Vec<Direction>> {
    let codes = match shape.characteristic {
        SCALAR => 0..=0,
        TRANSLATIONS => 1..=3,
        TRANSLATIONS_AND_ROTATIONS => 1..=6,
        _ => return None,
    };
    codes.map(Direction::from_code).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShapeNumbers;
    use ndarray::Array2;

    fn shape(form: ShapeForm, analysis: Analysis, nodes: &[u64]) -> Shape {
        Shape {
            form,
            name: String::new(),
            id_lines: Default::default(),
            model_type: 1,
            analysis,
            characteristic: TRANSLATIONS,
            quantity: 8,
            reference: None,
            numbers: ShapeNumbers {
                frequency_hz: 12.5,
                viscous: 0.01,
                ..ShapeNumbers::default()
            },
            complex: false,
            nodes: nodes.to_vec(),
            values: Array2::from_shape_fn((nodes.len(), 3), |(row, axis)| {
                Complex64::new((10 * nodes[row]) as f64 + axis as f64, 0.0)
            }),
            scale_to_si: 1.0,
            line: 0,
            warnings: Vec::new(),
        }
    }

    fn set(shapes: Vec<Shape>) -> Result<ShapeSet> {
        shape_set(&Contents {
            shapes,
            ..Contents::default()
        })
    }

    #[test]
    fn a_node_left_out_is_at_rest_in_55_and_unknown_in_2414() {
        let modes =
            |form| [&[2, 3][..], &[1, 2]].map(|nodes| shape(form, Analysis::NormalMode, nodes));
        let at_rest = set(modes(ShapeForm::AtNodes55).to_vec()).unwrap();
        let labels: Vec<u64> = at_rest.dofs.iter().step_by(3).map(|dof| dof.node).collect();
        assert_eq!(labels, [2, 3, 1]);
        assert_eq!(at_rest.dofs[1].to_string(), "2:+Y");
        let real = |mode: usize| -> Vec<f64> {
            at_rest.modes[mode]
                .shape
                .iter()
                .map(|value| value.re)
                .collect()
        };
        assert_eq!(real(0), [20.0, 21.0, 22.0, 30.0, 31.0, 32.0, 0.0, 0.0, 0.0]);
        assert_eq!(real(1), [20.0, 21.0, 22.0, 0.0, 0.0, 0.0, 10.0, 11.0, 12.0]);
        assert_eq!(at_rest.modes[0].frequency_hz, 12.5);
        // 12.5000
        assert!((at_rest.modes[0].frequency_std_hz - 1e-4 / 12f64.sqrt()).abs() < 1e-12);
        assert_eq!(at_rest.modes[0].loss_factor, Some(0.02));
        let unknown = set(modes(ShapeForm::Analysis2414).to_vec()).unwrap();
        assert_eq!(unknown.dofs.len(), 3);
        assert_eq!(unknown.modes[1].shape.len(), 3);
    }

    #[test]
    fn what_is_no_mode_is_left_out_and_nothing_else_is_an_error() {
        let field = shape(ShapeForm::AtNodes55, Analysis::FrequencyResponse, &[1, 2]);
        let mode = shape(ShapeForm::AtNodes55, Analysis::NormalMode, &[1, 2]);
        assert_eq!(set(vec![field.clone(), mode]).unwrap().modes.len(), 1);
        let error = set(vec![field]).unwrap_err();
        assert!(error.found.unwrap().contains("a field at one frequency"));
        let apart =
            [[1], [2]].map(|nodes| shape(ShapeForm::Analysis2414, Analysis::NormalMode, &nodes));
        assert!(set(apart.to_vec()).unwrap_err().message.contains("no node"));
    }
}
