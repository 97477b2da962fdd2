//! Matrix fractions in the z plane by fast Fourier transforms: what [`super::lscf`] and
//! [`super::plscf`] share.
//!
//! Each output o (a row of r columns of data, one per reference) is modelled as H_o =
//! B_o(z)·A(z)⁻¹ with one r × r denominator for all outputs and z = e^{jθ}. The equation
//! error B_o − H_o·A is linear:
//!
//! ```text
//! min Σ_o Σ_k ‖ Σ_p z_k^p b_op − Σ_p z_k^p H_o(k) A_p ‖²
//! X_p = z^p,  Y_pi = −z^p H_oi:   R = XᴴX,  S_o = XᴴY_o,  T = Σ_o Y_oᴴY_o,   M = T − Σ_o S_oᴴR⁻¹S_o
//! ```
//!
//! (theory.md, eq. 39–40). On even lines every entry depends on the difference of its two
//! powers alone, so one Fourier transform per column (and per pair of references) makes
//! all of them. Coefficients are complex, so that each pole counts once, without its
//! conjugate; numerators keep the full degree. The lines cover two thirds of the unit
//! circle ([`GAP`]): the powers stay well conditioned over the long arc, and the gap is
//! where the model may turn from the last line back to the first.
//!
//! The constraint A_0 = I on the lowest power sends the poles that noise makes outside
//! the circle, where they are unstable, and leaves the stable ones to the structure
//! (Cauberghe, Guillaume, Verboven, Vanlanduit, Parloo, Mech. Syst. Signal Process. 19
//! (2005) 989–998). The Cholesky factor of M holds all lower orders too.
//!
//! Cost: 8·n³·r²·outputs flop for order n, 25·(nr)³ for the eigenvalues at each order.

