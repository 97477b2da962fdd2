//! A true rig beside its model: gains that err, fingers, masses, and a noisy scanner.

use chladni_frf::{FieldPoint, FrfKind, MeasuredField};
use chladni_render::{Finger, Weights};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::FRAC_1_SQRT_2;

/// The panel of the tests as it truly is.
pub struct Rig {
    frequency_hz: f64,
    /// True mobility, responses × actuators, gains not yet in it.
    pub mobility: Array2<Complex64>,
    pub gains: Array1<Complex64>,
    random: ChaCha8Rng,
}

impl Rig {
    /// The panel without a fault.
    pub fn new(frequency_hz: f64, seed: u64) -> Self {
        Self {
            frequency_hz,
            mobility: super::truth().frf_matrix(FrfKind::Mobility, frequency_hz),
            gains: Array1::from_elem(34, Complex64::ONE),
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Amplifiers of an amplitude and a phase error.
    pub fn scattered(mut self, amplitude: f64, phase_deg: f64) -> Self {
        for i in 0..self.gains.len() {
            let size = 1.0 + amplitude * self.normal();
            let phase = phase_deg.to_radians() * self.normal();
            self.gains[i] *= Complex64::from_polar(size, phase);
        }
        self
    }

    /// Natural frequencies that all differ by a factor 1 + `shift`: temperature.
    pub fn shifted(mut self, shift: f64) -> Self {
        let mut panel = super::truth().clone();
        for mode in &mut panel.modes {
            mode.frequency_hz *= 1.0 + shift;
        }
        self.mobility = panel.frf_matrix(FrfKind::Mobility, self.frequency_hz);
        self
    }

    /// One channel with another gain.
    pub fn channel(mut self, channel: usize, gain: f64) -> Self {
        self.gains[channel] = gain.into();
        self
    }

    /// Something that is on the panel and stays there.
    pub fn loaded(mut self, load: &Finger, place_m: [f64; 2]) -> Self {
        let plate = &super::panel().plate;
        let layout = chladni_plate::Panel::default().layout();
        let at = |rows: &[[f64; 2]], columns: &[[f64; 2]]| {
            plate
                .mobility_matrix(rows, columns, self.frequency_hz)
                .unwrap()
        };
        let (y, h) = (
            at(&layout.responses_m, &[place_m]),
            at(&[place_m], &layout.references_m),
        );
        let own = at(&[place_m], &[place_m])[[0, 0]];
        let bound = (load.impedance(self.frequency_hz).inv() + own).inv();
        self.mobility -= &(y.dot(&h) * bound);
        self
    }

    /// The field that a drive truly makes.
    pub fn field(&self, drive: &Array1<Complex64>) -> Array1<Complex64> {
        self.mobility.dot(&(drive * &self.gains))
    }

    /// Weights in the order of the channels; those without one are still.
    pub fn drive(&self, weights: &Weights) -> Array1<Complex64> {
        let references = &super::truth().references;
        let weight = |dof| {
            weights
                .weights
                .iter()
                .find(|weight| weight.reference == dof)
        };
        let values = references.iter().map(|&dof| weight(dof));
        values
            .map(|weight| weight.map_or(Complex64::ZERO, |weight| weight.value()))
            .collect()
    }

    /// The field that a scanner measures, at the responses `rows`, with noise over the
    /// rms.
    pub fn measured(&mut self, weights: &Weights, noise: f64, rows: &[usize]) -> MeasuredField {
        let field = self.field(&self.drive(weights));
        let rms = (field.iter().map(Complex64::norm_sqr).sum::<f64>() / field.len() as f64).sqrt();
        let field = field.select(Axis(0), rows);
        let frequency_hz = self.frequency_hz;
        let points = rows.iter().zip(&field).map(|(&row, &value)| {
            let noise =
                Complex64::new(self.normal(), self.normal()) * (noise * rms * FRAC_1_SQRT_2);
            FieldPoint {
                response: super::truth().responses[row],
                velocity_m_per_s: value + noise,
                std_m_per_s: None,
                repeats: 1,
            }
        });
        let mut field = MeasuredField {
            frequency_hz,
            weights_sha256: None,
            magnitudes_only: false,
            points: points.collect(),
        };
        for point in &mut field.points {
            point.std_m_per_s = Some(noise * rms);
        }
        field
    }
}

/// The same without phases.
pub fn magnitudes(mut field: MeasuredField) -> MeasuredField {
    field.magnitudes_only = true;
    for point in &mut field.points {
        point.velocity_m_per_s = point.velocity_m_per_s.norm().into();
        point.std_m_per_s = point.std_m_per_s.map(|std| std * FRAC_1_SQRT_2);
    }
    field
}
