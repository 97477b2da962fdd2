//! The default method: maximum likelihood if the residual is white, the measured-data path if
//! it is not. A fit that stopped for a pass goes on from there.

use super::limits::BAND_UNEXPLAINED;
use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::law::FIRST;
use crate::data::options::FitOptions;
use crate::data::outliers::{outliers_by_energy, OutlierLines};
use crate::data::products::Projected;
use crate::data::source::{By, Source, Way};
use crate::data::watch::Watch;
use crate::measured::path::measured_path;
use crate::methods::fit::{Fit, FitToCheck, MethodRun};
use crate::model::build::Shaped;
use crate::model::decide::decide;
use crate::model::in_law::in_law;
use crate::model::outlier_lines::outliers_of;
use crate::poles::chain::{fast_chain, Chain, Outcome};
use crate::poles::delay_alone;
use crate::poles::estimate::{graded, more_than_asked, PoleEstimate};
use crate::poles::prune::narrower_than_a_line;
use crate::poles::refine::{refine, Projection};
use crate::poles::sketched::Doubt;
use crate::poles::whiteness::Residual;
use crate::tolerances as tol;
use chladni_frf::{Damping, Finding, ModalModel, Severity, Trust};
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// The result of the search for poles.
enum PoleSearch {
    /// Poles, and the columns that they were found on.
    Found(Box<PoleEstimate>),
    /// Outlier lines (positions among those used) to leave out before the next search.
    LeaveOut(Vec<usize>),
}

impl From<PoleEstimate> for PoleSearch {
    fn from(found: PoleEstimate) -> Self {
        Self::Found(Box::new(found))
    }
}

/// Poles by the fast chain if its residual is white, else by the measured-data path, and the
/// model that they lead to.
///
/// # Errors
/// A fit that cannot be made; a pass that others must make.
pub(crate) fn auto<S: Source>(
    data: &S,
    options: &FitOptions,
    outlier_lines: OutlierLines,
    watch: &Watch,
) -> Result<MethodRun, S::Stop> {
    let run = Run {
        data,
        options,
        outlier_lines,
        watch,
    };
    let mut history = Vec::new();
    let found = match data.way() {
        // where the walk stopped
        Some(way) if !matches!(way.by, By::Fast { .. }) => run.on_way(way.clone())?,
        _ => match run.chain()? {
            Outcome::White(chain) => {
                history.clone_from(&chain.history);
                from_chain(*chain, options.modes, data.hz()).into()
            }
            Outcome::Ended(Doubt::Outliers(lines)) if outlier_lines == OutlierLines::LeaveOut => {
                PoleSearch::LeaveOut(lines)
            }
            Outcome::Ended(Doubt::Conjugated) => run.on_way(Way {
                law: data.law,
                lambda: Vec::new(),
                by: By::Conjugated,
            })?,
            Outcome::Ended(Doubt::Delay(seconds)) => run.on_way(Way {
                law: data.law,
                lambda: Vec::new(),
                by: By::Delay(seconds),
            })?,
            Outcome::Ended(doubt) => run.by_measured_path(doubt.words())?,
        },
    };
    let found = match found {
        PoleSearch::Found(found) => *found,
        PoleSearch::LeaveOut(lines) => return Ok(MethodRun::LeaveOut(lines)),
    };
    let residual = match found.residual_is_noise {
        true => Residual::White,
        false => Residual::NotWhite,
    };
    let (model, residual_energy_of_frfs) = run.finished(found)?;
    let leave_out = (outlier_lines, residual) == (OutlierLines::LeaveOut, Residual::NotWhite);
    let outliers = match data.values().filter(|_| leave_out) {
        Some(values) => outliers_of(values, &model),
        None => Vec::new(),
    };
    if !outliers.is_empty() {
        return Ok(MethodRun::LeaveOut(outliers));
    }
    let fit = Fit {
        model,
        history,
        stabilization: None,
    };
    Ok(MethodRun::Fitted(Box::new(FitToCheck {
        fit,
        residual,
        residual_energy_of_frfs,
    })))
}

/// One run of the method, with all that its steps need to know.
struct Run<'a, S> {
    data: &'a S,
    options: &'a FitOptions,
    outlier_lines: OutlierLines,
    watch: &'a Watch<'a>,
}

