//! Warnings about a drive: what it does not serve, and what is too strong.

use crate::judging::ceiling::Ceiling;
use crate::judging::indices::{AreaIndices, PointIndices};
use crate::methods::method::Method;
use crate::panel::field::Field;
use crate::scene::limits::Limits;
use crate::tolerances;
use chladni_frf::{Finding, Severity};

/// A drive replayed through other data than those that it was found in.
#[derive(Clone, Copy)]
pub(crate) struct Replay {
    /// True on the measured line, false through the whole model.
    pub(crate) is_measured: bool,
    /// Part of the responses that it serves there.
    pub(crate) success_ratio: f64,
}

impl Replay {
    /// True where the whole model does not keep what fewer modes promise.
    pub(crate) fn refutes(self, points: &PointIndices) -> bool {
        !self.is_measured && self.success_ratio < points.success_ratio
    }
}

/// Tells that a drive serves fewer responses in its replay than in the model that it was found
/// in. A fault where the scene is met in that model, and not in the whole one.
///
/// * `[modes, all]`: number of the modes that this model sums, and that it could sum
pub(crate) fn replayed_worse(
    replay: Replay,
    points: &PointIndices,
    [modes, all]: [usize; 2],
) -> Option<Finding> {
    (replay.success_ratio < points.success_ratio).then(|| {
        let through = match replay.is_measured {
            true => "measured line",
            false => "whole model",
        };
        let words = format!(
            "replayed through the {through}, {:.1} % of the responses keep their limit, where \
             {:.1} % do in the model with {modes} modes",
            100.0 * replay.success_ratio,
            100.0 * points.success_ratio,
        );
        let severity = match replay.refutes(points) && points.success_ratio == 1.0 {
            true => Severity::Fault,
            false => Severity::Caution,
        };
        Finding::new(severity, "replayed-worse", words)
            .value("replayed_ratio", replay.success_ratio)
            .help(match modes < all {
                true => "sum more modes (`modes`)",
                false => "all modes are summed: measure the field and correct the drive",
            })
    })
}

/// The outcome of a scene that is not met, beside what is possible: enough to advise on it.
pub(crate) struct Shortfall<'a> {
    pub points: &'a PointIndices,
    pub ceiling: Option<&'a Ceiling>,
    /// Number of the actuators that were chosen, where others were left out: what the ceiling
    /// proves holds for these alone.
    pub of_some: Option<usize>,
    pub limits: &'a Limits,
    pub method: Method,
    /// True where an actuator is as strong as it may be.
    pub at_drive_limit: bool,
}

impl Shortfall<'_> {
    /// The finding.
    pub fn finding(&self) -> Finding {
        let Self {
            points,
            ceiling,
            of_some,
            limits,
            method,
            at_drive_limit,
        } = *self;
        let contrast = points.contrast_db.map_or("no contrast".into(), |db| {
            format!("a contrast of {db:.1} dB")
        });
        let served = format!(
            "{:.1} % of the hot and {:.1} % of the cold responses keep their limit",
            100.0 * points.hot_ratio,
            100.0 * points.cold_ratio
        );
        let change = "widen transition_m, use more actuators, or another frequency";
        let help = match at_drive_limit && points.hot_ratio < 1.0 {
            true => format!("the drive is as strong as [actuators] allows: allow more, {change}"),
            false => change.to_owned(),
        };
        let of_ceiling = |finding: Finding, ceiling: &Ceiling| {
            finding
                .value("possible_db", ceiling.possible_db)
                .value("asked_db", ceiling.asked_db)
        };
        let finding = match (ceiling, of_some) {
            (Some(ceiling), Some(actuators)) if ceiling.forbids() => {
                let [possible, asked] = ceiling.in_words();
                let words = format!(
                "the scene is not met: the actuators chosen ({actuators}) give at most {possible} dB, \
                 asked {asked} dB; {served}, with {contrast}"
            );
                of_ceiling(Finding::fault("scene-not-met", words), ceiling)
            }
            (Some(ceiling), None) if ceiling.forbids() => {
                let [possible, asked] = ceiling.in_words();
                let words = format!(
                "the scene is impossible: possible {possible} dB, asked {asked} dB (certified: no \
                 drive within the limits of the actuators gives more in this model); {served}, \
                 with {contrast}"
            );
                of_ceiling(Finding::fault("scene-impossible", words), ceiling)
            }
            (Some(ceiling), _) => {
                let words = format!(
                "the scene is not met: possible at most {:.1} dB, asked {:.1} dB, found {:.1} dB; \
                 {served}, with {contrast}",
                ceiling.possible_db, ceiling.asked_db, ceiling.reached_db
            );
                of_ceiling(Finding::fault("scene-not-met", words), ceiling)
            }
            (None, _) => {
                let words = format!(
                    "the scene is not met: {served}, with {contrast} where {:.1} dB are needed",
                    limits.apart_db()
                );
                Finding::fault("scene-not-met", words)
            }
        };
        match (ceiling, method) {
            (None, Method::Mls | Method::PressureMatching) => {
                finding.help(format!("{help}; method `robust` says what is possible"))
            }
            _ => finding.help(help),
        }
    }
}

/// Warns where few actuators serve every response and not the ground between them.
pub(crate) fn ground_lost(area: &AreaIndices, actuators: usize) -> Option<Finding> {
    let least = [area.hot_ratio, area.cold_ratio]
        .into_iter()
        .flatten()
        .fold(1.0, f64::min);
    (least < tolerances::SERVES).then(|| {
        let words = format!(
            "{actuators} actuators serve every response, but between the responses only {:.0} % of \
             the hot or of the cold ground",
            100.0 * least
        );
        Finding::caution("ground-between", words)
            .value("least_area_ratio", least)
            .help("use a few more actuators")
    })
}

/// Warns of motion far above the threshold.
pub(crate) fn strength(field: &Field, limits: &Limits) -> Option<Finding> {
    let largest = field
        .velocity_m_per_s
        .iter()
        .map(|v| v.norm())
        .fold(0.0, f64::max);
    let level = 20.0 * (largest / limits.threshold_m_per_s).log10();
    (level > tolerances::STRONG_DB).then(|| {
        let words = format!("the panel moves {level:.0} dB above the threshold somewhere");
        Finding::caution("strong-motion", words)
            .value("level_db", level)
            .help("check the limits of exposure and of the actuators")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_is_told_to_sum_more_modes_than_there_are() {
        let points = PointIndices {
            hot_ratio: 1.0,
            cold_ratio: 1.0,
            min_ratio: 1.0,
            success_ratio: 1.0,
            silence_ratio: 0.0,
            contrast_db: None,
            margin_db: None,
            max_force_n: None,
            max_voltage_v: None,
        };
        let help = |modes| {
            let replay = Replay {
                is_measured: true,
                success_ratio: 0.9,
            };
            replayed_worse(replay, &points, [modes, 14]).unwrap().help
        };
        assert!(help(13).starts_with("sum more modes"), "{}", help(13));
        assert!(help(14).contains("correct the drive"), "{}", help(14));
    }
}
