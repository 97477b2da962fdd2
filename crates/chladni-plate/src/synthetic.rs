//! FRFs of abstract modes, without a plate: tests of identification need to choose
//! frequencies, damping and shapes freely.
//!
//! Shapes are random; the first references are driving points (reference j is response
//! j), so that the truth is mass-normalised.

use crate::noise::{add_white_noise, circular, generator, mean_square};
use crate::response::synthesise_by_products;
use chladni_frf::{
    ComplexMatrix, ComplexVector, Damping, Direction, Dof, Error, FrfKind, FrfSet, FrfValues,
    Geometry, ModalModel, Mode, Quality, ReferenceUnit, ResidualTerm, ResidualTerms, Result,
    Scaling, Trust, CREATED_BY, MODEL_FORMAT,
};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// Random streams of shapes and residual terms: the same seed makes independent noise.
const SHAPE_STREAM: u64 = 1 << 62;
const RESIDUAL_STREAM: u64 = (1 << 62) + 1;

/// Kind of the shapes of the modes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SyntheticShapes {
    /// Real Gaussian entries.
    Real,
    /// Real Gaussian entries, each turned by a Gaussian angle of this standard deviation.
    Turned {
        /// Degrees.
        phase_deg: f64,
    },
    /// Circular complex Gaussian entries.
    Complex,
}

/// Settings of the synthetic set.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthetic {
    /// Natural frequencies ω_n/2π, Hz, in any order; two equal ones are a repeated pole.
    pub natural_frequency_hz: Vec<f64>,
    /// η_n, one per mode, or one for all.
    pub loss_factor: Vec<f64>,
    /// Number of responses, nodes 1, 2, ...
    pub responses: usize,
    /// Number of references: the nodes of the first responses, further ones from the next
    /// label on.
    pub references: usize,
    /// Shapes.
    pub shapes: SyntheticShapes,
    /// Damping law.
    pub damping: Damping,
    /// Kind of the FRFs.
    pub kind: FrfKind,
    /// Frequency axis, Hz.
    pub frequency_hz: Array1<f64>,
    /// Band that decides which modes are `in_band`, Hz; `None`: the axis from end to end.
    pub band_hz: Option<[f64; 2]>,
    /// Powers of ω (in receptance) of residual terms with random real matrices, symmetric
    /// over the nodes.
    pub residual_powers: Vec<i32>,
    /// Size of each residual term at the top of the axis, relative to the root mean
    /// square of the modal receptance.
    pub residual_level: f64,
    /// Noise level below the mean square of all values, dB; infinite: no noise.
    pub snr_db: f64,
    /// Seed of shapes, residual terms and noise.
    pub seed: u64,
}

impl Default for Synthetic {
    /// Three separate modes, ten FRFs, 40 dB.
    fn default() -> Self {
        Self {
            natural_frequency_hz: vec![40.0, 70.0, 110.0],
            loss_factor: vec![0.01],
            responses: 5,
            references: 2,
            shapes: SyntheticShapes::Real,
            damping: Damping::Structural,
            kind: FrfKind::Mobility,
            frequency_hz: Array1::range(10.0, 150.0, 0.1),
            band_hz: None,
            residual_powers: Vec::new(),
            residual_level: 0.1,
            snr_db: 40.0,
            seed: 1,
        }
    }
}

/// FRFs of chosen modes, and their truth.
#[derive(Debug, Clone)]
pub struct SyntheticSet {
    /// FRFs with noise.
    pub frf: FrfSet,
    /// Model whose synthesis gives the FRFs without noise.
    pub truth: ModalModel,
    /// E|n|² of the noise, in the measured kind's unit squared.
    pub noise_variance: f64,
}

impl Synthetic {
    /// Makes the set; the same specification gives the same bits.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] for sizes that do not fit or numbers that are
    /// no frequency or damping.
    pub fn build(&self) -> Result<SyntheticSet> {
        self.check()?;
        let truth = self.truth();
        let mut values = synthesise_by_products(&truth, &self.frequency_hz);
        let noise_variance = add_white_noise(&mut values, self.snr_db, self.seed)?;
        let relative_error = (noise_variance / mean_square(&values)).sqrt();
        let frf = FrfSet {
            frequency_hz: self.frequency_hz.clone(),
            values: FrfValues::F64(values),
            responses: truth.responses.clone(),
            references: truth.references.clone(),
            kind: Some(self.kind),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        };
        let quality = Quality {
            relative_error,
            ..truth.quality.clone()
        };
        Ok(SyntheticSet {
            frf: frf.checked()?,
            truth: ModalModel { quality, ..truth },
            noise_variance,
        })
    }

    fn check(&self) -> Result<()> {
        let modes = self.natural_frequency_hz.len();
        if self.loss_factor.len() != 1 && self.loss_factor.len() != modes {
            return Err(Error::bad_data("sizes disagree")
                .field("loss_factor")
                .found(self.loss_factor.len())
                .expected(format!("1 or {modes}, as many as frequencies")));
        }
        if self.responses == 0 || self.references == 0 || self.frequency_hz.is_empty() {
            return Err(Error::bad_data(
                "a set needs a response, a reference and a line",
            ));
        }
        self.natural_frequency_hz
            .iter()
            .try_for_each(|&f| crate::checks::positive("natural_frequency_hz", f))?;
        self.loss_factor
            .iter()
            .try_for_each(|&eta| crate::checks::positive("loss_factor", eta))?;
        match self
            .loss_factor
            .iter()
            .find(|eta| self.damping == Damping::Viscous && **eta >= 2.0)
        {
            Some(eta) => Err(Error::bad_data("a viscous mode must vibrate")
                .field("loss_factor")
                .found(eta)
                .expected("below 2, twice critical")),
            None => Ok(()),
        }
    }

