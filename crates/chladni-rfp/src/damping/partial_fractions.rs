//! Inner products of pole columns by partial fractions: one sum over lines for each pole in place of
//! one for each pair.
//!
//! 1/((ā − x)(b − x)) = [1/(ā − x) − 1/(b − x)]/(b − ā), and derivatives of that. Among the lines no
//! digit is lost: ā lies below the real axis and b above, however near a and b are. Beyond them
//! products of derivatives lose the square of the distance over the half-bandwidth.
//!
//! A viscous column has partial fractions on the axis y = √x = ω/ω_max. Its denominator
//! Re λ + j·Im λ·y/√Re λ − y² has two zeros, y₁ and y₂ = −ȳ₁, both on the same side of the axis. The
//! column and its derivatives are mixtures of 1/(y₁ − y), 1/(y₂ − y) and the derivatives of these.
//! These mixtures lose digits where the two zeros are near each other, as seen from most lines: see
//! [`keeps_digits`].

use crate::damping::columns::inverse;
use crate::damping::filled::fill;
use crate::damping::law::{is_rational, RATIONAL};
use crate::damping::limits;
use crate::data::columns::Columns;
use chladni_linalg::blocked::{blocked_gram, blocked_matmul_h};
use ndarray::{Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Inner products of structural pole columns and, if asked for, of their derivatives, which follow
/// them.
///
/// * `sums`: Σ g²/(λ − x) and, for derivatives, Σ g²/(λ − x)²
pub(super) fn rational_gram(
    lambda: &[Complex64],
    sums: &[[Complex64; 2]],
    derivatives: bool,
) -> Array2<Complex64> {
    let n = lambda.len();
    let all = if derivatives { 2 * n } else { n };
    let mut gram = Array2::zeros((all, all).f());
    for (q, (&b, of_b)) in lambda.iter().zip(sums).enumerate() {
        for (p, (a, of_a)) in lambda.iter().zip(sums).enumerate() {
            let over = inverse(b - a.conj());
            let [first, second] = of_a.map(|sum| sum.conj());
            let plain = (first - of_b[0]) * over;
            gram[[p, q]] = plain;
            if !derivatives {
                continue;
            }
            gram[[p, n + q]] = (of_b[1] - plain) * over;
            gram[[n + q, p]] = gram[[p, n + q]].conj();
            gram[[n + p, n + q]] = (second + of_b[1] - 2.0 * plain) * over * over;
        }
    }
    gram
}

/// A column of a viscous pole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// φ.
    Pole,
    /// −j·∂φ/∂Im λ.
    Loss,
    /// ∂φ/∂Re λ.
    Frequency,
}

/// True where partial fractions give the inner products of pole columns: without leakage, in the
/// structural law or for viscous poles that [keep their digits](keeps_digits).
pub(super) fn has_partial_fractions(work: &Columns, lambda: &[Complex64]) -> bool {
    let in_law = is_rational(work.law) || lambda.iter().all(|pole| keeps_digits(work, *pole));
    in_law && work.leakage.is_none()
}

/// True for a viscous pole whose products keep their digits: of less than half of critical damping,
/// not near zero, and with a line within some half-bandwidths.
fn keeps_digits(work: &Columns, pole: Complex64) -> bool {
    let (_, high) = work.range();
    let is_light = 0.0 < pole.im && pole.im < pole.re;
    if !is_light || pole.re < limits::LEAST_PLACE * high {
        return false;
    }
    let Zeros { right, .. } = Zeros::new(pole);
    let after = work.x.partition_point(|x| *x < right.re * right.re);
    let mut beside = [after.checked_sub(1), Some(after)].into_iter().flatten();
    beside.any(|line| {
        let off = work.x.get(line).map(|x| (x.sqrt() - right.re).abs());
        off.is_some_and(|off| off <= limits::LINE_WITHIN * right.im)
    })
}

/// The zeros of the denominator of a light pole.
struct Zeros {
    pole: Complex64,
    /// The one on the right, y₁.
    right: Complex64,
    /// y₁ − y₂.
    apart: f64,
}

impl Zeros {
    fn new(pole: Complex64) -> Self {
        let loss = pole.im / pole.re.sqrt();
        let apart = (4.0 * pole.re - loss * loss).sqrt();
        Self {
            pole,
            right: 0.5 * Complex64::new(apart, loss),
            apart,
        }
    }

    fn left(&self) -> Complex64 {
        -self.right.conj()
    }

