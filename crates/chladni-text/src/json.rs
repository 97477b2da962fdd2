//! The message of a JSON reader, as an error with its place.

use crate::words::parser_complaint;
use chladni_frf::Error;

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
            (Some("string \"heavy\""), Some("f64"))
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
}
