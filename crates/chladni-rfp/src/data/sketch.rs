//! First pass over the data: the count sketch (theory.md, eq. 6), the energy of each line and the
//! energy of each FRF.

use crate::data::limits;
use crate::data::pair_weights::PairWeights;
use crate::data::reading::{in_place, visit};
use crate::tolerances as tol;
use chladni_frf::FrfValues;
use ndarray::{Array1, Array2, ArrayViewMut2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// The column of the sketch that each FRF is added to, and the sign.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mixing {
    /// Number of columns.
    pub width: usize,
    /// Column of each FRF.
    pub column: Vec<usize>,
    /// Sign of each FRF: 1 or −1.
    pub sign: Vec<f64>,
}

impl Mixing {
    /// A random mixing with as many FRFs in one column as in another.
    pub fn even(frfs: usize, width: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut order: Vec<usize> = (0..frfs).collect();
        order.shuffle(&mut rng);
        let mut column = vec![0; frfs];
        for (position, &l) in order.iter().enumerate() {
            column[l] = position % width;
        }
        let sign = (0..frfs)
            .map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 })
            .collect();
        Self {
            width,
            column,
            sign,
        }
    }
}

/// The result of the pass, in units of the measured values.
#[derive(Debug, Clone)]
pub(crate) struct Sums {
    /// (line, column): signed sums of FRFs.
    pub columns: Array2<Complex64>,
    /// Sum of squares of each line.
    pub line_energy: Array1<f64>,
    /// Sum of squares of each FRF.
    pub frf_energy: Vec<f64>,
    /// True if an FRF holds a value that is not finite, or an FRF or a line holds zeros only.
    pub flawed: bool,
}

/// Adds two FRFs times their `signs` to a column, and their squares to the energy of the lines.
/// Returns the sum of squares of each FRF. Two at a time share the waits for memory. The function is
/// not inlined: the compiler would no longer know that the slices do not overlap, and would add one
/// value at a time.
#[inline(never)]
fn add_two(
    column: &mut [f64],
    energy: &mut [f64],
    one: &[f64],
    other: &[f64],
    signs: [f64; 2],
) -> [f64; 2] {
    let mut sums = [[0.0; limits::SKETCH_LANES]; 2];
    let mut lanes = |column: &mut [f64], energy: &mut [f64], one: &[f64], other: &[f64]| {
        let [first, second] = &mut sums;
        let sums = first.iter_mut().zip(second);
        for ((((first, second), column), energy), (one, other)) in
            sums.zip(column).zip(energy).zip(one.iter().zip(other))
        {
            let squares = [one * one, other * other];
            *column += signs[0] * one + signs[1] * other;
            *energy += squares[0] + squares[1];
            *first += squares[0];
            *second += squares[1];
        }
    };
    let ((columns, last_column), (energies, last_energy)) = (
        column.as_chunks_mut::<{ limits::SKETCH_LANES }>(),
        energy.as_chunks_mut::<{ limits::SKETCH_LANES }>(),
    );
    let ((ones, last_one), (others, last_other)) = (
        one.as_chunks::<{ limits::SKETCH_LANES }>(),
        other.as_chunks::<{ limits::SKETCH_LANES }>(),
    );
    for ((column, energy), (one, other)) in columns
        .iter_mut()
        .zip(energies)
        .zip(ones.iter().zip(others))
    {
        lanes(column, energy, one, other);
    }
    lanes(last_column, last_energy, last_one, last_other);
    sums.map(|sums| sums.iter().sum())
}

