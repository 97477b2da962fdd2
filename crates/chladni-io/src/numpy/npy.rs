//! One array: a header in the syntax of a Python dictionary, and its values.

use crate::arrays::memory::{AxisOrder, MemoryFile};
use crate::arrays::tree::Values;
use chladni_frf::{Error, Result};
use num_complex::{Complex32, Complex64};
use std::borrow::Cow;

/// Longest header: a name, an order and a shape.
const MOST_HEADER_BYTES: usize = 1 << 16;
/// Most axes of an array.
const MOST_AXES: usize = 32;

/// The content of the header.
#[derive(Debug, PartialEq)]
struct Header {
    /// `<`, `>` or `|`.
    big_endian: bool,
    kind: u8,
    /// Bytes of one value; of texts, characters.
    size: usize,
    fortran_order: bool,
    shape: Vec<usize>,
}

impl Header {
    /// The type of the values, for people.
    fn type_in_words(&self) -> String {
        match self.kind {
            b'O' => "pickled objects (object)".into(),
            b'V' => "records or raw bytes (void)".into(),
            b'M' => "dates (datetime64)".into(),
            b'm' => "durations (timedelta64)".into(),
            kind if kind.is_ascii_graphic() => format!("{}{}", char::from(kind), self.size),
            _ => "an unknown type".into(),
        }
    }
}

/// Adds the array in `bytes` under `path`; one of a type that is not read, without values.
///
/// # Errors
/// A damaged header, values of another count.
pub(super) fn read_array(bytes: &[u8], path: &str, arrays: &mut MemoryFile) -> Result<()> {
    let (header, data) = split(bytes).map_err(|error| error.field(format!("header of {path}")))?;
    let value_bytes = if header.kind == b'U' {
        header.size.saturating_mul(4)
    } else {
        header.size
    };
    let count = header
        .shape
        .iter()
        .try_fold(1usize, |product, &extent| product.checked_mul(extent));
    let needed = count.and_then(|count| count.checked_mul(value_bytes));
    // pickled objects may have any number of bytes
    let is_read = values(&header, &[]).is_some();
    if count.is_none() || (is_read && needed != Some(data.len())) {
        let needed = needed.map_or("more bytes than can be counted".into(), |needed| {
            format!("{needed} bytes")
        });
        let error = Error::bad_data("the count of values does not fit the shape")
            .at_byte((bytes.len() - data.len()) as u64)
            .field(path)
            .found(format!("{} bytes of data", data.len()))
            .expected(format!("{needed} for shape {:?}", header.shape));
        return Err(error.help("the file is cut short or damaged: save or copy it again"));
    }
    let values = values(&header, data);
    let type_in_words = header.type_in_words();
    // column-major is row-major in the reverse order of axes
    let shape = if header.fortran_order {
        header.shape.into_iter().rev().collect()
    } else {
        header.shape
    };
    let order = match header.fortran_order {
        true => AxisOrder::Reversed,
        false => AxisOrder::Same,
    };
    match values {
        Some(values) => arrays.add(path, shape, values, order),
        None => arrays.add_unread(path, shape, type_in_words, order),
    }
    Ok(())
}

fn split(bytes: &[u8]) -> Result<(Header, &[u8])> {
    let damaged = |found: &str, expected: &str| {
        let error = Error::bad_data("the header of the array is damaged")
            .at_byte(0)
            .found(found)
            .expected(expected);
        error.help(
            "the file is cut short or was changed by a text transfer; copy it again in binary mode",
        )
    };
    let version = bytes
        .strip_prefix(crate::signatures::NPY_SIGNATURE)
        .and_then(|rest| rest.first().copied());
    let (length, start): (usize, usize) = match (version, bytes.get(8..12)) {
        (Some(1), Some(&[a, b, ..])) => (usize::from(u16::from_le_bytes([a, b])), 10),
        (Some(2 | 3), Some(&[a, b, c, d])) => (u32::from_le_bytes([a, b, c, d]) as usize, 12),
        _ => {
            return Err(damaged(
                "another version or the end of the file",
                "version 1, 2 or 3",
            ))
        }
    };
    let text = bytes
        .get(start..start.saturating_add(length))
        .filter(|_| length <= MOST_HEADER_BYTES);
    let text = text.ok_or_else(|| {
        damaged(
            &format!("{length} bytes of header declared"),
            "a header inside the file",
        )
    })?;
    let text = String::from_utf8_lossy(text);
    let header = parse(&text).ok_or_else(|| {
        damaged(
            text.trim(),
            "{'descr': ..., 'fortran_order': ..., 'shape': (...)}",
        )
    })?;
    Ok((header, &bytes[start + length..]))
}

