//! The array of a set, made of records: one axis, one kind, every pair once.

use super::super::Duplicates;
use super::axis::common_axis;
use super::copies::copies_among;
use super::record::{Line, Record};
use crate::limits::{LANES, NAMES_LISTED, SPARSE_BYTES, SPARSE_FACTOR};
use chladni_frf::{
    Dof, Error, Finding, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit, Result,
};
use ndarray::Array3;
use num_complex::{Complex32, Complex64, ComplexFloat};
use std::collections::HashMap;

/// DOFs in order of appearance.
#[derive(Default)]
pub(super) struct DofList {
    pub(super) dofs: Vec<Dof>,
    index: HashMap<Dof, usize>,
}

impl DofList {
    pub(super) fn index_of(&mut self, dof: Dof) -> usize {
        *self.index.entry(dof).or_insert_with(|| {
            self.dofs.push(dof);
            self.dofs.len() - 1
        })
    }
}

/// Builds the set.
///
/// * `responses`, `references`: every DOF that a source names, measured or not
/// * `originals`: for each document the number of the first one of the same content; for messages
pub(super) fn build(
    records: Vec<Record>,
    mut responses: DofList,
    mut references: DofList,
    duplicates: Duplicates,
    originals: &[usize],
    warnings: &mut Vec<Finding>,
) -> Result<FrfSet> {
    let axis = common_axis(&records, warnings)?;
    let kind = common_kind(&records)?;
    let reference_unit = common_reference_unit(&records)?;
    let single = records.iter().all(|record| record.line.is_single());
    let has_coherence = records.iter().any(|record| record.coherence.is_some());
    let has_variance = records.iter().any(|record| record.variance.is_some());
    let estimations = records.iter().map(|record| record.estimation);
    let estimation = estimations.reduce(|a, b| a?.joined(b?)).flatten();

    let mut pairs: HashMap<(usize, usize), Vec<Record>> = HashMap::new();
    let measured = records.len();
    for record in records {
        let at = (
            responses.index_of(record.response),
            references.index_of(record.reference),
        );
        pairs.entry(at).or_default().push(record);
    }
    let dim = (responses.dofs.len(), references.dofs.len(), axis.len());
    check_grid(dim, measured)?;
    let values = match single {
        true => FrfValues::F32(Array3::from_elem(dim, Complex32::new(f32::NAN, f32::NAN))),
        false => FrfValues::F64(Array3::from_elem(dim, Complex64::new(f64::NAN, f64::NAN))),
    };
    let mut set = FrfSet {
        frequency_hz: axis,
        values,
        responses: responses.dofs,
        references: references.dofs,
        kind,
        reference_unit,
        coherence: has_coherence.then(|| Array3::from_elem(dim, f32::NAN)),
        variance: has_variance.then(|| Array3::from_elem(dim, f64::NAN)),
        estimation,
        geometry: Geometry::default(),
    };
    fill(&mut set, pairs, duplicates, originals, warnings)?;
    set.checked()
}

/// Stores the records of every pair, in the order of the pairs.
fn fill(
    set: &mut FrfSet,
    pairs: HashMap<(usize, usize), Vec<Record>>,
    duplicates: Duplicates,
    originals: &[usize],
    warnings: &mut Vec<Finding>,
) -> Result<()> {
    let mut at: Vec<_> = pairs.into_iter().collect();
    at.sort_by_key(|(pair, _)| *pair);
    let mut doubled = Vec::new();
    for (pair, mut records) in at {
        if records.iter().any(|record| !record.line.is_zero()) {
            // all zeros mark an invalid point: one that was measured again is no duplicate
            records.retain(|record| !record.line.is_zero());
        }
        if records.len() > 1 {
            let name = pair_name(set, pair);
            if duplicates == Duplicates::Error {
                return Err(doubled_pair(&name, &records, originals));
            }
            doubled.push(name);
        }
        let record = match duplicates {
            Duplicates::Mean if records.len() > 1 => mean(records),
            Duplicates::Last => records.pop(),
            _ => records.into_iter().next(),
        };
        if let Some(record) = record {
            store(set, pair, record);
        }
    }
    if !doubled.is_empty() {
        warnings.push(doubled_pairs(doubled, duplicates));
    }
    Ok(())
}

