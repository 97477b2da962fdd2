//! Values from the bytes of a file, by the type that the file declares.
//!
//! A member name or byte order that is not understood is an error, and never gives zeros.
//! Large datasets are decoded window by window, so that memory holds the raw bytes of one
//! window only.

use super::number::{Member, Number};
use super::File;
use crate::arrays::tree::{Element, Values};
use crate::bulk::read_past_cache;
use crate::Turn;
use bytemuck::Pod;
use chladni_frf::{Direction, Dof, Node};
use hdf5_pure::{Dataset, Datatype, Error, Layout};
use num_complex::{Complex32, Complex64};
use std::borrow::Cow;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;

/// Raw bytes read at a time. With 1 MiB or 16 MiB, the FRFs of the demonstration are read
/// equally fast.
const WINDOW_BYTES: u64 = 4 << 20;

/// Bytes read at a time of values that lie in the file as they do in memory. A stretch fits
/// into the cache next to a core, where fresh memory is cleared before it is filled.
const STRETCH_BYTES: usize = 256 << 10;

/// Element type of a dataset.
pub(super) fn element_of(datatype: &Datatype) -> Element {
    match datatype {
        Datatype::FloatingPoint { size: 8, .. } => Element::Real { single: false },
        Datatype::FloatingPoint { size: 4, .. } => Element::Real { single: true },
        Datatype::FixedPoint {
            size: 1 | 2 | 4 | 8,
            ..
        }
        | Datatype::Enumeration {
            size: 1 | 2 | 4 | 8,
            ..
        } => Element::Integer,
        Datatype::String { .. }
        | Datatype::VariableLength {
            is_string: true, ..
        } => Element::Text,
        Datatype::Compound { members, .. } => {
            let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
            match names.as_slice() {
                [first, second] if is_complex_pair(first, second) => Element::Complex {
                    single: members.iter().all(|member| {
                        element_of(&member.datatype) == Element::Real { single: true }
                    }),
                },
                ["node", "dir"] => Element::Dof,
                ["label", "x", "y", "z"] => Element::Node,
                _ => Element::Other(format!("records {{{}}}", names.join(", "))),
            }
        }
        Datatype::Reference { .. } => {
            Element::Other("object references (a MATLAB cell array?)".into())
        }
        Datatype::FloatingPoint { size: 2, .. } => Element::Other("real, half precision".into()),
        _ => Element::Other("a type of its own".into()),
    }
}

/// Words for a type whose values are not read.
pub(super) fn describe_unread(datatype: &Datatype) -> String {
    let element = element_of(datatype);
    let Datatype::Compound { members, .. } = datatype else {
        return element.describe();
    };
    let is_half = |part: &Datatype| matches!(part, Datatype::FloatingPoint { size: 2, .. });
    match element {
        Element::Complex { .. } if members.iter().all(|part| is_half(&part.datatype)) => {
            "complex, half precision".into()
        }
        Element::Complex { .. } => "complex numbers with parts of a type of their own".into(),
        other => other.describe(),
    }
}

/// True for the names of the parts of complex numbers: `r`, `i` (h5py), `real`, `imag`
/// (MATLAB), and those of home-made files.
fn is_complex_pair(first: &str, second: &str) -> bool {
    let (first, second) = (first.to_ascii_lowercase(), second.to_ascii_lowercase());
    [("r", "i"), ("real", "imag"), ("re", "im")].contains(&(first.as_str(), second.as_str()))
}

/// The values of some rows (along the first axis) of a dataset, in the memory of `spare`
/// where its type fits; `None` for types that are not understood.
pub(super) fn values_of(
    file: &File,
    dataset: &Dataset,
    datatype: &Datatype,
    rows: Range<usize>,
    turn: Option<Turn>,
    spare: Option<Values<'static>>,
) -> Result<Option<Values<'static>>, Error> {
    let Some(windows) = Windows::new(dataset, datatype, rows)? else {
        return Ok(None);
    };
    let (number, member) = (Number::of(datatype), |index| Member::of(datatype, index));
    Ok(match (element_of(datatype), number) {
        (Element::Real { single: true }, Some(number)) => windows
            .collect(|bytes| number.single(bytes))?
            .map(|values| Values::Real32(values.into())),
        (Element::Real { single: false }, Some(number)) => windows
            .collect(|bytes| number.real(bytes))?
            .map(|values| Values::Real64(values.into())),
        (Element::Integer, Some(number)) => {
            let unsigned = windows.collect(|bytes| u64::try_from(number.integer(bytes)?).ok())?;
            match unsigned {
                Some(values) => Some(Values::Unsigned(values.into())),
                None => windows
                    .collect(|bytes| i64::try_from(number.integer(bytes)?).ok())?
                    .map(|values| Values::Signed(values.into())),
            }
        }
        (Element::Complex { single }, _) => {
            let (Some(re), Some(im)) = (member(0), member(1)) else {
                return Ok(None);
            };
            if is_plain(datatype, single) {
                return plain_complex(&windows, file, single, turn, spare).map(Some);
            }
            complex(&windows, re, im, single)?
        }
        (Element::Dof, _) => {
            let (Some(node), Some(direction)) = (member(0), member(1)) else {
                return Ok(None);
            };
            let dof = |bytes: &[u8]| dof_of(bytes, node, direction);
            windows.collect(dof)?.map(Values::Dofs)
        }
        (Element::Node, _) => {
            let (Some(label), Some(x), Some(y), Some(z)) =
                (member(0), member(1), member(2), member(3))
            else {
                return Ok(None);
            };
            let node = |bytes: &[u8]| node_of(bytes, label, [x, y, z]);
            windows.collect(node)?.map(Values::Nodes)
        }
        _ => None,
    })
}

