//! The properties that a seed draws: everything but the random numbers of shapes and
//! noise.

use super::random::Random;
use chladni_frf::{Damping, FrfKind};

/// The stream of properties; shapes and noise have their own.
const STREAM: u64 = 1;
/// Most values of a set: above, responses are left out.
const MOST_VALUES: usize = 1_500_000;

/// Range of the draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difficulty {
    /// Properties that an unspoilt measurement of any linear structure may have.
    Calm,
    /// Everything that may be wrong or too much, several at a time.
    Hard,
}

impl Difficulty {
    /// As file names have it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Calm => "calm",
            Self::Hard => "hard",
        }
    }
}

/// The structure and its measurement, as drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// The seed that it was drawn from.
    pub seed: u64,
    /// Range of the draws.
    pub difficulty: Difficulty,
    /// Damping law.
    pub law: Damping,
    /// Kind of the FRFs.
    pub kind: FrfKind,
    /// Modes of the band.
    pub modes: usize,
    /// Modes below the band and above it.
    pub outside: [usize; 2],
    /// Modal constants of the nearest modes outside over the usual.
    pub outside_weight: f64,
    /// Distance of the nearest modes outside from the band's ends, in mean spacings.
    pub outside_distance: f64,
    /// Number of references.
    pub references: usize,
    /// Number of responses.
    pub responses: usize,
    /// The references are responses too.
    pub driving_points: bool,
    /// Mean half-power bandwidth over mean spacing of the modes.
    pub overlap: f64,
    /// Least spacing of neighbours, in half-power bandwidths; 0: repeated modes.
    pub least_spacing: f64,
    /// Lines per half-power bandwidth at the middle of the band.
    pub lines_per_bandwidth: f64,
    /// Median loss factor.
    pub loss_factor: f64,
    /// Loss factors lie within this factor of the median.
    pub loss_spread: f64,
    /// Imaginary over real part of the shapes, rms.
    pub complexity: f64,
    /// Modal constants lie within this factor of each other.
    pub uneven_modes: f64,
    /// Noise below the mean square of the data, dB.
    pub snr_db: f64,
    /// Standard deviation of ln σ over FRFs.
    pub uneven_noise: f64,
    /// Values in single precision.
    pub single: bool,
    /// The line spacing grows over the band by this factor.
    pub uneven_axis: f64,
    /// Middle of the band, Hz.
    pub middle_hz: f64,
    /// Rigid-body motion below the band.
    pub rigid_body: bool,
    /// Phase at the upper end that a delay of all FRFs makes, degrees.
    pub delay_deg: f64,
    /// Phase of all FRFs, degrees.
    pub phase_deg: f64,
    /// Values replaced by what a drop-out leaves.
    pub spoilt_values: usize,
    /// A moved sensor's mass shifts natural frequencies by so many half-bandwidths, rms.
    pub roving_mass: f64,
    /// Tones at the multiples of 50 or 60 Hz, over the noise of a value; 0: none.
    pub tones: f64,
    /// 50 or 60.
    pub mains_hz: f64,
}

impl Draw {
    /// The properties of a seed; the same every time.
    pub fn new(seed: u64, difficulty: Difficulty) -> Self {
        let mut random = Random::new(seed, STREAM);
        match difficulty {
            Difficulty::Calm => Self::calm(seed, &mut random),
            Difficulty::Hard => Self::hard(seed, &mut random),
        }
    }

    /// The common part of both.
    fn calm(seed: u64, random: &mut Random) -> Self {
        let modes = random.count([3, 24]);
        let lines_per_bandwidth = random.spread([3.0, 12.0]);
        let references = random.one_of(&[1, 1, 2, 3, 4, 5]);
        let draw = Self {
            seed,
            difficulty: Difficulty::Calm,
            law: random.one_of(&[Damping::Structural, Damping::Viscous]),
            kind: random.one_of(&[FrfKind::Mobility, FrfKind::Receptance, FrfKind::Accelerance]),
            modes,
            outside: [random.one_of(&[0, 1, 2, 3]), random.count([1, 12])],
            outside_weight: random.spread([0.5, 2.0]),
            outside_distance: random.even([0.5, 2.0]),
            references,
            responses: random.count([4, 60]).max(references),
            driving_points: random.chance(0.5),
            overlap: overlap(random, modes, lines_per_bandwidth, [0.02, 0.4], 2500.0),
            least_spacing: random.even([1.5, 4.0]),
            lines_per_bandwidth,
            loss_factor: random.spread([0.002, 0.04]),
            loss_spread: random.one_of(&[1.0, 1.5, 2.0]),
            complexity: random.one_of(&[0.0, 0.0, 0.0, 0.05, 0.3]),
            uneven_modes: random.even([1.0, 3.0]),
            snr_db: random.even([30.0, 80.0]),
            uneven_noise: random.one_of(&[0.0, 0.0, 0.5]),
            single: random.chance(0.3),
            uneven_axis: random.one_of(&[1.0, 1.0, 1.0, 3.0]),
            middle_hz: random.spread([20.0, 5000.0]),
            rigid_body: random.chance(0.3),
            delay_deg: 0.0,
            phase_deg: 0.0,
            spoilt_values: 0,
            roving_mass: 0.0,
            tones: 0.0,
            mains_hz: 50.0,
        };
        draw.within_size()
    }

