//! Poles and shapes as they were found, with the lines they were found on.

use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::poles::pole::Pole;
use crate::shapes::low_rank::Shapes;
use crate::shapes::scale::Scale;
use ndarray::Array2;
use num_complex::Complex64;

/// Poles, shapes and the lines they were found on.
pub(crate) struct FittedPoles<'a> {
    pub data: &'a DataLayout,
    pub work: &'a Columns,
    /// Scale of each FRF, where the columns are scaled FRFs.
    pub scales_of_frfs: Option<Vec<f64>>,
    pub powers: &'a [i32],
    /// True where the poles are those of a fit to these columns.
    pub fitted: bool,
    /// False if errors are not white noise, and the bars at hand come from the residual itself.
    pub residual_is_noise: bool,
    pub poles: &'a [Pole],
    pub shapes: &'a Shapes,
    pub scales: &'a [Scale],
}

impl FittedPoles<'_> {
    /// Scale of the FRF of pair l.
    pub(super) fn scale_of(&self, l: usize) -> f64 {
        self.scales_of_frfs.as_ref().map_or(1.0, |all| all[l])
    }

    /// Residues of the columns, (pole, pair).
    pub(super) fn residues(&self) -> Array2<Complex64> {
        let FittedPoles { poles, shapes, .. } = self;
        let pairs = &self.data.pairs;
        let mut residues = Array2::zeros((poles.len(), pairs.len()));
        for (term, &owner) in shapes.owner.iter().enumerate() {
            let unit = poles[owner].residue_unit(self.work.law);
            for (l, &(i, j)) in pairs.iter().enumerate() {
                residues[[owner, l]] +=
                    unit * shapes.shape[[term, i]] * shapes.participation[[term, j]];
            }
        }
        residues
    }

    /// Weight of line k over that of an FRF as it was measured.
    pub fn weight(&self, k: usize) -> f64 {
        let power = f64::from(self.data.kind.omega_power());
        self.work.g[k] / self.work.x[k].powf(0.5 * power)
    }
}