/// The text after `'key':`.
fn behind<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    ['\'', '"'].iter().find_map(|quote| {
        let quoted = format!("{quote}{key}{quote}");
        // the name of a field in a record has no colon behind it
        text.match_indices(quoted.as_str()).find_map(|(at, _)| {
            let rest = text[at + quoted.len()..].trim_start().strip_prefix(':')?;
            Some(rest.trim_start())
        })
    })
}

/// Byte order, kind and size of a type; a list is a record, of kind `V`.
fn element_type(descr: &str) -> Option<(u8, u8, usize)> {
    if descr.starts_with('[') {
        return Some((b'|', b'V', 0));
    }
    let quote = descr.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    let code = descr[1..].split(quote).next()?;
    let (order, rest) = match code.as_bytes().first()? {
        order @ (b'<' | b'>' | b'|' | b'=') => (*order, &code[1..]),
        _ => (b'|', code),
    };
    let kind = *rest.as_bytes().first()?;
    // pickled objects (`O`) have no size, dates a unit behind it: `M8[ns]`
    let size = if rest.len() == 1 || matches!(kind, b'M' | b'm') {
        0
    } else {
        rest.get(1..)?.parse().ok()?
    };
    Some((order, kind, size))
}

fn parse(text: &str) -> Option<Header> {
    let (order, kind, size) = element_type(behind(text, "descr")?)?;
    let fortran_order = match behind(text, "fortran_order")? {
        text if text.starts_with("True") => true,
        text if text.starts_with("False") => false,
        _ => return None,
    };
    let shape = behind(text, "shape")?
        .strip_prefix('(')?
        .split(')')
        .next()?;
    let extents = shape
        .split(',')
        .map(str::trim)
        .filter(|extent| !extent.is_empty());
    let shape: Vec<usize> = extents
        .map(|extent| extent.trim_end_matches('L').parse().ok())
        .collect::<Option<_>>()?;
    (shape.len() <= MOST_AXES).then_some(Header {
        big_endian: order == b'>',
        kind,
        size,
        fortran_order,
        shape,
    })
}

/// Numbers of `N` bytes each.
fn numbers<const N: usize, T>(
    data: &[u8],
    big_endian: bool,
    little: fn([u8; N]) -> T,
    big: fn([u8; N]) -> T,
) -> Vec<T> {
    let read = if big_endian { big } else { little };
    data.chunks_exact(N)
        .filter_map(|chunk| chunk.try_into().ok())
        .map(read)
        .collect()
}

macro_rules! numbers_of {
    ($number:ty as $wide:ty, $data:expr, $big:expr) => {
        numbers::<{ size_of::<$number>() }, $wide>(
            $data,
            $big,
            |b| <$number>::from_le_bytes(b) as $wide,
            |b| <$number>::from_be_bytes(b) as $wide,
        )
    };
}

fn values(header: &Header, data: &[u8]) -> Option<Values<'static>> {
    let big = header.big_endian;
    Some(match (header.kind, header.size) {
        (b'f', 8) => Values::Real64(Cow::Owned(numbers_of!(f64 as f64, data, big))),
        (b'f', 4) => Values::Real32(Cow::Owned(numbers_of!(f32 as f32, data, big))),
        (b'c', 16) => {
            let parts = numbers_of!(f64 as f64, data, big);
            Values::Complex64(
                parts
                    .chunks_exact(2)
                    .map(|pair| Complex64::new(pair[0], pair[1]))
                    .collect(),
            )
        }
        (b'c', 8) => {
            let parts = numbers_of!(f32 as f32, data, big);
            Values::Complex32(
                parts
                    .chunks_exact(2)
                    .map(|pair| Complex32::new(pair[0], pair[1]))
                    .collect(),
            )
        }
        (b'i', 8) => Values::Signed(Cow::Owned(numbers_of!(i64 as i64, data, big))),
        (b'i', 4) => Values::Signed(Cow::Owned(numbers_of!(i32 as i64, data, big))),
        (b'i', 2) => Values::Signed(Cow::Owned(numbers_of!(i16 as i64, data, big))),
        (b'i', 1) => Values::Signed(Cow::Owned(numbers_of!(i8 as i64, data, big))),
        (b'u', 8) => Values::Unsigned(Cow::Owned(numbers_of!(u64 as u64, data, big))),
        (b'u', 4) => Values::Unsigned(Cow::Owned(numbers_of!(u32 as u64, data, big))),
        (b'u', 2) => Values::Unsigned(Cow::Owned(numbers_of!(u16 as u64, data, big))),
        (b'u' | b'b', 1) => Values::Unsigned(Cow::Owned(numbers_of!(u8 as u64, data, big))),
        (b'U', size) if size > 0 => Values::Text(
            data.chunks_exact(4 * size)
                .map(|text| numbers_of!(u32 as u32, text, big))
                .map(|units| {
                    units
                        .into_iter()
                        .filter_map(char::from_u32)
                        .take_while(|&c| c != '\0')
                        .collect()
                })
                .collect(),
        ),
        (b'S', size) if size > 0 => Values::Text(
            data.chunks_exact(size)
                .map(|text| {
                    String::from_utf8_lossy(text)
                        .trim_end_matches('\0')
                        .to_owned()
                })
                .collect(),
        ),
        _ => return None,
    })
}

