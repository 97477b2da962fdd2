//! The modes of a file as a [`ShapeSet`]: a model, or the shapes of another program.

use super::{
    detect_format, read_contents, read_model, Analysis, Contents, FileFormat, ReadOptions, Shape,
    ShapeForm,
};
use chladni_frf::{Direction, Dof, Error, Result, ShapeMode, ShapeSet};
use num_complex::Complex64;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Data characteristics of values at nodes: one number, three translations, and these
/// with three rotations.
const SCALAR: i64 = 1;
const TRANSLATIONS: i64 = 2;
const TRANSLATIONS_AND_ROTATIONS: i64 = 3;

/// The modes in a file: those of a model, or the shapes of datasets 55 and 2414. What the
/// user must know of it comes with them.
///
/// # Errors
/// Those of reading; [`chladni_frf::ErrorKind::BadData`] where the file holds no mode.
pub fn read_shape_set(file: &Path) -> Result<(ShapeSet, Vec<String>)> {
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
        return Ok((ShapeSet::from(&model), model.quality.warnings));
    }
    let contents = read_contents(&[PathBuf::from(file)], &ReadOptions::default())
        .map_err(|error| error.file(file))?;
    let set = shape_set(&contents).map_err(|error| error.file(file))?;
    Ok((set, contents.warnings))
}

/// The mode shapes among what files hold; fields, static and buckling shapes are left
/// out.
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
        let found = match contents.shapes.first() {
            Some(shape) => format!("no mode, but a {}", shape.analysis.name()),
            None if contents.frf.is_some() => "FRFs".into(),
            None => "no shape".into(),
        };
        return Err(Error::bad_data("no mode shape in the file")
            .found(found)
            .expected("a model of `chladni fit`, or mode shapes in datasets 55 or 2414")
            .help("fit FRFs first, or export the modes of the finite-element program"));
    };
    let axes = components(first).unwrap_or_default();
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
    let nodes = || first.nodes.iter().copied().filter(has_value);
    let dofs: Vec<Dof> = nodes()
        .flat_map(|node| axes.iter().map(move |&axis| Dof::new(node, axis)))
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
        nodes()
            .flat_map(|node| (0..axes.len()).map(move |component| (node, component)))
            .map(|(node, component)| value(node, component).unwrap_or_default())
            .collect()
    };
    let modes = shapes.iter().zip(&rows).map(|(shape, rows)| {
        let values = values(shape, rows);
        ShapeMode {
            frequency_hz: shape.frequency_hz().unwrap_or(0.0),
            frequency_std_hz: 0.0,
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
