//! Kernels of dense linear algebra at the sizes of a fit, each back end in turn within
//! one run.

use crate::countdown::Countdown;
use crate::csv;
use crate::statistics::{distinct, median, quantile};
use chladni_linalg::{back_ends, BackEnd};
use chladni_report::{Anchor, Axis, Chart, Colour, Figure, Height, Layer, Mark};
use ndarray::{s, Array2, ShapeBuilder};
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::time::Instant;

/// Each kernel is repeated for so long at least, s.
const LEAST_S: f64 = 0.3;
/// The same in a quick run.
const QUICK_S: f64 = 0.08;
/// And so often at least.
const LEAST_REPEATS: usize = 5;

/// The work of a kernel on matrices a and b.
type Work = fn(&BackEnd, &Array2<Complex64>, &Array2<Complex64>) -> f64;

/// A kernel at one size.
struct Kernel {
    name: &'static str,
    /// The use of it, at this size.
    about: &'static str,
    /// Rows and columns of a, and columns of b.
    size: [usize; 3],
    /// Real operations of the textbook algorithm.
    flop: fn([f64; 3]) -> f64,
    work: Work,
}

/// Complex multiply and add: 8 real operations.
const KERNELS: [Kernel; 12] = [
    Kernel {
        name: "gemm",
        about: "residues of the panel: a^H b",
        size: [1601, 40, 2618],
        flop: gemm,
        work: product,
    },
    Kernel {
        name: "gemm",
        about: "normal matrix of refinement: a^H b",
        size: [1601, 80, 80],
        flop: gemm,
        work: product,
    },
    Kernel {
        name: "gemm",
        about: "field of a drive: a b",
        size: [345, 34, 34],
        flop: |[m, n, k]| 8.0 * m * n * k,
        work: forward,
    },
    Kernel {
        name: "qr",
        about: "basis of a fit",
        size: [1601, 40, 0],
        flop: qr,
        work: orthogonal,
    },
    Kernel {
        name: "qr",
        about: "basis with derivatives",
        size: [2001, 80, 0],
        flop: qr,
        work: orthogonal,
    },
    Kernel {
        name: "qr-r",
        about: "one column of vector fitting",
        size: [1601, 88, 0],
        flop: qr,
        work: triangle,
    },
    Kernel {
        name: "svd",
        about: "CMIF, mobility of a scene",
        size: [77, 34, 0],
        flop: svd,
        work: singular,
    },
    Kernel {
        name: "svd",
        about: "compressed data",
        size: [120, 80, 0],
        flop: svd,
        work: singular,
    },
    Kernel {
        name: "eigh",
        about: "covariance of a fit",
        size: [80, 80, 0],
        flop: |[n, ..]| 4.0 * 9.0 * n * n * n,
        work: hermitian,
    },
    Kernel {
        name: "eig",
        about: "zeros of vector fitting",
        size: [40, 40, 0],
        flop: |[n, ..]| 4.0 * 10.0 * n * n * n,
        work: spectrum,
    },
    Kernel {
        name: "eig",
        about: "companion of a matrix polynomial",
        size: [160, 160, 0],
        flop: |[n, ..]| 4.0 * 10.0 * n * n * n,
        work: spectrum,
    },
    Kernel {
        name: "lstsq",
        about: "residues by QR",
        size: [1601, 38, 80],
        flop: |sizes| qr(sizes) + gemm(sizes),
        work: least_squares,
    },
];

fn gemm([m, n, k]: [f64; 3]) -> f64 {
    8.0 * m * n * k
}

fn qr([m, n, _]: [f64; 3]) -> f64 {
    8.0 * n * n * (m - n / 3.0)
}

fn svd([m, n, _]: [f64; 3]) -> f64 {
    4.0 * (4.0 * m * n * n + 8.0 * n * n * n)
}

fn product(back_end: &BackEnd, a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    let c = (back_end.matmul_h)(a.view(), b.view());
    // one entry by hand
    let by_hand: Complex64 = a
        .column(0)
        .iter()
        .zip(b.column(0))
        .map(|(a, b)| a.conj() * b)
        .sum();
    (c[[0, 0]] - by_hand).norm() / by_hand.norm()
}

fn forward(back_end: &BackEnd, a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    let b = b.slice(s![..a.ncols(), ..]);
    let c = (back_end.matmul)(a.view(), b);
    let by_hand: Complex64 = a.row(0).iter().zip(b.column(0)).map(|(a, b)| a * b).sum();
    (c[[0, 0]] - by_hand).norm() / by_hand.norm()
}