impl<S: Source> Run<'_, S> {
    /// The fast chain in the law asked for, or in the structural one if none is. If its residual is
    /// not white, the other law is tried.
    fn chain(&self) -> Result<Outcome, S::Stop> {
        let in_law = |law, doubt: Option<&str>| self.chain_in_law(law, doubt);
        let (law, doubt) = match self.data.way() {
            Some(Way {
                law,
                by: By::Fast { doubt, .. },
                ..
            }) => (*law, doubt.clone()),
            _ => (self.options.damping.unwrap_or(FIRST), None),
        };
        let (other, evidence) = match doubt {
            Some(evidence) => (law, evidence),
            None => match in_law(law, None)? {
                Outcome::Ended(Doubt::NotWhite(evidence)) => (law.other(), evidence),
                whole => return Ok(whole),
            },
        };
        Ok(match in_law(other, Some(&evidence))? {
            white @ Outcome::White(_) => white,
            Outcome::Ended(_) => Outcome::Ended(Doubt::NotWhite(evidence)),
        })
    }

    /// The fast chain in one law.
    ///
    /// * `doubt`: evidence against the other law, if that was tried before
    fn chain_in_law(&self, law: Damping, doubt: Option<&str>) -> Result<Outcome, S::Stop> {
        let asked = self.options.asked();
        let data = self.data.in_law(law);
        fast_chain(&data, self.options.seed, asked, doubt, self.watch)
    }

    /// The model that poles lead to, and what it leaves of each FRF.
    fn finished(&self, found: PoleEstimate) -> Result<(ModalModel, Vec<f64>), S::Stop> {
        let Run {
            data,
            options,
            watch,
            ..
        } = *self;
        let again = |found: PoleEstimate, law: Damping| -> Result<PoleEstimate, S::Stop> {
            let frfs = found.residual_is_noise.then_some(data.pairs.len());
            if !found.residual_is_noise || data.values().is_none() {
                return Ok(in_law(found, law, frfs)?);
            }
            match self.chain_in_law(law, None)? {
                Outcome::White(chain) => Ok(from_chain(*chain, options.modes, data.hz())),
                Outcome::Ended(_) => Ok(in_law(found, law, frfs)?),
            }
        };
        let (identified, mut warnings) = decide(data, found, options, watch, &again)?;
        let shaped = Shaped::new(data, identified, options.most_modes())?;
        let residual_energy = match data.values() {
            Some(values) => shaped.residual_energy(values),
            None => shaped.residual_energy_by_sums(data),
        };
        let mut model = shaped.model(data, options, &residual_energy)?;
        let mut findings = model.quality.findings.iter();
        let is_stopped = findings.any(|told| told.severity == Severity::Fault);
        if model.quality.relative_error > BAND_UNEXPLAINED && !is_stopped {
            warnings.push(band_unexplained(model.quality.relative_error));
        }
        model.quality.findings.append(&mut warnings);
        model.number_findings();
        Ok((model, residual_energy))
    }

    /// Poles by the measured-data path, or outlier lines to leave out.
    fn by_measured_path(&self, evidence: String) -> Result<PoleSearch, S::Stop> {
        let Run {
            data,
            options,
            watch,
            ..
        } = *self;
        let found = measured_path(data, options.seed, options.asked(), watch)?;
        let Some(scales) = found.frf_scales else {
            // the path ran on mixtures: residues come from one pass over all FRFs
            let way = Way {
                law: data.law,
                lambda: found.refined.lambda,
                by: By::Measured {
                    evidence,
                    spread: found.spread,
                    grades: found.grades,
                    findings: found.warnings,
                    weights: found.weights,
                },
            };
            return self.on_way(way);
        };
        Ok(PoleSearch::from(PoleEstimate {
            variance: found.refined.variance(&found.work),
            refined: found.refined,
            work: found.work,
            back: Some(Array2::from_diag(&scales)),
            spread: found.spread,
            residual_is_noise: false,
            grades: found.grades,
            idle: Vec::new(),
            path: measured_words(&evidence),
            warnings: found.warnings,
            consistent: true,
        }))
    }

    /// The poles of a way other than the fast chain, on columns of all FRFs. If the FRFs themselves
    /// are not at hand, outlier lines are looked for in these columns.
    fn on_way(&self, way: Way) -> Result<PoleSearch, S::Stop> {
        let data = self.data;
        let (mut sketch, energy) = data.sketch(self.options.seed);
        sketch.weigh(way.weights());
        let q = Projection::new(&sketch, &way.lambda, &RESIDUAL_POWERS)?.q;
        drop(sketch);
        data.end_first_pass();
        let projected = data.projected(&way, q, &energy)?;
        if data.values().is_none() && self.outlier_lines == OutlierLines::LeaveOut {
            let outliers = spoilt_lines(&way, &projected, &energy)?;
            if !outliers.is_empty() {
                return Ok(PoleSearch::LeaveOut(outliers));
            }
        }
        let refined = refine(&projected.work, &way.lambda, &RESIDUAL_POWERS, tol::NO_STEP)?;
        let consistent = way.by != By::Conjugated;
        let (spread, grades, path, warnings) = match way.by {
            By::Measured {
                evidence,
                spread,
                grades,
                findings,
                ..
            } => (spread, grades, measured_words(&evidence), findings),
            // the data contradict any passive structure in e^{+jωt}; they are not conjugated unless
            // the user says so
            By::Fast { .. } | By::Conjugated => (
                Vec::new(),
                Vec::new(),
                "stopped after the pole pool".into(),
                vec![conjugated()],
            ),
            By::Delay(seconds) => (
                Vec::new(),
                Vec::new(),
                "stopped: a delay alone explains the data".into(),
                vec![delay_alone::finding(seconds)],
            ),
        };
        Ok(PoleSearch::from(PoleEstimate {
            variance: refined.variance(&projected.work),
            refined,
            work: projected.work,
            back: Some(projected.back),
            spread,
            residual_is_noise: false,
            grades,
            idle: Vec::new(),
            path,
            warnings,
            consistent,
        }))
    }
}

