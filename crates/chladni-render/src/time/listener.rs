//! Places that are judged in time, under all tones at once.

use crate::plane::Position;
use crate::plane::Rectangle;
use crate::scene::Limits;
use crate::time::causal::CausalModel;
use crate::time::judge::{Energies, EnergyLimits, Judge, TimeMeasure, TimeTraces};
use crate::time::plan::Chain;
use crate::time::simulate::{Motion, SampledDrive};
use crate::time::table::Measure;
use crate::time::timeline::Timeline;
use crate::time::tracks::Tracks;
use crate::tolerances;
use crate::tones::Share;
use crate::zones::{ZoneMap, Zones};
use chladni_linalg::matmul;
use ndarray::Array2;
use num_complex::Complex64;

/// The panel at some places, for every tone.
pub(crate) struct Listener {
    pub(crate) positions_m: Vec<Position>,
    /// Of each tone.
    pub(crate) models: Vec<CausalModel>,
    /// Threshold and limits of each tone, and its share.
    pub(crate) limits: Vec<(Limits, Share)>,
}

/// Where and by what is judged.
pub(crate) struct Judging<'a> {
    pub(crate) zones: &'a Zones,
    /// Of every place.
    pub(crate) maps: &'a [ZoneMap],
    /// The box around the responses.
    pub(crate) scanned: Rectangle,
    pub(crate) summation_s: f64,
}

/// What a drive is over some samples: of tracks, or of a recording.
pub(crate) trait Sounds {
    /// The envelopes of a block.
    fn block(&self, step_s: f64, first: usize, count: usize) -> SampledDrive;
}

impl Sounds for Tracks {
    fn block(&self, step_s: f64, first: usize, count: usize) -> SampledDrive {
        self.sampled(step_s, first, count)
    }
}

/// Judged by each measure, in their order; hot levels of each group by the measure asked
/// for; largest |a| of each tone.
pub(crate) struct Heard {
    pub(crate) measures: Vec<TimeMeasure>,
    pub(crate) hot_levels: Vec<Vec<Option<f64>>>,
    pub(crate) peaks: Vec<f64>,
    /// By the measure at each instant, where it was asked for.
    pub(crate) traces: Option<TimeTraces>,
}

impl Listener {
    /// How `chains` do when `voices` sound, one per tone.
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
        let limits = EnergyLimits::of(&self.limits[0].0, &self.limits[0].1);
        let mut judges: Vec<Judge> = measures
            .iter()
            .map(|&measure| {
                Judge::new(
                    measure,
                    judging.summation_s,
                    step_s,
                    limits,
                    &timeline.segments,
                    &timeline.grounds,
                )
            })
            .collect();
        let mut motions: Vec<Motion> = self.models.iter().map(Motion::new).collect();
        let mut peaks = vec![0.0; voices.len()];
        let mut largest = Vec::with_capacity(count);
        for first in (0..count).step_by(tolerances::JUDGE_BLOCK) {
            let length = tolerances::JUDGE_BLOCK.min(count - first);
            let drives: Vec<SampledDrive> = voices
                .iter()
                .map(|voice| voice.block(step_s, first, length))
                .collect();
            let mut sums = vec![0.0; length];
            for (peak, drive) in peaks.iter_mut().zip(&drives) {
                for (sum, size) in sums.iter_mut().zip(drive.amplitudes()) {
                    *peak = f64::max(*peak, size);
                    *sum += size;
                }
            }
            largest.extend(sums);
            let moved: Vec<Array2<Complex64>> = motions
                .iter_mut()
                .zip(&drives)
                .map(|(motion, drive)| motion.under(drive))
                .collect();
            let energies = self.energies(&moved);
            for judge in &mut judges {
                judge.feed(first, &energies);
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
            peaks,
        }
    }

    /// Energies of the velocities of every tone.
    fn energies(&self, moved: &[Array2<Complex64>]) -> Energies {
        let of = |k: usize| {
            let threshold = self.limits[k].0.threshold_m_per_s;
            moved[k].mapv(|v| v.norm_sqr() / (threshold * threshold))
        };
        let first = of(0);
        let mut energies = Energies {
            hot: &first / self.limits[0].1.hot,
            cold: first,
        };
        for k in 1..moved.len() {
            let tone = of(k);
            let share = self.limits[k].1.hot;
            energies
                .hot
                .zip_mut_with(&tone, |least, &value| *least = least.min(value / share));
            energies.cold += &tone;
        }
        energies
    }
}

impl SampledDrive {
    /// Largest |a_i| at each sample, N or V.
    fn amplitudes(&self) -> Vec<f64> {
        if self.patterns.is_empty() {
            return vec![0.0; self.values.nrows()];
        }
        let drive = matmul(self.values.view(), self.patterns.view());
        let largest = |row: ndarray::ArrayView1<Complex64>| {
            row.iter()
                .map(Complex64::norm_sqr)
                .fold(0.0, f64::max)
                .sqrt()
        };
        drive.rows().into_iter().map(largest).collect()
    }
}
