//! Passes over all FRFs: the second one, and a few more for modes that the sketch does not
//! show.

use crate::damping::structural::basis;
use crate::damping::structural::POWERS;
use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::data::products::{energies, Projected};
use crate::data::screening::Screened;
use crate::data::source::{By, Source, Way};
use crate::poles::limits;
use crate::poles::refine::{refine, refined_poles, Refined};
use crate::poles::scan::{residual_peak, Scan};
use crate::poles::settle::settle;
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_linalg::blocked::projected;
use chladni_linalg::{qr_thin, LinalgError};
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
    /// The residual of the compressed columns, looked at for more.
    scanned: Scan,
    /// Poles that the columns were made with and that are gone: their noise is still in
    /// the columns.
    lost: usize,
}

/// Modes that the sketch did not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MissedPoles {
    /// All FRFs are asked for them.
    Search,
    /// They are left.
    Leave,
}

/// The start of the passes over all FRFs.
#[derive(Debug)]
pub(crate) struct PassStart {
    /// The sketch on the lines that were looked at.
    pub sketch: Columns,
    /// Poles, as sharp as it shows them.
    pub lambda: Vec<Complex64>,
    /// Basis of the model with these poles on all lines, orthonormal; the next pass takes it.
    pub q: Array2<Complex64>,
    /// Orders tried, in order.
    pub history: Tried,
    /// Passes made already beyond the second.
    pub extra_passes: usize,
    /// Evidence against the other damping law, where this is the second tried.
    pub doubt: Option<String>,
}

/// Numbers of poles that were tried, each with its residual variance.
pub(crate) type Tried = Vec<(usize, f64)>;

impl PassStart {
    /// Compresses all FRFs, settles the order on the compressed columns and, if asked to,
    /// searches all FRFs for poles that the sketch did not show; with the orders tried.
    /// `energy`: of each line over all FRFs.
    ///
    /// # Errors
    /// A kernel that fails; a pass that others must make.
    pub fn compressed<S: Source>(
        mut self,
        data: &S,
        energy: &Array1<f64>,
        missed: MissedPoles,
    ) -> Result<(Pass, Tried), S::Stop> {
        let mut best = self.pass(data, energy)?;
        let mut tried = Vec::new();
        let most = match missed {
            MissedPoles::Search => data.effort.extra_passes,
            MissedPoles::Leave => 0,
        };
        while self.extra_passes < most {
            self.extra_passes += 1;
            if let Some((pole, vague)) = best.missed(data, data.values(), &tried) {
                tried.push(pole);
                let mut more = best.refined.lambda.clone();
                more.push(pole);
                let more = refined_poles(&self.sketch, &more, &POWERS, tol::ROUGH)?;
                let there = [pole, *more.last().expect("one was added")];
                if vague
                    && !best
                        .shares(data.values(), &there)
                        .iter()
                        .any(|share| *share > limits::CONFIRMED_REFINED)
                {
                    continue;
                }
                // a pass by other machines is expensive: do not ask for one with the same poles
                if data.values().is_none() && same(&more, &self.lambda) {
                    break;
                }
                (self.q, self.lambda) = (on_all_lines(data, &more)?, more);
                let with = self.pass(data, energy)?;
                // the same poles on columns that one more pole helped to choose: nothing is
                // learned
                if !same(&with.refined.lambda, &best.refined.lambda) {
                    best = with;
                }
            } else if best.lost > 0
                && best.projected.work.columns() < data.pairs.len()
                && data.values().is_some()
            {
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

/// True where both are the same poles, to a part of a half-bandwidth.
fn same(these: &[Complex64], those: &[Complex64]) -> bool {
    these.len() == those.len()
        && these.iter().all(|a| {
            those
                .iter()
                .any(|b| (a - b).norm() < limits::SAME_POLE * a.im)
        })
}

impl Pass {
    /// The order settled on columns that were compressed with the poles `start`.
    fn of(
        data: &DataLayout,
        projected: Projected,
        start: &[Complex64],
        history: &mut Vec<(usize, f64)>,
    ) -> Result<Self, LinalgError> {
        let work = &projected.work;
        let precision = tol::FINE.within(data.effort.likelihood_steps);
        let mut refined = refine(work, start, &POWERS, precision)?;
        let mut variance = full_variance(data, &projected, &refined);
        let before = history.len();
        let scanned = settle(work, &mut refined, &mut variance, data.pairs.len(), history)?;
        if history.len() > before {
            refined = refine(work, &refined.lambda, &POWERS, precision)?;
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

    /// The place where a mode that the sketch did not show stands out of the residual
    /// over all FRFs.
    fn stands_out(&self, data: &DataLayout) -> Option<Complex64> {
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
    /// FRFs, or out of the compressed columns. True for the latter: a refined pole has yet to
    /// confirm it.
    fn missed(
        &self,
        data: &DataLayout,
        values: Option<&Screened>,
        tried: &[Complex64],
    ) -> Option<(Complex64, bool)> {
        let Self {
            projected,
            variance,
            scanned,
            ..
        } = self;
        let (work, frfs) = (&projected.work, data.pairs.len());
        if !self.refined.has_room(data.lines.len()) {
            return None;
        }
        let peak = self.stands_out(data);
        if peak.is_some() || work.columns() >= frfs {
            return peak.map(|peak| (peak, false));
        }
        let mut places = scanned.beyond(threshold(work.columns(), work.lines()) * variance, tried);
        places.truncate(limits::PLACES);
        places
            .iter()
            .zip(self.shares(values, &places))
            .find(|(_, share)| *share > limits::CONFIRMED)
            .map(|(pole, _)| (*pole, true))
    }

    /// Energy beyond noise that a pole at each of the `places` takes out of all FRFs, over that
    /// which a pole of the model must take out. Empty if the FRFs are not at hand. A pass with
    /// that pole in the basis would be exact, and costs far more.
    fn shares(&self, values: Option<&Screened>, places: &[Complex64]) -> Vec<f64> {
        let Some(data) = values.filter(|_| !places.is_empty()) else {
            return Vec::new();
        };
        let (_, mut outside) = projected(
            self.refined.projection.q.view(),
            basis(&self.projected.work, places, &[]).view(),
        );
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

/// The basis of the second pass on all lines, whether or not the poles were found on a
/// thinned record.
pub(crate) fn basis_of(
    data: &DataLayout,
    refined: &Refined,
) -> Result<Array2<Complex64>, LinalgError> {
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

/// The same on lines of these `weights`, where they do not count alike.
pub(crate) fn on_weighted_lines(
    data: &DataLayout,
    lambda: &[Complex64],
    weights: &[f64],
) -> Result<Array2<Complex64>, LinalgError> {
    let axis = data.axis().reweighted(weights);
    Ok(qr_thin(basis(&axis, lambda, &POWERS).view())?.0)
}

/// Noise variance from the residual of all FRFs.
fn full_variance(data: &DataLayout, projected: &Projected, refined: &Refined) -> f64 {
    let dof = (data.lines.len() - refined.unknowns().min(data.lines.len() - 1)) * data.pairs.len();
    let left = projected.line_residual(&refined.projection.residual).sum();
    (left / (dof as f64 - refined.lambda.len() as f64).max(1.0)).max(tol::VARIANCE_LEAST)
}
