//! Poles that several estimates agree on: those of different FRFs ([`super::local`]) or
//! of different orders ([`super::stabilization`]).

use super::limits::RADIUS;
use num_complex::Complex64;
use rayon::prelude::*;

/// Clusters of `poles`, given as (estimate, s) estimate by estimate, the largest first:
/// indices, at most one of each estimate. It ends with the first cluster that is not
/// `enough`.
///
/// * `least_radius`: radius for poles sharper than the lines resolve
pub(crate) fn clusters(
    poles: &[(usize, Complex64)],
    least_radius: f64,
    enough: impl Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..poles.len()).collect();
    let mut found = Vec::new();
    while let Some(seed) = largest(poles, &left, least_radius) {
        // once more around the median, which is a better centre than any single pole
        let centre = median_pole(seed.iter().map(|&i| poles[i].1));
        let around = gather(poles, &left, centre, least_radius);
        let members = if around.len() >= seed.len() {
            around
        } else {
            seed
        };
        if !enough(members.len()) {
            break;
        }
        left.retain(|i| !members.contains(i));
        found.push(members);
    }
    found
}

/// The largest cluster around one of the poles left; the tightest of equally large ones.
fn largest(poles: &[(usize, Complex64)], left: &[usize], least_radius: f64) -> Option<Vec<usize>> {
    left.par_iter()
        .map(|&i| {
            let centre = poles[i].1;
            let members = gather(poles, left, centre, least_radius);
            let spread = members
                .iter()
                .map(|&m| (poles[m].1 - centre).norm())
                .sum::<f64>();
            (members, spread)
        })
        .collect::<Vec<_>>()
        .into_iter()
        .max_by(|a, b| a.0.len().cmp(&b.0.len()).then(b.1.total_cmp(&a.1)))
        .map(|(members, _)| members)
}

/// Indices of the poles near `centre`, the nearest one of each estimate.
fn gather(
    poles: &[(usize, Complex64)],
    left: &[usize],
    centre: Complex64,
    least_radius: f64,
) -> Vec<usize> {
    let mut members: Vec<(usize, f64)> = Vec::new();
    for &i in left {
        let (estimate, pole) = poles[i];
        let distance = (pole - centre).norm();
        if distance > (RADIUS * pole.re.abs().min(centre.re.abs())).max(least_radius) {
            continue;
        }
        match members.last_mut() {
            Some(last) if poles[last.0].0 == estimate => {
                if distance < last.1 {
                    *last = (i, distance);
                }
            }
            _ => members.push((i, distance)),
        }
    }
    members.into_iter().map(|(i, _)| i).collect()
}

/// Median; NaN of nothing.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n => 0.5 * (values[(n - 1) / 2] + values[n / 2]),
    }
}

/// Median of real and imaginary parts.
pub(crate) fn median_pole(poles: impl Iterator<Item = Complex64> + Clone) -> Complex64 {
    Complex64::new(
        median(poles.clone().map(|s| s.re)),
        median(poles.map(|s| s.im)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_that_no_two_estimates_share_are_dropped() {
        let poles: Vec<(usize, Complex64)> = [
            (0, -0.01, 0.501),
            (0, -0.01, 0.7),
            (1, -0.011, 0.5),
            (1, -0.01, 0.8),
            (2, -0.012, 0.502),
            (2, -0.01, 0.6),
            (2, -0.01, 0.5045),
        ]
        .map(|(estimate, re, im)| (estimate, Complex64::new(re, im)))
        .to_vec();
        let found = clusters(&poles, 1e-4, |members| members > 1);
        assert_eq!(found, [vec![0, 2, 4]]);
        let centre = median_pole(found[0].iter().map(|&i| poles[i].1));
        assert!((centre - Complex64::new(-0.011, 0.501)).norm() < 1e-12);
    }
}
