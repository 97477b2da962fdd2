//! Normal equations of all fields over gains and shifts.
//!
//! Around θ the fields are M·θ + b behind white noise. Evidence is asked for many priors of
//! the shifts under each prior of the gains: the gains, most of the unknowns, are eliminated
//! once for all of them. A gain is the level of all channels plus an error of its own: the level
//! comes after all other unknowns (theory.md, eq. 58).

use super::parts::Parts;
use super::seen::Seen;
use crate::panel::drive::Drive;
use crate::panel::kernel_error::unsolvable;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::{s, Array1, Array2, ArrayView1, ArrayViewMut1, Axis};
use num_complex::Complex64;

/// Whitened normal equations of all fields, at one scale of the unexplained part.
pub(super) struct Normal {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// ln of the likelihood that the linear model has at θ = 0, to a constant.
    ln_likelihood: f64,
}

/// The equations of the shifts and of the level alone, gains eliminated under a prior of theirs.
pub(super) struct Eliminated {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// ln of the evidence without what the shifts add.
    ln_evidence: f64,
}

/// Equations around θ of measured values with noise of one variance: those of one field, or of a
/// sum of fields whose errors depend on no other sum.
struct Share {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// Σ of the squares of what the linear model leaves at θ = 0.
    square: f64,
    /// Real numbers that were measured.
    values: usize,
    /// Variance of their noise.
    noise: f64,
    /// Variance that an unexplained mobility of variance 1 adds.
    force: f64,
}

/// A field around θ: slopes over the unknowns, axes (row, unknown), and what is left at θ = 0.
struct Linear {
    slope: Array2<Complex64>,
    left: Array1<Complex64>,
}

impl Parts {
    /// The normal equations around θ, by the scale of the unexplained part.
    ///
    /// # Errors
    /// Those of the factorisations.
    pub(super) fn normals(
        &self,
        theta: &Array1<f64>,
        fields: &[Seen],
    ) -> Result<Vec<(f64, Normal)>> {
        let size = self.size();
        let mut shares = Vec::new();
        for fields in alike(fields) {
            match fields.as_slice() {
                [alone] if alone.magnitudes_only => shares.push(self.magnitudes(theta, alone)),
                together => shares.extend(self.phased(theta, together)?),
            }
        }
        let normal = |&unexplained: &f64| {
            let unknowns = self.unknowns() + tolerances::LEVEL_PARTS;
            let mut normal = Normal {
                matrix: Array2::zeros((unknowns, unknowns)),
                right: Array1::zeros(unknowns),
                ln_likelihood: 0.0,
            };
            for share in &shares {
                let variance = share.noise + (unexplained * size).powi(2) * share.force;
                normal.matrix.scaled_add(1.0 / variance, &share.matrix);
                normal.right.scaled_add(1.0 / variance, &share.right);
                normal.ln_likelihood -=
                    0.5 * (share.square / variance + share.values as f64 * variance.ln());
            }
            (unexplained, normal)
        };
        Ok(tolerances::UNEXPLAINED_SCALES.iter().map(normal).collect())
    }

