//! The doubts that a pole may raise, one row each: code, sentence, and when it is raised.

use super::limits::*;
use super::usual::Usual;
use crate::measured::candidates::Origin;
use crate::measured::evidence::Evidence;
use crate::poles::estimate::UNCERTAIN_SENTENCE;
use crate::poles::limits::UNCERTAIN;
use chladni_frf::Reason;

/// A pole as the rules see it.
pub(super) struct Seen<'a> {
    /// Its own evidence.
    pub own: &'a Evidence,
    /// That of all others.
    pub others: &'a [&'a Evidence],
    /// Common properties of the sure modes.
    pub usual: Usual,
    /// FRFs of the set.
    pub frfs: usize,
    /// True where the records were windowed.
    pub windowed: bool,
}

impl Seen<'_> {
    /// True where a peak that is stronger by `fall_db` lies within the reach of its side
    /// lobes.
    fn beside_stronger(&self, fall_db: f64) -> bool {
        let line = self.own.lambda.im / self.own.half_width_lines.max(LEAST_HALF_WIDTH_LINES);
        self.others.iter().any(|other| {
            let lines = (other.lambda.re - self.own.lambda.re).abs() / line;
            lines <= SIDE_LOBE_LINES && other.level_db - self.own.level_db > fall_db
        })
    }

    /// True where another pole lies within so many half-bandwidths.
    fn near(&self, half_bandwidths: f64) -> bool {
        let own = self.own.lambda;
        self.others.iter().any(|other| {
            let distance = (other.lambda.re - own.re).abs();
            distance < half_bandwidths * other.lambda.im.max(own.im)
        })
    }

    /// True for a mode that needs no distinct peak.
    fn convinces(&self) -> bool {
        let own = self.own;
        let (misfit, deviation, part) = CONVINCING;
        let (misfit_alone, deviation_alone) = CONVINCING_ALONE;
        (own.misfit < misfit && own.deviation < deviation && own.part > part)
            || (own.misfit < misfit_alone && own.deviation < deviation_alone)
    }

    /// Degrees between the mean phase of its residues and that of the sure modes.
    fn off_degrees(&self) -> Option<f64> {
        let between = self.own.mean_phase? * self.usual.mean_phase?.conj();
        Some(0.5 * between.arg().abs().to_degrees())
    }
}

/// One doubt.
pub(super) struct Rule {
    code: &'static str,
    text: &'static str,
    /// True where two of its kind reject the pole.
    pub severe: bool,
    /// The detail where the doubt is raised, empty for none.
    raised: fn(&Seen) -> Option<String>,
}

impl Rule {
    const fn doubt(
        code: &'static str,
        text: &'static str,
        raised: fn(&Seen) -> Option<String>,
    ) -> Self {
        Self {
            code,
            text,
            severe: false,
            raised,
        }
    }

    const fn severe(
        code: &'static str,
        text: &'static str,
        raised: fn(&Seen) -> Option<String>,
    ) -> Self {
        Self {
            severe: true,
            ..Self::doubt(code, text, raised)
        }
    }

    /// The reason, where the doubt is raised.
    pub fn reason(&self, seen: &Seen) -> Option<Reason> {
        (self.raised)(seen).map(|detail| Reason::new(self.code, self.text).detail(detail))
    }
}

/// A doubt without a detail.
fn plain(raised: bool) -> Option<String> {
    raised.then(String::new)
}

