//! One measured FRF with its DOFs, axis and origin, before it joins the set.

use super::super::{Document, Function, Ordinate};
use crate::limits::SIX_DIGITS;
use chladni_frf::{
    Dof, Error, Estimation, Finding, FrfKind, FrfSet, FrfValues, ReferenceUnit, Result,
};
use ndarray::s;
use num_complex::{Complex32, Complex64};
use std::rc::Rc;

/// Values of one FRF in SI units, with the time sign e^{+jωt}, in the precision of the file.
#[derive(Debug, Clone)]
pub(super) enum Line {
    Single(Vec<Complex32>),
    Double(Vec<Complex64>),
}

impl Line {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Single(values) => values.len(),
            Self::Double(values) => values.len(),
        }
    }
    pub(super) fn get(&self, k: usize) -> Complex64 {
        match self {
            Self::Single(values) => Complex64::new(values[k].re.into(), values[k].im.into()),
            Self::Double(values) => values[k],
        }
    }
    pub(super) fn is_single(&self) -> bool {
        matches!(self, Self::Single(_))
    }
    pub(super) fn is_zero(&self) -> bool {
        (0..self.len()).all(|k| self.get(k) == Complex64::new(0.0, 0.0))
    }
    fn all_nan(&self) -> bool {
        (0..self.len()).all(|k| self.get(k).re.is_nan())
    }

    fn lengthen(&mut self, lines: usize) {
        match self {
            Self::Single(values) => values.resize(lines, Complex32::new(f32::NAN, f32::NAN)),
            Self::Double(values) => values.resize(lines, Complex64::new(f64::NAN, f64::NAN)),
        }
    }

    /// Masks values with a part that is not finite: both parts become NaN. Returns their
    /// number, without those of two NaN.
    fn mask(&mut self) -> usize {
        let mut masked = 0;
        let mut check = |re_finite: bool, im_finite: bool, both_nan: bool| {
            let bad = !(re_finite && im_finite);
            masked += usize::from(bad && !both_nan);
            bad
        };
        match self {
            Self::Single(values) => {
                for value in values.iter_mut() {
                    if check(
                        value.re.is_finite(),
                        value.im.is_finite(),
                        value.re.is_nan() && value.im.is_nan(),
                    ) {
                        *value = Complex32::new(f32::NAN, f32::NAN);
                    }
                }
            }
            Self::Double(values) => {
                for value in values.iter_mut() {
                    if check(
                        value.re.is_finite(),
                        value.im.is_finite(),
                        value.re.is_nan() && value.im.is_nan(),
                    ) {
                        *value = Complex64::new(f64::NAN, f64::NAN);
                    }
                }
            }
        }
        masked
    }
}

/// One FRF with its DOFs, axis and origin.
#[derive(Debug, Clone)]
pub(super) struct Record {
    pub(super) response: Dof,
    pub(super) reference: Dof,
    pub(super) frequency_hz: Rc<[f64]>,
    pub(super) line: Line,
    pub(super) coherence: Option<Vec<f32>>,
    pub(super) variance: Option<Vec<f64>>,
    pub(super) estimation: Option<Estimation>,
    pub(super) kind: Option<FrfKind>,
    pub(super) reference_unit: ReferenceUnit,
    /// Index of its document.
    pub(super) document: usize,
    /// File, and line where there is one: for messages.
    pub(super) place: String,
}

/// File and line of a function, for messages.
pub(super) fn place_of(document: &Document, line: u64) -> String {
    let file = document.file.display();
    if line > 0 {
        format!("{file} line {line}")
    } else {
        file.to_string()
    }
}

/// Frequency axis of a function in Hz; functions on the axis of the one before share its
/// memory.
pub(super) fn axis_of(function: &Function, last: &mut Option<Rc<[f64]>>) -> Rc<[f64]> {
    let values = function.abscissa.values(function.ordinate.len());
    let values: Vec<f64> = values
        .into_iter()
        .map(|f| f * function.abscissa_to_si)
        .collect();
    match last {
        Some(shared) if **shared == *values => shared.clone(),
        _ => last.insert(values.into()).clone(),
    }
}

/// The FRF of a dataset 58: values in SI, conjugated where `conjugate`. Masked values are
/// reported.
pub(super) fn from_function(
    function: Function,
    axis: Rc<[f64]>,
    document: usize,
    place: String,
    conjugate: bool,
    warnings: &mut Vec<Finding>,
) -> Result<Record> {
    if !function.scale_to_si.is_finite() || function.scale_to_si == 0.0 {
        return Err(Error::bad_data("the unit gives no usable scale")
            .field(place)
            .found(function.scale_to_si)
            .expected("a finite factor, not 0"));
    }
    if matches!(function.ordinate, Ordinate::Real32(_) | Ordinate::Real64(_)) {
        warnings.push(Finding::caution(
            "real-frf",
            format!("{place}: an FRF of real values; the imaginary parts are taken as zero"),
        ));
    }
    let mut line = line_of(function.ordinate, function.scale_to_si, conjugate);
    let masked = line.mask();
    if masked > 0 {
        warnings.push(Finding::caution(
            "lines-masked",
            format!("{place}: {masked} values are not finite; these lines are masked"),
        ));
    }
    Ok(Record {
        response: function.response,
        reference: function.reference,
        frequency_hz: axis,
        line,
        coherence: None,
        variance: None,
        estimation: estimated(&function.id_lines[4]),
        kind: function.kind,
        reference_unit: function.reference_unit,
        document,
        place,
    })
}

