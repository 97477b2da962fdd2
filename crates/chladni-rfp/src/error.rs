//! What stops an identification before it starts, with the numbers and the next step.

use crate::options::Method;
use chladni_linalg::LinalgError;
use thiserror::Error;

/// A fit that cannot be done. A fit that was done but cannot be trusted is no error: see the result's quality.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// The FRF kind is not known.
    #[error("the FRF kind is unknown; say receptance, mobility or accelerance")]
    UnknownKind,
    /// The band does not overlap the data.
    #[error("no line between {low_hz} and {high_hz} Hz: the data reach from {data_low_hz} to {data_high_hz} Hz")]
    BandOutsideData {
        /// Band asked for, Hz.
        low_hz: f64,
        /// Band asked for, Hz.
        high_hz: f64,
        /// First line, Hz.
        data_low_hz: f64,
        /// Last line, Hz.
        data_high_hz: f64,
    },
    /// Too few lines for any model.
    #[error("{lines} usable spectral lines between {low_hz} and {high_hz} Hz cannot support {modes} mode(s): at least {needed} are needed; widen the band")]
    TooFewLines {
        /// Lines left after screening.
        lines: usize,
        /// Band, Hz.
        low_hz: f64,
        /// Band, Hz.
        high_hz: f64,
        /// Modes asked for.
        modes: usize,
        /// Lines needed.
        needed: usize,
    },
    /// The bias of a window can be undone on whole records only.
    #[error("a window's bias is undone in the time domain, which needs every line from 0 Hz on, evenly spaced; found {found}")]
    WindowAxis {
        /// What stands in the way.
        found: String,
    },
    /// Nothing but zeros or NaN.
    #[error("no FRF in the set holds a finite, non-zero value in the band")]
    NoData,
    /// A method in the z plane on lines that do not lie on one even grid.
    #[error("the lines between {low_hz} and {high_hz} Hz lie on no even grid, which the method {method} needs; take vf or aaa, or interpolate before the fit")]
    UnevenAxis {
        /// The method asked for.
        method: Method,
        /// First line, Hz.
        low_hz: f64,
        /// Last line, Hz.
        high_hz: f64,
    },
    /// A poly-reference method where no FRF matrix is whole.
    #[error("the method {method} needs every response from every reference: {present} of {total} FRFs were measured; take lscf or vf")]
    IncompleteMatrix {
        /// The method asked for.
        method: Method,
        /// FRFs measured.
        present: usize,
        /// Responses times references.
        total: usize,
    },
    /// A kernel failed: our bug, not the user's.
    #[error("internal: {0}")]
    Kernel(#[from] LinalgError),
}
