//! Places that are judged in time, under all tones at once.

use crate::panel::field::AreaGrid;
use crate::panel::operator::Operator;
use crate::rig::at_tone;
use crate::scene::limits::Limits;
use crate::scene::plane::{Position, Rectangle};
use crate::scene::scene_file::Scene;
use crate::scene::tones::Share;
use crate::scene::zones::{ZoneMap, Zones};
use crate::time::causal::CausalModel;
use crate::time::contact::{Contact, Touch};
use crate::time::judge::{Energies, EnergyLimits, Judge, TimeMeasure, TimeTraces};
use crate::time::plan::Chain;
use crate::time::simulate::{Motion, SampledDrive};
use crate::time::table::Measure;
use crate::time::timeline::Timeline;
use crate::time::tracks::Tracks;
use crate::tolerances;
use chladni_frf::{ModalModel, Result};
use chladni_linalg::matmul;
use ndarray::{Array1, Array2, ArrayView1};
use num_complex::Complex64;
use rayon::prelude::*;

/// The panel at some places, for every tone.
#[derive(Clone)]
pub(crate) struct Listener {
    pub(crate) positions_m: Vec<Position>,
    /// Of each tone.
    pub(crate) models: Vec<CausalModel>,
    /// The limits of each tone.
    pub(crate) limits: Vec<ToneLimits>,
    /// A finger on one of the places.
    pub(crate) touch: Option<Touch>,
}

/// Limits of one tone.
#[derive(Clone, Copy)]
pub(crate) struct ToneLimits {
    pub(crate) limits: Limits,
    share: Share,
    /// d ln T/d ln f of its threshold.
    steepness: f64,
}

impl ToneLimits {
    /// Of a scene with one frequency.
    ///
    /// # Errors
    /// A threshold that is not known there.
    pub(crate) fn of(tone: &Scene) -> Result<Self> {
        let limits = tone.limits()?;
        let at = |factor: f64| {
            let found = tone.threshold.velocity_m_per_s(factor * tone.frequency_hz);
            match found {
                Ok(velocity) => (factor, velocity),
                Err(_) => (1.0, limits.threshold_m_per_s),
            }
        };
        let step = tolerances::THRESHOLD_STEP;
        let (below, above) = (at(1.0 - step), at(1.0 + step));
        let span = (above.0 / below.0).ln();
        Ok(Self {
            limits,
            share: tone.share,
            steepness: if span > 0.0 {
                (above.1 / below.1).ln() / span
            } else {
                0.0
            },
        })
    }

    /// Weighs what lies beside the carrier by its own threshold, v⁺·T(f₀)/T(f), to first
    /// order: v⁺ + j(p/ω₀)·dv⁺/dt; `last` is the sample before.
    fn weigh(
        &self,
        moved: &mut Array2<Complex64>,
        last: &mut Array1<Complex64>,
        carrier_rad_per_s: f64,
        step_s: f64,
    ) {
        if self.steepness == 0.0 {
            return;
        }
        let factor = Complex64::new(0.0, self.steepness / (carrier_rad_per_s * step_s));
        for mut row in moved.rows_mut() {
            let here = row.to_owned();
            row += &((&here - &*last) * factor);
            *last = here;
        }
    }
}

/// The ground that is judged, and the summation time.
pub(crate) struct Judging<'a> {
    pub(crate) zones: &'a Zones,
    /// Of every place.
    pub(crate) maps: &'a [ZoneMap],
    /// The box around the responses.
    pub(crate) scanned: Rectangle,
    pub(crate) summation_s: f64,
}

/// The drive over some samples: of tracks, or of a recording.
pub(crate) trait Sounds {
    /// The envelopes of a block.
    fn block(&self, step_s: f64, first: usize, count: usize) -> SampledDrive;

    /// Time before which it is silent, s.
    fn silent_to_s(&self) -> f64 {
        0.0
    }
}

impl Sounds for Tracks {
    fn block(&self, step_s: f64, first: usize, count: usize) -> SampledDrive {
        self.sampled(step_s, first, count)
    }

    fn silent_to_s(&self) -> f64 {
        let starts_s = self.tracks.iter().map(|track| track.envelope.span_s()[0]);
        starts_s.fold(f64::INFINITY, f64::min)
    }
}

