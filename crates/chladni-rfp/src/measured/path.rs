//! The measured-data path as one walk: screen the record, search each section (votes of
//! several orders, error model, local tests, moving pairs), join what was found, grade it.

use super::limits::{COLUMNS_MOST, EXPLAINS, LOUD_AT_PEAKS, PEAK_WIDTHS, PEAK_WINDOW, SAME_POLE};
use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::{line_energy, Columns};
use crate::data::error::FitError;
use crate::data::grade::Grade;
use crate::data::layout::DataLayout;
use crate::data::onset::{late, onset_s};
use crate::data::options::Asked;
use crate::data::peaks::{fourth_difference_noise, peaks, thinned, Peak};
use crate::data::source::Source;
use crate::data::watch::Watch;
use crate::measured::candidates::Origin;
use crate::measured::correlated_noise::correlates;
use crate::measured::error_model::{column_scales, normalised};
use crate::measured::evidence::Evidence;
use crate::measured::grade::{grade_all, DampingDoubt, Graded};
use crate::measured::impulse::{padding_factor, windowed};
use crate::measured::record::{noise_window, Record};
use crate::measured::search::{Finished, Search};
use crate::poles::estimate::more_than_asked;
use crate::poles::refine::{refine, refine_inside, Refined};
use crate::poles::sections::{split, Section};
use crate::tolerances as tol;
use chladni_frf::{Finding, Trust};
use chladni_linalg::{matmul, svd_thin, LinalgError};
use ndarray::{s, Array1};
use num_complex::Complex64;
use rayon::prelude::*;

/// The poles that the path found.
#[derive(Debug)]
pub(crate) struct MeasuredPoles {
    /// Poles and linear part on `work`.
    pub refined: Refined,
    /// Weighted lines and columns.
    pub work: Columns,
    /// Scales of the FRFs, if the columns are FRFs over their scales; `None` for mixtures, which do
    /// not lead back to FRFs.
    pub frf_scales: Option<Array1<f64>>,
    /// 1/σ of each line of the data, of unit mean square; empty where lines do not have the shape
    /// of the columns, so that residues do best to follow the peaks.
    pub weights: Vec<f64>,
    /// E|δλ|² of each pole.
    pub spread: Vec<f64>,
    /// Grade of each pole; nuisance poles are `Weak` without reasons.
    pub grades: Vec<Grade>,
    /// Warnings.
    pub warnings: Vec<Finding>,
}

/// Columns for the path: FRFs over their scales, with these, or the strongest mixtures of many.
fn columns<S: Source>(data: &S, seed: u64) -> Result<(Columns, Option<Array1<f64>>), LinalgError> {
    let few = data
        .values()
        .filter(|values| values.pairs.len() <= COLUMNS_MOST);
    let Some(values) = few else {
        return Ok((strongest(&data.sketch(seed).0)?, None));
    };
    let raw = values.work();
    let scales = column_scales(&raw);
    let mut b = raw.b.clone();
    for (mut column, scale) in b.columns_mut().into_iter().zip(&scales) {
        column.mapv_inplace(|v| v / scale);
    }
    Ok((raw.with_columns(b), Some(Array1::from(scales))))
}

/// The strongest mixtures of the columns of a sketch.
fn strongest(sketch: &Columns) -> Result<Columns, LinalgError> {
    let (_, _, vh) = svd_thin(sketch.b.view())?;
    let mixing = vh
        .slice(s![..COLUMNS_MOST.min(vh.nrows()), ..])
        .mapv(|v| v.conj());
    Ok(sketch.with_columns(matmul(sketch.b.view(), mixing.t())))
}

/// Runs the path. `asked` may fix the number of modes, and add some.
///
/// # Errors
/// A kernel that fails; a watch that ends it.
pub(crate) fn measured_path<S: Source>(
    data: &S,
    seed: u64,
    asked: Asked,
    watch: &Watch,
) -> Result<MeasuredPoles, FitError> {
    let (work, frf_scales) = columns(data, seed)?;
    on_columns(data, work, frf_scales, asked, watch)
}