    /// Parts of a column along 1/(y₁ − y), 1/(y₂ − y) and the derivatives of these by y₁ and y₂.
    fn parts(&self, of: Kind) -> [Complex64; 4] {
        let (d, root) = (self.apart, self.pole.re.sqrt());
        let j = Complex64::I;
        match of {
            Kind::Pole => [1.0 / d, -1.0 / d, 0.0, 0.0].map(Complex64::from),
            Kind::Loss => {
                let own = j * (self.pole.im / (self.pole.re * d.powi(3)));
                let of_squares = 1.0 / (root * d * d);
                [-own, own, self.right * of_squares, self.left() * of_squares]
            }
            Kind::Frequency => {
                let along_loss = -j * (0.5 * self.pole.im / self.pole.re);
                let loss = self.parts(Kind::Loss).map(|part| along_loss * part);
                let square = 1.0 / (d * d);
                let plain = [-2.0 * square / d, 2.0 * square / d, square, square];
                std::array::from_fn(|k| loss[k] + plain[k])
            }
        }
    }
}

/// Inner products of viscous columns that are written already, as [`viscous_gram`] has them: by
/// partial fractions, and by themselves for poles whose products would lose digits.
///
/// * `columns`: (line, ·), all of the first kind, then all of the second, and so on
pub(super) fn viscous_gram_of(
    work: &Columns,
    lambda: &[Complex64],
    kinds: &[Kind],
    columns: &Array2<Complex64>,
) -> Array2<Complex64> {
    let n = lambda.len();
    let direct: Vec<usize> = (0..columns.ncols())
        .filter(|c| !keeps_digits(work, lambda[c % n]))
        .collect();
    if work.leakage.is_some() || 2 * direct.len() > columns.ncols() {
        return blocked_gram(columns.view());
    }
    let mut gram = viscous_gram(work, lambda, kinds);
    let products = blocked_matmul_h(columns.view(), columns.select(Axis(1), &direct).view());
    for (&c, products) in direct.iter().zip(products.columns()) {
        gram.column_mut(c).assign(&products);
        gram.row_mut(c).assign(&products.mapv(|v| v.conj()));
    }
    gram
}