/// Node and direction code of the first DOF record whose code is none of a direction.
pub(super) fn unknown_direction(dataset: &Dataset, datatype: &Datatype) -> Option<[i128; 2]> {
    let windows = Windows::new(dataset, datatype, 0..usize::MAX).ok()??;
    let (node, direction) = (Member::of(datatype, 0)?, Member::of(datatype, 1)?);
    let codes = windows.collect(|record| Some([node.integer(record)?, direction.integer(record)?]));
    let is_unknown = |code: i128| {
        let code = i64::try_from(code).ok();
        code.and_then(Direction::from_code).is_none()
    };
    codes.ok()??.into_iter().find(|[_, code]| is_unknown(*code))
}

fn complex(
    windows: &Windows<'_>,
    re: Member,
    im: Member,
    single: bool,
) -> Result<Option<Values<'static>>, Error> {
    Ok(if single {
        let values =
            windows.collect(|bytes| Some(Complex32::new(re.single(bytes)?, im.single(bytes)?)))?;
        values.map(|values| Values::Complex32(values.into()))
    } else {
        let values =
            windows.collect(|bytes| Some(Complex64::new(re.real(bytes)?, im.real(bytes)?)))?;
        values.map(|values| Values::Complex64(values.into()))
    })
}

fn dof_of(record: &[u8], node: Member, direction: Member) -> Option<Dof> {
    let code = i64::try_from(direction.integer(record)?).ok()?;
    let node = u64::try_from(node.integer(record)?).ok()?;
    Some(Dof::new(node, Direction::from_code(code)?))
}

fn node_of(record: &[u8], label: Member, [x, y, z]: [Member; 3]) -> Option<Node> {
    Some(Node {
        label: u64::try_from(label.integer(record)?).ok()?,
        xyz_m: [x.real(record)?, y.real(record)?, z.real(record)?],
    })
}

/// Complex numbers as this program and h5py write them on most machines: they are copied
/// without decoding each value.
fn plain_complex(
    windows: &Windows<'_>,
    file: &File,
    single: bool,
    turn: Option<Turn>,
    spare: Option<Values<'static>>,
) -> Result<Values<'static>, Error> {
    Ok(match (single, spare) {
        (true, Some(Values::Complex32(Cow::Owned(spare)))) => {
            Values::Complex32(windows.collect_plain(file, turn, spare)?.into())
        }
        (true, _) => Values::Complex32(windows.collect_plain(file, turn, Vec::new())?.into()),
        (false, Some(Values::Complex64(Cow::Owned(spare)))) => {
            Values::Complex64(windows.collect_plain(file, turn, spare)?.into())
        }
        (false, _) => Values::Complex64(windows.collect_plain(file, turn, Vec::new())?.into()),
    })
}

/// True where complex numbers lie in the file as they do in memory.
fn is_plain(datatype: &Datatype, single: bool) -> bool {
    let half = if single { 4 } else { 8 };
    let part = |index, offset| {
        Member::of(datatype, index).is_some_and(|part| part.is_plain(offset, single))
    };
    cfg!(target_endian = "little")
        && part(0, 0)
        && part(1, half)
        && datatype.type_size() as usize == 2 * half
}

/// True where all of a dataset of complex numbers lies in the file as it does in memory,
/// one value after the other.
pub(super) fn lies_in_one_stretch(file: &File, dataset: &Dataset) -> Result<bool, Error> {
    let datatype = dataset.datatype()?;
    let Element::Complex { single } = element_of(&datatype) else {
        return Ok(false);
    };
    let Some(windows) = Windows::new(dataset, &datatype, 0..usize::MAX)? else {
        return Ok(false);
    };
    Ok(is_plain(&datatype, single) && windows.stretch(file)?.is_some())
}

/// A dataset cut along its first axis.
struct Windows<'a> {
    dataset: &'a Dataset,
    element_bytes: usize,
    /// Elements in all.
    count: usize,
    rows: Range<u64>,
    row_bytes: u64,
    /// Rows of one window: whole chunks, so that none is unpacked twice.
    step: u64,
}

