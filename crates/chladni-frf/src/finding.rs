//! Findings: facts that a user should know about data or a result, as data instead of
//! prose.
//!
//! Libraries make them and know no command-line flag; a front end groups them by code and
//! adds the next step in its own words. Every code has its paragraph in
//! `docs/troubleshooting.md`.

use crate::limits::SAME_MODE;
use crate::Dof;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::{Deref, DerefMut};

/// Code of a sentence that a file of an earlier version holds without a code.
const UNCODED: &str = "earlier-version";

/// Name under which the frequencies of the modes concerned stand in
/// [`Finding::values`].
pub const MODES_HZ: &str = "modes_hz";

/// Weight of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Severity {
    /// Good to know; nothing need be done.
    Note,
    /// Part of the result should be looked at before it is used.
    Caution,
    /// The result as a whole is not to be used as it is.
    Fault,
}

impl Severity {
    /// The word in files and on screens.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Caution => "caution",
            Self::Fault => "fault",
        }
    }
}

/// A value of a finding, or a list of them; the name says the unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Values {
    /// One number.
    One(f64),
    /// Several numbers.
    Many(Vec<f64>),
}

impl Values {
    /// The numbers.
    pub fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(value) => std::slice::from_ref(value),
            Self::Many(values) => values,
        }
    }
}

/// One fact that a user should know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Kebab-case, stable, anchor in `docs/troubleshooting.md`.
    pub code: Cow<'static, str>,
    /// Its weight.
    pub severity: Severity,
    /// Modes it is about, counted from 1 as in the table of modes.
    #[serde(default)]
    pub modes: Vec<usize>,
    /// DOFs it is about.
    #[serde(default)]
    pub dofs: Vec<Dof>,
    /// Numbers behind the sentence, with their unit in the name.
    #[serde(default)]
    pub values: BTreeMap<Cow<'static, str>, Values>,
    /// The finding itself, one sentence.
    pub text: String,
    /// The next step; empty where there is nothing to do.
    #[serde(default)]
    pub help: Cow<'static, str>,
}

impl Finding {
    /// A finding without numbers and without a next step.
    pub fn new(severity: Severity, code: &'static str, text: impl Into<String>) -> Self {
        Self {
            code: code.into(),
            severity,
            modes: Vec::new(),
            dofs: Vec::new(),
            values: BTreeMap::new(),
            text: text.into(),
            help: "".into(),
        }
    }

    /// Good to know.
    pub fn note(code: &'static str, text: impl Into<String>) -> Self {
        Self::new(Severity::Note, code, text)
    }

    /// To be looked at.
    pub fn caution(code: &'static str, text: impl Into<String>) -> Self {
        Self::new(Severity::Caution, code, text)
    }

    /// Not to be used as it is.
    pub fn fault(code: &'static str, text: impl Into<String>) -> Self {
        Self::new(Severity::Fault, code, text)
    }

    /// The same with its next step.
    pub fn help(self, help: impl Into<Cow<'static, str>>) -> Self {
        Self {
            help: help.into(),
            ..self
        }
    }

    /// The same with a number; one that is not finite is left out.
    pub fn value(mut self, name: &'static str, value: f64) -> Self {
        if value.is_finite() {
            self.values.insert(name.into(), Values::One(value));
        }
        self
    }

    /// The same with a list of numbers.
    pub fn list(mut self, name: &'static str, values: impl IntoIterator<Item = f64>) -> Self {
        let finite = values.into_iter().filter(|value| value.is_finite());
        self.values
            .insert(name.into(), Values::Many(finite.collect()));
        self
    }

    /// The same about modes at these frequencies, which [`numbered`] turns into mode
    /// numbers.
    pub fn modes_hz(self, frequencies: impl IntoIterator<Item = f64>) -> Self {
        self.list(MODES_HZ, frequencies)
    }

    /// The same about DOFs.
    pub fn dofs(self, dofs: impl IntoIterator<Item = Dof>) -> Self {
        Self {
            dofs: dofs.into_iter().collect(),
            ..self
        }
    }

    /// The same, with what it is about before its sentence.
    pub fn about(&self, what: impl fmt::Display) -> Self {
        Self {
            text: format!("{what}: {}", self.text),
            ..self.clone()
        }
    }

    /// True where text or next step contain these words.
    pub fn contains(&self, words: &str) -> bool {
        self.text.contains(words) || self.help.contains(words)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        if !self.help.is_empty() {
            write!(f, "; {}", self.help)?;
        }
        Ok(())
    }
}

/// A sentence of a file that knows no codes.
impl From<String> for Finding {
    fn from(text: String) -> Self {
        Self::caution(UNCODED, text)
    }
}

/// The sentences of all cautions and faults, several of one code in one.
pub fn warnings(findings: &[Finding]) -> Vec<String> {
    let mut by_code: Vec<(&str, String)> = Vec::new();
    for finding in findings.iter().filter(|f| f.severity > Severity::Note) {
        let coded = finding.code != UNCODED;
        match by_code
            .iter_mut()
            .find(|(code, _)| coded && *code == finding.code)
        {
            Some((_, text)) => *text += &format!("; {}", finding.text),
            None => by_code.push((&finding.code, finding.text.clone())),
        }
    }
    by_code.into_iter().map(|(_, text)| text).collect()
}

