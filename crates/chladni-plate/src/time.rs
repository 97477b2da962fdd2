//! FRFs as an analyser estimates them: modes simulated exactly in time, excited,
//! windowed, averaged.
//!
//! A viscous mode with pole s answers a force f by ż = s·z + f; velocities are v_i = Σ_n
//! 2 Re(s_n r_in z_n) with the residues r_in of theory.md, eq. 4. Between samples the
//! force is a straight line (first-order hold), for which the step is closed (theory.md,
//! eq. 25):
//!
//! z_{k+1} = E z_k + (I₀ − I₁) f_k + I₁ f_{k+1},   E = e^{sΔ},  I₀ = (E − 1)/s,  I₁ = (E
//! − 1 − sΔ)/(s²Δ)
//!
//! The hold multiplies the spectrum by a smooth function and leaves the poles where they
//! are, so that the truth is exact. H₁ = S_vf/S_ff over the averages, force free of
//! noise: Bendat & Piersol, *Random Data*, 4th ed. (2010), ch. 6.
//!
//! Effects shown here, and not by white noise on a modal sum: leakage, windows, truncated
//! and padded records.

use crate::noise::generator;
use crate::synthetic::Synthetic;
use crate::tolerances::SETTLING_RECORDS;
use chladni_frf::{
    BlockWindow, Channel, Damping, Error, FrfSet, FrfValues, Geometry, ModalModel, ReferenceUnit,
    Result, Run, SignalUnit,
};
use chladni_linalg::fft;
use ndarray::{s, Array1, Array2, Array3};
use num_complex::Complex64;
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

/// Random streams of forces and of noise.
const FORCE_STREAM: u64 = (1 << 62) + 2;
const NOISE_STREAM: u64 = (1 << 62) + 3;

/// Excitation of the structure.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Excitation {
    /// One blow at the start of each record, a half sine, the structure at rest before.
    Hammer {
        /// Length of the contact, s.
        contact_s: f64,
    },
    /// White noise over the first part of each record, the structure at rest before.
    BurstRandom {
        /// Part of the record, 0..=1.
        part: f64,
    },
    /// White noise without beginning or end.
    Random,
}

/// A test to simulate: one reference, velocities over force.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeTest {
    /// Natural frequencies ω_n/2π, Hz, rising.
    pub natural_frequency_hz: Vec<f64>,
    /// ζ_n, one per mode or one for all.
    pub damping_ratio: Vec<f64>,
    /// Number of responses; the force acts at the first.
    pub responses: usize,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Length T of a record, s.
    pub record_s: f64,
    /// The transform is taken over this many times the record, the rest zeros; 1: none.
    pub padding: usize,
    /// Lines that are kept, Hz.
    pub band_hz: [f64; 2],
    /// Records that are averaged.
    pub averages: usize,
    /// Excitation.
    pub excitation: Excitation,
    /// Window, on force and response.
    pub window: BlockWindow,
    /// Noise on the velocities, below their mean square over all records, dB.
    pub snr_db: f64,
    /// Seed of shapes, forces and noise.
    pub seed: u64,
}

/// Simulated FRFs and the structure behind them.
#[derive(Debug, Clone)]
pub struct TimeSet {
    /// H₁ mobilities.
    pub frf: FrfSet,
    /// The structure, as it is without any window.
    pub truth: ModalModel,
}

/// One mode on its way through time.
struct Oscillator {
    state: Complex64,
    /// E, I₀ − I₁, I₁.
    step: [Complex64; 3],
    /// 2 s r_i per response.
    output: Vec<Complex64>,
}

impl TimeTest {
    /// Simulates; the same specification gives the same bits.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] for sizes and numbers that describe no
    /// measurement.
    pub fn build(&self) -> Result<TimeSet> {
        let (truth, lines) = self.truth_and_lines()?;
        let samples = self.samples();
        let frequency_hz: Array1<f64> = lines.clone().map(|k| k as f64 * self.step_hz()).collect();
        let records = self.records(&truth, samples);
        let values = self.h1(&records, lines, samples);
        let frf = FrfSet {
            frequency_hz,
            values: FrfValues::F64(values),
            responses: truth.responses.clone(),
            references: truth.references.clone(),
            kind: Some(truth.frf_kind),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        };
        Ok(TimeSet {
            frf: frf.checked()?,
            truth,
        })
    }

