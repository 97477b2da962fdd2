//! Tests that read the sources: every finding has a paragraph in docs/troubleshooting.md under
//! its code, and no library names an option.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../../../docs/troubleshooting.md");
/// Calls whose first text is a code.
const CODED: [&str; 7] = [
    "Finding::note(",
    "Finding::caution(",
    "Finding::fault(",
    "Finding::new(",
    "Reason::new(",
    "Rule::doubt(",
    "Rule::severe(",
];
/// Code of findings in files of earlier versions, which had no codes.
const UNCODED: &str = "earlier-version";
/// Crates that make findings.
const CRATES: [&str; 9] = [
    "chladni-frf",
    "chladni-io",
    "chladni-signal",
    "chladni-rfp",
    "chladni-render",
    "chladni-plate",
    "chladni-report",
    "chladni-console",
    "chladni-cli",
];
/// Crates without options of the command line.
const LIBRARIES: [&str; 9] = [
    "chladni-frf",
    "chladni-io",
    "chladni-linalg",
    "chladni-plate",
    "chladni-render",
    "chladni-report",
    "chladni-rfp",
    "chladni-signal",
    "chladni-text",
];

fn rust_files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
    {
        if entry.is_dir() {
            rust_files(&entry, out);
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            out.push(entry);
        }
    }
}

/// The first literal text among the arguments of a call, as it is printed.
fn first_literal(call: &str) -> Option<String> {
    let mut depth = 1;
    for (at, letter) in call.char_indices() {
        match letter {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            ';' => return None,
            '"' => return Some(unquoted(&call[at + 1..])),
            _ => {}
        }
        if depth == 0 {
            return None;
        }
    }
    None
}

fn unquoted(rest: &str) -> String {
    let mut out = String::new();
    let mut letters = rest.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' => break,
            '\\' if letters.peek() == Some(&'\n') => {
                while letters.next_if(|next| next.is_whitespace()).is_some() {}
            }
            '\\' => out.extend(letters.next()),
            plain => out.push(plain),
        }
    }
    out
}

/// The sources of a crate without their tests.
fn sources(name: &str) -> Vec<String> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut files = Vec::new();
    rust_files(&crates.join(name).join("src"), &mut files);
    let without_tests = |file: &PathBuf| {
        let text = std::fs::read_to_string(file).unwrap();
        text.split("#[cfg(test)]").next().unwrap().to_owned()
    };
    files.iter().map(without_tests).collect()
}

#[test]
fn every_code_has_its_paragraph_and_every_paragraph_its_code() {
    let mut codes = BTreeSet::from([UNCODED.to_owned()]);
    for source in CRATES.iter().flat_map(|name| sources(name)) {
        for call in CODED {
            codes.extend(
                source
                    .match_indices(call)
                    .filter_map(|(at, _)| first_literal(&source[at + call.len()..])),
            );
        }
    }
    assert!(codes.len() > 150, "{codes:?}");
    let anchors: Vec<&str> = PAGE
        .split("<a id=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    let once: BTreeSet<String> = anchors.iter().map(|&code| code.to_owned()).collect();
    assert_eq!(once.len(), anchors.len(), "an anchor occurs twice");
    assert_eq!(codes, once, "codes of the sources, anchors of the page");
}

#[test]
fn no_library_names_an_option_of_the_command_line() {
    let names_one = |line: &str| {
        line.match_indices("--").any(|(at, _)| {
            let (before, after) = (&line[..at], &line[at + 2..]);
            // dashes of tables, comments of HTML and variables of style sheets are no options
            let is_inside = |c: char| c == '-' || c == '<' || c.is_alphanumeric();
            after.starts_with(|c: char| c.is_ascii_lowercase())
                && !before.ends_with(is_inside)
                && !before.ends_with("var(")
        })
    };
    let sources: Vec<String> = LIBRARIES.iter().flat_map(|name| sources(name)).collect();
    let lines = sources.iter().flat_map(|source| source.lines());
    let named: Vec<&str> = lines.filter(|line| names_one(line)).collect();
    assert!(named.is_empty(), "{}", named.join("\n"));
    assert!(names_one("/// `--band`: the band.") && !names_one("var(--ink)"));
}
