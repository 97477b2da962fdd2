//! Growth of the time of a fit with FRFs, lines, modes and threads: exponents fitted over
//! doublings of one of them. And its change where the panel is cut: less data must not
//! cost more.

use crate::cases::panel;
use crate::countdown::Countdown;
use crate::csv;
use crate::journal::Journal;
use crate::large::{large, Size};
use crate::problem::Problem;
use chladni_frf::{Error, ErrorKind, FrfSet, FrfValues, Result};
use chladni_rfp::{fit, FitOptions, Method};
use ndarray::Axis;
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

/// The panel with one of every so many lines, FRFs (by responses), or both.
const CUTS: [usize; 5] = [1, 2, 4, 8, 16];
/// Modes of the panel inside its band.
const PANEL_MODES: usize = 34;
/// The cuts: the axis, whether lines are, whether FRFs are.
const CUT_AXES: [(&str, bool, bool); 3] = [
    ("lines of the panel", true, false),
    ("FRFs of the panel", false, true),
    ("values of the panel", true, true),
];

/// One time.
#[derive(Debug, Clone)]
pub struct ScalingRow {
    /// The quantity varied: FRFs, lines, modes, threads, or what is left of the panel.
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
    let whole = Problem::of_panel(&panel())?.measured(1);
    let axes = axes(quick, &whole);
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
                    journal.once(&name, || {
                        let set = set(axis, value, base, &whole)?;
                        least_time(axis, value, method, &set, repeats)
                    })?,
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

/// The axes and the values on each.
fn axes(quick: bool, whole: &FrfSet) -> Vec<(&'static str, Vec<usize>)> {
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
    let mut axes = vec![
        ("FRFs", doublings(first, 5)),
        ("lines", doublings(first, 4)),
        ("modes", doublings(5, 4)),
        ("threads", threads),
    ];
    axes.extend(CUT_AXES.map(|(axis, _, _)| {
        let cuts = CUTS[..if quick { 3 } else { CUTS.len() }].iter().rev();
        (axis, cuts.map(|&step| left(whole, axis, step).1).collect())
    }));
    axes
}

/// The rest of the panel after a cut, and the number of its lines, FRFs or values.
fn left(whole: &FrfSet, axis: &str, step: usize) -> (FrfSet, usize) {
    let (_, of_lines, of_frfs) = CUT_AXES
        .into_iter()
        .find(|(name, _, _)| *name == axis)
        .unwrap_or(CUT_AXES[2]);
    let every = |count: usize, cut: bool| -> Vec<usize> {
        (0..count).step_by(if cut { step } else { 1 }).collect()
    };
    let mut set = whole.on_lines(&every(whole.frequency_hz.len(), of_lines));
    let rows = every(whole.responses.len(), of_frfs);
    set.responses = rows.iter().map(|&row| whole.responses[row]).collect();
    set.values = match &set.values {
        FrfValues::F64(values) => FrfValues::F64(values.select(Axis(0), &rows)),
        FrfValues::F32(values) => FrfValues::F32(values.select(Axis(0), &rows)),
    };
    let (responses, references, lines) = set.values.dim();
    let count = match (of_lines, of_frfs) {
        (true, false) => lines,
        (false, _) => responses * references,
        (true, true) => responses * references * lines,
    };
    (set, count)
}

/// The data of one time, and the number of their modes.
fn set(axis: &str, value: usize, base: Size, whole: &FrfSet) -> Result<(FrfSet, usize)> {
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
    if CUT_AXES.iter().all(|(name, _, _)| *name != axis) {
        return Ok((large(size)?, size.modes));
    }
    let mut cuts = CUTS.into_iter().map(|step| left(whole, axis, step));
    let found = cuts.find(|(_, count)| *count == value);
    Ok((
        found.map_or_else(|| whole.clone(), |(set, _)| set),
        PANEL_MODES,
    ))
}

fn least_time(
    axis: &str,
    value: usize,
    method: Method,
    (frf, modes): &(FrfSet, usize),
    repeats: usize,
) -> Result<f64> {
    let threads = if axis == "threads" {
        value
    } else {
        rayon::current_num_threads()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))?;
    let options = FitOptions {
        method,
        modes: (method == Method::Lean).then_some(*modes),
        ..FitOptions::default()
    };
    let mut least = f64::INFINITY;
    for _ in 0..repeats {
        let start = Instant::now();
        let fitted = pool.install(|| fit(frf, &options));
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
        let whole = large(QUICK_BASE).unwrap();
        for value in [500, 1000] {
            let lines = set("lines", value, QUICK_BASE, &whole).unwrap();
            assert_eq!(lines.0.frequency_hz.len(), value + 1);
            assert!(least_time("lines", value, Method::Peak, &lines, 1).unwrap() > 0.0);
        }
    }

    #[test]
    fn a_cut_keeps_one_of_every_so_many() {
        let whole = large(QUICK_BASE).unwrap();
        let (lines, count) = left(&whole, "lines of the panel", 4);
        assert_eq!((lines.values.dim(), count), ((100, 5, 126), 126));
        assert_eq!(lines.values.get(7, 3, 5), whole.values.get(7, 3, 20));
        let (both, count) = left(&whole, "values of the panel", 2);
        assert_eq!((both.values.dim(), count), ((50, 5, 251), 62_750));
        assert_eq!(both.values.get(7, 3, 5), whole.values.get(14, 3, 10));
        assert_eq!(both.responses[7], whole.responses[14]);
    }
}
