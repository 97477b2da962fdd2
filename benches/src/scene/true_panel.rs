//! The true plate under a drive: anywhere, drifted, and touched.

use crate::journal::nan;
use chladni_frf::Result;
use chladni_plate::{DampedPlate, Panel, PlateModes};
use chladni_render::{Field, Finger, Ground, Limits, ZoneMap};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Distance of the places on which drives are judged, m.
const GRID_M: f64 = 0.004;
/// Standard deviation of the drift of natural frequencies, relative.
const FREQUENCY_DRIFT: f64 = 1e-3;
/// The same of loss factors.
const LOSS_FACTOR_DRIFT: f64 = 0.1;

/// A plate with the shapes of its modes on a dense grid and at its actuators.
pub(crate) struct TruePanel {
    plate: DampedPlate,
    places_m: Vec<[f64; 2]>,
    at_places: Array2<f64>,
    at_actuators: Array2<f64>,
}

/// Shares of places that are served.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Served {
    /// Of hot places.
    #[serde(deserialize_with = "nan")]
    pub hot: f64,
    /// Of cold places.
    #[serde(deserialize_with = "nan")]
    pub cold: f64,
    /// Of both.
    #[serde(deserialize_with = "nan")]
    pub total: f64,
}

impl Served {
    /// The smaller share of hot and cold.
    pub fn least(&self) -> f64 {
        self.hot.min(self.cold)
    }
}

impl TruePanel {
    /// Judged on a grid over x_min, y_min, x_max, y_max.
    pub(crate) fn new(
        panel: &Panel,
        plate: DampedPlate,
        [x_min, y_min, x_max, y_max]: [f64; 4],
    ) -> Result<Self> {
        let axis = |low: f64, high: f64| {
            let steps = ((high - low) / GRID_M).round() as usize;
            (0..=steps).map(move |k| low + (high - low) * k as f64 / steps as f64)
        };
        let places_m: Vec<[f64; 2]> = axis(y_min, y_max)
            .flat_map(|y| axis(x_min, x_max).map(move |x| [x, y]))
            .collect();
        let at_places = plate.modes.evaluate(&places_m)?;
        let at_actuators = plate.modes.evaluate(&panel.layout().references_m)?;
        Ok(Self {
            plate,
            places_m,
            at_places,
            at_actuators,
        })
    }

    /// The modes of the plate.
    pub(crate) fn modes(&self) -> &PlateModes {
        &self.plate.modes
    }

    /// Their loss factors.
    pub(crate) fn loss_factors(&self) -> Array1<f64> {
        self.plate.loss_factors()
    }

    /// The shares that the drive serves on the plate as it is.
    pub(crate) fn free(
        &self,
        drive: &Array1<Complex64>,
        frequency_hz: f64,
        zones: &ZoneMap,
        limits: &Limits,
    ) -> Served {
        self.served(
            &self.field(drive, &self.factors(frequency_hz, None)),
            zones,
            limits,
        )
    }

    /// The shares that it serves at the responses of `field`.
    ///
    /// # Errors
    /// A response off the plate.
    pub(crate) fn at(
        &self,
        drive: &Array1<Complex64>,
        frequency_hz: f64,
        field: &Field,
        limits: &Limits,
    ) -> Result<Served> {
        let shapes = self
            .plate
            .modes
            .evaluate(&field.positions_m)?
            .mapv(Complex64::from);
        let velocity = shapes.dot(&(self.modal_force(drive) * self.factors(frequency_hz, None)));
        Ok(count(field.ground.iter().copied().zip(&velocity), limits))
    }

    /// The same after a random drift of every mode.
    pub(crate) fn drifted(
        &self,
        drive: &Array1<Complex64>,
        frequency_hz: f64,
        seed: u64,
        zones: &ZoneMap,
        limits: &Limits,
    ) -> Served {
        self.served(
            &self.field(drive, &self.factors(frequency_hz, Some(seed))),
            zones,
            limits,
        )
    }

