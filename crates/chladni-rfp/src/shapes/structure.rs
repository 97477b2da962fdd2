//! Modes with one shape each, as the search for structure finds them.

use crate::data::columns::Columns;
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
    pub fn stays_outside(&self, work: &Columns) -> bool {
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
