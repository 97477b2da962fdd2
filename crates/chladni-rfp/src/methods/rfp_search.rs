//! The search of `rfp` in the plane of one law: poles of each band, thinned, then
//! one fraction for all that is left.

use super::limits::{BACKGROUND, CLAIM, HELPER_TAKEN, LAST_STEPS, REWEIGHTED, TWINS};
use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::plane::Plane;
use crate::data::columns::Columns;
use crate::data::options::{FitOptions, RfpWeight};
use crate::methods::fraction::{damped, Lines};
use crate::methods::instrumental::{improved, Steps};
use crate::methods::overlapping_bands::{order, overlapping_bands, OverlappingBand};
use crate::methods::sanathanan_koerner::sanathanan_koerner;
use crate::methods::selection::{inside, left_by, poles_beyond_ends, thin_to};
use crate::methods::survey::{Compressed, Survey};
use crate::poles::prune::narrower_than_a_line;
use crate::poles::refine::removable;
use crate::poles::significance::threshold;
use chladni_frf::Damping;
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use rayon::prelude::*;

/// The poles of one band, or of all, λ in the plane of a law.
pub(super) struct BandPoles {
    pub(super) law: Damping,
    pub(super) poles: Vec<Complex64>,
    /// Roots in the band that turned the wrong way, of how many.
    pub(super) turned: usize,
    pub(super) all: usize,
    /// Leading coefficient of the last fraction over the length of all.
    pub(super) leading: f64,
}

impl BandPoles {
    fn none(law: Damping) -> Self {
        Self {
            law,
            poles: Vec::new(),
            turned: 0,
            all: 0,
            leading: 1.0,
        }
    }
}

/// The search in one law.
pub(super) struct Search<'a> {
    survey: &'a Survey<'a>,
    options: &'a FitOptions,
    law: Damping,
    work: Columns,
    /// Noise variance of one value; 0: only the residual tells it.
    noise: f64,
    /// Weight of noise in the compressed columns: their directions are those of most energy, of
    /// noise too.
    chosen: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        survey: &'a Survey,
        columns: &Compressed,
        options: &'a FitOptions,
        law: Damping,
    ) -> Self {
        let (lines, frfs) = (
            survey.data.lines.len() as f64,
            survey.data.pairs.len() as f64,
        );
        Self {
            survey,
            options,
            law,
            work: columns.work.clone().in_law(law),
            noise: noise_of(survey, columns),
            chosen: (1.0 + (frfs / (2.0 * lines)).sqrt()).powi(2),
        }
    }

    /// All steps.
    pub(super) fn run(&self) -> Result<BandPoles, LinalgError> {
        let work = &self.work;
        let mut found = BandPoles::none(self.law);
        let bands = overlapping_bands(
            &self.survey.peaks,
            &self.survey.energy,
            self.options.rfp.bands,
        );
        let parts = bands
            .par_iter()
            .map(|band| self.search(band, bands.len()))
            .collect::<Result<Vec<BandPoles>, LinalgError>>()?;
        for part in parts {
            found.turned += part.turned;
            found.all += part.all;
            found.poles.extend(part.poles);
        }
        found.poles = without_duplicates(found.poles);
        match self.options.modes {
            None => {
                self.thin(work, &mut found.poles)?;
                drop_background(work, &mut found.poles, 0);
            }
            Some(asked) => {
                drop_background(work, &mut found.poles, asked);
                self.thin(work, &mut found.poles)?;
            }
        }
        let steps = match self.options.rfp.weight {
            RfpWeight::Linear | RfpWeight::Sk => None,
            RfpWeight::Iv => Some(Steps::Instrumental),
            RfpWeight::Gn => Some(Steps::GaussNewton),
        };
        if let Some(steps) = steps {
            // modes there may need one more pole than the bands found
            let helpers = poles_beyond_ends(work, &found.poles, HELPER_TAKEN);
            found.poles.extend(helpers);
            self.thin(work, &mut found.poles)?;
            let lines = Lines::new(Plane::new(self.law, &work.x), work);
            let mut before = usize::MAX;
            while found.poles.len() < before && !found.poles.is_empty() {
                before = found.poles.len();
                let improved = improved(&lines, &found.poles, steps, LAST_STEPS)?;
                (found.poles, found.leading) = (improved.lambda, improved.leading);
                self.thin(work, &mut found.poles)?;
            }
        }
        Ok(found)
    }

    /// Poles of one band.
    fn search(&self, band: &OverlappingBand, bands: usize) -> Result<BandPoles, LinalgError> {
        let mut found = BandPoles::none(self.law);
        let whole = &self.work;
        let work = whole.rows(band.rows.clone());
        let peaks = &self.survey.peaks;
        let visible = peaks.iter().filter(|p| band.rows.contains(&p.row)).count();
        let asked = self.options.modes.map(|modes| modes.div_ceil(bands));
        let order = order(&work, visible, asked)?;
        let lines = Lines::new(Plane::new(self.law, &work.x), &work);
        let steps = match self.options.rfp.weight {
            RfpWeight::Linear => 0,
            _ => REWEIGHTED,
        };
        let roots = sanathanan_koerner(&lines, order, steps)?;
        let (stable, turned): (Vec<Complex64>, Vec<Complex64>) =
            roots.iter().partition(|root| root.im > 0.0);
        let mut poles = lines.plane.poles(&stable);
        let wrong = inside(&work, &lines.plane.poles(&damped(&turned)));
        found.turned += wrong;
        found.all += wrong + inside(&work, &poles);
        self.thin(&work, &mut poles)?;
        if self.options.modes.is_none() {
            drop_background(&work, &mut poles, 0);
        }
        let last = whole.lines();
        found.poles.extend(poles.into_iter().filter(|pole| {
            let claim = CLAIM * pole.im;
            (band.core.start == 0 || pole.re + claim >= whole.x[band.core.start])
                && (band.core.end == last || pole.re - claim < whole.x[band.core.end])
        }));
        Ok(found)
    }

    /// Takes out what `work` does not tell from noise, down to the modes asked for.
    fn thin(&self, work: &Columns, poles: &mut Vec<Complex64>) -> Result<(), LinalgError> {
        poles.retain(|pole| !narrower_than_a_line(work, *pole));
        if poles.is_empty() {
            return Ok(());
        }
        let whole = work.lines() == self.work.lines();
        let all = removable(work, poles, &RESIDUAL_POWERS)?;
        let variance = (self.chosen * self.noise).max(left_by(work, all.sse, all.unknowns()));
        let limit = threshold(work.columns(), work.lines()) * variance;
        let modes = match self.options.modes {
            None => 0..=usize::MAX,
            Some(asked) if whole => asked..=asked,
            // a band keeps all that it has: the number asked for is that of the whole
            Some(_) => usize::MAX..=usize::MAX,
        };
        *poles = thin_to(work, all, poles, modes, limit);
        Ok(())
    }
}

