//! The cones of a program and their scaling by Nesterov and Todd.
//!
//! A pair s, z inside the cones has one symmetric W with W·z = W⁻¹·s = λ. For a row that
//! must not be negative it is √(s/z); for a second-order cone, with J = diag(1, −1, …,
//! −1), η and w of wᵀJw = 1,
//!
//! W = η·[w₀, w₁ᵀ; w₁, I + w₁w₁ᵀ/(1+w₀)], W⁻¹ = J·W·J/η²
//!
//! (Vandenberghe, The CVXOPT linear and quadratic cone program solvers, 2010).

use std::ops::Range;

/// A cone of consecutive rows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cone {
    /// Each row by itself is not negative.
    NotNegative(Range<usize>),
    /// The first row is at least the norm of the others.
    Norm(Range<usize>),
}

/// The cones of all rows, in their order.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Cones(pub(crate) Vec<Cone>);

/// The scaling of a pair inside the cones.
pub(crate) struct Scaling {
    /// √(s/z) of rows by themselves, w of the other cones.
    w: Vec<f64>,
    /// η of each cone; 1 for rows by themselves.
    eta: Vec<f64>,
    /// W·z = W⁻¹·s.
    pub(crate) lambda: Vec<f64>,
}

impl Cone {
    /// Its rows.
    pub(crate) fn rows(&self) -> Range<usize> {
        match self {
            Self::NotNegative(rows) | Self::Norm(rows) => rows.clone(),
        }
    }
}

impl Cones {
    /// Number of eigenvalues of s∘z that are alike in the middle of the cones.
    pub(crate) fn degree(&self) -> f64 {
        let of = |cone: &Cone| match cone {
            Cone::NotNegative(rows) => rows.len(),
            Cone::Norm(_) => 1,
        };
        self.0.iter().map(of).sum::<usize>() as f64
    }

    /// Adds `factor` to every eigenvalue of `vector`.
    pub(crate) fn add_identity(&self, vector: &mut [f64], factor: f64) {
        for cone in &self.0 {
            match cone {
                Cone::NotNegative(rows) => {
                    let rows = &mut vector[rows.clone()];
                    rows.iter_mut().for_each(|value| *value += factor);
                }
                Cone::Norm(rows) => vector[rows.start] += factor,
            }
        }
    }

    /// The least eigenvalue of `vector`: positive inside the cones.
    pub(crate) fn least_eigenvalue(&self, vector: &[f64]) -> f64 {
        let of = |cone: &Cone| {
            let part = &vector[cone.rows()];
            match cone {
                Cone::NotNegative(_) => part.iter().copied().fold(f64::INFINITY, f64::min),
                Cone::Norm(_) => part[0] - norm(&part[1..]),
            }
        };
        self.0.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// u∘v.
    pub(crate) fn product(&self, u: &[f64], v: &[f64]) -> Vec<f64> {
        let mut product: Vec<f64> = u.iter().zip(v).map(|(u, v)| u * v).collect();
        for cone in &self.0 {
            if let Cone::Norm(rows) = cone {
                let first = rows.start;
                product[first] = dot(&u[rows.clone()], &v[rows.clone()]);
                for k in first + 1..rows.end {
                    product[k] = u[first] * v[k] + v[first] * u[k];
                }
            }
        }
        product
    }

    /// The x of λ∘x = `vector`.
    pub(crate) fn quotient(&self, vector: &[f64], lambda: &[f64]) -> Vec<f64> {
        let mut quotient: Vec<f64> = vector.iter().zip(lambda).map(|(v, l)| v / l).collect();
        for cone in &self.0 {
            if let Cone::Norm(rows) = cone {
                let (v, l) = (&vector[rows.clone()], &lambda[rows.clone()]);
                let first = (l[0] * v[0] - dot(&l[1..], &v[1..])) / square(l);
                let part = &mut quotient[rows.clone()];
                part[0] = first;
                for k in 1..l.len() {
                    part[k] = (v[k] - first * l[k]) / l[0];
                }
            }
        }
        quotient
    }

    /// The largest step from `lambda` along `direction` inside the cones; infinite where
    /// none leaves them.
    pub(crate) fn longest_step(&self, lambda: &[f64], direction: &[f64]) -> f64 {
        let of = |cone: &Cone| {
            let (l, d) = (&lambda[cone.rows()], &direction[cone.rows()]);
            match cone {
                Cone::NotNegative(_) => l.iter().zip(d).map(|(l, d)| -d / l).fold(0.0, f64::max),
                Cone::Norm(_) => {
                    // in the coordinates in which λ is the identity
                    let size = square(l).sqrt();
                    let along = (l[0] * d[0] - dot(&l[1..], &d[1..])) / size;
                    let share = (along + d[0]) / (l[0] + size);
                    let pairs = l[1..].iter().zip(&d[1..]);
                    let across: f64 = pairs.map(|(l, d)| (d - share * l).powi(2)).sum();
                    (across.sqrt() - along) / size
                }
            }
        };
        1.0 / self.0.iter().map(of).fold(0.0, f64::max)
    }

    /// The scaling of `s` and `z`, both inside.
    pub(crate) fn scaling(&self, s: &[f64], z: &[f64]) -> Scaling {
        let mut scaling = Scaling {
            w: s.iter().zip(z).map(|(s, z)| (s / z).sqrt()).collect(),
            eta: vec![1.0; self.0.len()],
            lambda: Vec::new(),
        };
        for (cone, eta) in self.0.iter().zip(&mut scaling.eta) {
            if let Cone::Norm(rows) = cone {
                let (s, z) = (&s[rows.clone()], &z[rows.clone()]);
                let (of_s, of_z) = (square(s).sqrt(), square(z).sqrt());
                let twice = (2.0 + 2.0 * dot(s, z) / (of_s * of_z)).sqrt();
                let w = &mut scaling.w[rows.clone()];
                w[0] = (s[0] / of_s + z[0] / of_z) / twice;
                for k in 1..s.len() {
                    w[k] = (s[k] / of_s - z[k] / of_z) / twice;
                }
                *eta = (of_s / of_z).sqrt();
            }
        }
        let mut lambda = z.to_vec();
        self.scale(&scaling, &mut lambda);
        Scaling { lambda, ..scaling }
    }

    /// vector ← W·vector.
    pub(crate) fn scale(&self, scaling: &Scaling, vector: &mut [f64]) {
        for (cone, &eta) in self.0.iter().zip(&scaling.eta) {
            let (w, v) = (&scaling.w[cone.rows()], &mut vector[cone.rows()]);
            match cone {
                Cone::NotNegative(_) => v.iter_mut().zip(w).for_each(|(v, w)| *v *= w),
                Cone::Norm(_) => mirror(w, v, 1.0, eta),
            }
        }
    }

    /// vector ← W⁻¹·vector.
    pub(crate) fn unscale(&self, scaling: &Scaling, vector: &mut [f64]) {
        for (cone, &eta) in self.0.iter().zip(&scaling.eta) {
            let (w, v) = (&scaling.w[cone.rows()], &mut vector[cone.rows()]);
            match cone {
                Cone::NotNegative(_) => v.iter_mut().zip(w).for_each(|(v, w)| *v /= w),
                Cone::Norm(_) => mirror(w, v, -1.0, 1.0 / eta),
            }
        }
    }
}

impl Scaling {
    /// √(s/z) of rows by themselves, w of a second-order cone.
    pub(crate) fn w(&self, cone: &Cone) -> &[f64] {
        &self.w[cone.rows()]
    }

