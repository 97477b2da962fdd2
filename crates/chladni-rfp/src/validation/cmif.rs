//! Complex mode indicator function: C. Shih, Y. Tsuei, R. Allemang, D. Brown, Mech. Syst.
//! Signal Process. 2 (1988) 367.

use chladni_frf::FrfSet;
use chladni_linalg::{singular_values, LinalgError};
use ndarray::{Array2, ArrayView1};
use rayon::prelude::*;

/// Complex mode indicator function: singular values of the FRF matrix per line, falling;
/// axes (line, singular value), in units of the FRFs. Lines with missing values are NaN.
///
/// # Errors
/// A singular value decomposition that does not converge.
pub fn cmif(frf: &FrfSet) -> Result<Array2<f64>, LinalgError> {
    let (responses, references, lines) = frf.values.dim();
    let count = responses.min(references);
    let rows: Vec<Result<Vec<f64>, LinalgError>> = (0..lines)
        .into_par_iter()
        .map(|k| {
            let matrix =
                Array2::from_shape_fn((responses, references), |(i, j)| frf.values.get(i, j, k));
            if matrix.iter().any(|v| !v.is_finite()) {
                return Ok(vec![f64::NAN; count]);
            }
            Ok(singular_values(matrix.view())?.to_vec())
        })
        .collect();
    let mut out = Array2::zeros((lines, count));
    for (k, row) in rows.into_iter().enumerate() {
        out.row_mut(k).assign(&ArrayView1::from(&row?));
    }
    Ok(out)
}
