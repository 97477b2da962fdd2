//! The start of modes whose poles lie within one half-bandwidth (theory.md, section 4).
//!
//! Free residues of poles that noise does not tell apart stand for a pole and its derivative: the
//! residues of both are nearly one matrix and its opposite, and start two modes in one shape. Their
//! sums Σ R_n and Σ λ_n R_n are known far better, and of modes with one shape each they are
//! ΨLᵀ and ΨΛLᵀ: poles and participations are the eigenvalues and left eigenvectors of one over the
//! other, in the space of the strongest shapes.

use crate::shapes::limits;
use chladni_linalg::{eigenvalues, matmul, matmul_h, svd_thin, LinalgError};
use ndarray::{s, Array2, Axis};
use num_complex::Complex64;

/// Groups of more than one of `poles`, each nearer than the larger half-bandwidth to another of
/// its group.
pub(super) fn close_groups(poles: &[Complex64]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for n in 0..poles.len() {
        let is_near = |&m: &usize| (poles[m] - poles[n]).norm() < poles[m].im.max(poles[n].im);
        let (near, mut apart): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| group.iter().any(is_near));
        apart.push(near.into_iter().flatten().chain([n]).collect());
        groups = apart;
    }
    groups.retain(|group| group.len() > 1);
    groups
}

/// Poles, and the participations of each: (mode, other).
pub(super) type PolesAndParticipations = (Vec<Complex64>, Array2<Complex64>);

/// Poles and participations (mode, other) of as many modes as there are `poles` in a group, from
/// their free residues (own, other). `None` where these have fewer shapes, or the poles of the
/// modes leave the group.
pub(super) fn from_moments(
    poles: &[Complex64],
    residues: &[Array2<Complex64>],
) -> Result<Option<PolesAndParticipations>, LinalgError> {
    let count = poles.len();
    let centre = poles.iter().sum::<Complex64>() / count as f64;
    let (own, other) = residues[0].dim();
    if own.min(other) < count {
        return Ok(None);
    }
    let moment = |power: i32| {
        let all = poles.iter().zip(residues);
        all.fold(Array2::zeros((own, other)), |sum, (pole, residue)| {
            sum + residue * (pole - centre).powi(power)
        })
    };
    let (u, sizes, vh) = svd_thin(moment(0).view())?;
    let (u, vh) = (u.slice(s![.., ..count]), vh.slice(s![..count, ..]));
    if sizes[count - 1] <= limits::MOMENTS_RANK * sizes[0] {
        return Ok(None);
    }
    let first = matmul_h(u, moment(1).view());
    let mut over = matmul(first.view(), vh.t().mapv(|v: Complex64| v.conj()).view());
    for (mut row, size) in over.rows_mut().into_iter().zip(&sizes) {
        row.mapv_inplace(|v| v / size);
    }
    let reach = poles.iter().fold(0.0_f64, |most, pole| most.max(pole.im));
    let shifts = eigenvalues(over.view())?;
    if shifts
        .iter()
        .any(|shift| shift.norm() >= reach || (centre + shift).im <= 0.0)
    {
        return Ok(None);
    }
    let mut along = Array2::zeros((count, other));
    for (mut row, shift) in along.rows_mut().into_iter().zip(&shifts) {
        // the null vector of (A − μ)ᵀ
        let mut transposed = over.t().to_owned();
        transposed.diag_mut().mapv_inplace(|v| v - shift);
        let (_, _, right) = svd_thin(transposed.view())?;
        let left = right.row(count - 1).mapv(|v| v.conj());
        row.assign(&matmul(left.insert_axis(Axis(0)).view(), vh).row(0));
    }
    Ok(Some((
        shifts.iter().map(|shift| centre + shift).collect(),
        along,
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_told_from_the_residues_of_other_poles_with_the_same_moments() {
        let value = |n: usize, i: usize| {
            let part = |i: usize| ((5 * n + 3 * i * i) % 7) as f64 - 2.5;
            Complex64::new(part(i), part(i + 2))
        };
        let term = |n: usize| Array2::from_shape_fn((4, 3), |(i, j)| value(n, i) * value(n + 2, j));
        let at = |re: f64| Complex64::new(re, 0.01);
        let modes = [at(1.0), at(1.0001)];
        // R₀ + R₁ and λ₀R₀ + λ₁R₁ are those of the modes
        let poles = [at(0.998), at(1.003)];
        let share = |of: Complex64| (of - poles[0]) / (poles[1] - poles[0]);
        let second = term(0) * share(modes[0]) + term(1) * share(modes[1]);
        let first = term(0) + term(1) - &second;
        let (mut found, along) = from_moments(&poles, &[first, second]).unwrap().unwrap();
        let order = usize::from(found[0].re > found[1].re);
        for n in 0..2 {
            let row = along.row((n + order) % 2);
            let like: Complex64 = (0..3).map(|j| row[j].conj() * value(n + 2, j)).sum();
            let size = |v: f64| v.sqrt();
            let whole = size((0..3).map(|j| value(n + 2, j).norm_sqr()).sum())
                * size(row.iter().map(|v| v.norm_sqr()).sum());
            assert!((like.norm() / whole - 1.0).abs() < 1e-6);
        }
        found.sort_by(|a, b| a.re.total_cmp(&b.re));
        for (found, mode) in found.iter().zip(modes) {
            assert!((found - mode).norm() < 1e-9, "{found}");
        }
    }

    #[test]
    fn groups_are_of_poles_within_a_half_bandwidth() {
        let poles = [1.0, 2.0, 1.015, 1.008, 2.03].map(|re| Complex64::new(re, 0.01));
        assert_eq!(close_groups(&poles), [vec![0, 2, 3]]);
    }
}