    /// Fields of the same rows. Their errors are not independent: an unexplained mobility
    /// answers equal drives equally. In the sums Σ_f conj(U_fi)·v_f/σ_f they are, with the
    /// variance 1 + s²λ_i; U and λ are of the matrix A_gᴴA_f/(σ_fσ_g) (theory.md, eq. 58a).
    fn phased(&self, theta: &Array1<f64>, fields: &[&Seen]) -> Result<Vec<Share>> {
        let size = |drive: &Drive| drive.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        // a field that is zero everywhere has no noise that could be told
        let least = |drive: &Drive| tolerances::LEAST_FIELD_NOISE * self.size() * size(drive);
        let noises: Vec<f64> = fields
            .iter()
            .map(|seen| seen.noise.max(least(&seen.drive)))
            .collect();
        let drives: Vec<Drive> = fields
            .iter()
            .zip(&noises)
            .map(|(seen, noise)| seen.drive.mapv(|weight| weight / noise))
            .collect();
        let overlap = Array2::from_shape_fn((fields.len(), fields.len()), |(f, g)| {
            let pairs = drives[f].iter().zip(&drives[g]);
            pairs.map(|(a, b)| a * b.conj()).sum::<Complex64>()
        });
        let (forces, sums) = chladni_linalg::eigh(overlap.view()).map_err(unsolvable)?;
        let linear: Vec<Linear> = fields.iter().map(|seen| self.linear(theta, seen)).collect();
        let share = |(&force, sum): (&f64, ArrayView1<Complex64>)| {
            let (rows, unknowns) = linear[0].slope.dim();
            let mut slope = Array2::<Complex64>::zeros((rows, unknowns));
            let mut left = Array1::<Complex64>::zeros(rows);
            for ((noise, of_field), part) in noises.iter().zip(&linear).zip(sum) {
                let part = part.conj() / noise;
                slope.scaled_add(part, &of_field.slope);
                left.scaled_add(part, &of_field.left);
            }
            let parts = |value: &Complex64| [value.re, value.im];
            let values = Array1::from_iter(left.iter().flat_map(parts));
            let slopes = Array2::from_shape_fn((2 * rows, unknowns), |(k, p)| {
                parts(&slope[[k / 2, p]])[k % 2]
            });
            self.share(slopes, &values, 0.5, 0.5 * force.max(0.0))
        };
        Ok(forces.iter().zip(sums.columns()).map(share).collect())
    }

    /// A field of magnitudes, along the phases that θ foretells.
    fn magnitudes(&self, theta: &Array1<f64>, seen: &Seen) -> Share {
        let Linear { slope, left } = self.linear(theta, seen);
        let force: f64 = seen.drive.iter().map(Complex64::norm_sqr).sum();
        let (slope, left) = (slope.mapv(|value| value.re), left.mapv(|value| value.re));
        self.share(slope, &left, seen.noise.powi(2), 0.5 * force)
    }

    fn linear(&self, theta: &Array1<f64>, seen: &Seen) -> Linear {
        let (field, slope) = self.field(theta, &seen.drive);
        let mut slope = slope.select(Axis(0), &seen.rows);
        let mut left = Array1::zeros(seen.rows.len());
        for (k, (&row, &measured)) in seen.rows.iter().zip(&seen.velocity).enumerate() {
            let foretold = field[row];
            left[k] = measured - foretold;
            if seen.magnitudes_only {
                let turn = foretold.conj() / foretold.norm().max(f64::MIN_POSITIVE);
                slope.row_mut(k).mapv_inplace(|value| value * turn);
                left[k] = Complex64::from(measured.norm() - foretold.norm());
            }
        }
        for (p, &value) in theta.iter().enumerate() {
            left.scaled_add(Complex64::from(value), &slope.column(p));
        }
        Linear { slope, left }
    }

    /// The equations of real values `left` over the unknowns and the level of all gains.
    fn share(&self, slope: Array2<f64>, left: &Array1<f64>, noise: f64, force: f64) -> Share {
        let unknowns = self.unknowns();
        let mut rows = Array2::<f64>::zeros((left.len(), unknowns + tolerances::LEVEL_PARTS));
        rows.slice_mut(s![.., ..unknowns]).assign(&slope);
        for part in 0..tolerances::LEVEL_PARTS {
            let of_gains = slope.slice(s![.., part..2 * self.actuators(); 2]);
            rows.column_mut(unknowns + part)
                .assign(&of_gains.sum_axis(Axis(1)));
        }
        Share {
            matrix: chladni_linalg::matmul_h(rows.view(), rows.view()),
            right: rows.t().dot(left),
            square: left.dot(left),
            values: left.len(),
            noise,
            force,
        }
    }
}

