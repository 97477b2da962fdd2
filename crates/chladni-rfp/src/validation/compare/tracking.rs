//! One mode through many models: over temperature, damage or production.

use super::{compare, CompareOptions, Comparison};
use chladni_frf::{Result, ShapeSet};

/// The model that each model is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TrackAgainst {
    /// The first one: copies of one structure, damage against a sound state.
    #[default]
    First,
    /// The one before it: a structure that changes step by step.
    Previous,
}

/// The places of one mode.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ModeTrack {
    /// Its number in each model, from 1; `None` where it was not found.
    pub modes: Vec<Option<usize>>,
}

/// Many sets of modes side by side.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Tracking {
    /// One comparison for each set but the first; its `a` is the first or the one before.
    pub comparisons: Vec<Comparison>,
    /// Every mode of every set once: first those of the first set, then what came later.
    pub tracks: Vec<ModeTrack>,
}

/// Compares every set with the first or the one before it, and follows each mode.
///
/// # Errors
/// As [`compare`].
pub fn track(
    sets: &[ShapeSet],
    against: TrackAgainst,
    options: &CompareOptions,
) -> Result<Tracking> {
    let base = |k: usize| match against {
        TrackAgainst::First => 0,
        TrackAgainst::Previous => k - 1,
    };
    let comparisons: Vec<Comparison> = (1..sets.len())
        .map(|k| compare(&sets[base(k)], &sets[k], options))
        .collect::<Result<_>>()?;
    let mut tracks: Vec<ModeTrack> = Vec::new();
    for (k, set) in sets.iter().enumerate() {
        for number in 1..=set.modes.len() {
            let partner = k.checked_sub(1).and_then(|before| {
                let pair = comparisons[before].pairs.iter().find(|p| p.b == number)?;
                (tracks.iter()).position(|track| track.modes[base(k)] == Some(pair.a))
            });
            let at = partner.unwrap_or_else(|| {
                tracks.push(ModeTrack {
                    modes: vec![None; sets.len()],
                });
                tracks.len() - 1
            });
            tracks[at].modes[k] = Some(number);
        }
    }
    Ok(Tracking {
        comparisons,
        tracks,
    })
}
