//! Values of datasets and attributes.

use super::element_of;
use crate::arrays::tree::{Element, Values};
use chladni_frf::{Direction, Dof, Node};
use hdf5::types::{FixedAscii, FixedUnicode, TypeDescriptor, VarLenAscii, VarLenUnicode};
use hdf5::{Container, H5Type};
use num_complex::Complex;

/// Longest fixed-length text that is read.
const TEXT_BYTES: usize = 4096;

/// Complex numbers as MATLAB writes them.
#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct RealImag<T: H5Type> {
    real: T,
    imag: T,
}

/// Complex numbers as home-made files have them.
#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct ReIm<T: H5Type> {
    re: T,
    im: T,
}

#[derive(H5Type, Clone, Copy)]
#[repr(C)]
pub(super) struct DofRecord {
    pub(super) node: u64,
    pub(super) dir: i8,
}

#[derive(H5Type, Clone, Copy)]
#[repr(C)]
pub(super) struct NodeRecord {
    pub(super) label: u64,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
}

/// Values by their type in the file; `None` for types that are not understood.
pub(super) fn read_values(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Option<Values<'static>>> {
    Ok(Some(match element_of(descriptor) {
        Element::Real { single: true } => Values::Real32(container.read_raw::<f32>()?.into()),
        Element::Real { single: false } => Values::Real64(container.read_raw::<f64>()?.into()),
        Element::Integer => return integers(container, descriptor),
        Element::Text => return texts(container, descriptor),
        Element::Complex { single: true } => {
            Values::Complex32(complex::<f32>(container, descriptor)?.into())
        }
        Element::Complex { single: false } => {
            Values::Complex64(complex::<f64>(container, descriptor)?.into())
        }
        Element::Dof => {
            let dof = |record: DofRecord| {
                Some(Dof::new(
                    record.node,
                    Direction::from_code(record.dir.into())?,
                ))
            };
            match container
                .read_raw::<DofRecord>()?
                .into_iter()
                .map(dof)
                .collect()
            {
                Some(dofs) => Values::Dofs(dofs),
                None => return Ok(None),
            }
        }
        Element::Node => {
            let node = |record: NodeRecord| Node {
                label: record.label,
                xyz_m: [record.x, record.y, record.z],
            };
            Values::Nodes(
                container
                    .read_raw::<NodeRecord>()?
                    .into_iter()
                    .map(node)
                    .collect(),
            )
        }
        Element::Other(_) => return Ok(None),
    }))
}

/// Whole numbers: unsigned, where none is negative.
fn integers(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Option<Values<'static>>> {
    Ok(Some(match descriptor {
        TypeDescriptor::Integer(_) => {
            let values = container.read_raw::<i64>()?;
            match values
                .iter()
                .map(|&value| u64::try_from(value).ok())
                .collect::<Option<Vec<u64>>>()
            {
                Some(unsigned) => Values::Unsigned(unsigned.into()),
                None => Values::Signed(values.into()),
            }
        }
        TypeDescriptor::Unsigned(_) => Values::Unsigned(container.read_raw::<u64>()?.into()),
        TypeDescriptor::Boolean => Values::Unsigned(
            container
                .read_raw::<bool>()?
                .into_iter()
                .map(u64::from)
                .collect(),
        ),
        _ => return Ok(None),
    }))
}

fn complex<T: H5Type + Copy>(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Vec<Complex<T>>> {
    let TypeDescriptor::Compound(compound) = descriptor else {
        return Ok(Vec::new());
    };
    match compound.fields.first().map(|field| field.name.as_str()) {
        Some("real") => Ok(container
            .read_raw::<RealImag<T>>()?
            .into_iter()
            .map(|value| Complex {
                re: value.real,
                im: value.imag,
            })
            .collect()),
        Some("re") => Ok(container
            .read_raw::<ReIm<T>>()?
            .into_iter()
            .map(|value| Complex {
                re: value.re,
                im: value.im,
            })
            .collect()),
        _ => container.read_raw::<Complex<T>>(),
    }
}

fn texts(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Option<Values<'static>>> {
    fn all<T: H5Type + std::fmt::Display>(container: &Container) -> hdf5::Result<Vec<String>> {
        Ok(container
            .read_raw::<T>()?
            .iter()
            .map(T::to_string)
            .collect())
    }
    let texts = match *descriptor {
        TypeDescriptor::VarLenUnicode => all::<VarLenUnicode>(container)?,
        TypeDescriptor::VarLenAscii => all::<VarLenAscii>(container)?,
        TypeDescriptor::FixedUnicode(size) if size <= TEXT_BYTES => {
            all::<FixedUnicode<TEXT_BYTES>>(container)?
        }
        TypeDescriptor::FixedAscii(size) if size <= TEXT_BYTES => {
            all::<FixedAscii<TEXT_BYTES>>(container)?
        }
        _ => return Ok(None),
    };
    Ok(Some(Values::Text(texts)))
}