/// The path on columns that are made already; `frf_scales` if they are FRFs over their scales.
fn on_columns(
    data: &DataLayout,
    work: Columns,
    frf_scales: Option<Array1<f64>>,
    asked: Asked,
    watch: &Watch,
) -> Result<MeasuredPoles, FitError> {
    watch.stage("screening")?;
    let hz = data.hz();
    let (visible, mut warnings) = visible(data, work);
    let record = visible.record(data, frf_scales.as_ref());

    watch.stage("pole pool and local tests")?;
    let sections = split(&visible.work, &visible.seen);
    let (searches, dropped) = searched(&record, &sections, asked)?;
    warnings.extend(
        asked
            .modes
            .and_then(|modes| more_than_asked(modes, &dropped, hz)),
    );
    watch.stage("error bars and grades")?;
    let finished = searches
        .into_par_iter()
        .map(Search::finish)
        .collect::<Result<Vec<_>, LinalgError>>()?;
    warnings.extend(finished.iter().flat_map(|f| f.notes.iter().cloned()));
    let (evidence, weights) = join(&visible.work, &finished);
    let graded = grade_all(&evidence, &record);
    warnings.extend(damping_doubts(&evidence, &graded, hz));
    warnings.extend(peaks_left(
        unexplained(&visible.seen, &evidence, &graded)
            .map(|peak| peak.lambda.re.max(0.0).sqrt() * hz)
            .collect(),
    ));

    let work = visible.work.reweighted(&weights);
    let lambda: Vec<Complex64> = evidence.iter().map(|e| e.lambda).collect();
    // poles of resolved modes are those of their own lines, unless errors are largest there
    let refined = match record.leaks {
        true => refine_inside(&work, &lambda, &RESIDUAL_POWERS, tol::FINE)?,
        false => refine(&work, &lambda, &RESIDUAL_POWERS, tol::NO_STEP)?,
    };
    let spread = evidence
        .iter()
        .map(|e| (e.deviation * e.lambda.im).powi(2))
        .collect();
    Ok(MeasuredPoles {
        refined,
        weights: match record.needs_all_lines() {
            true => on_lines(&data.x, &visible.work.x, &weights),
            false => Vec::new(),
        },
        work,
        frf_scales,
        spread,
        grades: graded.into_iter().map(|own| own.grade).collect(),
        warnings,
    })
}

/// The lines of a record that are worth a search, and what they show before it.
struct Visible {
    work: Columns,
    noise: Array1<f64>,
    seen: Vec<Peak>,
    /// True if the records went through a window that is not known.
    windowed: bool,
}

impl Visible {
    /// The record as a search takes it; `frf_scales` if the columns are FRFs over their scales.
    fn record<'a>(&'a self, data: &'a DataLayout, frf_scales: Option<&Array1<f64>>) -> Record<'a> {
        Record {
            work: &self.work,
            noise: &self.noise,
            seen: &self.seen,
            frfs: data.pairs.len(),
            scales: frf_scales.cloned(),
            one_reference: data.references.len() == 1,
            windowed: self.windowed,
            leaks: data.errors.as_ref().is_some_and(|errors| errors.leaks()),
            loud_at_peaks: self.loud_at_peaks(data),
            correlated_noise: data
                .errors
                .as_deref()
                .filter(|errors| correlates(&self.work, errors)),
            hz: data.hz(),
        }
    }

    /// True if the set says that lines at half of the peaks or more are far noisier than the
    /// median line.
    fn loud_at_peaks(&self, data: &DataLayout) -> bool {
        let (reach, least) = PEAK_WINDOW;
        let loud = |peak: &&Peak| {
            let lines = self.work.window(peak.lambda, reach, least);
            let count = lines.len() as f64;
            let sum: f64 = lines.map(|k| data.variance_at(self.work.x[k])).sum();
            sum > LOUD_AT_PEAKS * count
        };
        let number = self.seen.iter().filter(loud).count();
        number > 0 && 2 * number >= self.seen.len()
    }
}