/// Judged by each measure, in their order; hot levels of each group by the measure asked
/// for; largest |a| of each tone, and of all tones together.
pub(crate) struct Heard {
    pub(crate) measures: Vec<TimeMeasure>,
    pub(crate) hot_levels: Vec<Vec<Option<f64>>>,
    pub(crate) peaks: Vec<f64>,
    pub(crate) peak_together: f64,
    /// By the measure at each instant, where it was asked for.
    pub(crate) traces: Option<TimeTraces>,
}

impl Listener {
    /// The responses of a model, for every tone of a scene.
    ///
    /// # Errors
    /// As [`Operator::of_model`]; a threshold that is not known at a tone.
    pub(crate) fn at_responses(model: &ModalModel, scene: &Scene) -> Result<Self> {
        let mut there = Self {
            positions_m: Vec::new(),
            models: Vec::new(),
            limits: Vec::new(),
            touch: None,
        };
        for tone in scene.tones() {
            let only = tone.actuators.only.as_deref();
            let model = &*at_tone(model, &tone)?;
            let operator = Operator::of_model(model, tone.frequency_hz, only)?;
            there.models.push(CausalModel::new(model, &operator)?);
            there.limits.push(ToneLimits::of(&tone)?);
            there.positions_m = operator.positions_m;
        }
        Ok(there)
    }

    /// The same panel on a grid between these places.
    pub(crate) fn over(&self, grid: &AreaGrid) -> Self {
        let there = |model: &CausalModel| model.at(grid.interpolation());
        Self {
            positions_m: grid.places.iter().map(|place| place.1).collect(),
            models: self.models.iter().map(there).collect(),
            limits: self.limits.clone(),
            touch: None,
        }
    }

    /// Judges `chains` when `voices` sound, one per tone.
    pub(crate) fn hear<S: Sounds>(
        &self,
        voices: &[S],
        chains: &[Chain],
        judging: &Judging,
        measures: &[Measure],
    ) -> Heard {
        let step_s = tolerances::JUDGE_STEP_S;
        let end_s = chains.iter().map(Chain::end_s).fold(0.0, f64::max);
        let count = ((end_s + tolerances::JUDGE_TAIL_S) / step_s).ceil() as usize;
        let timeline = Timeline::new(
            chains,
            judging.maps,
            judging.zones,
            judging.scanned,
            &self.positions_m,
            step_s,
            count,
        );
        let limits = EnergyLimits::of(&self.limits[0].limits, &self.limits[0].share);
        let judge = |&measure: &Measure| {
            Judge::new(
                measure,
                judging.summation_s,
                step_s,
                limits,
                &timeline.segments,
                &timeline.grounds,
            )
        };
        let mut judges: Vec<Judge> = measures.iter().map(judge).collect();
        let mut panel = Panel::at_rest(self);
        let mut peaks = Peaks::new(&self.models);
        let still = self.still(voices, chains, count);
        judges.iter_mut().for_each(|judge| judge.pass_over(still));
        let mut largest = Vec::with_capacity(count);
        largest.resize(still, 0.0);
        for first in (still..count).step_by(tolerances::JUDGE_BLOCK) {
            let length = tolerances::JUDGE_BLOCK.min(count - first);
            let drives: Vec<SampledDrive> = voices
                .iter()
                .map(|voice| voice.block(step_s, first, length))
                .collect();
            largest.extend(peaks.take(&drives, first, length));
            let energies = self.energies(&panel.under(&drives, first, step_s));
            match self.positions_m.len() < tolerances::JUDGE_TOGETHER {
                true => judges
                    .iter_mut()
                    .for_each(|judge| judge.feed(first, &energies)),
                false => judges
                    .par_iter_mut()
                    .for_each(|judge| judge.feed(first, &energies)),
            }
        }
        let at_once = measures
            .iter()
            .position(|&measure| measure == Measure::Peak);
        Heard {
            traces: at_once.map(|k| judges[k].traces(largest)),
            measures: judges
                .iter()
                .map(|judge| judge.result(&timeline.starts_s, &timeline.ends))
                .collect(),
            hot_levels: judges.iter().map(Judge::hot_levels).collect(),
            peaks: peaks.of_tones,
            peak_together: peaks.together,
        }
    }

