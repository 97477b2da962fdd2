//! How the time of a fit grows with FRFs, lines, modes and threads: exponents fitted over
//! doublings of one of them.

use crate::countdown::Countdown;
use crate::csv;
use crate::journal::Journal;
use crate::large::{large, Size};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_rfp::{fit, FitOptions, Method};
use std::time::Instant;

/// The set that one thing is varied of.
const BASE: Size = Size {
    responses: 400,
    references: 5,
    lines: 1001,
    modes: 10,
    single: false,
};
/// The same for a quick run.
const QUICK_BASE: Size = Size {
    responses: 100,
    references: 5,
    lines: 501,
    modes: 10,
    single: false,
};
/// Fits of each set; the least time counts, for a machine that others use as well only
/// makes times longer.
const REPEATS: usize = 3;
/// The same for a quick run.
const QUICK_REPEATS: usize = 2;

/// One time.
#[derive(Debug, Clone)]
pub struct ScalingRow {
    /// What is varied: FRFs, lines, modes, threads.
    pub axis: &'static str,
    /// Its value.
    pub value: usize,
    /// Method.
    pub method: Method,
    /// Least time of a fit, s.
    pub time_s: f64,
    /// Slope of log time over log value along the axis, by least squares.
    pub exponent: f64,
}

/// Times each method along each axis.
///
/// # Errors
/// None for these sets, but those of the journal.
pub fn scaling(
    methods: &[Method],
    quick: bool,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<ScalingRow>> {
    let (base, repeats) = if quick {
        (QUICK_BASE, QUICK_REPEATS)
    } else {
        (BASE, REPEATS)
    };
    let doublings = |first: usize, count: usize| {
        (0..if quick { count.min(3) } else { count })
            .map(|k| first << k)
            .collect::<Vec<_>>()
    };
    let first = if quick { 250 } else { 500 };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads: Vec<usize> = std::iter::successors(Some(1), |count| Some(2 * count))
        .take_while(|count| *count <= cores)
        .collect();
    let axes: [(&'static str, Vec<usize>); 4] = [
        ("FRFs", doublings(first, 5)),
        ("lines", doublings(first, 4)),
        ("modes", doublings(5, 4)),
        ("threads", threads),
    ];
    let pieces = axes
        .iter()
        .map(|(_, values)| values.len() * methods.len())
        .sum();
    let mut countdown = Countdown::new(pieces, progress);
    let mut rows = Vec::new();
    for (axis, values) in axes {
        for &method in methods {
            let mut times = Vec::new();
            for &value in &values {
                let name = format!("{method}: {value} {axis}");
                countdown.next(&name, journal.has(&name));
                times.push((
                    value,
                    journal.once(&name, || least_time(axis, value, method, base, repeats))?,
                ));
            }
            let exponent = slope(&times);
            rows.extend(times.into_iter().map(|(value, time_s)| ScalingRow {
                axis,
                value,
                method,
                time_s,
                exponent,
            }));
        }
    }
    Ok(rows)
}

fn least_time(axis: &str, value: usize, method: Method, base: Size, repeats: usize) -> Result<f64> {
    let size = match axis {
        "FRFs" => Size {
            responses: value / base.references,
            ..base
        },
        "lines" => Size {
            lines: value + 1,
            ..base
        },
        "modes" => Size {
            modes: value,
            ..base
        },
        _ => base,
    };
    let threads = if axis == "threads" {
        value
    } else {
        rayon::current_num_threads()
    };
    let frf = large(size)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))?;
    let options = FitOptions {
        method,
        modes: (method == Method::Lean).then_some(size.modes),
        ..FitOptions::default()
    };
    let mut least = f64::INFINITY;
    for _ in 0..repeats {
        let start = Instant::now();
        let fitted = pool.install(|| fit(&frf, &options));
        drop(fitted.map_err(|error| {
            Error::new(
                ErrorKind::Internal,
                format!("{method} fails on {value} {axis}: {error}"),
            )
        })?);
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// Least-squares slope of log time over log value; NaN for fewer than two values.
fn slope(times: &[(usize, f64)]) -> f64 {
    let points: Vec<[f64; 2]> = times
        .iter()
        .map(|(value, time_s)| [(*value as f64).ln(), time_s.ln()])
        .collect();
    let mean = [0, 1]
        .map(|which| points.iter().map(|point| point[which]).sum::<f64>() / points.len() as f64);
    let moment = |which: usize| {
        points
            .iter()
            .map(|point| (point[0] - mean[0]) * (point[which] - mean[which]))
            .sum::<f64>()
    };
    moment(1) / moment(0)
}

/// The rows as CSV.
pub fn scaling_csv(rows: &[ScalingRow]) -> String {
    let cells = rows.iter().map(|row| {
        let names = [
            row.axis.to_owned(),
            row.value.to_string(),
            row.method.to_string(),
        ];
        names
            .into_iter()
            .chain([row.time_s, row.exponent].map(csv::number))
            .collect()
    });
    let comment = format!(
        "least of {REPEATS} fits; varied from {} FRFs, {} lines, {} modes",
        BASE.responses * BASE.references,
        BASE.lines,
        BASE.modes
    );
    csv::table(
        &comment,
        &["axis", "value", "method", "time_s", "exponent"],
        cells,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power_is_that_power() {
        let times: Vec<(usize, f64)> = [1, 2, 4, 8]
            .map(|n: usize| (n, 0.3 * (n as f64).powf(1.7)))
            .to_vec();
        assert!((slope(&times) - 1.7).abs() < 1e-12);
        assert!(slope(&times[..1]).is_nan());
    }

    #[test]
    fn sets_of_any_length_are_fitted_and_timed() {
        let rows = [500, 1000].map(|value| {
            (
                value,
                least_time("lines", value, Method::Peak, QUICK_BASE, 1).unwrap(),
            )
        });
        assert!(rows.iter().all(|(_, time_s)| *time_s > 0.0));
    }
}
