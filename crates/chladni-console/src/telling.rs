//! Findings on a terminal: one paragraph for each code, faults first.

use crate::limits::{COLUMNS, INDENT, MOST_WITH_HELP};
use crate::next_step::option_for;
use crate::table::counted;
use chladni_frf::{Finding, Severity};
use std::cmp::Reverse;

/// Notes that ask the user how the data were measured: they are always shown in full.
const QUESTIONS: [&str; 1] = ["more-references"];

/// Findings that the first sentence of a result contains already.
const SAID: [&str; 1] = ["mostly-unexplained"];

/// A paragraph for the terminal.
#[derive(Debug, PartialEq)]
pub(crate) struct Told {
    /// Severity of the finding; `None` for a line about all notes.
    pub severity: Option<Severity>,
    /// The text in lines that fit beside the severity.
    pub text: String,
}

/// One paragraph for the findings of each code, faults first. Notes are only counted, unless
/// `verbose` or they ask something.
pub(crate) fn told(findings: &[Finding], verbose: bool) -> Vec<Told> {
    let mut groups: Vec<Vec<&Finding>> = Vec::new();
    let is_said = |finding: &&Finding| !verbose && SAID.contains(&&*finding.code);
    for finding in findings.iter().filter(|finding| !is_said(finding)) {
        match groups.iter_mut().find(|group| alike(group[0], finding)) {
            Some(group) if !verbose => group.push(finding),
            _ => groups.push(vec![finding]),
        }
    }
    groups.sort_by_key(|group| Reverse(group[0].severity));
    let asks = |finding: &Finding| QUESTIONS.contains(&&*finding.code);
    let is_shown =
        |group: &&Vec<&Finding>| verbose || group[0].severity > Severity::Note || asks(group[0]);
    let folded: usize = groups
        .iter()
        .filter(|group| !is_shown(group))
        .map(Vec::len)
        .sum();
    let is_caution = |group: &&Vec<&Finding>| group[0].severity == Severity::Caution;
    let many = !verbose && groups.iter().filter(is_caution).count() > MOST_WITH_HELP;
    let mut paragraphs: Vec<Told> = groups
        .iter()
        .filter(is_shown)
        .map(|group| Told {
            severity: Some(group[0].severity),
            text: wrapped(&sentence(group, verbose, !(many && is_caution(&group)))),
        })
        .collect();
    let left_out: Vec<String> = [
        many.then(|| "next steps".to_owned()),
        (folded > 0).then(|| counted(folded, "note")),
    ]
    .into_iter()
    .flatten()
    .collect();
    if !left_out.is_empty() {
        let them = if folded == 1 && !many { "it" } else { "them" };
        paragraphs.push(Told {
            severity: None,
            text: format!("{}: -v shows {them}", left_out.join(", ")),
        });
    }
    paragraphs
}

fn alike(a: &Finding, b: &Finding) -> bool {
    (&a.code, a.severity) == (&b.code, b.severity)
}

/// The first finding of the group, the number of the others, and with `help` the next step. A
/// step that names an option is always shown.
fn sentence(group: &[&Finding], verbose: bool, help: bool) -> String {
    let first = group[0];
    let mut sentence = first.text.clone();
    if group.len() > 1 {
        sentence += &format!(" (and {} more like it: -v)", group.len() - 1);
    }
    if verbose && !first.modes.is_empty() {
        let modes: Vec<String> = first.modes.iter().map(usize::to_string).collect();
        let noun = if modes.len() == 1 { "mode" } else { "modes" };
        sentence += &format!(" [{noun} {}]", modes.join(", "));
    }
    let is_option = first.help.contains("--");
    if (help || is_option) && !first.help.is_empty() {
        sentence += &format!("; {}", first.help);
    }
    match option_for(first) {
        Some(option) => sentence + &format!(" ({option})"),
        None => sentence,
    }
}

/// The text in lines that leave room for the severity; words are never cut.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for paragraph in text.lines() {
        for word in paragraph.split_whitespace() {
            let line = lines.last_mut().expect("there is at least one line");
            let width = line.chars().count() + 1 + word.chars().count();
            if !line.is_empty() && width > COLUMNS - INDENT {
                lines.push(word.to_owned());
            } else {
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
        }
    }
    lines.join(&format!("\n{}", " ".repeat(INDENT)))
}

/// The severity before a finding, padded.
pub(crate) fn label(severity: Severity) -> String {
    format!("{:INDENT$}", severity.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_of_one_code_are_one_paragraph_and_faults_come_first() {
        let findings = [
            Finding::note("a", "a note"),
            Finding::caution("zero", "file a: zero pairs").help("nothing"),
            Finding::caution("zero", "file b: zero pairs"),
            Finding::fault("kind", "wrong kind"),
            Finding::note("b", "another note"),
        ];
        let texts = |verbose| -> Vec<String> {
            let all = told(&findings, verbose).into_iter();
            all.map(|told| told.text).collect()
        };
        assert_eq!(
            texts(false),
            [
                "wrong kind",
                "file a: zero pairs (and 1 more like it: -v); nothing",
                "2 notes: -v shows them"
            ]
        );
        assert_eq!(texts(true).len(), 5);
    }

    #[test]
    fn long_sentences_are_wrapped_beside_their_word() {
        let finding = [Finding::caution("long", "word ".repeat(40))];
        let told = told(&finding, false).remove(0);
        let lines: Vec<&str> = told.text.lines().collect();
        assert!(lines.len() == 3 && lines[1].starts_with("         word"));
        assert!(lines.iter().all(|line| line.len() <= 80), "{lines:?}");
    }

    #[test]
    fn of_many_cautions_the_sentences_are_shown_and_the_steps_of_faults() {
        let findings = [
            Finding::fault("kind", "wrong kind").help("say it"),
            Finding::caution("a", "first").help("do this"),
            Finding::caution("b", "second").help("do that"),
            Finding::caution("c", "third").help("say --it"),
            Finding::note("d", "a note"),
        ];
        let texts = |findings: &[Finding], verbose| -> Vec<String> {
            let all = told(findings, verbose).into_iter();
            all.map(|told| told.text).collect()
        };
        assert_eq!(
            texts(&findings, false),
            [
                "wrong kind; say it",
                "first",
                "second",
                "third; say --it",
                "next steps, 1 note: -v shows them"
            ]
        );
        assert_eq!(texts(&findings, true)[1], "first; do this");
        assert_eq!(texts(&findings[..3], false)[1], "first; do this");
    }

    #[test]
    fn a_note_that_asks_is_shown_and_the_others_are_counted() {
        let findings = [
            Finding::note("a", "a note"),
            Finding::note("more-references", "more references than responses"),
        ];
        let told = told(&findings, false);
        assert_eq!(told[0].text, "more references than responses");
        assert_eq!(told[1].text, "1 note: -v shows it");
    }
}
