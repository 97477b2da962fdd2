//! Errors that stop a fit in pieces.

use crate::data::error::FitError;
use chladni_linalg::LinalgError;
use thiserror::Error;

/// The reason that a piece could not be made, merged or solved.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PieceError {
    /// An error that stops every fit.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Pieces or files that do not fit together.
    #[error(transparent)]
    Data(#[from] chladni_frf::Error),
}

impl From<LinalgError> for PieceError {
    fn from(error: LinalgError) -> Self {
        Self::Fit(error.into())
    }
}
