//! Every finding of the code has its paragraph in docs/troubleshooting.md, under its code,
//! and every sentence without a code an entry: the sources are read for what they say.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../../../docs/troubleshooting.md");
/// What hands a warning or a mode's doubt on.
const CALLS: [&str; 4] = [
    "warnings.push(",
    ".warn(",
    "notes.push(",
    "let words = format!(",
];
/// Calls whose first text is a code.
const CODED: [&str; 5] = [
    "Finding::note(",
    "Finding::caution(",
    "Finding::fault(",
    "Finding::new(",
    "Reason::new(",
];
/// Code of sentences that files of earlier versions hold.
const UNCODED: &str = "earlier-version";
/// Crates whose sentences have no codes yet.
const CRATES: [&str; 7] = [
    "chladni-text",
    "chladni-io",
    "chladni-signal",
    "chladni-console",
    "chladni-render",
    "chladni-plate",
    "chladni-cli",
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

/// The first text in quotation marks before the call's own end, as it is printed.
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

/// The longest piece between inserted values.
fn longest_piece(text: &str) -> String {
    let mut pieces = vec![String::new()];
    let mut inside = false;
    for letter in text.chars() {
        match letter {
            '{' => inside = true,
            '}' => {
                inside = false;
                pieces.push(String::new());
            }
            _ if inside => {}
            plain => pieces.last_mut().unwrap().push(plain),
        }
    }
    let trimmed = pieces.iter().map(|piece| {
        piece
            .trim_matches([' ', ':', ';', ',', '(', ')', '%'])
            .to_owned()
    });
    trimmed.max_by_key(|piece| piece.len()).unwrap_or_default()
}

/// Without what only formatting adds.
fn plain(text: &str) -> String {
    text.replace(['`', '\\'], "").to_lowercase()
}

#[test]
fn every_warning_of_the_code_has_an_entry() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut files = Vec::new();
    CRATES
        .iter()
        .for_each(|name| rust_files(&crates.join(name).join("src"), &mut files));
    let page = plain(PAGE);
    let (mut seen, mut missing) = (0, Vec::new());
    for file in files {
        let source = std::fs::read_to_string(&file).unwrap();
        let source = source.split("#[cfg(test)]").next().unwrap();
        for call in CALLS {
            for (at, _) in source.match_indices(call) {
                // a rewritten error is no new one
                let Some(text) = first_literal(&source[at + call.len()..])
                    .filter(|text| !text.contains("help:"))
                else {
                    continue;
                };
                let piece = plain(&longest_piece(&text));
                // a frame around another warning says nothing of its own
                if piece.split_whitespace().count() < 2 {
                    continue;
                }
                seen += 1;
                // half a sentence is enough to find it by
                let words: Vec<&str> = piece.split(' ').collect();
                let found = page.contains(&piece)
                    || words
                        .windows(5.min(words.len()))
                        .any(|five| page.contains(&five.join(" ")));
                if !found {
                    missing.push(format!(
                        "{}: {text}",
                        file.strip_prefix(crates).unwrap().display()
                    ));
                }
            }
        }
    }
    assert!(
        seen > 60,
        "only {seen} warnings were found: does the reading of the sources still work?"
    );
    assert!(
        missing.is_empty(),
        "docs/troubleshooting.md lacks\n{}",
        missing.join("\n")
    );
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
    for source in ["chladni-frf", "chladni-rfp", "chladni-cli"]
        .iter()
        .flat_map(|name| sources(name))
    {
        for call in CODED {
            codes.extend(
                source
                    .match_indices(call)
                    .filter_map(|(at, _)| first_literal(&source[at + call.len()..])),
            );
        }
    }
    assert!(codes.len() > 70, "{codes:?}");
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
fn the_identification_names_no_option_of_the_command_line() {
    let named: Vec<String> = sources("chladni-rfp")
        .iter()
        .flat_map(|source| source.lines())
        .filter(|line| !line.trim_start().starts_with("//"))
        .filter(|line| {
            line.match_indices("--").any(|(at, _)| {
                line[at + 2..].starts_with(|letter: char| letter.is_ascii_lowercase())
            })
        })
        .map(str::to_owned)
        .collect();
    assert!(named.is_empty(), "{}", named.join("\n"));
}
