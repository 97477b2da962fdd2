//! Decisions on the structure: its damping law, and one shape per mode, complex or real, for all
//! references.

use crate::damping::findings;
use crate::damping::verdict::{self, Fitted, Verdict, Window};
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::{FitOptions, ShapeModel};
use crate::data::watch::Watch;
use crate::model::fewer_poles::{law_of_fewer_poles, may_tell, without_needless_poles, STAGE};
use crate::model::identified::{Identified, LawOpen};
use crate::model::in_law::in_law;
use crate::model::limits;
use crate::poles::estimate::{is_faint, PoleEstimate};
use crate::shapes::search::structured;
use crate::shapes::structure::Search;
use chladni_frf::{Damping, Finding};
use chladni_linalg::LinalgError;
use ndarray::Axis;
use num_complex::Complex64;

/// Poles in the damping law that the data prefer, or that is asked for, with one shape per
/// mode if that serves all references; and the findings on both. If no law is asked for:
///
/// 1. The phases of the residues choose the law.
/// 2. If they do not decide for good, or there is no noise to judge them by, and little noise tells the
///    laws far apart, the law in which few poles explain the data clearly better is taken.
/// 3. If neither decides for good and one shape per mode is refused, the other law is taken if one shape
///    per mode holds there: heavily overlapping modes may have wrong phases. The law stays open if
///    the phases spoke for the first. If the other law has more poles, the first is tried with
///    these before.
/// 4. If shapes are complex in the first law and real in the other, the other is taken, on
///    condition that phases are true.
///
/// Before shapes are looked at, poles that data without noise do not need are taken out.
///
/// * `again`: finds the poles in another law
pub(crate) fn decide<E: From<LinalgError> + From<FitError>>(
    data: &DataLayout,
    found: PoleEstimate,
    options: &FitOptions,
    watch: &Watch,
    again: &dyn Fn(PoleEstimate, Damping) -> Result<PoleEstimate, E>,
) -> Result<(Identified, Vec<Finding>), E> {
    watch.stage(STAGE)?;
    let verdict = law_verdict(data, &found, options)?;
    let is_asked = options.damping.is_some();
    let is_decided = matches!(verdict, Verdict::Decided(_));
    // without noise the phases are judged by rounding
    let is_open = found.is_rounding() || !(is_asked || is_decided);
    let frfs = data.pairs.len();
    let by_poles = match is_open && may_tell(&found) {
        true => law_of_fewer_poles(&found, frfs, watch)?,
        false => None,
    };
    let (by_poles, found) = match by_poles {
        Some(law) if law != found.work.law && !is_asked => {
            let other = again(found.clone(), law)?;
            match other.leaves_no_more_than(&found) {
                true => (by_poles, other),
                false => (None, found),
            }
        }
        _ => (by_poles, found),
    };
    let verdict = by_poles.map_or(verdict, Verdict::Decided);
    let law = options.damping.or(verdict.law()).unwrap_or(found.work.law);
    let found = match found.work.law == law {
        true => found,
        false => again(found, law)?,
    };
    let found = match options.modes.is_none() && options.added_hz.is_empty() {
        true => without_needless_poles(found, frfs)?,
        false => found,
    };
    watch.stage("shapes")?;
    let mut choice = Choice {
        search: shape_search(data, &found, options)?,
        found,
        verdict,
    };
    if options.damping.is_none() && by_poles.is_none() {
        let in_other = |found: PoleEstimate| again(found, law.other());
        choice = choice.or_other_law(data, options, law.other(), in_other)?;
    }
    let real = real_shapes_hold(&choice.search);
    let mut identified = Identified::new(choice.found);
    let on_law = note_law(&mut identified, data, choice.verdict, options, real);
    let mut findings = Vec::from_iter(on_law);
    match choice.search {
        Search::Found(structured) => identified = identified.structured(structured),
        Search::Refused(sigmas) => findings.push(one_shape_refused(sigmas)),
        Search::Inapplicable => {}
    }
    Ok((identified, findings))
}

/// Poles in one law, with their shapes and the verdict on the law.
struct Choice {
    found: PoleEstimate,
    search: Search,
    verdict: Verdict,
}

impl Choice {
    /// The poles in the `other` law if their shapes speak for it, else these: steps 3 and 4 of
    /// [`decide`].
    fn or_other_law<E: From<LinalgError>>(
        self,
        data: &DataLayout,
        options: &FitOptions,
        other: Damping,
        in_other: impl FnOnce(PoleEstimate) -> Result<PoleEstimate, E>,
    ) -> Result<Self, E> {
        let refused = matches!(self.search, Search::Refused(_))
            && !matches!(self.verdict, Verdict::Decided(_));
        let complex = one_shape_holds(&self.search)
            && !real_shapes_hold(&self.search)
            && options.shapes == ShapeModel::Auto;
        if !(refused || complex) {
            return Ok(self);
        }
        let found = in_other(self.found.clone())?;
        let search = shape_search(data, &found, options)?;
        if !(one_shape_holds(&search) && (refused || real_shapes_hold(&search))) {
            return Ok(self);
        }
        if refused && found.refined.lambda.len() > self.found.refined.lambda.len() {
            // the search in the other law found poles that this one lacked
            if let Some(with_all) = self.with_poles_of(&found, data, options)? {
                return Ok(with_all);
            }
        }
        // a phase that all FRFs share does not make one shape per mode fail, but turns real
        // shapes into complex ones and back
        let verdict = match (refused, self.verdict) {
            (true, Verdict::IfPhasesTrue(..)) => Verdict::Disputed,
            (true, _) => Verdict::Decided(other),
            (false, _) => {
                let turn = verdict::confusing_turn(&found.work, &found.refined.lambda);
                Verdict::IfPhasesTrue(other, turn)
            }
        };
        Ok(Self {
            found,
            search,
            verdict,
        })
    }

