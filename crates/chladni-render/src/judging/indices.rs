//! Quality of a field against what was asked: the indices of the seed paper, hot and cold
//! apart, and the score with no drive.
//!
//! Silence meets the cold limit everywhere, so the share of all points inside their limit
//! says little: 0.779 for one cell of four. Hence `silence_ratio` beside `success_ratio`,
//! and `min_ratio`, which only a good field makes large.

use crate::panel::drive::{amplitude, Drive};
use crate::panel::field::{AreaField, Field};
use crate::scene::limits::Limits;
use crate::scene::plane::Position;
use crate::scene::zones::{check_zones, Ground, ZoneMap};
use chladni_frf::{ReferenceUnit, Result};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Indices at the measured responses, and over the area between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Indices {
    /// At the measured responses.
    pub points: PointIndices,
    /// On a grid of at most 5 mm interpolated between them; `None` where they carry no
    /// area.
    pub area: Option<AreaIndices>,
}

/// Indices at the measured responses; ratios are fractions of judged points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PointIndices {
    /// Hot points with |v| at least threshold + limen, over all hot points.
    pub hot_ratio: f64,
    /// Cold points with |v| at most threshold − limen, over all cold points.
    pub cold_ratio: f64,
    /// The smaller of the two.
    pub min_ratio: f64,
    /// Hot and cold points inside their limit, over all judged points.
    pub success_ratio: f64,
    /// The score with no drive: cold points over judged points.
    pub silence_ratio: f64,
    /// 20 log10(least hot |v| / largest cold |v|), dB; `None` where nothing moves.
    pub contrast_db: Option<f64>,
    /// The least distance of a judged point from its limit, dB, negative where one
    /// misses; `None` where a hot point is still.
    pub margin_db: Option<f64>,
    /// Largest |A_i|, N peak; `None` where the references are volts.
    pub max_force_n: Option<f64>,
    /// Largest |A_i|, V peak, where the references are volts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_voltage_v: Option<f64>,
}

/// Indices over the area; fractions of the grid points that are hot or cold, `None` where
/// none is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AreaIndices {
    /// Hot ground that is felt.
    pub hot_ratio: Option<f64>,
    /// Cold ground that is quiet.
    pub cold_ratio: Option<f64>,
}

/// Amplitudes on hot and on cold ground, m/s; those of hot ground over the level of its
/// zone, so that one limit holds for all.
fn amplitudes<'a>(
    zones: &ZoneMap,
    places: impl IntoIterator<Item = Position>,
    ground: impl IntoIterator<Item = &'a Ground>,
    velocity: impl IntoIterator<Item = &'a Complex64>,
) -> [Vec<f64>; 2] {
    let [mut hot, mut cold] = [Vec::new(), Vec::new()];
    for ((place, ground), v) in places.into_iter().zip(ground).zip(velocity) {
        match ground {
            Ground::Hot => hot.push(amplitude(v) / zones.level_at(place)),
            Ground::Cold => cold.push(amplitude(v)),
            Ground::Ignored => {}
        }
    }
    [hot, cold]
}

impl PointIndices {
    /// The indices of a field under the drive that makes it.
    ///
    /// # Errors
    /// No response lies in the hot zone, or none in the cold one.
    pub(crate) fn of_field(
        field: &Field,
        zones: &ZoneMap,
        limits: &Limits,
        drive: &Drive,
        unit: ReferenceUnit,
    ) -> Result<Self> {
        let [hot, cold] = amplitudes(
            zones,
            field.positions_m.iter().copied(),
            &field.ground,
            &field.velocity_m_per_s,
        );
        check_zones(hot.len(), cold.len())?;
        let felt = hot.iter().filter(|&&v| limits.is_felt(v)).count();
        let quiet = cold.iter().filter(|&&v| limits.is_quiet(v)).count();
        let (hot_ratio, cold_ratio) = (
            felt as f64 / hot.len() as f64,
            quiet as f64 / cold.len() as f64,
        );
        let judged = (hot.len() + cold.len()) as f64;
        let least_hot = hot.iter().copied().fold(f64::INFINITY, f64::min);
        let largest_cold = cold.iter().copied().fold(0.0, f64::max);
        let db = |ratio: f64| Some(20.0 * ratio.log10()).filter(|level| level.is_finite());
        let largest = drive.iter().map(|weight| weight.norm()).fold(0.0, f64::max);
        let (max_force_n, max_voltage_v) = match unit {
            ReferenceUnit::Newton => (Some(largest), None),
            ReferenceUnit::Volt => (None, Some(largest)),
        };
        Ok(Self {
            hot_ratio,
            cold_ratio,
            min_ratio: hot_ratio.min(cold_ratio),
            success_ratio: (felt + quiet) as f64 / judged,
            silence_ratio: cold.len() as f64 / judged,
            contrast_db: db(least_hot / largest_cold),
            margin_db: db((least_hot / limits.hot_m_per_s).min(limits.cold_m_per_s / largest_cold)),
            max_force_n,
            max_voltage_v,
        })
    }
}

impl AreaIndices {
    /// The indices of an interpolated field.
    pub(crate) fn of_area(area: &AreaField, zones: &ZoneMap, limits: &Limits) -> Self {
        let rows = area.y_m.iter();
        let places = rows.flat_map(|&y| area.x_m.iter().map(move |&x| [x, y]));
        let [hot, cold] = amplitudes(zones, places, &area.ground, &area.velocity_m_per_s);
        let ratio = |all: &[f64], inside: &dyn Fn(f64) -> bool| {
            (!all.is_empty())
                .then(|| all.iter().filter(|&&v| inside(v)).count() as f64 / all.len() as f64)
        };
        Self {
            hot_ratio: ratio(&hot, &|v| limits.is_felt(v)),
            cold_ratio: ratio(&cold, &|v| limits.is_quiet(v)),
        }
    }
}