/// Looks at a record: zeros appended to it, its window, its noise and its peaks.
fn visible(data: &DataLayout, mut work: Columns) -> (Visible, Vec<Finding>) {
    let mut warnings = Vec::new();
    let factor = padding_factor(&work, &data.line_hz);
    if factor > 1 {
        warnings.push(padded(factor));
        work = work
            .select(&(0..work.lines()).step_by(factor).collect::<Vec<_>>())
            .of_padded(factor);
    }
    let thinned_hz: Vec<f64> = data.line_hz.iter().copied().step_by(factor).collect();
    let onset_s = onset_s(work.b.view(), &thinned_hz);
    warnings.extend(onset_s.map(late));
    // a window that is known is in the columns
    let shows = || onset_s.is_none() && windowed(&work, &thinned_hz);
    let windowed = data.window.is_none() && (data.hann_on_blows_s.is_some() || shows());
    if windowed && data.hann_on_blows_s.is_none() {
        warnings.push(broadened());
    }
    let noise = fourth_difference_noise(&work, noise_window(work.lines()));
    let seen = peaks(&work, &line_energy(&work.b), &noise);
    let rows = thinned(&work, &seen);
    let seen = Visible {
        noise: rows.iter().map(|&k| noise[k]).collect(),
        work: work.select(&rows),
        seen,
        windowed,
    };
    (seen, warnings)
}

/// The finding of a record with zeros appended.
fn padded(factor: usize) -> Finding {
    let words = format!(
        "the impulse response ends at 1/{factor} of the record (zero-padded): only every {} line \
         is used, the others are interpolation",
        ordinal(factor)
    );
    Finding::note("padded", words).value("padding_factor", factor as f64)
}

/// The finding of an unknown window.
fn broadened() -> Finding {
    let words = "the impulse response decays ever faster: the records went through a window (Hann \
                 or similar) that broadens every line; poles beside a stronger one may be its \
                 side lobes";
    Finding::caution("windowed", words)
        .help("take the damping as an upper bound, or measure without that window")
}

/// Searches all sections, with the number of modes and the added ones as asked; returns
/// the searches, and the poles that went for that number.
fn searched<'a>(
    record: &'a Record<'a>,
    sections: &'a [Section],
    asked: Asked,
) -> Result<(Vec<Search<'a>>, Vec<Complex64>), LinalgError> {
    let mut searches = sections
        .par_iter()
        .map(|section| Search::run(record, section, asked.modes))
        .collect::<Result<Vec<_>, LinalgError>>()?;
    let mut dropped = Vec::new();
    if let Some(modes) = asked.modes {
        let trust = standing(&searches, record)?;
        dropped = keep_strongest(&mut searches, modes, &trust)?;
    }
    for search in &mut searches {
        search.add(asked)?;
    }
    // what was added is not left out
    dropped.retain(|gone| searches.iter().all(|search| !search.holds(*gone)));
    Ok((searches, dropped))
}

/// Evidence of all sections in order of frequency, poles that two sections report once,
/// and the weight of every line.
fn join(work: &Columns, finished: &[Finished]) -> (Vec<Evidence>, Vec<f64>) {
    let mut all: Vec<Evidence> = finished
        .iter()
        .flat_map(|f| f.evidence.iter().cloned())
        .collect();
    all.sort_by(|a, b| a.lambda.re.total_cmp(&b.lambda.re));
    if finished.len() > 1 {
        all.dedup_by(|b, a| {
            (a.lambda - b.lambda).norm()
                < SAME_POLE * a.lambda.im.max(b.lambda.im).max(work.spacing(a.lambda.re))
        });
    }
    // where sections overlap the later one's error model stands: both saw the lines
    let mut variance = Array1::from_elem(work.lines(), f64::MAX);
    for part in finished {
        variance
            .slice_mut(s![part.lines.clone()])
            .assign(&part.variance);
    }
    (all, normalised(&variance))
}

/// Weights of lines x from those of lines `known`, some of them, of unit mean square.
fn on_lines(x: &[f64], known: &[f64], weights: &[f64]) -> Vec<f64> {
    let at = |&x: &f64| {
        let after = known.partition_point(|own| *own < x);
        match (after.checked_sub(1), after < known.len()) {
            (Some(before), true) => {
                let part = (x - known[before]) / (known[after] - known[before]);
                weights[before] + part * (weights[after] - weights[before])
            }
            (Some(last), false) => weights[last],
            (None, _) => weights[0],
        }
    };
    let mut all: Vec<f64> = x.iter().map(at).collect();
    let squares: f64 = all.iter().map(|weight| weight * weight).sum();
    let rms = (squares / all.len() as f64).sqrt();
    all.iter_mut().for_each(|weight| *weight /= rms);
    all
}

