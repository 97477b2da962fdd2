//! The search for modes in one section: votes, error model, local tests, moving pairs.

use super::limits::{
    APART, BASE_LEAST, NEAREST_LINES, ODD_EVEN_SIGMAS, OWNED_BEYOND, OWN_POLE_FARTHEST, RESEED,
    RESEED_BELOW, RESEED_OVER_NOISE_DB, SHADOW, STRONG_DB, WEIGHT_ROUNDS,
};
use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::{line_energy, Columns};
use crate::data::options::Asked;
use crate::data::peaks::{fourth_difference_noise, peaks, Peak};
use crate::measured::candidates::{Candidates, Origin};
use crate::measured::consensus::consensus;
use crate::measured::correlated_noise::over_chance;
use crate::measured::error_model::NoiseModel;
use crate::measured::evidence::{look, Evidence};
use crate::measured::local::{add, one_column_gains, remove, remove_unneeded, try_add};
use crate::measured::moving_pairs::{merge, own_poles};
use crate::measured::record::{noise_window, Record};
use crate::measured::resolved::refine_resolved;
use crate::measured::sandwich::variances;
use crate::poles::by_hand;
use crate::poles::refine::{refine, Refined};
use crate::poles::sections::Section;
use crate::tolerances as tol;
use chladni_frf::{Finding, Trust};
use chladni_linalg::LinalgError;
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;

/// A section with the poles found in it.
#[derive(Clone)]
pub(crate) struct Search<'a> {
    record: &'a Record<'a>,
    /// The section searched.
    pub section: &'a Section,
    /// Unweighted columns.
    plain: Columns,
    level: Array1<f64>,
    model: NoiseModel,
    weighted: Columns,
    /// Poles.
    pub candidates: Candidates,
    /// Mergers.
    pub notes: Vec<(Complex64, Finding)>,
}

impl<'a> Search<'a> {
    /// Searches. `asked`: modes that the user knows to be there.
    pub fn run(
        record: &'a Record<'a>,
        section: &'a Section,
        asked: Option<usize>,
    ) -> Result<Self, LinalgError> {
        let plain = record.work.rows(section.lines.clone());
        let model = NoiseModel::start(record.noise.slice(s![section.lines.clone()]).to_owned());
        let level = line_energy(&plain.b);
        let weighted = plain.reweighted(&model.weights(&level));
        let seen: Vec<Peak> = record
            .seen
            .iter()
            .copied()
            .filter(|p| plain.in_band(p.lambda))
            .collect();
        let seeds: Vec<Complex64> = seen.iter().map(|p| p.lambda).collect();
        let strongest = seen.iter().map(|p| p.level_db).fold(f64::MIN, f64::max);
        let strong: Vec<Complex64> = seen
            .iter()
            .filter(|p| p.level_db > strongest - STRONG_DB)
            .map(|p| p.lambda)
            .collect();
        let second =
            (strong.len() * 2 < seeds.len() && !strong.is_empty()).then_some(strong.as_slice());
        let base = asked.unwrap_or(0).max(seeds.len()).max(BASE_LEAST);
        let votes = consensus(&weighted, &seeds, base, second, &RESIDUAL_POWERS)?;
        let (start, origin): (Vec<Complex64>, Vec<Origin>) = votes.into_iter().unzip();
        let refined = refine(
            &weighted,
            &start,
            &RESIDUAL_POWERS,
            tol::ROUGH.within(2 * tol::ROUGH.steps),
        )?;
        let candidates = Candidates { refined, origin };
        let mut search = Self {
            record,
            section,
            plain,
            level,
            model,
            weighted,
            candidates,
            notes: Vec::new(),
        };
        search.reweigh()?;
        search.settle(&seen)?;
        Ok(search)
    }