/// Gives the findings the numbers of the modes at their frequencies; `frequencies_hz`: of
/// the modes that count, in the order of the table.
pub fn numbered(findings: &mut [Finding], frequencies_hz: &[f64]) {
    for finding in findings {
        let Some(concerned) = finding.values.get(MODES_HZ) else {
            continue;
        };
        let nearest = |&place: &f64| {
            let off = |n: usize| (frequencies_hz[n] - place).abs();
            (0..frequencies_hz.len())
                .min_by(|&a, &b| off(a).total_cmp(&off(b)))
                .filter(|&n| off(n) <= SAME_MODE * place.abs())
        };
        let mut numbers: Vec<usize> = concerned
            .as_slice()
            .iter()
            .filter_map(nearest)
            .map(|n| n + 1)
            .collect();
        numbers.dedup();
        finding.modes = numbers;
    }
}

/// One reason why a mode is not sure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reason {
    /// Kebab-case, stable, anchor in `docs/troubleshooting.md`.
    pub code: Cow<'static, str>,
    /// The doubt, in the same words for every mode.
    pub text: Cow<'static, str>,
    /// Its size for this mode; empty where there is no number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub detail: String,
}

impl Reason {
    /// A reason without a number.
    pub fn new(code: &'static str, text: &'static str) -> Self {
        Self {
            code: code.into(),
            text: text.into(),
            detail: String::new(),
        }
    }

    /// The same with its number.
    pub fn detail(self, detail: impl Into<String>) -> Self {
        Self {
            detail: detail.into(),
            ..self
        }
    }

    /// True where the reason in words contains these.
    pub fn contains(&self, words: &str) -> bool {
        self.to_string().contains(words)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        if !self.detail.is_empty() {
            write!(f, " ({})", self.detail)?;
        }
        Ok(())
    }
}

/// The reasons of a mode. Files hold them twice: `reasons` as sentences, `doubts` with
/// their codes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "ReasonLists", into = "ReasonLists")]
pub struct Reasons(pub Vec<Reason>);

#[derive(Serialize, Deserialize)]
struct ReasonLists {
    reasons: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    doubts: Vec<Reason>,
}

impl Reasons {
    /// The reasons as sentences.
    pub fn sentences(&self) -> Vec<String> {
        self.iter().map(ToString::to_string).collect()
    }

    /// The reasons that a file holds: with codes, or without where it is of an earlier
    /// version or was edited by hand.
    pub fn of_file(sentences: Vec<String>, coded: Vec<Reason>) -> Self {
        let coded = Self(coded);
        if coded.sentences() == sentences {
            return coded;
        }
        let uncoded = |text: String| Reason {
            code: UNCODED.into(),
            text: text.into(),
            detail: String::new(),
        };
        Self(sentences.into_iter().map(uncoded).collect())
    }
}

impl Deref for Reasons {
    type Target = Vec<Reason>;
    fn deref(&self) -> &Vec<Reason> {
        &self.0
    }
}

impl DerefMut for Reasons {
    fn deref_mut(&mut self) -> &mut Vec<Reason> {
        &mut self.0
    }
}

impl From<Vec<Reason>> for Reasons {
    fn from(reasons: Vec<Reason>) -> Self {
        Self(reasons)
    }
}

impl From<ReasonLists> for Reasons {
    fn from(lists: ReasonLists) -> Self {
        Self::of_file(lists.reasons, lists.doubts)
    }
}

impl From<Reasons> for ReasonLists {
    fn from(reasons: Reasons) -> Self {
        Self {
            reasons: reasons.sentences(),
            doubts: reasons.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_are_the_sentences_of_cautions_and_faults_by_code() {
        let findings = [
            Finding::caution("peak", "a peak at 3 Hz"),
            Finding::note("unscaled", "not scaled"),
            Finding::fault("sign", "wrong sign").help("turn it"),
            Finding::caution("peak", "a peak at 5 Hz"),
            Finding::from("old words".to_owned()),
            Finding::from("other old words".to_owned()),
        ];
        assert_eq!(
            warnings(&findings),
            [
                "a peak at 3 Hz; a peak at 5 Hz",
                "wrong sign",
                "old words",
                "other old words"
            ]
        );
    }

    #[test]
    fn findings_take_the_numbers_of_the_modes_at_their_frequencies() {
        let mut findings = [Finding::caution("few", "few lines").modes_hz([52.01, 300.0])];
        numbered(&mut findings, &[52.0, 144.0]);
        assert_eq!(findings[0].modes, [1]);
    }

    #[test]
    fn reasons_keep_their_codes_and_those_of_earlier_files_are_read() {
        let reasons = Reasons(vec![
            Reason::new("tone", "a tone"),
            Reason::new("uncertain", "uncertain").detail("0.5 half-bandwidths"),
        ]);
        let json = serde_json::to_string(&reasons).unwrap();
        assert!(
            json.starts_with(r#"{"reasons":["a tone","uncertain (0.5 half-bandwidths)"]"#),
            "{json}"
        );
        assert_eq!(serde_json::from_str::<Reasons>(&json).unwrap(), reasons);
        let old: Reasons = serde_json::from_str(r#"{"reasons":["background"]}"#).unwrap();
        assert_eq!(old.sentences(), ["background"]);
        assert_eq!(old[0].code, UNCODED);
    }
}