use super::limits::{GAP, MOST_RIDGE, OUTPUTS_TOGETHER, RIDGE, RIDGE_UP, SPARSEST, UNEVEN};
use crate::data::error::FitError;
use crate::data::options::Method;
use crate::methods::survey::Survey;
use chladni_linalg::fft::{self, Fft};
use chladni_linalg::{
    cholesky, eigenvalues, matmul_h, solve_lower, solve_lower_adjoint, LinalgError,
};
use ndarray::{s, Array2, Array3, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Lines as points of the unit circle.
#[derive(Debug, Clone)]
pub(crate) struct UnitCircle {
    /// Place of each line on the grid.
    at: Vec<usize>,
    /// Points of the circle.
    points: usize,
    /// ω/ω_max of the first line, and from one point to the next.
    first: f64,
    spacing: f64,
}

impl UnitCircle {
    /// Lays the lines on the circle.
    ///
    /// # Errors
    /// [`FitError::UnevenAxis`] where they lie on no even grid.
    pub fn new(survey: &Survey, method: Method) -> Result<Self, FitError> {
        let data = survey.data;
        let f = &data.line_hz;
        let (low_hz, high_hz) = (f[0], f[f.len() - 1]);
        let smallest = f
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(f64::INFINITY, f64::min);
        let steps = ((high_hz - low_hz) / smallest).round();
        let uneven = FitError::UnevenAxis {
            method,
            low_hz,
            high_hz,
        };
        if !(1.0..=(SPARSEST * f.len()) as f64).contains(&steps) {
            return Err(uneven);
        }
        let spacing = (high_hz - low_hz) / steps;
        let at: Vec<usize> = f
            .iter()
            .map(|f| ((f - low_hz) / spacing).round() as usize)
            .collect();
        if f.iter()
            .zip(&at)
            .any(|(f, &k)| (f - low_hz - k as f64 * spacing).abs() > UNEVEN * spacing)
        {
            return Err(uneven);
        }
        let per_omega_max = TAU / data.omega_max;
        let points = ((steps + 1.0) * (1.0 + GAP)).ceil() as usize;
        Ok(Self {
            at,
            points,
            first: low_hz * per_omega_max,
            spacing: spacing * per_omega_max,
        })
    }

    /// s/ω_max of a pole on the z plane; the cut lies in the middle of the gap.
    fn pole(&self, z: Complex64) -> Complex64 {
        let cut = 0.5 * GAP / (1.0 + GAP) * TAU;
        let angle = (z.arg() + cut).rem_euclid(TAU) - cut;
        let per_angle = self.points as f64 / TAU * self.spacing;
        Complex64::new(z.norm().ln() * per_angle, self.first + angle * per_angle)
    }

    /// Σ_k v_k z_k^d for all d modulo the points of the circle.
    fn transform(
        &self,
        values: impl Iterator<Item = Complex64>,
        fft: &dyn Fft<f64>,
    ) -> Vec<Complex64> {
        let mut buffer = vec![Complex64::default(); self.points];
        self.at.iter().zip(values).for_each(|(&k, v)| buffer[k] = v);
        fft.process(&mut buffer);
        buffer
    }

    fn lag(&self, from: usize, to: usize) -> usize {
        (to + self.points - from) % self.points
    }
}

/// Largest value on the diagonal.
fn largest(matrix: &Array2<Complex64>) -> f64 {
    matrix.diag().iter().fold(0.0_f64, |most, v| most.max(v.re))
}

/// Cholesky factor with the least ridge that makes the matrix positive definite; `whole`: its
/// [`largest`] before anything was taken off, whose rounding is left where all was.
fn factored(mut matrix: Array2<Complex64>, whole: f64) -> Result<Array2<Complex64>, LinalgError> {
    let scale = largest(&matrix).max(f64::EPSILON.sqrt() * whole);
    let mut ridge = RIDGE * scale;
    loop {
        matrix.diag_mut().mapv_inplace(|v| v + ridge);
        match cholesky(matrix.view()) {
            Err(LinalgError::NotPositiveDefinite { .. }) if ridge < MOST_RIDGE * scale => {
                ridge *= RIDGE_UP
            }
            result => return result,
        }
    }
}

/// The reduced normal equations of one denominator.
#[derive(Debug)]
pub(crate) struct MatrixFraction {
    circle: UnitCircle,
    references: usize,
    /// Coefficients A_1 … A_n have this Cholesky factor; lower orders are its leading
    /// parts.
    factor: Array2<Complex64>,
    /// Their right-hand side −M_10, solved by the factor once.
    halfway: Array2<Complex64>,
}

impl MatrixFraction {
    /// Normal equations up to order `order`.
    ///
    /// * `data`: axes (output, line, reference), in any scale
    ///
    /// # Errors
    /// A decomposition that fails.
    pub fn new(
        circle: UnitCircle,
        data: &Array3<Complex64>,
        order: usize,
    ) -> Result<Self, LinalgError> {
        let (outputs, lines, r) = data.dim();
        let size = r * (order + 1);
        let fft = fft::inverse(circle.points);
        let ones = circle.transform((0..lines).map(|_| Complex64::new(1.0, 0.0)), &*fft);
        let basis = Array2::from_shape_fn((order + 1, order + 1), |(p, q)| ones[circle.lag(p, q)]);
        let whole = largest(&basis);
        let l = factored(basis, whole)?;

        let mut m = Array2::zeros((size, size).f());
        for (i, j) in (0..r).flat_map(|i| (0..r).map(move |j| (i, j))) {
            let power = (0..lines).map(|k| {
                (0..outputs)
                    .map(|o| data[[o, k, i]].conj() * data[[o, k, j]])
                    .sum()
            });
            let t = circle.transform(power, &*fft);
            for (p, q) in (0..=order).flat_map(|p| (0..=order).map(move |q| (p, q))) {
                m[[p * r + i, q * r + j]] = t[circle.lag(p, q)];
            }
        }
        let whole = largest(&m);
        for first in (0..outputs).step_by(OUTPUTS_TOGETHER) {
            let parts: Vec<Array2<Complex64>> = (first..(first + OUTPUTS_TOGETHER).min(outputs))
                .into_par_iter()
                .map(|o| -> Result<Array2<Complex64>, LinalgError> {
                    let mut s = Array2::zeros((order + 1, size).f());
                    for i in 0..r {
                        let h =
                            circle.transform(data.slice(s![o, .., i]).iter().map(|v| -v), &*fft);
                        for (p, q) in (0..=order).flat_map(|p| (0..=order).map(move |q| (p, q))) {
                            s[[p, q * r + i]] = h[circle.lag(p, q)];
                        }
                    }
                    let w = solve_lower(l.view(), s.view())?;
                    Ok(matmul_h(w.view(), w.view()))
                })
                .collect::<Result<_, _>>()?;
            parts.iter().for_each(|part| m -= part);
        }
        let factor = factored(m.slice(s![r.., r..]).to_owned(), whole)?;
        let halfway = solve_lower(factor.view(), m.slice(s![r.., ..r]).mapv(|v| -v).view())?;
        Ok(Self {
            circle,
            references: r,
            factor,
            halfway,
        })
    }

    /// Highest order.
    pub fn order(&self) -> usize {
        self.factor.nrows() / self.references
    }

    /// Poles s/ω_max of the denominator of order `order`, either sign of damping: det
    /// A(z) = 0, as eigenvalues 1/z of the block companion matrix of 1 + A_1 z + … + A_n
    /// z^n.
    ///
    /// # Errors
    /// Eigenvalues that do not converge.
    pub fn poles(&self, order: usize) -> Result<Vec<Complex64>, LinalgError> {
        let (r, size) = (self.references, self.references * order);
        let factor = self.factor.slice(s![..size, ..size]);
        let coefficients = solve_lower_adjoint(factor, self.halfway.slice(s![..size, ..]))?;
        let mut companion = Array2::zeros((size, size).f());
        for (p, block) in coefficients.axis_chunks_iter(Axis(0), r).enumerate() {
            companion
                .slice_mut(s![..r, p * r..(p + 1) * r])
                .assign(&block.mapv(|v| -v));
        }
        for below in r..size {
            companion[[below, below - r]] = Complex64::new(1.0, 0.0);
        }
        let inverse = eigenvalues(companion.view())?;
        Ok(inverse
            .iter()
            .filter(|w| w.norm() > f64::EPSILON)
            .map(|w| self.circle.pole(w.inv()))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(at: Vec<usize>) -> UnitCircle {
        UnitCircle {
            at,
            points: 300,
            first: 0.1,
            spacing: 0.004,
        }
    }

    /// s of two decaying exponentials, which are rational in z exactly.
    const POLES: [Complex64; 2] = [Complex64::new(-0.01, 0.3), Complex64::new(-0.02, 0.71)];

    /// Σ_n ψ_on L_nr/(z − z_n) on the lines, axes (output, line, reference).
    fn data(circle: &UnitCircle, references: usize) -> Array3<Complex64> {
        let z = |s: Complex64| {
            ((s - Complex64::new(0.0, circle.first))
                * (TAU / (circle.points as f64 * circle.spacing)))
                .exp()
        };
        Array3::from_shape_fn((3, circle.at.len(), references), |(o, k, r)| {
            let at = Complex64::from_polar(1.0, TAU * circle.at[k] as f64 / circle.points as f64);
            let term = |n: usize| {
                Complex64::new((1.0 + o as f64 * (n as f64 + 0.3)).sin(), 0.2)
                    * (0.7 + r as f64 - 1.1 * n as f64)
            };
            (0..2).map(|n| term(n) / (at - z(POLES[n]))).sum()
        })
    }

    fn worst(found: &[Complex64]) -> f64 {
        POLES
            .iter()
            .map(|s| {
                found
                    .iter()
                    .map(|f| (f - s).norm())
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn exponentials_are_found_at_their_own_order() {
        let gaps: Vec<usize> = (0..200).filter(|k| k % 17 != 3).collect();
        for at in [(0..200).collect(), gaps] {
            let circle = circle(at);
            let single = MatrixFraction::new(circle.clone(), &data(&circle, 1), 6).unwrap();
            assert_eq!(single.order(), 6);
            assert!(worst(&single.poles(2).unwrap()) < 1e-6);
            let double = MatrixFraction::new(circle.clone(), &data(&circle, 2), 4).unwrap();
            assert_eq!(double.poles(1).unwrap().len(), 2);
            assert!(worst(&double.poles(1).unwrap()) < 1e-6);
        }
    }

    #[test]
    fn poles_beyond_the_order_of_the_structure_are_unstable() {
        let circle = circle((0..200).collect());
        let fraction = MatrixFraction::new(circle.clone(), &data(&circle, 1), 12).unwrap();
        let stable: Vec<Complex64> = fraction
            .poles(12)
            .unwrap()
            .into_iter()
            .filter(|s| s.re < 0.0)
            .collect();
        assert_eq!(stable.len(), 2, "{stable:?}");
        assert!(worst(&stable) < 1e-6);
    }

    #[test]
    fn angles_and_poles_correspond() {
        let circle = circle((0..200).collect());
        for s in [
            POLES[0],
            Complex64::new(0.01, 0.05),
            Complex64::new(-0.3, 0.95),
        ] {
            let z = ((s - Complex64::new(0.0, circle.first))
                * (TAU / (circle.points as f64 * circle.spacing)))
                .exp();
            assert!((circle.pole(z) - s).norm() < 1e-13);
        }
    }
}