/// The finding of a band whose peaks are explained, and most of its rms not.
fn band_unexplained(relative_error: f64) -> Finding {
    let words = format!(
        "the model leaves {:.0} % of the data: most of this band holds noise, or motion that no \
         resonance explains",
        100.0 * relative_error
    );
    Finding::caution("mostly-unexplained", words)
        .value("relative_error", relative_error)
        .help("fit the band in which peaks stand clear of the noise")
}

fn from_chain(chain: Chain, asked: Option<usize>, hz: f64) -> PoleEstimate {
    let (grades, spread) = graded(&chain.refined, &chain.projected.work, chain.variance);
    PoleEstimate {
        grades,
        spread,
        residual_is_noise: true,
        work: chain.projected.work,
        back: Some(chain.projected.back),
        variance: chain.variance,
        idle: chain.idle,
        path: format!("fast chain: {}", chain.whiteness.evidence),
        warnings: asked
            .and_then(|asked| more_than_asked(asked, &chain.dropped, hz))
            .into_iter()
            .collect(),
        consistent: true,
        refined: chain.refined,
    }
}

fn measured_words(evidence: &str) -> String {
    format!("measured-data path: {evidence}")
}

fn conjugated() -> Finding {
    Finding::fault(
        "conjugated",
        "every resonance turns the wrong way: the data follow e^(-jwt) as they were read",
    )
    .help("read the data with the other time sign")
}

/// Lines that no neighbour supports, by sums over all FRFs. They are judged by the residual of
/// the poles that are wider than a line and not rejected.
fn spoilt_lines(
    way: &Way,
    projected: &Projected,
    energy: &Array1<f64>,
) -> Result<Vec<usize>, LinalgError> {
    let By::Measured { grades, .. } = &way.by else {
        return Ok(Vec::new());
    };
    let work = &projected.work;
    let sound: Vec<Complex64> = way
        .lambda
        .iter()
        .zip(grades)
        .filter(|(pole, grade)| {
            grade.trust != Trust::Rejected && !narrower_than_a_line(work, **pole)
        })
        .map(|(pole, _)| *pole)
        .collect();
    if !sound.iter().any(|pole| work.in_band(*pole)) {
        return Ok(Vec::new()); // nothing to judge by
    }
    let mut left =
        projected.line_residual(&Projection::new(work, &sound, &RESIDUAL_POWERS)?.residual);
    for (left, weight) in left.iter_mut().zip(way.weights()) {
        *left /= weight * weight;
    }
    Ok(outliers_by_energy(energy, &left))
}
