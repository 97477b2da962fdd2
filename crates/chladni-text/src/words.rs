//! For messages about text that people write: the line a byte stands in, what a parser
//! says.

use crate::json_kind::{json_format, json_kind};
use chladni_frf::Error;

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
        (Some(word), _) if said.starts_with("unknown field") => {
            // without backticks, in which some names are options
            let fields = expected.unwrap_or("no such field").replace('`', "");
            return error.found(word).expected(fields);
        }
        (_, Some(found)) => error.found(plain(found)),
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
        Some(expected) => error.expected(plain(expected)),
        None => error,
    }
}

/// A parser's name of a type, in plain words; other words as they are.
fn plain(said: &str) -> &str {
    match said {
        "f32" | "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" => "a whole number from 0 to 4294967295",
        "u64" | "usize" => "a whole number, 0 or more",
        "i32" | "i64" | "isize" => "a whole number",
        "map" | "a map" => "keys in { }",
        "sequence" | "a sequence" => "a list in [ ]",
        _ if said.starts_with("struct ") => "keys in { }",
        _ => said,
    }
}

/// The complaint of a TOML parser about syntax, at byte `at` of `text`. A JSON file of this
/// program is called by its kind.
pub fn toml_complaint(said: &str, text: &str, at: usize) -> Error {
    if let Some(error) = json_for_toml(text) {
        return error;
    }
    let line = line_of_byte(text, at);
    let found = text
        .lines()
        .nth(line as usize - 1)
        .unwrap_or_default()
        .trim();
    if said.trim() == "duplicate key" {
        return Error::bad_data("this name occurs twice")
            .at_line(line)
            .found(found)
            .expected("each key once in its table, and each [table] once")
            .help("leave one of the two out; write each table of a list as [[name]]");
    }
    let complaint = parser_complaint(&said.replace('\n', " "));
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

/// The error of a JSON file of this program in the place of TOML.
fn json_for_toml(text: &str) -> Option<Error> {
    let format = json_format(text)?;
    let error = Error::bad_data(format!("{}, not TOML", json_kind(&format)?))
        .field("format")
        .found(format)
        .expected("TOML, as of a scene or a panel");
    Some(error.help("give the TOML file here, and this file in its own place"))
}

/// Line of a byte of `text`, counted from 1.
pub fn line_of_byte(text: &str, byte: usize) -> u64 {
    1 + text
        .bytes()
        .take(byte)
        .filter(|&byte| byte == b'\n')
        .count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_no_names_of_a_parser() {
        for (said, found, expected) in [
            ("invalid type: map, expected f64", "keys in { }", "a number"),
            (
                "invalid type: sequence, expected usize",
                "a list in [ ]",
                "a whole number, 0 or more",
            ),
            (
                "invalid value: integer `5000000000`, expected u32",
                "integer `5000000000`",
                "a whole number from 0 to 4294967295",
            ),
            (
                "invalid type: string \"a\", expected struct Plate",
                "string \"a\"",
                "keys in { }",
            ),
        ] {
            let error = parser_complaint(said);
            assert_eq!(error.found.as_deref(), Some(found), "{error}");
            assert_eq!(error.expected.as_deref(), Some(expected), "{error}");
        }
    }

    #[test]
    fn a_json_file_in_the_place_of_toml_is_called_by_its_kind() {
        let complaint = |text: &str| toml_complaint("invalid key", text, 0);
        let error = complaint("{\n\"format\": \"chladni.signal\", \"version\": 1}");
        assert_eq!(error.message, "the sidecar of a signal, not TOML");
        assert_eq!(error.found.as_deref(), Some("chladni.signal"));
        assert!(error.expected.is_some() && error.help.is_some(), "{error}");
        for other in ["{\"format\": \"music\"}", "{\"keep\": [1]}", "[frf\n"] {
            let error = complaint(other);
            assert!(error.message.starts_with("this is no TOML"), "{error}");
        }
    }

    #[test]
    fn lines_are_counted_from_one() {
        assert_eq!(
            [0, 2, 3, 99].map(|byte| line_of_byte("a\n\nb", byte)),
            [1, 2, 3, 3]
        );
    }
}
