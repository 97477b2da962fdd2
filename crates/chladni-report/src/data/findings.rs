//! Findings of report, model and scenes, as the page lists them at its top.

use crate::input::ReportInput;
use chladni_frf::Finding;
use serde_json::{json, Value};
use std::cmp::Reverse;

/// The findings, faults first, then cautions, then notes.
pub(crate) fn all(input: &ReportInput) -> Vec<Value> {
    let mut all: Vec<(String, &Finding)> = Vec::new();
    // a finding that both a result and its file contain is listed once
    for (about, finding) in stated(input) {
        if !all.iter().any(|(_, known)| known.text == finding.text) {
            all.push((about, finding));
        }
    }
    all.sort_by_key(|(_, finding)| Reverse(finding.severity));
    all.iter()
        .map(|(about, finding)| {
            json!({
                "about": about,
                "code": finding.code,
                "severity": finding.severity,
                "modes": finding.modes,
                "text": finding.text,
                "help": finding.help,
            })
        })
        .collect()
}

/// Each finding with its subject (report, model, scene), in the order of the page.
fn stated<'a>(input: &'a ReportInput) -> Vec<(String, &'a Finding)> {
    let of_report = input
        .findings
        .iter()
        .map(|finding| ("Report".to_owned(), finding));
    let model = input.model.map(|model| model.quality.findings.as_slice());
    let of_model = model
        .unwrap_or_default()
        .iter()
        .map(|finding| ("Model".to_owned(), finding));
    let of_scenes = input.scenes.iter().zip(1..).flat_map(|(scene, number)| {
        let shown = scene.shown.map_or(&[][..], |shown| shown.findings);
        let findings = scene.weights.findings.iter().chain(shown);
        findings.map(move |finding| (format!("Scene {number}"), finding))
    });
    of_report.chain(of_model).chain(of_scenes).collect()
}
