//! Readers, writers and what they keep, against hand-made bytes and other tools' files.

mod arrays;
mod assemble;
mod csv;
mod documentation;
mod hdf5;
mod hdf5_foreign;
mod layouts;
mod model_file;
mod selection;
mod uff;

/// Says what a test leaves out. Written past the test harness, which would keep it to
/// itself.
fn skipped(what: &str) {
    use std::io::Write;
    drop(writeln!(std::io::stderr(), "skipped: {what}"));
}

/// Findings in words, with their next steps.
fn words(findings: &[chladni_frf::Finding]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}