    /// Wider ranges, and one or two faults of the measurement.
    fn hard(seed: u64, random: &mut Random) -> Self {
        let calm = Self::calm(seed, random);
        let modes = random.count([3, 40]);
        let lines_per_bandwidth = random.spread([0.5, 20.0]);
        let references = random.one_of(&[1, 2, 3, 4, 5]);
        let mut draw = Self {
            difficulty: Difficulty::Hard,
            modes,
            outside: [random.one_of(&[0, 1, 2, 4]), random.count([1, 20])],
            outside_weight: random.spread([0.5, 10.0]),
            outside_distance: random.even([0.02, 1.0]),
            references,
            responses: random.count([4, 3000]).max(references),
            overlap: overlap(random, modes, lines_per_bandwidth, [0.01, 2.0], 4000.0),
            least_spacing: random.one_of(&[0.0, 0.1, 0.3, 1.0]),
            lines_per_bandwidth,
            loss_factor: random.spread([0.0005, 0.1]),
            loss_spread: random.even([1.0, 4.0]),
            uneven_modes: random.spread([1.0, 30.0]),
            snr_db: random.even([20.0, 90.0]),
            uneven_noise: random.one_of(&[0.0, 0.5, 1.0]),
            single: random.chance(0.5),
            ..calm
        };
        for _ in 0..random.one_of(&[0, 0, 1, 2]) {
            match random.count([1, 6]) {
                1 => draw.delay_deg = random.spread([0.3, 10.0]),
                2 => draw.phase_deg = random.spread([0.3, 5.0]),
                3 => draw.spoilt_values = random.count([1, 20]),
                4 => draw.roving_mass = random.spread([0.01, 2.0]),
                5 => (draw.tones, draw.mains_hz) = (random.spread([3.0, 300.0]), 50.0),
                _ => (draw.tones, draw.mains_hz) = (random.spread([3.0, 300.0]), 60.0),
            }
        }
        draw.within_size()
    }

    /// As many responses as a set of bearable size has.
    fn within_size(self) -> Self {
        let of_one = (self.lines() * self.references).max(1);
        let most = (MOST_VALUES / of_one).max(self.references).max(4);
        Self {
            responses: self.responses.min(most),
            ..self
        }
    }

    /// Mean half-power bandwidth, Hz.
    pub fn bandwidth_hz(&self) -> f64 {
        self.loss_factor * self.middle_hz
    }

    /// Mean spacing of the modes, Hz: as far as the band leaves room above 0 Hz.
    pub fn spacing_hz(&self) -> f64 {
        let wished = self.bandwidth_hz() / self.overlap;
        wished.min(WIDEST * self.middle_hz / (self.modes + 1) as f64)
    }

    /// Lines of the band, about.
    pub fn lines(&self) -> usize {
        let width = self.spacing_hz() * (self.modes + 1) as f64;
        (width / self.bandwidth_hz() * self.lines_per_bandwidth).ceil() as usize
    }

    /// Values of the set, about.
    pub fn values(&self) -> usize {
        self.lines() * self.responses * self.references
    }

    /// True where noise alone stands between data and model, so that bars can be held
    /// against errors.
    #[cfg(test)]
    fn unspoilt(&self) -> bool {
        let faults = [self.delay_deg, self.phase_deg, self.roving_mass, self.tones];
        self.spoilt_values == 0 && faults.iter().all(|fault| *fault == 0.0)
    }
}

/// Width of the widest band over its middle frequency.
const WIDEST: f64 = 1.6;
/// Least lines of a set.
const LEAST_LINES: f64 = 100.0;

/// A modal overlap that leads to no fewer lines than a fit needs and no more than `most`.
fn overlap(
    random: &mut Random,
    modes: usize,
    lines_per_bandwidth: f64,
    [low, high]: [f64; 2],
    most: f64,
) -> f64 {
    let all = (modes + 1) as f64 * lines_per_bandwidth;
    let (least, largest) = ((all / most).max(low), (all / LEAST_LINES).min(high));
    random.spread([least.min(largest), largest.max(least)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_draws_the_same_structure_and_seeds_draw_different_ones() {
        let draws: Vec<Draw> = (0..200)
            .map(|seed| Draw::new(seed, Difficulty::Hard))
            .collect();
        assert_eq!(draws[7], Draw::new(7, Difficulty::Hard));
        let viscous = draws
            .iter()
            .filter(|draw| draw.law == Damping::Viscous)
            .count();
        assert!((70..130).contains(&viscous), "{viscous}");
        assert!(draws.iter().any(|draw| draw.unspoilt()) && draws.iter().any(|d| d.tones > 0.0));
        assert!(draws
            .windows(2)
            .all(|pair| pair[0].middle_hz != pair[1].middle_hz));
    }

    #[test]
    fn calm_draws_are_unspoilt_and_of_bearable_size() {
        for seed in 0..300 {
            let draw = Draw::new(seed, Difficulty::Calm);
            assert!(
                draw.unspoilt() && draw.responses >= draw.references,
                "{draw:?}"
            );
            assert!((60..=4000).contains(&draw.lines()), "{draw:?}");
            assert!(draw.values() <= MOST_VALUES, "{draw:?}");
        }
    }
}
