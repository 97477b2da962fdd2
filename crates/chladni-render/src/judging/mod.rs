//! Judgement of a drive: drive and field enter; numbers and warnings leave.
//!
//! `indices` (the field against what was asked) → `ceiling` (the most that any drive could
//! do) → `second_search` (a better drive, where the first misses limits) → `shortcomings` (what
//! must be said). `endurance` draws rigs by `rig_draw`,
//! `frequency_sweep` tries other drive frequencies.

pub(crate) mod ceiling;
pub(crate) mod endurance;
pub(crate) mod frequency_sweep;
pub(crate) mod indices;
pub(crate) mod rig_draw;
pub(crate) mod second_search;
pub(crate) mod shortcomings;
