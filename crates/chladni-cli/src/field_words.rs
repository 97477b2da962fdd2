//! Sentences on a measured field: the limits that it keeps, and the likely causes of its
//! deviation from the prediction. Terminal and studio share them.

use crate::limits::EXPLAINED_NIS;
use chladni_console::table::significant;
use chladni_render::{FieldEvaluation, Ground, Hypothesis, Place};

/// The verdict on a measured field, and its likeliest cause.
pub fn sentence(judged: &FieldEvaluation) -> String {
    let count = |wanted: Ground| {
        let grounds = judged.measured.ground.iter();
        grounds.filter(|&&ground| ground == wanted).count()
    };
    let kept = |ground: Ground, ratio: f64| {
        let all = count(ground);
        format!("{:.0} of {all}", ratio * all as f64)
    };
    let points = &judged.indices.points;
    let verdict = match points.min_ratio < 1.0 {
        true => "misses",
        false => "keeps",
    };
    let said = |code: &str| judged.findings.iter().any(|f| f.code == code);
    let cause = match judged.agreement.hypotheses.first() {
        _ if said("field-level-off") => " Its level is far off: look at its unit.".into(),
        _ if said("channels-swapped") => " Likeliest cause: two cables are swapped.".into(),
        Some(likeliest) if !is_explained(judged) => {
            format!(" Likeliest cause: {}.", cause(likeliest))
        }
        _ => " The error bars explain its deviation from the prediction.".into(),
    };
    format!(
        "The measured field {verdict} the scene: {} hot felt, {} cold quiet.{cause}",
        kept(Ground::Hot, points.hot_ratio),
        kept(Ground::Cold, points.cold_ratio),
    )
}

/// The deviation from the prediction in numbers.
pub fn deviation(judged: &FieldEvaluation) -> String {
    let agreement = &judged.agreement;
    let phase = agreement
        .phase_deg
        .map_or(String::new(), |phase| format!(", phase {phase:+.1}°"));
    let word = match is_explained(judged) {
        true => "the error bars explain it",
        false => "more than the error bars explain",
    };
    format!(
        "against the prediction: level {:+.2} dB{phase}, agreement {:.4} (1 is perfect); \
         deviation over expected {} ({word})",
        agreement.level_db,
        agreement.coefficient,
        significant(agreement.nis, 2),
    )
}

fn is_explained(judged: &FieldEvaluation) -> bool {
    judged.agreement.nis <= EXPLAINED_NIS
}

/// A cause in words, with its place and size.
pub fn cause(cause: &Hypothesis) -> String {
    let channel = |words: &str| match cause.place {
        Some(Place::Channel(dof)) => format!("channel {dof} {words}"),
        _ => format!("a channel {words}"),
    };
    let percent = |part: f64| format!("{:+.2} %", 100.0 * part);
    let [re, im] = cause.value.unwrap_or_default();
    let factor = format!("{:.3}{im:+.3}j", 1.0 + re);
    match cause.kind.as_str() {
        "nothing" => "no error of the rig".into(),
        "gain" => format!("all channels have the factor {factor}"),
        "dead" => channel("gives no force"),
        "reversed" => channel("has the wrong sign"),
        "channel" => channel(&format!("has the factor {factor}")),
        "channels" => format!("the channels' gains are off by {:.1} % rms", 100.0 * re),
        "mode" => match cause.place {
            Some(Place::Mode(hz)) => format!("the mode at {hz:.1} Hz has shifted by {}", percent(re)),
            _ => format!("a mode has shifted by {}", percent(re)),
        },
        "modes" => format!("all natural frequencies have shifted by {}", percent(re)),
        "load" => match cause.place {
            Some(Place::Point([x, y])) => format!(
                "something touches the panel at x = {:.0} mm, y = {:.0} mm ({re:.2}{im:+.2}j N s/m)",
                1e3 * x,
                1e3 * y
            ),
            _ => "something touches the panel".into(),
        },
        _ => "none of the known errors".into(),
    }
}
