//! Arrays of numbers inside JSON: little-endian bytes as base64 under the name of their
//! type, `{"f32": "AACAPw=="}`.

use crate::text::base64;
use num_complex::Complex64;
use serde_json::{json, Value};

/// Numbers in single precision.
pub(crate) fn f32s(values: impl IntoIterator<Item = f64>) -> Value {
    let bytes: Vec<u8> = values
        .into_iter()
        .flat_map(|value| (value as f32).to_le_bytes())
        .collect();
    json!({ "f32": base64(&bytes) })
}

/// Numbers in double precision: frequencies.
pub(crate) fn f64s<'a>(values: impl IntoIterator<Item = &'a f64>) -> Value {
    let bytes: Vec<u8> = values
        .into_iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    json!({ "f64": base64(&bytes) })
}

/// Complex numbers in single precision, real and imaginary part in turn.
pub(crate) fn complex<'a>(values: impl IntoIterator<Item = &'a Complex64>) -> Value {
    f32s(values.into_iter().flat_map(|value| [value.re, value.im]))
}

/// Whole numbers, 0 or more.
pub(crate) fn u32s(values: impl IntoIterator<Item = usize>) -> Value {
    let bytes: Vec<u8> = values
        .into_iter()
        .flat_map(|value| (value as u32).to_le_bytes())
        .collect();
    json!({ "u32": base64(&bytes) })
}

/// Code of a part that is not known; the page draws nothing there.
const MISSING: i16 = i16::MIN;

/// Complex numbers for drawing (shapes), with a resolution of 1/32767 of the largest part. NaN,
/// as outside the responses, becomes [`MISSING`].
pub(crate) fn drawn(values: &[Complex64]) -> Value {
    let parts = || values.iter().flat_map(|value| [value.re, value.im]);
    let step = parts().map(f64::abs).fold(0.0, f64::max) / f64::from(i16::MAX);
    let small = |part: f64| match part {
        part if part.is_nan() => MISSING,
        part if step > 0.0 => (part / step).round() as i16,
        _ => 0,
    };
    let bytes: Vec<u8> = parts().flat_map(|part| small(part).to_le_bytes()).collect();
    json!({ "i16": base64(&bytes), "step": step })
}

/// Codes of a byte.
pub(crate) fn u8s(values: impl IntoIterator<Item = u8>) -> Value {
    json!({ "u8": base64(&values.into_iter().collect::<Vec<_>>()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_little_endian() {
        assert_eq!(f32s([1.0]), json!({"f32": "AACAPw=="}));
        let drawn = drawn(&[Complex64::new(-65534.0, 2.0)]);
        assert_eq!(drawn, json!({"i16": "AYABAA==", "step": 2.0}));
        assert_eq!(u32s([258]), json!({"u32": "AgEAAA=="}));
    }

    #[test]
    fn what_is_not_known_is_missing_and_no_zero() {
        let gap = Complex64::new(f64::NAN, f64::NAN);
        let bytes = [1, 128, 0, 0, 0, 128, 0, 128];
        let coded = drawn(&[Complex64::new(-32767.0, 0.0), gap]);
        assert_eq!(coded, json!({"i16": base64(&bytes), "step": 1.0}));
        let coded = drawn(&[Complex64::ZERO, gap]);
        assert_eq!(coded["i16"], base64(&[0, 0, 0, 0, 0, 128, 0, 128]));
    }
}
