//! Columns of poles written line by line: plain ones and their derivatives, in the law of the
//! lines, with what leaks where records leak.

use crate::damping::columns::LeakingColumn;
use crate::damping::limits::LANES;
use crate::data::columns::Columns;
use chladni_frf::Damping;
use chladni_linalg::wide;
use num_complex::Complex64;

/// Writes the column g/(λ − x) of a pole and, where it is asked for, its derivative, −g/(λ − x)²
/// in the structural law; returns Σ g²/(λ − x) and Σ g²/(λ − x)², the second with the derivative
/// alone, and neither where lines leak.
pub(super) fn fill(
    work: &Columns,
    pole: Complex64,
    column: &mut [Complex64],
    derivative: Option<&mut [Complex64]>,
) -> [Complex64; 2] {
    if let Some(leakage) = &work.leakage {
        let leaking = LeakingColumn::new(work.law, leakage, pole);
        let of_lines = work.x.iter().zip(&work.g);
        let of_lines = of_lines.map(|(&x, &g)| leaking.at(x).map(|v| v * g));
        let values = column.iter_mut().zip(of_lines);
        match derivative {
            None => values.for_each(|(value, [own, _])| *value = own),
            Some(derivative) => values
                .zip(derivative)
                .for_each(|((value, both), slope)| [*value, *slope] = both),
        }
        return [Complex64::ZERO; 2];
    }
    let over = 1.0 / pole.re.max(f64::MIN_POSITIVE);
    let of_law = |x: f64| (x * over).sqrt();
    wide(|| match (work.law, derivative) {
        (Damping::Structural, None) => in_lanes::<false>(work, pole, |_| 1.0, column, &mut []),
        (Damping::Structural, Some(to)) => in_lanes::<true>(work, pole, |_| 1.0, column, to),
        (Damping::Viscous, None) => in_lanes::<false>(work, pole, of_law, column, &mut []),
        (Damping::Viscous, Some(to)) => in_lanes::<true>(work, pole, of_law, column, to),
    })
}

/// Writes the columns g·x^p of residual terms, one after the other.
pub(super) fn fill_terms(work: &Columns, powers: &[i32], columns: &mut [Complex64]) {
    let columns = columns.chunks_mut(work.lines().max(1));
    for (column, &power) in columns.zip(powers) {
        for ((value, &x), &g) in column.iter_mut().zip(&work.x).zip(&work.g) {
            *value = (g * x.powi(power)).into();
        }
    }
}

/// Some lines at a time. `loss`: at x over that at the natural frequency.
#[inline(always)]
fn in_lanes<const BOTH: bool>(
    work: &Columns,
    pole: Complex64,
    loss: impl Fn(f64) -> f64,
    column: &mut [Complex64],
    derivative: &mut [Complex64],
) -> [Complex64; 2] {
    let mut sums = [[0.0; LANES]; 4];
    let mut of_lanes = |x: &[f64; LANES], g: &[f64; LANES]| {
        let (mut value, mut slope) = ([Complex64::ZERO; LANES], [Complex64::ZERO; LANES]);
        for l in 0..LANES {
            let (away, loss) = (pole.re - x[l], loss(x[l]));
            let lossy = pole.im * loss;
            let over = 1.0 / (away * away + lossy * lossy);
            let (re, im) = (away * over, -lossy * over);
            value[l] = Complex64::new(re * g[l], im * g[l]);
            sums[0][l] += value[l].re * g[l];
            sums[1][l] += value[l].im * g[l];
            if BOTH {
                let weight = -g[l] * loss;
                slope[l] = Complex64::new((re * re - im * im) * weight, 2.0 * re * im * weight);
                sums[2][l] -= slope[l].re * g[l];
                sums[3][l] -= slope[l].im * g[l];
            }
        }
        (value, slope)
    };
    let (x, last_x) = work.x.as_chunks();
    let (g, last_g) = work.g.as_chunks();
    let (columns, last_column) = column.as_chunks_mut();
    let (derivatives, last_derivative) = derivative.as_chunks_mut();
    for (k, column) in columns.iter_mut().enumerate() {
        let (value, slope) = of_lanes(&x[k], &g[k]);
        *column = value;
        if BOTH {
            derivatives[k] = slope;
        }
    }
    let rest = last_x.len();
    if rest > 0 {
        // what is beyond the last line weighs nothing
        let (mut x, mut g) = ([last_x[0]; LANES], [0.0; LANES]);
        x[..rest].copy_from_slice(last_x);
        g[..rest].copy_from_slice(last_g);
        let (value, slope) = of_lanes(&x, &g);
        last_column.copy_from_slice(&value[..rest]);
        if BOTH {
            last_derivative.copy_from_slice(&slope[..rest]);
        }
    }
    let [re, im, slope_re, slope_im] = sums.map(|lanes| lanes.iter().sum());
    [Complex64::new(re, im), Complex64::new(slope_re, slope_im)]
}