/// The error of a pair that several records hold.
fn doubled_pair(name: &str, records: &[Record], originals: &[usize]) -> Error {
    let count = records.len();
    let copies = copies_among(records, originals);
    let [one, other] = copies.unwrap_or([0, 1]).map(|place| &records[place].place);
    let files = match count {
        2 => "the two files",
        _ => "two of the files",
    };
    let (why, help) = match copies {
        Some(_) => (
            format!(", and {files} are copies of each other"),
            "give only one of these two files, or choose with `duplicates first|last`",
        ),
        None => (
            String::new(),
            "choose with `duplicates first|last|mean`; files that all say reference node 1 need \
             `reference N`",
        ),
    };
    Error::bad_data(format!("the pair {name} is there {count} times{why}"))
        .field("response and reference")
        .found(format!("{one} and {other}"))
        .expected("each pair once")
        .help(help)
}

fn doubled_pairs(names: Vec<String>, duplicates: Duplicates) -> Finding {
    let rule = match duplicates {
        Duplicates::First => "the first is kept",
        Duplicates::Last => "the last is kept",
        Duplicates::Mean => "their mean is taken",
        Duplicates::Error => "",
    };
    let count = names.len();
    let words = format!(
        "{count} pairs are there more than once, {rule}: {}",
        listed(names.into_iter())
    );
    Finding::note("pairs-doubled", words)
}

fn common_kind(records: &[Record]) -> Result<Option<FrfKind>> {
    let Some(first) = records.first() else {
        return Ok(None);
    };
    let name = |kind: Option<FrfKind>| kind.map_or("not said", FrfKind::as_str);
    match records.iter().find(|record| record.kind != first.kind) {
        None => Ok(first.kind),
        Some(other) => Err(
            Error::bad_data("FRFs of different kinds do not make one set")
                .field("FRF kind")
                .found(format!("{} in {}", name(other.kind), other.place))
                .expected(format!("{} as in {}", name(first.kind), first.place))
                .help("convert them separately, or say one kind for all with `frf_kind`"),
        ),
    }
}

fn common_reference_unit(records: &[Record]) -> Result<ReferenceUnit> {
    let Some(first) = records.first() else {
        return Ok(ReferenceUnit::default());
    };
    match records
        .iter()
        .find(|record| record.reference_unit != first.reference_unit)
    {
        None => Ok(first.reference_unit),
        Some(other) => Err(
            Error::bad_data("references in different units do not make one set")
                .field("reference unit")
                .found(format!("{} in {}", other.reference_unit, other.place))
                .expected(format!("{} as in {}", first.reference_unit, first.place))
                .help("convert the files separately"),
        ),
    }
}

fn check_grid(dim: (usize, usize, usize), measured: usize) -> Result<()> {
    let bytes = |pairs: usize| {
        pairs
            .saturating_mul(dim.2)
            .saturating_mul(size_of::<Complex64>())
    };
    let grid = dim.0.saturating_mul(dim.1);
    if bytes(grid) > SPARSE_BYTES && grid / SPARSE_FACTOR > measured {
        return Err(
            Error::bad_data("almost all (response, reference) pairs are missing")
                .found(format!(
                    "{measured} FRFs for {} responses and {} references",
                    dim.0, dim.1
                ))
                .expected("FRFs of most pairs")
                .help("convert the files in groups of common references"),
        );
    }
    Ok(())
}

/// Mean of several records of one pair, without masked lines.
fn mean(records: Vec<Record>) -> Option<Record> {
    let lines = records.first()?.line.len();
    let average = |k: usize| {
        let finite: Vec<Complex64> = records
            .iter()
            .map(|record| record.line.get(k))
            .filter(|value| !value.re.is_nan())
            .collect();
        finite.iter().sum::<Complex64>() / finite.len() as f64
    };
    let values: Vec<Complex64> = (0..lines).map(average).collect();
    let single = records.iter().all(|record| record.line.is_single());
    let line = if single {
        Line::Single(
            values
                .iter()
                .map(|value| Complex32::new(value.re as f32, value.im as f32))
                .collect(),
        )
    } else {
        Line::Double(values)
    };
    let coherences: Vec<&Vec<f32>> = records
        .iter()
        .filter_map(|record| record.coherence.as_ref())
        .collect();
    let coherence = (!coherences.is_empty()).then(|| {
        let average = |k: usize| {
            coherences.iter().map(|values| values[k]).sum::<f32>() / coherences.len() as f32
        };
        (0..lines).map(average).collect()
    });
    // the variance of a mean of independent measurements, where all variances are known
    let variances: Option<Vec<&Vec<f64>>> = records
        .iter()
        .map(|record| record.variance.as_ref())
        .collect();
    let variance = variances.map(|variances| {
        let of_mean = |k: usize| {
            variances.iter().map(|values| values[k]).sum::<f64>() / (variances.len() as f64).powi(2)
        };
        (0..lines).map(of_mean).collect()
    });
    let first = records.into_iter().next()?;
    Some(Record {
        line,
        coherence,
        variance,
        ..first
    })
}

