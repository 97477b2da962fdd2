//! The rig as all fields together tell it: the operator of the estimator that counts.
//!
//! The one counts that foretold the newest field better; of a first field the structured
//! one, unless its modes want to move by the largest scale.

use super::calibrated::movable_modes;
use super::calibration::{
    CalibratedMode, CalibratedOperator, Calibration, ChannelGain, Estimator, CALIBRATION_FORMAT,
    CALIBRATION_VERSION,
};
use super::correction::Correction;
use super::estimators::{estimate, miss, score, Estimators};
use super::field::rms;
use super::kalman::KalmanOperator;
use super::parts::Parts;
use super::prior::design;
use super::seen::Seen;
use crate::problems::setup::Setup;
use crate::scene::drift::Drift;
use crate::scene::scene_file::Scene;
use crate::tolerances;
use chladni_frf::{ComplexMatrix, Dof, Error, Finding, ModalModel, Result, CREATED_BY};
use num_complex::Complex64;

/// The result of all fields together.
pub(super) struct Learned {
    pub(super) estimators: Estimators,
    /// The estimator that counts.
    pub(super) chosen: Estimator,
    /// NIS of each field against what was foretold of it.
    pub(super) nis: Vec<f64>,
    /// Findings on fields after the first.
    pub(super) findings: Vec<Finding>,
}

impl Learned {
    /// Takes in the fields one by one: each is foretold from those before it.
    ///
    /// # Errors
    /// No field; a later one that turns the wrong way or lies at another level than those before
    /// it foretell; those of the factorisations.
    pub(super) fn of(
        model: &ModalModel,
        setup: &Setup,
        scene: &Scene,
        seen: &[Seen],
    ) -> Result<Self> {
        let drift = &scene.drift.unwrap_or_default();
        let all: Vec<usize> = (0..setup.operator.responses.len()).collect();
        let parts = Parts::new(model, &setup.operator);
        let unmeasured = |drift: &Drift| -> Result<KalmanOperator> {
            Ok(KalmanOperator {
                mobility: setup.operator.mobility.clone(),
                covariance: design(model, &setup.operator, scene, drift)?.gram().clone(),
            })
        };
        let first = unmeasured(drift)?;
        let open = unmeasured(&drift.with_drive_error(tolerances::OPERATOR_DRIVE_ERROR))?;
        let mut learned: Option<Self> = None;
        for (count, newest) in (1..).zip(seen) {
            let whole = newest.rows.len() == all.len();
            let (mut chosen, mut nis) = (Estimator::Structured, Vec::new());
            let mut findings = Vec::new();
            let mut before = None;
            match learned {
                Some(known) => {
                    let likeness = newest.likeness(&known.operator().mobility);
                    let refused = likeness.check().map_err(|error| {
                        let about = error.field.clone().unwrap_or_default();
                        error.field(format!("{about} of field {count}"))
                    });
                    refused?;
                    findings = known.findings;
                    let told = likeness.finding();
                    findings.extend(told.map(|told| told.about(format_args!("field {count}"))));
                    chosen = known.chosen;
                    if whole {
                        let error = |of| miss(known.estimators.operator(of), newest);
                        let other = error(Estimator::Kalman) < error(Estimator::Structured);
                        chosen = [Estimator::Structured, Estimator::Kalman][usize::from(other)];
                    }
                    nis = known.nis;
                    nis.push(score(known.estimators.operator(chosen), newest));
                    before = Some(known.estimators.structured);
                }
                None => nis.push(score(&first, newest)),
            }
            let estimators = estimate(&parts, [&first, &open], &seen[..count], before.as_ref())?;
            let largest = tolerances::MODE_SCALES[tolerances::MODE_SCALES.len() - 1];
            if count == 1 && whole && estimators.structured.scales.modes >= largest {
                chosen = Estimator::Kalman;
            }
            learned = Some(Self {
                estimators,
                chosen,
                nis,
                findings,
            });
        }
        learned.ok_or_else(|| {
            Error::bad_data("no field to correct by")
                .field("field")
                .found("none")
                .expected("at least one pair of weights and measured field")
                .help("play the weights, measure the field, and give both")
        })
    }

    /// The operator of the estimator that counts.
    fn operator(&self) -> &KalmanOperator {
        self.estimators.operator(self.chosen)
    }

    /// Factor on the covariance: where the newest field was not what was foretold, the
    /// error bars were too small by that much. Of a first field nothing is known.
    fn inflation(&self) -> f64 {
        match self.nis.as_slice() {
            [_, .., newest] => newest.max(1.0),
            _ => 1.0,
        }
    }

    /// The scene over the operator of the estimator that counts, with `share` of its covariance.
    ///
    /// # Errors
    /// Those of the factorisation of the covariance.
    pub(super) fn laid(&self, setup: &Setup, share: f64) -> Result<Setup> {
        let operator = self.operator();
        let inflation = self.inflation();
        let covariance = operator
            .covariance
            .mapv(|value| value * inflation)
            .mapv(|value| value * share);
        setup.with_operator(operator.mobility.clone(), covariance)
    }

