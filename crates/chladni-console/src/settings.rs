//! Settings that libraries name in their sentences, rewritten as options.
//!
//! A library knows no options. It names a setting by its field in backticks, with a value
//! where it proposes one: `` `frf_kind mobility` ``. In Python that is the keyword; here it
//! becomes `--frf-kind mobility`.

use crate::usage;
use chladni_frf::{Error, ErrorKind, Finding, TimeSign};

/// Names of the settings that are options of the same name.
const SETTINGS: [&str; 26] = [
    "block",
    "blocks",
    "delay",
    "dofs",
    "duplicates",
    "estimator",
    "exponential_window",
    "force",
    "frf_kind",
    "lenient",
    "map",
    "measured",
    "memory",
    "modes",
    "overlap",
    "phase_unit",
    "reference",
    "references",
    "response",
    "sample_rate",
    "scales",
    "snap_df",
    "sweep",
    "time_sign",
    "units",
    "window",
];

/// Words of libraries for the time sign opposite to that of reading.
const OTHER_SIGN: &str = "the other time sign";

/// The text with every setting as an option.
pub fn as_options(text: &str) -> String {
    let read_with = match usage::says("--time-sign", "-") {
        true => TimeSign::Minus,
        false => TimeSign::Plus,
    };
    as_options_of(text, read_with)
}

/// The same where the data were read with this time sign.
fn as_options_of(text: &str, read_with: TimeSign) -> String {
    let other = match read_with {
        TimeSign::Minus => "+",
        TimeSign::Plus => "-",
    };
    // findings of a stored result are told again: they already name the option
    let text = match text.contains(&format!("{OTHER_SIGN} (")) {
        true => text.to_owned(),
        false => text.replace(OTHER_SIGN, &format!("{OTHER_SIGN} (`time_sign {other}`)")),
    };
    let mut out = String::with_capacity(text.len());
    let mut rest = text.as_str();
    while let Some((before, quoted, after)) = next_quoted(rest) {
        out += before;
        match option_of(quoted) {
            Some(option) => out += &option,
            None => out += &format!("`{quoted}`"),
        }
        rest = after;
    }
    out + rest
}

/// The text before the next words in backticks, these words, and the rest.
fn next_quoted(text: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = text.split_once('`')?;
    let (quoted, after) = rest.split_once('`')?;
    Some((before, quoted, after))
}

/// `frf_kind mobility` as `--frf-kind mobility`; `None` where the words name no setting.
fn option_of(quoted: &str) -> Option<String> {
    let name = quoted
        .split(' ')
        .next()
        .filter(|name| SETTINGS.contains(name))?;
    Some(format!(
        "--{}{}",
        name.replace('_', "-"),
        &quoted[name.len()..]
    ))
}

/// The finding with every setting as an option.
pub fn finding_with_options(finding: &Finding) -> Finding {
    Finding {
        text: as_options(&finding.text),
        help: as_options(&finding.help).into(),
        ..finding.clone()
    }
}

/// The error with every setting as an option; so is the field of an error of usage.
pub fn error_with_options(error: Error) -> Error {
    let field = error.field.as_deref().map(|field| {
        option_of(field)
            .filter(|_| error.kind == ErrorKind::Usage)
            .unwrap_or_else(|| field.to_owned())
    });
    let text = |text: &Option<String>| text.as_deref().map(as_options);
    Error {
        message: as_options(&error.message),
        found: text(&error.found),
        expected: text(&error.expected),
        help: text(&error.help),
        field,
        ..error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_become_options_and_other_words_in_backticks_stay() {
        for (text, expected) in [
            ("say it with `frf_kind`", "say it with --frf-kind"),
            (
                "unit `mm/s`: say it with `frf_kind mobility` or `time_sign -`.",
                "unit `mm/s`: say it with --frf-kind mobility or --time-sign -.",
            ),
            ("`lenient` masks `x`", "--lenient masks `x`"),
            ("method `robust` serves more", "method `robust` serves more"),
            ("an open ` and `map", "an open ` and `map"),
            ("`map` or `map frf=H`", "--map or --map frf=H"),
        ] {
            assert_eq!(as_options(text), expected);
        }
    }

    #[test]
    fn the_other_time_sign_is_the_one_that_was_not_given() {
        let advice = "read it with the other time sign";
        for (read_with, option) in [
            (TimeSign::Plus, "(--time-sign -)"),
            (TimeSign::Minus, "(--time-sign +)"),
        ] {
            let told = as_options_of(advice, read_with);
            assert_eq!(told, format!("{advice} {option}"));
            assert_eq!(as_options_of(&told, read_with), told);
        }
    }

    #[test]
    fn a_wrong_setting_is_named_as_the_option() {
        let wrong = Error::new(ErrorKind::Usage, "no possible overlap").field("overlap");
        assert_eq!(
            error_with_options(wrong).field.as_deref(),
            Some("--overlap")
        );
        let column = Error::bad_data("no number").field("reference");
        assert_eq!(
            error_with_options(column).field.as_deref(),
            Some("reference")
        );
    }
}