    /// The records themselves, without the window: force and velocities, one run per
    /// record.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn runs(&self) -> Result<Vec<Run>> {
        let (truth, _) = self.truth_and_lines()?;
        let records = Self {
            window: BlockWindow::Rectangular,
            ..self.clone()
        }
        .records(&truth, self.samples());
        let channel = |dof, unit, is_reference, row: ndarray::ArrayView1<'_, f64>| Channel {
            dof,
            unit,
            is_reference,
            samples: row.to_vec(),
        };
        let run = |record: &Array2<f64>| {
            let force = channel(
                truth.references[0],
                SignalUnit::Force,
                true,
                record.row(self.responses),
            );
            let velocities = truth
                .responses
                .iter()
                .zip(record.rows())
                .map(|(dof, row)| channel(*dof, SignalUnit::Velocity, false, row));
            let channels = std::iter::once(force).chain(velocities).collect();
            Run {
                file: "simulated".into(),
                line: 0,
                sample_rate_hz: self.sample_rate_hz,
                channels,
            }
        };
        Ok(records.iter().map(run).collect())
    }

    fn samples(&self) -> usize {
        (self.record_s * self.sample_rate_hz).round() as usize
    }

    fn step_hz(&self) -> f64 {
        1.0 / (self.record_s * self.padding as f64)
    }

    /// The structure, and the lines of the transform that are kept.
    fn truth_and_lines(&self) -> Result<(ModalModel, std::ops::Range<usize>)> {
        self.check()?;
        let step_hz = self.step_hz();
        let lines = (self.band_hz[0] / step_hz).ceil() as usize
            ..(self.band_hz[1] / step_hz).floor() as usize + 1;
        let frequency_hz: Array1<f64> = lines.clone().map(|k| k as f64 * step_hz).collect();
        let structure = Synthetic {
            natural_frequency_hz: self.natural_frequency_hz.clone(),
            loss_factor: self.damping_ratio.iter().map(|zeta| 2.0 * zeta).collect(),
            responses: self.responses,
            references: 1,
            damping: Damping::Viscous,
            frequency_hz,
            snr_db: f64::INFINITY,
            seed: self.seed,
            ..Synthetic::default()
        };
        Ok((structure.build()?.truth, lines))
    }

    fn check(&self) -> Result<()> {
        for (name, value) in [
            ("sample_rate_hz", self.sample_rate_hz),
            ("record_s", self.record_s),
            ("band_hz", self.band_hz[0]),
        ] {
            crate::checks::positive(name, value)?;
        }
        if self.averages == 0 || self.padding == 0 || self.snr_db.is_nan() {
            return Err(Error::bad_data(
                "a test needs a record, its transform and a noise level",
            ));
        }
        if self.band_hz[1] > 0.5 * self.sample_rate_hz || self.band_hz[0] >= self.band_hz[1] {
            return Err(Error::bad_data("the band does not fit the sampling")
                .field("band_hz")
                .found(format!("{:?}", self.band_hz))
                .expected(format!("rising, up to {} Hz", 0.5 * self.sample_rate_hz)));
        }
        Ok(())
    }

    fn oscillators(&self, truth: &ModalModel) -> Vec<Oscillator> {
        let dt = 1.0 / self.sample_rate_hz;
        let oscillator = |mode: &chladni_frf::Mode| {
            let omega = TAU * mode.frequency_hz;
            let damped = omega * (1.0 - mode.damping_ratio.powi(2)).sqrt();
            let pole = Complex64::new(-mode.damping_ratio * omega, damped);
            let e = (pole * dt).exp();
            let (i0, i1) = ((e - 1.0) / pole, (e - 1.0 - pole * dt) / (pole * pole * dt));
            let residue = |shape: &Complex64| {
                shape * mode.participation.0[0] / Complex64::new(0.0, 2.0 * damped)
            };
            let output = mode
                .shape
                .0
                .iter()
                .map(|shape| 2.0 * pole * residue(shape))
                .collect();
            Oscillator {
                state: Complex64::default(),
                step: [e, i0 - i1, i1],
                output,
            }
        };
        truth.modes.iter().map(oscillator).collect()
    }

    /// Force and velocities of each record, windowed: (channel, sample), the force last.
    fn records(&self, truth: &ModalModel, samples: usize) -> Vec<Array2<f64>> {
        let mut oscillators = self.oscillators(truth);
        let mut random = generator(self.seed, FORCE_STREAM);
        let continuous = self.excitation == Excitation::Random;
        let mut last_force = 0.0;
        let settling = if continuous { SETTLING_RECORDS } else { 0 };
        let mut records = Vec::with_capacity(self.averages);
        for record in 0..settling + self.averages {
            let force = self.force(samples, &mut random);
            let mut out = Array2::zeros((self.responses + 1, samples));
            if !continuous {
                last_force = 0.0;
                oscillators
                    .iter_mut()
                    .for_each(|o| o.state = Complex64::default());
            }
            for k in 0..samples {
                out[[self.responses, k]] = force[k];
                for o in &mut oscillators {
                    let [e, from, to] = o.step;
                    o.state = e * o.state + from * last_force + to * force[k];
                    for (i, gain) in o.output.iter().enumerate() {
                        out[[i, k]] += (gain * o.state).re;
                    }
                }
                last_force = force[k];
            }
            if record >= settling {
                records.push(out);
            }
        }
        self.add_noise(&mut records);
        let window: Array1<f64> = (0..samples)
            .map(|k| self.window_at(k as f64 / samples as f64))
            .collect();
        records
            .iter_mut()
            .for_each(|r| r.rows_mut().into_iter().for_each(|mut row| row *= &window));
        records
    }

    fn force(&self, samples: usize, random: &mut impl Rng) -> Vec<f64> {
        let mut normal = || -> f64 { random.sample(StandardNormal) };
        match self.excitation {
            Excitation::Hammer { contact_s } => {
                // blows differ in strength
                let strength = 1.0 + 0.1 * normal();
                let pulse = |t: f64| {
                    if t < contact_s {
                        strength * (PI * t / contact_s).sin()
                    } else {
                        0.0
                    }
                };
                (0..samples)
                    .map(|k| pulse(k as f64 / self.sample_rate_hz))
                    .collect()
            }
            Excitation::BurstRandom { part } => {
                let end = (part * samples as f64) as usize;
                (0..samples)
                    .map(|k| if k < end { normal() } else { 0.0 })
                    .collect()
            }
            Excitation::Random => (0..samples).map(|_| normal()).collect(),
        }
    }

    fn add_noise(&self, records: &mut [Array2<f64>]) {
        let mean_square = |r: &Array2<f64>| {
            r.slice(s![..self.responses, ..])
                .mapv(|v| v * v)
                .mean()
                .unwrap_or(0.0)
        };
        let mean_square = records.iter().map(mean_square).sum::<f64>() / records.len() as f64;
        let sigma = (mean_square * 10f64.powf(-self.snr_db / 10.0)).sqrt();
        let mut random = generator(self.seed, NOISE_STREAM);
        for record in records {
            record
                .slice_mut(s![..self.responses, ..])
                .mapv_inplace(|v| v + sigma * random.sample::<f64, _>(StandardNormal));
        }
    }

    /// The window at t/T.
    fn window_at(&self, t: f64) -> f64 {
        match self.window {
            BlockWindow::Rectangular => 1.0,
            BlockWindow::Hann => (PI * t).sin().powi(2),
            BlockWindow::Exponential { rate_per_s } => (-rate_per_s * t * self.record_s).exp(),
        }
    }

    /// H₁ = S_vf/S_ff on `lines` of the padded transform: (response, 1, line).
    fn h1(
        &self,
        records: &[Array2<f64>],
        lines: std::ops::Range<usize>,
        samples: usize,
    ) -> Array3<Complex64> {
        let size = samples * self.padding;
        let fft = fft::forward(size);
        let mut cross = Array3::<Complex64>::zeros((self.responses, 1, lines.len()));
        let mut auto = vec![0.0; lines.len()];
        for record in records {
            let spectrum = |channel: usize| {
                let mut buffer: Vec<Complex64> = record
                    .row(channel)
                    .iter()
                    .map(|v| Complex64::new(*v, 0.0))
                    .collect();
                buffer.resize(size, Complex64::default());
                fft.process(&mut buffer);
                buffer[lines.clone()].to_vec()
            };
            let force = spectrum(self.responses);
            auto.iter_mut()
                .zip(&force)
                .for_each(|(a, f)| *a += f.norm_sqr());
            for i in 0..self.responses {
                for ((c, v), f) in cross
                    .slice_mut(s![i, 0, ..])
                    .iter_mut()
                    .zip(spectrum(i))
                    .zip(&force)
                {
                    *c += v * f.conj();
                }
            }
        }
        for mut row in cross.rows_mut() {
            row.iter_mut().zip(&auto).for_each(|(c, a)| *c /= a);
        }
        cross
    }
}
