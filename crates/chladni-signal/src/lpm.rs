//! Local polynomial method: around each frequency, response and references of the whole
//! record obey
//!
//! Y(r) = Σ_j B_j(r)·X_j(r) + C(r)
//!
//! with polynomials of degree 2 in the place r of a line, −1 to 1: B_j is the FRF of
//! reference j, C what the ends of the record leave (its transient). The value at the
//! frequency itself is B_j(0); what the fit leaves over gives its variance.
//!
//! R. Pintelon, J. Schoukens, G. Vandersteen, K. Barbé, "Estimation of nonparametric noise
//! and FRF models for multivariable systems", Mech. Syst. Signal Process. 24 (2010)
//! 573–595.

use super::local_basis::{
    coherence, square, unknowns, Basis, LocalEstimate, LocalLine, LocalLines,
};
use num_complex::Complex64;

/// FRFs of every response; `None` where references have no power or act as one.
pub(super) fn estimate(local: &LocalLines) -> Option<LocalLine> {
    let lines = local.places.len();
    let basis = Basis::new(local, &vec![1.0; lines])?;
    let unit_variance = basis.unit_variance();
    let freedom = (lines - unknowns(local.references.len())) as f64;
    let of_response = |response: &&[Complex64]| {
        let own: Vec<Complex64> = response.to_vec();
        let split = basis.split(own);
        let noise = square(&split.rest) / freedom;
        LocalEstimate {
            values: split
                .at_centre
                .into_iter()
                .zip(unit_variance.iter().map(|unit| unit * noise))
                .collect(),
            coherence: coherence(response, noise),
        }
    };
    Some(LocalLine {
        responses: local.responses.iter().map(of_response).collect(),
        force_noise: None,
    })
}
