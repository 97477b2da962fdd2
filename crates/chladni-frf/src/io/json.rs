//! JSON for people: a line for each key, lists of numbers in one line.

use crate::{parser_complaint, Error};
use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};
use std::io::{self, Write};

/// Writes `value` with one line per key, arrays in one line, and a newline at the end.
///
/// # Errors
/// Those of `out`.
pub fn write_json(out: &mut dyn Write, value: &impl Serialize) -> io::Result<()> {
    value.serialize(&mut Serializer::with_formatter(
        &mut *out,
        KeyPerLine {
            depth: 0,
            empty: true,
        },
    ))?;
    out.write_all(b"\n")
}

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

struct KeyPerLine {
    depth: usize,
    empty: bool,
}

impl KeyPerLine {
    fn new_line<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        out.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| out.write_all(b"  "))
    }
}

impl Formatter for KeyPerLine {
    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.empty = true;
        out.write_all(b"{")
    }
    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if !first {
            out.write_all(b",")?;
        }
        self.new_line(out)
    }
    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }
    fn end_object_value<W: ?Sized + Write>(&mut self, _out: &mut W) -> io::Result<()> {
        self.empty = false;
        Ok(())
    }
    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if !self.empty {
            self.new_line(out)?;
        }
        self.empty = false;
        out.write_all(b"}")
    }
    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        out.write_all(if first { b"" } else { b", " })
    }
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
            kind: crate::FrfKind,
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

    #[test]
    fn keys_stand_on_lines_of_their_own_and_numbers_beside_each_other() {
        let value = serde_json::json!({"a": [1.5, 2.0], "b": {}, "c": [{"d": []}, {"d": [[1]]}]});
        let mut out = Vec::new();
        write_json(&mut out, &value).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, "{\n  \"a\": [1.5, 2.0],\n  \"b\": {},\n  \"c\": [{\n    \"d\": []\n  }, {\n    \"d\": [[1]]\n  }]\n}\n");
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            value
        );
    }
}
