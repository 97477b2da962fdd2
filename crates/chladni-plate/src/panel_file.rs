//! Reading a panel file: every complaint names the key and its line, and an unknown key
//! the nearest known one.

use crate::panel::Panel;
use chladni_frf::{nearest_word, Error, Result};
use chladni_text::read_text;
use chladni_text::{line_of_byte, parser_complaint, toml_complaint};
use std::path::Path;
use toml::de::{DeTable, DeValue};
use toml::Spanned;

/// Sections and keys of a panel file.
const SECTIONS: [(&str, &[&str]); 4] = [
    (
        "plate",
        &[
            "length_m",
            "width_m",
            "thickness_m",
            "youngs_modulus_pa",
            "poisson_ratio",
            "density_kg_per_m3",
            "loss_factor",
            "edges",
            "stiffness_n_per_m2",
        ],
    ),
    (
        "responses",
        &["grid", "spacing_m", "at_references", "driving_point"],
    ),
    (
        "references",
        &[
            "edge_count",
            "spacing_m",
            "inset_m",
            "mass_kg",
            "stiffness_n_per_m",
            "damping_n_s_per_m",
            "newtons_per_volt",
        ],
    ),
    (
        "frf",
        &["kind", "start_hz", "stop_hz", "step_hz", "snr_db", "seed"],
    ),
];

/// Keys whose value is a pair of numbers.
const PAIRS: [&str; 2] = ["grid", "edge_count"];

impl Panel {
    /// Reads and checks a panel; keys that are left out have their defaults.
    ///
    /// * `memory_limit_bytes`: what exceeds it is refused here, before anything is
    ///   computed
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with line and key: no TOML, an unknown key, a
    /// wrong type, an unusable value, too large.
    pub fn from_toml(text: &str, memory_limit_bytes: u64) -> Result<Self> {
        let document = DeTable::parse(text).map_err(|error| {
            toml_complaint(
                error.message(),
                text,
                error.span().map_or(0, |span| span.start),
            )
        })?;
        check_keys(text, document.get_ref())?;
        let panel: Panel =
            toml::from_str(text).map_err(|error| type_error(text, document.get_ref(), &error))?;
        let with_line = |error: Error| match error
            .field
            .as_deref()
            .and_then(|field| line_of_key(text, document.get_ref(), field))
        {
            Some(line) => error.at_line(line),
            None => error,
        };
        panel.check().map_err(with_line)?;
        panel.check_memory(memory_limit_bytes)?;
        Ok(panel)
    }

    /// Reads a panel file; see [`Self::from_toml`].
    ///
    /// # Errors
    /// As [`Self::from_toml`], with the file's name; also a file that cannot be read.
    pub fn read(file: &Path, memory_limit_bytes: u64) -> Result<Self> {
        let text = read_text(file, "a panel, TOML")?;
        Self::from_toml(&text, memory_limit_bytes).map_err(|error| error.file(file))
    }
}

fn check_keys(text: &str, document: &DeTable) -> Result<()> {
    let sections = SECTIONS.map(|(name, _)| name);
    for (name, value) in document.iter() {
        let Some((_, keys)) = SECTIONS
            .iter()
            .find(|(section, _)| section == name.get_ref())
        else {
            return Err(unknown(text, name, "section", &sections).help(misplaced(name.get_ref())));
        };
        let DeValue::Table(section) = value.get_ref() else {
            return Err(
                Error::bad_data(format!("`{}` is a section, not a value", name.get_ref()))
                    .at_line(line_of_byte(text, name.span().start))
                    .field(name.get_ref().as_ref())
                    .found("a value")
                    .expected(format!("the heading [{}]", name.get_ref())),
            );
        };
        for (key, value) in section.iter() {
            if !keys.contains(&key.get_ref().as_ref()) {
                return Err(unknown(text, key, "key", keys).field(format!(
                    "{}.{}",
                    name.get_ref(),
                    key.get_ref()
                )));
            }
            let DeValue::Array(entries) = value.get_ref() else {
                continue;
            };
            // a list that is read as a pair leaves out what follows
            if PAIRS.contains(&key.get_ref().as_ref()) && entries.len() > 2 {
                return Err(Error::bad_data("too many numbers")
                    .at_line(line_of_byte(text, key.span().start))
                    .field(format!("{}.{}", name.get_ref(), key.get_ref()))
                    .found(format!("a list of {}", entries.len()))
                    .expected("a list of 2 whole numbers"));
            }
        }
    }
    Ok(())
}

