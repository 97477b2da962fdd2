//! Grades: what a modal engineer would say of each pole, with the reasons.

use crate::measured::candidates::Origin;
use crate::measured::evidence::Evidence;
use crate::measured::record::Record;
use crate::poles::estimate::{self, Grade};
use chladni_frf::{Finding, Reason, Trust};
use num_complex::Complex64;

/// Median loss of the six modes nearest to candidate q among those that are `sure`;
/// `None` below three.
fn usual_loss(all: &[Evidence], sure: &[bool], q: usize) -> Option<f64> {
    let mut neighbours: Vec<(f64, f64)> = all
        .iter()
        .zip(sure)
        .enumerate()
        .filter(|(other, (_, sure))| *other != q && **sure)
        .map(|(_, (o, _))| {
            (
                (o.lambda.re - all[q].lambda.re).abs(),
                o.lambda.im / o.lambda.re,
            )
        })
        .collect();
    neighbours.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut losses: Vec<f64> = neighbours.iter().take(6).map(|n| n.1).collect();
    losses.sort_by(f64::total_cmp);
    (losses.len() >= 3).then(|| losses[losses.len() / 2])
}

/// Where the residues of the `sure` modes but q stand, each weighted by how well it is
/// known; `None` where they are few, or stand everywhere.
fn usual_stand(all: &[Evidence], sure: &[bool], q: usize) -> Option<Complex64> {
    let others = all
        .iter()
        .zip(sure)
        .enumerate()
        .filter(|(other, (_, sure))| *other != q && **sure);
    let (mut sum, mut weights, mut squares) = (Complex64::ZERO, 0.0, 0.0);
    for (stand, deviation) in others.filter_map(|(_, (e, _))| Some((e.stand?, e.deviation))) {
        let weight = deviation.max(BEST_KNOWN).powi(-2);
        sum += weight * stand;
        weights += weight;
        squares += weight * weight;
    }
    (weights * weights >= FEW * squares && sum.norm() > COMMON * weights).then_some(sum)
}

/// What the sure modes have in common.
#[derive(Clone, Copy, Default)]
struct Usual {
    loss: Option<f64>,
    stand: Option<Complex64>,
}

/// Error bar, in half-bandwidths, below which modes count as equally well known.
const BEST_KNOWN: f64 = 0.01;
/// Modes, of equal weight, that it takes to tell where residues usually stand; and the
/// least share of them that agrees.
const FEW: f64 = 3.0;
/// See above.
const COMMON: f64 = 0.9;
/// Degrees off the others from which residues do not stand with them.
const OFF_DEGREES: f64 = 45.0;
/// Largest residue over the next, dB, beyond which one FRF alone shows a mode.
const ALONE_DB: f64 = 20.0;
/// Modal phase collinearity below which a shape is none that one mode alone makes, and
/// half-bandwidths within which another has a part in it.
const NO_COMMON_PHASE: f64 = 0.5;
/// See above.
const ISOLATED: f64 = 6.0;

/// Loss factor beyond which a pole is no resonance.
const BACKGROUND_LOSS: f64 = 0.4;

/// Lines within which a stronger peak has side lobes, and how far they lie below it, dB.
const SIDE_LOBE_LINES: f64 = 4.0;
/// See above.
const SIDE_LOBE_DB: f64 = 8.0;

/// Half-bandwidths beyond which the size of an error bar says nothing more.
const NO_WIDTH: f64 = 3.0;

/// The reason that an error bar of so many half-bandwidths is.
fn uncertain(deviation: f64) -> Reason {
    match deviation > NO_WIDTH {
        true => Reason::new("too-narrow", "too narrow to tell a resonance from a tone"),
        false => estimate::uncertain(deviation),
    }
}

/// A doubt about the damping of a mode that is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DampingDoubt {
    /// Too few lines within the half-power bandwidth.
    UpperBound,
    /// A peak without the shape of a resonance.
    Indicative,
}

impl DampingDoubt {
    /// The finding about modes at these frequencies, rising; none without a mode.
    pub fn finding(self, places_hz: Vec<f64>) -> Option<Finding> {
        let subject = match places_hz.as_slice() {
            [] => return None,
            [one] => format!("the mode at {one:.2} Hz"),
            [first, .., last] => {
                format!("{} modes, {first:.1} to {last:.1} Hz", places_hz.len())
            }
        };
        let finding = match self {
            Self::UpperBound => Finding::caution(
                "damping-upper-bound",
                format!(
                    "{subject}: fewer than two lines within the half-power bandwidth; the damping \
                     is an upper bound"
                ),
            )
            .help("measure longer records for finer lines"),
            Self::Indicative => Finding::caution(
                "damping-indicative",
                format!("{subject}: no shape of a resonance; the damping is indicative only"),
            )
            .help("measure at a lower level, or fit these modes in a narrow band"),
        };
        Some(finding.modes_hz(places_hz))
    }
}

