//! Lines of a table, its comments, and the remarks among them.

use super::text::Line;

/// `# key = value` (or `%`, `//`, and `:`); without a comment sign only known keys.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Remark {
    pub(super) line: u64,
    pub(super) key: String,
    pub(super) value: String,
}

/// Keys of remarks, each with its other names.
const KEYS: [(&str, &[&str]); 8] = [
    ("frf_kind", &[]),
    (
        "unit",
        &["units", "frf_unit", "frf_units", "y_unit", "y_units"],
    ),
    (
        "frequency_unit",
        &[
            "frequency_units",
            "freq_unit",
            "f_unit",
            "x_unit",
            "x_units",
        ],
    ),
    ("phase_unit", &["phase_units", "angle_unit", "angle_units"]),
    ("time_sign", &[]),
    ("reference_unit", &[]),
    ("response", &[]),
    ("reference", &[]),
];

/// The key that a text stands for: `Frequency units` is `frequency_unit`.
pub(super) fn key_of(text: &str) -> String {
    let key = text.trim().to_lowercase().replace([' ', '-'], "_");
    KEYS.iter()
        .find(|(_, others)| others.contains(&key.as_str()))
        .map_or(key, |(name, _)| (*name).to_owned())
}

fn is_known(key: &str) -> bool {
    KEYS.iter().any(|(name, _)| *name == key)
}

/// Splits a comment at `=`, or at `:` after a known key. A header with `=` in it, such as
/// `f [Hz], Re(H=v/F)`, is no remark.
fn remark_of_comment(comment: &str) -> Option<(String, &str)> {
    let is_key = |key: &str| {
        key.chars()
            .all(|c| c.is_alphanumeric() || " _-.".contains(c))
    };
    if let Some((key, value)) = comment.split_once('=').filter(|(key, _)| is_key(key)) {
        return Some((key_of(key), value));
    }
    let (key, value) = comment.split_once(':')?;
    Some((key_of(key), value)).filter(|(key, _)| is_known(key))
}

/// Splits a line such as `Unit: mm/s/N` or `unit;mm/s/N`, where the key is known.
fn remark_of_line(line: &str) -> Option<(String, &str)> {
    line.match_indices(['=', ':', ',', ';', '\t'])
        .next()
        .map(|(at, sign)| (key_of(&line[..at]), &line[at + sign.len()..]))
        .filter(|(key, value)| is_known(key) && !value.trim().contains([',', ';', '\t']))
}

/// The lines that are not blank, and the remarks. A comment that is no remark may be the header,
/// as `numpy.savetxt` writes it. It stays a line, without its sign.
pub(super) fn lines_and_remarks(text: &str) -> (Vec<Line<'_>>, Vec<Remark>) {
    let (mut lines, mut remarks) = (Vec::new(), Vec::new());
    for (number, raw) in numbered_lines(text) {
        let trimmed = raw.trim();
        let comment = trimmed
            .strip_prefix(['#', '%'])
            .or_else(|| trimmed.strip_prefix("//"))
            .map(|comment| comment.trim_start_matches(['#', '%', '/']).trim());
        let remark = match comment {
            Some(comment) => remark_of_comment(comment),
            None => remark_of_line(trimmed),
        };
        if let Some((key, value)) = remark {
            remarks.push(Remark {
                line: number,
                key,
                value: value.trim().trim_matches('"').to_owned(),
            });
            continue;
        }
        // trailing tabs are empty columns: only the line end goes
        let content = comment.unwrap_or(raw);
        if !content.trim().is_empty() {
            lines.push(Line {
                number,
                text: content,
                is_comment: comment.is_some(),
            });
        }
    }
    (lines, remarks)
}

/// The lines of a text, numbered as editors do: LF, CRLF and lone CR each end one line.
pub(crate) fn numbered_lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let lines = text.split('\n').flat_map(|line| {
        let line = line.strip_suffix('\r').unwrap_or(line);
        line.split('\r')
    });
    (1..).zip(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_as_editors_do() {
        let (lines, remarks) = lines_and_remarks("# unit = m/s/N\r\n\r\nf,re,im\r\n1,2,3\r4,5,6\n");
        assert_eq!(
            lines.iter().map(|line| line.number).collect::<Vec<_>>(),
            [3, 4, 5]
        );
        assert_eq!(
            remarks,
            [Remark {
                line: 1,
                key: "unit".into(),
                value: "m/s/N".into()
            }]
        );
    }

    #[test]
    fn remarks_have_known_keys_or_a_comment_sign() {
        let (lines, remarks) = lines_and_remarks(
            "Units: mm/s/N\nunit;m/N\n// x units = kHz\n# f [Hz], Re(H=v/F), Im\nresponse,\
             reference,f,re,im\nOperator: me\n# operator = me\n% 1,2,3\n",
        );
        let found: Vec<_> = remarks
            .iter()
            .map(|remark| (remark.key.as_str(), remark.value.as_str()))
            .collect();
        assert_eq!(
            found,
            [
                ("unit", "mm/s/N"),
                ("unit", "m/N"),
                ("frequency_unit", "kHz"),
                ("operator", "me")
            ]
        );
        assert_eq!(
            lines
                .iter()
                .map(|line| (line.number, line.is_comment))
                .collect::<Vec<_>>(),
            [(4, true), (5, false), (6, false), (8, true)]
        );
    }
}