/// Inner products of these columns of poles that [keep their digits](keeps_digits): all of the first
/// kind, then all of the second, and so on.
pub(super) fn viscous_gram(
    work: &Columns,
    lambda: &[Complex64],
    kinds: &[Kind],
) -> Array2<Complex64> {
    let (n, lines) = (lambda.len(), work.lines());
    let zeros: Vec<Zeros> = lambda.iter().map(|pole| Zeros::new(*pole)).collect();
    let right = zeros.iter().map(|zeros| zeros.right);
    let places: Vec<Complex64> = right.chain(zeros.iter().map(Zeros::left)).collect();
    let axis = Columns {
        x: work.x.iter().map(|x| x.sqrt()).collect(),
        g: work.g.clone(),
        b: Array2::zeros((lines, 0)),
        law: RATIONAL,
        leakage: None,
        neighbours: 0.0,
    };
    let sums: Vec<_> = places
        .par_iter()
        .map_init(
            || vec![Complex64::ZERO; 2 * lines],
            |memory, place| {
                let (column, derivative) = memory.split_at_mut(lines);
                fill(&axis, *place, column, Some(derivative))
            },
        )
        .collect();
    let of_zeros = rational_gram(&places, &sums, true);
    let parts: Vec<Vec<[Complex64; 4]>> = zeros
        .iter()
        .map(|zeros| kinds.iter().map(|of| zeros.parts(*of)).collect())
        .collect();
    let mut gram = Array2::zeros((kinds.len() * n, kinds.len() * n).f());
    for q in 0..n {
        for p in 0..n {
            for (k, of_q) in parts[q].iter().enumerate() {
                let along = |row: usize| -> Complex64 {
                    (0..4).map(|c| of_zeros[[row, c * n + q]] * of_q[c]).sum()
                };
                let along: [Complex64; 4] = std::array::from_fn(|r| along(r * n + p));
                for (i, of_p) in parts[p].iter().enumerate() {
                    gram[[i * n + p, k * n + q]] = (0..4).map(|r| of_p[r].conj() * along[r]).sum();
                }
            }
        }
    }
    gram
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Damping;
    use chladni_linalg::matmul_h;

    /// Lines of FRFs whose kind is the receptance times so many powers of jω.
    fn lines(first: f64, kind: i32) -> Columns {
        let step = (1.0 - first) / 399.0;
        let y: Vec<f64> = (0..400).map(|k| first + step * f64::from(k)).collect();
        Columns {
            g: y.iter().map(|y| y.powi(kind)).collect(),
            x: y.iter().map(|y| y * y).collect(),
            b: Array2::zeros((400, 0)),
            law: Damping::Viscous,
            leakage: None,
            neighbours: 0.0,
        }
    }

    const KINDS: [Kind; 3] = [Kind::Pole, Kind::Loss, Kind::Frequency];

    /// The columns themselves.
    fn columns(work: &Columns, lambda: &[Complex64]) -> Array2<Complex64> {
        let n = lambda.len();
        Array2::from_shape_fn((work.lines(), 3 * n).f(), |(k, c)| {
            let (pole, y) = (lambda[c % n], work.x[k].sqrt());
            let loss = y / pole.re.sqrt();
            let over = 1.0 / Complex64::new(pole.re - y * y, pole.im * loss);
            work.g[k]
                * match KINDS[c / n] {
                    Kind::Pole => over,
                    Kind::Loss => -loss * over * over,
                    Kind::Frequency => {
                        -Complex64::new(1.0, -0.5 * pole.im * loss / pole.re) * over * over
                    }
                }
        })
    }

    /// The largest error of the products, over the norms of both columns.
    fn worst(columns: &Array2<Complex64>, gram: &Array2<Complex64>) -> f64 {
        let direct = matmul_h(columns.view(), columns.view());
        let errors = gram.indexed_iter().map(|((i, j), value)| {
            let size = (direct[[i, i]].re * direct[[j, j]].re).sqrt();
            (value - direct[[i, j]]).norm() / size
        });
        errors.fold(0.0, f64::max)
    }

    fn at(frequency: f64, loss_factor: f64) -> Complex64 {
        frequency * frequency * Complex64::new(1.0, loss_factor)
    }

    #[test]
    fn viscous_products_are_those_of_the_columns() {
        for (first, kind) in [(0.001, 3), (0.001, 2), (0.1, 1), (0.2, 0), (0.001, 0)] {
            let work = lines(first, kind);
            // narrower than a line, near a twin, at both ends, beyond the lines, heavy
            let lambda = [
                at(0.55, 3e-4),
                at(0.5502, 3e-4),
                at(0.55, 1e-2),
                at(first.max(0.1), 0.02),
                at(first.max(0.1), 0.021),
                at(1.0, 0.01),
                at(1.1, 0.01),
                at(0.45, 0.95),
            ];
            assert!(has_partial_fractions(&work, &lambda));
            let gram = viscous_gram(&work, &lambda, &KINDS);
            let error = worst(&columns(&work, &lambda), &gram);
            assert!(error < 1e-10, "{first} {kind}: {error}");
        }
    }

    /// Below the lines, near zero, far from all lines in half-bandwidths, of heavy damping.
    #[test]
    fn viscous_columns_whose_products_would_lose_digits_are_multiplied() {
        let gap = {
            let mut work = lines(0.1, 2);
            let kept = (0..400).filter(|k| !(150..250).contains(k));
            let kept: Vec<usize> = kept.collect();
            work.x = kept.iter().map(|&k| work.x[k]).collect();
            work.g = kept.iter().map(|&k| work.g[k]).collect();
            work.b = Array2::zeros((kept.len(), 0));
            work
        };
        let cases = [
            (lines(0.2, 2), at(0.09, 0.02), true),
            (lines(0.001, 2), at(0.0015, 0.02), true),
            (lines(0.2, 1), at(1.35, 1e-4), true),
            (gap, at(0.55, 1e-5), true),
            (lines(0.1, 1), at(0.5, 1.1), false),
            (lines(0.1, 1), at(0.5, 0.0), false),
            (lines(0.1, 1), at(0.5, -0.01), false),
        ];
        for (work, pole, loses) in cases {
            let lambda = [at(0.7, 0.01), pole, at(0.8, 0.02), at(0.9, 0.01)];
            assert!(!has_partial_fractions(&work, &lambda), "{pole}");
            let columns = columns(&work, &lambda);
            if loses {
                let error = worst(&columns, &viscous_gram(&work, &lambda, &KINDS));
                assert!(error > 1e-10, "{pole}: {error}");
            }
            let error = worst(&columns, &viscous_gram_of(&work, &lambda, &KINDS, &columns));
            assert!(error < 1e-11, "{pole}: {error}");
        }
    }
}
