//! A measured field beside the weights that played.

use crate::results::weights::Weights;
use chladni_frf::MeasuredField;

/// A field that was measured while weights played.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayedField {
    /// The weights.
    pub weights: Weights,
    /// The field.
    pub field: MeasuredField,
    /// SHA-256 of the file of the weights, hexadecimal; a field that names another is refused.
    /// `None`: unknown.
    pub weights_sha256: Option<String>,
}

impl PlayedField {
    /// A field under weights whose file is unknown.
    pub fn new(weights: Weights, field: MeasuredField) -> Self {
        Self {
            weights,
            field,
            weights_sha256: None,
        }
    }
}
