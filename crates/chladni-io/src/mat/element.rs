//! Elements of a MATLAB file: a tag of type and size, and data.

use chladni_frf::{Error, Result};

/// Byte order of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

impl Order {
    fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            Self::Little => u32::from_le_bytes(bytes),
            Self::Big => u32::from_be_bytes(bytes),
        }
    }
}

/// One element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<'a> {
    /// Type code.
    pub kind: u32,
    pub bytes: &'a [u8],
    /// Offset of its tag in the file; in a packed element, that of the packed one.
    pub byte: usize,
}

/// Elements one after another.
pub(super) struct Elements<'a> {
    rest: &'a [u8],
    byte: usize,
    order: Order,
}

const COMPRESSED: u32 = 15;
const TAG_BYTES: usize = 8;
/// Data begin at multiples of this.
const ALIGNMENT: usize = 8;

impl<'a> Elements<'a> {
    /// The elements in `bytes`, which begin at `byte` of the file.
    pub(super) fn new(bytes: &'a [u8], byte: usize, order: Order) -> Self {
        Self {
            rest: bytes,
            byte,
            order,
        }
    }

    fn advance(&mut self, count: usize) {
        let count = count.min(self.rest.len());
        self.rest = &self.rest[count..];
        self.byte += count;
    }

    fn element(&mut self) -> Result<Element<'a>> {
        let byte = self.byte;
        let short = |needed: usize, present: usize| {
            Err(Error::bad_data("the file ends inside an element")
                .at_byte(byte as u64)
                .field("size of the element")
                .found(format!("{needed} bytes declared, {present} present"))
                .expected("all its bytes")
                .help("the file is cut short: save or copy it again"))
        };
        let Some((tag, data)) = self.rest.split_first_chunk::<TAG_BYTES>() else {
            return short(TAG_BYTES, self.rest.len());
        };
        let words = [
            [tag[0], tag[1], tag[2], tag[3]],
            [tag[4], tag[5], tag[6], tag[7]],
        ]
        .map(|word| self.order.u32(word));
        // a small element keeps its size in the upper half of the first word, and its
        // data in the second
        let small = (words[0] >> 16) as usize;
        if small > 0 {
            let kind = words[0] & 0xffff;
            if small > 4 {
                return short(small, 4);
            }
            let bytes = &self.rest[4..4 + small];
            self.advance(TAG_BYTES);
            return Ok(Element { kind, bytes, byte });
        }
        let size = words[1] as usize;
        let Some(bytes) = data.get(..size) else {
            return short(size, data.len());
        };
        let padded = if words[0] == COMPRESSED {
            size
        } else {
            size.div_ceil(ALIGNMENT) * ALIGNMENT
        };
        self.advance(TAG_BYTES + padded);
        Ok(Element {
            kind: words[0],
            bytes,
            byte,
        })
    }
}

impl<'a> Iterator for Elements<'a> {
    type Item = Result<Element<'a>>;
    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let element = self.element();
        if element.is_err() {
            self.rest = &[];
        }
        Some(element)
    }
}

/// Numbers of `N` bytes each, as `f64`.
fn numbers<const N: usize>(
    bytes: &[u8],
    order: Order,
    little: fn([u8; N]) -> f64,
    big: fn([u8; N]) -> f64,
) -> Vec<f64> {
    let read = if order == Order::Little { little } else { big };
    bytes
        .chunks_exact(N)
        .filter_map(|chunk| chunk.try_into().ok())
        .map(read)
        .collect()
}

macro_rules! numbers_of {
    ($number:ty, $bytes:expr, $order:expr) => {
        numbers::<{ size_of::<$number>() }>(
            $bytes,
            $order,
            |b| <$number>::from_le_bytes(b) as f64,
            |b| <$number>::from_be_bytes(b) as f64,
        )
    };
}

impl Element<'_> {
    /// Bytes of one number, for the types of numbers.
    fn number_bytes(&self) -> Option<usize> {
        match self.kind {
            1 | 2 => Some(1),
            3 | 4 => Some(2),
            5..=7 => Some(4),
            9 | 12 | 13 => Some(8),
            _ => None,
        }
    }

    /// Its numbers, widened.
    pub(super) fn reals(&self, order: Order) -> Result<Vec<f64>> {
        let wrong = |found: String, expected: &str| {
            Err(Error::bad_data("no numbers where numbers belong")
                .at_byte(self.byte as u64)
                .field("element")
                .found(found)
                .expected(expected)
                .help("the file is damaged: save or copy it again"))
        };
        let Some(size) = self.number_bytes() else {
            return wrong(
                format!("type {}", self.kind),
                "a numeric type, 1 to 7, 9, 12 or 13",
            );
        };
        if !self.bytes.len().is_multiple_of(size) {
            return wrong(
                format!("{} bytes", self.bytes.len()),
                &format!("a multiple of {size} bytes"),
            );
        }
        let bytes = self.bytes;
        Ok(match self.kind {
            1 => numbers_of!(i8, bytes, order),
            2 => numbers_of!(u8, bytes, order),
            3 => numbers_of!(i16, bytes, order),
            4 => numbers_of!(u16, bytes, order),
            5 => numbers_of!(i32, bytes, order),
            6 => numbers_of!(u32, bytes, order),
            7 => numbers_of!(f32, bytes, order),
            9 => numbers_of!(f64, bytes, order),
            12 => numbers_of!(i64, bytes, order),
            _ => numbers_of!(u64, bytes, order),
        })
    }

    /// Its numbers as sizes; negative ones are refused.
    pub(super) fn unsigned(&self, order: Order) -> Result<Vec<u64>> {
        let reals = self.reals(order)?;
        if let Some(negative) = reals.iter().find(|&&value| value < 0.0) {
            return Err(Error::bad_data("a size cannot be negative")
                .at_byte(self.byte as u64)
                .field("dimensions")
                .found(negative)
                .expected("0 or more"));
        }
        Ok(reals.into_iter().map(|value| value as u64).collect())
    }

    /// Its text: UTF-8, UTF-16 or single bytes.
    pub(super) fn text(&self, order: Order) -> Result<String> {
        match self.kind {
            16 | 1 | 2 => Ok(String::from_utf8_lossy(self.bytes).into_owned()),
            _ => {
                let units: Vec<u16> = self
                    .reals(order)?
                    .into_iter()
                    .map(|unit| unit as u16)
                    .collect();
                Ok(String::from_utf16_lossy(&units))
            }
        }
    }
}
