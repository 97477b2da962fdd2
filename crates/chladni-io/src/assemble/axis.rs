//! The frequency axis that all FRFs of a set share.

use super::record::Record;
use crate::limits::{AXES_ROUNDED, SIX_DIGITS};
use chladni_frf::{Error, Finding, Result};
use ndarray::Array1;

/// The axis of the first record; the others must lie within half a line of it.
pub(super) fn common_axis(records: &[Record], warnings: &mut Vec<Finding>) -> Result<Array1<f64>> {
    let Some(first) = records.first() else {
        return Ok(Array1::zeros(0));
    };
    let axis = &first.frequency_hz;
    let rises = axis.windows(2).all(|pair| pair[0] < pair[1])
        && axis.iter().all(|f| f.is_finite() && *f >= 0.0);
    if !rises {
        return Err(Error::bad_data(
            "the frequency axis must be finite, not negative and strictly rising",
        )
        .field(format!("frequency axis of {}", first.place))
        .found(describe_axis(axis))
        .expected("frequencies of 0 or more, each above the one before")
        .help("export the data again, or look at the contents of the file"));
    }
    // a thousandth of a line shifts no pole noticeably
    let farthest = farthest_from(first, records)?;
    if let Some((lines, record)) = farthest.filter(|(lines, _)| *lines > 1e-3) {
        warnings.push(differing(first, record, lines));
    }
    Ok(Array1::from(axis.to_vec()))
}

/// The finding of two axes that differ: a note where printed digits may have done it.
fn differing(first: &Record, record: &Record, lines: f64) -> Finding {
    let pairs = first.frequency_hz.iter().zip(record.frequency_hz.iter());
    let apart = |(a, b): (&f64, &f64)| (a - b).abs();
    let hz = pairs.clone().map(apart).fold(0.0, f64::max);
    let printed = pairs
        .clone()
        .all(|pair| apart(pair) <= SIX_DIGITS * pair.0.abs());
    let words = format!(
        "frequency axes differ by up to {lines:.3} of a line ({} against {}); that of the first \
         is used",
        record.place, first.place
    );
    if printed || lines <= AXES_ROUNDED {
        return Finding::note("axes-differ", words);
    }
    let decimals = (-hz.log10().floor()).max(2.0) as usize;
    let words = format!(
        "{words}; that is more than rounding: frequencies are off by up to {hz:.decimals$} Hz there, and \
         one mode may look like several"
    );
    Finding::caution("axes-differ", words)
        .value("off_hz", hz)
        .help("measure or export all FRFs with one axis, or fit those of each axis by themselves")
}

/// The record whose axis is farthest from that of `first`, and the distance in lines; `None`
/// where all agree.
///
/// # Errors
/// An axis half a line or more from that of `first`.
fn farthest_from<'a>(
    first: &'a Record,
    records: &'a [Record],
) -> Result<Option<(f64, &'a Record)>> {
    let axis = &first.frequency_hz;
    let mut largest: Option<(f64, &Record)> = None;
    let mut last = first;
    for record in records {
        if std::rc::Rc::ptr_eq(&record.frequency_hz, &last.frequency_hz) {
            continue;
        }
        last = record;
        match distance_in_lines(axis, &record.frequency_hz) {
            Some(lines) if lines < 0.5 => {
                if lines > largest.map_or(0.0, |(found, _)| found) {
                    largest = Some((lines, record));
                }
            }
            _ => {
                return Err(
                    Error::bad_data("FRFs of one set must share their frequency axis")
                        .field("frequency axis")
                        .found(format!(
                            "{} in {}",
                            describe_axis(&record.frequency_hz),
                            record.place
                        ))
                        .expected(format!(
                            "within half a line of {} in {}",
                            describe_axis(axis),
                            first.place
                        ))
                        .help(
                            "convert and fit the files separately, or measure them with the same \
                           analyser settings",
                        ),
                )
            }
        }
    }
    Ok(largest)
}

/// Largest distance of two axes, in units of the smaller spacing to a neighbouring line;
/// `None` for different lengths.
fn distance_in_lines(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() != b.len() {
        return None;
    }
    let spacing = |k: usize| {
        let before = if k > 0 {
            a[k] - a[k - 1]
        } else {
            f64::INFINITY
        };
        let after = if k + 1 < a.len() {
            a[k + 1] - a[k]
        } else {
            f64::INFINITY
        };
        before.min(after)
    };
    let distance = |k: usize| match (a[k] - b[k]).abs() {
        0.0 => 0.0,
        // a single line has no spacing: the rounding of six printed digits takes its place
        difference if a.len() == 1 => difference / (SIX_DIGITS * a[0].abs()),
        difference => difference / spacing(k),
    };
    let worst = (0..a.len()).map(distance);
    worst
        .reduce(|x, y| if y > x || y.is_nan() { y } else { x })
        .or(Some(0.0))
}

fn describe_axis(axis: &[f64]) -> String {
    match axis {
        [] => "no lines".into(),
        [one] => format!("one line at {one} Hz"),
        [first, .., last] => format!("{} lines {first}..{last} Hz", axis.len()),
    }
}