fn orthogonal(back_end: &BackEnd, a: &Array2<Complex64>, _: &Array2<Complex64>) -> f64 {
    let (q, r) = (back_end.qr_thin)(a.view());
    let column: Complex64 = q
        .row(0)
        .iter()
        .zip(r.column(r.ncols() - 1))
        .map(|(q, r)| q * r)
        .sum();
    (column - a[[0, a.ncols() - 1]]).norm() / a[[0, a.ncols() - 1]].norm()
}

fn triangle(back_end: &BackEnd, a: &Array2<Complex64>, _: &Array2<Complex64>) -> f64 {
    let r = (back_end.qr_r)(a.view());
    let lengths = [r.column(1), a.column(1)]
        .map(|column| column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt());
    (lengths[0] / lengths[1] - 1.0).abs()
}

fn singular(back_end: &BackEnd, a: &Array2<Complex64>, _: &Array2<Complex64>) -> f64 {
    let values = (back_end.svd_thin)(a.view())
        .map(|(_, values, _)| values.iter().map(|s| s * s).sum::<f64>());
    values.map_or(f64::NAN, |sum| {
        (sum / a.iter().map(|v| v.norm_sqr()).sum::<f64>() - 1.0).abs()
    })
}

fn hermitian(back_end: &BackEnd, a: &Array2<Complex64>, _: &Array2<Complex64>) -> f64 {
    let symmetric = Array2::from_shape_fn(a.dim(), |(i, j)| a[[i, j]] + a[[j, i]].conj());
    let trace: f64 = symmetric.diag().iter().map(|v| v.re).sum();
    (back_end.eigh)(symmetric.view()).map_or(f64::NAN, |(values, _)| {
        (values.sum() - trace).abs() / a.nrows() as f64
    })
}

fn spectrum(back_end: &BackEnd, a: &Array2<Complex64>, _: &Array2<Complex64>) -> f64 {
    let trace: Complex64 = a.diag().iter().sum();
    (back_end.eigenvalues)(a.view()).map_or(f64::NAN, |values| {
        (values.iter().sum::<Complex64>() - trace).norm() / a.nrows() as f64
    })
}

fn least_squares(back_end: &BackEnd, a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    let (q, r) = (back_end.qr_thin)(a.view());
    let x = (back_end.solve_upper)(r.view(), (back_end.matmul_h)(q.view(), b.view()).view());
    // the residual is orthogonal to the first column of a
    let left = &b.column(0) - &a.dot(&x.column(0));
    let inner: Complex64 = a
        .column(0)
        .iter()
        .zip(&left)
        .map(|(a, r)| a.conj() * r)
        .sum();
    inner.norm() / a.nrows() as f64
}

/// One kernel with one back end.
#[derive(Debug, Clone)]
pub struct KernelRow {
    /// Kernel.
    pub kernel: &'static str,
    /// Back end.
    pub backend: &'static str,
    /// Rows × columns, and × columns of the other matrix.
    pub size: String,
    /// The use of it.
    pub about: &'static str,
    /// Seconds: median, least, third quartile.
    pub time_s: [f64; 3],
    /// Real operations of the textbook algorithm over the least time, 1/s: other users of
    /// the machine only make times longer.
    pub flop_per_s: f64,
    /// Departure from an identity that the result must fulfil, relative.
    pub residual: f64,
    /// Times it was run.
    pub repeats: usize,
}

/// Times every kernel with every back end that is linked in, by turns, on one thread.
pub fn kernels(quick: bool, progress: &dyn Fn(&str)) -> Vec<KernelRow> {
    let back_ends = back_ends();
    let mut countdown = Countdown::new(KERNELS.len(), progress);
    let least_s = if quick { QUICK_S } else { LEAST_S };
    let mut rows = Vec::new();
    for kernel in &KERNELS {
        let [m, n, k] = kernel.size;
        let size = if k > 0 {
            format!("{m}x{n}x{k}")
        } else {
            format!("{m}x{n}")
        };
        countdown.next(&format!("{} {size}", kernel.name), false);
        let (a, b) = (random(m, n, 1), random(m, k, 2));
        let mut times: Vec<Vec<f64>> = vec![Vec::new(); back_ends.len()];
        let residuals: Vec<f64> = back_ends
            .iter()
            .map(|back_end| (kernel.work)(back_end, &a, &b))
            .collect();
        let start = Instant::now();
        // by turns: what slows the machine down slows both
        while times[0].len() < LEAST_REPEATS
            || start.elapsed().as_secs_f64() < least_s * back_ends.len() as f64
        {
            for (back_end, times) in back_ends.iter().zip(&mut times) {
                let clock = Instant::now();
                std::hint::black_box((kernel.work)(back_end, &a, &b));
                times.push(clock.elapsed().as_secs_f64());
            }
        }
        rows.extend(back_ends.iter().zip(times).zip(residuals).map(
            |((back_end, times), residual)| KernelRow {
                kernel: kernel.name,
                backend: back_end.name,
                size: size.clone(),
                about: kernel.about,
                time_s: [
                    median(&times),
                    quantile(&times, 0.0),
                    quantile(&times, 0.75),
                ],
                flop_per_s: (kernel.flop)([m as f64, n as f64, k as f64]) / quantile(&times, 0.0),
                residual,
                repeats: times.len(),
            },
        ));
    }
    rows
}