    /// η of a cone.
    pub(crate) fn eta(&self, cone: usize) -> f64 {
        self.eta[cone]
    }
}

/// Entry (i, j) of W⁻¹ of a second-order cone.
pub(crate) fn inverse_entry(w: &[f64], eta: f64, i: usize, j: usize) -> f64 {
    let of_unit = match (i, j) {
        (0, 0) => w[0],
        (0, k) | (k, 0) => -w[k],
        (i, j) => f64::from(u8::from(i == j)) + w[i] * w[j] / (1.0 + w[0]),
    };
    of_unit / eta
}

/// v ← factor·[w₀, ±w₁ᵀ; ±w₁, I + w₁w₁ᵀ/(1+w₀)]·v.
fn mirror(w: &[f64], v: &mut [f64], sign: f64, factor: f64) {
    let across = dot(&w[1..], &v[1..]);
    let share = sign * v[0] + across / (1.0 + w[0]);
    v[0] = factor * (w[0] * v[0] + sign * across);
    for (v, w) in v[1..].iter_mut().zip(&w[1..]) {
        *v = factor * (*v + share * w);
    }
}

/// vᵀJv of a vector inside a second-order cone.
fn square(v: &[f64]) -> f64 {
    let across = norm(&v[1..]);
    (v[0] - across) * (v[0] + across)
}

/// √Σv².
pub(crate) fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

/// Σab, in eight sums side by side.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (parts_a, parts_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = parts_a.remainder().iter().zip(parts_b.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 8];
    for (a, b) in parts_a.zip(parts_b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cones() -> Cones {
        Cones(vec![Cone::NotNegative(0..2), Cone::Norm(2..5)])
    }

    const S: [f64; 5] = [0.3, 2.0, 1.7, -0.4, 1.2];
    const Z: [f64; 5] = [1.1, 0.2, 2.0, 1.9, 0.3];

    fn assert_near(a: &[f64], b: &[f64]) {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_scaling_brings_both_of_a_pair_to_the_same_place() {
        let scaling = cones().scaling(&S, &Z);
        let mut of_s = S.to_vec();
        cones().unscale(&scaling, &mut of_s);
        assert_near(&of_s, &scaling.lambda);
        cones().scale(&scaling, &mut of_s);
        assert_near(&of_s, &S);
        let entries = (0..3).map(|i| {
            let entry = |j| inverse_entry(scaling.w(&cones().0[1]), scaling.eta(1), i, j);
            (0..3).map(|j| entry(j) * S[2 + j]).sum::<f64>()
        });
        assert_near(&entries.collect::<Vec<_>>(), &scaling.lambda[2..]);
        assert!((dot(&scaling.lambda, &scaling.lambda) - dot(&S, &Z)).abs() < 1e-12);
    }

    #[test]
    fn quotients_undo_products_and_steps_end_at_the_border() {
        let product = cones().product(&S, &Z);
        assert_near(&cones().quotient(&product, &S), &Z);
        let direction = [-0.1, 0.3, -0.5, 0.2, -0.1];
        let longest = cones().longest_step(&S, &direction);
        let end: Vec<f64> = S
            .iter()
            .zip(direction)
            .map(|(s, d)| s + longest * d)
            .collect();
        assert!(cones().least_eigenvalue(&end).abs() < 1e-12, "{end:?}");
        assert_eq!(cones().longest_step(&S, &S), f64::INFINITY);
    }
}
