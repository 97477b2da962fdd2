//! Faults of a rig, drawn from a seed.

use crate::wild::random::Random;
use chladni_render::Finger;
use num_complex::Complex64;

/// Stream of the faults of a seed.
const STREAM: u64 = 40;
/// Chance of each fault in a mixed rig.
const CHANCE: f64 = 0.3;
/// Amplifiers of mixed rigs: largest relative error, and phase per relative error, °.
const MOST_SCATTER: f64 = 0.05;
const DEGREES_PER_SCATTER: f64 = 100.0;
/// Standard deviation of the common shift of natural frequencies (0.1 % is about 15 K in
/// glass), and of each mode's own.
const COMMON_SHIFT: f64 = 1e-3;
const OWN_SHIFT: f64 = 3e-4;
/// Masses left on the panel, kg.
const MASS_KG: [f64; 2] = [1e-4, 1e-3];
/// The scanner misses its points by so much (standard deviation along each axis), m.
const POINT_ERROR_M: f64 = 1e-3;
/// Noise of the scanner over the rms of a field.
const FIELD_NOISE: [f64; 2] = [0.005, 0.02];
/// Noise where one fault alone is looked at, as in the study.
const PLAIN_NOISE: f64 = 0.01;

/// Kind of rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RigError {
    /// Any of the others together, drawn.
    Mixed,
    /// Amplifiers of 2 % and 2°.
    Scattered2,
    /// Amplifiers of 5 % and 5°.
    Scattered5,
    /// One of the strongest channels is dead.
    Dead,
    /// One of them is reversed.
    Reversed,
    /// A mass of 0.5 g.
    Mass,
    /// A finger that stays.
    Finger,
    /// Two fingers that stay.
    Fingers,
    /// Natural frequencies drift, all together and each.
    Drift,
}

impl RigError {
    /// All, the default first.
    pub const ALL: [Self; 9] = [
        Self::Mixed,
        Self::Scattered2,
        Self::Scattered5,
        Self::Dead,
        Self::Reversed,
        Self::Mass,
        Self::Finger,
        Self::Fingers,
        Self::Drift,
    ];

    /// Name on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mixed => "mixed",
            Self::Scattered2 => "scattered-2",
            Self::Scattered5 => "scattered-5",
            Self::Dead => "dead",
            Self::Reversed => "reversed",
            Self::Mass => "mass",
            Self::Finger => "finger",
            Self::Fingers => "two-fingers",
            Self::Drift => "drift",
        }
    }

    /// The kind of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A load at a place given as shares of the judged rectangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Load {
    pub(super) what: Finger,
    pub(super) place: [f64; 2],
}

/// Faults of one rig.
#[derive(Debug, Clone)]
pub(super) struct Faults {
    /// Complex gain of each channel.
    pub(super) gains: Vec<Complex64>,
    /// Relative shift of all natural frequencies, and the deviation of each one's own.
    pub(super) shift: f64,
    pub(super) own_shift: f64,
    pub(super) loads: Vec<Load>,
    /// Deviation of the scanner's points, m.
    pub(super) point_error_m: f64,
    /// Noise of the scanner over the rms of the field.
    pub(super) noise: f64,
    /// For what is drawn later.
    pub(super) random: Random,
}

impl Faults {
    /// Draws the faults of `seed`; `order` lists the channels, the strongest first.
    pub(super) fn draw(kind: RigError, seed: u64, order: &[usize]) -> Self {
        let mut faults = Self {
            gains: vec![Complex64::ONE; order.len()],
            shift: 0.0,
            own_shift: 0.0,
            loads: Vec::new(),
            point_error_m: 0.0,
            noise: PLAIN_NOISE,
            random: Random::new(seed, STREAM),
        };
        match kind {
            RigError::Mixed => faults.mix(order),
            RigError::Scattered2 => faults.scatter(0.02),
            RigError::Scattered5 => faults.scatter(0.05),
            RigError::Dead => faults.channel(order, 0.0),
            RigError::Reversed => faults.channel(order, -1.0),
            RigError::Mass => faults.load(Finger::of_mass(5e-4)),
            RigError::Finger => faults.load(Finger::default()),
            RigError::Fingers => (0..2).for_each(|_| faults.load(Finger::default())),
            RigError::Drift => faults.drift(),
        }
        faults
    }

    /// Scattered gains, and each other fault with a chance of its own.
    fn mix(&mut self, order: &[usize]) {
        self.point_error_m = POINT_ERROR_M;
        self.noise = self.random.spread(FIELD_NOISE);
        let amplitude = self.random.even([0.0, MOST_SCATTER]);
        self.scatter(amplitude);
        self.drift();
        if self.random.chance(CHANCE) {
            self.channel(order, 0.0);
        }
        if self.random.chance(CHANCE) {
            self.channel(order, -1.0);
        }
        if self.random.chance(CHANCE) {
            let mass_kg = self.random.spread(MASS_KG);
            self.load(Finger::of_mass(mass_kg));
        }
        if self.random.chance(CHANCE) {
            self.load(Finger::default());
        }
    }

    fn scatter(&mut self, amplitude: f64) {
        let phase = (DEGREES_PER_SCATTER * amplitude).to_radians();
        for gain in &mut self.gains {
            let size = 1.0 + amplitude * self.random.normal();
            *gain *= Complex64::from_polar(size, phase * self.random.normal());
        }
    }

    /// One of the stronger half of the channels.
    fn channel(&mut self, order: &[usize], gain: f64) {
        let channel = self.random.one_of(&order[..order.len().div_ceil(2)]);
        self.gains[channel] *= gain;
    }

    fn load(&mut self, what: Finger) {
        let place = [(); 2].map(|()| self.random.even([0.05, 0.95]));
        self.loads.push(Load { what, place });
    }

    fn drift(&mut self) {
        self.shift = COMMON_SHIFT * self.random.normal();
        self.own_shift = OWN_SHIFT;
    }
}
