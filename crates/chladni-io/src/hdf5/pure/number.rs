//! Numbers in the bytes of a file, alone and inside records.

use hdf5_pure::{Datatype, DatatypeByteOrder};

/// A number of a file: width, kind and byte order.
#[derive(Clone, Copy)]
pub(super) enum Number {
    Float32 {
        big: bool,
    },
    Float64 {
        big: bool,
    },
    Integer {
        size: usize,
        signed: bool,
        big: bool,
    },
}

impl Number {
    pub(super) fn of(datatype: &Datatype) -> Option<Self> {
        let is_big = |order: &DatatypeByteOrder| match order {
            DatatypeByteOrder::LittleEndian => Some(false),
            DatatypeByteOrder::BigEndian => Some(true),
            DatatypeByteOrder::Vax => None,
        };
        match datatype {
            Datatype::FloatingPoint {
                size: 4,
                byte_order,
                layout,
            } if *layout == hdf5_pure::FloatingPointLayout::IEEE754_BINARY32 => {
                Some(Self::Float32 {
                    big: is_big(byte_order)?,
                })
            }
            Datatype::FloatingPoint {
                size: 8,
                byte_order,
                layout,
            } if *layout == hdf5_pure::FloatingPointLayout::IEEE754_BINARY64 => {
                Some(Self::Float64 {
                    big: is_big(byte_order)?,
                })
            }
            Datatype::FixedPoint {
                size,
                byte_order,
                layout,
            } if matches!(size, 1 | 2 | 4 | 8)
                && layout.bit_offset == 0
                && u32::from(layout.bit_precision) == 8 * size =>
            {
                Some(Self::Integer {
                    size: *size as usize,
                    signed: layout.signed,
                    big: is_big(byte_order)?,
                })
            }
            Datatype::Enumeration { base_type, .. } => Self::of(base_type),
            _ => None,
        }
    }

    pub(super) fn integer(self, bytes: &[u8]) -> Option<i128> {
        let Self::Integer { size, signed, big } = self else {
            return None;
        };
        let mut word = [0_u8; 8];
        for (k, &byte) in bytes.get(..size)?.iter().enumerate() {
            word[if big { size - 1 - k } else { k }] = byte;
        }
        let unused = 64 - 8 * size as u32;
        let value = u64::from_le_bytes(word);
        Some(if signed {
            i128::from(((value << unused) as i64) >> unused)
        } else {
            i128::from(value)
        })
    }

    pub(super) fn real(self, bytes: &[u8]) -> Option<f64> {
        match self {
            Self::Float32 { .. } => self.single(bytes).map(f64::from),
            Self::Float64 { big } => {
                let word = bytes.get(..8)?.try_into().ok()?;
                Some(if big {
                    f64::from_be_bytes(word)
                } else {
                    f64::from_le_bytes(word)
                })
            }
            Self::Integer { .. } => self.integer(bytes).map(|value| value as f64),
        }
    }

    pub(super) fn single(self, bytes: &[u8]) -> Option<f32> {
        let Self::Float32 { big } = self else {
            return None;
        };
        let word = bytes.get(..4)?.try_into().ok()?;
        Some(if big {
            f32::from_be_bytes(word)
        } else {
            f32::from_le_bytes(word)
        })
    }
}

/// A number inside a record.
#[derive(Clone, Copy)]
pub(super) struct Member {
    offset: usize,
    number: Number,
}

impl Member {
    pub(super) fn of(datatype: &Datatype, index: usize) -> Option<Self> {
        let Datatype::Compound { members, .. } = datatype else {
            return None;
        };
        let member = members.get(index)?;
        Some(Self {
            offset: usize::try_from(member.byte_offset).ok()?,
            number: Number::of(&member.datatype)?,
        })
    }
    pub(super) fn real(self, record: &[u8]) -> Option<f64> {
        self.number.real(record.get(self.offset..)?)
    }
    /// True for a little-endian float of 4 (`single`) or 8 bytes at `offset`, half of its
    /// record.
    pub(super) fn is_plain(self, offset: usize, single: bool) -> bool {
        let kind = if single {
            matches!(self.number, Number::Float32 { big: false })
        } else {
            matches!(self.number, Number::Float64 { big: false })
        };
        kind && self.offset == offset
    }
    pub(super) fn single(self, record: &[u8]) -> Option<f32> {
        self.number.single(record.get(self.offset..)?)
    }
    pub(super) fn integer(self, record: &[u8]) -> Option<i128> {
        self.number.integer(record.get(self.offset..)?)
    }
}
