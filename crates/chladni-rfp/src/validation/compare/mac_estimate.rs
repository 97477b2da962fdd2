//! The modal assurance criterion of shapes with error bars: its value, what noise takes
//! from it, and how far it may be off.

use num_complex::Complex64;

/// A shape with the standard deviation of each value, √E|δ|².
#[derive(Debug, Clone)]
pub(super) struct UncertainShape {
    unit: Vec<Complex64>,
    /// σ² of each value over the squared norm of the shape.
    variance: Vec<f64>,
    /// E(Re δ)² over its value for circular errors: 2 where errors are real as the shape
    /// is, else 1.
    reality: f64,
}

impl UncertainShape {
    /// `None` for a shape of zeros.
    pub fn new(values: Vec<Complex64>, std: Vec<f64>) -> Option<Self> {
        let power: f64 = values.iter().map(|value| value.norm_sqr()).sum();
        let is_usable = power > 0.0 && power.is_finite();
        is_usable.then(|| Self {
            reality: if values.iter().all(|value| value.im == 0.0) {
                2.0
            } else {
                1.0
            },
            unit: values.iter().map(|value| value / power.sqrt()).collect(),
            variance: std.iter().map(|std| std * std / power).collect(),
        })
    }
}

/// MAC of two shapes that are not known exactly.
///
/// The MAC of the exact shapes lies within `value − noise_bias` ± 1.96·`std` in 95 % of
/// cases, where the errors of the values are independent of each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct MacEstimate {
    /// |aᴴb|²/((aᴴa)(bᴴb)) of the shapes as they are.
    pub value: f64,
    /// Mean part that the errors of the shapes add to it: negative between like shapes,
    /// positive between orthogonal ones.
    pub noise_bias: f64,
    /// Standard deviation.
    pub std: f64,
}

impl MacEstimate {
    /// The value without what noise adds, 0..=1.
    pub fn unbiased(&self) -> f64 {
        (self.value - self.noise_bias).clamp(0.0, 1.0)
    }
}

/// MAC with its error, of the expansion of |aᴴb|²/((aᴴa)(bᴴb)) to second order in
/// independent errors (theory.md, eqs. M1 and M2).
pub(super) fn mac_estimate(a: &UncertainShape, b: &UncertainShape) -> MacEstimate {
    let cosine: Complex64 = a.unit.iter().zip(&b.unit).map(|(a, b)| a.conj() * b).sum();
    let value = cosine.norm_sqr().min(1.0);
    let [of_a, of_b] = [
        one_side(a, b, cosine, value),
        one_side(b, a, cosine.conj(), value),
    ];
    // between like shapes 1 − MAC is a sum of squares of errors; between orthogonal ones
    // the MAC is the square of a single sum
    let of_squares: f64 = (a.variance.iter().zip(&b.variance))
        .zip(&a.unit)
        .map(|((va, vb), unit)| {
            (a.reality * va + b.reality * vb) * (va + vb) * (1.0 - unit.norm_sqr()).powi(2)
        })
        .sum();
    let of_sum = of_a.projected + of_b.projected;
    let second = value * of_squares + (1.0 - value) * of_sum * of_sum;
    // shapes with errors lie farther apart than exact ones: the first order, made of their
    // distance, holds the second order twice
    let variance = (of_a.first + of_b.first - 2.0 * second).max(0.0) + second;
    MacEstimate {
        value,
        noise_bias: of_a.bias + of_b.bias,
        std: variance.sqrt(),
    }
}

/// The effect of the errors of one of two shapes.
struct OneSide {
    bias: f64,
    /// Variance to first order.
    first: f64,
    /// Mean square of the errors along the other shape.
    projected: f64,
}

fn one_side(own: &UncertainShape, other: &UncertainShape, cosine: Complex64, mac: f64) -> OneSide {
    let (mut total, mut along_own, mut projected, mut distant) = (0.0, 0.0, 0.0, 0.0);
    let mut crossed = Complex64::default();
    for ((&u, &v), &variance) in own.unit.iter().zip(&other.unit).zip(&own.variance) {
        total += variance;
        along_own += u.norm_sqr() * variance;
        projected += v.norm_sqr() * variance;
        distant += (v - u * cosine).norm_sqr() * variance;
        crossed += v.conj() * u * variance;
    }
    let mixed = 2.0 * (mac * along_own - (cosine * crossed).re);
    OneSide {
        bias: projected - mac * total + own.reality * mixed,
        first: 2.0 * own.reality * mac * distant,
        projected,
    }
}