    /// Samples, in whole blocks, during which nothing sounds, nothing is asked of the ground
    /// and so nothing is to be simulated.
    fn still<S: Sounds>(&self, voices: &[S], chains: &[Chain], count: usize) -> usize {
        if self.touch.is_some() {
            return 0;
        }
        let starts_s = chains.iter().map(Chain::start_s);
        let starts_s = starts_s.chain(voices.iter().map(Sounds::silent_to_s));
        let samples = starts_s.fold(f64::INFINITY, f64::min) / tolerances::JUDGE_STEP_S;
        // one sample less: rounding, and the sample at which the drive begins
        let blocks = (samples - 1.0).max(0.0) as usize / tolerances::JUDGE_BLOCK;
        (blocks * tolerances::JUDGE_BLOCK).min(count)
    }

    /// Amplitudes of the places over their thresholds, of all tones together, at every
    /// `every`-th sample; axes (frame, place).
    pub(crate) fn frames<S: Sounds>(
        &self,
        voices: &[S],
        every: usize,
        count: usize,
    ) -> Array2<f64> {
        let step_s = tolerances::JUDGE_STEP_S;
        let mut motions: Vec<Motion> = self.models.iter().map(Motion::new).collect();
        let mut frames = Array2::zeros((count, self.positions_m.len()));
        let samples = every * count;
        for first in (0..samples).step_by(tolerances::JUDGE_BLOCK) {
            let length = tolerances::JUDGE_BLOCK.min(samples - first);
            let moved: Vec<Array2<Complex64>> = motions
                .iter_mut()
                .zip(voices)
                .map(|(motion, voice)| motion.under(&voice.block(step_s, first, length)))
                .collect();
            let energies = self.energies(&moved).cold;
            let begun = first.div_ceil(every);
            for (frame, mut row) in frames.rows_mut().into_iter().enumerate().skip(begun) {
                if every * frame >= first + length {
                    break;
                }
                row.assign(&energies.row(every * frame - first).mapv(f64::sqrt));
            }
        }
        frames
    }

    /// Energies of the velocities of every tone.
    fn energies(&self, moved: &[Array2<Complex64>]) -> Energies {
        let of = |k: usize| {
            let threshold = self.limits[k].limits.threshold_m_per_s;
            moved[k].mapv(|v| v.norm_sqr() / (threshold * threshold))
        };
        let first = of(0);
        let mut energies = Energies {
            hot: &first / self.limits[0].share.hot,
            cold: first,
        };
        for k in 1..moved.len() {
            let tone = of(k);
            let share = self.limits[k].share.hot;
            energies
                .hot
                .zip_mut_with(&tone, |least, &value| *least = least.min(value / share));
            energies.cold += &tone;
        }
        energies
    }
}

/// The panel of a listener while it moves, block after block.
struct Panel<'a> {
    listener: &'a Listener,
    /// Of each tone, as the next two.
    motions: Vec<Motion<'a>>,
    /// None where no finger is there.
    contacts: Vec<Contact<'a>>,
    /// The last sample of the block before.
    last: Vec<Array1<Complex64>>,
}

impl<'a> Panel<'a> {
    fn at_rest(listener: &'a Listener) -> Self {
        let Listener { models, touch, .. } = listener;
        let contact = |touch| models.iter().map(move |model| Contact::new(model, touch));
        Self {
            listener,
            motions: models.iter().map(Motion::new).collect(),
            contacts: touch.iter().flat_map(contact).collect(),
            last: vec![Array1::zeros(listener.positions_m.len()); models.len()],
        }
    }

    /// Velocities under a block of drives that begins at the sample `first`, weighed by
    /// the thresholds beside each carrier.
    fn under(
        &mut self,
        drives: &[SampledDrive],
        first: usize,
        step_s: f64,
    ) -> Vec<Array2<Complex64>> {
        let mut moved: Vec<Array2<Complex64>> = self
            .motions
            .iter_mut()
            .zip(drives)
            .map(|(motion, drive)| motion.under(drive))
            .collect();
        for (contact, moved) in self.contacts.iter_mut().zip(&mut moved) {
            contact.lay_over(moved, first, step_s);
        }
        for (k, moved) in moved.iter_mut().enumerate() {
            let carrier = self.listener.models[k].carrier_rad_per_s;
            self.listener.limits[k].weigh(moved, &mut self.last[k], carrier, step_s);
        }
        moved
    }
}

