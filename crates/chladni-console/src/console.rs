//! What is said on stderr while a command runs: stages, warnings, notes.

use crate::args::Common;
use crate::next_step::option_for;
use crate::progress::Progress;
use chladni_frf::{printable, Finding, Severity};
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard};

/// Text whose words may come from a file or its name, with lines and tabs only.
pub fn for_terminal(text: &str) -> String {
    printable(text, &['\n', '\t'])
}

/// A finding with its next step, and the option that takes it.
fn told(finding: &Finding) -> String {
    match option_for(&finding.code) {
        Some(option) => format!("{finding} ({option})"),
        None => finding.to_string(),
    }
}

/// The user's wishes about output, and everything said so far.
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
    warnings: Mutex<Vec<String>>,
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
            colour: std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
                && std::io::stderr().is_terminal(),
            warnings: Mutex::default(),
            findings: Mutex::default(),
        }
    }

    /// A stage begins.
    pub fn stage(&self, name: &str) {
        self.progress.stage(name);
    }

    /// How far the stage is, 0 to 1, and how long it will still take.
    pub fn so_far(&self, done: f64, left: std::time::Duration) {
        self.progress.so_far(done, left);
    }

    /// A warning: on stderr now, and in the result later; the same words count once.
    pub fn warn(&self, warning: impl Into<String>) {
        let warning = warning.into();
        if self.said().contains(&warning) {
            return;
        }
        if !self.quiet {
            self.line("33", "warning: ", &warning);
        }
        self.said().push(warning);
    }

    /// Several warnings.
    pub fn warn_all(&self, warnings: impl IntoIterator<Item = String>) {
        warnings.into_iter().for_each(|warning| self.warn(warning));
    }

    /// Findings: faults first, then cautions, each with its next step; notes by their
    /// number, unless all is asked for. What was said before is not said again.
    pub fn find_all(&self, findings: &[Finding]) {
        let mut known = self
            .findings
            .lock()
            .expect("nothing panics while it is held");
        let mut new: Vec<&Finding> = findings
            .iter()
            .filter(|finding| !known.contains(finding) && !self.said().contains(&finding.text))
            .collect();
        new.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        let mut folded = 0;
        for finding in &new {
            if finding.severity > Severity::Note {
                self.said().push(finding.text.clone());
            }
            match finding.severity {
                _ if self.quiet => {}
                Severity::Note if !self.verbose => folded += 1,
                Severity::Note => self.line("", "note: ", &told(finding)),
                Severity::Caution => self.line("33", "warning: ", &told(finding)),
                Severity::Fault => self.line("31", "fault: ", &told(finding)),
            }
        }
        match folded {
            0 => {}
            1 => self.line("", "", "1 note: -v shows it"),
            count => self.line("", "", &format!("{count} notes: -v shows them")),
        }
        known.extend(new.into_iter().cloned());
    }

    /// All findings so far, in order.
    pub fn findings(&self) -> Vec<Finding> {
        self.findings
            .lock()
            .expect("nothing panics while it is held")
            .clone()
    }

    fn said(&self) -> MutexGuard<'_, Vec<String>> {
        self.warnings
            .lock()
            .expect("nothing panics while it is held")
    }

    /// All warnings so far, in order.
    pub fn warnings(&self) -> Vec<String> {
        self.said().clone()
    }

    /// Something good to know that belongs into no result.
    pub fn note(&self, note: &str) {
        if !self.quiet {
            self.line("", "", note);
        }
    }

    /// An error, always shown.
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

    /// Shows how long each stage took; nowhere else does a time appear.
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