    fn band_hz(&self) -> [f64; 2] {
        self.band_hz.unwrap_or([
            self.frequency_hz[0],
            self.frequency_hz[self.frequency_hz.len() - 1],
        ])
    }

    fn truth(&self) -> ModalModel {
        let nodes = self.responses.max(self.references);
        let dofs = |count: usize| {
            (1..=count)
                .map(|node| Dof::new(node as u64, Direction::PLUS_Z))
                .collect()
        };
        let mut order: Vec<usize> = (0..self.natural_frequency_hz.len()).collect();
        order.sort_by(|&a, &b| {
            self.natural_frequency_hz[a].total_cmp(&self.natural_frequency_hz[b])
        });
        let mut random = generator(self.seed, SHAPE_STREAM);
        let modes = order
            .into_iter()
            .map(|n| {
                self.mode(
                    n,
                    (0..nodes).map(|_| self.shape_entry(&mut random)).collect(),
                )
            })
            .collect();
        let mut model = ModalModel {
            format: MODEL_FORMAT.into(),
            version: 1,
            created_by: CREATED_BY.into(),
            source: Vec::new(),
            options: Default::default(),
            frf_kind: self.kind,
            reference_unit: ReferenceUnit::Newton,
            band_hz: self.band_hz(),
            damping: self.damping,
            scaling: Scaling::UnitModalMass,
            responses: dofs(self.responses),
            references: dofs(self.references),
            nodes: Vec::new(),
            lines: Vec::new(),
            faces: Vec::new(),
            method: "synthetic".into(),
            modes,
            residual_terms: ResidualTerms {
                omega_scale_rad_per_s: TAU * self.frequency_hz[self.frequency_hz.len() - 1],
                terms: Vec::new(),
            },
            quality: Quality {
                relative_error: 0.0,
                chi2_per_dof: 1.0,
                trusted: true,
                findings: Vec::new(),
                path: None,
            },
        };
        model.residual_terms.terms = self.residual_terms(&model);
        model
    }

    fn shape_entry(&self, random: &mut impl Rng) -> Complex64 {
        let mut normal = || -> f64 { random.sample(StandardNormal) };
        // the same real numbers for every kind of shape
        let (re, im) = (normal(), normal());
        match self.shapes {
            SyntheticShapes::Real => Complex64::new(re, 0.0),
            SyntheticShapes::Turned { phase_deg } => {
                Complex64::from_polar(re, (phase_deg * im).to_radians())
            }
            SyntheticShapes::Complex => Complex64::new(re, im) * std::f64::consts::FRAC_1_SQRT_2,
        }
    }

    fn mode(&self, n: usize, shape: Vec<Complex64>) -> Mode {
        let frequency_hz = self.natural_frequency_hz[n];
        let loss_factor = if self.loss_factor.len() == 1 {
            self.loss_factor[0]
        } else {
            self.loss_factor[n]
        };
        let band_hz = self.band_hz();
        Mode {
            frequency_hz,
            frequency_std_hz: 0.0,
            loss_factor,
            loss_factor_std: 0.0,
            damping_ratio: loss_factor / 2.0,
            in_band: band_hz[0] <= frequency_hz && frequency_hz <= band_hz[1],
            trust: Trust::Sure,
            reasons: Default::default(),
            mpc: phase_collinearity(&shape[..self.responses]),
            shape: ComplexVector(shape[..self.responses].to_vec()),
            shape_std: vec![0.0; self.responses],
            scale_std: None,
            participation: ComplexVector(shape[..self.references].to_vec()),
        }
    }

    fn residual_terms(&self, modal: &ModalModel) -> Vec<ResidualTerm> {
        let receptance = ModalModel {
            frf_kind: FrfKind::Receptance,
            ..modal.clone()
        };
        let level = self.residual_level
            * mean_square(&synthesise_by_products(&receptance, &self.frequency_hz)).sqrt();
        let mut random = generator(self.seed, RESIDUAL_STREAM);
        let nodes = self.responses.max(self.references);
        let terms = self.residual_powers.iter().map(|&power| {
            // symmetric over the nodes, as reciprocity asks
            let draws =
                Array2::from_shape_simple_fn((nodes, nodes), || circular(&mut random).re * level);
            let entry = |(i, j): (usize, usize)| Complex64::new(draws[[i.min(j), i.max(j)]], 0.0);
            ResidualTerm {
                power,
                matrix: ComplexMatrix(Array2::from_shape_fn(
                    (self.responses, self.references),
                    entry,
                )),
            }
        });
        terms.collect()
    }
}

/// Modal phase collinearity: 1 for a shape whose entries lie on a line through zero
/// (Pappa, Elliott and Schenk, *J. Guidance* 16, 1993, 852-858; without removing the
/// mean, as for mode shapes of a plate).
fn phase_collinearity(shape: &[Complex64]) -> f64 {
    let power: f64 = shape.iter().map(|v| v.norm_sqr()).sum();
    let square: Complex64 = shape.iter().map(|v| v * v).sum();
    if power > 0.0 {
        (square.norm() / power).powi(2)
    } else {
        1.0
    }
}
