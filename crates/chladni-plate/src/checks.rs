//! Numbers that a panel may hold.

use chladni_frf::{Error, Result};

pub(crate) fn positive(field: &str, value: f64) -> Result<()> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(Error::bad_data("not a usable value")
            .field(field)
            .found(value)
            .expected("a finite number above 0")),
    }
}

pub(crate) fn not_negative(field: &str, value: f64) -> Result<()> {
    match value.is_finite() && value >= 0.0 {
        true => Ok(()),
        false => Err(Error::bad_data("not a usable value")
            .field(field)
            .found(value)
            .expected("a finite number, 0 or above")),
    }
}
