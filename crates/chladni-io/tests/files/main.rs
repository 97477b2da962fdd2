//! Readers and writers, checked with hand-made bytes and files of other programs.

mod arrays;
mod assemble;
mod csv;
mod documentation;
mod hdf5;
mod hdf5_foreign;
#[cfg(not(feature = "system"))]
mod hdf5_own;
mod layouts;
mod model_file;
mod parts;
mod selection;
mod uff;

/// Reports what a test leaves out, past the test harness, which would hide it.
fn skipped(what: &str) {
    use std::io::Write;
    drop(writeln!(std::io::stderr(), "skipped: {what}"));
}

/// Findings in words, with their next steps.
fn words(findings: &[chladni_frf::Finding]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}
