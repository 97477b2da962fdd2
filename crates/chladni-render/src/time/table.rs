//! The `[time]` of a scene: what is to be felt when.

use crate::scene::plane::Position;

/// The measure of ground that does not move steadily.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Measure {
    /// By the energy that touch adds up over [`TimeTable::summation_s`], the older the
    /// less.
    Summed,
    /// By the amplitude at each instant.
    Peak,
    /// By the root mean square over a window of [`TimeTable::summation_s`] that slides.
    Rms,
}

impl Measure {
    /// All measures, the default first.
    pub const ALL: [Self; 3] = [Self::Summed, Self::Peak, Self::Rms];

    /// Name as in scenes and results.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Summed => "summed",
            Self::Peak => "peak",
            Self::Rms => "rms",
        }
    }
}

/// The strength of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Level {
    /// As the steady drive.
    Steady,
    /// So strong that hot ground reaches its limit within the event, by the measure.
    Compensated,
}

impl Level {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::Steady, Self::Compensated];

    /// Name as in scenes and results.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Steady => "steady",
            Self::Compensated => "compensated",
        }
    }
}

/// The passage of the drive from one pattern to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Ramps {
    /// Every actuator by the same raised cosine.
    Plain,
    /// The same, and what makes every mode follow it without lag.
    Modal,
    /// A program over the envelopes of all actuators, for ramps below 10 ms.
    Program,
}

impl Ramps {
    /// All ways, the default first.
    pub const ALL: [Self; 3] = [Self::Modal, Self::Plain, Self::Program];

    /// Name as in scenes and results.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Modal => "modal",
            Self::Program => "program",
        }
    }
}

/// Duration of a ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RampTime {
    /// The least whole millisecond that keeps every limit.
    Auto,
    /// So long, s.
    Seconds(f64),
}

/// One place, for a while, perhaps again and again.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// Its beginning, s.
    pub start_s: f64,
    /// With both ramps, s.
    pub duration_s: f64,
    /// Of its rise and of its fall.
    pub ramp: RampTime,
    /// Line of `ramp_s` in the scene file; that of the event where it has none.
    pub ramp_line: u64,
    /// Number of bursts.
    pub count: usize,
    /// From one beginning to the next, s.
    pub period_s: f64,
    /// Hot cells; `None`: those of the scene.
    pub hot: Option<Vec<usize>>,
    /// Line in the scene file.
    pub line: u64,
}

/// From some cells to others while both sound.
#[derive(Debug, Clone, PartialEq)]
pub struct Fade {
    /// Hot cells before.
    pub from: Vec<usize>,
    /// Hot cells after.
    pub to: Vec<usize>,
    /// Its beginning, s.
    pub start_s: f64,
    /// Its duration, s.
    pub fade_s: f64,
    /// Rise before and fall after it, where no burst sounds then.
    pub ramp: RampTime,
    /// Line of `ramp_s` in the scene file; that of the event where it has none.
    pub ramp_line: u64,
    /// Line in the scene file.
    pub line: u64,
}

/// A spot that runs along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// Time at which the spot begins to rise, s.
    pub start_s: f64,
    /// Corners of its path, m.
    pub path_m: Vec<Position>,
    /// m/s.
    pub speed_m_per_s: f64,
    /// Ground within this distance of its middle is hot, m.
    pub hot_radius_m: f64,
    /// Ground beyond this distance is cold, m.
    pub quiet_from_m: f64,
    /// Rise at the path's beginning, and fall at its end.
    pub ramp: RampTime,
    /// Line of `ramp_s` in the scene file; that of the event where it has none.
    pub ramp_line: u64,
    /// Line in the scene file.
    pub line: u64,
}

impl Move {
    /// Length of the path, m.
    pub fn length_m(&self) -> f64 {
        self.path_m
            .windows(2)
            .map(|pair| apart(pair[0], pair[1]))
            .sum()
    }

    /// From the beginning of the path to its end, s.
    pub fn travel_s(&self) -> f64 {
        self.length_m() / self.speed_m_per_s
    }

    /// The place so far along the path, m.
    pub fn place(&self, along_m: f64) -> Position {
        let mut left = along_m.max(0.0);
        for pair in self.path_m.windows(2) {
            let length = apart(pair[0], pair[1]);
            if left <= length && length > 0.0 {
                return [0, 1]
                    .map(|axis| pair[0][axis] + (pair[1][axis] - pair[0][axis]) * left / length);
            }
            left -= length;
        }
        self.path_m.last().copied().unwrap_or_default()
    }
}

pub(crate) fn apart(a: Position, b: Position) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The `[time]` of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeTable {
    /// By which the scene counts as met.
    pub measure: Measure,
    /// τ of [`Measure::Summed`], window of [`Measure::Rms`], s.
    pub summation_s: f64,
    /// The strength of events.
    pub level: Level,
    /// The ramps by which the drive comes and goes.
    pub ramps: Ramps,
    /// In the order of the file.
    pub bursts: Vec<Burst>,
    /// The same.
    pub fades: Vec<Fade>,
    /// The same.
    pub moves: Vec<Move>,
}

/// Time over which touch adds up energy, s, where the scene gives none: the constant of
/// Zwislocki's theory, by which Pacinian thresholds against duration run (Gescheider et
/// al., J. Acoust. Soc. Am. 95, 1994).
pub const DEFAULT_SUMMATION_S: f64 = 0.2;

impl Default for TimeTable {
    /// Two seconds of the scene's own zones with ramps of 50 ms.
    fn default() -> Self {
        Self {
            measure: Measure::Summed,
            summation_s: DEFAULT_SUMMATION_S,
            level: Level::Steady,
            ramps: Ramps::Modal,
            bursts: vec![Burst {
                start_s: 0.0,
                duration_s: 2.0,
                ramp: RampTime::Seconds(0.05),
                ramp_line: 0,
                count: 1,
                period_s: 2.0,
                hot: None,
                line: 0,
            }],
            fades: Vec::new(),
            moves: Vec::new(),
        }
    }
}
