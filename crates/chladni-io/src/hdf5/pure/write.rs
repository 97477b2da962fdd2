//! Writing, with the builder of the library.

use crate::arrays::tree::{Attribute, Dataset, Group, Values};
use chladni_frf::{Dof, Error, Node, Result};
use hdf5_pure::{AttrValue, CompoundTypeBuilder, FileBuilder, LibVer};
use num_complex::Complex;
use std::path::Path;

/// Writes a file of the 1.8 format (read by everything), contiguous and uncompressed,
/// without time stamps.
pub(in super::super) fn write(path: &Path, root: &Group<'_>) -> Result<()> {
    let fail = |error: hdf5_pure::Error| match error {
        hdf5_pure::Error::Io(error) => crate::atomic::write_error(&error, path),
        error => Error::new(chladni_frf::ErrorKind::Internal, format!("HDF5: {error}")).file(path),
    };
    let mut file = FileBuilder::new();
    file.with_libver_bounds(LibVer::Earliest, LibVer::V18);
    for (name, value) in &root.attributes {
        file.set_attr(name, attribute_value(value));
    }
    for dataset in &root.datasets {
        fill(file.create_dataset(&dataset.name), dataset).map_err(fail)?;
    }
    for group in &root.groups {
        let built = build_group(file.create_group(&group.name), group).map_err(fail)?;
        file.add_group(built);
    }
    file.write(path).map_err(fail)
}

fn build_group(
    mut builder: hdf5_pure::GroupBuilder,
    group: &Group<'_>,
) -> std::result::Result<hdf5_pure::FinishedGroup, hdf5_pure::Error> {
    for (name, value) in &group.attributes {
        builder.set_attr(name, attribute_value(value));
    }
    for dataset in &group.datasets {
        fill(builder.create_dataset(&dataset.name), dataset)?;
    }
    for inner in &group.groups {
        let built = build_group(builder.create_group(&inner.name), inner)?;
        builder.add_group(built);
    }
    Ok(builder.finish())
}

fn attribute_value(value: &Attribute) -> AttrValue {
    match value {
        Attribute::Text(text) => AttrValue::VarLenString(text.clone()),
        Attribute::FixedText(text) => AttrValue::String(text.clone()),
        Attribute::Real(value) => AttrValue::F64(*value),
        Attribute::Integer(value) => AttrValue::I64(*value),
    }
}

fn fill(
    builder: &mut hdf5_pure::DatasetBuilder,
    dataset: &Dataset<'_>,
) -> std::result::Result<(), hdf5_pure::Error> {
    let shape: Vec<u64> = dataset.shape.iter().map(|&extent| extent as u64).collect();
    let count = shape.iter().product();
    builder.with_shape(&shape);
    match &dataset.values {
        Values::Real64(values) => builder.with_f64_data(values),
        Values::Real32(values) => builder.with_f32_data(values),
        Values::Unsigned(values) => builder.with_u64_data(values),
        Values::Signed(values) => builder.with_i64_data(values),
        Values::Complex64(values) => {
            let datatype = CompoundTypeBuilder::new()
                .f64_field("r")
                .f64_field("i")
                .build()?;
            builder.with_compound_data(datatype, bytes_of(values, f64::to_le_bytes), count)
        }
        Values::Complex32(values) => {
            let datatype = CompoundTypeBuilder::new()
                .f32_field("r")
                .f32_field("i")
                .build()?;
            builder.with_compound_data(datatype, bytes_of(values, f32::to_le_bytes), count)
        }
        Values::Text(texts) => {
            builder.with_vlen_strings(&texts.iter().map(String::as_str).collect::<Vec<_>>())
        }
        Values::Dofs(dofs) => {
            let datatype = CompoundTypeBuilder::new()
                .u64_field("node")
                .i8_field("dir")
                .build()?;
            let records = dofs.iter().flat_map(dof_record).collect();
            builder.with_compound_data(datatype, records, count)
        }
        Values::Nodes(nodes) => {
            let datatype = CompoundTypeBuilder::new()
                .u64_field("label")
                .f64_field("x")
                .f64_field("y")
                .f64_field("z")
                .build()?;
            let records = nodes.iter().flat_map(node_record).collect();
            builder.with_compound_data(datatype, records, count)
        }
    };
    for (name, value) in &dataset.attributes {
        builder.set_attr(name, attribute_value(value));
    }
    Ok(())
}

fn dof_record(dof: &Dof) -> Vec<u8> {
    let code = dof.direction.code().to_le_bytes();
    [&dof.node.to_le_bytes()[..], &code].concat()
}

fn node_record(node: &Node) -> Vec<u8> {
    let [x, y, z] = node.xyz_m.map(f64::to_le_bytes);
    [node.label.to_le_bytes(), x, y, z].concat()
}

/// Real part, imaginary part, real part, ...
fn bytes_of<T: Copy, const N: usize>(values: &[Complex<T>], bytes: fn(T) -> [u8; N]) -> Vec<u8> {
    let mut all = Vec::with_capacity(size_of_val(values));
    for value in values {
        all.extend_from_slice(&bytes(value.re));
        all.extend_from_slice(&bytes(value.im));
    }
    all
}
