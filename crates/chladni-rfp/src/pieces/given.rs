//! Residues of a block at the poles of a model.

use crate::damping::basis::basis;
use crate::data::options::FitOptions;
use crate::data::products::{measured_basis, project};
use crate::data::screening::Screened;
use crate::data::source::Source;
use crate::data::window::of_set::with_set;
use crate::model::build::Shaped;
use crate::model::given::GivenPoles;
use crate::pieces::error::PieceError;
use chladni_frf::{FrfSet, ModalModel};
use chladni_linalg::qr_thin;

/// The model of the FRFs of one block with the poles, damping law and residual terms of
/// `model`: shapes and participations are fitted, poles and their error bars are taken as
/// they are.
///
/// # Errors
/// [`crate::FitError`]: the band of the model outside the data, no FRF with values.
pub fn residues(
    frf: &FrfSet,
    model: &ModalModel,
    options: &FitOptions,
) -> Result<ModalModel, PieceError> {
    let options = FitOptions {
        band_hz: Some(model.band_hz),
        ..with_set(frf, options)
    };
    let data = Screened::new(frf, &options)?;
    let given = GivenPoles::new(model, data.omega_max);
    let given = if data.pairs.len() <= 2 * given.unknowns() {
        given.on(data.work(), None)?
    } else {
        // products with the structural twins of viscous poles span nearly the same
        // columns
        let q = qr_thin(basis(&data.axis(), &given.lambda(), &given.powers).view())?.0;
        let projected = project(
            &data,
            measured_basis(&data, &q, &[]),
            &data.sketch(options.seed).1,
            &[],
        )?;
        given.on(projected.work, Some(projected.back))?
    };
    let shaped = Shaped::new(&data, given, None)?;
    let residual_energy = shaped.residual_energy(&data);
    Ok(shaped.model(&data, &options, &residual_energy)?)
}
