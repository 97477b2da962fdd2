//! The rig as it is: the true plate with its faults, and a scanner in front of it.

use super::fault::Faults;
use chladni_frf::{
    ComplexMatrix, FieldPoint, MeasuredField, ModalModel, ResidualTerm, ResidualTerms, Result,
};
use chladni_plate::PlateModes;
use chladni_render::{Field, Ground, Limits};
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// A plate to be driven: its modes, loss factors and actuators.
pub(super) struct Plate<'a> {
    pub(super) modes: &'a PlateModes,
    pub(super) loss_factors: Array1<f64>,
    pub(super) actuators_m: &'a [[f64; 2]],
    pub(super) frequency_hz: f64,
}

/// A rig with its faults.
pub(super) struct TrueRig {
    /// True mobility, faults in it, at the places that the scanner really looks at.
    mobility: Array2<Complex64>,
    faults: Faults,
    frequency_hz: f64,
}

impl TrueRig {
    /// The plate with `faults`, seen at the responses of `field`.
    ///
    /// # Errors
    /// A place off the plate.
    pub(super) fn new(plate: &Plate, mut faults: Faults, field: &Field) -> Result<Self> {
        let responses = &field.positions_m;
        let corner = |axis: usize| {
            let along = responses.iter().map(|place| place[axis]);
            let low = along.clone().fold(f64::INFINITY, f64::min);
            [low, along.fold(f64::NEG_INFINITY, f64::max)]
        };
        let [x, y] = [corner(0), corner(1)];
        let within = |[low, high]: [f64; 2], share: f64| low + (high - low) * share;
        let loads = faults.loads.iter();
        let loads_m: Vec<[f64; 2]> = loads
            .map(|load| [within(x, load.place[0]), within(y, load.place[1])])
            .collect();
        let error_m = faults.point_error_m;
        let mut off = || error_m * faults.random.normal();
        let scanned: Vec<[f64; 2]> = responses
            .iter()
            .map(|[a, b]| [(a + off()).clamp(x[0], x[1]), (b + off()).clamp(y[0], y[1])])
            .collect();
        let rows = [scanned.as_slice(), &loads_m].concat();
        let columns = [plate.actuators_m, &loads_m].concat();
        let mut mobility = plate.mobility(&rows, &columns, &mut faults)?;
        let [first_row, first_column] = [scanned.len(), plate.actuators_m.len()];
        for (k, load) in faults.loads.iter().enumerate() {
            let (row, column) = (first_row + k, first_column + k);
            let bound = load.what.impedance(plate.frequency_hz).inv() + mobility[[row, column]];
            let from = mobility.column(column).to_owned();
            let to = mobility.row(row).mapv(|value| value / bound);
            for (mut row, &from) in mobility.rows_mut().into_iter().zip(&from) {
                row.scaled_add(-from, &to);
            }
        }
        for (i, gain) in faults.gains.iter().enumerate() {
            mobility.column_mut(i).mapv_inplace(|value| value * gain);
        }
        Ok(Self {
            mobility: mobility.slice(s![..first_row, ..first_column]).to_owned(),
            faults,
            frequency_hz: plate.frequency_hz,
        })
    }

    /// Smaller share of hot and cold responses that a drive truly serves.
    pub(super) fn served(&self, drive: &Array1<Complex64>, field: &Field, limits: &Limits) -> f64 {
        let mut counts = [[0.0; 2]; 2];
        for (ground, value) in field.ground.iter().zip(self.mobility.dot(drive)) {
            let (kind, inside) = match ground {
                Ground::Hot => (0, limits.is_felt(value.norm())),
                Ground::Cold => (1, limits.is_quiet(value.norm())),
                Ground::Ignored => continue,
            };
            counts[kind][0] += 1.0;
            counts[kind][1] += f64::from(u8::from(inside));
        }
        (counts[0][1] / counts[0][0]).min(counts[1][1] / counts[1][0])
    }

    /// `model` with the true mobility in place of its modes.
    pub(super) fn known(&self, model: &ModalModel, field: &Field) -> ModalModel {
        let receptance = Complex64::new(0.0, TAU * self.frequency_hz).inv();
        let term = ResidualTerm {
            power: 0,
            matrix: ComplexMatrix(self.mobility.mapv(|value| value * receptance)),
        };
        ModalModel {
            responses: field.responses.clone(),
            modes: Vec::new(),
            residual_terms: ResidualTerms {
                terms: vec![term],
                ..model.residual_terms.clone()
            },
            ..model.clone()
        }
    }

    /// Field of a drive as the scanner tells it.
    pub(super) fn measured(&mut self, drive: &Array1<Complex64>, field: &Field) -> MeasuredField {
        let truth = self.mobility.dot(drive);
        let square = truth.iter().map(Complex64::norm_sqr).sum::<f64>() / truth.len() as f64;
        let std = self.faults.noise * square.sqrt();
        let random = &mut self.faults.random;
        let mut seen = |value: Complex64| {
            value + Complex64::new(random.normal(), random.normal()) * (std * FRAC_1_SQRT_2)
        };
        let points = field.responses.iter().zip(truth);
        MeasuredField {
            frequency_hz: self.frequency_hz,
            weights_sha256: None,
            magnitudes_only: false,
            points: points
                .map(|(&response, value)| FieldPoint {
                    response,
                    velocity_m_per_s: seen(value),
                    std_m_per_s: Some(std),
                    repeats: 1,
                })
                .collect(),
        }
    }
}

impl Plate<'_> {
    /// Mobility between places, natural frequencies shifted.
    fn mobility(
        &self,
        rows: &[[f64; 2]],
        columns: &[[f64; 2]],
        faults: &mut Faults,
    ) -> Result<Array2<Complex64>> {
        let omega = TAU * self.frequency_hz;
        let (shift, own) = (faults.shift, faults.own_shift);
        let factors: Array1<Complex64> = self
            .modes
            .omega()
            .iter()
            .zip(&self.loss_factors)
            .map(|(w, eta)| {
                let w = w * (1.0 + shift + own * faults.random.normal());
                Complex64::new(0.0, omega) / Complex64::new(w * w - omega * omega, w * w * eta)
            })
            .collect();
        let shapes = |places| Ok(self.modes.evaluate(places)?.mapv(Complex64::from));
        let [from, to]: [Array2<Complex64>; 2] = [shapes(columns)?, shapes(rows)?];
        Ok((to * factors).dot(&from.t()))
    }
}
