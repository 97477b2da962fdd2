//! The modal model: what a fit saves.
//!
//! The fields are those of the model file (`docs/formats.md`); the file alone reproduces
//! the fit.

use crate::finding::{numbered, warnings};
use crate::limits::ROUNDING;
use crate::{Dof, Finding, FrfKind, Geometry, Node, Reasons, ReferenceUnit, Source};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Value of `format` in a model file.
pub const MODEL_FORMAT: &str = "chladni.model";

/// A complex vector, as `{"re": [...], "im": [...]}` in files.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "SplitVector", into = "SplitVector")]
pub struct ComplexVector(pub Vec<Complex64>);

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SplitVector {
    re: Vec<f64>,
    im: Vec<f64>,
}

impl From<ComplexVector> for SplitVector {
    fn from(vector: ComplexVector) -> Self {
        Self {
            re: vector.0.iter().map(|c| c.re).collect(),
            im: vector.0.iter().map(|c| c.im).collect(),
        }
    }
}

impl TryFrom<SplitVector> for ComplexVector {
    type Error = String;
    fn try_from(split: SplitVector) -> Result<Self, String> {
        if split.re.len() != split.im.len() {
            return Err(format!(
                "re has {} entries and im {}",
                split.re.len(),
                split.im.len()
            ));
        }
        Ok(Self(
            split
                .re
                .into_iter()
                .zip(split.im)
                .map(|(re, im)| Complex64::new(re, im))
                .collect(),
        ))
    }
}

/// A complex matrix, as `{"re": [[...]], "im": [[...]]}` in files, row by row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SplitMatrix", into = "SplitMatrix")]
pub struct ComplexMatrix(pub Array2<Complex64>);

impl ComplexMatrix {
    /// The matrix with these real and imaginary parts, row by row.
    ///
    /// # Errors
    /// The complaint that they are no rectangles of one size.
    pub fn of_parts(re: &[Vec<f64>], im: &[Vec<f64>]) -> Result<Self, &'static str> {
        let columns = re.first().map_or(0, Vec::len);
        let even = |rows: &[Vec<f64>]| rows.iter().all(|row| row.len() == columns);
        if re.len() != im.len() || !even(re) || !even(im) {
            return Err("re and im must be rectangular and of one size");
        }
        Ok(Self(Array2::from_shape_fn(
            (re.len(), columns),
            |(i, j)| Complex64::new(re[i][j], im[i][j]),
        )))
    }
}

#[derive(Serialize, Deserialize)]
struct SplitMatrix {
    re: Vec<Vec<f64>>,
    im: Vec<Vec<f64>>,
}

impl From<ComplexMatrix> for SplitMatrix {
    fn from(matrix: ComplexMatrix) -> Self {
        let part = |f: fn(&Complex64) -> f64| {
            matrix
                .0
                .rows()
                .into_iter()
                .map(|row| row.iter().map(f).collect())
                .collect()
        };
        Self {
            re: part(|c| c.re),
            im: part(|c| c.im),
        }
    }
}

impl TryFrom<SplitMatrix> for ComplexMatrix {
    type Error = &'static str;
    fn try_from(split: SplitMatrix) -> Result<Self, &'static str> {
        Self::of_parts(&split.re, &split.im)
    }
}

/// Damping law of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Damping {
    /// Hysteretic: ω_n²(1 + jη_n) − ω².
    Structural,
    /// Viscous: poles s_n = −ζ_nω_n + jω_n√(1−ζ_n²), η_n = 2ζ_n.
    Viscous,
}

impl Damping {
    /// The law that this one is weighed against.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Structural => Self::Viscous,
            Self::Viscous => Self::Structural,
        }
    }
}

/// Scaling of the shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scaling {
    /// Λ_n = 1: shape and participation hold the same mass-normalised ψ_n, kg^{-1/2}.
    UnitModalMass,
    /// Largest |shape| is 1; participation carries the rest.
    Unscaled,
}

/// Degree of trust in a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Trust {
    /// More likely absent than present; listed only on request, never part of the
    /// synthesis.
    Rejected,
    /// Kept, with reasons for doubt.
    Weak,
    /// Kept, no reason for doubt found.
    Sure,
}

