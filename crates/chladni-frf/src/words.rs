//! For messages about text that people write: the word they may have meant, the line a
//! byte stands in, what a parser says.

use crate::Error;

/// Text for a terminal: control characters, which it would obey, and marks that turn the
/// direction of writing around are escaped, but for those in `kept`.
pub fn printable(text: &str, kept: &[char]) -> String {
    let is_obeyed = |c: char| {
        let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        (c.is_control() || turns) && !kept.contains(&c)
    };
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_obeyed(c) {
            true => shown.extend(c.escape_unicode()),
            false => shown.push(c),
        }
    }
    shown
}

/// The known word that `word` may stand for: one that begins with it (a name without its
/// unit or extension), else the one with the fewest letters to change, insert or delete
/// (Levenshtein 1966); the first of equals, `None` where none is known.
pub fn nearest_word<'w>(word: &str, known: &[&'w str]) -> Option<&'w str> {
    known
        .iter()
        .min_by_key(|candidate| (!candidate.starts_with(word), edit_distance(word, candidate)))
        .copied()
}

/// True where `near` is close enough to `word` to be asked about.
pub(crate) fn is_near(word: &str, near: &str) -> bool {
    near.starts_with(word) || 3 * edit_distance(word, near) <= word.chars().count()
}

/// The words of a parser (serde_json, toml) in parts: `invalid type: null, expected f64`
/// says what stood there, and what belongs there; ``missing field `x` `` names the field.
pub fn parser_complaint(said: &str) -> Error {
    let (said, expected) = said
        .split_once(", expected ")
        .map_or((said, None), |(said, expected)| (said, Some(expected)));
    let found = ["invalid type: ", "invalid value: "]
        .iter()
        .find_map(|words| said.strip_prefix(words));
    let error = Error::bad_data(found.map_or(said, |found| {
        said.trim_end_matches(found).trim_end_matches(": ")
    }));
    let error = match (said.split('`').nth(1), found) {
        (Some(field), _) if said.starts_with("missing field") => error
            .field(field)
            .found("no such field")
            .expected("a value for it"),
        (Some(word), _) if said.starts_with("unknown variant") => error.found(word),
        (_, Some(found)) => error.found(found),
        // words of our own types: "`x` is no ...; write ..."
        (Some(word), None) if said.contains("; write ") => {
            let expected = said
                .split_once("; write ")
                .map_or("", |(_, expected)| expected);
            return Error::bad_data(said).found(word).expected(expected);
        }
        _ if expected.is_none() => error
            .found(said)
            .expected("a value as docs/formats.md describes it"),
        _ => error,
    };
    match expected {
        Some(expected) => error.expected(expected),
        None => error,
    }
}

/// The complaint of a TOML parser about syntax, at byte `at` of `text`.
pub fn toml_complaint(said: &str, text: &str, at: usize) -> Error {
    let line = line_of_byte(text, at);
    let complaint = parser_complaint(&said.replace('\n', " "));
    let found = text
        .lines()
        .nth(line as usize - 1)
        .unwrap_or_default()
        .trim();
    Error {
        message: format!("this is no TOML: {}", complaint.message),
        ..complaint
    }
    .at_line(line)
    .found(if found.is_empty() {
        "an empty line"
    } else {
        found
    })
    .help("correct that line; a key is written as `name = value`, a table as `[name]`")
}

/// Line of a byte of `text`, counted from 1.
pub fn line_of_byte(text: &str, byte: usize) -> u64 {
    1 + text
        .bytes()
        .take(byte)
        .filter(|&byte| byte == b'\n')
        .count() as u64
}

/// Letters to change, insert or delete; names longer than [`LONGEST`] are compared that
/// far.
fn edit_distance(a: &str, b: &str) -> usize {
    /// No name is longer; the cost grows with the square.
    const LONGEST: usize = 64;
    let b: Vec<char> = b.chars().take(LONGEST).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().take(LONGEST).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for j in 0..b.len() {
            let changed = diagonal + usize::from(letter != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted() {
        assert_eq!(
            [
                ("abc", "abc"),
                ("abc", "axc"),
                ("", "abc"),
                ("kitten", "sitting")
            ]
            .map(|(a, b)| edit_distance(a, b)),
            [0, 1, 3, 3]
        );
    }

    #[test]
    fn a_name_without_its_unit_is_near_and_another_word_is_not() {
        assert_eq!(
            nearest_word("transition", &["grid", "transitions", "transition_m"]),
            Some("transitions")
        );
        assert_eq!(
            nearest_word("thicknes_m", &["length_m", "thickness_m"]),
            Some("thickness_m")
        );
        assert_eq!(nearest_word("x", &[]), None);
        assert!(
            is_near("pannel.h5", "panel.h5")
                && is_near("panel", "panel.h5")
                && !is_near("nowhere.uff", "panel.uff")
        );
    }

    #[test]
    fn lines_are_counted_from_one() {
        assert_eq!(
            [0, 2, 3, 99].map(|byte| line_of_byte("a\n\nb", byte)),
            [1, 2, 3, 3]
        );
    }
}
