//! MATLAB files of version 5 to 7 (`save` without `-v7.3`): arrays, structs and cells as
//! a tree of paths.
//!
//! The format: MathWorks, "MAT-File Format", level 5. A 128-byte header, then elements of
//! a tag (type, count of bytes) and data padded to 8 bytes; version 7 packs each variable
//! with zlib. Arrays are column-major, real and imaginary parts in blocks of their own.
//! Files of version 7.3 are HDF5 and are read there.

mod element;
mod unpack;
mod write;

pub(super) use write::{damping_name, scaling_name, trust_name, MatFile, PER_MODE};

use super::arrays::memory::{AxisOrder, MemoryFile};
use super::arrays::tree::{check_nesting, Values};
use super::{Document, FileFormat, ReadOptions};
use chladni_frf::{Error, Finding, Result};
use element::{Element, Elements, Order};
use num_complex::{Complex32, Complex64};
use std::borrow::Cow;
use std::path::Path;

const HEADER_BYTES: usize = 128;
/// Types of elements that hold other elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Bit of the array flags: an imaginary part follows.
const COMPLEX: u32 = 0x0800;

/// Classes of arrays.
const CELL: u32 = 1;
const STRUCT: u32 = 2;
const CHAR: u32 = 4;
const SINGLE: u32 = 7;
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;

