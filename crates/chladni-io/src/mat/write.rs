//! MATLAB files of version 5, as `save -v6` writes them: one element for each variable,
//! little endian, not packed. The header has no date: the same data give the same bytes.

use super::{CELL, CHAR, COMPLEX, HEADER_BYTES, MATRIX, SINGLE};
use crate::limits::LARGEST_ELEMENT;
use crate::signatures::MAT_SIGNATURE;
use chladni_frf::{
    Damping, Dof, Error, FrfSet, FrfValues, ModalModel, Mode, Result, Scaling, Trust,
};
use num_complex::Complex64;
use std::io::{self, Write};

/// Element types.
const UNSIGNED_32: u32 = 6;
const SIGNED_8: u32 = 1;
const SIGNED_32: u32 = 5;
const REAL_32: u32 = 7;
const REAL_64: u32 = 9;
const UNSIGNED_16: u32 = 4;
/// Class of arrays of double precision.
const DOUBLE: u32 = 6;

/// A file of named variables to be written.
pub(crate) struct MatFile {
    bytes: Vec<u8>,
}

impl MatFile {
    fn new() -> Self {
        let mut bytes = MAT_SIGNATURE.to_vec();
        bytes.extend(format!(", written by {}", chladni_frf::CREATED_BY).bytes());
        bytes.resize(HEADER_BYTES - 4, b' ');
        bytes.extend([0, 1, b'I', b'M']);
        Self { bytes }
    }

    /// The file of a set: `freq`, `frf` (response, reference, line), DOFs, kind and units.
    ///
    /// # Errors
    /// More values than such a file can hold.
    pub(crate) fn of_set(set: &FrfSet) -> Result<Self> {
        let (responses, references, lines) = set.values.dim();
        let shape = [responses, references, lines];
        let mut file = Self::new();
        file.reals("freq", &[lines, 1], set.frequency_hz.iter().copied())?;
        // column-major: the response runs fastest
        let order = || {
            (0..lines).flat_map(move |k| {
                (0..references).flat_map(move |j| (0..responses).map(move |i| [i, j, k]))
            })
        };
        let (class, kind) = match &set.values {
            FrfValues::F64(_) => (DOUBLE, REAL_64),
            FrfValues::F32(_) => (SINGLE, REAL_32),
        };
        let part = |of: fn(Complex64) -> f64| {
            let values = order().map(move |[i, j, k]| of(set.values.get(i, j, k)));
            match kind {
                REAL_32 => values
                    .flat_map(|v| (v as f32).to_le_bytes())
                    .collect::<Vec<_>>(),
                _ => values.flat_map(f64::to_le_bytes).collect(),
            }
        };
        file.array(
            "frf",
            &shape,
            class,
            kind,
            &[part(|v| v.re), part(|v| v.im)],
        )?;
        if let Some(coherence) = &set.coherence {
            let values = order().flat_map(|at| coherence[at].to_le_bytes()).collect();
            file.array("coherence", &shape, SINGLE, REAL_32, &[values])?;
        }
        file.texts("response", &dofs(&set.responses))?;
        file.texts("reference", &dofs(&set.references))?;
        file.text("reference_unit", &set.reference_unit.to_string())?;
        file.text("time_sign", "+")?;
        file.text("axes", "response-reference-line")?;
        if let Some(kind) = set.kind {
            file.text("frf_kind", kind.as_str())?;
            file.text("unit", &kind.unit(set.reference_unit))?;
        }
        Ok(file)
    }

    /// The file of a model, its fields under their names: values of modes as columns, shapes as
    /// (response, mode), participations as (reference, mode).
    ///
    /// # Errors
    /// More values than such a file can hold.
    pub(crate) fn of_model(model: &ModalModel) -> Result<Self> {
        let modes = &model.modes;
        let (count, references) = (modes.len(), model.references.len());
        let mut file = Self::new();
        file.text("format", &model.format)?;
        file.reals("version", &[1, 1], [f64::from(model.version)].into_iter())?;
        file.text("created_by", &model.created_by)?;
        file.text("frf_kind", model.frf_kind.as_str())?;
        file.text("reference_unit", &model.reference_unit.to_string())?;
        file.text("damping", damping_name(model.damping))?;
        file.text("scaling", scaling_name(model.scaling))?;
        file.reals("band_hz", &[1, 2], model.band_hz.into_iter())?;
        for (name, value) in PER_MODE {
            file.reals(name, &[count, 1], modes.iter().map(value))?;
        }
        let trust: Vec<String> = modes
            .iter()
            .map(|mode| trust_name(mode.trust).into())
            .collect();
        file.texts("trust", &trust)?;
        let shapes = modes.iter().flat_map(|mode| &mode.shape.0);
        file.complex("shape", &[model.responses.len(), count], shapes)?;
        let errors = modes.iter().flat_map(|mode| &mode.shape_std).copied();
        file.reals("shape_std", &[model.responses.len(), count], errors)?;
        let participations = modes.iter().flat_map(|mode| &mode.participation.0);
        file.complex("participation", &[references, count], participations)?;
        file.texts("responses", &dofs(&model.responses))?;
        file.texts("references", &dofs(&model.references))?;
        let nodes = &model.nodes;
        file.reals(
            "node",
            &[nodes.len(), 1],
            nodes.iter().map(|node| node.label as f64),
        )?;
        let places = (0..3).flat_map(|axis| nodes.iter().map(move |node| node.xyz_m[axis]));
        file.reals("node_xyz_m", &[nodes.len(), 3], places)?;
        let residual = &model.residual_terms;
        let scale = [residual.omega_scale_rad_per_s];
        file.reals("omega_scale_rad_per_s", &[1, 1], scale.into_iter())?;
        let powers = residual.terms.iter().map(|term| f64::from(term.power));
        file.reals("residual_power", &[residual.terms.len(), 1], powers)?;
        let terms = &residual.terms;
        let matrices = terms.iter().flat_map(|term| term.matrix.0.t().into_iter());
        file.complex(
            "residual",
            &[model.responses.len(), references, terms.len()],
            matrices,
        )?;
        Ok(file)
    }

