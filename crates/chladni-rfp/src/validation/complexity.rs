//! Complexity of a shape: three figures that all say "real" of a shape whose points move
//! in phase or in opposition.

use num_complex::Complex64;

/// Sums of squares and products of real and imaginary parts: (S_xx, S_yy, S_xy), of the shape over
/// its largest entry: squares of small numbers would be zero.
fn moments(shape: &[Complex64]) -> [f64; 3] {
    let largest = largest(shape).max(f64::MIN_POSITIVE);
    let entries = shape.iter().map(|v| v / largest);
    entries.fold([0.0; 3], |[xx, yy, xy], v| {
        [xx + v.re * v.re, yy + v.im * v.im, xy + v.re * v.im]
    })
}

/// Largest amplitude.
fn largest(shape: &[Complex64]) -> f64 {
    shape.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// Modal phase collinearity, 0..=1; 1 for a shape that is real up to one common phase. R.
/// Pappa, K. Elliott, A. Schenk, J. Guidance 16 (1993) 852: ((S_xx − S_yy)² +
/// 4S_xy²)/(S_xx + S_yy)² with the sums over real and imaginary parts.
pub fn mpc(shape: &[Complex64]) -> f64 {
    let [xx, yy, xy] = moments(shape);
    let sum = xx + yy;
    if sum > 0.0 {
        ((xx - yy).powi(2) + 4.0 * xy * xy) / (sum * sum)
    } else {
        0.0
    }
}

/// Mean phase deviation, degrees, 0..=90: how far the phases of the points lie from the
/// mean phase of the shape (modulo 180°), each weighted with its amplitude. The mean
/// phase is the principal axis of the points in the complex plane. E. Reynders, J.
/// Houbrechts, G. De Roeck, Mech. Syst. Signal Process. 29 (2012) 228. 0 for a shape of
/// zeros.
pub fn mean_phase_deviation_deg(shape: &[Complex64]) -> f64 {
    let [xx, yy, xy] = moments(shape);
    let axis = Complex64::from_polar(1.0, 0.5 * (2.0 * xy).atan2(xx - yy));
    let amplitudes: f64 = shape.iter().map(|v| v.norm()).sum();
    if amplitudes == 0.0 {
        return 0.0;
    }
    let off = |v: &Complex64| {
        let turned = v * axis.conj();
        v.norm() * turned.im.abs().atan2(turned.re.abs())
    };
    (shape.iter().map(off).sum::<f64>() / amplitudes).to_degrees()
}

/// Modal complexity factor, 0..=1: area of the convex hull of the shape in the complex
/// plane over the area of the circle with the radius of its largest entry. 0 for a real
/// shape, 1 for a wave that runs through all phases at one amplitude. M. Imregun, D.
/// Ewins, IMAC 13 (1995) 496.
pub fn modal_complexity_factor(shape: &[Complex64]) -> f64 {
    let largest = largest(shape);
    if largest == 0.0 {
        return 0.0;
    }
    let hull = convex_hull(shape.iter().map(|v| v / largest).collect());
    let twice_area: f64 = (0..hull.len())
        .map(|k| cross(hull[k], hull[(k + 1) % hull.len()]))
        .sum();
    0.5 * twice_area.abs() / std::f64::consts::PI
}

fn cross(a: Complex64, b: Complex64) -> f64 {
    a.re * b.im - a.im * b.re
}

/// Corners of the convex hull, counter-clockwise (A. Andrew, Inf. Process. Lett. 9 (1979)
/// 216: monotone chain).
fn convex_hull(mut points: Vec<Complex64>) -> Vec<Complex64> {
    points.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = Complex64>| {
        let mut chain: Vec<Complex64> = Vec::new();
        for point in points {
            while chain.len() >= 2
                && cross(
                    chain[chain.len() - 1] - chain[chain.len() - 2],
                    point - chain[chain.len() - 1],
                ) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    fn circle(points: usize) -> Vec<Complex64> {
        (0..points)
            .map(|k| Complex64::from_polar(2.0, TAU * k as f64 / points as f64))
            .collect()
    }

    #[test]
    fn a_real_shape_at_any_common_phase_is_not_complex() {
        let shape: Vec<Complex64> = [1.0, -2.0, 0.5, 0.0]
            .map(|v| Complex64::from_polar(1.0, 0.7) * v)
            .to_vec();
        assert!((mpc(&shape) - 1.0).abs() < 1e-14);
        assert!(mean_phase_deviation_deg(&shape) < 1e-6);
        assert!(modal_complexity_factor(&shape) < 1e-14);
    }

    #[test]
    fn the_scale_of_a_shape_does_not_matter() {
        let shape = [(1.0, 0.0), (-0.3, 0.5), (0.2, -0.9)].map(|(re, im)| Complex64::new(re, im));
        for scale in [1e-300, 1e-94, 1e200] {
            let scaled = shape.map(|v| v * scale);
            for figure in [mpc, mean_phase_deviation_deg, modal_complexity_factor] {
                let (told, all) = (figure(&scaled), figure(&shape));
                assert!((told / all - 1.0).abs() < 1e-9, "{scale}: {told} for {all}");
            }
        }
        assert_eq!(mpc(&[Complex64::ZERO; 3]), 0.0);
    }

    #[test]
    fn a_running_wave_is_as_complex_as_can_be() {
        assert!(mpc(&circle(4)) < 1e-30);
        // phases 0 and 90° in turn from any axis: 45° in the mean
        assert!((mean_phase_deviation_deg(&circle(360)) - 45.0).abs() < 0.5);
        // a regular polygon of n corners in the unit circle has the area (n/2) sin(2π/n)
        for n in [4, 12, 100] {
            let polygon = 0.5 * n as f64 * (TAU / n as f64).sin() / PI;
            assert!(
                (modal_complexity_factor(&circle(n)) - polygon).abs() < 1e-12,
                "{n}"
            );
        }
    }

    #[test]
    fn points_turned_both_ways_by_an_angle_deviate_by_it() {
        let delta = 0.2;
        let shape: Vec<Complex64> = (0..6)
            .map(|k| Complex64::from_polar(1.0, 0.9 + if k % 2 == 0 { delta } else { -delta }))
            .collect();
        assert!((mean_phase_deviation_deg(&shape) - delta.to_degrees()).abs() < 1e-9);
        // S along the axis cos²δ, across sin²δ: MPC = (cos²δ − sin²δ)²
        assert!((mpc(&shape) - (2.0 * delta).cos().powi(2)).abs() < 1e-12);
        let opposed: Vec<Complex64> = shape
            .iter()
            .map(|v| v * Complex64::from_polar(1.0, 2.0 * FRAC_PI_2))
            .collect();
        assert!((mean_phase_deviation_deg(&opposed) - delta.to_degrees()).abs() < 1e-9);
    }
}
