//! Passes over all FRFs: the second one, and a few more for modes that the sketch does not
//! show.

use crate::damping::basis::basis;
use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::data::products::{energies, Projected};
use crate::data::screening::Screened;
use crate::data::source::{By, Source, Way};
use crate::poles::limits;
use crate::poles::refine::{refine, refined_poles, Refined};
use crate::poles::scan::{residual_peak, Scan};
use crate::poles::settle::{settle, OrderHistory};
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_linalg::blocked::{projected, tall_qr};
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// The result of one pass over all FRFs.
pub(crate) struct Pass {
    /// Compressed data and the way back to FRFs.
    pub projected: Projected,
    /// Refined on the compressed columns.
    pub refined: Refined,
    /// Noise variance of one work value.
    pub variance: f64,
    /// The last scan of the residual of the compressed columns.
    scanned: Scan,
    /// Number of poles that the columns were made with and that are gone: their noise is still in
    /// the columns.
    lost: usize,
}

/// A place of a mode that the sketch did not show.
struct MissedPole {
    place: Complex64,
    /// True if the compressed columns alone show it: a refined pole has yet to confirm it.
    unconfirmed: bool,
}

/// The treatment of modes that the sketch did not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MissedPoles {
    /// They are searched for in all FRFs.
    Search,
    /// They are left out.
    Leave,
}

/// The start of the passes over all FRFs.
#[derive(Debug)]
pub(crate) struct PassStart {
    /// The sketch, on the lines that it was thinned to.
    pub sketch: Columns,
    /// Poles, as refined on the sketch.
    pub lambda: Vec<Complex64>,
    /// Basis of the model with these poles on all lines, orthonormal; the next pass takes it.
    pub q: Array2<Complex64>,
    /// Orders tried, in order.
    pub history: OrderHistory,
    /// Passes made already beyond the second.
    pub extra_passes: usize,
    /// Evidence against the other damping law, if that was tried before.
    pub doubt: Option<String>,
}

impl PassStart {
    /// Compresses all FRFs, settles the number of poles on the compressed columns and, if asked to,
    /// searches all FRFs for poles that the sketch did not show. Returns the last pass, and the
    /// orders tried.
    ///
    /// * `energy`: of each line over all FRFs
    ///
    /// # Errors
    /// A kernel that fails; a pass that others must make.
    pub fn compressed<S: Source>(
        mut self,
        data: &S,
        energy: &Array1<f64>,
        missed: MissedPoles,
    ) -> Result<(Pass, OrderHistory), S::Stop> {
        let mut best = self.pass(data, energy)?;
        let mut tried = Vec::new();
        let most_passes = match missed {
            MissedPoles::Search => data.effort.extra_passes,
            MissedPoles::Leave => 0,
        };
        while self.extra_passes < most_passes {
            self.extra_passes += 1;
            if let Some(missed) = best.missed(data, data.values(), &tried) {
                tried.push(missed.place);
                let more = [best.refined.lambda.as_slice(), &[missed.place]].concat();
                let more = refined_poles(&self.sketch, &more, &RESIDUAL_POWERS, tol::ROUGH)?;
                let places = [missed.place, more[more.len() - 1]];
                if missed.unconfirmed && !best.confirms(data.values(), &places) {
                    continue;
                }
                // a pass by other machines is expensive: do not ask for one with the same poles
                if data.values().is_none() && same(&more, &self.lambda) {
                    break;
                }
                (self.q, self.lambda) = (on_all_lines(data, &more)?, more);
                let next = self.pass(data, energy)?;
                // the added pole did not stay: its pass tells nothing new
                if !same(&next.refined.lambda, &best.refined.lambda) {
                    best = next;
                }
            } else if best.is_spoilt(data) && data.values().is_some() {
                // once more without the noise of the lost poles
                self.q = basis_of(data, &best.refined)?;
                self.lambda = best.refined.lambda;
                best = self.pass(data, energy)?;
            } else {
                break;
            }
        }
        Ok((best, self.history))
    }

    /// One pass with these poles.
    fn pass<S: Source>(&mut self, data: &S, energy: &Array1<f64>) -> Result<Pass, S::Stop> {
        let way = Way {
            law: data.law,
            lambda: self.lambda.clone(),
            by: By::Fast {
                history: self.history.clone(),
                extra_passes: self.extra_passes,
                doubt: self.doubt.clone(),
            },
        };
        let q = std::mem::take(&mut self.q);
        let projected = data.projected(&way, q, energy)?;
        Ok(Pass::of(data, projected, &self.lambda, &mut self.history)?)
    }
}

/// True if both are the same poles, to a part of a half-bandwidth.
fn same(these: &[Complex64], those: &[Complex64]) -> bool {
    these.len() == those.len()
        && these.iter().all(|a| {
            those
                .iter()
                .any(|b| (a - b).norm() < limits::SAME_POLE * a.im)
        })
}

