//! Commands and options for the next step after a finding or an error. Libraries know none.

use chladni_frf::{Error, Finding, Values};
use std::path::Path;

/// File of the proposed report.
const PAGE: &str = "report.html";

/// Advice of libraries, and the command that follows it.
const COMMANDS: [(&str, &str); 9] = [
    ("look at the contents of the file", "`chladni info FILE`"),
    (
        "in the order of the FRFs in the file",
        "`chladni info -v FILE` lists them",
    ),
    ("estimate FRFs first", "`chladni estimate`"),
    ("fit a model first", "`chladni fit FRF -o MODEL.json`"),
    (
        "in the order of the model",
        "`chladni fit` prints the numbers",
    ),
    ("drop this mode", "`chladni select`"),
    (
        "a calibration file of Chladni",
        "`chladni correct` writes one",
    ),
    ("a weights file of Chladni", "`chladni render` writes one"),
    ("pair DOFs by name", "`--pair-dofs name`"),
];

/// The error with the commands that follow its advice.
pub fn error_with_commands(error: Error) -> Error {
    let help = error.help.as_deref().map(with_commands);
    Error { help, ..error }
}

fn with_commands(advice: &str) -> String {
    COMMANDS
        .iter()
        .fold(advice.to_owned(), |advice, (words, command)| {
            advice.replace(words, &format!("{words} ({command})"))
        })
}

/// The command that makes a report of `files`, which are quoted for a shell.
pub fn report(files: &[String]) -> String {
    let force = match Path::new(PAGE).exists() {
        true => " --force",
        false => "",
    };
    format!("chladni report {} -o {PAGE}{force}", files.join(" "))
}

/// True where errors of the gains endanger a drive more than those of the panel.
pub fn is_of_gains(finding: &Finding) -> bool {
    let share = |name: &str| match finding.values.get(name) {
        Some(Values::One(share)) => *share,
        _ => 1.0,
    };
    share("amplifiers_alone") < share("frequencies_alone").min(share("finger_alone"))
}

/// The option, or the command, that helps with a finding.
pub fn option_for(finding: &Finding) -> Option<&'static str> {
    Some(match &*finding.code {
        "rig-sensitive" if is_of_gains(finding) => "chladni correct",
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
        "points-apart" => "--pair-dofs name",
        "origin-differs" => "--pair-dofs nearest",
        "quicker-method" => "--method robust",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_gets_its_commands_and_other_words_stay() {
        for (advice, expected) in [
            (
                "look at the contents of the file; estimate FRFs first",
                "look at the contents of the file (`chladni info FILE`); estimate FRFs first \
                 (`chladni estimate`)",
            ),
            (
                "fit a model first, or export the modes",
                "fit a model first (`chladni fit FRF -o MODEL.json`), or export the modes",
            ),
            ("split the file by kind", "split the file by kind"),
        ] {
            let error = Error::bad_data("no such data").help(advice);
            let told = error_with_commands(error).help;
            assert_eq!(told.as_deref(), Some(expected));
        }
    }

    #[test]
    fn gains_that_endanger_a_drive_are_corrected_and_the_panel_is_swept() {
        for (amplifiers, option) in [(0.0, "chladni correct"), (1.0, "--sweep LO:HI")] {
            let finding = Finding::caution("rig-sensitive", "few rigs")
                .value("amplifiers_alone", amplifiers)
                .value("frequencies_alone", 0.9)
                .value("finger_alone", 0.1);
            assert_eq!(option_for(&finding), Some(option));
        }
    }
}
