//! Local rational method: as the local polynomial method, with a denominator that all
//! responses share,
//!
//! Y_l(r)·D(r) = Σ_j B_lj(r)·X_j(r) + C_l(r),  D = 1 + d₁r + d₂r²
//!
//! so that a mode inside these lines is followed exactly, however narrow it is. D is found
//! by least squares with each line weighted by 1/|D| of the step before (Sanathanan and
//! Koerner), starting from D = 1. Each response counts by the noise that its fit leaves.
//! For given D the other unknowns are those of the polynomial method; they are projected
//! out, which leaves two unknowns, whatever the number of responses.
//!
//! R. Voorhoeve, A. van der Maas, T. Oomen, "Non-parametric identification of
//! multivariable systems: a local rational modeling approach", Mech. Syst. Signal
//! Process. 105 (2018) 129–152; C. Sanathanan, J. Koerner, IEEE Trans. Automatic Control
//! 8 (1963) 56–58.

use super::force_noise::ForceNoise;
use super::local_basis::{
    coherence, inner, square, unknowns, Basis, LocalEstimate, LocalLine, LocalLines,
};
use crate::limits::{LEAST_DENOMINATOR, ROUNDING, STEPS};
use chladni_frf::shared_power;
use num_complex::Complex64;

/// d₁, d₂ of the denominator that the responses share.
type SharedDenominator = [Complex64; 2];

/// One response projected: residuals of y, r·y and r²·y.
struct Projected {
    /// Inner products of the three residuals.
    gram: [[Complex64; 3]; 3],
    /// B_j(0) of the three, per reference.
    at_centre: Vec<[Complex64; 3]>,
    /// ‖y‖² on the weighted lines.
    power: f64,
    /// The residual of y.
    rest: Vec<Complex64>,
}

/// FRFs of every response; `None` where references have no power or act as one.
pub(super) fn estimate(local: &LocalLines) -> Option<LocalLine> {
    let mut fit = Fit::unweighted(local)?;
    let force_noise = fit.force_noise();
    for _ in 0..STEPS {
        fit = fit.refined()?;
    }
    Some(fit.finish(force_noise))
}

/// The unknowns of one step of Sanathanan and Koerner.
struct Fit<'a> {
    local: &'a LocalLines<'a>,
    basis: Basis,
    projected: Vec<Projected>,
    denominator: SharedDenominator,
    /// Variance of the noise that the fit leaves, per response.
    noise: Vec<f64>,
}

impl<'a> Fit<'a> {
    /// The first step, with D = 1; each response counts by its power.
    fn unweighted(local: &'a LocalLines) -> Option<Self> {
        Self::new(local, SharedDenominator::default(), None)
    }

    /// The next step, weighted by this one.
    fn refined(self) -> Option<Self> {
        Self::new(self.local, self.denominator, Some(self.noise))
    }

    /// * `denominator_before`, `noise_before`: those of the step before; without that noise the
    ///   power of each response stands for it
    fn new(
        local: &'a LocalLines,
        denominator_before: SharedDenominator,
        noise_before: Option<Vec<f64>>,
    ) -> Option<Self> {
        let weight = weights(&local.places, denominator_before);
        let basis = Basis::new(local, &weight)?;
        let responses = local.responses.iter();
        let projected: Vec<Projected> = responses
            .map(|response| Projected::new(local, &basis, response, &weight))
            .collect();
        let noise_before =
            noise_before.unwrap_or_else(|| projected.iter().map(|p| p.power).collect());
        let normal = Normal::of(&projected, &noise_before);
        let denominator = normal.solution();
        let noise = projected
            .iter()
            .zip(&noise_before)
            .map(|(p, &before)| p.noise(local, denominator, normal.share(p, before)))
            .collect();
        Some(Self {
            local,
            basis,
            projected,
            denominator,
            noise,
        })
    }

    /// Noise of the only force, as the residuals of all responses share it where D = 1: a D of
    /// its own would take part of what they share.
    fn force_noise(&self) -> Option<ForceNoise> {
        let [force] = self.local.references[..] else {
            return None;
        };
        let lines = self.local.places.len();
        let free = (lines - unknowns(1)) as f64;
        let projected = self.projected.iter();
        let each = projected.map(|p| (p.at_centre[0][0], &p.rest[..]));
        let power = shared_power(each, free)?;
        Some(ForceNoise {
            power,
            // a mean of 1/power, by so many lines
            attenuation: (lines - 1) as f64 / square(force),
            unit_variance: self.basis.unit_variance()[0],
        })
    }

    /// The result of this step as the last one, with the noise of the force that the first told.
    fn finish(&self, force_noise: Option<ForceNoise>) -> LocalLine {
        let normal = Normal::of(&self.projected, &self.noise);
        let raised = self.raised(&normal);
        LocalLine {
            responses: self.responses(&normal),
            force_noise: force_noise.map(|force_noise| ForceNoise {
                unit_variance: raised * force_noise.unit_variance,
                ..force_noise
            }),
        }
    }

    /// Values and variances at the frequency, where D = 1.
    fn responses(&self, normal: &Normal) -> Vec<LocalEstimate> {
        let unit_variance = self.basis.unit_variance();
        let [d1, d2] = self.denominator;
        let of_response = |((p, &noise), response): ((&Projected, &f64), &&[Complex64])| {
            let values = p
                .at_centre
                .iter()
                .zip(&unit_variance)
                .map(|(&[y, ry, rry], unit)| {
                    let by_denominator = normal.variance([ry, rry]);
                    (y + d1 * ry + d2 * rry, unit * noise + by_denominator)
                })
                .collect();
            LocalEstimate {
                values,
                coherence: coherence(response, noise),
            }
        };
        let responses = self.projected.iter().zip(&self.noise);
        let responses = responses.zip(&self.local.responses);
        responses.map(of_response).collect()
    }