impl<'a> Windows<'a> {
    /// `None` for elements of size 0, and for more elements than can be counted.
    fn new(
        dataset: &'a Dataset,
        datatype: &Datatype,
        rows: Range<usize>,
    ) -> Result<Option<Self>, Error> {
        let shape = dataset.shape()?;
        let all = shape.first().copied().unwrap_or(1);
        let chunk_rows = dataset
            .chunk_shape()?
            .and_then(|shape| shape.first().copied())
            .unwrap_or(1)
            .max(1);
        let count = shape
            .iter()
            .try_fold(1_u64, |product, &extent| product.checked_mul(extent));
        let element_bytes = datatype.type_size() as usize;
        let Some((count, bytes)) =
            count.and_then(|count| Some((count, count.checked_mul(element_bytes as u64)?)))
        else {
            return Ok(None);
        };
        let row_bytes = bytes.checked_div(all).unwrap_or(0).max(1);
        let step = (WINDOW_BYTES / row_bytes)
            .max(1)
            .checked_next_multiple_of(chunk_rows)
            .unwrap_or(all);
        let rows = (rows.start as u64).min(all)..(rows.end as u64).min(all);
        let count = count.checked_div(all).unwrap_or(0) * (rows.end - rows.start);
        // a damaged header may claim any number of rows without elements: none is visited
        let rows = if count == 0 { 0..0 } else { rows };
        let count = usize::try_from(count).ok().filter(|_| element_bytes > 0);
        Ok(count.map(|count| Self {
            dataset,
            element_bytes,
            count,
            rows,
            row_bytes,
            step,
        }))
    }

    /// Gives the raw bytes of each window to `take`, until that returns false. Returns true
    /// where it took all.
    fn each(&self, mut take: impl FnMut(&[u8]) -> bool) -> Result<bool, Error> {
        let mut row = self.rows.start;
        while row < self.rows.end {
            if !take(
                &self
                    .dataset
                    .read_raw_rows(row, self.step.min(self.rows.end - row))?,
            ) {
                return Ok(false);
            }
            row = row.saturating_add(self.step);
        }
        Ok(true)
    }

    /// Offset of the rows in the file; `None` where the dataset does not lie there in one
    /// stretch.
    fn stretch(&self, file: &File) -> Result<Option<u64>, Error> {
        let Layout::Contiguous {
            address: Some(address),
            size,
        } = self.dataset.layout()?
        else {
            return Ok(None);
        };
        let is_whole = self
            .rows
            .end
            .checked_mul(self.row_bytes)
            .is_some_and(|end| end <= size);
        let is_inside = address
            .checked_add(size)
            .is_some_and(|end| end <= file.bytes);
        Ok((is_whole && is_inside).then(|| address + self.rows.start * self.row_bytes))
    }

    /// Reads every element of a type that lies in the file as it does in memory, into the memory
    /// of `values`.
    fn collect_plain<T: Pod>(
        &self,
        file: &File,
        turn: Option<Turn>,
        mut values: Vec<T>,
    ) -> Result<Vec<T>, Error> {
        let Some(start) = self.stretch(file)? else {
            values.clear();
            values.reserve_exact(self.count);
            self.each(|raw| {
                values.extend(
                    raw.chunks_exact(size_of::<T>())
                        .map(bytemuck::pod_read_unaligned::<T>),
                );
                true
            })?;
            return Ok(values);
        };
        values.truncate(self.count);
        if let Some(mut turn) = turn {
            values.resize(self.count, T::zeroed());
            let bytes = bytemuck::cast_slice_mut(&mut values);
            read_past_cache(&file.place, start, bytes)?;
            turn.pass(start, bytes);
            return Ok(values);
        }
        let mut file = std::fs::File::open(&*file.place)?;
        file.seek(SeekFrom::Start(start))?;
        values.reserve_exact(self.count - values.len());
        for at in (0..self.count).step_by(STRETCH_BYTES / size_of::<T>()) {
            let end = (at + STRETCH_BYTES / size_of::<T>()).min(self.count);
            if values.len() < end {
                values.resize(end, T::zeroed());
            }
            file.read_exact(bytemuck::cast_slice_mut(&mut values[at..end]))?;
        }
        Ok(values)
    }

    /// Decodes every element with `read`; `None` where one is not understood.
    fn collect<T>(&self, read: impl Fn(&[u8]) -> Option<T>) -> Result<Option<Vec<T>>, Error> {
        let mut values = Vec::with_capacity(self.count);
        let understood = self.each(|raw| {
            raw.chunks(self.element_bytes)
                .all(|bytes| read(bytes).map(|value| values.push(value)).is_some())
        })?;
        Ok(understood.then_some(values))
    }
}