fn store(set: &mut FrfSet, (i, j): (usize, usize), record: Record) {
    let count = record.line.len();
    match &mut set.values {
        FrfValues::F64(values) => (0..count).for_each(|k| values[[i, j, k]] = record.line.get(k)),
        FrfValues::F32(values) => {
            if let Line::Single(line) = &record.line {
                (0..count).for_each(|k| values[[i, j, k]] = line[k]);
            }
        }
    }
    if let (Some(target), Some(coherence)) = (&mut set.coherence, record.coherence) {
        coherence
            .iter()
            .take(count)
            .enumerate()
            .for_each(|(k, &value)| target[[i, j, k]] = value);
    }
    if let (Some(target), Some(variance)) = (&mut set.variance, record.variance) {
        variance
            .iter()
            .take(count)
            .enumerate()
            .for_each(|(k, &value)| target[[i, j, k]] = value);
    }
}

/// True where no value is infinite or NaN. A sum of 0 times each value is NaN else, and is
/// many times faster than a test of each value.
fn all_finite<C: ComplexFloat>(values: &[C]) -> bool {
    let mut sums = [C::zero(); LANES];
    let (chunks, rest) = values.as_chunks::<LANES>();
    for chunk in chunks {
        sums.iter_mut()
            .zip(chunk)
            .for_each(|(sum, &value)| *sum = *sum + value.conj() * C::zero());
    }
    sums.iter().chain(rest).all(|value| value.is_finite())
}

/// Cleans a set as it was read: pairs of zeros become missing, values that are not finite
/// become NaN, and both are reported.
pub(super) fn clean(set: &mut FrfSet, file: &str, warnings: &mut Vec<Finding>) {
    fn clean_array<C: ComplexFloat>(
        values: &mut Array3<C>,
        zero_value: C,
        nan: C,
    ) -> (usize, Vec<(usize, usize)>) {
        let (mut masked, mut zero) = (0, Vec::new());
        for (i, mut rows) in values.outer_iter_mut().enumerate() {
            for (j, mut line) in rows.outer_iter_mut().enumerate() {
                if !line.as_slice().is_some_and(all_finite) {
                    for value in line.iter_mut().filter(|value| !value.is_finite()) {
                        masked += usize::from(value.re() == value.re() || value.im() == value.im());
                        *value = nan;
                    }
                }
                if !line.is_empty() && line.iter().all(|&value| value == zero_value) {
                    line.fill(nan);
                    zero.push((i, j));
                }
            }
        }
        (masked, zero)
    }
    let (masked, zero) = match &mut set.values {
        FrfValues::F64(values) => {
            clean_array(values, Complex64::ZERO, Complex64::new(f64::NAN, f64::NAN))
        }
        FrfValues::F32(values) => {
            clean_array(values, Complex32::ZERO, Complex32::new(f32::NAN, f32::NAN))
        }
    };
    if masked > 0 {
        let place = if file.is_empty() {
            String::new()
        } else {
            format!("{file}: ")
        };
        warnings.push(Finding::caution(
            "lines-masked",
            format!("{place}{masked} values are not finite; these lines are masked"),
        ));
    }
    report_missing(set, zero, warnings);
}

fn report_missing(set: &FrfSet, mut zero: Vec<(usize, usize)>, warnings: &mut Vec<Finding>) {
    let missing = set.missing_pairs();
    zero.retain(|pair| missing.binary_search(pair).is_ok());
    zero.sort_unstable();
    zero.dedup();
    if !zero.is_empty() {
        let names = listed(zero.iter().map(|&pair| pair_name(set, pair)));
        warnings.push(Finding::caution(
            "pairs-zero",
            format!(
                "{} pairs are exactly zero on every line and are treated as missing: {names}",
                zero.len()
            ),
        ));
    }
    let absent: Vec<_> = missing
        .into_iter()
        .filter(|pair| zero.binary_search(pair).is_err())
        .collect();
    if !absent.is_empty() {
        let names = listed(absent.iter().map(|&pair| pair_name(set, pair)));
        warnings.push(Finding::note(
            "pairs-missing",
            format!(
                "{} of {} pairs are missing (response, reference): {names}",
                absent.len(),
                set.pairs()
            ),
        ));
    }
}

fn pair_name(set: &FrfSet, (i, j): (usize, usize)) -> String {
    format!("({}, {})", set.responses[i], set.references[j])
}

fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let count = names.len();
    let mut list: Vec<String> = names.take(NAMES_LISTED).collect();
    if count > NAMES_LISTED {
        list.push(format!("and {} more", count - NAMES_LISTED));
    }
    list.join(", ")
}
