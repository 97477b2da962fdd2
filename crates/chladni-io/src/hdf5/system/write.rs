//! HDF5 written by the C library.

use super::values::{DofRecord, NodeRecord};
use crate::arrays::tree::{Attribute, Attributes, Dataset, Group, Values};
use chladni_frf::{Error, ErrorKind, Node, Result};
use hdf5::types::VarLenUnicode;
use hdf5::{H5Type, Location};
use num_complex::{Complex32, Complex64};
use std::path::Path;

/// Writes a file in the oldest layout that holds it, contiguous and uncompressed, without
/// time stamps.
pub(in crate::hdf5) fn write(path: &Path, root: &Group<'_>) -> Result<()> {
    let fail = |error: hdf5::Error| Error::new(ErrorKind::Io, format!("HDF5: {error}")).file(path);
    // the writer holds a lock already
    let file = hdf5::File::with_options()
        .with_fapl(|access| access.file_locking(false))
        .create(path)
        .map_err(fail)?;
    write_group(&file, root).map_err(fail)?;
    file.close().map_err(fail)
}

fn write_group(target: &hdf5::Group, group: &Group<'_>) -> hdf5::Result<()> {
    write_attributes(target, &group.attributes)?;
    for dataset in &group.datasets {
        write_dataset(target, dataset)?;
    }
    for inner in &group.groups {
        let created = target
            .create_group_builder()
            .obj_track_times(false)
            .create(inner.name.as_str())?;
        write_group(&created, inner)?;
    }
    Ok(())
}

fn write_attributes(location: &Location, attributes: &Attributes) -> hdf5::Result<()> {
    for (name, value) in attributes {
        let name = name.as_str();
        match value {
            Attribute::Text(text) | Attribute::FixedText(text) => location
                .new_attr::<VarLenUnicode>()
                .create(name)?
                .write_scalar(&unicode(text)?)?,
            Attribute::Real(value) => location
                .new_attr::<f64>()
                .create(name)?
                .write_scalar(value)?,
            Attribute::Integer(value) => location
                .new_attr::<i64>()
                .create(name)?
                .write_scalar(value)?,
        }
    }
    Ok(())
}

fn unicode(text: &str) -> hdf5::Result<VarLenUnicode> {
    text.parse()
        .map_err(|_| hdf5::Error::from(format!("text with a zero character: {text:?}")))
}

fn write_dataset(target: &hdf5::Group, dataset: &Dataset<'_>) -> hdf5::Result<()> {
    let written = match &dataset.values {
        Values::Real64(values) => create::<f64>(target, dataset, values)?,
        Values::Real32(values) => create::<f32>(target, dataset, values)?,
        Values::Complex64(values) => create::<Complex64>(target, dataset, values)?,
        Values::Complex32(values) => create::<Complex32>(target, dataset, values)?,
        Values::Unsigned(values) => create::<u64>(target, dataset, values)?,
        Values::Signed(values) => create::<i64>(target, dataset, values)?,
        Values::Text(texts) => {
            let texts: Vec<VarLenUnicode> = texts
                .iter()
                .map(|text| unicode(text))
                .collect::<hdf5::Result<_>>()?;
            create(target, dataset, &texts)?
        }
        Values::Dofs(dofs) => {
            let records: Vec<DofRecord> = dofs
                .iter()
                .map(|dof| DofRecord {
                    node: dof.node,
                    dir: dof.direction.code(),
                })
                .collect();
            create(target, dataset, &records)?
        }
        Values::Nodes(nodes) => {
            let record = |node: &Node| NodeRecord {
                label: node.label,
                x: node.xyz_m[0],
                y: node.xyz_m[1],
                z: node.xyz_m[2],
            };
            create(
                target,
                dataset,
                &nodes.iter().map(record).collect::<Vec<_>>(),
            )?
        }
    };
    write_attributes(&written, &dataset.attributes)
}

/// Creates a dataset of packed records, so that no padding bytes are written.
fn create<T: H5Type>(
    target: &hdf5::Group,
    dataset: &Dataset<'_>,
    values: &[T],
) -> hdf5::Result<hdf5::Dataset> {
    let builder = target
        .new_dataset_builder()
        .obj_track_times(false)
        .packed(true)
        .empty::<T>()
        .shape(dataset.shape.clone());
    let created = builder.create(dataset.name.as_str())?;
    if !values.is_empty() {
        created.as_writer().write_raw(values)?;
    }
    Ok(created)
}
