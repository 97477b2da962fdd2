//! Second and last pass over the data: everything that poles *and* all residues need (theory.md, eq. 13–15).
//!
//! With Q an orthonormal basis of the model, R₀ = QᴴB and T = B·R₀ᵀ (real and imaginary parts apart, so that every mixture
//! of FRFs stays real and both damping laws can use it): the columns of T·(R₀R₀ᵀ)^{-1/2} carry what the poles need at the
//! signal-to-noise ratio of the whole set, and the residues of any nearby poles follow from them.

use crate::screen::Screened;
use crate::tolerances as tol;
use crate::work::Work;
use chladni_linalg::{eigh, matmul, matmul_h, LinalgError};
use ndarray::{s, Array1, Array2, ArrayView2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// What the second pass leaves.
#[derive(Debug, Clone)]
pub(crate) struct Projected {
    /// Compressed columns, real mixtures of FRFs: at most twice as many as the model has unknowns.
    pub work: Work,
    /// (compressed column, FRF), real: B ≈ work.b · back on what the model can reach.
    pub back: Array2<f64>,
    /// Residual energy of each line over all FRFs at the poles of Q.
    pub line_residual: Array1<f64>,
}

/// Real and imaginary part stacked: (2·lines, columns).
fn stacked(a: ArrayView2<Complex64>) -> Array2<f64> {
    let n = a.nrows();
    let mut out = Array2::zeros((2 * n, a.ncols()).f());
    out.slice_mut(s![..n, ..]).assign(&a.mapv(|v| v.re));
    out.slice_mut(s![n.., ..]).assign(&a.mapv(|v| v.im));
    out
}

/// Runs the pass with basis `q` on all FRFs; `line_energy` comes from the first pass.
pub(crate) fn project(data: &Screened, q: &Array2<Complex64>, line_energy: &Array1<f64>) -> Result<Projected, LinalgError> {
    let (lines, total, m) = (data.lines.len(), data.pairs.len(), 2 * q.ncols());
    let mut basis = Array2::zeros((2 * lines, m).f());
    basis.slice_mut(s![.., ..m / 2]).assign(&stacked(q.view()));
    basis.slice_mut(s![.., m / 2..]).assign(&stacked(q.mapv(|v| v * Complex64::i()).view()));

    let group = total.div_ceil(tol::PASS_GROUPS).max(1);
    let groups: Vec<std::ops::Range<usize>> = (0..total).step_by(group).map(|a| a..(a + group).min(total)).collect();
    let parts: Vec<(Array2<f64>, Array2<f64>)> = groups
        .par_iter()
        .map(|columns| {
            let mut r0 = Array2::zeros((m, columns.len()).f());
            let mut t = Array2::<f64>::zeros((2 * lines, m).f());
            for a in columns.clone().step_by(tol::BLOCK_FRFS) {
                let b = (a + tol::BLOCK_FRFS).min(columns.end);
                let block = stacked(data.block(a..b, 0..lines).view());
                let inside = matmul_h(basis.view(), block.view());
                t += &matmul(block.view(), inside.t());
                r0.slice_mut(s![.., a - columns.start..b - columns.start]).assign(&inside);
            }
            (r0, t)
        })
        .collect();
    let mut r0 = Array2::zeros((m, total).f());
    let mut t = Array2::<f64>::zeros((2 * lines, m).f());
    for (columns, (r, part)) in groups.into_iter().zip(parts) {
        r0.slice_mut(s![.., columns]).assign(&r);
        t += &part;
    }
    let g = matmul(r0.view(), r0.t());
    let line_residual = line_residual(&basis, &t, &g, line_energy);
    // G^{-1/2} on the directions that carry anything
    let (values, vectors) = eigh(g.view())?;
    let largest = values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..m).filter(|&i| values[i] > tol::GRAM_ROUNDING * largest).collect();
    let half = Array2::from_shape_fn((m, kept.len()).f(), |(i, c)| vectors[[i, kept[c]]] / values[kept[c]].sqrt());
    let columns = matmul(t.view(), half.view());
    let b = Array2::from_shape_fn((lines, kept.len()).f(), |(k, c)| Complex64::new(columns[[k, c]], columns[[lines + k, c]]));
    Ok(Projected { work: Work { x: data.x.clone(), g: data.g.clone(), b }, back: matmul_h(half.view(), r0.view()), line_residual })
}

/// Energy per line of B − QR₀ from T = BR₀ᵀ and G = R₀R₀ᵀ, all stacked.
fn line_residual(basis: &Array2<f64>, t: &Array2<f64>, g: &Array2<f64>, energy: &Array1<f64>) -> Array1<f64> {
    let qg = matmul(basis.view(), g.view());
    let lines = energy.len();
    let row = |k: usize| -> f64 {
        let q = basis.row(k);
        q.iter().zip(qg.row(k)).zip(t.row(k)).map(|((a, model), cross)| a * (model - 2.0 * cross)).sum()
    };
    Array1::from_shape_fn(lines, |k| (energy[k] + row(k) + row(lines + k)).max(0.0))
}