/// Every doubt, in the order in which it is told.
pub(super) const RULES: [Rule; 24] = [
    Rule::doubt(
        "few-orders",
        "found by few of the model orders and line halves",
        |seen| match seen.own.origin {
            Origin::Agreed { score, .. } if score < FEW_ORDERS => {
                Some(format!("{:.0} %", 100.0 * score))
            }
            _ => None,
        },
    ),
    Rule::doubt(
        "left-over-peak",
        "found at a peak that the model orders had left",
        |seen| plain(matches!(seen.own.origin, Origin::Added)),
    ),
    Rule::doubt(
        "may-be-two",
        "two close modes would look like it as well as one that moves between FRFs",
        |seen| plain(seen.own.origin == Origin::MayBeTwo),
    ),
    Rule::severe(
        "drifted-in",
        "the estimate drifted in from outside the band",
        |seen| plain(matches!(seen.own.origin, Origin::Nuisance)),
    ),
    Rule::severe(
        "line-shape",
        "the peak does not have the shape of a resonance",
        |Seen { own, .. }| {
            let told = || format!("misses the data around it by {:.0} %", 100.0 * own.misfit);
            (own.misfit > NO_RESONANCE).then(told)
        },
    ),
    Rule::doubt("odd-even", "odd and even lines disagree", |seen| {
        let apart = seen.own.odd_even()?;
        (apart > DISAGREE).then(|| half_bandwidths(apart))
    }),
    Rule::doubt(
        "hardly-needed",
        "the data around it hardly need it",
        |Seen { own, .. }| {
            let rise = || {
                format!(
                    "residual energy rises by {:.0} % without it",
                    100.0 * own.gain
                )
            };
            (own.gain < HARDLY_NEEDED).then(rise)
        },
    ),
    Rule::doubt(
        "line-noise",
        "noise alone makes such peaks: it is alike on neighbouring lines",
        |seen| {
            let times = seen.own.over_noise.filter(|times| *times < CHANCE)?;
            Some(format!("{times:.2} of what chance explains"))
        },
    ),
    Rule::doubt(
        "too-narrow",
        "too narrow to tell a resonance from a tone",
        |seen| plain(seen.own.deviation > NO_WIDTH),
    ),
    Rule::doubt("uncertain", UNCERTAIN_SENTENCE, |seen| {
        let deviation = seen.own.deviation;
        let told = || format!("{deviation:.1} half-bandwidths, one sigma");
        (deviation > UNCERTAIN && deviation <= NO_WIDTH).then(told)
    }),
    Rule::doubt(
        "band-edge",
        "close to the band edge: widen the band",
        |Seen { own, .. }| (own.edge < EDGE).then(|| format!("{:.1} half-bandwidths", own.edge)),
    ),
    Rule::doubt(
        "buried",
        "more than 20 dB below the response around it",
        |seen| plain(seen.own.part < BURIED),
    ),
    Rule::doubt("scatters", "its frequency differs between FRFs", |seen| {
        let scatter = seen.own.scatter?;
        (scatter > DISAGREE).then(|| half_bandwidths(scatter))
    }),
    Rule::severe(
        "one-line-spike",
        "one-line spike: nothing is left of it without its two nearest lines",
        |Seen { own, .. }| {
            plain(own.half_width_lines < SPIKE_LINES && own.gain_without_nearest < NOTHING_LEFT)
        },
    ),
    Rule::doubt(
        "no-skirts",
        "no skirts: nothing is left of it beyond its four nearest lines",
        |Seen { own, .. }| {
            plain(own.half_width_lines < NARROW_LINES && own.gain_of_skirts < NOTHING_LEFT)
        },
    ),
    Rule::severe(
        "side-lobe",
        "side lobe of the stronger peak beside it: leakage",
        |seen| {
            let narrow = seen.own.half_width_lines < NARROW_LINES;
            plain(narrow && seen.beside_stronger(SIDE_LOBE_DB))
        },
    ),
    Rule::doubt(
        "windowed-side-lobe",
        "beside a stronger peak of windowed records: may be its side lobe",
        |seen| plain(seen.windowed && seen.beside_stronger(0.0)),
    ),
    Rule::severe(
        "tone",
        "damped far less than the sure modes around it: a tone rather than a mode",
        |Seen { own, usual, .. }| plain(own.lambda.im / own.lambda.re < TONE * usual.loss?),
    ),
    Rule::doubt(
        "broad",
        "damped far more than the sure modes around it, and without quite the shape of a resonance",
        |Seen { own, usual, .. }| {
            let loss = own.lambda.im / own.lambda.re;
            plain(loss > BROAD * usual.loss? && own.misfit > INDICATIVE)
        },
    ),
    Rule::severe("no-distinct-peak", "no distinct peak", |seen| {
        let height_db = seen.own.stands_out_db;
        let side = if height_db < 0.0 { "below" } else { "above" };
        let told = || format!("{:.0} dB {side} its surroundings", height_db.abs());
        (height_db < DISTINCT_DB && !seen.convinces()).then(told)
    }),
    Rule::doubt(
        "one-frf-alone",
        "one FRF alone shows it, 20 dB over all others",
        |seen| plain(seen.own.alone_db? > ALONE_DB),
    ),
    Rule::doubt(
        "no-common-phase",
        "its points have no common phase, and no other mode is near",
        |seen| {
            let collinearity = seen.own.mean_phase?.norm_sqr();
            let alone = collinearity < NO_COMMON_PHASE && !seen.near(ISOLATED);
            alone.then(|| format!("MPC {collinearity:.2}"))
        },
    ),
    Rule::doubt(
        "off-phase",
        "its phase differs from that of the sure modes",
        |seen| {
            let off = seen.off_degrees()?;
            (off > OFF_DEGREES).then(|| format!("{off:.0} degrees off"))
        },
    ),
    Rule::doubt(
        "half-pair",
        "half of a close pair that one FRF alone cannot tell from one mode",
        |seen| plain(seen.frfs == 1 && seen.near(HALF_PAIR)),
    ),
];

/// A distance in words; far apart is far apart.
fn half_bandwidths(apart: f64) -> String {
    match apart > 1000.0 {
        true => "more than 1000 half-bandwidths".into(),
        false => format!("{apart:.1} half-bandwidths"),
    }
}
