//! The two routes to the scale of a shape, both on shapes of the nominal plate.
//!
//! A measured shape s on the responses and l on the references, with s⊗l its residue, is ψ up
//! to t: s = tψ|S, l = ψ|T/t. On the shapes b of the nominal plate (geometry, Poisson's ratio,
//! coils):
//!
//! - continuity: αs on S and βl on T are one shape where [αs; βl] lies in the span of b; the
//!   smallest eigenvector of the Gram matrix of what lies outside it gives t⁻² = α/β;
//! - mass: s = Σ c_n b_n has the modal mass Σ c_n² = t².
//!
//! A wrong Poisson's ratio changes b and hardly their span.

use super::places::Places;
use super::rigid::RigidBody;
use super::ScaleRoute;
use crate::modes::PlateModes;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Mode, Result};
use chladni_linalg::{eigh, lstsq, qr_thin};
use ndarray::{concatenate, s, Array1, Array2, Axis};
use num_complex::Complex64;

/// Factors t⁻² on ss† that make it ψψᵀ, by each route.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    continuity: f64,
    mass: f64,
}

impl Scales {
    pub(super) fn of(&self, route: ScaleRoute) -> f64 {
        match route {
            ScaleRoute::Continuity => self.continuity,
            ScaleRoute::Mass => self.mass,
        }
    }

    /// Relative difference; infinite where signs contradict.
    pub(super) fn difference(&self) -> f64 {
        match self.continuity > 0.0 && self.mass > 0.0 {
            true => (self.continuity / self.mass).ln().abs(),
            false => f64::INFINITY,
        }
    }
}

/// Shapes of the nominal plate at all places.
pub(super) struct Routes {
    /// At the responses; axes (place, shape).
    responses: Array2<f64>,
    /// Orthonormal basis of the same over responses and references together.
    span: Array2<f64>,
    /// Gain of each channel.
    gains: Array1<f64>,
    /// True mass over that of the nominal plate.
    mass_ratio: f64,
}

impl Routes {
    /// # Errors
    /// A place off the plate; too few responses.
    pub(super) fn new(
        ritz: &PlateModes,
        places: &Places,
        rigid: Option<&RigidBody>,
        mass_ratio: f64,
    ) -> Result<Self> {
        let [rows, columns] = [&places.responses_m, &places.references_m].map(Vec::len);
        let share = (tolerances::SCALING_SHARE * rows as f64) as usize;
        let count = share.min(tolerances::MOST_SCALING_SHAPES).min(ritz.len());
        if count < tolerances::LEAST_SCALING_SHAPES {
            return Err(Error::bad_data("too few responses to follow a shape")
                .field("scaling")
                .found(format!("{rows} responses"))
                .expected(format!(
                    "at least {:.0}",
                    tolerances::LEAST_SCALING_SHAPES as f64 / tolerances::SCALING_SHARE
                ))
                .help("measure a driving point, or more responses"));
        }
        let at = |places: &[[f64; 2]]| -> Result<Array2<f64>> {
            Ok(ritz.evaluate(places)?.slice(s![.., ..count]).to_owned())
        };
        let [responses, references] = [at(&places.responses_m)?, at(&places.references_m)?];
        let both = concatenate![Axis(0), responses, references];
        let (span, _) = qr_thin(both.view()).map_err(unsolvable)?;
        let gains = match rigid {
            Some(body) => Array1::from_vec(body.gains.clone()),
            None => Array1::ones(columns),
        };
        Ok(Self {
            responses,
            span,
            gains,
            mass_ratio,
        })
    }

    /// The factors of a mode; `None` where it has no motion.
    pub(super) fn scales(&self, mode: &Mode, places: &Places) -> Result<Option<Scales>> {
        let turn = mean_phase(&mode.shape.0);
        let along = |values: &[Complex64], signs: &[f64], turn: Complex64| -> Array1<f64> {
            let pairs = values.iter().zip(signs);
            pairs
                .map(|(value, sign)| (value * turn).re * sign)
                .collect()
        };
        let own = along(&mode.shape.0, &places.response_signs, turn.conj());
        let other = along(&mode.participation.0, &places.reference_signs, turn) / &self.gains;
        let [a, b] = [&own, &other].map(|values| values.dot(values).sqrt());
        if !(a > 0.0 && b > 0.0) {
            return Ok(None);
        }
        let mut columns = Array2::zeros((own.len() + other.len(), 2));
        columns.slice_mut(s![..own.len(), 0]).assign(&(&own / a));
        columns.slice_mut(s![own.len().., 1]).assign(&(&other / b));
        let outside = &columns - &self.span.dot(&self.span.t().dot(&columns));
        let gram = outside.t().dot(&outside);
        let (_, vectors) = eigh(gram.view()).map_err(unsolvable)?;
        let [alpha, beta] = [vectors[[0, 0]] / a, vectors[[1, 0]] / b];
        let column = own.insert_axis(Axis(1));
        let parts = lstsq(self.responses.view(), column.view()).map_err(unsolvable)?;
        let modal_mass = self.mass_ratio * parts.iter().map(|part| part * part).sum::<f64>();
        Ok(Some(Scales {
            continuity: alpha / beta,
            mass: modal_mass.recip(),
        }))
    }
}

/// Phase, as a unit number, that most of a shape lies along.
fn mean_phase(shape: &[Complex64]) -> Complex64 {
    let square: Complex64 = shape.iter().map(|value| value * value).sum();
    Complex64::from_polar(1.0, 0.5 * square.arg())
}

fn unsolvable(error: chladni_linalg::LinalgError) -> Error {
    Error::new(
        ErrorKind::Internal,
        format!("the shapes of the panel cannot be solved: {error}"),
    )
}
