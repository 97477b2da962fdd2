//! Grades: what a modal engineer would say of each pole, with the reasons.

mod damping_doubt;
mod limits;
mod rules;
mod usual;

use crate::data::grade::Grade;
use crate::measured::candidates::Origin;
use crate::measured::evidence::Evidence;
use crate::measured::record::Record;
use crate::tolerances as tol;
use chladni_frf::{Reason, Trust};
pub(crate) use damping_doubt::DampingDoubt;
use limits::*;
use rules::{Seen, RULES};
use usual::Usual;

/// The grade of a pole, and the doubt about its damping if there is one.
#[derive(Debug, Clone)]
pub(crate) struct Graded {
    pub grade: Grade,
    pub doubt: Option<DampingDoubt>,
}

impl From<Grade> for Graded {
    fn from(grade: Grade) -> Self {
        Self { grade, doubt: None }
    }
}

/// Grades every pole of `all` (in order of frequency); poles outside the band pass
/// ungraded.
pub(crate) fn grade_all(all: &[Evidence], record: &Record) -> Vec<Graded> {
    let grade = |list: &[Evidence], q: usize, usual: Usual| {
        grade(list, q, record.frfs, record.windowed, usual)
    };
    let inside: Vec<Evidence> = all.iter().filter(|e| e.in_band()).cloned().collect();
    let mut graded: Vec<Graded> = (0..inside.len())
        .map(|q| grade(&inside, q, Usual::default()))
        .collect();
    for _ in 0..ROUNDS {
        let is_sure = |own: &Graded| own.grade.trust == Trust::Sure;
        let sure: Vec<bool> = graded.iter().map(is_sure).collect();
        graded = (0..inside.len())
            .map(|q| grade(&inside, q, Usual::beside(q, &inside, &sure)))
            .collect();
    }
    let mut graded = graded.into_iter();
    let ungraded = Graded::from(Grade {
        trust: Trust::Weak,
        reasons: Vec::new(),
    });
    let next = |e: &Evidence| match e.in_band() {
        true => graded.next(),
        false => None,
    };
    all.iter()
        .map(next)
        .map(|own| own.unwrap_or_else(|| ungraded.clone()))
        .collect()
}

/// The grade of pole `q` of `all`, by [`RULES`].
fn grade(all: &[Evidence], q: usize, frfs: usize, windowed: bool, usual: Usual) -> Graded {
    let own = &all[q];
    if own.lambda.im > tol::BACKGROUND_LOSS * own.lambda.re {
        let reason = Reason::new("background", "background: broader than any mode");
        return Grade::rejected(reason).into();
    }
    if own.origin == Origin::LeftOut {
        let reason = Reason::new("left-out", "more modes were found than were asked for");
        return Grade::rejected(reason).into();
    }
    let others: Vec<&Evidence> = all[..q].iter().chain(&all[q + 1..]).collect();
    let seen = Seen {
        own,
        others: &others,
        usual,
        frfs,
        windowed,
    };
    let raised: Vec<(bool, Reason)> = RULES
        .iter()
        .filter_map(|rule| Some((rule.severe, rule.reason(&seen)?)))
        .collect();
    let severe = raised.iter().filter(|(severe, _)| *severe).count();
    let reasons: Vec<Reason> = raised.into_iter().map(|(_, reason)| reason).collect();
    let visible_line = own.stands_out_db > VISIBLE_DB && own.half_width_lines < SPIKE_LINES;
    let is_noise = own.over_noise.is_some_and(|times| times < CHANCE);
    let no_mode = own.misfit > NO_MODE || own.gain < NOT_NEEDED || is_noise || severe >= SEVERE;
    let trust = if no_mode && !visible_line {
        Trust::Rejected
    } else if reasons.is_empty() {
        Trust::Sure
    } else {
        Trust::Weak
    };
    Graded {
        grade: Grade { trust, reasons },
        doubt: DampingDoubt::of(own),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;

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
            over_noise: None,
            deviation: 0.01,
            scatter: Some(0.01),
            misfit: 0.05,
            part: 0.9,
            half_width_lines: 2.0,
            stands_out_db: 30.0,
            edge: 50.0,
            level_db: 0.0,
            alone_db: Some(3.0),
            mean_phase: Some(Complex64::new(0.99, 0.05)),
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
            mean_phase: Some(Complex64::new(5.0, 0.0)),
        };
        grade(&all, 0, frfs, windowed, usual).grade
    }

    #[test]
    fn each_doubt_is_named_and_nothing_else() {
        let Grade { trust, reasons } = graded(|_| (), 3, false, &[]);
        assert_eq!((trust, reasons.len()), (Trust::Sure, 0));
        type Doubt = (&'static str, fn(&mut Evidence));
        let doubts: [Doubt; 19] = [
            ("model orders and line halves", |e| {
                e.origin = Origin::Agreed {
                    score: 0.6,
                    odd_even: None,
                }
            }),
            ("model orders had left", |e| e.origin = Origin::Added),
            ("two close modes", |e| e.origin = Origin::MayBeTwo),
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
            ("damped far more", |e| (e.lambda.im, e.misfit) = (0.02, 0.3)),
            ("one FRF alone", |e| e.alone_db = Some(25.0)),
            ("no common phase", |e| {
                e.mean_phase = Some(Complex64::new(0.5, 0.1))
            }),
            ("degrees off", |e| {
                e.mean_phase = Some(Complex64::new(-0.6, 0.7))
            }),
            ("no distinct peak", |e| {
                (e.stands_out_db, e.deviation, e.misfit) = (5.0, 0.1, 0.3)
            }),
        ];
        for (words, change) in doubts {
            let Grade { trust, reasons } = graded(change, 3, false, &[]);
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
        let Grade { trust, reasons } = graded(narrow, 3, false, &[stronger(3.0)]);
        assert!(
            trust == Trust::Weak && reasons[0].contains("side lobe of the stronger peak"),
            "{reasons:?}"
        );
        assert_eq!(
            graded(narrow, 3, false, &[stronger(9.0)]).trust,
            Trust::Sure,
            "too far for a side lobe"
        );
        assert_eq!(
            graded(|_| (), 3, false, &[stronger(3.0)]).trust,
            Trust::Sure,
            "too broad for a side lobe"
        );
        let Grade { trust, reasons } = graded(|_| (), 3, true, &[stronger(3.0)]);
        assert!(
            trust == Trust::Weak && reasons[0].contains("windowed"),
            "{reasons:?}"
        );
        let Grade { trust, reasons } = graded(|_| (), 1, false, &[good(0.303)]);
        assert!(
            trust == Trust::Weak && reasons[0].contains("half of a close pair"),
            "{reasons:?}"
        );
    }

    #[test]
    fn what_chance_explains_of_correlated_noise_is_no_mode() {
        let over_noise = |times: f64| graded(|e| e.over_noise = Some(times), 3, false, &[]);
        let Grade { trust, reasons } = over_noise(0.5);
        assert_eq!(trust, Trust::Rejected);
        assert!(
            reasons.len() == 1 && reasons[0].contains("noise alone"),
            "{reasons:?}"
        );
        assert_eq!(over_noise(2.0), Grade::SURE);
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
        assert_eq!(graded(hidden, 3, false, &[]).trust, Trust::Rejected);
        assert_eq!(graded(spoilt, 3, false, &[]).trust, Trust::Weak);
        let Grade { trust, reasons } = graded(|e| e.lambda.im = 0.2, 3, false, &[]);
        assert!(trust == Trust::Rejected && reasons[0].contains("background"));
    }
}
