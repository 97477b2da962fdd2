//! Errors that stop an identification before it starts, with the numbers and the next
//! step.

use crate::data::limits;
use crate::data::options::{FitOptions, Method};
use chladni_frf::{Error as FileError, ErrorKind};
use chladni_linalg::LinalgError;
use thiserror::Error;

/// A fit that cannot be done. A fit that was done but cannot be trusted is no error: see
/// the result's quality.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// The FRF kind is not known.
    #[error("the FRF kind is unknown; say receptance, mobility or accelerance")]
    UnknownKind,
    /// The band does not overlap the data.
    #[error(
        "no line between {low_hz} and {high_hz} Hz: the data reach from {data_low_hz} to \
             {data_high_hz} Hz"
    )]
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
    #[error(
        "{lines} usable spectral lines between {low_hz} and {high_hz} Hz cannot support \
             {modes} mode(s): at least {needed} are needed; widen the band"
    )]
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
    /// Residual terms in powers of ω are one over so narrow a band.
    #[error("the band from {low_hz} to {high_hz} Hz is too narrow beside its frequency")]
    NarrowBand {
        /// Band, Hz.
        low_hz: f64,
        /// Band, Hz.
        high_hz: f64,
    },
    /// Numbers that no panel has.
    #[error("the FRFs have a root mean square of {rms:e}")]
    Scale {
        /// In the measured kind, SI units.
        rms: f64,
    },
    /// The length of the records follows from the distance of lines.
    #[error(
        "what a window does to the lines depends on the length of the records, which is the \
             inverse of the line spacing: evenly spaced lines are needed; found {found}"
    )]
    WindowAxis {
        /// The obstacle.
        found: String,
    },
    /// Nothing but zeros or NaN.
    #[error("no FRF in the set holds a finite, non-zero value in the band")]
    NoData,
    /// A method in the z plane on lines that do not lie on one even grid.
    #[error(
        "the lines between {low_hz} and {high_hz} Hz lie on no even grid, which the method \
             {method} needs; take vf or aaa, or interpolate before the fit"
    )]
    UnevenAxis {
        /// The method asked for.
        method: Method,
        /// First line, Hz.
        low_hz: f64,
        /// Last line, Hz.
        high_hz: f64,
    },
    /// A poly-reference method where no FRF matrix is whole.
    #[error(
        "the method {method} needs every response from every reference: {present} of {total} \
             FRFs were measured; take lscf or vf"
    )]
    IncompleteMatrix {
        /// The method asked for.
        method: Method,
        /// FRFs measured.
        present: usize,
        /// Responses times references.
        total: usize,
    },
    /// The caller asked it to stop.
    #[error("the fit was stopped before its end, as asked")]
    Cancelled,
    /// A kernel failed: our bug, not the user's.
    #[error("internal: {0}")]
    Kernel(#[from] LinalgError),
}

impl FitError {
    /// Tells what was found, what was expected and what to do, for users of files and of
    /// arrays alike; the caller adds the file. `option` tells how its users write an
    /// option, which may stand there in dashes or as a keyword.
    pub fn told(&self, options: &FitOptions, option: impl Fn(&str) -> String) -> FileError {
        let [band, modes, method, window] = ["band", "modes", "method", "window"].map(&option);
        match self {
            Self::UnknownKind => {
                FileError::new(ErrorKind::UnknownFrfKind, "the FRF kind is not known")
                    .field("FRF kind")
                    .expected("receptance, mobility or accelerance")
                    .help(format!(
                        "say it with {} \
                               receptance|mobility|accelerance",
                        option("frf-kind")
                    ))
            }
            Self::BandOutsideData {
                low_hz,
                high_hz,
                data_low_hz,
                data_high_hz,
            } => FileError::bad_data("no line of the data lies in the band")
                .field(&band)
                .found(format!("{low_hz}:{high_hz} Hz"))
                .expected(format!(
                    "a band that overlaps the data, {data_low_hz} to \
                                       {data_high_hz} Hz"
                ))
                .help(format!("give a {band} within the data, or leave it out")),
            Self::TooFewLines {
                lines,
                low_hz,
                high_hz,
                modes: asked,
                needed,
            } => FileError::bad_data("too few usable spectral lines in the band")
                .field(if options.band_hz.is_some() {
                    &band
                } else {
                    "frequency axis"
                })
                .found(format!("{lines} lines between {low_hz} and {high_hz} Hz"))
                .expected(format!("at least {needed} lines for {asked} modes"))
                .help(format!("widen {band}, or ask for fewer {modes}")),
            Self::NarrowBand { low_hz, high_hz } => {
                FileError::bad_data("the band is too narrow beside its frequency")
                    .field(if options.band_hz.is_some() {
                        &band
                    } else {
                        "frequency axis"
                    })
                    .found(format!("{low_hz} to {high_hz} Hz"))
                    .expected(format!(
                        "a width of {:.3} Hz or more: residual terms in powers of the frequency \
                         are one below it",
                        limits::NARROWEST_BAND * high_hz
                    ))
                    .help(format!("measure or choose a wider {band}"))
            }
            Self::Scale { rms } => {
                let [least, most] = limits::SENSIBLE_RMS;
                FileError::bad_data("numbers that no panel can have")
                    .field("FRF values")
                    .found(format!("a root mean square of {rms:.1e}"))
                    .expected(format!("{least:e} to {most:e} in SI units"))
                    .help("look at the unit of the file, or scale its numbers")
            }
            Self::WindowAxis { found } => FileError::bad_data(
                "the bias of a window is undone in the time domain, which \
                                     needs whole records",
            )
            .field(&window)
            .found(found)
            .expected("FRFs without gaps on evenly spaced lines from 0 Hz on")
            .help(format!(
                "export all lines, or leave {window} out: the possible bias is \
                                   named then"
            )),
            Self::NoData => {
                FileError::bad_data("no FRF holds a finite, non-zero value in the band")
                    .field("FRF values")
                    .found("zeros or NaN only")
                    .expected("measured values")
                    .help("look at the file with `chladni info`")
            }
            Self::UnevenAxis {
                method: asked,
                low_hz,
                high_hz,
            } => FileError::bad_data("the lines lie on no even frequency grid")
                .field("frequency axis")
                .found(format!("uneven steps between {low_hz} and {high_hz} Hz"))
                .expected(format!(
                    "one step for all lines (some may be missing): the method \
                                   {asked} works in the z plane"
                ))
                .help(format!(
                    "take {method} auto, vf or aaa, which need no even grid"
                )),
            Self::IncompleteMatrix {
                method: asked,
                present,
                total,
            } => FileError::bad_data("the FRF matrix is not whole")
                .field("FRF matrix")
                .found(format!("{present} of {total} FRFs"))
                .expected(format!(
                    "every response from every reference: the method {asked} fits \
                                   them together"
                ))
                .help(format!(
                    "take {method} auto, lscf or vf, which need no whole matrix"
                )),
            Self::Cancelled => FileError::new(
                ErrorKind::Interrupted,
                "the fit was stopped before its end, as asked",
            ),
            Self::Kernel(error) => {
                FileError::new(ErrorKind::Internal, format!("internal error: {error}"))
            }
        }
    }
}
