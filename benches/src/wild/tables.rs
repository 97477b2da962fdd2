//! The tables: a row for each structure.

use super::{Draw, WildOutcome, WildRow};
use crate::csv;
use chladni_frf::Damping;

/// Columns of what came of a structure.
const OUTCOME: [&str; 17] = [
    "seed",
    "law",
    "kind",
    "modes",
    "references",
    "responses",
    "snr_db",
    "complexity",
    "found",
    "spurious",
    "spurious_sure",
    "announced",
    "damping",
    "undecidable",
    "chi2_per_dof",
    "frequency_within_95",
    "time_s",
];

/// A row for each structure: what was drawn in short, and what came of it.
pub fn wild_csv(rows: &[WildRow]) -> String {
    let comment = "structures drawn from a seed; undecidable: the result says that the damping \
                   law cannot be told; the rest of what is drawn: wild-draws.csv";
    csv::table(comment, &OUTCOME, rows.iter().map(outcome))
}

fn law_name(law: Damping) -> String {
    match law {
        Damping::Structural => "structural".into(),
        Damping::Viscous => "viscous".into(),
    }
}

fn outcome(row: &WildRow) -> Vec<String> {
    let WildRow { draw, outcome } = row;
    let flag = |holds: bool| u8::from(holds).to_string();
    let fitted = outcome.viscous.map(|viscous| match viscous {
        true => Damping::Viscous,
        false => Damping::Structural,
    });
    vec![
        draw.seed.to_string(),
        law_name(draw.law),
        draw.kind.to_string(),
        draw.modes.to_string(),
        draw.references.to_string(),
        draw.responses.to_string(),
        csv::number(draw.snr_db),
        csv::number(draw.complexity),
        outcome.found.to_string(),
        outcome.spurious.to_string(),
        outcome.spurious_sure.to_string(),
        flag(outcome.announced),
        fitted.map(law_name).unwrap_or_default(),
        flag(outcome.undecidable),
        csv::number(outcome.chi2_per_dof),
        csv::number(outcome.covered[0] as f64 / outcome.found as f64),
        csv::number(outcome.time_s),
    ]
}

/// A number drawn.
type Property = (&'static str, fn(&Draw) -> f64);
/// A number of an outcome.
type Count = (&'static str, fn(&WildOutcome) -> f64);

/// The properties drawn, beside what stands in [`OUTCOME`].
pub(super) const PROPERTIES: [Property; 22] = [
    ("lines", |draw| draw.lines() as f64),
    ("overlap", |draw| draw.bandwidth_hz() / draw.spacing_hz()),
    ("least_spacing", |draw| draw.least_spacing),
    ("lines_per_bandwidth", |draw| draw.lines_per_bandwidth),
    ("loss_factor", |draw| draw.loss_factor),
    ("loss_spread", |draw| draw.loss_spread),
    ("uneven_modes", |draw| draw.uneven_modes),
    ("modes_below", |draw| draw.outside[0] as f64),
    ("modes_above", |draw| draw.outside[1] as f64),
    ("outside_weight", |draw| draw.outside_weight),
    ("outside_distance", |draw| draw.outside_distance),
    ("driving_points", |draw| {
        f64::from(u8::from(draw.driving_points))
    }),
    ("rigid_body", |draw| f64::from(u8::from(draw.rigid_body))),
    ("uneven_noise", |draw| draw.uneven_noise),
    ("single", |draw| f64::from(u8::from(draw.single))),
    ("uneven_axis", |draw| draw.uneven_axis),
    ("middle_hz", |draw| draw.middle_hz),
    ("delay_deg", |draw| draw.delay_deg),
    ("phase_deg", |draw| draw.phase_deg),
    ("spoilt_values", |draw| draw.spoilt_values as f64),
    ("roving_mass", |draw| draw.roving_mass),
    ("tones", |draw| draw.tones),
];

const COUNTS: [Count; 4] = [
    ("missed", |outcome| outcome.missed as f64),
    ("hidden", |outcome| outcome.hidden as f64),
    ("beyond_6_sigma", |outcome| outcome.beyond as f64),
    ("loss_factor_within_95", |outcome| {
        outcome.covered[1] as f64 / outcome.found as f64
    }),
];

/// All that was drawn, the rest of the counts, and the words of fits that ended without a
/// result.
pub fn wild_draws_csv(rows: &[WildRow]) -> String {
    let header: Vec<&str> = ["seed"]
        .into_iter()
        .chain(PROPERTIES.map(|(name, _)| name))
        .chain(COUNTS.map(|(name, _)| name))
        .chain(["findings", "failure"])
        .collect();
    let cells = rows.iter().map(|row| {
        let drawn = PROPERTIES
            .iter()
            .map(|(_, value)| csv::number(value(&row.draw)));
        let counted = COUNTS
            .iter()
            .map(|(_, value)| csv::number(value(&row.outcome)));
        [row.draw.seed.to_string()]
            .into_iter()
            .chain(drawn)
            .chain(counted)
            .chain([
                row.outcome.findings.join(" "),
                row.outcome.failure().unwrap_or_default().to_owned(),
            ])
            .collect()
    });
    csv::table("what each seed of wild.csv draws", &header, cells)
}

#[cfg(test)]
mod tests {
    use super::super::Difficulty;
    use super::*;

    #[test]
    fn tables_have_a_cell_for_each_column() {
        let row = WildRow {
            draw: Draw::new(4, Difficulty::Hard),
            outcome: WildOutcome {
                found: 2,
                covered: [1, 2],
                ..WildOutcome::default()
            },
        };
        for table in [
            wild_csv(std::slice::from_ref(&row)),
            wild_draws_csv(std::slice::from_ref(&row)),
        ] {
            let cells: Vec<usize> = table
                .lines()
                .skip(1)
                .map(|line| line.split(',').count())
                .collect();
            assert!(cells.len() == 2 && cells[0] == cells[1], "{table}");
        }
    }
}