impl Pass {
    /// Settles the number of poles on columns that were compressed with the poles `start`.
    fn of(
        data: &DataLayout,
        projected: Projected,
        start: &[Complex64],
        history: &mut OrderHistory,
    ) -> Result<Self, LinalgError> {
        let work = &projected.work;
        let precision = tol::FINE.within(data.effort.likelihood_steps);
        let mut refined = refine(work, start, &RESIDUAL_POWERS, precision)?;
        let mut variance = full_variance(data, &projected, &refined);
        let before = history.len();
        let scanned = settle(work, &mut refined, &mut variance, data.pairs.len(), history)?;
        if history.len() > before {
            refined = refine(work, &refined.lambda, &RESIDUAL_POWERS, precision)?;
            variance = full_variance(data, &projected, &refined);
        }
        let lost = start.len().saturating_sub(refined.lambda.len());
        Ok(Self {
            projected,
            refined,
            variance,
            scanned,
            lost,
        })
    }

    /// True if the columns hold the noise of poles that are gone.
    fn is_spoilt(&self, data: &DataLayout) -> bool {
        self.lost > 0 && self.projected.work.columns() < data.pairs.len()
    }

    /// The place where a mode that the sketch did not show stands out of the residual
    /// over all FRFs.
    fn peak_of_residual(&self, data: &DataLayout) -> Option<Complex64> {
        let Self {
            projected, refined, ..
        } = self;
        residual_peak(
            &projected.work,
            &projected.line_noise(&refined.projection.q, &refined.projection.residual),
            data.pairs.len(),
            &refined.lambda,
        )
    }

    /// The place where a mode that the sketch did not show stands out of the residual over all
    /// FRFs, or else out of the compressed columns.
    fn missed(
        &self,
        data: &DataLayout,
        values: Option<&Screened>,
        tried: &[Complex64],
    ) -> Option<MissedPole> {
        let Self {
            projected,
            variance,
            scanned,
            ..
        } = self;
        let (work, frfs) = (&projected.work, data.pairs.len());
        // of exact data the residual over all FRFs is the rounding of a difference
        let left = projected.line_residual(&self.refined.projection.residual);
        let is_rounding = left.sum() <= limits::EXPLAINED * work.energy();
        if is_rounding || !self.refined.has_room(data.lines.len()) {
            return None;
        }
        let found = |unconfirmed| move |place| MissedPole { place, unconfirmed };
        let peak = self.peak_of_residual(data);
        if peak.is_some() || work.columns() >= frfs {
            return peak.map(found(false));
        }
        let mut places = scanned.beyond(threshold(work.columns(), work.lines()) * variance, tried);
        places.truncate(limits::PLACES);
        places
            .iter()
            .zip(self.energy_shares(values, &places))
            .find(|(_, share)| *share > limits::CONFIRMED)
            .map(|(place, _)| found(true)(*place))
    }

    /// True if a pole at one of the `places` takes nearly enough energy out of all FRFs.
    fn confirms(&self, values: Option<&Screened>, places: &[Complex64]) -> bool {
        let shares = self.energy_shares(values, places);
        shares
            .iter()
            .any(|share| *share > limits::CONFIRMED_REFINED)
    }

    /// Energy beyond noise that a pole at each of the `places` takes out of all FRFs, over the
    /// energy that a pole of the model must take out. Empty if the FRFs are not at hand. A pass with
    /// that pole in the basis would be exact, and costs far more.
    fn energy_shares(&self, values: Option<&Screened>, places: &[Complex64]) -> Vec<f64> {
        let Some(data) = values.filter(|_| !places.is_empty()) else {
            return Vec::new();
        };
        let columns = basis(&self.projected.work, places, &[]);
        let (_, mut outside) = projected(self.refined.projection.q.view(), columns.view());
        for mut column in outside.columns_mut() {
            let norm = column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
            column.mapv_inplace(|v| v / norm);
        }
        let frfs = data.pairs.len();
        let needed = threshold(frfs, data.lines.len()) - frfs as f64;
        energies(data, &outside)
            .into_iter()
            .map(|energy| (energy / self.variance - frfs as f64) / needed)
            .collect()
    }
}

/// Orthonormal basis of a model with these poles on all lines, even if they were refined on some of
/// the lines only.
fn basis_of(data: &DataLayout, refined: &Refined) -> Result<Array2<Complex64>, LinalgError> {
    if refined.projection.q.nrows() == data.lines.len() {
        return Ok(refined.projection.q.clone());
    }
    on_all_lines(data, &refined.lambda)
}

/// Orthonormal basis of a model with the poles `lambda` on all lines.
pub(crate) fn on_all_lines(
    data: &DataLayout,
    lambda: &[Complex64],
) -> Result<Array2<Complex64>, LinalgError> {
    on_weighted_lines(data, lambda, &[])
}

/// The same on lines with these `weights`; empty: all count alike.
pub(crate) fn on_weighted_lines(
    data: &DataLayout,
    lambda: &[Complex64],
    weights: &[f64],
) -> Result<Array2<Complex64>, LinalgError> {
    let axis = data.axis().reweighted(weights);
    Ok(tall_qr(basis(&axis, lambda, &RESIDUAL_POWERS).view())?.0)
}

/// Noise variance from the residual of all FRFs.
fn full_variance(data: &DataLayout, projected: &Projected, refined: &Refined) -> f64 {
    let dof = (data.lines.len() - refined.unknowns().min(data.lines.len() - 1)) * data.pairs.len();
    let sse = projected.line_residual(&refined.projection.residual).sum();
    (sse / (dof as f64 - refined.lambda.len() as f64).max(1.0)).max(tol::VARIANCE_LEAST)
}