    /// Local tests until the poles are those that their neighbourhoods need.
    fn settle(&mut self, seen: &[Peak]) -> Result<(), LinalgError> {
        if self.model.multiplicative < RESEED_BELOW {
            for _ in 0..RESEED.1 {
                if !self.reseed()? {
                    break;
                }
                self.reweigh()?;
            }
        }
        remove_unneeded(&self.weighted, &mut self.candidates)?;
        if self.record.frfs == 1 {
            self.drop_shadows()?;
        }
        for peak in seen.iter().filter(|p| p.is_striking()) {
            if !self.candidates.explain(peak.lambda) {
                try_add(&self.weighted, &mut self.candidates, peak.lambda)?;
            }
        }
        self.notes = merge(&self.weighted, &mut self.candidates, self.record.hz)?;
        Ok(())
    }

    /// Refines with the error model that the residual shows, twice.
    fn reweigh(&mut self) -> Result<(), LinalgError> {
        for _ in 0..WEIGHT_ROUNDS {
            let residual = self.residual();
            let fitted = line_energy(&(&self.plain.b - &residual));
            self.model = NoiseModel::from_residual(&residual, &fitted);
            self.weighted = self.plain.reweighted(&self.model.weights(&self.level));
            self.candidates.refined = refine(
                &self.weighted,
                &self.candidates.refined.lambda,
                &RESIDUAL_POWERS,
                tol::ROUGH.within(2 * tol::ROUGH.steps),
            )?;
        }
        Ok(())
    }

    /// The residual without line weights.
    fn residual(&self) -> Array2<Complex64> {
        let mut out = self.candidates.refined.projection.residual.clone();
        for (k, mut row) in out.rows_mut().into_iter().enumerate() {
            let ratio = self.weighted.g[k] / self.plain.g[k].max(tol::TINY);
            row.mapv_inplace(|v| v / ratio);
        }
        out
    }

    /// Tries poles at the peaks of the residual; true where one was accepted.
    fn reseed(&mut self) -> Result<bool, LinalgError> {
        let residual = self
            .weighted
            .with_columns(self.candidates.refined.projection.residual.clone());
        let noise = fourth_difference_noise(&residual, noise_window(residual.lines()));
        let mut changed = false;
        for peak in peaks(&residual, &line_energy(&residual.b), &noise)
            .into_iter()
            .take(RESEED.0)
        {
            changed |= peak.over_noise_db > RESEED_OVER_NOISE_DB
                && !self.candidates.explain(peak.lambda)
                && try_add(&self.weighted, &mut self.candidates, peak.lambda)?;
        }
        Ok(changed)
    }

    /// With one FRF nothing but the line shape tells a close pair from one misfitted
    /// mode: the partner that few orders agree on, or that lies 20 dB below the other, is
    /// taken for misfit.
    fn drop_shadows(&mut self) -> Result<(), LinalgError> {
        loop {
            let residual = self.residual();
            let Refined { lambda, .. } = &self.candidates.refined;
            let in_band = |p: &Complex64| self.weighted.in_band(*p);
            let close = |q: usize| {
                let near = |other: &Complex64| {
                    (other.re - lambda[q].re).abs() < APART * lambda[q].im.max(other.im)
                };
                lambda
                    .iter()
                    .enumerate()
                    .any(|(o, other)| o != q && in_band(other) && near(other))
            };
            let doubtful = |q: usize| match self.candidates.origin[q] {
                Origin::Agreed { score, .. } if score >= SHADOW.0 => {
                    look(
                        self.record,
                        &self.plain,
                        &residual,
                        &self.candidates.refined,
                        q,
                    )
                    .part
                        < SHADOW.1
                }
                _ => true,
            };
            let Some(q) =
                (0..lambda.len()).find(|&q| in_band(&lambda[q]) && close(q) && doubtful(q))
            else {
                return Ok(());
            };
            remove(&self.weighted, &mut self.candidates, q)?;
        }
    }

    /// True where the pole is this section's to report; half a width beyond a cut counts,
    /// its twin is dropped later.
    pub fn owns(&self, pole: Complex64) -> bool {
        self.section.core.start - OWNED_BEYOND * pole.im <= pole.re
            && pole.re < self.section.core.end + OWNED_BEYOND * pole.im
    }

