//! Faults of single channels, beside gains that scatter: what two swapped cables are held against.
//!
//! Two reversed channels whose weights are nearly opposite move a field almost as their swap does,
//! and several dead ones, or amplifiers that err by a tenth, leave a difference of which a swap
//! explains some. Each is weighed as the swap is: dead and reversed channels without a free size,
//! one or two of them; odd channels one after another, as long as evidence grows.

use super::evidence::widened;
use super::field::Prediction;
use super::weighed::{variance, View};
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array1;
use num_complex::Complex64;

/// Channels that are dead or reversed: places and errors of their factors.
type Known = Vec<(usize, f64)>;

/// ln of the evidence of the likeliest faults of channels, over that of no fault.
///
/// # Errors
/// Those of the factorisations.
pub(super) fn likeliest_faults(view: &View, prediction: &Prediction) -> Result<f64> {
    let paths = prediction.paths(&prediction.drive);
    let known = dead_or_reversed(view, &paths)?;
    Ok(known.max(odd_channels(view, &paths)?))
}

/// The same of one or two dead or reversed channels.
fn dead_or_reversed(view: &View, paths: &[Array1<Complex64>]) -> Result<f64> {
    let count = paths.len();
    let errors = tolerances::KNOWN_FAULTS;
    let of_one = |i: usize| errors.map(|error| (i, error));
    let single = (0..count).flat_map(of_one).map(|fault| vec![fault]);
    let double = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
    let double = double.flat_map(|(i, j)| {
        let both = of_one(i).map(|one| of_one(j).map(|other| vec![one, other]));
        both.into_iter().flatten()
    });
    let [single, double]: [Vec<Known>; 2] = [single.collect(), double.collect()];
    let mut most = f64::NEG_INFINITY;
    for faults in [single, double] {
        let alternatives = faults.len();
        let mut weighed = alone(view, paths, faults)?;
        weighed.sort_by(|a, b| b.1.total_cmp(&a.1));
        weighed.truncate(tolerances::SWAPS_WEIGHED);
        for (fault, alone) in weighed {
            let mut after = paths.to_vec();
            for &(i, error) in &fault {
                after[i].mapv_inplace(|path| path * (1.0 + error));
            }
            let beside = view.fixed_and_scattered(&change(paths, &fault), &after, alternatives)?;
            most = most.max(alone).max(beside.ln_evidence);
        }
    }
    Ok(most)
}

/// The change of the field by known faults.
fn change(paths: &[Array1<Complex64>], fault: &[(usize, f64)]) -> Array1<Complex64> {
    let mut change = Array1::zeros(paths[0].len());
    for &(i, error) in fault {
        change.scaled_add(Complex64::from(error), &paths[i]);
    }
    change
}

/// Each of `faults` with its evidence, without gains that scatter.
fn alone(
    view: &View,
    paths: &[Array1<Complex64>],
    faults: Vec<Known>,
) -> Result<Vec<(Known, f64)>> {
    let count = faults.len();
    if view.field.magnitudes_only {
        let weighed = faults.into_iter().map(|fault| {
            let ln_evidence = view.fixed(&change(paths, &fault), count)?;
            Ok((fault, ln_evidence))
        });
        return weighed.collect();
    }
    // whitening is linear: one solution per channel serves all
    let white = paths.iter().map(|path| view.white(path.view()));
    let white: Vec<Array1<Complex64>> = white.collect::<Result<_>>()?;
    let weighed = faults.into_iter().map(|fault| {
        let ln_evidence = view.fixed_of_white(change(&white, &fault), count);
        (fault, ln_evidence)
    });
    Ok(weighed.collect())
}

/// The same of gains that scatter, with none to four odd channels among them: the next one is the
/// channel whose gain needs a wider prior most.
fn odd_channels(view: &View, paths: &[Array1<Complex64>]) -> Result<f64> {
    let count = paths.len();
    let wide = 1.0 / variance(tolerances::ODD_GAIN_ERROR);
    let mut most = f64::NEG_INFINITY;
    for scale in tolerances::SCATTER_SCALES {
        let mut widest = paths.to_vec();
        let mut odd: Vec<usize> = Vec::new();
        let (mut ln_choices, mut here) = (0.0, f64::NEG_INFINITY);
        loop {
            let mut gains = view.scattered(&widest)?;
            gains.prior = variance(scale);
            let found = view.weigh(&gains)?;
            if found.ln_evidence - ln_choices <= here {
                break;
            }
            here = found.ln_evidence - ln_choices;
            if odd.len() == tolerances::MOST_ODD {
                break;
            }
            let gain = |i: usize| {
                let priors = [wide, 1.0 / variance(scale)];
                widened(i, &found.sizes, &found.covariance, priors)
            };
            let even = (0..count).filter(|i| !odd.contains(i));
            let even = even
                .map(|i| (i, gain(i)))
                .filter(|(_, gain)| gain.is_finite());
            let Some((next, _)) = even.max_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            // a prior that is wider by a factor is a path that is longer by it
            let wider = tolerances::ODD_GAIN_ERROR / scale;
            widest[next].mapv_inplace(|path| path * wider);
            ln_choices += ((count - odd.len()) as f64 / (odd.len() + 1) as f64).ln();
            odd.push(next);
        }
        most = most.max(here);
    }
    Ok(most)
}