/// Noise variance of one value; 0 where only the residual tells it.
fn noise_of(survey: &Survey, columns: &Compressed) -> f64 {
    let (lines, frfs) = (survey.data.lines.len(), survey.data.pairs.len());
    match frfs.saturating_sub(columns.work.columns()) {
        0 => 0.0,
        beyond => columns.outside / (lines * beyond) as f64,
    }
}

/// Poles without those that two bands found.
fn without_duplicates(poles: Vec<Complex64>) -> Vec<Complex64> {
    let mut kept: Vec<Complex64> = Vec::new();
    for pole in poles {
        let same = |other: &Complex64| (other - pole).norm() < TWINS * other.im.min(pole.im);
        if !kept.iter().any(same) {
            kept.push(pole);
        }
    }
    kept
}

/// Drops poles of the band that are broad in bandwidth and in loss factor, unless fewer
/// than `least` would be left there.
fn drop_background(work: &Columns, poles: &mut Vec<Complex64>, least: usize) {
    let median = |measure: &dyn Fn(&Complex64) -> f64| {
        let mut values: Vec<f64> = poles
            .iter()
            .filter(|pole| work.in_band(**pole))
            .map(measure)
            .collect();
        values.sort_by(f64::total_cmp);
        values
            .get(values.len() / 2)
            .copied()
            .unwrap_or(f64::INFINITY)
    };
    let loss = |pole: &Complex64| pole.im / pole.re;
    let width = |pole: &Complex64| pole.im / pole.re.abs().sqrt();
    let (most_loss, most_width) = (BACKGROUND * median(&loss), BACKGROUND * median(&width));
    let narrow = |pole: &Complex64| {
        !work.in_band(*pole) || loss(pole) < most_loss || width(pole) < most_width
    };
    let kept: Vec<Complex64> = poles.iter().copied().filter(narrow).collect();
    if inside(work, &kept) >= least {
        *poles = kept;
    }
}
