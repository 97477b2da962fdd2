//! Poles that move between FRFs: a roving sensor whose mass loads the structure,
//! temperature, a clamp that settles. One set of poles then contradicts the data as a
//! whole, however well each FRF could be fitted by itself.

use crate::checks::around::{neighbourhood, pole, strongest};
use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::poles::refine::refine;
use crate::tolerances as tol;
use chladni_frf::{Finding, Mode};

/// Lets every FRF have its own pole near each mode.
pub(crate) fn moving_poles(case: &Case) -> Option<Checked> {
    if case.noise_is_known || case.data.pairs.len() < 2 {
        return None;
    }
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let scatter: Vec<f64> = modes
        .iter()
        .filter_map(|mode| scatter(case, mode))
        .collect();
    let moving: Vec<f64> = scatter
        .iter()
        .copied()
        .filter(|s| *s > limits::MOVES)
        .collect();
    if moving.is_empty() || (moving.len() as f64) < limits::SHARE * scatter.len() as f64 {
        return None;
    }
    let most = moving.iter().copied().fold(0.0, f64::max);
    let words = format!(
        "poles differ between FRFs: {} of {} modes scatter by more than {} half-bandwidths (at \
         most {most:.1}): a roving sensor's mass, temperature, or a support that changes",
        moving.len(),
        scatter.len(),
        limits::MOVES
    );
    let finding = Finding::fault("moving-poles", words)
        .value("scatter_half_bandwidths", most)
        .help("measure with a fixed mass dummy, or fit the FRFs of each set-up by themselves");
    Some(finding.into())
}

/// Rms distance, in half-bandwidths along the frequency axis, of the FRFs' own poles from
/// their mean, weighted by strength; noise taken off. `None` where the mode cannot be
/// looked at by itself.
fn scatter(case: &Case, mode: &Mode) -> Option<f64> {
    let lambda = pole(case, mode);
    let near = |other: &Mode| {
        other != mode && (pole(case, other).re - lambda.re).abs() < limits::MOVING_ALONE * lambda.im
    };
    if lambda.im <= 0.0 || case.model.in_band_modes().any(near) {
        return None;
    }
    let frfs = strongest(case, mode, limits::MOVING_FRFS_MOST);
    let (local, own) = neighbourhood(
        case,
        mode,
        &[],
        limits::MOVING_WINDOW,
        limits::MOVING_FRFS_MOST,
    )?;
    let (mut places, mut noise, mut total) = (Vec::new(), 0.0, 0.0);
    for (column, &(strength, _)) in frfs.iter().enumerate() {
        let single = local.with_columns(own.slice(ndarray::s![.., column..column + 1]).to_owned());
        let Ok(fit) = refine(&single, &[lambda], &[0], tol::ROUGH.within(tol::FINE.steps)) else {
            continue;
        };
        let weight = strength * strength;
        // half of E|δλ|² lies along the frequency axis
        noise += weight * 0.5 * fit.variance(&single)
            / fit.information(&single)[[0, 0]].re.max(f64::MIN_POSITIVE);
        places.push((
            weight,
            ((fit.lambda[0].re - lambda.re) / lambda.im)
                .clamp(-limits::MOVING_FARTHEST, limits::MOVING_FARTHEST),
        ));
        total += weight;
    }
    if places.len() < 2 || total <= 0.0 {
        return None;
    }
    let mean = places.iter().map(|(w, d)| w * d).sum::<f64>() / total;
    let variance = places
        .iter()
        .map(|(w, d)| w * (d - mean).powi(2))
        .sum::<f64>()
        / total;
    let noise = noise / total / lambda.im.powi(2);
    Some(
        if variance > limits::OVER_NOISE * limits::OVER_NOISE * noise {
            (variance - noise).sqrt()
        } else {
            0.0
        },
    )
}
