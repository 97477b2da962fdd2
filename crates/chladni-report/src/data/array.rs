//! Arrays of numbers inside JSON: little-endian bytes as base64 under the name of their
//! type, `{"f32": "AACAPw=="}`.

use crate::text::base64;
use num_complex::Complex64;
use serde_json::{json, Value};

/// Numbers to seven digits.
pub(crate) fn f32s(values: impl IntoIterator<Item = f64>) -> Value {
    let bytes: Vec<u8> = values
        .into_iter()
        .flat_map(|value| (value as f32).to_le_bytes())
        .collect();
    json!({ "f32": base64(&bytes) })
}

/// Numbers as they are: frequencies.
pub(crate) fn f64s<'a>(values: impl IntoIterator<Item = &'a f64>) -> Value {
    let bytes: Vec<u8> = values
        .into_iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    json!({ "f64": base64(&bytes) })
}

/// Complex numbers, real and imaginary part in turn.
pub(crate) fn complex<'a>(values: impl IntoIterator<Item = &'a Complex64>) -> Value {
    f32s(values.into_iter().flat_map(|value| [value.re, value.im]))
}

/// Whole numbers from 0.
pub(crate) fn u32s(values: impl IntoIterator<Item = usize>) -> Value {
    let bytes: Vec<u8> = values
        .into_iter()
        .flat_map(|value| (value as u32).to_le_bytes())
        .collect();
    json!({ "u32": base64(&bytes) })
}

/// Small signed numbers.
pub(crate) fn i8s(values: &[i8]) -> Value {
    json!({ "i8": base64(&values.iter().map(|value| value.to_le_bytes()[0]).collect::<Vec<_>>()) })
}

/// Small codes.
pub(crate) fn u8s(values: impl IntoIterator<Item = u8>) -> Value {
    json!({ "u8": base64(&values.into_iter().collect::<Vec<_>>()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_little_endian() {
        assert_eq!(f32s([1.0]), json!({"f32": "AACAPw=="}));
        assert_eq!(i8s(&[-1, 2]), json!({"i8": "/wI="}));
        assert_eq!(u32s([258]), json!({"u32": "AgEAAA=="}));
    }
}
