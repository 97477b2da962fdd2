//! The outcome of a run of a program; the tests of `benches` use it too.

#![allow(dead_code)] // every test program uses its own part

use serde_json::Value;

/// Exit code and output of a run.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// Exit code and output of a process that has ended.
    pub fn of(output: std::process::Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            code: output.status.code().unwrap(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// The one JSON object on stdout.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| {
            panic!("{error} in {:?}; stderr {:?}", self.stdout, self.stderr)
        })
    }
    /// The text of stderr in one line, without the line breaks for a terminal.
    pub fn said(&self) -> String {
        self.stderr.split_whitespace().collect::<Vec<_>>().join(" ")
    }
    /// Checks the exit status.
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(
            self.code, code,
            "stdout {:?}, stderr {:?}",
            self.stdout, self.stderr
        );
        self
    }
}
