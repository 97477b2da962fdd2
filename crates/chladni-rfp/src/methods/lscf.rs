//! Least-squares complex frequency (LSCF): one common denominator in z = e^{jθ},
//! assembled by Fourier transforms.
//!
//! Every column has its own numerator, all share one denominator
//! ([`super::matrix_fraction`] with one reference). Powers of z are nearly orthogonal
//! over the band, so orders of hundreds are within reach where powers of jω fail at
//! eight. Poles that stay over rising order are offered as modes
//! ([`super::stabilization`]), their residues decide.
//!
//! Cost: one transform of the lines per column and 8·n³ flop per column for order n; the
//! eigenvalues of some twenty orders take most of the time.
//!
//! Avoid it for the last digits, or for close modes. The equation error is weighted by
//! |A|², and finite order stands for residual terms: that is bias, which more data do not
//! remove. With the gap of [`super::matrix_fraction`] it is one to five Cramér–Rao bounds
//! for separate modes at 40 dB (tens at the ends of the band), but modes a third of a
//! bandwidth apart are merged or off by half of it, and at 20 dB weak modes never settle.
//! Clean data are reproduced to half of the digits. Good for a first look, and for the
//! diagram. It needs an even frequency axis (missing lines do not matter).
//!
//! P. Guillaume, P. Verboven, S. Vanlanduit, Proc. ISMA 23 (1998) 359–366. H. Van der
//! Auweraer, P. Guillaume, P. Verboven, S. Vanlanduit, J. Dyn. Syst. Meas. Control 123
//! (2001) 651–658.

use crate::data::error::FitError;
use crate::data::options::{FitOptions, Method};
use crate::data::screening::Screened;
use crate::methods::found::{MethodPoles, Stabilization};
use crate::methods::matrix_fraction::{MatrixFraction, UnitCircle};
use crate::methods::stabilization::{highest, Ladder};
use crate::methods::survey::{Compressed, Survey};
use chladni_frf::FrfSet;
use ndarray::Axis;

/// Poles by LSCF with stabilization.
///
/// # Errors
/// [`FitError::UnevenAxis`]; a decomposition that fails.
pub(crate) fn lscf(
    survey: &Survey,
    columns: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    let circle = UnitCircle::new(survey, Method::Lscf)?;
    let data = columns.work.b.t().insert_axis(Axis(2)).to_owned();
    let expected = survey.expected(columns, options);
    let fraction = MatrixFraction::new(circle, &data, highest(expected, survey))?;
    Ok(Ladder::climb(&fraction, expected)?.modes(
        survey,
        options,
        "common denominator in z, stable poles chosen by their residues",
    )?)
}

/// Poles of rising order for a stabilization diagram, by the method lscf in the band of
/// `options`.
///
/// # Errors
/// [`FitError`]: as [`crate::fit()`]; [`FitError::UnevenAxis`].
pub fn stabilization(frf: &FrfSet, options: &FitOptions) -> Result<Stabilization, FitError> {
    let data = Screened::new(frf, options)?;
    let survey = Survey::new(&data, options.seed);
    let columns = survey.compress()?;
    Ok(lscf(&survey, &columns, options)?
        .stabilization
        .unwrap_or_default())
}