/// The largest drives so far, N or V.
struct Peaks {
    /// ω₀ of each tone, rad/s.
    carriers_rad_per_s: Vec<f64>,
    of_tones: Vec<f64>,
    /// |Σ a·e^{jω₀t}| over the tones: what the signal of one actuator reaches.
    together: f64,
}

impl Peaks {
    fn new(models: &[CausalModel]) -> Self {
        Self {
            carriers_rad_per_s: models.iter().map(|model| model.carrier_rad_per_s).collect(),
            of_tones: vec![0.0; models.len()],
            together: 0.0,
        }
    }

    /// Takes a block that begins at the sample `first`; returns the amplitudes of all tones
    /// added up at each sample.
    fn take(&mut self, drives: &[SampledDrive], first: usize, length: usize) -> Vec<f64> {
        let mut sums = vec![0.0; length];
        let mut together: Option<Array2<Complex64>> = None;
        for (k, drive) in drives
            .iter()
            .enumerate()
            .filter(|(_, drive)| drive.sounds())
        {
            let mut driven = matmul(drive.values.view(), drive.patterns.view());
            for (sum, size) in sums.iter_mut().zip(largest(&driven)) {
                self.of_tones[k] = f64::max(self.of_tones[k], size);
                *sum += size;
            }
            if drives.len() > 1 {
                let turn_rad = self.carriers_rad_per_s[k] * drive.step_s;
                for (at, mut row) in driven.rows_mut().into_iter().enumerate() {
                    let turn = Complex64::from_polar(1.0, turn_rad * (first + at) as f64);
                    row.mapv_inplace(|value| value * turn);
                }
            }
            together = Some(match together {
                Some(others) => others + driven,
                None => driven,
            });
        }
        let sizes = together.iter().flat_map(largest);
        self.together = sizes.fold(self.together, f64::max);
        sums
    }
}

/// Largest |a_i| of each row.
fn largest(drive: &Array2<Complex64>) -> Vec<f64> {
    let of = |row: ArrayView1<Complex64>| {
        row.iter()
            .map(Complex64::norm_sqr)
            .fold(0.0, f64::max)
            .sqrt()
    };
    drive.rows().into_iter().map(of).collect()
}

impl SampledDrive {
    /// True where any pattern has a value.
    fn sounds(&self) -> bool {
        !self.patterns.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use std::path::Path;

    #[test]
    fn what_lies_beside_the_carrier_is_weighed_by_its_own_threshold() {
        let text = "frequency_hz = 110.0\n[threshold]\nprofile = \"classic\"\n[zones]\ngrid = [2, 2]\nhot = [1]\n";
        let scene = Scene::parse(text, Path::new("")).unwrap();
        let tone = ToneLimits::of(&scene).unwrap();
        let carrier = TAU * 110.0;
        let step_s = 1e-5;
        for beside_hz in [-5.0, 5.0] {
            let turn = |k: usize| Complex64::from_polar(1.0, TAU * beside_hz * step_s * k as f64);
            let mut moved = Array2::from_shape_fn((50, 1), |(k, _)| turn(k + 1));
            let mut last = Array1::from_elem(1, turn(0));
            tone.weigh(&mut moved, &mut last, carrier, step_s);
            let there = scene.threshold.velocity_m_per_s(110.0 + beside_hz).unwrap();
            let expected = tone.limits.threshold_m_per_s / there;
            let found = moved[[49, 0]].norm();
            assert!(
                (found - expected).abs() < 0.1 * (expected - 1.0).abs(),
                "{beside_hz}: {found} {expected}"
            );
        }
        let flat = Scene::parse(&text.replace("classic", "paper"), Path::new("")).unwrap();
        assert_eq!(ToneLimits::of(&flat).unwrap().steepness, 0.0);
    }
}
