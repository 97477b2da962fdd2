//! Values at nodes: mode shapes and vibration fields, as datasets 55 and 2414 hold them.

use chladni_frf::{Dof, Finding};
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Components of a translation: X, Y, Z.
pub const TRANSLATION: usize = 3;
/// Most values that a node can have: nine for a general tensor, with room for
/// user-defined results.
pub(super) const MOST_COMPONENTS: usize = 64;

/// The analysis that the values belong to; the codes of datasets 55 and 2414.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Analysis {
    /// 1: one load, at rest.
    Static,
    /// 2: a real mode.
    NormalMode,
    /// 3: a complex mode of first order.
    ComplexModeFirstOrder,
    /// 4: one instant of a motion.
    Transient,
    /// 5: the motion at one frequency.
    FrequencyResponse,
    /// 6: a buckling shape.
    Buckling,
    /// 7: a complex mode of second order.
    ComplexModeSecondOrder,
    /// 0, 9 and whatever else a file says.
    Other(i64),
}

impl Analysis {
    /// The analysis of a code in the file.
    pub fn from_code(code: i64) -> Self {
        match code {
            1 => Self::Static,
            2 => Self::NormalMode,
            3 => Self::ComplexModeFirstOrder,
            4 => Self::Transient,
            5 => Self::FrequencyResponse,
            6 => Self::Buckling,
            7 => Self::ComplexModeSecondOrder,
            other => Self::Other(other),
        }
    }
    /// The code of the file.
    pub fn code(self) -> i64 {
        match self {
            Self::Static => 1,
            Self::NormalMode => 2,
            Self::ComplexModeFirstOrder => 3,
            Self::Transient => 4,
            Self::FrequencyResponse => 5,
            Self::Buckling => 6,
            Self::ComplexModeSecondOrder => 7,
            Self::Other(code) => code,
        }
    }
    /// True for modes with a complex eigenvalue.
    pub fn is_complex_mode(self) -> bool {
        matches!(
            self,
            Self::ComplexModeFirstOrder | Self::ComplexModeSecondOrder
        )
    }
    /// True for modes, real or complex.
    pub fn is_mode(self) -> bool {
        self == Self::NormalMode || self.is_complex_mode()
    }
    /// The word in the output of `info`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static shape",
            Self::NormalMode => "normal mode",
            Self::ComplexModeFirstOrder | Self::ComplexModeSecondOrder => "complex mode",
            Self::Transient => "instant of a motion",
            Self::FrequencyResponse => "field at one frequency",
            Self::Buckling => "buckling shape",
            Self::Other(_) => "data at nodes",
        }
    }
}

/// The numbers of the mode, frequency or instant of a shape; 0 where a file states none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ShapeNumbers {
    /// Load case (55) or load set (2414).
    pub load_case: i64,
    /// Number of the mode, time step or frequency step.
    pub number: i64,
    /// Time of an instant, s.
    pub time_s: f64,
    /// Undamped natural frequency of a normal mode, or the frequency of a field, Hz.
    pub frequency_hz: f64,
    /// Modal mass of a normal mode, in the units of the file.
    pub modal_mass: f64,
    /// Viscous damping ratio of a normal mode.
    pub viscous: f64,
    /// Hysteretic loss factor of a normal mode.
    pub hysteretic: f64,
    /// Eigenvalue of a complex mode, rad/s; real eigenvalue of a buckling shape.
    pub eigenvalue: Complex64,
    /// Modal A of a complex mode.
    pub modal_a: Complex64,
    /// Modal B of a complex mode.
    pub modal_b: Complex64,
}

/// The origin of a shape, and the form in which it is written again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ShapeForm {
    /// Dataset 55: a node that is left out is at rest.
    #[default]
    AtNodes55,
    /// Dataset 2414: a node that is left out has no value.
    Analysis2414,
}

/// Values at nodes, as in the file; `scale_to_si` turns them into SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its dataset.
    pub form: ShapeForm,
    /// Name (2414).
    pub name: String,
    /// ID lines 1 to 5.
    pub id_lines: [String; 5],
    /// Model type: 1 structural.
    pub model_type: i64,
    /// The analysis that it belongs to.
    pub analysis: Analysis,
    /// Data characteristic: 1 scalar, 2 three translations, 3 translations and rotations,
    /// 4 and 5 tensors.
    pub characteristic: i64,
    /// Quantity code: 8 displacement, 11 velocity, 12 acceleration.
    pub quantity: i64,
    /// Reference of measured data, where the file names one (ID line 5 of dataset 55).
    pub reference: Option<Dof>,
    /// Numbers of its mode, frequency or instant.
    pub numbers: ShapeNumbers,
    /// True for complex values; false where imaginary parts are 0.
    pub complex: bool,
    /// Node labels, one per row of `values`.
    pub nodes: Vec<u64>,
    /// Values; axes (node, component), components X, Y, Z, RX, RY, RZ of vectors.
    pub values: Array2<Complex64>,
    /// Factor from the file's values to SI; 1 for modes, whose scaling is their own.
    pub scale_to_si: f64,
    /// Line of the dataset in the file, counted from 1; 0 in other formats.
    pub line: u64,
    /// Findings about it.
    pub warnings: Vec<Finding>,
}

impl Shape {
    /// |s|/2π of a mode, or the frequency of a field, Hz.
    pub fn frequency_hz(&self) -> Option<f64> {
        let numbers = &self.numbers;
        match self.analysis {
            Analysis::NormalMode | Analysis::FrequencyResponse => Some(numbers.frequency_hz),
            _ if self.analysis.is_complex_mode() && numbers.eigenvalue.norm() > 0.0 => {
                Some(numbers.eigenvalue.norm() / TAU)
            }
            _ if self.analysis.is_complex_mode() => Some(numbers.frequency_hz),
            _ => None,
        }
    }
    /// Viscous damping ratio of a mode; without one, half the loss factor.
    pub fn damping_ratio(&self) -> Option<f64> {
        let numbers = &self.numbers;
        let by_numbers = if numbers.viscous == 0.0 {
            numbers.hysteretic / 2.0
        } else {
            numbers.viscous
        };
        let magnitude = numbers.eigenvalue.norm();
        match self.analysis {
            Analysis::NormalMode => Some(by_numbers),
            _ if !self.analysis.is_complex_mode() => None,
            _ if magnitude > 0.0 => Some(-numbers.eigenvalue.re / magnitude),
            _ => Some(by_numbers),
        }
    }
}
