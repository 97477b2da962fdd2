//! Required attributes of a group.

use crate::arrays::tree::Entry;
use chladni_frf::{Error, Result};
use num_complex::Complex64;

/// Names of the ID lines.
pub(super) const ID_LINES: [&str; 5] = [
    "id_line_1",
    "id_line_2",
    "id_line_3",
    "id_line_4",
    "id_line_5",
];

/// The attributes of a group.
pub(super) struct Required<'a> {
    pub(super) group: &'a Entry,
    /// Word for the content of the group, in messages.
    pub(super) holds: &'static str,
}

impl Required<'_> {
    fn required<T>(&self, name: &str, found: Option<T>) -> Result<T> {
        found.ok_or_else(|| {
            Error::bad_data("an attribute is missing")
                .field(self.field(name))
                .found("nothing")
                .expected(format!("every attribute of a {}", self.holds))
        })
    }

    /// The name of an attribute in messages.
    pub(super) fn field(&self, name: &str) -> String {
        format!("{name} of {}", self.group.path)
    }

    pub(super) fn text(&self, name: &str) -> Result<String> {
        self.required(name, self.group.text(name).map(str::to_owned))
    }

    pub(super) fn whole(&self, name: &str) -> Result<i64> {
        self.required(name, self.group.integer(name))
    }

    /// A whole number of 32 bits.
    pub(super) fn small(&self, name: &str) -> Result<i32> {
        let found = self.whole(name)?;
        i32::try_from(found).map_err(|_| {
            Error::bad_data("a number of 32 bits is needed")
                .field(self.field(name))
                .found(found)
                .expected(format!("{} to {}", i32::MIN, i32::MAX))
        })
    }

    pub(super) fn real(&self, name: &str) -> Result<f64> {
        self.required(name, self.group.real(name))
    }

    pub(super) fn complex(&self, name: &str) -> Result<Complex64> {
        let re = self.real(&format!("{name}_re"))?;
        Ok(Complex64::new(re, self.real(&format!("{name}_im"))?))
    }
}

/// The results of `read` for all `names`.
pub(super) fn each<T: Default, const N: usize>(
    names: [&str; N],
    read: impl Fn(&str) -> Result<T>,
) -> Result<[T; N]> {
    let mut all = std::array::from_fn(|_| T::default());
    for (value, name) in all.iter_mut().zip(names) {
        *value = read(name)?;
    }
    Ok(all)
}