/// One mode, or an out-of-band pole (`in_band` false) that serves as residual term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// ω_n/2π, undamped, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz, one sigma.
    pub frequency_std_hz: f64,
    /// η_n; 2ζ_n in the viscous law.
    pub loss_factor: f64,
    /// Standard deviation of η_n, one sigma.
    pub loss_factor_std: f64,
    /// η_n/2 in both laws.
    pub damping_ratio: f64,
    /// Inside `band_hz`; false marks out-of-band poles (residual terms).
    pub in_band: bool,
    /// Grade.
    pub trust: Trust,
    /// The reasons that it is not `sure`.
    #[serde(flatten)]
    pub reasons: Reasons,
    /// Modal phase collinearity of the shape, 0..=1 (1: real).
    pub mpc: f64,
    /// ψ_n at the responses.
    pub shape: ComplexVector,
    /// √E|δψ|² per response, in the shape's scaling.
    pub shape_std: Vec<f64>,
    /// Relative standard deviation of the scale to unit modal mass, which `shape_std`
    /// includes: shape and participation share it, so that it is no error of their
    /// product. `None` where shapes are not scaled, or it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale_std: Option<f64>,
    /// ψ_n at the references, times whatever scale the shape does not carry.
    pub participation: ComplexVector,
}

impl Mode {
    /// True for a mode of the band that was not rejected: tables number these, and all
    /// other modes are residual terms.
    pub fn counts(&self) -> bool {
        self.in_band && self.trust != Trust::Rejected
    }

    /// `shape_std` of a response without the error of the scale: what is left of it in
    /// FRFs, where the participation has the scale's inverse.
    pub fn shape_std_at_known_scale(&self, response: usize) -> f64 {
        self.shape_variance_at_known_scale(response).sqrt()
    }

    /// The square of [`Self::shape_std_at_known_scale`].
    #[inline]
    pub fn shape_variance_at_known_scale(&self, response: usize) -> f64 {
        let of_scale = self.scale_std.unwrap_or(0.0).powi(2) * self.shape.0[response].norm_sqr();
        (self.shape_std[response].powi(2) - of_scale).max(0.0)
    }

    /// `shape_std` without what only scales the whole shape: what is left of it in the
    /// MAC.
    ///
    /// A shape that is scaled to 1 at its largest response has that response's error in
    /// all others, std_i² = σ_i² + |ψ_i/ψ_m|²·σ_m², and none at itself but rounding; σ_m
    /// is taken as the root mean square of the others.
    pub fn shape_std_up_to_scale(&self) -> Vec<f64> {
        let shape = &self.shape.0;
        let std = (0..shape.len().min(self.shape_std.len()))
            .map(|response| self.shape_std_at_known_scale(response));
        let mut std: Vec<f64> = std.collect();
        let largest = (0..std.len()).max_by(|&a, &b| shape[a].norm().total_cmp(&shape[b].norm()));
        let others = std.len().saturating_sub(1).max(1) as f64;
        let of_others =
            |std: &[f64]| (std.iter().map(|std| std * std).sum::<f64>() / others).sqrt();
        let is_scaled = |&largest: &usize| std[largest] <= ROUNDING * of_others(&std);
        let Some(largest) = largest.filter(is_scaled) else {
            return std;
        };
        std[largest] = 0.0;
        for (std, value) in std.iter_mut().zip(shape) {
            *std /= (1.0 + (value / shape[largest]).norm_sqr()).sqrt();
        }
        std[largest] = of_others(&std);
        std
    }
}

/// One residual term: receptance += matrix·(ω/omega_scale)^power.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResidualTerm {
    /// Integer power of ω/omega_scale (usually −2, 0, 2, 4).
    pub power: i32,
    /// Responses × references.
    #[serde(flatten)]
    pub matrix: ComplexMatrix,
}

/// All residual terms of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResidualTerms {
    /// Scale of ω, rad/s.
    pub omega_scale_rad_per_s: f64,
    /// None: empty.
    pub terms: Vec<ResidualTerm>,
}

/// Quality with which the model explains its data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "QualityFields", into = "QualityFields")]
pub struct Quality {
    /// Rms residual over rms data, in the measured kind.
    pub relative_error: f64,
    /// χ² per degree of freedom.
    pub chi2_per_dof: f64,
    /// False: no mode is sure, or the data as a whole contradict the model.
    pub trusted: bool,
    /// Everything the user should know, in the order it was found.
    pub findings: Vec<Finding>,
    /// The path that found the modes, and the reason for it; absent for hand-made models.
    pub path: Option<String>,
}

