//! Peak picking: the natural frequency is where the summed |FRF|² peaks, the loss factor
//! what its half-power points say.
//!
//! In receptance one structural mode is A/(λ − x), so that 1/|α|² is a parabola in x = ω²
//! (theory.md, eq. 42) with its vertex at x_n and half-power points at x_n(1 ± η). The
//! sum over all FRFs keeps that form. Where a neighbour rises before the half-power
//! point, the lowest point on the way is taken, at x_n(1 ± η√(r − 1)) for a drop by r.
//! Peaks that explain no more than noise would are dropped.
//!
//! Cost: nothing beyond the first pass. C. W. Bishop and G. M. L. Gladwell describe the
//! practice, Phil. Trans. R. Soc. A 255 (1963) 241–280; D. J. Ewins, *Modal Testing*
//! (2000), section 4.3, its errors.
//!
//! Avoid it for numbers to report. Neighbours and residual terms move the peak and fill
//! the valleys, noise adds to the width, two modes within a bandwidth are one peak, and
//! the frequency is known to a fraction of the line spacing at best. It is here to teach,
//! and for a first look.

use super::limits::{FLANK_ENDS, LEAST_DROP};
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::methods::found::MethodPoles;
use crate::methods::selection::modes_of;
use crate::methods::survey::{Compressed, Survey};
use num_complex::Complex64;

/// Poles of the visible peaks that matter, or of as many as asked for.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn peak(
    survey: &Survey,
    _: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    Ok(modes_of(
        survey,
        &picked(survey),
        options,
        "visible peaks and their half-power points",
    )?)
}

/// λ of each visible peak.
pub(crate) fn picked(survey: &Survey) -> Vec<Complex64> {
    let x = &survey.data.x;
    let power: Vec<f64> = survey
        .energy
        .iter()
        .zip(&survey.data.g)
        .map(|(e, g)| e / (g * g))
        .collect();
    survey
        .peaks
        .iter()
        .map(|peak| half_power(x, &power, peak.row))
        .collect()
}

/// x_n(1 + jη) of the peak at line `top` of `power`, |α|² over lines `x`.
fn half_power(x: &[f64], power: &[f64], top: usize) -> Complex64 {
    let (vertex, highest) = vertex(x, power, top);
    let sides = [
        (0..top).rev().collect::<Vec<_>>(),
        (top + 1..x.len()).collect(),
    ];
    let widths: Vec<f64> = sides
        .iter()
        .filter_map(|side| half_width(x, power, highest, vertex, top, side))
        .collect();
    let line = 0.5 * (x[(top + 1).min(x.len() - 1)] - x[top.saturating_sub(1)]);
    let width = if widths.is_empty() {
        line
    } else {
        widths.iter().sum::<f64>() / widths.len() as f64
    };
    Complex64::new(vertex, width)
}

/// Vertex of the parabola through 1/|α|² at the top line and its neighbours, and |α|²
/// there.
fn vertex(x: &[f64], power: &[f64], top: usize) -> (f64, f64) {
    if top == 0 || top + 1 >= x.len() {
        return (x[top], power[top]);
    }
    let (a, b) = (x[top - 1] - x[top], x[top + 1] - x[top]);
    let rise = |k: usize| 1.0 / power[k] - 1.0 / power[top];
    let curvature = (rise(top + 1) / b - rise(top - 1) / a) / (b - a);
    let slope = rise(top - 1) / a - curvature * a;
    let shift = -0.5 * slope / curvature;
    let lowest = 1.0 / power[top] + 0.5 * slope * shift;
    if (a..=b).contains(&shift) && lowest > 0.0 {
        (x[top] + shift, 1.0 / lowest)
    } else {
        (x[top], power[top])
    }
}

/// h = ηx_n from one side: the half-power point, or the lowest point before a neighbour
/// rises.
fn half_width(
    x: &[f64],
    power: &[f64],
    highest: f64,
    vertex: f64,
    top: usize,
    side: &[usize],
) -> Option<f64> {
    let (mut lowest, mut before) = (top, top);
    for &k in side {
        if power[k] <= 0.5 * highest {
            // the root of what 1/|α|² rises by is straight in x
            let rise = |power: f64| (1.0 / power - 1.0 / highest).max(0.0).sqrt();
            let (from, to) = (rise(power[before]), rise(power[k].max(f64::MIN_POSITIVE)));
            let part = ((rise(0.5 * highest) - from) / (to - from)).clamp(0.0, 1.0);
            return Some((x[before] + part * (x[k] - x[before]) - vertex).abs());
        }
        if power[k] > FLANK_ENDS * power[lowest] {
            break;
        }
        if power[k] < power[lowest] {
            lowest = k;
        }
        before = k;
    }
    let drop = highest / power[lowest];
    (drop >= LEAST_DROP).then(|| (x[lowest] - vertex).abs() / (drop - 1.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_mode_is_read_off_its_parabola() {
        let truth = Complex64::new(0.401, 0.008);
        let x: Vec<f64> = (1..=500).map(|k| k as f64 / 500.0).collect();
        let power: Vec<f64> = x.iter().map(|&x| (truth - x).norm_sqr().recip()).collect();
        let top = (0..500)
            .max_by(|&a, &b| power[a].total_cmp(&power[b]))
            .unwrap();
        let found = half_power(&x, &power, top);
        assert!((found - truth).norm() < 1e-9, "{found}");
    }

    #[test]
    fn a_neighbour_before_the_half_power_point_does_not_stop_the_reading() {
        let truth = Complex64::new(0.4, 0.02);
        let x: Vec<f64> = (0..=14).map(|k| 0.386 + k as f64 * 0.002).collect();
        let power: Vec<f64> = x.iter().map(|&x| (truth - x).norm_sqr().recip()).collect();
        let found = half_power(&x, &power, 7);
        assert!((found - truth).norm() < 1e-9, "{found}");
    }
}
