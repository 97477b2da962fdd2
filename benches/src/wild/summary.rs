//! The outcome of the seeds, beside what is asked for.

use super::{Difficulty, WildRow};
use chladni_frf::Damping;

/// Loss factor and noise level from which on the law is to be decided.
const DECIDED_FROM: (f64, f64) = (0.01, 40.0);
/// χ² per degree of freedom of a fit that explains its data.
const CHI2: [f64; 2] = [0.97, 1.05];

/// One number and its goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Criterion {
    /// The quantity that is counted.
    pub name: &'static str,
    /// Out of how many.
    pub of: usize,
    /// Number of those.
    pub count: usize,
    /// Least and largest share that the project asks for.
    pub goal: [f64; 2],
}

impl Criterion {
    /// Count over all; NaN of none.
    pub fn share(&self) -> f64 {
        self.count as f64 / self.of as f64
    }

    fn count(rows: &[WildRow], name: &'static str, of: Is, counts: Is, goal: [f64; 2]) -> Self {
        let all = || rows.iter().filter(|row| of(row));
        Self {
            name,
            of: all().count(),
            count: all().filter(|row| counts(row)).count(),
            goal,
        }
    }

    /// True where the goal is met, or nothing was counted.
    pub fn met(&self) -> bool {
        self.of == 0 || (self.goal[0]..=self.goal[1]).contains(&self.share())
    }
}

/// All criteria of one run.
pub fn summary(rows: &[WildRow]) -> Vec<Criterion> {
    let calm = rows
        .iter()
        .all(|row| row.draw.difficulty == Difficulty::Calm);
    let count = |name, of: Is, counts: Is, goal| Criterion::count(rows, name, of, counts, goal);
    let mut list = vec![
        count("internal errors", all, bug, [0.0, 0.0]),
        count("spurious mode called sure", all, spurious, [0.0, 0.002]),
        count(
            "sure mode beyond 6 error bars, unsaid",
            all,
            proud,
            [0.0, 0.002],
        ),
    ];
    if calm {
        list.extend([
            count("exact", all, exact, [0.98, 1.0]),
            count("exact or announced", all, known, [0.998, 1.0]),
            count("exact, and warned of all the same", exact, told, [0.0, 0.1]),
            count("law right where decided", decided, right, [1.0, 1.0]),
            count(
                "law decided: real shapes, loss factor from 1 %, from 40 dB",
                tellable,
                decided,
                [0.8, 1.0],
            ),
            count(
                "chi2 per degree of freedom 0.97 to 1.05",
                fitted,
                explained,
                [0.95, 1.0],
            ),
        ]);
        for (law, names) in [
            (Damping::Structural, COVERAGE[0]),
            (Damping::Viscous, COVERAGE[1]),
        ] {
            list.extend([0, 1].map(|which| coverage(rows, law, which, names[which])));
        }
    } else {
        list.extend([
            count("exact", all, exact, [0.0, 1.0]),
            count("wrong ones announced", wrong, told, [0.99, 1.0]),
            count(
                "law right where decided, exact ones",
                counts,
                right,
                [0.998, 1.0],
            ),
        ]);
    }
    list
}

/// A condition on one structure.
type Is = fn(&WildRow) -> bool;

fn all(_: &WildRow) -> bool {
    true
}

fn fitted(row: &WildRow) -> bool {
    row.outcome.viscous.is_some()
}

fn bug(row: &WildRow) -> bool {
    row.outcome.internal.is_some()
}

fn exact(row: &WildRow) -> bool {
    row.outcome.exact()
}

fn wrong(row: &WildRow) -> bool {
    !row.outcome.exact()
}

fn known(row: &WildRow) -> bool {
    !row.outcome.silent()
}

fn proud(row: &WildRow) -> bool {
    row.outcome.overconfident()
}

fn told(row: &WildRow) -> bool {
    row.outcome.announced
}

fn spurious(row: &WildRow) -> bool {
    row.outcome.spurious_sure > 0
}

fn decided(row: &WildRow) -> bool {
    fitted(row) && !row.outcome.undecidable
}

/// The law counts in the modes found, these are right in number, and no phase of the
/// measurement stands against it unsaid.
fn counts(row: &WildRow) -> bool {
    let outcome = &row.outcome;
    decided(row) && exact(row) && outcome.law_matters && !outcome.law_conditional()
}

fn right(row: &WildRow) -> bool {
    row.outcome.viscous == Some(row.draw.law == Damping::Viscous)
}

fn tellable(row: &WildRow) -> bool {
    let (loss_factor, snr_db) = DECIDED_FROM;
    // complex shapes hide the turn that tells the laws apart
    let real = row.draw.complexity == 0.0;
    fitted(row) && real && row.draw.loss_factor >= loss_factor && row.draw.snr_db >= snr_db
}

fn explained(row: &WildRow) -> bool {
    (CHI2[0]..=CHI2[1]).contains(&row.outcome.chi2_per_dof)
}

/// Names of the criteria of coverage: of each law, natural frequency and loss factor.
const COVERAGE: [[&str; 2]; 2] = [
    [
        "structural: natural frequency within 95 %",
        "structural: loss factor within 95 %",
    ],
    [
        "viscous: natural frequency within 95 %",
        "viscous: loss factor within 95 %",
    ],
];

/// Modes of fits in the right law, and those within their 95 % intervals. Where the law
/// cannot be told, bars hold both laws: those fits are left out.
fn coverage(rows: &[WildRow], law: Damping, which: usize, name: &'static str) -> Criterion {
    let viscous = law == Damping::Viscous;
    let own = rows
        .iter()
        .filter(|row| row.draw.law == law && row.outcome.viscous == Some(viscous))
        .filter(|row| !row.outcome.undecidable);
    let (of, count) = own.fold((0, 0), |(of, count), row| {
        (of + row.outcome.found, count + row.outcome.covered[which])
    });
    Criterion {
        name,
        of,
        count,
        goal: [0.93, 0.97],
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Draw, WildOutcome};
    use super::*;

    #[test]
    fn each_failure_counts_where_it_belongs() {
        let row = |seed: u64, outcome: WildOutcome| WildRow {
            draw: Draw {
                law: Damping::Viscous,
                ..Draw::new(seed, Difficulty::Calm)
            },
            outcome,
        };
        let good = WildOutcome {
            found: 4,
            viscous: Some(true),
            chi2_per_dof: 1.0,
            covered: [4, 3],
            ..WildOutcome::default()
        };
        let rows = [
            row(1, good.clone()),
            row(
                2,
                WildOutcome {
                    spurious: 1,
                    spurious_sure: 1,
                    ..good.clone()
                },
            ),
            row(
                3,
                WildOutcome {
                    missed: 1,
                    announced: true,
                    viscous: Some(false),
                    ..good.clone()
                },
            ),
            row(
                4,
                WildOutcome {
                    internal: Some("bug".into()),
                    ..WildOutcome::default()
                },
            ),
        ];
        let list = summary(&rows);
        let of = |name: &str| {
            list.iter()
                .find(|criterion| criterion.name == name)
                .unwrap()
        };
        assert_eq!(
            (of("internal errors").count, of("internal errors").met()),
            (1, false)
        );
        assert_eq!((of("exact").count, of("exact").of), (1, 4));
        assert_eq!(of("spurious mode called sure").count, 1);
        let law = of("law right where decided");
        assert_eq!((law.count, law.of), (2, 3));
        let covered = of("viscous: loss factor within 95 %");
        assert_eq!((covered.count, covered.of), (6, 8));
        assert!(
            of("structural: loss factor within 95 %").met(),
            "none counted"
        );
    }
}
