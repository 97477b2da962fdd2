//! The message of a JSON reader, as an error with its place.

use crate::words::parser_complaint;
use chladni_frf::Error;
use serde::de::IgnoredAny;

/// The complaint of a JSON reader in parts: line, field, what stood there and what
/// belongs there. `what` was read: "model".
pub fn json_error(what: &str, error: &serde_json::Error) -> Error {
    let said = error.to_string();
    // the place at the end stands in fields of its own
    let said = said
        .rsplit_once(" at line ")
        .map_or(said.as_str(), |(words, _)| words);
    let complaint = match error.is_syntax() || error.is_eof() {
        true => Error::bad_data("no valid JSON")
            .found(said)
            .expected("JSON"),
        false => parser_complaint(said),
    };
    let message = format!("{what}: {} (column {})", complaint.message, error.column());
    Error {
        message,
        ..complaint
    }
    .at_line(error.line() as u64)
}

/// The same of a JSON reader that read `text`. Readers call some values of a wrong type bad
/// syntax; the text itself tells the two apart.
pub fn json_error_in(text: &str, what: &str, error: &serde_json::Error) -> Error {
    let complaint = json_error(what, error);
    // a reader that passes over values does not see these
    let beyond_limits = ["number out of range", "recursion limit exceeded"];
    let said = error.to_string();
    let is_beyond = beyond_limits.iter().any(|limit| said.starts_with(limit));
    let is_valid = || serde_json::from_str::<IgnoredAny>(text).is_ok();
    if !error.is_syntax() || is_beyond || !is_valid() {
        return complaint;
    }
    let message = format!(
        "{what}: a value of the wrong type (column {})",
        error.column()
    );
    let complaint = Error {
        message,
        ..complaint
    }
    .expected("a value as docs/formats.md describes it");
    match value_at(text, error) {
        Some(value) => complaint.found(value),
        None => complaint,
    }
}

/// The value that begins at the place of an error.
fn value_at<'a>(text: &'a str, error: &serde_json::Error) -> Option<&'a str> {
    let line = text.split('\n').nth(error.line().checked_sub(1)?)?;
    let rest = line.get(error.column().checked_sub(1)?..)?;
    let value = rest.split([',', ']', '}']).next()?.trim();
    (!value.is_empty()).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complaints_come_in_parts() {
        #[derive(Debug, serde::Deserialize)]
        #[allow(dead_code)]
        struct Two {
            mass: f64,
            kind: chladni_frf::FrfKind,
        }
        let complaint =
            |text: &str| json_error("pair", &serde_json::from_str::<Two>(text).unwrap_err());
        let missing = complaint("{\n\"mass\": 1}");
        assert_eq!(
            (missing.line, missing.field.as_deref()),
            (Some(2), Some("kind"))
        );
        let wrong = complaint("{\"mass\": \"heavy\", \"kind\": \"mobility\"}");
        assert_eq!(
            (wrong.found.as_deref(), wrong.expected.as_deref()),
            (Some("string \"heavy\""), Some("a number"))
        );
        assert!(wrong.message.starts_with("pair: invalid type"), "{wrong}");
        assert_eq!(
            complaint("{\"mass\": 1, \"kind\": \"dance\"}")
                .found
                .as_deref(),
            Some("dance")
        );
        assert_eq!(complaint("{\"mass\": ").expected.as_deref(), Some("JSON"));
    }

    #[test]
    fn a_value_of_a_wrong_type_is_not_called_bad_syntax() {
        #[derive(Debug, serde::Deserialize)]
        #[allow(dead_code)]
        enum Step {
            Waltz,
        }
        #[derive(Debug, serde::Deserialize)]
        #[allow(dead_code)]
        struct Dance {
            step: Step,
            place: [f64; 2],
        }
        let complaint = |text: &str| {
            let error = serde_json::from_str::<Dance>(text).unwrap_err();
            json_error_in(text, "dance", &error)
        };
        for (text, found) in [
            ("{\n\"step\": 5, \"place\": [0, 1]}", "5"),
            ("{\n\"step\": \"Waltz\", \"place\": [0, 1, 2]}", "2"),
        ] {
            let wrong = complaint(text);
            assert_eq!(
                (wrong.line, wrong.found.as_deref()),
                (Some(2), Some(found)),
                "{wrong}"
            );
            assert!(wrong.message.contains("wrong type"), "{wrong}");
        }
        for text in [
            "{\"step\": 5, \"place\": [0, 1,}",
            "{\"step\": \"Waltz\", \"place\": [0, 1e999]}",
        ] {
            let broken = complaint(text);
            assert!(broken.message.contains("no valid JSON"), "{broken}");
        }
    }
}