/// The values times `scale`, conjugated where `conjugate`.
fn line_of(ordinate: Ordinate, scale: f64, conjugate: bool) -> Line {
    let sign = if conjugate { -1.0 } else { 1.0 };
    let double = |re: f64, im: f64| Complex64::new(re * scale, im * scale * sign);
    let single = |re: f32, im: f32| {
        let value = double(re.into(), im.into());
        Complex32::new(value.re as f32, value.im as f32)
    };
    match ordinate {
        Ordinate::Real32(values) => {
            Line::Single(values.into_iter().map(|re| single(re, 0.0)).collect())
        }
        Ordinate::Real64(values) => {
            Line::Double(values.into_iter().map(|re| double(re, 0.0)).collect())
        }
        Ordinate::Complex32(values) => {
            Line::Single(values.into_iter().map(|v| single(v.re, v.im)).collect())
        }
        Ordinate::Complex64(values) => {
            Line::Double(values.into_iter().map(|v| double(v.re, v.im)).collect())
        }
    }
}

/// Characters of an ID line: one that fills it may have lost its end.
const ID_LINE: usize = 80;

/// The estimation of an FRF, which `estimate` writes into ID line 5.
fn estimated(line: &str) -> Option<Estimation> {
    let whole = line.trim_end();
    let parsed = whole.parse().ok();
    parsed.filter(|_| whole.chars().count() < ID_LINE)
}

/// The measured pairs of a set, one record each.
pub(super) fn from_set(
    set: &FrfSet,
    document: usize,
    place: &str,
    warnings: &mut Vec<Finding>,
) -> Vec<Record> {
    let axis: Rc<[f64]> = set.frequency_hz.to_vec().into();
    let mut records = Vec::with_capacity(set.pairs());
    let mut masked = 0;
    for (i, &response) in set.responses.iter().enumerate() {
        for (j, &reference) in set.references.iter().enumerate() {
            let mut line = match &set.values {
                FrfValues::F64(values) => Line::Double(values.slice(s![i, j, ..]).to_vec()),
                FrfValues::F32(values) => Line::Single(values.slice(s![i, j, ..]).to_vec()),
            };
            masked += line.mask();
            if line.all_nan() {
                continue;
            }
            records.push(Record {
                response,
                reference,
                frequency_hz: axis.clone(),
                line,
                coherence: set
                    .coherence
                    .as_ref()
                    .map(|coherence| coherence.slice(s![i, j, ..]).to_vec()),
                variance: set
                    .variance
                    .as_ref()
                    .map(|variance| variance.slice(s![i, j, ..]).to_vec()),
                estimation: set.estimation,
                kind: set.kind,
                reference_unit: set.reference_unit,
                document,
                place: place.to_owned(),
            });
        }
    }
    if masked > 0 {
        warnings.push(Finding::caution(
            "lines-masked",
            format!("{place}: {masked} values are not finite; these lines are masked"),
        ));
    }
    records
}

/// Lengthens FRFs that were cut short to the axis of the longest one, where their own axis is
/// its beginning. The missing lines are masked.
pub(super) fn lengthen(records: &mut [Record], warnings: &mut Vec<Finding>) {
    let Some(axis) = records
        .iter()
        .map(|record| &record.frequency_hz)
        .max_by_key(|axis| axis.len())
        .cloned()
    else {
        return;
    };
    for record in records {
        let own = record.frequency_hz.len();
        let spacing = |k: usize| axis[k + 1] - axis[k];
        let is_beginning = own < axis.len()
            && (record.frequency_hz.iter().zip(&*axis).enumerate())
                .all(|(k, (a, b))| (a - b).abs() < 0.5 * spacing(k));
        if !is_beginning {
            continue;
        }
        warnings.push(Finding::caution(
            "values-missing",
            format!(
                "{}: ends after {own} of {} lines; the others are masked",
                record.place,
                axis.len()
            ),
        ));
        record.frequency_hz = axis.clone();
        record.line.lengthen(axis.len());
        if let Some(coherence) = &mut record.coherence {
            coherence.resize(axis.len(), f32::NAN);
        }
        if let Some(variance) = &mut record.variance {
            variance.resize(axis.len(), f64::NAN);
        }
    }
}

/// Coherence γ² in single precision, and the number of values outside 0..=1, which become
/// NaN. Rounding of six digits is clamped.
pub(crate) fn clean_coherence(values: impl IntoIterator<Item = f64>) -> (Vec<f32>, usize) {
    let mut outside = 0;
    let cleaned = values
        .into_iter()
        .map(|value| {
            if (-SIX_DIGITS..=1.0 + SIX_DIGITS).contains(&value) {
                return value.clamp(0.0, 1.0) as f32;
            }
            outside += usize::from(!value.is_nan());
            f32::NAN
        })
        .collect();
    (cleaned, outside)
}
