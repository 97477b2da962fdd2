//! The result of a reader: everything found in one file, FRF or not.

use super::Shape;
use chladni_frf::{
    Checksum, Direction, Dof, Error, Finding, FrfKind, FrfSet, Geometry, ReferenceUnit, Source,
};
use chladni_text::file_name;
use num_complex::{Complex32, Complex64};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// File formats, told apart by content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum FileFormat {
    /// Universal file, text or binary 58.
    Uff,
    /// Text table.
    Csv,
    /// HDF5, MATLAB 7.3 among it.
    Hdf5,
    /// MATLAB 5 to 7.
    Matlab,
    /// NumPy, `.npy` or `.npz`.
    Numpy,
    /// Sound file.
    Wav,
    /// Modal model as JSON.
    Model,
    /// Weights as JSON.
    Weights,
}

/// Everything found in one file.
#[derive(Debug, Clone)]
pub struct Document {
    /// Path as given.
    pub file: PathBuf,
    /// Format found.
    pub format: FileFormat,
    /// Checksum of the file; `None` where only its headers were read.
    pub checksum: Option<Checksum>,
    /// Nodes, lines, faces, in metres.
    pub geometry: Geometry,
    /// One entry per dataset, sound, unknown or damaged, in the order of the file.
    pub datasets: Vec<DatasetInfo>,
    /// Formats that hold a whole set (HDF5, CSV) fill this.
    pub frf: Option<FrfSet>,
    /// Formats that hold functions one by one (UFF 58) fill this, sound ones only.
    pub functions: Vec<Function>,
    /// Mode shapes and fields at nodes.
    pub shapes: Vec<Shape>,
    /// Errors of damaged datasets. `info` lists them; other commands stop at the first.
    pub errors: Vec<Error>,
    /// Findings about the file.
    pub warnings: Vec<Finding>,
}

impl Document {
    /// A document of `file` with nothing in it yet.
    pub(super) fn new(file: &Path, format: FileFormat) -> Self {
        Self {
            file: file.to_path_buf(),
            format,
            checksum: None,
            geometry: Geometry::default(),
            datasets: Vec::new(),
            frf: None,
            functions: Vec::new(),
            shapes: Vec::new(),
            errors: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The file as the source of a result; `None` where only its headers were read.
    pub fn source(&self) -> Option<Source> {
        let checksum = self.checksum.clone()?;
        Some(Source {
            file: file_name(&self.file),
            checksum,
        })
    }
}

/// One dataset, as `info` lists it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct DatasetInfo {
    /// Universal-file number; `None` in other formats.
    pub number: Option<u32>,
    /// Line where it starts, counted from 1 (text formats).
    pub line: Option<u64>,
    /// Name of the dataset: "nodes", "units", "unknown", ...
    pub name: String,
    /// 58: function type ("frf", "coherence", "time", ...).
    pub function: Option<String>,
    /// 58: response DOF.
    pub response: Option<String>,
    /// 58: reference DOF.
    pub reference: Option<String>,
    /// 58: number of abscissa values.
    pub values: Option<usize>,
    /// Node datasets: number of nodes.
    pub nodes: Option<usize>,
    /// Shapes (55, 2414): |s|/2π, Hz.
    pub frequency_hz: Option<f64>,
    /// Shapes (55, 2414): viscous damping ratio.
    pub damping_ratio: Option<f64>,
    /// 58: kind of FRF by codes or labels.
    #[serde(skip)]
    pub frf_kind: Option<FrfKind>,
    /// Findings about it, and the error of a damaged one.
    #[serde(serialize_with = "in_words")]
    pub warnings: Vec<Finding>,
    /// True where the rest of the document does not hold its content; `convert` leaves it out.
    #[serde(skip)]
    pub left_behind: bool,
}

/// Ordinate values of a function, in the precision of the file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Ordinate {
    /// Real, single precision.
    Real32(Vec<f32>),
    /// Real, double precision.
    Real64(Vec<f64>),
    /// Complex, single precision.
    Complex32(Vec<Complex32>),
    /// Complex, double precision.
    Complex64(Vec<Complex64>),
}

impl Ordinate {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Real32(v) => v.len(),
            Self::Real64(v) => v.len(),
            Self::Complex32(v) => v.len(),
            Self::Complex64(v) => v.len(),
        }
    }
    /// True without values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Abscissa of a function.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Abscissa {
    /// Start and step.
    Even {
        /// First value.
        start: f64,
        /// Step.
        step: f64,
    },
    /// One value per ordinate.
    Uneven(Vec<f64>),
}

impl Abscissa {
    /// The first `count` values.
    pub fn values(&self, count: usize) -> Vec<f64> {
        match self {
            Self::Even { start, step } => (0..count).map(|k| start + step * k as f64).collect(),
            Self::Uneven(values) => values[..count.min(values.len())].to_vec(),
        }
    }
}