    /// Factor by which D raises the variance of FRFs whose errors are shared: all responses
    /// tell the same of it.
    fn raised(&self, normal: &Normal) -> f64 {
        let unit = self.basis.unit_variance()[0];
        let projected = self.projected.iter();
        let by_denominator: f64 = projected
            .map(|p| normal.variance([p.at_centre[0][1], p.at_centre[0][2]]))
            .sum();
        let own: f64 = self.noise.iter().map(|noise| unit * noise).sum();
        1.0 + self.projected.len() as f64 * by_denominator / own.max(f64::MIN_POSITIVE)
    }
}

/// 1/|D| of each line.
fn weights(places: &[f64], [d1, d2]: SharedDenominator) -> Vec<f64> {
    let sizes: Vec<f64> = places
        .iter()
        .map(|r| (1.0 + d1 * r + d2 * r * r).norm())
        .collect();
    let least = LEAST_DENOMINATOR * sizes.iter().copied().fold(0.0, f64::max);
    sizes.iter().map(|size| size.max(least).recip()).collect()
}

impl Projected {
    fn new(local: &LocalLines, basis: &Basis, response: &[Complex64], weight: &[f64]) -> Self {
        let lines = || response.iter().zip(weight).zip(&local.places);
        let y: Vec<Complex64> = lines().map(|((y, w), _)| y * w).collect();
        let power = square(&y);
        let [y, ry, rry] = [
            basis.split(y),
            basis.split(lines().map(|((y, w), r)| y * w * r).collect()),
            basis.split(lines().map(|((y, w), r)| y * w * (r * r)).collect()),
        ];
        let rests = [&y.rest, &ry.rest, &rry.rest];
        let gram = std::array::from_fn(|a| std::array::from_fn(|b| inner(rests[a], rests[b])));
        let at_centre = (0..local.references.len())
            .map(|j| [&y, &ry, &rry].map(|split| split.at_centre[j]))
            .collect();
        Self {
            gram,
            at_centre,
            power,
            rest: y.rest,
        }
    }

    /// Variance of the noise on a line: what is left, over the freedom that is left;
    /// `share` is the part of D's freedom that this response took.
    fn noise(&self, local: &LocalLines, [d1, d2]: SharedDenominator, share: f64) -> f64 {
        let factors = [Complex64::from(1.0), d1, d2];
        let mut left = Complex64::default();
        for (row, a) in self.gram.iter().zip(factors) {
            for (product, b) in row.iter().zip(factors) {
                left += a.conj() * product * b;
            }
        }
        let free = local.places.len() - unknowns(local.references.len());
        // a response without noise must not outweigh all others by rounding alone
        left.re.max(ROUNDING * self.power) / (free as f64 - share)
    }
}

/// The normal equations of D, responses over the variances of their noise.
struct Normal {
    /// Hermitian matrix: diagonal and upper element.
    diagonal: [f64; 2],
    upper: Complex64,
    right: [Complex64; 2],
}

impl Normal {
    fn of(projected: &[Projected], noise: &[f64]) -> Self {
        let mut normal = Self {
            diagonal: [0.0; 2],
            upper: Complex64::default(),
            right: [Complex64::default(); 2],
        };
        let acting = projected
            .iter()
            .zip(noise)
            .filter(|(_, noise)| **noise > 0.0);
        for (p, noise) in acting {
            for i in 0..2 {
                normal.diagonal[i] += (p.gram[i + 1][i + 1].re + ROUNDING * p.power) / noise;
                normal.right[i] -= p.gram[i + 1][0] / noise;
            }
            normal.upper += p.gram[1][2] / noise;
        }
        normal
    }

    /// Inverse: diagonal and upper element; zero where nothing acts.
    fn inverse(&self) -> ([f64; 2], Complex64) {
        let [a, b] = self.diagonal;
        let determinant = a * b - self.upper.norm_sqr();
        if determinant.is_nan() || determinant <= 0.0 {
            return ([0.0; 2], Complex64::default());
        }
        (
            [b / determinant, a / determinant],
            -self.upper / determinant,
        )
    }

    fn solution(&self) -> SharedDenominator {
        let ([a, b], upper) = self.inverse();
        let [p, q] = self.right;
        [a * p + upper * q, upper.conj() * p + b * q]
    }

    /// gᴴ-variance of D: g·M⁻¹·gᴴ.
    fn variance(&self, [g1, g2]: [Complex64; 2]) -> f64 {
        let ([a, b], upper) = self.inverse();
        a * g1.norm_sqr() + b * g2.norm_sqr() + 2.0 * (g1 * upper * g2.conj()).re
    }

    /// Part of D's two unknowns that a response determines.
    fn share(&self, p: &Projected, noise: f64) -> f64 {
        if noise <= 0.0 {
            return 0.0;
        }
        let ([a, b], upper) = self.inverse();
        let trace = a * p.gram[1][1].re + b * p.gram[2][2].re + 2.0 * (upper * p.gram[2][1]).re;
        (trace / noise).clamp(0.0, 2.0)
    }
}