    /// Owned modes that may be dropped where the user asks for fewer, and the one of least
    /// evidence; `trust`: what poles would be graded.
    pub fn weakest(&self, trust: &[(Complex64, Trust)]) -> Result<Weakest, LinalgError> {
        let gains = one_column_gains(&self.weighted, &self.candidates.refined, 0)?;
        let graded = |pole: Complex64| {
            let near = trust
                .iter()
                .filter(|(known, _)| (known - pole).norm() < pole.im);
            near.min_by(|(a, _), (b, _)| (a - pole).norm().total_cmp(&(b - pole).norm()))
                .map_or(Trust::Weak, |(_, trust)| *trust)
        };
        let open: Vec<Dispensable> = (0..gains.len())
            .filter_map(|q| {
                let lambda = self.candidates.refined.lambda[q];
                let counts = self.candidates.may_go(q)
                    && self.weighted.in_band(lambda)
                    && self.owns(lambda)
                    && graded(lambda) != Trust::Rejected;
                counts.then(|| Dispensable {
                    pole: q,
                    sure: graded(lambda) == Trust::Sure,
                    gain: gains[q],
                })
            })
            .collect();
        Ok(Weakest {
            count: open.len(),
            least: open.into_iter().min_by(Dispensable::after),
        })
    }

    /// Fits a pole at each place that the user has seen and no pole explains. It stays whatever
    /// its evidence, which its grade tells.
    pub fn add(&mut self, asked: Asked) -> Result<(), LinalgError> {
        let known: Vec<Complex64> = self.counted().collect();
        let mut starts = by_hand::starts(asked.added_hz, &self.plain, &known, self.record.hz);
        starts.retain(|start| self.owns(*start));
        if starts.is_empty() {
            return Ok(());
        }
        for start in starts {
            match self.left_out_at(start) {
                Some(q) => self.candidates.origin[q] = Origin::Added,
                None => add(&self.weighted, &mut self.candidates, start)?,
            }
        }
        self.reweigh()
    }

    /// True where a pole of this section stands within a half-bandwidth of `pole`.
    pub fn holds(&self, pole: Complex64) -> bool {
        self.owns(pole) && self.counted().any(|known| (known - pole).norm() < pole.im)
    }

