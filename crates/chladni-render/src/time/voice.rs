//! One tone of a play: the panel about its carrier, the steady drive of every place, and
//! how the drive passes from one to the next.

use crate::methods::options::RenderOptions;
use crate::methods::robust;
use crate::panel::drive::{Drive, DriveLimits};
use crate::panel::operator::{outside_band, Operator};
use crate::problems::setup::{check_ground, drive_limits, Setup};
use crate::render::render;
use crate::results::evaluate::drive_on;
use crate::results::weights::Weights;
use crate::rig::at_tone;
use crate::scene::limits::Limits;
use crate::scene::scene_file::Scene;
use crate::time::causal::CausalModel;
use crate::time::modal_ramp::{corrected, correction};
use crate::time::plan::Place;
use crate::time::programs::Programs;
use crate::time::timeline::zones_of;
use chladni_frf::{Finding, ModalModel, Result};
use ndarray::Array2;
use num_complex::Complex64;

/// One tone.
pub(crate) struct Voice {
    pub(crate) frequency_hz: f64,
    pub(crate) operator: Operator,
    pub(crate) model: CausalModel,
    pub(crate) limits: Limits,
    pub(crate) drive_limits: DriveLimits,
    /// Steady drive of each place; axes (place, actuator).
    pub(crate) patterns: Array2<Complex64>,
    /// K times it; the same axes.
    pub(crate) corrections: Array2<Complex64>,
    /// Velocity of the responses under them; axes (response, place).
    pub(crate) steady: Array2<Complex64>,
    /// Programs that were solved.
    pub(crate) programs: Programs,
    /// Findings on the steady drives.
    pub(crate) findings: Vec<Finding>,
}

impl Voice {
    /// The tone of `scene`, with the steady drives of `places`.
    ///
    /// * `given`: those of the scene's own zones, where they are known
    ///
    /// # Errors
    /// As [`crate::render`].
    pub(crate) fn new(
        model: &ModalModel,
        scene: &Scene,
        places: &[Place],
        given: Option<&Weights>,
        options: &RenderOptions,
    ) -> Result<Self> {
        let mut findings: Vec<Finding> = outside_band(model, scene.frequency_hz)
            .into_iter()
            .collect();
        let model = &*at_tone(model, scene)?;
        let scene = &Scene {
            tone_gains: None,
            ..scene.clone()
        };
        let operator =
            Operator::of_model(model, scene.frequency_hz, scene.actuators.only.as_deref())?;
        let mut patterns = Array2::zeros((places.len(), operator.references.len()));
        let (drive_limits, _) = drive_limits(scene, operator.unit)?;
        let steady = SteadyDrives {
            model,
            scene,
            operator: &operator,
            given,
            options,
        };
        let is_spot = |k: &usize| matches!(places[*k], Place::Spot(_));
        let (spots, others): (Vec<usize>, Vec<usize>) = (0..places.len()).partition(is_spot);
        // from the middle of the way to both of its ends at once
        let middle = spots.len() / 2;
        for &k in others.iter().chain(spots.get(middle)) {
            let drive = steady.alone(&places[k], &mut findings)?;
            patterns.row_mut(k).assign(&drive);
        }
        if let Some((&first, onward)) = spots[middle..].split_first() {
            let start = patterns.row(first).to_owned();
            let along = |spots: Vec<usize>| steady.following(&start, places, spots);
            let back = spots[..middle].iter().rev().copied().collect();
            let (onward, back) = rayon::join(|| along(onward.to_vec()), || along(back));
            for (k, drive) in onward?.into_iter().chain(back?) {
                patterns.row_mut(k).assign(&drive);
            }
        }
        let causal = CausalModel::new(model, &operator)?;
        let corrections = corrected(&correction(&causal)?, &patterns);
        Ok(Self {
            frequency_hz: scene.frequency_hz,
            steady: causal.steady(patterns.view()),
            programs: Programs::default(),
            model: causal,
            limits: scene.limits()?,
            drive_limits,
            operator,
            patterns,
            corrections,
            findings,
        })
    }
}

/// The steady drives of places.
struct SteadyDrives<'a> {
    model: &'a ModalModel,
    scene: &'a Scene,
    operator: &'a Operator,
    given: Option<&'a Weights>,
    options: &'a RenderOptions,
}

impl SteadyDrives<'_> {
    /// The scene with the zones of a place. What time asks for takes the margin that there
    /// is: amplifiers may err as much as the scene says, and no more. A steady tone needs no
    /// margin for time: it is driven as [`render`] drives it.
    fn scene_at(&self, place: &Place) -> Scene {
        let drift = match self.scene.time {
            Some(_) => Some(self.scene.drift.unwrap_or(self.options.drift).as_named()),
            None => self.scene.drift,
        };
        let asked = match place {
            Place::Spot(spot) => Place::Spot(spot.for_passing()),
            other => other.clone(),
        };
        Scene {
            zones: zones_of(&asked, &self.scene.zones),
            time: None,
            drift,
            ..self.scene.clone()
        }
    }

    /// The drive of a place by itself; what cannot be met there goes into `findings`.
    fn alone(&self, place: &Place, findings: &mut Vec<Finding>) -> Result<Drive> {
        let there = self.scene_at(place);
        if let (Place::Scene, Some(weights)) = (place, self.given) {
            check_ground(&there, self.operator)?;
            return Ok(drive_on(self.operator, weights));
        }
        let weights = render(self.model, &there, self.options)?.weights;
        if !weights.feasible {
            findings.extend(weights.findings.iter().cloned());
        }
        Ok(drive_on(self.operator, &weights))
    }

    /// The drives of some of the places, each like the one before, the first one like
    /// `start`.
    fn following(
        &self,
        start: &Drive,
        places: &[Place],
        spots: Vec<usize>,
    ) -> Result<Vec<(usize, Drive)>> {
        let mut drives: Vec<(usize, Drive)> = Vec::with_capacity(spots.len());
        for k in spots {
            let before = drives.last().map_or(start, |(_, drive)| drive);
            let setup = Setup::new(self.model, &self.scene_at(&places[k]), &self.options.drift)?;
            let drive = robust::follow(&setup, before, self.options.effort)?;
            drives.push((k, drive));
        }
        Ok(drives)
    }
}