/// Reads a file; `sha256` is left empty.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] for a file cut short, sizes that disagree, text in place
/// of numbers.
pub(super) fn read(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Document> {
    let arrays = read_arrays(bytes).map_err(|error| error.file(path))?;
    arrays.document(path, FileFormat::Matlab, options)
}

fn read_arrays(bytes: &[u8]) -> Result<MemoryFile> {
    let order = byte_order(bytes)?;
    let mut walk = Walk {
        order,
        budget: unpack::Budget::new(bytes.len()),
        arrays: MemoryFile::default(),
        objects: 0,
    };
    for element in Elements::new(&bytes[HEADER_BYTES..], HEADER_BYTES, order) {
        walk.variable(&element?)?;
    }
    if walk.arrays.is_empty() {
        walk.arrays.warnings.push(Finding::caution(
            "not-read",
            "no array of numbers is in the file",
        ));
    }
    Ok(walk.arrays)
}

fn byte_order(bytes: &[u8]) -> Result<Order> {
    let mark = bytes.get(126..HEADER_BYTES);
    match mark {
        Some(b"IM") => Ok(Order::Little),
        Some(b"MI") => Ok(Order::Big),
        _ => Err(Error::bad_data("the header of the MATLAB file is damaged")
            .at_byte(126)
            .field("endian indicator")
            .found(mark.map_or("the end of the file".into(), String::from_utf8_lossy))
            .expected("IM or MI")
            .help(
                "the file is cut short or was changed by a text transfer; copy it again in \
                   binary mode",
            )),
    }
}

struct Walk {
    order: Order,
    budget: unpack::Budget,
    arrays: MemoryFile,
    objects: usize,
}

impl Walk {
    /// Reads one element of the file: a matrix, or a packed one.
    fn variable(&mut self, element: &Element<'_>) -> Result<()> {
        match element.kind {
            MATRIX => self.matrix(element, "", None, 0),
            COMPRESSED => {
                let unpacked = self.budget.unpack(element)?;
                let inner = Elements::new(&unpacked, element.byte, self.order).next();
                let inner = inner
                    .transpose()?
                    .filter(|inner| inner.kind == MATRIX)
                    .ok_or_else(|| {
                        let error = Error::bad_data("a packed element holds no array")
                            .at_byte(element.byte as u64)
                            .field("compressed element");
                        error.found("something else").expected("a matrix element")
                    })?;
                self.matrix(&inner, "", None, 0)
            }
            other => {
                self.arrays.warnings.push(Finding::note(
                    "not-read",
                    format!(
                        "an element of type {other} at byte {} is not read",
                        element.byte
                    ),
                ));
                Ok(())
            }
        }
    }

    /// The texts of a cell array of texts alone.
    fn texts(&self, cells: &[Result<Element<'_>>]) -> Result<Option<Vec<String>>> {
        let mut texts = Vec::with_capacity(cells.len());
        for cell in cells {
            let Ok(cell) = cell else { return Ok(None) };
            let parts: Vec<_> = Elements::new(cell.bytes, cell.byte, self.order).collect();
            let [Ok(flags), Ok(_), Ok(_), Ok(characters)] = parts.as_slice() else {
                return Ok(None);
            };
            let word = flags.unsigned(self.order)?.first().copied().unwrap_or(0) as u32;
            if word & 0xff != CHAR {
                return Ok(None);
            }
            texts.push(characters.text(self.order)?);
        }
        Ok((!texts.is_empty()).then_some(texts))
    }

    /// Reads an array into `folder`, under its own name, else under `name` (the name of a
    /// field or the number of a cell).
    fn matrix(
        &mut self,
        element: &Element<'_>,
        folder: &str,
        name: Option<&str>,
        depth: usize,
    ) -> Result<()> {
        self.objects += 1;
        check_nesting(folder, depth, self.objects)?;
        if element.bytes.is_empty() {
            return Ok(()); // an empty field
        }
        let mut parts = Elements::new(element.bytes, element.byte, self.order);
        let mut part = |what: &str| -> Result<Element<'_>> {
            let next = parts.next().transpose()?;
            next.ok_or_else(|| ends_early(element, what))
        };
        let flags = part("array flags")?;
        let word = flags.unsigned(self.order)?.first().copied().unwrap_or(0) as u32;
        let (class, complex) = (word & 0xff, word & COMPLEX != 0);
        let dimensions = part("dimensions")?;
        let shape: Vec<usize> = dimensions
            .unsigned(self.order)?
            .into_iter()
            .map(|extent| usize::try_from(extent).unwrap_or(usize::MAX))
            .collect();
        let own_name = String::from_utf8_lossy(part("name")?.bytes).into_owned();
        let path = format!("{folder}/{}", safe_name(name.unwrap_or(&own_name)));
        match class {
            CHAR => {
                let texts = rows(part("characters")?.text(self.order)?, &shape);
                self.arrays.add(
                    &path,
                    vec![texts.len()],
                    Values::Text(texts),
                    AxisOrder::Same,
                );
                Ok(())
            }
            CELL => self.cells(parts.collect(), &path, depth),
            STRUCT => {
                let width = part("length of field names")?.unsigned(self.order)?;
                let width = width.first().copied().unwrap_or(0) as usize;
                let names = part("field names")?.bytes.chunks(width.max(1));
                let names: Vec<String> = names.map(|name| trimmed(name).to_string()).collect();
                let several = shape.iter().product::<usize>() > 1;
                self.fields(parts, &names, several, &path, depth)
            }
            _ if NUMERIC.contains(&class) => {
                let re = part("values")?;
                let im = complex.then(|| part("imaginary parts")).transpose()?;
                let count = checked_count(&shape, element, &path)?;
                let values = values(class, &re, im.as_ref(), self.order)?;
                self.numbers(values, (shape, count), &re, &path)
            }
            _ => {
                let words = format!("{path}: {} is not read", class_name(class));
                self.arrays.warnings.push(Finding::note("not-read", words));
                Ok(())
            }
        }
    }

    /// Keeps the values of an array of numbers, whose count must be that of the dimensions.
    fn numbers(
        &mut self,
        (values, found): (Values<'static>, usize),
        (shape, count): (Vec<usize>, usize),
        re: &Element<'_>,
        path: &str,
    ) -> Result<()> {
        if found != count {
            return Err(
                Error::bad_data("the count of values does not fit the dimensions")
                    .at_byte(re.byte as u64)
                    .field(path)
                    .found(format!("{found} values"))
                    .expected(format!("{count} for dimensions {shape:?}")),
            );
        }
        // column-major in MATLAB's order of axes is row-major in the reverse
        let shape = shape.into_iter().rev().collect();
        self.arrays.add(path, shape, values, AxisOrder::Reversed);
        Ok(())
    }

    /// Reads the cells of an array: texts as one array, other cells one by one.
    fn cells(&mut self, cells: Vec<Result<Element<'_>>>, path: &str, depth: usize) -> Result<()> {
        if let Some(texts) = self.texts(&cells)? {
            let count = texts.len();
            self.arrays
                .add(path, vec![count], Values::Text(texts), AxisOrder::Same);
            return Ok(());
        }
        for (k, cell) in cells.into_iter().enumerate() {
            self.matrix(&cell?, path, Some(&(k + 1).to_string()), depth + 1)?;
        }
        Ok(())
    }

    /// Reads the fields of a struct, or of each of several.
    fn fields(
        &mut self,
        values: Elements<'_>,
        names: &[String],
        several: bool,
        path: &str,
        depth: usize,
    ) -> Result<()> {
        for (k, value) in values.enumerate() {
            let Some(name) = names.get(k % names.len().max(1)) else {
                break;
            };
            let folder = if several {
                format!("{path}/{}", k / names.len() + 1)
            } else {
                path.to_owned()
            };
            self.matrix(&value?, &folder, Some(name), depth + 1)?;
        }
        Ok(())
    }
}

fn ends_early(array: &Element<'_>, missing: &str) -> Error {
    Error::bad_data("the array ends early")
        .at_byte(array.byte as u64)
        .field(missing)
        .found("the end of the array")
        .expected("flags, dimensions, name and values")
}

/// Values and their count.
fn values(
    class: u32,
    re: &Element<'_>,
    im: Option<&Element<'_>>,
    order: Order,
) -> Result<(Values<'static>, usize)> {
    if let Some(im) = im {
        let (re, im) = (re.reals(order)?, im.reals(order)?);
        if re.len() != im.len() {
            return Err(Error::bad_data("real and imaginary parts differ in length")
                .field("imaginary parts")
                .found(im.len())
                .expected(format!("{}, as many as real parts", re.len())));
        }
        let count = re.len();
        let pairs = re.into_iter().zip(im);
        return Ok(match class {
            SINGLE => (
                Values::Complex32(
                    pairs
                        .map(|(re, im)| Complex32::new(re as f32, im as f32))
                        .collect(),
                ),
                count,
            ),
            _ => (
                Values::Complex64(pairs.map(|(re, im)| Complex64::new(re, im)).collect()),
                count,
            ),
        });
    }
    let reals = re.reals(order)?;
    let count = reals.len();
    Ok(match class {
        SINGLE => (
            Values::Real32(reals.into_iter().map(|value| value as f32).collect()),
            count,
        ),
        _ => (Values::Real64(Cow::Owned(reals)), count),
    })
}

/// Number of values by the dimensions; an error where the file has fewer bytes.
fn checked_count(shape: &[usize], element: &Element<'_>, path: &str) -> Result<usize> {
    let count = shape
        .iter()
        .try_fold(1usize, |product, &extent| product.checked_mul(extent));
    count
        .filter(|&count| count <= element.bytes.len())
        .ok_or_else(|| {
            Error::bad_data("the array claims more values than are there")
                .at_byte(element.byte as u64)
                .field(path)
                .found(format!(
                    "dimensions {shape:?}, {} bytes",
                    element.bytes.len()
                ))
                .expected("at least one byte for each value")
                .help("the file is damaged: save or copy it again")
        })
}

/// Text up to the first zero byte.
fn trimmed(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.split(|&byte| byte == 0).next().unwrap_or_default())
}

/// The texts of a matrix of characters, stored column by column: one for each row, without
/// trailing blanks.
fn rows(text: String, shape: &[usize]) -> Vec<String> {
    let (Some(&count), characters) = (shape.first(), text.chars().count()) else {
        return vec![text];
    };
    if count < 2 || !characters.is_multiple_of(count) {
        return vec![text];
    }
    let row = |k: usize| text.chars().skip(k).step_by(count).collect::<String>();
    let trimmed = |k: usize| row(k).trim_end().to_owned();
    (0..count).map(trimmed).collect()
}

/// A name without the separator of paths.
fn safe_name(name: &str) -> String {
    name.chars()
        .map(|c| if c == '/' || c.is_control() { '_' } else { c })
        .collect()
}

fn class_name(class: u32) -> &'static str {
    match class {
        3 => "an object",
        5 => "a sparse array",
        16 => "a function handle",
        17 => "an object of a newer class",
        _ => "an array of an unknown class",
    }
}