    /// Poles that are not left out.
    fn counted(&self) -> impl Iterator<Item = Complex64> + '_ {
        let Candidates { refined, origin } = &self.candidates;
        let all = refined.lambda.iter().zip(origin);
        all.filter(|(_, origin)| **origin != Origin::LeftOut)
            .map(|(pole, _)| *pole)
    }

    /// A pole that is left out where `place` lies within its half-bandwidth.
    fn left_out_at(&self, place: Complex64) -> Option<usize> {
        let Candidates { refined, origin } = &self.candidates;
        (0..origin.len()).find(|&q| {
            let pole = refined.lambda[q];
            origin[q] == Origin::LeftOut && (pole.re - place.re).abs() < pole.im.max(place.im)
        })
    }

    /// Leaves one pole out of the count. An isolated pole stays in the fit, so that its skirts
    /// do not disturb the others. A pole beside another is removed: the other takes over its
    /// part.
    pub fn drop(&mut self, q: usize) -> Result<(), LinalgError> {
        let Candidates { refined, origin } = &mut self.candidates;
        let own = refined.lambda[q];
        let beside =
            refined.lambda.iter().enumerate().any(|(o, other)| {
                o != q && (other.re - own.re).abs() < APART * other.im.max(own.im)
            });
        if beside {
            return remove(&self.weighted, &mut self.candidates, q);
        }
        origin[q] = Origin::LeftOut;
        Ok(())
    }

    /// Scatter of the FRFs' own poles around pole `q`, and their number; `None` where the
    /// columns are no FRFs, or one.
    fn scatter(&self, q: usize) -> Result<Option<(f64, usize)>, LinalgError> {
        let refined = &self.candidates.refined;
        if self.weighted.columns() <= 1
            || !self.weighted.in_band(refined.lambda[q])
            || self.record.scales.is_none()
        {
            return Ok(None);
        }
        let own = own_poles(&self.weighted, refined, &[q])?.poles;
        Ok(Some((weighted_scatter(refined, q, &own), own.len())))
    }

    /// The last refinement, and the evidence about every pole.
    pub fn finish(mut self) -> Result<Finished, LinalgError> {
        self.reweigh()?;
        self.candidates.refined = refine(
            &self.weighted,
            &self.candidates.refined.lambda,
            &RESIDUAL_POWERS,
            tol::FINE,
        )?;
        let mut local = vec![None; self.candidates.refined.lambda.len()];
        if !self.record.needs_all_lines() {
            (self.candidates.refined, local) = refine_resolved(
                &self.plain,
                &self.weighted,
                &self.residual(),
                &self.candidates.refined,
            )?;
        }
        let refined = &self.candidates.refined;
        let (robust, white) = variances(&self.weighted, refined)?;
        let gains = one_column_gains(&self.weighted, refined, 0)?;
        let without_two = one_column_gains(&self.weighted, refined, NEAREST_LINES[0])?;
        let without_four = one_column_gains(&self.weighted, refined, NEAREST_LINES[1])?;
        let residual = self.residual();
        let mut evidence = Vec::new();
        for q in 0..refined.lambda.len() {
            let pole = refined.lambda[q];
            let mut e = look(self.record, &self.plain, &residual, refined, q);
            e.origin = self.candidates.origin[q];
            e.gain = gains[q];
            e.gain_without_nearest = without_two[q];
            e.gain_of_skirts = without_four[q];
            if let Some(errors) = self.record.correlated_noise {
                e.over_noise = over_chance(&self.weighted, refined, q, errors)?;
            }
            let mut deviation = local[q].unwrap_or(robust[q].max(white[q])).sqrt();
            if let Some((scatter, frfs)) = self.scatter(q)? {
                e.scatter = Some(scatter / pole.im);
                deviation = deviation.max(scatter / (frfs as f64).sqrt());
            }
            deviation = deviation.max(e.odd_even().unwrap_or(0.0) * pole.im / ODD_EVEN_SIGMAS);
            e.deviation = deviation / pole.im;
            evidence.push(e);
        }
        let variance = self.model.variance(&self.level);
        evidence.retain(|e| self.owns(e.lambda));
        let notes = self
            .notes
            .iter()
            .filter(|(pole, _)| self.owns(*pole))
            .map(|(_, note)| note.clone())
            .collect();
        Ok(Finished {
            evidence,
            variance,
            lines: self.section.lines.clone(),
            notes,
        })
    }
}

/// Modes that a section may drop.
pub(crate) struct Weakest {
    /// Number of these modes.
    pub count: usize,
    /// The one of least evidence.
    pub least: Option<Dispensable>,
}

/// One of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dispensable {
    /// Its place.
    pub pole: usize,
    sure: bool,
    gain: f64,
}

impl Dispensable {
    /// Order in which they go.
    pub fn after(&self, other: &Self) -> std::cmp::Ordering {
        let own = self.sure.cmp(&other.sure);
        own.then(self.gain.total_cmp(&other.gain))
    }
}

/// The result of the search of a section.
pub(crate) struct Finished {
    /// Evidence about every pole it owns, nuisance poles included.
    pub evidence: Vec<Evidence>,
    /// Variance of one value per line, by its error model.
    pub variance: Array1<f64>,
    /// Lines of the section.
    pub lines: std::ops::Range<usize>,
    /// Mergers.
    pub notes: Vec<Finding>,
}

/// Rms distance of the own poles from the common one, each FRF weighted by how strongly
/// it shows the mode.
fn weighted_scatter(refined: &Refined, q: usize, own: &[Complex64]) -> f64 {
    let pole = refined.lambda[q];
    let (mut sum, mut total) = (0.0, 0.0);
    for (p, r) in own.iter().zip(refined.coefficients.row(q)) {
        let weight = r.norm_sqr();
        sum += weight
            * (p - pole)
                .norm_sqr()
                .min(OWN_POLE_FARTHEST * pole.im * pole.im);
        total += weight;
    }
    if total > 0.0 {
        (sum / total).sqrt()
    } else {
        0.0
    }
}
