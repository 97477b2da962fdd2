//! The drive over time as a sum of patterns, each with its envelope.
//!
//! a(t) = Σ_b [ u_b(t)·A_b + u̇_b(t)·B_b ], B_b = K·A_b with modal ramps and 0 with plain
//! ones. Everything that is played, simulated or judged is made of this.

use crate::time::envelope::{Course, Envelope};
use crate::time::simulate::SampledDrive;
use ndarray::{concatenate, Array1, Array2, Axis};
use num_complex::Complex64;

/// One pattern and its envelope.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// A, peak phasors in N or V.
    pub(crate) pattern: Array1<Complex64>,
    /// B: what the derivative of the envelope drives besides, N·s or V·s.
    pub(crate) correction: Option<Array1<Complex64>>,
    /// u.
    pub(crate) envelope: Envelope,
}

/// The envelopes of one tone, about its carrier.
#[derive(Debug, Clone)]
pub(crate) struct Tracks {
    /// ω₀/2π, Hz.
    pub(crate) frequency_hz: f64,
    pub(crate) tracks: Vec<Track>,
}

impl Tracks {
    /// On `count` samples from the sample `first` on.
    pub(crate) fn sampled(&self, step_s: f64, first: usize, count: usize) -> SampledDrive {
        let [from_s, to_s] = [first, first + count].map(|sample| step_s * sample as f64);
        let sounding: Vec<&Track> = self
            .tracks
            .iter()
            .filter(|track| {
                let [start_s, end_s] = track.envelope.span_s();
                start_s <= to_s && end_s >= from_s
            })
            .collect();
        let patterns: Vec<&Array1<Complex64>> =
            sounding.iter().map(|track| &track.pattern).collect();
        let corrected: Vec<usize> = (0..sounding.len())
            .filter(|&b| sounding[b].correction.is_some())
            .collect();
        let corrections: Vec<&Array1<Complex64>> = sounding
            .iter()
            .filter_map(|track| track.correction.as_ref())
            .collect();
        let columns = patterns.len() + corrections.len();
        let mut values = Array2::zeros((count, columns));
        let mut slopes = Array2::zeros((count, columns));
        let mut bends = Array2::zeros((count, columns));
        for k in 0..count {
            let time_s = step_s * (first + k) as f64;
            let envelopes: Vec<Course> = sounding
                .iter()
                .map(|track| track.envelope.at(time_s))
                .collect();
            let mut put = |column: usize, value: f64, slope: f64, bend: f64| {
                values[[k, column]] = value.into();
                slopes[[k, column]] = slope.into();
                bends[[k, column]] = bend.into();
            };
            for (b, [value, slope, bend, _]) in envelopes.iter().enumerate() {
                put(b, *value, *slope, *bend);
            }
            for (number, &b) in corrected.iter().enumerate() {
                let [_, slope, bend, third] = envelopes[b];
                put(patterns.len() + number, slope, bend, third);
            }
        }
        SampledDrive {
            step_s,
            patterns: stacked(&patterns, &corrections, self.actuators()),
            values,
            slopes,
            bends,
        }
    }

    fn actuators(&self) -> usize {
        self.tracks.first().map_or(0, |track| track.pattern.len())
    }

    /// a at one time, N or V.
    pub(crate) fn at(&self, time_s: f64, sum: &mut [Complex64]) {
        sum.fill(Complex64::ZERO);
        for track in &self.tracks {
            let [value, slope, ..] = track.envelope.at(time_s);
            if value != 0.0 {
                add(sum, &track.pattern, value);
            }
            if let Some(correction) = track.correction.as_ref().filter(|_| slope != 0.0) {
                add(sum, correction, slope);
            }
        }
    }

    /// The same with every pattern times `factor`.
    pub(crate) fn times(mut self, factor: Complex64) -> Self {
        for track in &mut self.tracks {
            track.pattern.mapv_inplace(|value| value * factor);
            if let Some(correction) = &mut track.correction {
                correction.mapv_inplace(|value| value * factor);
            }
        }
        self
    }

    /// The same through channels of these complex gains.
    pub(crate) fn with_gains(mut self, gains: &[Complex64]) -> Self {
        let gains = Array1::from(gains.to_vec());
        for track in &mut self.tracks {
            track.pattern *= &gains;
            if let Some(correction) = &mut track.correction {
                *correction *= &gains;
            }
        }
        self
    }
}

/// Turns of the tones against each other: phases mean nothing to the field, and
/// Schroeder's (IEEE Trans. Inf. Theory 16, 1970) keep the lines of a band from adding up
/// to pulses.
pub(crate) fn schroeder(number: usize, count: usize) -> Complex64 {
    let product = (number * number.saturating_sub(1)) as f64;
    Complex64::from_polar(1.0, std::f64::consts::PI * product / count as f64)
}

fn add(sum: &mut [Complex64], pattern: &Array1<Complex64>, factor: f64) {
    for (sum, value) in sum.iter_mut().zip(pattern) {
        *sum += value * factor;
    }
}

fn stacked(
    patterns: &[&Array1<Complex64>],
    corrections: &[&Array1<Complex64>],
    actuators: usize,
) -> Array2<Complex64> {
    let rows: Vec<_> = patterns
        .iter()
        .chain(corrections)
        .map(|row| row.view().insert_axis(Axis(0)))
        .collect();
    if rows.is_empty() {
        return Array2::zeros((0, actuators));
    }
    concatenate(Axis(0), &rows).expect("patterns of one length")
}
