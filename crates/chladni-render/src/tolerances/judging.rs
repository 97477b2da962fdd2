//! Constants of the judgement of drives: meaning, unit, origin.

/// Level above the threshold from which strength is warned about, dB: at 300 Hz some 8 dB
/// below the hand-arm action value of directive 2002/44/EC (2.5 m/s² weighted by ISO
/// 5349-1, which is 25 mm/s rms there).
pub const STRONG_DB: f64 = 35.0;

/// Below this distance from the certified ceiling, dB, nobody looks for a drive with
/// still more contrast.
pub const CEILING_REACHED_DB: f64 = 0.1;

/// Largest distance of the certified ceiling to what was found, dB, where method `best`
/// tells cases apart. Half of it takes three times the cases.
pub const CEILING_CASES_DB: f64 = 0.19;

/// A ceiling that lies below what is asked by more than this, dB, is not lowered further by cases:
/// they take seconds per tone, lowered those of two opposite quarters by 0.3 to 0.6 dB, and change
/// no verdict.
pub const CEILING_FAR_DB: f64 = 6.0;

/// Factor by which a drive may grow, below which it is called as strong as it may be.
pub const AT_DRIVE_LIMIT: f64 = 1.02;

/// Distance of the frequencies of a sweep, Hz: a fifth to a half of the bandwidth of a
/// glass panel's modes there.
pub const SWEEP_STEP_HZ: f64 = 2.0;

/// Most steps of a sweep.
pub const MOST_SWEPT: f64 = 500.0;

/// Bandwidths of a mode within which it lies near the drive: a finger may move it across.
pub const NEAR_BANDWIDTHS: f64 = 2.0;

/// Shares of responses nearer than this are equal to the frequency chooser: less than one
/// response in a hundred.
pub const SAME_SUCCESS: f64 = 0.005;

/// Rigs that are simulated for one drive: the share that survives is then sure to 1.5 %
/// where it is 0.95.
pub const ENDURANCE_RIGS: usize = 200;

/// Rigs that are simulated at a time: their matrices stay in the cache.
pub const RIGS_AT_ONCE: usize = 40;

/// Seed of these rigs: the same for every drive.
pub const ENDURANCE_SEED: u64 = 0;

/// Rms error of each natural frequency there, relative: a few kelvin.
pub const ENDURANCE_FREQUENCY_ERROR: f64 = 1e-3;

/// Distance from the drive, Hz, within which another frequency is looked for where fingers
/// are not tolerated, and the step of that.
pub const TOUCH_SEARCH_HZ: [f64; 2] = [40.0, 10.0];

/// Frequencies of these that are tried by a program.
pub const TOUCH_TRIED: usize = 3;
