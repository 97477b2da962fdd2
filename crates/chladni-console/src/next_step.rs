//! Options of the command line that take the next step of a finding. Libraries know none.

/// The option that helps with findings of this code.
pub fn option_for(code: &str) -> Option<&'static str> {
    Some(match code {
        "conjugated" | "negative-damping" => "--time-sign -",
        "wrong-kind" => "--frf-kind",
        "mostly-unexplained" | "band-edge" => "--band LO:HI",
        "law-undecidable" | "law-if-phases-true" => "--damping structural or viscous",
        "law-contradicted" => "leave --damping out",
        "more-modes" => "leave --modes out",
        "no-peak" => "--modes N",
        "order-too-high" => "--method auto",
        "window-bias" | "window-found" => "--window hann, rectangular, none or another one",
        "window-modelled" => "--window none",
        "decays-not-windowed" => "--exponential-window",
        "mode-on-drive" | "rig-sensitive" => "--sweep LO:HI",
        "ground-between" | "too-few-actuators" => "--actuators",
        "quicker-method" => "--method robust",
        "replayed-worse" => "--modes",
        _ => return None,
    })
}