/// Fields with phases that measured the same rows, together; each of the others alone.
fn alike(fields: &[Seen]) -> Vec<Vec<&Seen>> {
    let mut groups: Vec<Vec<&Seen>> = Vec::new();
    for seen in fields {
        let same = |group: &&mut Vec<&Seen>| {
            let first = group[0];
            !(seen.magnitudes_only || first.magnitudes_only) && first.rows == seen.rows
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(seen),
            None => groups.push(vec![seen]),
        }
    }
    groups
}

impl Normal {
    /// The equations of the shifts, gains eliminated under their prior precision.
    ///
    /// # Errors
    /// Those of the factorisations.
    pub(super) fn eliminated(&self, gains: &[f64]) -> Result<Eliminated> {
        let count = gains.len();
        let mut own = self.matrix.slice(s![..count, ..count]).to_owned();
        add(own.diag_mut(), gains);
        let root = chladni_linalg::cholesky(own.view()).map_err(unsolvable)?;
        let across = self.matrix.slice(s![..count, count..]);
        let across = chladni_linalg::solve_lower(root.view(), across).map_err(unsolvable)?;
        let right = self.right.slice(s![..count]).insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), right).map_err(unsolvable)?;
        let white = white.column(0);
        let within = chladni_linalg::matmul_h(across.view(), across.view());
        Ok(Eliminated {
            matrix: &self.matrix.slice(s![count.., count..]) - &within,
            right: &self.right.slice(s![count..]) - &across.t().dot(&white),
            ln_evidence: self.ln_likelihood + gained(&root, white, gains),
        })
    }

    /// The most probable unknowns under a prior, and their covariance.
    ///
    /// # Errors
    /// Those of the factorisation.
    pub(super) fn posterior(&self, precision: &[f64]) -> Result<(Array1<f64>, Array2<f64>)> {
        let mut matrix = self.matrix.clone();
        add(matrix.diag_mut(), precision);
        let covariance = chladni_linalg::inverse_hermitian(matrix.view()).map_err(unsolvable)?;
        Ok((covariance.dot(&self.right), covariance))
    }
}

impl Eliminated {
    /// ln of the evidence for a prior of the shifts.
    ///
    /// # Errors
    /// Those of the factorisation.
    pub(super) fn ln_evidence(&self, precision: &[f64]) -> Result<f64> {
        let mut matrix = self.matrix.clone();
        add(matrix.diag_mut(), precision);
        let root = chladni_linalg::cholesky(matrix.view()).map_err(unsolvable)?;
        let right = self.right.view().insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), right).map_err(unsolvable)?;
        Ok(self.ln_evidence + gained(&root, white.column(0), precision))
    }
}

/// The evidence that unknowns with a prior add: ½|L⁻¹b|² − ½ ln det LLᵀ + ½ ln det P.
fn gained(root: &Array2<f64>, white: ArrayView1<f64>, precision: &[f64]) -> f64 {
    let ln_det = 2.0 * root.diag().iter().map(|value| value.ln()).sum::<f64>();
    let ln_prior = precision.iter().map(|value| value.ln()).sum::<f64>();
    0.5 * (white.dot(&white) - ln_det + ln_prior)
}

