//! One set of FRFs, written in every format and read again: the same numbers.

use arbitrary::{Arbitrary, Result, Unstructured};
use chladni_frf::{Dof, ErrorKind, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_io::{read_frf, write_frf, ReadOptions};
use ndarray::{Array1, Array3};
use num_complex::{Complex32, Complex64};
use std::path::Path;

/// Formats by their extensions, and the largest relative error of a value: text of
/// universal files has 13 digits in double and 6 in single precision.
const FORMATS: [(&str, f64); 7] = [
    ("h5", 0.0),
    ("npz", 0.0),
    ("mat", 0.0),
    ("csv", 0.0),
    ("uff", 0.0),
    ("unv", 1e-12),
    ("uf", 1e-12),
];
/// In single precision.
const SINGLE_ERROR: f64 = 1e-5;
/// The axis of a universal file has 13 digits as well; an uneven one as text has six, and
/// the writer says so.
const AXIS_ERROR: f64 = 1e-12;
/// See above.
const UNEVEN_TEXT_ERROR: f64 = 5e-6;
/// Exponents that a text field prints with two digits.
const EXPONENTS: std::ops::RangeInclusive<i32> = -90..=90;

/// A set, and the format that it goes through.
#[derive(Debug)]
pub struct Case {
    set: FrfSet,
    format: usize,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let format = u.int_in_range(0..=FORMATS.len() - 1)?;
        let [responses, references, lines] = [
            u.int_in_range(1..=3)?,
            u.int_in_range(1..=2)?,
            u.int_in_range(1..=6)?,
        ];
        let kind = *u.choose(&[FrfKind::Mobility, FrfKind::Receptance, FrfKind::Accelerance])?;
        let reference_unit = *u.choose(&[ReferenceUnit::Newton, ReferenceUnit::Volt])?;
        let single = u.arbitrary()?;
        let even = u.arbitrary()?;
        let axis = axis(u, lines, even)?;
        let mut all = Vec::new();
        for _ in 0..responses * references * lines {
            all.push(Complex64::new(number(u)?, number(u)?));
        }
        let values = Array3::from_shape_vec((responses, references, lines), all).unwrap();
        let coherence = match u.arbitrary()? {
            true => Some(Array3::from_elem(values.dim(), 0.5)),
            false => None,
        };
        let set = FrfSet {
            frequency_hz: axis,
            values: match single {
                true => FrfValues::F32(values.mapv(|v| Complex32::new(v.re as f32, v.im as f32))),
                false => FrfValues::F64(values),
            },
            responses: dofs(u, responses)?,
            references: dofs(u, references)?,
            kind: Some(kind),
            reference_unit,
            coherence,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        };
        Ok(Self { set, format })
    }
}

/// Rising frequencies, Hz, in even steps or not.
fn axis(u: &mut Unstructured<'_>, lines: usize, even: bool) -> Result<Array1<f64>> {
    let step = |u: &mut Unstructured<'_>| Ok(f64::from(u.int_in_range(1..=u16::MAX)?) / 128.0);
    let (mut hz, first) = (f64::from(u.arbitrary::<u16>()?) / 8.0, step(u)?);
    let mut axis = Vec::new();
    for _ in 0..lines {
        axis.push(hz);
        hz += if even { first } else { step(u)? };
    }
    Ok(Array1::from(axis))
}

/// A finite number, never too large for a text field.
fn number(u: &mut Unstructured<'_>) -> Result<f64> {
    let digits: i32 = u.arbitrary()?;
    let exponent = u.int_in_range(EXPONENTS)?;
    Ok(f64::from(digits) / 65536.0 * 10_f64.powi(exponent / 3))
}

/// DOFs that differ.
fn dofs(u: &mut Unstructured<'_>, count: usize) -> Result<Vec<Dof>> {
    let mut dofs: Vec<Dof> = Vec::new();
    for k in 0..count {
        let drawn = u64::from(u.arbitrary::<u16>()?) + 1;
        let is_known = dofs.iter().any(|dof| dof.node == drawn);
        let node = if is_known { 100_000 + k as u64 } else { drawn };
        let direction = *u.choose(&["+X", "-X", "+Y", "-Y", "+Z", "-Z"])?;
        dofs.push(format!("{node}:{direction}").parse().unwrap());
    }
    Ok(dofs)
}

/// Writes the set and reads it again; what a format cannot hold may be refused.
///
/// # Panics
/// Content read that is not what was written.
pub fn through(case: &Case, path: &Path) {
    let (extension, error) = FORMATS[case.format];
    let path = path.with_extension(extension);
    if let Err(error) = write_frf(&path, &case.set, true) {
        assert_ne!(error.kind, ErrorKind::Internal, "{error}");
        return;
    }
    let (read, _, _) =
        read_frf(&[path], &ReadOptions::default()).expect("what was written is read");
    same(&case.set, &read, error);
}

fn same(written: &FrfSet, read: &FrfSet, error: f64) {
    assert_eq!(read.kind, written.kind);
    assert_eq!(read.reference_unit, written.reference_unit);
    assert_eq!(read.values.dim(), written.values.dim());
    // text has the digits of the precision
    let is_single = matches!(written.values, FrfValues::F32(_));
    let error = if is_single && error > 0.0 {
        SINGLE_ERROR
    } else {
        error
    };
    let near =
        |a: f64, b: f64| (a - b).abs() <= error * b.abs() || (is_single && a as f32 == b as f32);
    let axis_error = match error > 0.0 {
        true => UNEVEN_TEXT_ERROR,
        false => AXIS_ERROR,
    };
    for (a, b) in read.frequency_hz.iter().zip(&written.frequency_hz) {
        assert!((a - b).abs() <= axis_error * b.abs(), "{a} Hz for {b}");
    }
    // formats may order DOFs in their own way
    let place = |all: &[Dof], dof: &Dof| {
        all.iter()
            .position(|known| known == dof)
            .unwrap_or_else(|| panic!("{dof} is lost"))
    };
    for (i, response) in written.responses.iter().enumerate() {
        for (j, reference) in written.references.iter().enumerate() {
            let at = (
                place(&read.responses, response),
                place(&read.references, reference),
            );
            let (before, after) = (written.values.frf(i, j), read.values.frf(at.0, at.1));
            // a pair of nothing but zeros was not measured
            if before.iter().all(|b| b.norm_sqr() == 0.0) {
                let zero = |a: &Complex64| !a.is_finite() || a.norm_sqr() == 0.0;
                assert!(after.iter().all(zero), "{after:?} for zeros");
                continue;
            }
            for (a, b) in after.iter().zip(before.iter()) {
                assert!(near(a.re, b.re) && near(a.im, b.im), "{a} for {b}");
            }
        }
    }
}
