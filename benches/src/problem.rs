//! A measurement whose truth is known: clean FRFs, the model behind them, and the noise
//! that a seed adds.

use chladni_frf::{FrfSet, FrfValues, ModalModel, Result};
use chladni_plate::{
    add_noise_of_variance, cramer_rao, cramer_rao_rank_one, cramer_rao_real, gain_noise,
    noise_variance, simulate, CramerRao, Panel, Synthetic,
};

/// Powers of ω of the residual terms that any fit of a band must leave free
/// (`docs/theory.md`, eq. 5).
const RESIDUAL_POWERS: [i32; 4] = [-2, 0, 2, 4];
/// Modes so many half-power bandwidths outside the band bend its edge: their poles are
/// unknowns of the bound as well.
const NEAR_BANDWIDTHS: f64 = 5.0;

/// FRFs without noise, their truth, and the noise.
#[derive(Debug, Clone)]
pub struct Problem {
    /// FRFs without noise, in double precision.
    pub clean: FrfSet,
    /// The model whose synthesis they are.
    pub truth: ModalModel,
    /// E|n|² of the white noise, in the measured kind's unit squared.
    pub noise_variance: f64,
    /// Standard deviation of a gain error per line that all FRFs share; zero: none.
    pub common_gain: f64,
}

/// Least standard deviations of the in-band modes, see [`cramer_rao`].
#[derive(Debug, Clone)]
pub struct Bounds {
    /// Residues free in each FRF.
    pub free: CramerRao,
    /// One shape per mode.
    pub rank_one: CramerRao,
    /// One real shape per mode, as all cases have them.
    pub real: CramerRao,
}

impl Problem {
    /// FRFs of abstract modes, `snr_db` above white noise.
    ///
    /// # Errors
    /// As [`Synthetic::build`].
    pub fn of_modes(spec: &Synthetic) -> Result<Self> {
        let set = Synthetic {
            snr_db: f64::INFINITY,
            ..spec.clone()
        }
        .build()?;
        Ok(Self::new(set.frf, set.truth, spec.snr_db))
    }

    /// FRFs of a plate.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn of_panel(panel: &Panel) -> Result<Self> {
        let simulation = simulate(panel, None, Some(f64::INFINITY))?;
        Ok(Self::new(
            simulation.frf,
            simulation.truth,
            panel.frf.snr_db,
        ))
    }

    fn new(clean: FrfSet, truth: ModalModel, snr_db: f64) -> Self {
        let mut problem = Self {
            clean,
            truth,
            noise_variance: 0.0,
            common_gain: 0.0,
        };
        if let FrfValues::F64(values) = &problem.clean.values {
            problem.noise_variance = noise_variance(values, snr_db);
        }
        problem
    }

    /// The same with a gain error of this standard deviation per line, common to all
    /// FRFs.
    pub fn with_common_gain(self, common_gain: f64) -> Self {
        Self {
            common_gain,
            ..self
        }
    }

    /// The same noise without any structure.
    pub fn without_modes(mut self) -> Self {
        if let FrfValues::F64(values) = &mut self.clean.values {
            values.fill(Default::default());
        }
        self.truth.modes.clear();
        self.truth.residual_terms.terms.clear();
        self
    }

    /// The measurement with the noise of `seed`.
    pub fn measured(&self, seed: u64) -> FrfSet {
        let mut frf = self.clean.clone();
        if self.common_gain > 0.0 {
            gain_noise(&mut frf, self.common_gain, true, seed);
        }
        if let FrfValues::F64(values) = &mut frf.values {
            add_noise_of_variance(values, self.noise_variance, seed);
        }
        frf
    }

    /// Bounds of the in-band modes; `None` where white noise is absent or not the only
    /// one.
    ///
    /// # Errors
    /// As [`cramer_rao`].
    pub fn bounds(&self) -> Result<Option<Bounds>> {
        if self.noise_variance == 0.0 || self.common_gain > 0.0 {
            return Ok(None);
        }
        let [low, high] = self.truth.band_hz;
        let mut model = self.truth.clone();
        let mut wanted = Vec::new();
        for mode in &mut model.modes {
            let outside_hz = (low - mode.frequency_hz).max(mode.frequency_hz - high);
            let in_band = std::mem::replace(
                &mut mode.in_band,
                outside_hz < NEAR_BANDWIDTHS * mode.loss_factor * mode.frequency_hz,
            );
            if mode.in_band {
                wanted.push(in_band);
            }
        }
        let only_wanted = |bound: CramerRao| {
            let keep = |values: Vec<f64>| {
                values
                    .into_iter()
                    .zip(&wanted)
                    .filter(|(_, wanted)| **wanted)
                    .map(|(value, _)| value)
                    .collect()
            };
            CramerRao {
                frequency_std_hz: keep(bound.frequency_std_hz),
                loss_factor_std: keep(bound.loss_factor_std),
            }
        };
        let (axis, variance) = (&self.clean.frequency_hz, self.noise_variance);
        Ok(Some(Bounds {
            free: only_wanted(cramer_rao(&model, axis, variance, &RESIDUAL_POWERS)?),
            rank_one: only_wanted(cramer_rao_rank_one(
                &model,
                axis,
                variance,
                &RESIDUAL_POWERS,
            )?),
            real: only_wanted(cramer_rao_real(&model, axis, variance, &RESIDUAL_POWERS)?),
        }))
    }
}