/// Circular complex Gaussian entries, column-major.
fn random(rows: usize, columns: usize, seed: u64) -> Array2<Complex64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    Array2::from_shape_simple_fn((rows, columns).f(), || Complex64::new(normal(), normal()))
}

/// The rows as CSV.
pub fn kernels_csv(rows: &[KernelRow]) -> String {
    let header = [
        "kernel",
        "backend",
        "size",
        "time_s",
        "time_least_s",
        "time_third_quartile_s",
        "gflop_per_s",
        "residual",
        "repeats",
        "about",
    ];
    let cells = rows.iter().map(|row| {
        let names = [row.kernel, row.backend, row.size.as_str()].map(String::from);
        let numbers = [
            row.time_s[0],
            row.time_s[1],
            row.time_s[2],
            1e-9 * row.flop_per_s,
            row.residual,
        ]
        .map(csv::number);
        names
            .into_iter()
            .chain(numbers)
            .chain([row.repeats.to_string(), row.about.to_owned()])
            .collect()
    });
    csv::table(
        "complex kernels on one thread, back ends by turns; residual: departure from an \
                identity of the result",
        &header,
        cells,
    )
}

/// Speed of each kernel, one mark for each back end.
pub fn kernels_figure(rows: &[KernelRow]) -> Figure {
    let label = |row: &KernelRow| format!("{} {}", row.kernel, row.size);
    let names = distinct(rows.iter().map(label));
    let count = names.len() as f64;
    let height = |k: usize| count - 1.0 - k as f64;
    let place = |row: &KernelRow| {
        let name = label(row);
        height(names.iter().position(|other| *other == name).unwrap_or(0))
    };
    let ticks = (0..names.len())
        .map(|k| (height(k), String::new()))
        .collect();
    let fastest = rows
        .iter()
        .map(|row| 1e-9 * row.flop_per_s)
        .fold(0.0, f64::max);
    let mut chart = Chart::new(
        Axis::linear(
            "Speed, operations of the textbook algorithm over the least time",
            "Gflop/s",
        )
        .range([0.0, 1.45 * fastest]),
        Axis::linear("Kernel", "rows × columns")
            .range([-0.6, count - 0.4])
            .names(ticks),
    )
    .height(Height::Px(26.0 * count));
    for backend in distinct(rows.iter().map(|row| row.backend)) {
        let points = rows
            .iter()
            .filter(|row| row.backend == backend)
            .map(|row| [1e-9 * row.flop_per_s, place(row)])
            .collect();
        let (mark, colour) = if backend == rows[0].backend {
            (Mark::Dot, Colour::Series(0))
        } else {
            (Mark::Ring, Colour::Ink)
        };
        chart = chart.marks(backend, points, mark, colour, 10.0);
    }
    for (k, name) in names.iter().enumerate() {
        chart = chart.with(Layer::Words {
            at: [1.43 * fastest, height(k)],
            text: name.clone(),
            anchor: Anchor::End,
            bold: false,
        });
    }
    Figure {
        name: "solvers".into(),
        title: "Kernels at the sizes of a fit".into(),
        caption: "Complex double precision on one thread, back ends by turns in one run.".into(),
        width: 720.0,
        charts: vec![chart],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kernel_gives_what_its_identity_asks_for() {
        for kernel in &KERNELS {
            let [m, n, k] = kernel.size;
            for back_end in back_ends() {
                let residual = (kernel.work)(&back_end, &random(m, n, 1), &random(m, k, 2));
                assert!(
                    residual < 1e-10,
                    "{} {:?} {}: {residual}",
                    kernel.name,
                    kernel.size,
                    back_end.name
                );
            }
        }
    }
}
