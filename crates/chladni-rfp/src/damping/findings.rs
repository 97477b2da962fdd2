//! The findings on the damping law.

use chladni_frf::{Damping, Finding};

/// The finding where neither free residues nor common shapes decide; `most`: the largest
/// [`crate::damping::verdict::shift`].
pub(crate) fn undecidable(taken: Damping, most: f64) -> Finding {
    Finding::note(
        "law-undecidable",
        format!(
            "damping law undecidable: structural and viscous damping explain these data equally \
             well; the numbers follow the {} law, and the error bars hold both (frequencies under the \
             other one differ by about η²/4, up to {most:.0} error bars of noise)",
            name(taken)
        ),
    )
    .value("shift_over_error_bar", most)
    .help("say which law holds, if you know it")
}

/// The finding where phases and shapes speak for different laws; `most`: the largest [`crate::damping::verdict::shift`].
pub(crate) fn disputed(taken: Damping, most: f64) -> Finding {
    Finding::note(
        "law-undecidable",
        format!(
            "damping law undecidable: the phases of the residues speak for {} damping, but one \
             shape per mode holds only under {} damping; the numbers follow the latter, and the \
             error bars hold both (frequencies differ by about η²/4, up to {most:.0} error bars of \
             noise)",
            name(taken.other()),
            name(taken)
        ),
    )
    .value("shift_over_error_bar", most)
    .help("say which law holds, if you know it")
}

/// The finding where only the phases as they were measured decide.
pub(crate) fn if_phases_true(taken: Damping, degrees: f64) -> Finding {
    Finding::note(
        "law-if-phases-true",
        format!(
            "the damping law rests on the phases of the FRFs: {}, unless all of them share an \
             error of {degrees:.2} degrees, which would pass for the other law",
            name(taken)
        ),
    )
    .value("phase_error_deg", degrees)
    .help("say which law holds, if you know it")
}

/// The finding on a law that the data contradict; `degrees`: only if phases are true to
/// better than this.
pub(crate) fn contradicted(asked: Damping, degrees: Option<f64>) -> Finding {
    let (own, other) = match asked {
        Damping::Structural => (name(asked), name(Damping::Viscous)),
        Damping::Viscous => (name(asked), name(Damping::Structural)),
    };
    let condition = degrees.map_or(String::new(), |degrees| {
        format!(", if phases are true to better than {degrees:.2} degrees")
    });
    Finding::caution(
        "law-contradicted",
        format!(
            "the data contradict the {own} damping that was asked for{condition}: {other} damping \
             explains them better than noise allows; frequencies and loss factors are off by more \
             than their error bars"
        ),
    )
    .help("let the data choose the law")
}

fn name(damping: Damping) -> &'static str {
    match damping {
        Damping::Structural => "structural",
        Damping::Viscous => "viscous",
    }
}