fn add(mut diagonal: ArrayViewMut1<f64>, precision: &[f64]) {
    for (value, precision) in diagonal.iter_mut().zip(precision) {
        *value += precision;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::operator::Operator;
    use crate::test_model::test_model;
    use chladni_frf::Damping;

    fn parts() -> Parts {
        let model = test_model(Damping::Structural, &[(80.0, 0.08), (120.0, 0.05)], [5, 2]);
        Parts::new(&model, &Operator::of_model(&model, 100.0, None).unwrap())
    }

    /// A field that is not quite that of the model.
    fn seen(parts: &Parts, drive: [Complex64; 2], noise: f64) -> Seen {
        let drive = Drive::from_iter(drive);
        let velocity = parts
            .whole
            .dot(&drive)
            .mapv(|value| value * Complex64::new(1.1, 0.05));
        Seen {
            rows: (0..velocity.len()).collect(),
            noise: noise * crate::rig::field::rms(&velocity),
            drive,
            velocity,
            magnitudes_only: false,
        }
    }

    fn normals(parts: &Parts, fields: &[Seen]) -> Vec<(f64, Normal)> {
        parts
            .normals(&Array1::zeros(parts.unknowns()), fields)
            .unwrap()
    }

    /// The matrix, the right side, and the likelihood beside that of the first scale are one.
    fn assert_same(a: &[(f64, Normal)], b: &[(f64, Normal)]) {
        let largest = |values: Vec<f64>| values.into_iter().fold(0.0, f64::max);
        for ((_, one), (_, other)) in a.iter().zip(b) {
            let of = |apart: &Array2<f64>| largest(apart.iter().map(|v| v.abs()).collect());
            let apart = of(&(&one.matrix - &other.matrix));
            assert!(apart <= 1e-9 * of(&one.matrix), "{apart}");
            let of = |apart: &Array1<f64>| largest(apart.iter().map(|v| v.abs()).collect());
            let apart = of(&(&one.right - &other.right));
            assert!(apart <= 1e-9 * of(&one.right), "{apart}");
            let beside =
                |own: &Normal, all: &[(f64, Normal)]| own.ln_likelihood - all[0].1.ln_likelihood;
            let (one, other) = (beside(one, a), beside(other, b));
            assert!((one - other).abs() <= 1e-9 * one.abs(), "{one} {other}");
        }
    }

    const WEIGHTS: [Complex64; 2] = [Complex64::new(1.0, 0.2), Complex64::new(0.3, -0.5)];

    /// The unexplained part of the model is the same each time, turned as the drive is, so that only
    /// noise is averaged.
    #[test]
    fn a_field_measured_twice_is_one_of_half_the_variance() {
        let parts = parts();
        for turn in [Complex64::ONE, Complex64::I, Complex64::new(-0.6, 0.8)] {
            let first = seen(&parts, WEIGHTS, 0.02);
            let second = seen(&parts, WEIGHTS.map(|weight| weight * turn), 0.02);
            let twice = normals(&parts, &[first, second]);
            let once = normals(&parts, &[seen(&parts, WEIGHTS, 0.02 / 2f64.sqrt())]);
            assert_same(&once, &twice);
        }
    }

    /// Drives that overlap nowhere have errors of their own.
    #[test]
    fn fields_of_orthogonal_drives_add_up() {
        let parts = parts();
        let [a, b] = WEIGHTS;
        let fields = [
            seen(&parts, WEIGHTS, 0.02),
            seen(&parts, [-b.conj(), a.conj()], 0.02),
        ];
        let both = normals(&parts, &fields);
        let [first, second] = fields.map(|seen| normals(&parts, &[seen]));
        let sum: Vec<(f64, Normal)> = first
            .iter()
            .zip(&second)
            .map(|((scale, one), (_, other))| {
                let sum = Normal {
                    matrix: &one.matrix + &other.matrix,
                    right: &one.right + &other.right,
                    ln_likelihood: one.ln_likelihood + other.ln_likelihood,
                };
                (*scale, sum)
            })
            .collect();
        assert_same(&both, &sum);
    }

    /// A field of fewer rows, or one of magnitudes, is taken alone.
    #[test]
    fn fields_of_other_rows_are_not_joined() {
        let parts = parts();
        let whole = seen(&parts, WEIGHTS, 0.02);
        let mut some = whole.clone();
        some.rows.truncate(3);
        some.velocity = some.velocity.slice(s![..3]).to_owned();
        let mut plain = whole.clone();
        plain.magnitudes_only = true;
        let fields = [whole.clone(), some, plain.clone(), whole, plain];
        let sizes: Vec<usize> = alike(&fields).iter().map(Vec::len).collect();
        assert_eq!(sizes, [2, 1, 1, 1]);
    }
}
