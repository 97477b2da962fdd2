//! Structured refinement: one shape per mode for all references, real where the data
//! admit it (theory.md, section 4).
//!
//! Free residues spend most of their freedom on differences that no structure has.
//! Rank-one residues R_n = ψ_n·L_nᵀ lower the bound of close poles by up to an order of
//! magnitude, real shapes by √2 in frequency on top. Either is taken only where the sum
//! of squares rises by no more than chance (likelihood ratio); where rank one does not
//! hold, modes may be missing, and one at a time is added while it pays.
//!
//! Needs every pair of response and reference, and the structural law (complex-analytic
//! poles).

use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::data::options::ShapeModel;
use crate::poles::estimate::PoleEstimate;
use crate::shapes::attempt::{is_chance, Attempt};
use crate::shapes::limits;
use chladni_linalg::LinalgError;
use ndarray::Array2;
use num_complex::Complex64;

/// One pole with the shapes that belong to it: one row each, more than one for a repeated
/// pole.
#[derive(Debug, Clone)]
pub(crate) struct StructuredPole {
    /// Pole in the x plane.
    pub lambda: Complex64,
    /// Variances of Re λ and Im λ for unit noise variance.
    pub spread: [f64; 2],
    /// (row, response).
    pub shape: Array2<Complex64>,
    /// (row, reference).
    pub participation: Array2<Complex64>,
}

/// The poles of the band that structured refinement found.
#[derive(Debug, Clone)]
pub(crate) struct Structured {
    /// Poles of the band, and of just beyond.
    pub poles: Vec<StructuredPole>,
    /// The poles with free residues that they stand for.
    pub replaced: Vec<Complex64>,
    /// All other poles, and the place of each once these have their shapes; `None` where
    /// its neighbour stands for it.
    pub others: Vec<(Complex64, Option<Complex64>)>,
    /// Poles outside the band that are needed besides.
    pub added: Vec<Complex64>,
    /// True where the model as saved, whose other poles have one place each for all FRFs,
    /// leaves no more than chance.
    pub borne: bool,
    /// True where shapes are real.
    pub real: bool,
    /// The structure taken and the reason for it, for the result.
    pub evidence: String,
}

impl Structured {
    /// True where no pole has come into the band: it would pass for a mode.
    fn stays_outside(&self, work: &Columns) -> bool {
        let outside = |pole: &Complex64| !work.in_band(*pole);
        let before = self.replaced.iter().filter(|pole| outside(pole)).count();
        let now = self.poles.iter().filter(|pole| outside(&pole.lambda));
        now.map(|pole| pole.shape.nrows()).sum::<usize>() >= before
    }
}

/// The result of the search for structure.
#[derive(Debug)]
pub(crate) enum Search {
    /// Not asked for, or nothing to hold against the data.
    Inapplicable,
    /// One shape per mode raises the sum of squares by so many standard deviations of
    /// chance, with all the modes that could be added.
    Refused(f64),
    /// It holds.
    Found(Structured),
}

/// Refines the poles of the band under the shape model asked for; where one just beyond
/// its ends has one shape too, that one with them: left free it takes most of what is
/// known of its neighbour inside.
///
/// `fixed_order`: no mode may be added.
pub(crate) fn structured(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
) -> Result<Search, LinalgError> {
    match attempted(data, found, asked, fixed_order) {
        // columns that cannot be told apart hold nothing against the data
        Err(LinalgError::NotPositiveDefinite { .. }) => Ok(Search::Inapplicable),
        other => other,
    }
}

fn attempted(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
) -> Result<Search, LinalgError> {
    let (work, lambda) = (&found.work, &found.refined.lambda);
    let complete = data.pairs.len() == data.responses.len() * data.references.len();
    if asked == ShapeModel::Free || !complete || !lambda.iter().any(|l| work.in_band(*l)) {
        return Ok(Search::Inapplicable);
    }
    let (low, high) = work.range();
    let beside = |l: &Complex64| (low - l.re).max(l.re - high) < limits::BESIDE_HALF_WIDTHS * l.im;
    let mut known = None;
    if asked == ShapeModel::Auto && lambda.iter().any(|l| beside(l) && !work.in_band(*l)) {
        let attempt = Attempt::new(data, found, (asked, fixed_order), beside)?;
        let state = attempt.one_shape_each(None)?;
        if is_chance(attempt.beyond_free(&state)) {
            if !attempt.is_hopeless(&state)? {
                match attempt.searched(state.clone())? {
                    Search::Found(own) if own.borne && own.stays_outside(work) => {
                        return Ok(Search::Found(own));
                    }
                    _ => {}
                }
            }
            known = Some(state);
        }
    }
    let attempt = Attempt::new(data, found, (asked, fixed_order), |l| work.in_band(*l))?;
    let state = attempt.one_shape_each(known.as_ref())?;
    let sigmas = attempt.beyond_free(&state);
    match asked {
        ShapeModel::Auto if !is_chance(sigmas) => Ok(Search::Refused(sigmas)),
        _ => attempt.searched(state),
    }
}
