//! Messages on stderr while a command runs: stages, warnings, notes.

use crate::args::Common;
use crate::progress::Progress;
use crate::settings::finding_with_options;
use crate::telling;
use chladni_frf::{printable, Finding, Severity};
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard};

/// Text without control characters other than line breaks and tabs, since parts of it may come
/// from a file or its name.
pub fn for_terminal(text: &str) -> String {
    printable(text, &['\n', '\t'])
}

/// Messages to the user, as the common options ask for, and the findings so far.
pub struct Console {
    /// `--json`.
    pub json: bool,
    /// `--quiet`.
    pub quiet: bool,
    /// `--verbose`.
    pub verbose: bool,
    /// `--force`.
    pub force: bool,
    progress: Progress,
    colour: bool,
    findings: Mutex<Vec<Finding>>,
}

impl Console {
    /// A console for these options.
    pub fn new(common: &Common) -> Self {
        Self {
            json: common.json,
            quiet: common.quiet,
            verbose: common.verbose > 0,
            force: common.force,
            progress: Progress::new(common.progress, common.quiet),
            colour: !common.no_color
                && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
                && std::io::stderr().is_terminal(),
            findings: Mutex::default(),
        }
    }

    /// Begins a stage.
    pub fn stage(&self, name: &str) {
        self.progress.stage(name);
    }

    /// Shows the part of the stage that is done, 0 to 1, and the time that is left.
    pub fn so_far(&self, done: f64, left: std::time::Duration) {
        self.progress.so_far(done, left);
    }

    /// Adds a finding unless it is known already. All are told at the end.
    pub fn find(&self, finding: &Finding) {
        let finding = finding_with_options(finding);
        let mut known = self.known();
        if !known.contains(&finding) {
            known.push(finding);
        }
    }

    /// Adds several findings.
    pub fn find_all<'a>(&self, findings: impl IntoIterator<Item = &'a Finding>) {
        findings.into_iter().for_each(|finding| self.find(finding));
    }

    /// All findings so far, in order.
    pub fn findings(&self) -> Vec<Finding> {
        self.known().clone()
    }

    /// The sentences of all cautions and faults so far.
    pub fn warnings(&self) -> Vec<String> {
        chladni_frf::warnings(&self.known())
    }

    fn known(&self) -> MutexGuard<'_, Vec<Finding>> {
        self.findings
            .lock()
            .expect("nothing panics while it is held")
    }

    /// Tells the findings on stderr: by code, faults first; notes are only counted without
    /// `--verbose`.
    pub fn tell(&self) {
        if self.quiet {
            return;
        }
        for told in telling::told(&self.known(), self.verbose) {
            let colour = match told.severity {
                Some(Severity::Fault) => "31",
                Some(Severity::Caution) => "33",
                _ => "",
            };
            let label = told.severity.map_or(String::new(), telling::label);
            self.line(colour, &label, &told.text);
        }
    }

    /// Prints a remark that belongs to no result.
    pub fn note(&self, note: &str) {
        if !self.quiet {
            self.line("", "", note);
        }
    }

    /// Prints an error, with `--quiet` too.
    pub fn error(&self, message: &str) {
        self.line("1;31", "error: ", message);
    }

    /// Ends the progress display.
    pub fn finish(&self) {
        self.progress.finish();
        if self.verbose {
            self.times();
        }
    }

    /// Prints the time of each stage. No other output contains a time.
    pub fn times(&self) {
        for (name, seconds) in self.progress.take_times() {
            self.note(&format!("{seconds:8.2} s  {name}"));
        }
    }

    fn line(&self, colour: &str, prefix: &str, text: &str) {
        let (start, end) = if self.colour && !colour.is_empty() {
            (format!("\x1b[{colour}m"), "\x1b[0m")
        } else {
            (String::new(), "")
        };
        let text = for_terminal(text);
        // a closed stderr must not stop the work
        self.progress
            .suspend(|| drop(writeln!(std::io::stderr(), "{start}{prefix}{end}{text}")));
    }
}