fn unknown(text: &str, name: &Spanned<std::borrow::Cow<str>>, what: &str, known: &[&str]) -> Error {
    let nearest = nearest_word(name.get_ref(), known).unwrap_or_default();
    Error::bad_data(format!(
        "unknown {what}; the nearest known one is `{nearest}`"
    ))
    .at_line(line_of_byte(text, name.span().start))
    .field(name.get_ref().as_ref())
    .found(name.get_ref())
    .expected(format!("one of {}", known.join(", ")))
}

/// Advice for a name at the top of the file: a key without its section, or else the list
/// of sections.
fn misplaced(name: &str) -> String {
    match SECTIONS.iter().find(|(_, keys)| keys.contains(&name)) {
        Some((section, _)) => format!("the key `{name}` belongs under the heading [{section}]"),
        None => "the sections are [plate], [responses], [references] and [frf]".into(),
    }
}

/// The key whose value the error points at.
fn type_error(text: &str, document: &DeTable, error: &toml::de::Error) -> Error {
    let located = parser_complaint(error.message().trim());
    let Some(span) = error.span() else {
        return located;
    };
    let at = |value: &Spanned<DeValue>| {
        value.span().start <= span.start
            && span.start < value.span().end.max(value.span().start + 1)
    };
    let field = document
        .iter()
        .find_map(|(name, section)| match section.get_ref() {
            DeValue::Table(keys) => keys
                .iter()
                .find(|(_, value)| at(value))
                .map(|(key, _)| format!("{}.{}", name.get_ref(), key.get_ref())),
            _ => None,
        });
    let located = located.at_line(line_of_byte(text, span.start));
    match field {
        Some(field) => located.field(field),
        None => located,
    }
}

