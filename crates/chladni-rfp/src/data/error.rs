//! Errors that stop an identification, most of them before it starts, with the numbers and the
//! next step.

use crate::data::limits;
use crate::data::options::{FitOptions, Method};
use chladni_frf::{counted, Error as FileError, ErrorKind};
use chladni_linalg::LinalgError;
use std::fmt;

/// The reason that a fit cannot be done. A fit that was done but cannot be trusted is no error: see
/// the result's quality.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// The FRF kind is not known.
    UnknownKind,
    /// The band does not overlap the data.
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
    /// A band over which powers of ω are too alike to tell residual terms apart.
    NarrowBand {
        /// Band, Hz.
        low_hz: f64,
        /// Band, Hz.
        high_hz: f64,
    },
    /// Numbers that no panel has.
    Scale {
        /// In the measured kind, SI units.
        rms: f64,
    },
    /// A window whose record length the line spacing does not tell.
    WindowAxis {
        /// The obstacle.
        found: String,
    },
    /// Nothing but zeros or NaN.
    NoData,
    /// A method in the z plane on lines that do not lie on one even grid.
    UnevenAxis {
        /// The method asked for.
        method: Method,
        /// First line, Hz.
        low_hz: f64,
        /// Last line, Hz.
        high_hz: f64,
    },
    /// A poly-reference method where no FRF matrix is whole.
    IncompleteMatrix {
        /// The method asked for.
        method: Method,
        /// FRFs measured.
        present: usize,
        /// Responses times references.
        total: usize,
    },
    /// The caller asked it to stop.
    Cancelled,
    /// A kernel failed: our bug, not the user's.
    Kernel(LinalgError),
}

impl FitError {
    /// Tells what was found, what was expected and what to do, for users of files and of
    /// arrays alike; the caller adds the file. `option` tells how its users write an
    /// option, which may stand there in dashes or as a keyword.
    pub fn told(&self, options: &FitOptions, option: impl Fn(&str) -> String) -> FileError {
        let [band, modes, method, window] = ["band", "modes", "method", "window"].map(&option);
        let reach = match options.band_hz {
            Some(_) => band.as_str(),
            None => "frequency axis",
        };
        let (error, help) = match self {
            Self::Cancelled => {
                let what = "the fit was stopped before its end, as asked";
                return FileError::new(ErrorKind::Interrupted, what);
            }
            Self::Kernel(error) => {
                return FileError::new(ErrorKind::Internal, format!("internal error: {error}"));
            }
            Self::UnknownKind => (
                FileError::new(ErrorKind::UnknownFrfKind, "the FRF kind is not known")
                    .field("FRF kind")
                    .expected("receptance, mobility or accelerance"),
                format!(
                    "say it with {} receptance|mobility|accelerance",
                    option("frf-kind")
                ),
            ),
            Self::BandOutsideData {
                low_hz,
                high_hz,
                data_low_hz,
                data_high_hz,
            } => (
                FileError::bad_data("no line of the data lies in the band")
                    .field(&band)
                    .found(format!("{low_hz}:{high_hz} Hz"))
                    .expected(format!(
                        "a band that overlaps the data, {data_low_hz} to {data_high_hz} Hz"
                    )),
                format!("give a {band} within the data, or leave it out"),
            ),
            Self::TooFewLines {
                lines,
                low_hz,
                high_hz,
                modes: asked,
                needed,
            } => (
                FileError::bad_data("too few usable spectral lines in the band")
                    .field(reach)
                    .found(format!(
                        "{} between {low_hz} and {high_hz} Hz",
                        counted(*lines, "line")
                    ))
                    .expected(format!(
                        "at least {} for {}",
                        counted(*needed, "line"),
                        counted(*asked, "mode")
                    )),
                format!("widen {band}, or ask for fewer {modes}"),
            ),
            Self::NarrowBand { low_hz, high_hz } => (
                FileError::bad_data("the band is too narrow beside its frequency")
                    .field(reach)
                    .found(format!("{low_hz} to {high_hz} Hz"))
                    .expected(format!(
                        "a width of {:.3} Hz or more: residual terms in powers of the frequency \
                         are one below it",
                        limits::NARROWEST_BAND * high_hz
                    )),
                format!("measure or choose a wider {band}"),
            ),
            Self::Scale { rms } => {
                let [least, most] = limits::SENSIBLE_RMS;
                let error = FileError::bad_data("numbers that no panel can have")
                    .field("FRF values")
                    .found(format!("a root mean square of {rms:.1e}"))
                    .expected(format!("{least:e} to {most:e} in SI units"));
                let help = "look at the unit of the file, or scale its numbers";
                (error, help.into())
            }
            Self::WindowAxis { found } => (
                FileError::bad_data(
                    "a window changes lines by the record length, which is read from the line \
                     spacing",
                )
                .field(&window)
                .found(found)
                .expected("evenly spaced lines"),
                format!("export evenly spaced lines, or leave {window} out"),
            ),
            Self::NoData => (
                FileError::bad_data("no FRF holds a finite, non-zero value in the band")
                    .field("FRF values")
                    .found("zeros or NaN only")
                    .expected("measured values"),
                "look at the contents of the file".into(),
            ),
            Self::UnevenAxis {
                method: asked,
                low_hz,
                high_hz,
            } => (
                FileError::bad_data("the lines lie on no even frequency grid")
                    .field("frequency axis")
                    .found(format!("uneven steps between {low_hz} and {high_hz} Hz"))
                    .expected(format!(
                        "one step for all lines (some may be missing): the method {asked} works \
                         in the z plane"
                    )),
                format!("take {method} auto, vf or aaa, which need no even grid"),
            ),
            Self::IncompleteMatrix {
                method: asked,
                present,
                total,
            } => (
                FileError::bad_data("the FRF matrix is not whole")
                    .field("FRF matrix")
                    .found(format!("{present} of {total} FRFs"))
                    .expected(format!(
                        "every response from every reference: the method {asked} fits them \
                         together"
                    )),
                format!("take {method} auto, lscf or vf, which need no whole matrix"),
            ),
        };
        error.help(help)
    }
}

/// The same text, with options by their plain names.
impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.told(&FitOptions::default(), str::to_owned).fmt(f)
    }
}

impl std::error::Error for FitError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Kernel(error) => Some(error),
            _ => None,
        }
    }
}

impl From<LinalgError> for FitError {
    fn from(error: LinalgError) -> Self {
        Self::Kernel(error)
    }
}
