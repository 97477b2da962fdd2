//! Grades: what a modal engineer would say of each pole, with the reasons.

use super::candidates::Origin;
use super::evidence::Evidence;
use crate::model::Grade;
use chladni_frf::Trust;

/// Median loss of the six modes nearest to candidate q among those that are `sure`; `None` below three.
fn usual_loss(all: &[Evidence], sure: &[bool], q: usize) -> Option<f64> {
    let mut neighbours: Vec<(f64, f64)> = all
        .iter()
        .zip(sure)
        .enumerate()
        .filter(|(other, (_, sure))| *other != q && **sure)
        .map(|(_, (o, _))| ((o.lambda.re - all[q].lambda.re).abs(), o.lambda.im / o.lambda.re))
        .collect();
    neighbours.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut losses: Vec<f64> = neighbours.iter().take(6).map(|n| n.1).collect();
    losses.sort_by(f64::total_cmp);
    (losses.len() >= 3).then(|| losses[losses.len() / 2])
}

/// Loss factor beyond which a pole is no resonance.
const BACKGROUND_LOSS: f64 = 0.4;

/// A grade with the doubt about damping, if there is one.
pub(crate) type Graded = (Grade, Option<&'static str>);

/// Grades every pole of `all` (in order of frequency); poles outside the band pass ungraded.
pub(crate) fn grade_all(all: &[Evidence], frfs: usize) -> Vec<Graded> {
    let inside: Vec<Evidence> = all.iter().filter(|e| e.in_band()).cloned().collect();
    let sure: Vec<bool> = (0..inside.len()).map(|q| grade(&inside, q, frfs, None).0 .0 == Trust::Sure).collect();
    let mut graded = (0..inside.len()).map(|q| grade(&inside, q, frfs, usual_loss(&inside, &sure, q)));
    all.iter().map(|e| if e.in_band() { graded.next() } else { None }.unwrap_or(((Trust::Weak, Vec::new()), None))).collect()
}

/// Sees neighbours: `all` holds the evidence of every candidate in order of frequency, `usual_loss` the damping of the sure
/// modes around it, once they are known.
fn grade(all: &[Evidence], q: usize, frfs: usize, usual_loss: Option<f64>) -> Graded {
    let e = &all[q];
    // a broad in-band pole serves the background
    if e.lambda.im > BACKGROUND_LOSS * e.lambda.re {
        return ((Trust::Rejected, vec!["background: broader than any mode".into()]), None);
    }
    let mut reasons = Vec::new();
    let mut severe = 0;
    let mut note = |bad: bool, is_severe: bool, text: String| {
        if bad {
            severe += usize::from(is_severe);
            reasons.push(text);
        }
    };
    match e.origin {
        Origin::Agreed { score, .. } => {
            note(score < 0.75, false, format!("found by only {:.0} % of the model orders and line halves", 100.0 * score));
        }
        Origin::Added => note(true, false, "found at a peak that the model orders had left".into()),
        Origin::Nuisance => note(true, true, "wandered in from outside the band".into()),
    }
    note(e.misfit > 0.5, true, format!("the line shape misses the data by {:.0} % around the peak", 100.0 * e.misfit));
    if let Some(d) = e.odd_even() {
        note(d > 0.5, false, format!("odd and even lines disagree by {d:.1} half-bandwidths"));
    }
    note(e.gain < 1.5, false, format!("its neighbourhood hardly needs it (residual energy rises by {:.0} % without it)", 100.0 * e.gain));
    note(e.deviation > 0.3, false, format!("uncertain by {:.1} half-bandwidths (one sigma)", e.deviation));
    note(e.edge < 2.0, false, format!("only {:.1} half-bandwidths from the band edge: widen the band", e.edge));
    note(e.part < 0.1, false, "more than 20 dB below the response around it".into());
    if let Some(s) = e.scatter {
        note(s > 0.5, false, format!("its frequency scatters by {s:.1} half-bandwidths over the FRFs"));
    }
    note(
        e.half_width_lines < 0.5 && e.gain_without_nearest < 1.0,
        true,
        "one-line spike: nothing is left of it without its two nearest lines".into(),
    );
    // side lobe of a stronger peak: within four lines, 8 dB lower, narrower than two lines
    let lobe = all.iter().enumerate().any(|(other, o)| {
        let lines = (o.lambda.re - e.lambda.re).abs() / (e.lambda.im / e.half_width_lines.max(1e-9));
        other != q && lines <= 4.0 && o.level_db - e.level_db > 8.0
    });
    note(lobe && 2.0 * e.half_width_lines < 2.0, true, "side lobe of the stronger peak beside it (leakage)".into());
    if let Some(usual) = usual_loss {
        note(
            e.lambda.im / e.lambda.re < 0.12 * usual,
            true,
            "damped far less than the sure modes around it: a tone (mains, fan) rather than a mode".into(),
        );
    }
    let convincing = (e.misfit < 0.1 && e.deviation < 0.05 && e.part > 0.5) || (e.deviation < 0.03 && e.misfit < 0.25);
    note(e.stands_out_db < 10.0 && !convincing, true, format!("does not stand out of its surroundings ({:.0} dB)", e.stands_out_db));
    if frfs == 1 {
        let pair =
            all.iter().enumerate().any(|(other, o)| other != q && (o.lambda.re - e.lambda.re).abs() < 2.0 * o.lambda.im.max(e.lambda.im));
        note(pair, false, "half of a close pair that one FRF alone cannot tell from one mode".into());
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
        Some("fewer than two lines within the half-power bandwidth, prone to leakage: take the damping as an upper bound at")
    } else if e.misfit > 0.2 {
        Some("the line is not a resonance curve: the damping is indicative only at")
    } else {
        None
    };
    ((trust, reasons), damping)
}