/// A grade with the doubt about damping, if there is one.
pub(crate) type Graded = (Grade, Option<DampingDoubt>);

/// Grades every pole of `all` (in order of frequency); poles outside the band pass
/// ungraded.
pub(crate) fn grade_all(all: &[Evidence], record: &Record) -> Vec<Graded> {
    let grade = |list: &[Evidence], q: usize, usual: Usual| {
        grade(list, q, record.frfs, record.windowed, usual)
    };
    let inside: Vec<Evidence> = all.iter().filter(|e| e.in_band()).cloned().collect();
    let sure: Vec<bool> = (0..inside.len())
        .map(|q| grade(&inside, q, Usual::default()).0 .0 == Trust::Sure)
        .collect();
    let usual = |q: usize| Usual {
        loss: usual_loss(&inside, &sure, q),
        stand: usual_stand(&inside, &sure, q),
    };
    let mut graded = (0..inside.len()).map(|q| grade(&inside, q, usual(q)));
    all.iter()
        .map(|e| {
            if e.in_band() { graded.next() } else { None }
                .unwrap_or(((Trust::Weak, Vec::new()), None))
        })
        .collect()
}

/// Sees neighbours: `all` holds the evidence of every candidate in order of frequency,
/// `usual` what the sure modes have in common, once they are known.
fn grade(all: &[Evidence], q: usize, frfs: usize, windowed: bool, usual: Usual) -> Graded {
    let e = &all[q];
    // a broad in-band pole serves the background
    if e.lambda.im > BACKGROUND_LOSS * e.lambda.re {
        return (
            (
                Trust::Rejected,
                vec![Reason::new(
                    "background",
                    "background: broader than any mode",
                )],
            ),
            None,
        );
    }
    let mut reasons = Vec::new();
    let mut severe = 0;
    let mut note = |bad: bool, is_severe: bool, reason: Reason| {
        if bad {
            severe += usize::from(is_severe);
            reasons.push(reason);
        }
    };
    match e.origin {
        Origin::Agreed { score, .. } => {
            note(
                score < 0.75,
                false,
                Reason::new(
                    "few-orders",
                    "found by few of the model orders and line halves",
                )
                .detail(format!("{:.0} %", 100.0 * score)),
            );
        }
        Origin::Added => note(
            true,
            false,
            Reason::new(
                "left-over-peak",
                "found at a peak that the model orders had left",
            ),
        ),
        Origin::Nuisance => note(
            true,
            true,
            Reason::new(
                "drifted-in",
                "the estimate drifted in from outside the band",
            ),
        ),
    }
    note(
        e.misfit > 0.5,
        true,
        Reason::new(
            "line-shape",
            "the peak does not have the shape of a resonance",
        )
        .detail(format!(
            "misses the data around it by {:.0} %",
            100.0 * e.misfit
        )),
    );
    if let Some(d) = e.odd_even() {
        note(
            d > 0.5,
            false,
            Reason::new("odd-even", "odd and even lines disagree")
                .detail(format!("{d:.1} half-bandwidths")),
        );
    }
    note(
        e.gain < 1.5,
        false,
        Reason::new("hardly-needed", "the data around it hardly need it").detail(format!(
            "residual energy rises by {:.0} % without it",
            100.0 * e.gain
        )),
    );
    note(e.deviation > 0.3, false, uncertain(e.deviation));
    note(
        e.edge < 2.0,
        false,
        Reason::new("band-edge", "close to the band edge: widen the band")
            .detail(format!("{:.1} half-bandwidths", e.edge)),
    );
    note(
        e.part < 0.1,
        false,
        Reason::new("buried", "more than 20 dB below the response around it"),
    );
    if let Some(s) = e.scatter {
        note(
            s > 0.5,
            false,
            Reason::new("scatters", "its frequency differs between FRFs")
                .detail(format!("{s:.1} half-bandwidths")),
        );
    }
    note(
        e.half_width_lines < 0.5 && e.gain_without_nearest < 1.0,
        true,
        Reason::new(
            "one-line-spike",
            "one-line spike: nothing is left of it without its two nearest lines",
        ),
    );
    note(
        e.half_width_lines < 1.0 && e.gain_of_skirts < 1.0,
        false,
        Reason::new(
            "no-skirts",
            "no skirts: nothing is left of it beyond its four nearest lines",
        ),
    );
    let beside = |reach: f64, fall_db: f64| {
        all.iter().enumerate().any(|(other, o)| {
            let lines =
                (o.lambda.re - e.lambda.re).abs() / (e.lambda.im / e.half_width_lines.max(1e-9));
            other != q && lines <= reach && o.level_db - e.level_db > fall_db
        })
    };
    note(
        e.half_width_lines < 1.0 && beside(SIDE_LOBE_LINES, SIDE_LOBE_DB),
        true,
        Reason::new(
            "side-lobe",
            "side lobe of the stronger peak beside it: leakage",
        ),
    );
    note(
        windowed && beside(SIDE_LOBE_LINES, 0.0),
        false,
        Reason::new(
            "windowed-side-lobe",
            "beside a stronger peak of windowed records: may be its side lobe",
        ),
    );
    if let Some(usual) = usual.loss {
        note(
            e.lambda.im / e.lambda.re < 0.12 * usual,
            true,
            Reason::new(
                "tone",
                "damped far less than the sure modes around it: a tone rather than a mode",
            ),
        );
    }
    let convincing = (e.misfit < 0.1 && e.deviation < 0.05 && e.part > 0.5)
        || (e.deviation < 0.03 && e.misfit < 0.25);
    note(
        e.stands_out_db < 10.0 && !convincing,
        true,
        Reason::new("no-distinct-peak", "no distinct peak").detail(match e.stands_out_db < 0.0 {
            true => format!("{:.0} dB below its surroundings", -e.stands_out_db),
            false => format!("{:.0} dB above its surroundings", e.stands_out_db),
        }),
    );
    let near = |reach: f64| {
        let close =
            |o: &Evidence| (o.lambda.re - e.lambda.re).abs() < reach * o.lambda.im.max(e.lambda.im);
        all.iter()
            .enumerate()
            .any(|(other, o)| other != q && close(o))
    };
    note(
        e.alone_db.is_some_and(|db| db > ALONE_DB),
        false,
        Reason::new(
            "one-frf-alone",
            "one FRF alone shows it, 20 dB over all others",
        ),
    );
    if let Some(stand) = e.stand {
        let mpc = stand.norm_sqr();
        note(
            mpc < NO_COMMON_PHASE && !near(ISOLATED),
            false,
            Reason::new(
                "no-common-phase",
                "its points have no common phase, and no other mode is near",
            )
            .detail(format!("MPC {mpc:.2}")),
        );
        let off = usual.stand.map_or(0.0, |usual| {
            0.5 * (stand * usual.conj()).arg().abs().to_degrees()
        });
        note(
            off > OFF_DEGREES,
            false,
            Reason::new("off-phase", "its phase differs from that of the sure modes")
                .detail(format!("{off:.0} degrees off")),
        );
    }
    if frfs == 1 {
        note(
            near(2.0),
            false,
            Reason::new(
                "half-pair",
                "half of a close pair that one FRF alone cannot tell from one mode",
            ),
        );
    }

    let visible_line = e.stands_out_db > 20.0 && e.half_width_lines < 0.5;
    let trust = if (e.misfit > 1.5 || e.gain < 0.3 || severe >= 2) && !visible_line {
        Trust::Rejected
    } else if reasons.is_empty() {
        Trust::Sure
    } else {
        Trust::Weak
    };
    let damping = if 2.0 * e.half_width_lines < 2.0 {
        Some(DampingDoubt::UpperBound)
    } else if e.misfit > 0.2 {
        Some(DampingDoubt::Indicative)
    } else {
        None
    };
    ((trust, reasons), damping)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode beyond doubt at x = 0.3, 4 lines wide.
    fn good(x: f64) -> Evidence {
        Evidence {
            lambda: Complex64::new(x, 0.002),
            origin: Origin::Agreed {
                score: 1.0,
                odd_even: Some(1e-5),
            },
            gain: 100.0,
            gain_without_nearest: 50.0,
            gain_of_skirts: 30.0,
            deviation: 0.01,
            scatter: Some(0.01),
            misfit: 0.05,
            part: 0.9,
            half_width_lines: 2.0,
            stands_out_db: 30.0,
            edge: 50.0,
            level_db: 0.0,
            alone_db: Some(3.0),
            stand: Some(Complex64::new(0.99, 0.05)),
        }
    }

    fn graded(
        change: impl Fn(&mut Evidence),
        frfs: usize,
        windowed: bool,
        neighbours: &[Evidence],
    ) -> Grade {
        let mut all = vec![good(0.3)];
        change(&mut all[0]);
        all.extend(neighbours.iter().cloned());
        let usual = Usual {
            loss: Some(0.007),
            stand: Some(Complex64::new(5.0, 0.0)),
        };
        grade(&all, 0, frfs, windowed, usual).0
    }

    #[test]
    fn each_doubt_is_named_and_nothing_else() {
        let (trust, reasons) = graded(|_| (), 3, false, &[]);
        assert_eq!((trust, reasons.len()), (Trust::Sure, 0));
        type Doubt = (&'static str, fn(&mut Evidence));
        let doubts: [Doubt; 17] = [
            ("model orders and line halves", |e| {
                e.origin = Origin::Agreed {
                    score: 0.6,
                    odd_even: None,
                }
            }),
            ("model orders had left", |e| e.origin = Origin::Added),
            ("drifted in", |e| e.origin = Origin::Nuisance),
            ("odd and even lines", |e| {
                e.origin = Origin::Agreed {
                    score: 1.0,
                    odd_even: Some(0.0015),
                }
            }),
            ("shape of a resonance", |e| e.misfit = 0.6),
            ("hardly need it", |e| e.gain = 1.0),
            ("is uncertain", |e| e.deviation = 0.4),
            ("band edge", |e| e.edge = 1.0),
            ("20 dB below", |e| e.part = 0.05),
            ("differs between FRFs", |e| e.scatter = Some(0.8)),
            ("one-line spike", |e| {
                (e.half_width_lines, e.gain_without_nearest) = (0.3, 0.5)
            }),
            ("no skirts", |e| {
                (e.half_width_lines, e.gain_of_skirts) = (0.7, 0.5)
            }),
            ("a tone", |e| e.lambda.im = 0.0001),
            ("one FRF alone", |e| e.alone_db = Some(25.0)),
            ("no common phase", |e| {
                e.stand = Some(Complex64::new(0.5, 0.1))
            }),
            ("degrees off", |e| e.stand = Some(Complex64::new(-0.6, 0.7))),
            ("no distinct peak", |e| {
                (e.stands_out_db, e.deviation, e.misfit) = (5.0, 0.1, 0.3)
            }),
        ];
        for (words, change) in doubts {
            let (trust, reasons) = graded(change, 3, false, &[]);
            assert_eq!(trust, Trust::Weak, "{words}: {reasons:?}");
            assert!(
                reasons.len() == 1 && reasons[0].contains(words),
                "{words}: {reasons:?}"
            );
        }
    }

    #[test]
    fn stronger_neighbours_make_side_lobes_and_half_pairs() {
        let stronger = |lines: f64| Evidence {
            level_db: 20.0,
            ..good(0.3 + 0.001 * lines)
        };
        let narrow = |e: &mut Evidence| (e.lambda.im, e.half_width_lines) = (0.0009, 0.9);
        let (trust, reasons) = graded(narrow, 3, false, &[stronger(3.0)]);
        assert!(
            trust == Trust::Weak && reasons[0].contains("side lobe of the stronger peak"),
            "{reasons:?}"
        );
        assert_eq!(
            graded(narrow, 3, false, &[stronger(9.0)]).0,
            Trust::Sure,
            "too far for a side lobe"
        );
        assert_eq!(
            graded(|_| (), 3, false, &[stronger(3.0)]).0,
            Trust::Sure,
            "too broad for a side lobe"
        );
        let (trust, reasons) = graded(|_| (), 3, true, &[stronger(3.0)]);
        assert!(
            trust == Trust::Weak && reasons[0].contains("windowed"),
            "{reasons:?}"
        );
        let (trust, reasons) = graded(|_| (), 1, false, &[good(0.303)]);
        assert!(
            trust == Trust::Weak && reasons[0].contains("half of a close pair"),
            "{reasons:?}"
        );
    }

    #[test]
    fn two_severe_doubts_reject_but_a_visible_line_is_shown() {
        let spoilt = |e: &mut Evidence| {
            (e.misfit, e.half_width_lines, e.gain_without_nearest) = (0.7, 0.3, 0.5)
        };
        let hidden = |e: &mut Evidence| {
            spoilt(e);
            e.stands_out_db = 15.0;
        };
        assert_eq!(graded(hidden, 3, false, &[]).0, Trust::Rejected);
        assert_eq!(graded(spoilt, 3, false, &[]).0, Trust::Weak);
        let (trust, reasons) = graded(|e| e.lambda.im = 0.2, 3, false, &[]);
        assert!(trust == Trust::Rejected && reasons[0].contains("background"));
    }
}
