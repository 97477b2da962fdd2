//! Noise in the record of a force, told by the errors that several responses share.
//!
//! A force read as x + n leaves −H_l·n in the fit of every response l, while the noise of
//! responses is their own ([`chladni_frf::shared_power`]), and least squares give
//! H·(1 − E|n|²/E|x + n|²) (theory.md, eq. F4g).

use crate::limits::{FORCE_FITS, FORCE_LINES, FORCE_MEDIAN, FORCE_MOST, FORCE_SIGNS};

/// The force's noise as one local fit tells it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ForceNoise {
    /// E|n|² on a line of the transform; scatters about it, below 0 too.
    pub power: f64,
    /// The part of an FRF that a unit of noise takes: 1/E|x + n|².
    pub attenuation: f64,
    /// Variance of an FRF per unit of noise on a line of its response.
    pub unit_variance: f64,
}

/// Noise of the force as it acts on the FRFs of one line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correction {
    /// The factor that undoes its bias.
    pub factor: f64,
    /// Variance of the error that remains, over the power of an FRF.
    pub variance: f64,
}

/// Corrections of the lines that tell the noise of the force; `None` where responses share no
/// errors.
///
/// * `step`: lines of the record from one line of the FRFs to the next; below those of a local fit
///   neighbours tell less
pub(super) fn corrections(
    lines: &[Option<ForceNoise>],
    step: f64,
) -> Option<Vec<(usize, Correction)>> {
    let around = ((FORCE_LINES as f64 / step).ceil() as usize).max(FORCE_FITS) | 1;
    let known: Vec<(usize, ForceNoise)> = lines
        .iter()
        .enumerate()
        .filter_map(|(k, line)| Some((k, (*line)?)))
        .collect();
    let shares = known.iter().filter(|(_, line)| line.power > 0.0).count();
    if known.len() < around || (shares as f64) < FORCE_SIGNS * known.len() as f64 {
        return None;
    }
    let of_line = |(place, &(k, line)): (usize, &(usize, ForceNoise))| {
        let first = place.saturating_sub(around / 2).min(known.len() - around);
        let near = known[first..first + around].iter();
        let mut powers: Vec<f64> = near.map(|(_, line)| line.power).collect();
        let middle = powers.select_nth_unstable_by(around / 2, f64::total_cmp);
        let power = middle.1.max(0.0) / FORCE_MEDIAN;
        let taken = (power * line.attenuation).clamp(0.0, FORCE_MOST);
        let correction = Correction {
            factor: 1.0 / (1.0 - taken),
            variance: power * line.unit_variance,
        };
        (k, correction)
    };
    Some(known.iter().enumerate().map(of_line).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_corrected_where_errors_are_shared() {
        let line = |power: f64| {
            Some(ForceNoise {
                power,
                attenuation: 0.5,
                unit_variance: 0.2,
            })
        };
        let noisy = vec![line(0.1 * FORCE_MEDIAN); 2 * FORCE_FITS];
        let corrected = corrections(&noisy, 13.0).unwrap();
        assert_eq!(corrected.len(), noisy.len());
        for (_, Correction { factor, variance }) in corrected {
            assert!((factor - 1.0 / 0.95).abs() < 1e-12 && (variance - 0.02).abs() < 1e-12);
        }
        let mut clean = noisy.clone();
        clean
            .iter_mut()
            .step_by(2)
            .for_each(|own| *own = line(-0.1));
        assert_eq!(corrections(&clean, 13.0), None);
        assert_eq!(corrections(&noisy[..FORCE_FITS - 1], 13.0), None);
        assert_eq!(corrections(&noisy[..FORCE_FITS], 8.0), None);
        assert_eq!(corrections(&vec![None; 2 * FORCE_FITS], 13.0), None);
    }
}