    /// The same with `finger` at `place_m`: v − y_f (1/Z + Y_ff)⁻¹ v_f.
    ///
    /// # Errors
    /// The place lies off the plate.
    pub(crate) fn touched(
        &self,
        drive: &Array1<Complex64>,
        frequency_hz: f64,
        finger: &Finger,
        place_m: [f64; 2],
        zones: &ZoneMap,
        limits: &Limits,
    ) -> Result<Served> {
        let factors = self.factors(frequency_hz, None);
        let shape = self.plate.modes.evaluate(&[place_m])?.row(0).to_owned();
        let weighted = &shape.mapv(Complex64::from) * &factors;
        let own: Complex64 = weighted.iter().zip(&shape).map(|(a, b)| a * b).sum();
        let free: Complex64 = self
            .modal_force(drive)
            .iter()
            .zip(&weighted)
            .map(|(a, b)| a * b)
            .sum();
        let force = free / (finger.impedance(frequency_hz).inv() + own);
        let pressed = self.at_places.mapv(Complex64::from).dot(&weighted) * force;
        Ok(self.served(&(self.field(drive, &factors) - pressed), zones, limits))
    }

    /// The same at the responses of `field` alone.
    ///
    /// # Errors
    /// A place off the plate.
    pub(crate) fn touched_at(
        &self,
        drive: &Array1<Complex64>,
        frequency_hz: f64,
        finger: &Finger,
        place_m: [f64; 2],
        field: &Field,
        limits: &Limits,
    ) -> Result<Served> {
        let factors = self.factors(frequency_hz, None);
        let shapes = |places: &[[f64; 2]]| -> Result<Array2<Complex64>> {
            Ok(self.plate.modes.evaluate(places)?.mapv(Complex64::from))
        };
        let (here, there) = (shapes(&[place_m])?, shapes(&field.positions_m)?);
        let modal = self.modal_force(drive) * &factors;
        let weighted = &here.row(0) * &factors;
        let bound = finger.impedance(frequency_hz).inv() + here.row(0).dot(&weighted);
        let force = here.row(0).dot(&modal) / bound;
        let velocity = there.dot(&(modal - weighted.mapv(|value| value * force)));
        Ok(count(field.ground.iter().copied().zip(&velocity), limits))
    }

    /// jω/(ω_n²(1+jη_n) − ω²), drifted where a seed is given.
    fn factors(&self, frequency_hz: f64, seed: Option<u64>) -> Array1<Complex64> {
        let omega = TAU * frequency_hz;
        let mut rng = ChaCha8Rng::seed_from_u64(seed.unwrap_or(0));
        let mut normal = |size: f64| -> f64 {
            let value: f64 = StandardNormal.sample(&mut rng);
            if seed.is_some() {
                1.0 + size * value
            } else {
                1.0
            }
        };
        let modes = self
            .plate
            .modes
            .omega()
            .iter()
            .zip(self.plate.loss_factors());
        let poles: Vec<[f64; 2]> = modes
            .map(|(w, eta)| [w * normal(FREQUENCY_DRIFT), eta * normal(LOSS_FACTOR_DRIFT)])
            .collect();
        poles
            .iter()
            .map(|[w, eta]| {
                Complex64::new(0.0, omega) / Complex64::new(w * w - omega * omega, w * w * eta)
            })
            .collect()
    }

    fn modal_force(&self, drive: &Array1<Complex64>) -> Array1<Complex64> {
        self.at_actuators.t().mapv(Complex64::from).dot(drive)
    }

    fn field(&self, drive: &Array1<Complex64>, factors: &Array1<Complex64>) -> Array1<Complex64> {
        self.at_places
            .mapv(Complex64::from)
            .dot(&(self.modal_force(drive) * factors))
    }

    fn served(&self, field: &Array1<Complex64>, zones: &ZoneMap, limits: &Limits) -> Served {
        count(
            self.places_m
                .iter()
                .map(|&place| zones.classify(place))
                .zip(field),
            limits,
        )
    }
}

fn count<'a>(places: impl Iterator<Item = (Ground, &'a Complex64)>, limits: &Limits) -> Served {
    let mut counts = [[0.0; 2]; 2];
    for (ground, v) in places {
        let (kind, inside) = match ground {
            Ground::Hot => (0, limits.is_felt(v.norm())),
            Ground::Cold => (1, limits.is_quiet(v.norm())),
            Ground::Ignored => continue,
        };
        counts[kind][0] += 1.0;
        counts[kind][1] += if inside { 1.0 } else { 0.0 };
    }
    let [hot, cold] = counts;
    Served {
        hot: hot[1] / hot[0],
        cold: cold[1] / cold[0],
        total: (hot[1] + cold[1]) / (hot[0] + cold[0]),
    }
}