    /// The law of these poles with those that were `found` in the other one, if they leave no more
    /// there, one shape per mode holds, and phases do not decide for the other law.
    fn with_poles_of(
        &self,
        found: &PoleEstimate,
        data: &DataLayout,
        options: &FitOptions,
    ) -> Result<Option<Self>, LinalgError> {
        let frfs = found.residual_is_noise.then_some(data.pairs.len());
        let here = in_law(found.clone(), self.found.work.law, frfs)?;
        let verdict = law_verdict(data, &here, options)?;
        let is_contradicted = verdict == Verdict::Decided(found.work.law);
        if is_contradicted || !here.leaves_no_more_than(found) {
            return Ok(None);
        }
        let search = shape_search(data, &here, options)?;
        Ok(one_shape_holds(&search).then_some(Self {
            found: here,
            search,
            verdict,
        }))
    }
}

/// Poles in the damping law that the data prefer, or that is asked for, with free residues.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn with_free_residues(
    data: &DataLayout,
    found: PoleEstimate,
    options: &FitOptions,
) -> Result<Identified, LinalgError> {
    let verdict = law_verdict(data, &found, options)?;
    let law = options.damping.or(verdict.law()).unwrap_or(found.work.law);
    let mut identified = Identified::new(in_law(found, law, None)?);
    let on_law = note_law(&mut identified, data, verdict, options, false);
    identified.warnings.extend(on_law);
    Ok(identified)
}

/// Marks a law that the data leave open. Returns the finding on the law if the data contradict it,
/// or hardly determine it.
///
/// * `verdict`: of the data on the law
/// * `real`: true if shapes are real in the law taken
pub(crate) fn note_law(
    identified: &mut Identified,
    data: &DataLayout,
    verdict: Verdict,
    options: &FitOptions,
    real: bool,
) -> Option<Finding> {
    let (law, free) = (identified.damping, options.damping.is_none());
    let shift = identified.shift_by_other_law(data.decay_of_window(options));
    identified.law_open = match free && verdict.law().is_none() {
        true if !identified.residual_is_noise => LawOpen::ResidualNotWhite,
        true if shift > limits::LAW_SHIFTS => LawOpen::BeyondErrorBars,
        _ => LawOpen::No,
    };
    match verdict {
        Verdict::Decided(other) if other != law => Some(findings::contradicted(law, None)),
        // a phase that all modes share cannot contradict real shapes
        Verdict::IfPhasesTrue(other, degrees) if other != law && !real => {
            Some(findings::contradicted(law, Some(degrees)))
        }
        Verdict::IfPhasesTrue(own, degrees) if own == law && free && shift > limits::LAW_SHIFTS => {
            Some(findings::if_phases_true(law, degrees))
        }
        Verdict::Undecidable if free && shift > limits::LAW_SHIFTS => {
            Some(findings::undecidable(law, shift))
        }
        Verdict::Disputed if free && shift > limits::LAW_SHIFTS => {
            Some(findings::disputed(law, shift))
        }
        _ => None,
    }
}

/// The finding that one shape per mode does not serve all references.
fn one_shape_refused(sigmas: f64) -> Finding {
    let words = format!(
        "one shape per mode does not explain all references together ({sigmas:.0} sigma beyond \
         chance): modes may hide in each other's overlap, or the references were not measured \
         alike"
    );
    Finding::caution("one-shape-refused", words)
        .value("beyond_chance_sigma", sigmas)
        .help("look for a delay or a gain of one reference, or fit a narrower band")
}

/// True if one shape for each mode adds no more than chance to the residual.
fn one_shape_holds(search: &Search) -> bool {
    matches!(search, Search::Found(structured) if structured.borne)
}

/// True if one real shape for each mode adds no more than chance to the residual.
fn real_shapes_hold(search: &Search) -> bool {
    matches!(search, Search::Found(structured) if structured.borne && structured.real)
}

/// The verdict of the data on the law: undecidable without modes, and if the residual is not
/// white and damping is light.
fn law_verdict(
    data: &DataLayout,
    found: &PoleEstimate,
    options: &FitOptions,
) -> Result<Verdict, LinalgError> {
    if !found.residual_is_noise && found.heaviest_sure() < limits::LAW_ALIKE {
        return Ok(Verdict::Undecidable);
    }
    // faint modes may stand for the misfit of a wrong law: they do not count
    let all = &found.refined.lambda;
    let shown: Vec<usize> = (0..all.len())
        .filter(|&n| !is_faint(&found.grades[n]))
        .collect();
    let lambda: Vec<Complex64> = shown.iter().map(|&n| all[n]).collect();
    let terms = all.len()..found.refined.coefficients.nrows();
    let rows: Vec<usize> = shown.into_iter().chain(terms).collect();
    let fitted = Fitted {
        lambda: &lambda,
        powers: &found.refined.powers,
        coefficients: &found.refined.coefficients.select(Axis(0), &rows),
        variance: found.variance,
        frfs: data.pairs.len(),
        window: Window {
            kind: data.kind,
            decay: data.decay_of_window(options),
        },
    };
    verdict::verdict(&found.work, &fitted)
}

/// Structured refinement if it applies: it is asked for, or the residual is white noise, so that
/// chance can be judged.
fn shape_search(
    data: &DataLayout,
    found: &PoleEstimate,
    options: &FitOptions,
) -> Result<Search, LinalgError> {
    let forced = matches!(options.shapes, ShapeModel::Rank1 | ShapeModel::Real);
    if !(found.residual_is_noise || forced) {
        return Ok(Search::Inapplicable);
    }
    structured(data, found, options.shapes, options.modes.is_some())
}
