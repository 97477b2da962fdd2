//! The time at which impulse responses begin: late where all FRFs are delayed.

use crate::data::limits;
use chladni_frf::Finding;
use chladni_linalg::fft;
use ndarray::ArrayView2;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Spacing of the lines, Hz; `None` where they are few, or not evenly spaced.
pub(crate) fn even_step(frequency: &[f64]) -> Option<f64> {
    let n = frequency.len();
    if n < limits::LINES_LEAST {
        return None;
    }
    let step = (frequency[n - 1] - frequency[0]) / (n - 1) as f64;
    let is_off = |w: &[f64]| ((w[1] - w[0]) - step).abs() >= limits::UNEVEN * step;
    (!frequency.windows(2).any(is_off)).then_some(step)
}

/// The time, s, before which the impulse responses of all `frfs`, (line, FRF), are silent; `None` where they
/// begin at once, or no silence shows. A taper over the lines keeps the side lobes of their end
/// low; each sample is the reciprocal of the band.
pub(crate) fn onset_s(frfs: ArrayView2<Complex64>, frequency: &[f64]) -> Option<f64> {
    let step = even_step(frequency)?;
    let n = frequency.len();
    let mut energy = vec![0.0; n];
    let fft = fft::inverse(n);
    for column in frfs.columns() {
        let places = column.iter().zip(0..);
        let mut response: Vec<Complex64> = places
            .map(|(value, k)| value * (PI * (k as f64 + 0.5) / n as f64).sin().powi(2))
            .collect();
        fft.process(&mut response);
        energy
            .iter_mut()
            .zip(&response)
            .for_each(|(sum, v)| *sum += v.norm_sqr());
    }
    let peak = energy.iter().copied().fold(0.0, f64::max);
    // a step has a quarter of its energy at its place
    let onset = energy.iter().position(|own| *own >= limits::ONSET * peak)?;
    let early = limits::ONSET_WIDTH
        ..onset
            .checked_sub(limits::ONSET_WIDTH)?
            .max(limits::ONSET_WIDTH);
    let is_silent = energy[early]
        .iter()
        .all(|own| *own <= limits::SILENT * peak);
    let is_late = (limits::ONSET_LEAST..n / 2).contains(&onset);
    (is_late && is_silent).then(|| onset as f64 / (n as f64 * step))
}

/// The finding of impulse responses that begin late.
pub(crate) fn late(seconds: f64) -> Finding {
    let words = format!(
        "all impulse responses are silent for the first {:.1} ms: all FRFs lag (a sound card, the \
         way from a loudspeaker), or waves take that long to all responses; poles that stand for \
         a lag look like heavily damped modes",
        1e3 * seconds
    );
    Finding::caution("common-delay", words)
        .value("delay_ms", 1e3 * seconds)
        .help(format!(
            "take it off: `delay {seconds:.4}`; the next fit says what is left of it"
        ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use std::f64::consts::TAU;

    /// Spectrum of three modes of this decay, 1/s, over a record of one second, late by so many.
    fn spectrum(decay: f64, late: f64) -> (Array2<Complex64>, Vec<f64>) {
        let frequency: Vec<f64> = (1..=1024).map(f64::from).collect();
        let of_modes = |f: &f64| {
            let modes = [110.0, 333.0, 701.0].iter();
            let sum: Complex64 = modes
                .map(|own| 1.0 / Complex64::new(decay, TAU * (f - own)))
                .sum();
            sum * Complex64::from_polar(1.0, -TAU * f * late)
        };
        let frf: Vec<Complex64> = frequency.iter().map(of_modes).collect();
        let frfs = Array2::from_shape_vec((1024, 1), frf).unwrap();
        (frfs, frequency)
    }

    #[test]
    fn the_onset_of_late_responses_is_found() {
        for late in [0.0, 0.004, 0.05, 0.3] {
            let (frfs, frequency) = spectrum(60.0, late);
            let found = onset_s(frfs.view(), &frequency);
            // four samples are no silence
            match late > 0.01 {
                true => assert!((found.unwrap() - late).abs() < 1.5e-3, "{found:?}"),
                false => assert_eq!(found, None),
            }
        }
        // what has not died away at the end of the record goes on at its beginning
        let (frfs, frequency) = spectrum(1.0, 0.3);
        assert_eq!(onset_s(frfs.view(), &frequency), None);
    }
}
