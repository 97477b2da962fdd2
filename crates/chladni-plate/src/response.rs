//! FRFs of a damped plate: the modal sum, exact for the modes that are kept.
//!
//! α(x, y; ω) = −Σ_rigid ψ_n(x) ψ_n(y)/ω² + Σ_elastic ψ_n(x) ψ_n(y) / (ω_n² (1 + jη_n) −
//! ω²)
//!
//! with mass-normalised ψ and structural damping (Ewins, *Modal Testing*, 2nd ed.,
//! section 2.5); mobility is jω α, accelerance −ω² α.

use crate::modes::PlateModes;
use crate::panel::Panel;
use crate::plate::{LossFactor, Plate};
use crate::point_mass::PointMass;
use crate::point_spring::PointSpring;
use crate::tolerances::{BAND_FACTOR, LEAST_MODES, MOST_LOSS_FACTOR};
use chladni_frf::{Damping, Error, FrfKind, ModalModel, Mode, Result, Trust};
use chladni_linalg::matmul;
use ndarray::{Array1, Array2, Array3, ArrayView2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A plate with damping, ready to be asked for FRFs anywhere.
///
/// ```
/// use chladni_plate::{DampedPlate, Plate};
/// let panel = DampedPlate::new(&Plate::default(), &[], 100.0).unwrap();
/// let centre = [[0.134, 0.085]];
/// let mobility = panel.mobility_matrix(&centre, &centre, 54.4).unwrap();
/// assert!(mobility[[0, 0]].re > 0.0, "a driving point takes power");
/// ```
#[derive(Debug, Clone)]
pub struct DampedPlate {
    /// Undamped modes, rigid-body modes first.
    pub modes: PlateModes,
    /// Loss factor of the elastic modes.
    pub loss_factor: LossFactor,
}

impl DampedPlate {
    /// A plate loaded by `masses`, with every mode up to four times `band_top_hz` and 60
    /// at least.
    ///
    /// # Errors
    /// As [`PlateModes::up_to`].
    pub fn new(plate: &Plate, masses: &[PointMass], band_top_hz: f64) -> Result<Self> {
        let modes = PlateModes::up_to(plate, masses, BAND_FACTOR * band_top_hz, LEAST_MODES)?;
        Ok(Self {
            modes,
            loss_factor: plate.loss_factor.clone(),
        })
    }

    /// The plate of a panel under its actuators, with every mode up to four times
    /// `band_top_hz` and 60 at least.
    ///
    /// Dampers enter the loss factor of each elastic mode, η_n + c·Σψ_n²(x_k)/ω_n; that they
    /// couple modes, and damp rigid-body motions, is left out: both are small where c is far
    /// below ω_n times the modal mass.
    ///
    /// # Errors
    /// As [`PlateModes::up_to`].
    pub fn of_panel(panel: &Panel, band_top_hz: f64) -> Result<Self> {
        let layout = panel.layout();
        let top_hz = BAND_FACTOR * band_top_hz;
        let (plate, frame) = (&panel.plate, &panel.references);
        let springs = layout.references_m.iter().map(|&position_m| PointSpring {
            position_m,
            stiffness_n_per_m: frame.stiffness_n_per_m,
        });
        let springs: Vec<PointSpring> = springs.collect();
        let modes = PlateModes::held(plate, &layout.masses, &springs, top_hz, LEAST_MODES)?;
        if frame.damping_n_s_per_m == 0.0 {
            return Ok(Self {
                modes,
                loss_factor: plate.loss_factor.clone(),
            });
        }
        let shapes = modes.evaluate(&layout.references_m)?;
        let rigid = modes.rigid_count();
        let of_mode = |n: usize| {
            let moved: f64 = shapes.column(n).iter().map(|value| value * value).sum();
            let own = plate.loss_factor.of_mode(n - rigid);
            own + frame.damping_n_s_per_m * moved / modes.omega()[n]
        };
        let loss_factors: Vec<f64> = (rigid..modes.len()).map(of_mode).collect();
        let largest = loss_factors.iter().copied().fold(0.0, f64::max);
        if largest > MOST_LOSS_FACTOR {
            let damping = frame.damping_n_s_per_m;
            let own = plate.loss_factor.entries().iter().copied();
            let room = MOST_LOSS_FACTOR - own.fold(0.0, f64::max);
            let most = damping * room / (largest - MOST_LOSS_FACTOR + room);
            return Err(
                Error::bad_data("the dampers are too strong for damped modes")
                    .field("references.damping_n_s_per_m")
                    .found(format!("{damping}, a loss factor of {largest:.3}"))
                    .expected(format!(
                    "at most about {most:.3}, so that loss factors stay below {MOST_LOSS_FACTOR}"
                ))
                    .help("a damper that holds its point still is a spring: stiffness_n_per_m"),
            );
        }
        let loss_factor = LossFactor::PerMode(loss_factors);
        Ok(Self { modes, loss_factor })
    }

    /// Loss factor of each mode, zero for rigid-body modes.
    pub fn loss_factors(&self) -> Array1<f64> {
        let rigid = self.modes.rigid_count();
        (0..self.modes.len())
            .map(|n| {
                if n < rigid {
                    0.0
                } else {
                    self.loss_factor.of_mode(n - rigid)
                }
            })
            .collect()
    }

    /// Factors of ψ_n(x) ψ_n(y) in an FRF of `kind`; axes (mode, line).
    pub fn modal_factors(&self, kind: FrfKind, frequency_hz: &Array1<f64>) -> Array2<Complex64> {
        let loss_factors = self.loss_factors();
        Array2::from_shape_fn((self.modes.len(), frequency_hz.len()), |(n, k)| {
            let (omega, omega_n2) = (TAU * frequency_hz[k], self.modes.omega()[n].powi(2));
            kind.from_receptance(omega)
                / Complex64::new(omega_n2 - omega * omega, omega_n2 * loss_factors[n])
        })
    }

    /// FRFs of `kind` between points, m/N, m/s/N or m/s²/N; axes (response, reference,
    /// line).
    ///
    /// # Errors
    /// A point off the plate.
    pub fn frfs(
        &self,
        kind: FrfKind,
        responses_m: &[[f64; 2]],
        references_m: &[[f64; 2]],
        frequency_hz: &Array1<f64>,
    ) -> Result<Array3<Complex64>> {
        let shapes = |points| Ok(self.modes.evaluate(points)?.mapv(Complex64::from));
        let (left, right): (Array2<Complex64>, Array2<Complex64>) =
            (shapes(responses_m)?, shapes(references_m)?);
        Ok(superpose(
            left.view(),
            right.view(),
            self.modal_factors(kind, frequency_hz).view(),
        ))
    }

    /// Mobility between points at one frequency, (m/s)/N; axes (response, reference).
    ///
    /// # Errors
    /// A point off the plate.
    pub fn mobility_matrix(
        &self,
        responses_m: &[[f64; 2]],
        references_m: &[[f64; 2]],
        frequency_hz: f64,
    ) -> Result<Array2<Complex64>> {
        let axis = Array1::from_elem(1, frequency_hz);
        Ok(self
            .frfs(FrfKind::Mobility, responses_m, references_m, &axis)?
            .index_axis_move(Axis(2), 0))
    }
}

/// FRFs of a modal model on a frequency axis: the same numbers as
/// [`ModalModel::synthesise`] by matrix products, many times faster.
pub fn synthesise_by_products(model: &ModalModel, frequency_hz: &Array1<f64>) -> Array3<Complex64> {
    let modes: Vec<&Mode> = model
        .modes
        .iter()
        .filter(|mode| mode.trust != Trust::Rejected)
        .collect();
    let kind = |f: f64| model.frf_kind.from_receptance(TAU * f);
    let columns = |pick: &dyn Fn(&Mode) -> Vec<Complex64>, rows: usize| {
        let mut all = Array2::zeros((rows, modes.len()));
        for (mut column, mode) in all.columns_mut().into_iter().zip(&modes) {
            column.assign(&Array1::from(pick(mode)));
        }
        all
    };
    let left = columns(&|mode| mode.shape.0.clone(), model.responses.len());
    let right = columns(&|mode| mode.participation.0.clone(), model.references.len());
    let factors = |half: usize| {
        Array2::from_shape_fn((modes.len(), frequency_hz.len()), |(n, k)| {
            let factors = modes[n].receptance_factors(model.damping, TAU * frequency_hz[k]);
            kind(frequency_hz[k]) * factors[half]
        })
    };
    let mut frf = superpose(left.view(), right.view(), factors(0).view());
    if model.damping == Damping::Viscous {
        // the half of conjugates is a superposition of its own
        let [left, right] = [left, right].map(|columns| columns.mapv(|v| v.conj()));
        frf = frf + superpose(left.view(), right.view(), factors(1).view());
    }
    for term in &model.residual_terms.terms {
        for (k, &f) in frequency_hz.iter().enumerate() {
            let scale =
                kind(f) * (TAU * f / model.residual_terms.omega_scale_rad_per_s).powi(term.power);
            frf.index_axis_mut(Axis(2), k)
                .scaled_add(scale, &term.matrix.0);
        }
    }
    frf
}

/// Σ_n left_in right_jn factor_nk; axes (i, j, k). One product per response, so that the
/// bits do not depend on the threads.
fn superpose(
    left: ArrayView2<Complex64>,
    right: ArrayView2<Complex64>,
    factors: ArrayView2<Complex64>,
) -> Array3<Complex64> {
    let mut sum = Array3::zeros((left.nrows(), right.nrows(), factors.ncols()));
    let rows: Vec<_> = sum.outer_iter_mut().zip(left.rows()).collect();
    rows.into_par_iter()
        .for_each(|(mut frf, shape)| frf.assign(&matmul((&right * &shape).view(), factors)));
    sum
}