/// Poles with their grades, as the searches stand.
fn standing(searches: &[Search], record: &Record) -> Result<Vec<(Complex64, Trust)>, LinalgError> {
    let finished = searches
        .par_iter()
        .map(|search| search.clone().finish())
        .collect::<Result<Vec<_>, LinalgError>>()?;
    let (evidence, _) = join(record.work, &finished);
    let grades = grade_all(&evidence, record);
    let of_pole = |(e, graded): (&Evidence, Graded)| (e.lambda, graded.grade.trust);
    Ok(evidence.iter().zip(grades).map(of_pole).collect())
}

/// Drops in-band poles until `modes` are left in all sections together, those that would
/// not be sure before those that would, the least local gain first; returns the dropped
/// ones. Poles that are no modes are not counted.
fn keep_strongest(
    searches: &mut [Search],
    modes: usize,
    trust: &[(Complex64, Trust)],
) -> Result<Vec<Complex64>, LinalgError> {
    let mut dropped = Vec::new();
    let mut weakest = searches
        .iter()
        .map(|search| search.weakest(trust))
        .collect::<Result<Vec<_>, LinalgError>>()?;
    while weakest.iter().map(|w| w.count).sum::<usize>() > modes {
        let least = weakest
            .iter()
            .enumerate()
            .filter_map(|(s, w)| Some((s, w.least?)))
            .min_by(|(_, a), (_, b)| a.after(b));
        let Some((s, least)) = least else { break };
        dropped.push(searches[s].candidates.refined.lambda[least.pole]);
        searches[s].drop(least.pole)?;
        weakest[s] = searches[s].weakest(trust)?;
    }
    Ok(dropped)
}

/// Striking peaks beside which no pole stands that is accepted, or left out as asked. A
/// pole that is broad for the peak does not explain it.
fn unexplained<'a>(
    seen: &'a [Peak],
    evidence: &'a [Evidence],
    graded: &'a [Graded],
) -> impl Iterator<Item = &'a Peak> {
    let explains = |peak: &Peak, pole: Complex64| {
        (pole.re - peak.lambda.re).abs()
            < EXPLAINS
                * peak
                    .lambda
                    .im
                    .max(pole.im.min(PEAK_WIDTHS * peak.lambda.im))
    };
    let accepted = move |peak: &Peak| {
        evidence.iter().zip(graded).any(|(e, own)| {
            let accepted = own.grade.trust != Trust::Rejected || e.origin == Origin::LeftOut;
            accepted && explains(peak, e.lambda)
        })
    };
    seen.iter()
        .filter(move |peak| peak.is_striking() && !accepted(peak))
}

/// The finding of visible peaks, Hz, that no accepted mode explains.
fn peaks_left(mut places: Vec<f64>) -> Option<Finding> {
    places.sort_by(f64::total_cmp);
    let text = match places.as_slice() {
        [] => return None,
        [one] => format!("a visible peak at {one:.2} Hz that no accepted mode explains"),
        [first, .., last] => format!(
            "{} visible peaks, {first:.1} to {last:.1} Hz, that no accepted mode explains",
            places.len()
        ),
    };
    let help = "look at them in the report; add a mode there, or fit a band without them";
    Some(
        Finding::caution("peak-unexplained", text)
            .list("peaks_hz", places)
            .help(help),
    )
}

/// One finding per kind of doubt about damping, with the modes it concerns.
fn damping_doubts(evidence: &[Evidence], graded: &[Graded], hz: f64) -> Vec<Finding> {
    let concerned = |kind: DampingDoubt| -> Vec<f64> {
        evidence
            .iter()
            .zip(graded)
            .filter(|(_, own)| own.grade.trust != Trust::Rejected && own.doubt == Some(kind))
            .map(|(e, _)| e.lambda.re.max(0.0).sqrt() * hz)
            .collect()
    };
    [DampingDoubt::UpperBound, DampingDoubt::Indicative]
        .into_iter()
        .filter_map(|kind| kind.finding(concerned(kind)))
        .collect()
}

/// "2nd", "3rd", "4th": counts of lines, which are small.
fn ordinal(number: usize) -> String {
    let ending = match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}