/// Sums FRFs into some of the columns, `frfs_of` each. Returns the squares of each line, real and
/// imaginary part in turn, and those of each FRF.
fn summed(
    values: &FrfValues,
    pairs: &[(usize, usize)],
    lines: &[usize],
    mixing: &Mixing,
    weights: Option<&PairWeights>,
    mut columns: ArrayViewMut2<Complex64>,
    frfs_of: &[Vec<usize>],
) -> (Vec<f64>, Vec<(usize, f64)>) {
    let size = 2 * lines.len();
    let (mut energy, mut copies, mut of_frfs) =
        (vec![0.0; size], [Vec::new(), Vec::new()], Vec::new());
    let zeros = vec![0.0; size];
    for (mut column, frfs) in columns.columns_mut().into_iter().zip(frfs_of) {
        let column: &mut [f64] =
            bytemuck::cast_slice_mut(column.as_slice_mut().expect("column-major"));
        for two in frfs.chunks(2) {
            let [first, second] = &mut copies;
            let one = values_of(values, pairs[two[0]], lines, weights, first);
            let other = two.get(1).map_or(zeros.as_slice(), |&l| {
                values_of(values, pairs[l], lines, weights, second)
            });
            let signs = [
                mixing.sign[two[0]],
                two.get(1).map_or(0.0, |&l| mixing.sign[l]),
            ];
            let sums = add_two(column, &mut energy, one, other, signs);
            of_frfs.extend(two.iter().copied().zip(sums));
        }
    }
    (energy, of_frfs)
}

/// An FRF as it lies in memory, or copied into `copy` with its weight.
fn values_of<'a>(
    values: &'a FrfValues,
    pair: (usize, usize),
    lines: &[usize],
    weights: Option<&PairWeights>,
    copy: &'a mut Vec<f64>,
) -> &'a [f64] {
    let weight = weights.map_or(1.0, |weights| weights.of(pair));
    in_place(values, &[pair], lines)
        .filter(|_| weights.is_none())
        .and_then(|frf| frf.to_slice_memory_order())
        .unwrap_or_else(|| {
            copy.resize(2 * lines.len(), 0.0);
            visit(
                values,
                pair,
                lines,
                copy.chunks_exact_mut(2),
                |out, value| (out[0], out[1]) = (value.re * weight, value.im * weight),
            );
            copy
        })
}

impl Sums {
    /// Runs the pass over `pairs` times their `weights` on `lines`. It goes column by column, so that
    /// every FRF is read in one stretch.
    pub fn new(
        values: &FrfValues,
        pairs: &[(usize, usize)],
        lines: &[usize],
        mixing: &Mixing,
        weights: Option<&PairWeights>,
    ) -> Self {
        let mut frfs_of = vec![Vec::new(); mixing.width];
        mixing
            .column
            .iter()
            .enumerate()
            .for_each(|(l, &column)| frfs_of[column].push(l));
        let mut columns = Array2::zeros((lines.len(), mixing.width).f());
        let size = mixing.width.div_ceil(tol::PASS_GROUPS);
        let groups: Vec<_> = columns
            .axis_chunks_iter_mut(Axis(1), size)
            .zip(frfs_of.chunks(size))
            .collect();
        let parts: Vec<_> = groups
            .into_par_iter()
            .map(|(columns, frfs_of)| {
                summed(values, pairs, lines, mixing, weights, columns, frfs_of)
            })
            .collect();
        let mut sums = Self {
            columns,
            line_energy: Array1::zeros(lines.len()),
            frf_energy: vec![0.0; pairs.len()],
            flawed: false,
        };
        for (energy, of_frfs) in parts {
            sums.line_energy
                .iter_mut()
                .zip(energy.chunks_exact(2))
                .for_each(|(sum, parts)| *sum += parts[0] + parts[1]);
            of_frfs
                .into_iter()
                .for_each(|(l, energy)| sums.frf_energy[l] = energy);
        }
        let sound = |energy: &f64| energy.is_finite() && *energy > 0.0;
        sums.flawed = !sums.frf_energy.iter().chain(&sums.line_energy).all(sound);
        sums
    }

    /// Only the lines at `places`; the energies of the FRFs are lost.
    pub fn select(&self, places: &[usize]) -> Self {
        let mut columns = Array2::zeros((places.len(), self.columns.ncols()).f());
        columns.assign(&self.columns.select(Axis(0), places));
        Self {
            columns,
            line_energy: self.line_energy.select(Axis(0), places),
            frf_energy: Vec::new(),
            flawed: self.flawed,
        }
    }
}