/// The header of an array to be written, padded as the format asks: data begin at a
/// multiple of 64 bytes.
pub(super) fn header(code: &str, shape: &[usize]) -> Vec<u8> {
    const ALIGNMENT: usize = 64;
    const BEFORE: usize = 10;
    let extents: String = shape.iter().map(|extent| format!("{extent},")).collect();
    let mut text = format!("{{'descr': '{code}', 'fortran_order': False, 'shape': ({extents}), }}");
    let padded = (BEFORE + text.len() + 1).div_ceil(ALIGNMENT) * ALIGNMENT;
    while BEFORE + text.len() + 1 < padded {
        text.push(' ');
    }
    text.push('\n');
    let mut header = crate::signatures::NPY_SIGNATURE.to_vec();
    header.extend([1, 0]);
    header.extend((text.len() as u16).to_le_bytes());
    header.extend(text.as_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_numpy_are_parsed() {
        let read = |text: &str| parse(text).unwrap();
        let plain = read("{'descr': '<c16', 'fortran_order': False, 'shape': (3, 4), }");
        assert_eq!(
            plain,
            Header {
                big_endian: false,
                kind: b'c',
                size: 16,
                fortran_order: false,
                shape: vec![3, 4]
            }
        );
        let other = read("{\"shape\": (), \"fortran_order\": True, \"descr\": \">U12\"}");
        assert_eq!(
            other,
            Header {
                big_endian: true,
                kind: b'U',
                size: 12,
                fortran_order: true,
                shape: vec![]
            }
        );
        for (descr, kind) in [
            ("[('a', '<f8'), ('shape', '<f8', (2,))]", b'V'),
            ("'<M8[ns]'", b'M'),
            ("'|O'", b'O'),
        ] {
            let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (3,), }}");
            let header = read(&text);
            assert_eq!((header.kind, header.shape), (kind, vec![3]), "{descr}");
        }
        for bad in [
            "",
            "{'descr': '<f8', 'shape': (3,)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (-3,)}",
        ] {
            assert_eq!(parse(bad), None, "{bad}");
        }
    }

    #[test]
    fn a_written_header_reads_back_and_is_aligned() {
        let bytes = header("<f8", &[2, 3]);
        assert_eq!(bytes.len() % 64, 0);
        let mut file = bytes.clone();
        file.extend([0; 48]);
        let (header, data) = split(&file).unwrap();
        assert_eq!((header.shape, data.len()), (vec![2, 3], 48));
    }

    #[test]
    fn sizes_that_disagree_are_refused_and_other_types_not_read() {
        let array = |code: &str, shape: &[usize], bytes: usize| {
            [header(code, shape), vec![0; bytes]].concat()
        };
        let read = |bytes: &[u8]| {
            let mut arrays = MemoryFile::default();
            read_array(bytes, "/a", &mut arrays).map(|()| arrays)
        };
        assert!(read(&array("<f8", &[3], 24)).unwrap().warnings.is_empty());
        for bad in [
            array("<f8", &[3], 23),
            array("<f8", &[usize::MAX, 3], 24),
            array("|O", &[usize::MAX, 3], 24),
        ] {
            assert!(read(&bad).is_err());
        }
        for other in [
            array("|O", &[3], 25),
            array("<f2", &[3], 6),
            array("<f3", &[3], 9),
            array("<M8[ns]", &[3], 24),
        ] {
            let arrays = read(&other).unwrap();
            let error = arrays.largest_unread().unwrap();
            assert!(error.help.unwrap().contains("as numbers"));
            assert_eq!(arrays.warnings[0].code, "not-read");
        }
        assert!(read(b"\x93NUMPY\x01\x00\xff\xff{}").is_err());
    }
}