    /// Writes the whole file.
    pub(crate) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&self.bytes)
    }

    fn reals(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl Iterator<Item = f64>,
    ) -> Result<()> {
        let bytes = values.flat_map(f64::to_le_bytes).collect();
        self.array(name, shape, DOUBLE, REAL_64, &[bytes])
    }

    fn complex<'v>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl Iterator<Item = &'v Complex64> + Clone,
    ) -> Result<()> {
        let re = values.clone().flat_map(|value| value.re.to_le_bytes());
        let im = values.flat_map(|value| value.im.to_le_bytes());
        let parts = [re.collect(), im.collect()];
        self.array(name, shape, DOUBLE, REAL_64, &parts)
    }

    fn text(&mut self, name: &str, text: &str) -> Result<()> {
        let element = text_matrix(name, text);
        self.push(name, &element)
    }

    /// A cell array of texts.
    fn texts(&mut self, name: &str, texts: &[String]) -> Result<()> {
        let mut content = head(name, &[texts.len(), 1], CELL);
        for text in texts {
            content.extend(element(MATRIX, &text_matrix("", text)));
        }
        self.push(name, &content)
    }

    /// An array whose parts hold numbers of type `kind`, column by column.
    fn array(
        &mut self,
        name: &str,
        shape: &[usize],
        class: u32,
        kind: u32,
        parts: &[Vec<u8>],
    ) -> Result<()> {
        let complex = if parts.len() > 1 { COMPLEX } else { 0 };
        let mut content = head(name, shape, class | complex);
        for part in parts {
            content.extend(element(kind, part));
        }
        self.push(name, &content)
    }

    fn push(&mut self, name: &str, content: &[u8]) -> Result<()> {
        if content.len() > LARGEST_ELEMENT {
            return Err(
                Error::bad_data("too many values for a MATLAB file of version 5")
                    .field(name)
                    .found(format!("{} bytes", content.len()))
                    .expected(format!("at most {LARGEST_ELEMENT}"))
                    .help("write HDF5 (.h5), which MATLAB reads with h5read"),
            );
        }
        self.bytes.extend(element(MATRIX, content));
        Ok(())
    }
}

/// The name of a number of a mode in the model file, and the number.
type NamedNumber = (&'static str, fn(&Mode) -> f64);

/// Values of each mode, under the names of the model file.
pub(crate) const PER_MODE: [NamedNumber; 7] = [
    ("frequency_hz", |mode| mode.frequency_hz),
    ("frequency_std_hz", |mode| mode.frequency_std_hz),
    ("loss_factor", |mode| mode.loss_factor),
    ("loss_factor_std", |mode| mode.loss_factor_std),
    ("damping_ratio", |mode| mode.damping_ratio),
    ("mpc", |mode| mode.mpc),
    ("in_band", |mode| f64::from(u8::from(mode.in_band))),
];

/// The word for a trust in the model file.
pub(crate) fn trust_name(trust: Trust) -> &'static str {
    match trust {
        Trust::Rejected => "rejected",
        Trust::Weak => "weak",
        Trust::Sure => "sure",
    }
}

/// The word for a damping law in the model file.
pub(crate) fn damping_name(damping: Damping) -> &'static str {
    match damping {
        Damping::Structural => "structural",
        Damping::Viscous => "viscous",
    }
}

/// The word for a scaling in the model file.
pub(crate) fn scaling_name(scaling: Scaling) -> &'static str {
    match scaling {
        Scaling::UnitModalMass => "unit_modal_mass",
        Scaling::Unscaled => "unscaled",
    }
}

fn dofs(dofs: &[Dof]) -> Vec<String> {
    dofs.iter().map(ToString::to_string).collect()
}

fn text_matrix(name: &str, text: &str) -> Vec<u8> {
    let units: Vec<u16> = text.encode_utf16().collect();
    let rows = usize::from(!units.is_empty());
    let mut content = head(name, &[rows, units.len()], CHAR);
    let bytes: Vec<u8> = units.into_iter().flat_map(u16::to_le_bytes).collect();
    content.extend(element(UNSIGNED_16, &bytes));
    content
}

/// Flags, dimensions and name of an array.
fn head(name: &str, shape: &[usize], flags: u32) -> Vec<u8> {
    let words = [flags, 0].map(u32::to_le_bytes).concat();
    let extents: Vec<u8> = shape
        .iter()
        .flat_map(|&extent| (extent as i32).to_le_bytes())
        .collect();
    [
        element(UNSIGNED_32, &words),
        element(SIGNED_32, &extents),
        element(SIGNED_8, name.as_bytes()),
    ]
    .concat()
}

/// A tag, its data, and zeros up to a multiple of eight bytes.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut element = Vec::with_capacity(data.len() + 16);
    element.extend(kind.to_le_bytes());
    element.extend((data.len() as u32).to_le_bytes());
    element.extend(data);
    element.resize(element.len().div_ceil(8) * 8, 0);
    element
}
