//! Grades: what a modal engineer would say of each pole, with the reasons.

use crate::model::Grade;
use crate::refine::Refined;
use crate::work::{basis, Work};
use chladni_frf::Trust;
use ndarray::Array2;
use num_complex::Complex64;

/// Evidence about one pole.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    /// Pole.
    pub lambda: Complex64,
    /// Part of the runs that found it.
    pub score: f64,
    /// |odd − even| over the half-width.
    pub odd_even: Option<f64>,
    /// Relative rise of the local sum of squares without it.
    pub gain: f64,
    /// The same without the two nearest lines.
    pub gain_without_nearest: f64,
    /// Standard deviation over the half-width.
    pub deviation: f64,
    /// Scatter of its own poles over the FRFs, over the half-width; `None` where there is one FRF.
    pub scatter: Option<f64>,
    /// Rms residual over rms modal part within 1.5 half-widths.
    pub misfit: f64,
    /// Modal part over the whole response at its peak (amplitudes).
    pub part: f64,
    /// Half-width in lines.
    pub half_width_lines: f64,
    /// Height of the response over the median of its surroundings, dB.
    pub stands_out_db: f64,
    /// Distance to the nearer band edge in half-widths.
    pub edge: f64,
}

/// Collects what the residual and the neighbourhood show, both without line weights (these would flatten the peaks); the
/// fields that need other runs are filled by the caller.
pub(crate) fn look(work: &Work, residual: &Array2<Complex64>, refined: &Refined, q: usize) -> Evidence {
    let lambda = refined.lambda[q];
    let window = work.window(lambda, 1.5, 2);
    let rows: Vec<usize> = window.collect();
    let local = work.select(&rows);
    let shape = basis(&local, &[lambda], &[]);
    let strength: f64 = refined.coefficients.row(q).iter().map(|v| v.norm_sqr()).sum();
    let modal: f64 = shape.iter().map(|v| v.norm_sqr()).sum::<f64>() * strength;
    let residual: f64 = rows.iter().map(|&k| residual.row(k).iter().map(|v| v.norm_sqr()).sum::<f64>()).sum();
    let response: f64 = local.b.iter().map(|v| v.norm_sqr()).sum();
    let spacing = work.spacing(lambda.re);
    let (low, high) = work.range();
    Evidence {
        lambda,
        score: 1.0,
        odd_even: None,
        gain: f64::MAX,
        gain_without_nearest: f64::MAX,
        deviation: 0.0,
        scatter: None,
        misfit: (residual / modal.max(1e-300)).sqrt(),
        part: (modal / response.max(1e-300)).sqrt(),
        half_width_lines: lambda.im / spacing,
        stands_out_db: stands_out(work, lambda),
        edge: (lambda.re - low).min(high - lambda.re) / lambda.im,
    }
}

/// Response at the pole over the median of the lines within 30 widths (at least 30 lines), dB.
fn stands_out(work: &Work, lambda: Complex64) -> f64 {
    let at = |k: usize| work.b.row(k).iter().map(|v| v.norm_sqr()).sum::<f64>();
    let near = work.window(lambda, 1.0, 1).map(at).fold(0.0, f64::max);
    let mut around: Vec<f64> = work.window(lambda, 60.0, 30).map(at).collect();
    around.sort_by(f64::total_cmp);
    let median = around.get(around.len() / 2).copied().unwrap_or(near);
    10.0 * (near.max(1e-300) / median.max(1e-300)).log10()
}

/// Median loss of the six modes nearest to candidate q among those that are `sure`; `None` below three.
pub(crate) fn usual_loss(all: &[Evidence], sure: &[bool], q: usize) -> Option<f64> {
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

/// Sees neighbours: `all` holds the evidence of every candidate in order of frequency, `level` its peak response in dB,
/// `usual_loss` the damping of the sure modes around it, once they are known.
pub(crate) fn grade(all: &[Evidence], level: &[f64], q: usize, frfs: usize, usual_loss: Option<f64>) -> (Grade, Option<&'static str>) {
    let e = &all[q];
    let mut reasons = Vec::new();
    let mut severe = 0;
    let mut note = |bad: bool, is_severe: bool, text: String| {
        if bad {
            severe += usize::from(is_severe);
            reasons.push(text);
        }
    };
    note(e.score < 0.75, false, format!("found by only {:.0} % of the model orders and line halves", 100.0 * e.score));
    note(e.misfit > 0.5, true, format!("the line shape misses the data by {:.0} % around the peak", 100.0 * e.misfit));
    if let Some(d) = e.odd_even {
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
        other != q && lines <= 4.0 && level[other] - level[q] > 8.0
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