/// Axis description: records 8 to 11 of dataset 58.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// Quantity code (8 displacement, 11 velocity, 12 acceleration, 13 force, 17 time, 18
    /// frequency, ...).
    pub quantity: i32,
    /// Exponents of length, force and temperature.
    pub exponents: [i32; 3],
    /// Axis label.
    pub label: String,
    /// Unit label.
    pub unit: String,
}

/// One function at a DOF pair: dataset 58 with its values **as in the file**;
/// `scale_to_si` turns them into SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// Function type code: 1 time, 4 FRF, 6 coherence, ...
    pub function_type: i32,
    /// ID lines 1 to 5.
    pub id_lines: [String; 5],
    /// Function id, version, load case of record 6.
    pub ids: [i64; 3],
    /// Entity names of response and reference.
    pub entity_names: [String; 2],
    /// Response DOF.
    pub response: Dof,
    /// Reference DOF.
    pub reference: Dof,
    /// Abscissa values as in the file.
    pub abscissa: Abscissa,
    /// z value of record 7.
    pub z: f64,
    /// Abscissa, ordinate numerator, ordinate denominator, z axis.
    pub axes: [Axis; 4],
    /// Ordinate values as in the file.
    pub ordinate: Ordinate,
    /// FRFs: kind by codes or labels; `None` where they do not tell.
    pub kind: Option<FrfKind>,
    /// FRFs: unit of the reference by codes or labels.
    pub reference_unit: ReferenceUnit,
    /// Factor from the file's ordinate to SI (dataset 164 or an explicit unit label).
    pub scale_to_si: f64,
    /// Factor from the file's abscissa to Hz or s.
    pub abscissa_to_si: f64,
    /// Line of the dataset in the file, counted from 1.
    pub line: u64,
    /// Findings about it.
    pub warnings: Vec<Finding>,
}

/// Serializes findings in words, as the listing of a dataset holds them.
fn in_words<S: serde::Serializer>(findings: &[Finding], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(findings.iter().map(ToString::to_string))
}

/// Function type of time records, dataset 58.
const TIME_RECORD: i32 = 1;
/// Quantity code of time.
const TIME: i32 = 17;

impl Function {
    /// A time record of one channel, times in s, values as they are.
    pub(super) fn time_record(
        response: Dof,
        times: Abscissa,
        channel: Axis,
        ordinate: Ordinate,
    ) -> Self {
        let time = Axis {
            quantity: TIME,
            label: "Time".into(),
            unit: "s".into(),
            ..Axis::default()
        };
        Self {
            function_type: TIME_RECORD,
            id_lines: Default::default(),
            ids: [0; 3],
            entity_names: Default::default(),
            response,
            reference: Dof::new(0, Direction::SCALAR),
            abscissa: times,
            z: 0.0,
            axes: [time, channel, Axis::default(), Axis::default()],
            ordinate,
            kind: None,
            reference_unit: ReferenceUnit::Newton,
            scale_to_si: 1.0,
            abscissa_to_si: 1.0,
            line: 0,
            warnings: Vec::new(),
        }
    }
}

/// Settings of reading FRFs: the options common to all commands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// Kind of the FRFs: needed where the file does not say.
    pub frf_kind: Option<FrfKind>,
    /// Sign of the exponent e^{±jωt}: minus means conjugate on reading.
    pub time_sign: chladni_frf::TimeSign,
    /// Delay of all responses against the references, s, which is taken off.
    pub delay_s: f64,
    /// One reference node for all FRFs of files that each hold one reference (one entry, or
    /// one per file).
    pub references: Vec<u64>,
    /// One response node for all FRFs of files that each hold one response (one entry, or
    /// one per file).
    pub responses: Vec<u64>,
    /// DOFs of every FRF, in their order; empty: as in the files.
    pub dofs: super::DeclaredDofs,
    /// Keys and paths of datasets, such as `frf` and `/data/H`, `freq` and `/data/f`.
    pub map: Vec<(String, String)>,
    /// The treatment of a pair with several FRFs.
    pub duplicates: Duplicates,
    /// Unit of phases in tables and arrays.
    pub phase_unit: Option<super::PhaseUnit>,
    /// Sampling rate of tables without a time column, which are then time records, Hz.
    pub sample_rate_hz: Option<f64>,
    /// Replace a frequency step of six printed digits by the exact step that it stands for.
    pub snap_df: bool,
    /// Mask values that cannot be read instead of refusing the file.
    pub lenient: bool,
}

/// The treatment of a (response, reference) pair that occurs twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Duplicates {
    /// Refuse.
    #[default]
    Error,
    /// Keep the first.
    First,
    /// Keep the last.
    Last,
    /// Average them.
    Mean,
}

impl std::str::FromStr for Duplicates {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "error" => Ok(Self::Error),
            "first" => Ok(Self::First),
            "last" => Ok(Self::Last),
            "mean" => Ok(Self::Mean),
            _ => Err(format!(
                "`{text}` is no choice among pairs that occur twice; write error, first, last or mean"
            )),
        }
    }
}