/// Line of `section.key`, or of the section where the key is left to its default.
fn line_of_key(text: &str, document: &DeTable, field: &str) -> Option<u64> {
    let (section, key) = field.split_once('.').unwrap_or((field, ""));
    let (_, value) = document
        .iter()
        .find(|(name, _)| name.get_ref() == section)?;
    let DeValue::Table(keys) = value.get_ref() else {
        return None;
    };
    keys.iter()
        .find(|(name, _)| name.get_ref() == key)
        .map(|(name, _)| line_of_byte(text, name.span().start))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: u64 = 2 << 30;

    fn message(text: &str) -> String {
        Panel::from_toml(text, LIMIT).unwrap_err().to_string()
    }

    #[test]
    fn an_empty_file_is_the_default_panel() {
        assert_eq!(Panel::from_toml("", LIMIT).unwrap(), Panel::default());
    }

    #[test]
    fn whole_numbers_serve_as_decimals_and_loss_factors_as_lists() {
        let panel = Panel::from_toml(
            "[plate]\nlength_m = 1\nloss_factor = [0.01, 0.02]\nedges = \"SFSF\"",
            LIMIT,
        )
        .unwrap();
        assert_eq!(panel.plate.length_m, 1.0);
        assert_eq!(panel.plate.loss_factor.entries(), [0.01, 0.02]);
    }

    #[test]
    fn an_infinite_level_is_no_noise() {
        let panel = Panel::from_toml("[frf]\nsnr_db = inf", LIMIT).unwrap();
        assert_eq!(panel.frf.snr_db, f64::INFINITY);
    }

    #[test]
    fn an_unknown_key_names_the_nearest_one_and_its_line() {
        let text = message("[frf]\nstart_hz = 2.0\nstep = 0.5\n");
        assert!(
            text.contains("line 3") && text.contains("frf.step") && text.contains("`step_hz`"),
            "{text}"
        );
        let text = message("[plates]\n");
        assert!(
            text.contains("line 1") && text.contains("`plate`"),
            "{text}"
        );
        let text = message("seed = 3\n");
        assert!(text.contains("belongs under the heading [frf]"), "{text}");
    }

    #[test]
    fn wrong_types_and_values_name_key_line_and_what_is_expected() {
        for (text, parts) in [
            (
                "[plate]\n\nwidth_m = \"a\"",
                ["line 3", "plate.width_m", "string"],
            ),
            (
                "[plate]\nwidth_m = -1.0",
                ["line 2", "plate.width_m", "above 0"],
            ),
            (
                "[plate]\nwidth_m = nan",
                ["line 2", "plate.width_m", "finite"],
            ),
            (
                "[plate]\npoisson_ratio = 0.7",
                ["line 2", "plate.poisson_ratio", "below 0.5"],
            ),
            (
                "[plate]\nloss_factor = \"x\"",
                ["line 2", "plate.loss_factor", "array of numbers"],
            ),
            (
                "[plate]\nloss_factor = []",
                ["line 2", "plate.loss_factor", "one per elastic mode"],
            ),
            (
                "[plate]\nedges = \"FFFX\"",
                ["line 2", "plate.edges", "four letters"],
            ),
            (
                "[responses]\ngrid = [0, 3]",
                ["line 2", "responses.grid", "at least 1"],
            ),
            (
                "[responses]\ngrid = [11, 7, 3]",
                ["line 2", "responses.grid", "a list of 3"],
            ),
            (
                "[references]\nedge_count = [11, 6, 0]",
                ["line 2", "references.edge_count", "a list of 3"],
            ),
            ("[responses]\ngrid = [3]", ["line 2", "responses.grid", "2"]),
            (
                "[responses]\ngrid = [-3, 1]",
                ["line 2", "responses.grid", "-3"],
            ),
            (
                "[responses]\ngrid = [20, 7]",
                ["line 2", "responses.grid", "do not fit"],
            ),
            (
                "[references]\nedge_count = [0, 0]",
                ["line 2", "references.edge_count", "nothing drives"],
            ),
            (
                "[references]\ninset_m = 0.1",
                ["line 2", "references.inset_m", "middle"],
            ),
            (
                "[references]\n\nnewtons_per_volt = [0.1, 0.2]",
                ["line 3", "references.newtons_per_volt", "34 references"],
            ),
            (
                "[references]\nnewtons_per_volt = 0.0",
                ["line 2", "references.newtons_per_volt", "dead actuator"],
            ),
            (
                "[references]\nnewtons_per_volt = \"x\"",
                ["line 2", "references.newtons_per_volt", "array of numbers"],
            ),
            (
                "[frf]\nkind = \"mobillity\"",
                ["line 2", "frf.kind", "receptance"],
            ),
            (
                "[frf]\nstart_hz = 0.0",
                ["line 2", "frf.start_hz", "rigid body"],
            ),
            (
                "[frf]\nstop_hz = 1.0",
                ["line 2", "frf.stop_hz", "ends before"],
            ),
            (
                "[frf]\nsnr_db = nan",
                ["line 2", "frf.snr_db", "-100 dB or more"],
            ),
            (
                "[frf]\nsnr_db = -inf",
                ["line 2", "frf.snr_db", "-100 dB or more"],
            ),
            (
                "[frf]\nsnr_db = -1000",
                ["line 2", "frf.snr_db", "-100 dB or more"],
            ),
            (
                "[plate]\nloss_factor = [0.01, 5]",
                ["line 2", "plate.loss_factor", "at most 2"],
            ),
            ("[frf]\nseed = 1.5", ["line 2", "frf.seed", "1.5"]),
            ("plate = 3", ["line 1", "section", "[plate]"]),
            ("[plate\n", ["line 1", "TOML", "help"]),
        ] {
            let shown = message(text);
            for part in parts {
                assert!(
                    shown.contains(part),
                    "{text:?} gave {shown:?} without {part:?}"
                );
            }
        }
    }

    #[test]
    fn sizes_that_exceed_the_memory_are_refused_at_once() {
        for text in [
            "[frf]\nstep_hz = 1e-12",
            "[frf]\nstop_hz = 1e9",
            "[responses]\ngrid = [9000000000000000000, 9000000000000000000]\nspacing_m = 1e-300",
            "[references]\nedge_count = [4000000000, 1]\nspacing_m = 1e-11",
            "[plate]\nthickness_m = 1e-12",
        ] {
            assert!(
                message(text).contains("more memory than is allowed"),
                "{text}: {}",
                message(text)
            );
        }
        assert!(Panel::default().memory_bytes() < 400e6);
        assert!(Panel::default().memory_bytes() > 77.0 * 34.0 * 1997.0 * 16.0);
    }
}