    /// The present knowledge of the rig.
    ///
    /// * `own`, `model`: the model as it was fitted, and as the calibration before made it
    /// * `swapped`: channels of swapped cables; nothing is kept of their gains, since nobody knows
    ///   whether they are of the amplifier or of the actuator
    pub(super) fn calibration(
        &self,
        [own, model]: [&ModalModel; 2],
        corrected: &Setup,
        before: Option<&Calibration>,
        told: &Correction,
        swapped: Option<[usize; 2]>,
    ) -> Calibration {
        let gains = self.gains(before, told, swapped);
        let mut dead: Vec<Dof> = before.map_or(Vec::new(), |known| known.dead.clone());
        let mut sizes: Vec<f64> = gains
            .iter()
            .filter(|gain| !gain.odd)
            .map(|gain| gain.re.hypot(gain.im))
            .collect();
        sizes.sort_by(f64::total_cmp);
        let level = sizes.get(sizes.len() / 2).map_or(1.0, |size| *size);
        let died = gains.iter().filter(|gain| gain.is_dead_beside(level));
        dead.extend(died.map(|gain| gain.reference));
        Calibration {
            format: CALIBRATION_FORMAT.into(),
            version: CALIBRATION_VERSION,
            created_by: CREATED_BY.into(),
            source: before.map_or(Vec::new(), |known| known.source.clone()),
            unit: Some(corrected.operator.unit),
            gain_tables: before.map_or(Vec::new(), |known| known.gain_tables.clone()),
            fields: told.iteration + before.map_or(0, |known| known.fields),
            scan_due: told.scan_due,
            scan_reason: told.scan_reason.clone(),
            gains,
            dead,
            modes: self.modes([own, model], corrected.operator.frequency_hz),
            operators: self.operators(corrected, before, told, swapped),
        }
    }

    fn holds_structured(&self) -> bool {
        self.chosen == Estimator::Structured
    }

    /// The gain of every channel: as known before, times what is told now where that counts.
    fn gains(
        &self,
        before: Option<&Calibration>,
        told: &Correction,
        swapped: Option<[usize; 2]>,
    ) -> Vec<ChannelGain> {
        let common = self.common_factor();
        let gain = |(i, gain): (usize, &ChannelGain)| {
            let known = before.map_or(Complex64::ONE, |known| known.gain_of(gain.reference));
            let is_swapped = swapped.is_some_and(|pair| pair.contains(&i));
            let factor = match (self.holds_structured() || gain.odd) && !is_swapped {
                true => known * Complex64::new(gain.re, gain.im),
                false => known * common,
            };
            let std = match is_swapped {
                true => gain.std.max(tolerances::RIG_DRIVE_ERROR),
                false => gain.std,
            };
            ChannelGain {
                re: factor.re,
                im: factor.im,
                std,
                odd: gain.odd && !is_swapped,
                ..*gain
            }
        };
        told.gains.iter().enumerate().map(gain).collect()
    }

    /// The factor that all channels share; 1 where they have none.
    fn common_factor(&self) -> Complex64 {
        let factor = self.estimators.structured.common_factor();
        factor.unwrap_or(Complex64::ONE)
    }

    /// The modes that may move, as they stand now at a drive frequency.
    fn modes(&self, [own, model]: [&ModalModel; 2], frequency_hz: f64) -> Vec<CalibratedMode> {
        let structured = &self.estimators.structured;
        let mode = |(k, n): (usize, usize)| {
            let [fitted, known] = [&own.modes[n], &model.modes[n]];
            let (frequency_hz, loss_factor) = match self.holds_structured() {
                true => structured.moved_pole(k, known, model.damping, frequency_hz),
                false => (known.frequency_hz, known.loss_factor),
            };
            CalibratedMode {
                model_hz: fitted.frequency_hz,
                frequency_hz,
                loss_factor,
                std: structured.shift_std[k],
            }
        };
        movable_modes(own)
            .into_iter()
            .enumerate()
            .map(mode)
            .collect()
    }

    /// The operator at the drive frequency, and those from before elsewhere, rising in
    /// frequency.
    fn operators(
        &self,
        corrected: &Setup,
        before: Option<&Calibration>,
        told: &Correction,
        swapped: Option<[usize; 2]>,
    ) -> Vec<CalibratedOperator> {
        let operator = &corrected.operator;
        let mut mobility = operator.mobility.clone();
        let mut covariance = corrected.problem.covariance.gram().clone();
        for i in swapped.into_iter().flatten() {
            if self.holds_structured() {
                let own = self.common_factor() / (1.0 + self.estimators.structured.gains[i]);
                let without_gain = mobility.column(i).mapv(|value| value * own);
                mobility.column_mut(i).assign(&without_gain);
            }
            let square = rms(&mobility.column(i).to_owned()).powi(2);
            covariance[[i, i]] += square * tolerances::RIG_DRIVE_ERROR.powi(2);
        }
        let frequency_hz = operator.frequency_hz;
        let here = before.and_then(|known| known.at(frequency_hz));
        let mut operators = vec![CalibratedOperator {
            frequency_hz,
            fields: told.iteration + here.map_or(0, |known| known.fields),
            estimator: self.chosen,
            responses: operator.responses.clone(),
            references: operator.references.clone(),
            mobility: ComplexMatrix(mobility),
            covariance: ComplexMatrix(covariance),
        }];
        let elsewhere = |known: &&CalibratedOperator| {
            let distance = (known.frequency_hz - frequency_hz).abs();
            distance > tolerances::SAME_FREQUENCY * frequency_hz
        };
        let before = before.iter().flat_map(|known| &known.operators);
        operators.extend(before.filter(elsewhere).cloned());
        operators.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        operators
    }
}