impl Quality {
    /// The sentences of cautions and faults.
    pub fn warnings(&self) -> Vec<String> {
        warnings(&self.findings)
    }
}

/// Quality in files, where `warnings` repeats the sentences of `findings` for readers that
/// know no codes.
#[derive(Serialize, Deserialize)]
struct QualityFields {
    relative_error: f64,
    chi2_per_dof: f64,
    trusted: bool,
    warnings: Vec<String>,
    findings: Option<Vec<Finding>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    path: Option<String>,
}

impl From<QualityFields> for Quality {
    fn from(fields: QualityFields) -> Self {
        Self {
            relative_error: fields.relative_error,
            chi2_per_dof: fields.chi2_per_dof,
            trusted: fields.trusted,
            findings: fields
                .findings
                .unwrap_or_else(|| fields.warnings.into_iter().map(Finding::from).collect()),
            path: fields.path,
        }
    }
}

impl From<Quality> for QualityFields {
    fn from(quality: Quality) -> Self {
        Self {
            warnings: quality.warnings(),
            relative_error: quality.relative_error,
            chi2_per_dof: quality.chi2_per_dof,
            trusted: quality.trusted,
            findings: Some(quality.findings),
            path: quality.path,
        }
    }
}

/// A modal model: modes, residual terms, DOFs, geometry and quality. Field by field the
/// model file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModalModel {
    /// Always [`MODEL_FORMAT`].
    pub format: String,
    /// Version of the layout: 1.
    pub version: u32,
    /// Program and version.
    pub created_by: String,
    /// The files it was fitted to.
    pub source: Vec<Source>,
    /// Options that can change the result.
    pub options: serde_json::Map<String, serde_json::Value>,
    /// Kind of the FRFs that were fitted.
    pub frf_kind: FrfKind,
    /// Unit of the references.
    pub reference_unit: ReferenceUnit,
    /// Fitted band, Hz.
    pub band_hz: [f64; 2],
    /// Law of the saved numbers.
    pub damping: Damping,
    /// Scaling of the shapes.
    pub scaling: Scaling,
    /// Response DOFs.
    pub responses: Vec<Dof>,
    /// Reference DOFs.
    pub references: Vec<Dof>,
    /// Positions of the nodes.
    pub nodes: Vec<Node>,
    /// Trace lines of the measured structure, node labels; for pictures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<Vec<u64>>,
    /// Faces of the measured structure, node labels; for pictures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faces: Vec<Vec<u64>>,
    /// The method that ran.
    pub method: String,
    /// Modes and out-of-band poles, by rising frequency.
    pub modes: Vec<Mode>,
    /// Residual terms.
    pub residual_terms: ResidualTerms,
    /// Quality of the fit.
    pub quality: Quality,
}

impl ModalModel {
    /// Nodes with the lines and faces that join them.
    pub fn geometry(&self) -> Geometry {
        Geometry {
            nodes: self.nodes.clone(),
            lines: self.lines.clone(),
            faces: self.faces.clone(),
        }
    }

    /// The model at some of its DOFs alone, by their places: what few FRFs need costs as
    /// much as they are.
    pub fn at_dofs(&self, responses: &[usize], references: &[usize]) -> Self {
        fn of<T: Clone>(all: &[T], places: &[usize]) -> Vec<T> {
            places.iter().map(|&place| all[place].clone()).collect()
        }
        let mut part = self.clone();
        (part.responses, part.references) = (
            of(&self.responses, responses),
            of(&self.references, references),
        );
        for mode in &mut part.modes {
            mode.shape.0 = of(&mode.shape.0, responses);
            mode.shape_std = of(&mode.shape_std, responses);
            mode.participation.0 = of(&mode.participation.0, references);
        }
        for term in &mut part.residual_terms.terms {
            term.matrix.0 = term
                .matrix
                .0
                .select(Axis(0), responses)
                .select(Axis(1), references);
        }
        part
    }

    /// Modes that count ([`Mode::counts`]).
    pub fn in_band_modes(&self) -> impl Iterator<Item = &Mode> {
        self.modes.iter().filter(|mode| mode.counts())
    }

    /// Gives the findings the numbers of the modes that they are about.
    pub fn number_findings(&mut self) {
        let frequencies: Vec<f64> = self.in_band_modes().map(|mode| mode.frequency_hz).collect();
        numbered(&mut self.quality.findings, &frequencies);
    }
}
