//! From values and shapes of a file to the arrays of an [`chladni_frf::FrfSet`].

use super::tree::{Entry, Values};
use chladni_frf::{Dof, Error, FrfSet, FrfValues, Result};
use ndarray::{Array3, ArrayD, Axis, IxDyn};
use num_complex::Complex;
use std::borrow::Cow;

/// A complex array of any rank, in the precision of the file.
#[derive(Debug, Clone)]
pub(crate) enum ComplexArray {
    Double(ArrayD<Complex<f64>>),
    Single(ArrayD<Complex<f32>>),
}

impl ComplexArray {
    /// `values` in the shape that `entry` declares.
    pub(crate) fn new(entry: &Entry, values: Values<'static>) -> Result<Self> {
        let shape = entry.shape();
        match values {
            Values::Complex64(values) => Ok(Self::Double(shaped(entry, shape, values)?)),
            Values::Complex32(values) => Ok(Self::Single(shaped(entry, shape, values)?)),
            _ => Err(wrong_type(
                entry,
                "complex numbers, a compound {r, i} or {real, imag}",
            )),
        }
    }

    /// Extents of its axes.
    pub(crate) fn shape(&self) -> &[usize] {
        match self {
            Self::Double(array) => array.shape(),
            Self::Single(array) => array.shape(),
        }
    }

    /// The values in double precision.
    pub(crate) fn widened(self) -> Self {
        match self {
            Self::Single(array) => {
                Self::Double(array.mapv(|value| Complex::new(value.re.into(), value.im.into())))
            }
            double => double,
        }
    }

    /// The array with its axes in reverse order: MATLAB stores (a, b, c) as (c, b, a).
    pub(crate) fn reversed_axes(self) -> Self {
        match self {
            Self::Double(array) => Self::Double(array.reversed_axes()),
            Self::Single(array) => Self::Single(array.reversed_axes()),
        }
    }

    /// The values as (response, reference, line), of which the arguments give the axes; an
    /// axis `None` gets length 1.
    pub(crate) fn into_frf_values(
        self,
        response: Option<usize>,
        reference: Option<usize>,
        line: usize,
    ) -> FrfValues {
        match self {
            Self::Double(array) => FrfValues::F64(three_axes(array, response, reference, line)),
            Self::Single(array) => FrfValues::F32(three_axes(array, response, reference, line)),
        }
    }
}

fn three_axes<T: Clone>(
    mut array: ArrayD<T>,
    response: Option<usize>,
    reference: Option<usize>,
    line: usize,
) -> Array3<T> {
    let mut order = [0, 0, line];
    for (slot, axis) in order.iter_mut().zip([response, reference]) {
        *slot = axis.unwrap_or_else(|| {
            let last = Axis(array.ndim());
            array.insert_axis_inplace(last);
            last.0
        });
    }
    let ordered = array
        .view()
        .permuted_axes(IxDyn(&order))
        .as_standard_layout()
        .into_owned();
    ordered
        .into_dimensionality()
        .expect("three axes were named")
}

/// Real numbers (integers are widened) in the shape that `entry` declares.
pub(crate) fn real_array(entry: &Entry, values: Values<'static>) -> Result<ArrayD<f64>> {
    shaped(entry, entry.shape(), reals(entry, values)?.into())
}

/// Real numbers as a flat list.
pub(crate) fn reals(entry: &Entry, values: Values<'static>) -> Result<Vec<f64>> {
    match values {
        Values::Real64(values) => Ok(values.into_owned()),
        Values::Real32(values) => Ok(values.iter().map(|&value| value.into()).collect()),
        Values::Unsigned(values) => Ok(values.iter().map(|&value| value as f64).collect()),
        Values::Signed(values) => Ok(values.iter().map(|&value| value as f64).collect()),
        // some programs keep all arrays complex
        Values::Complex64(values) if values.iter().all(|value| value.im == 0.0) => {
            Ok(values.iter().map(|value| value.re).collect())
        }
        Values::Complex32(values) if values.iter().all(|value| value.im == 0.0) => {
            Ok(values.iter().map(|value| value.re.into()).collect())
        }
        _ => Err(wrong_type(entry, "real numbers")),
    }
}

/// Integers as a flat list.
pub(crate) fn integers(entry: &Entry, values: Values<'static>) -> Result<Vec<u64>> {
    match values {
        Values::Unsigned(values) => Ok(values.into_owned()),
        _ => Err(wrong_type(entry, "whole numbers, not negative")),
    }
}

/// Texts as a flat list.
pub(crate) fn texts(entry: &Entry, values: Values<'static>) -> Result<Vec<String>> {
    match values {
        Values::Text(texts) => Ok(texts),
        _ => Err(wrong_type(entry, "text")),
    }
}

/// DOF records as a flat list.
pub(crate) fn dofs(entry: &Entry, values: Values<'static>) -> Result<Vec<Dof>> {
    match values {
        Values::Dofs(dofs) => Ok(dofs),
        _ => Err(wrong_type(
            entry,
            "records {node u64, dir i8}, dir a code from -6 to 6",
        )),
    }
}

/// The set that was made of the array at `path`, checked.
///
/// # Errors
/// No response, reference or line; those of [`FrfSet::checked`]. Each says what to do.
pub(crate) fn checked(set: FrfSet, path: &str) -> Result<FrfSet> {
    let (responses, references, lines) = set.values.dim();
    let counts = [
        (responses, "responses"),
        (references, "references"),
        (lines, "lines"),
    ];
    if let Some((_, noun)) = counts.into_iter().find(|(count, _)| *count == 0) {
        return Err(Error::bad_data("an array of FRFs without values")
            .field(path)
            .found(format!("0 {noun}"))
            .expected("one response, reference and line, or more")
            .help("save the array again, with its values"));
    }
    set.checked().map_err(|error| match error.help {
        Some(_) => error,
        None => error.help("correct it in the program that wrote the file"),
    })
}

/// The error of a dataset of another element type than expected.
pub(crate) fn wrong_type(entry: &Entry, expected: &str) -> Error {
    let found = entry
        .element()
        .map_or_else(|| "a group".to_owned(), super::tree::Element::describe);
    Error::bad_data("values of the wrong type")
        .field(&entry.path)
        .found(found)
        .expected(expected)
}

fn shaped<T: Clone>(
    entry: &Entry,
    shape: &[usize],
    values: Cow<'static, [T]>,
) -> Result<ArrayD<T>> {
    let count = values.len();
    ArrayD::from_shape_vec(IxDyn(shape), values.into_owned()).map_err(|_| {
        Error::bad_data("the count of values does not fit the shape")
            .field(&entry.path)
            .found(count)
            .expected(format!("shape {shape:?}"))
    })
}
