//! The floor of a fit: what no method that looks at all data can do without, measured in
//! the same run.
//!
//! One pass over memory, and 16·N·M·m flop (N lines, M FRFs, m unknowns of one FRF): the
//! residues of all FRFs, QᴴB, and the compressed data, B(QᴴB)ᵀ, are two complex products
//! of 8·N·M·m flop each. The flops are charged at the speed of the back end's own complex
//! product on all threads.

use chladni_frf::{FrfSet, FrfValues};
use chladni_linalg::matmul;
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Side of the product that the speed is measured on: large enough for full speed, some
/// tens of milliseconds.
const SIDE: usize = 448;
/// Values per task of the memory pass: some megabytes.
const CHUNK: usize = 1 << 18;
/// Sums that a thread keeps, so that additions need not wait for each other.
const LANES: usize = 8;

/// Time of both parts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// One pass over the data, s.
    pub memory_s: f64,
    /// Bytes of the data.
    pub bytes: f64,
    /// 16·N·M·m.
    pub flop: f64,
    /// Speed of the back end's complex product on all threads, flop/s.
    pub flop_per_s: f64,
}

impl Floor {
    /// Measures both parts for a set whose fit has `unknowns` unknowns per FRF (poles and
    /// residual terms).
    pub fn measure(frf: &FrfSet, unknowns: usize) -> Self {
        let (responses, references, lines) = frf.values.dim();
        let values = (responses * references * lines) as f64;
        let bytes = match &frf.values {
            FrfValues::F64(_) => 16.0 * values,
            FrfValues::F32(_) => 8.0 * values,
        };
        Self {
            memory_s: memory_pass(frf),
            bytes,
            flop: 16.0 * values * unknowns as f64,
            flop_per_s: product_speed(),
        }
    }

    /// Seconds of the flops.
    pub fn flop_s(&self) -> f64 {
        self.flop / self.flop_per_s
    }

    /// Seconds of both.
    pub fn total_s(&self) -> f64 {
        self.memory_s + self.flop_s()
    }
}

/// Seconds that all threads take to add up all values.
fn memory_pass(frf: &FrfSet) -> f64 {
    let start = Instant::now();
    let sum = match &frf.values {
        FrfValues::F64(values) => values
            .as_slice_memory_order()
            .map(|values| sum(values, |value| value)),
        FrfValues::F32(values) => values
            .as_slice_memory_order()
            .map(|values| sum(values, |v| Complex64::new(v.re.into(), v.im.into()))),
    };
    std::hint::black_box(sum);
    start.elapsed().as_secs_f64()
}

fn sum<T: Copy + Sync>(values: &[T], widen: impl Fn(T) -> Complex64 + Sync) -> Complex64 {
    values
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut lanes = [Complex64::default(); LANES];
            for values in chunk.chunks(LANES) {
                for (lane, &value) in lanes.iter_mut().zip(values) {
                    *lane += widen(value);
                }
            }
            lanes.iter().sum::<Complex64>()
        })
        .sum()
}

/// flop/s of one complex product per thread, all threads at once.
fn product_speed() -> f64 {
    let threads = rayon::current_num_threads();
    let a = Array2::from_shape_fn((SIDE, SIDE), |(i, j)| {
        Complex64::new((i + 2 * j) as f64 % 7.0, (3 * i + j) as f64 % 5.0)
    });
    let start = Instant::now();
    (0..threads).into_par_iter().for_each(|_| {
        std::hint::black_box(matmul(a.view(), a.view()));
    });
    8.0 * (SIDE as f64).powi(3) * threads as f64 / start.elapsed().as_secs_f64()
}
