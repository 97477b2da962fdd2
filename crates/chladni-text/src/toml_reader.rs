//! Reading TOML key by key, so that every complaint names the line, the key, what stood
//! there and what belongs there.

use crate::limits::LARGEST;
use crate::{line_of_byte, toml_complaint};
use chladni_frf::{nearest_word, Error, Result};
use toml::de::{DeTable, DeValue};
use toml::Spanned;

/// The keys a file may hold: table name (empty: top level; with `[]` at its end: a list of
/// tables) and its keys.
pub type Keys = &'static [(&'static str, &'static [&'static str])];

/// Parses the text; a syntax error becomes an error with its line.
pub fn parse(text: &str) -> Result<Spanned<DeTable<'_>>> {
    DeTable::parse(text).map_err(|error| {
        toml_complaint(
            error.message(),
            text,
            error.span().map_or(0, |span| span.start),
        )
    })
}

/// A table and its name.
pub struct Table<'a> {
    text: &'a str,
    name: String,
    line: u64,
    entries: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    /// The whole document.
    pub fn root(text: &'a str, document: &'a Spanned<DeTable<'a>>) -> Self {
        Self {
            text,
            name: String::new(),
            line: 1,
            entries: document.get_ref(),
        }
    }

    fn path(&self, key: &str) -> String {
        if self.name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.name)
        }
    }

    /// Refuses the first key that is not among those that `keys` lists for `table`,
    /// naming the nearest known one.
    pub fn only_keys(&self, keys: Keys, table: &str) -> Result<()> {
        let known = keys
            .iter()
            .find(|(name, _)| *name == table)
            .map_or(&[][..], |(_, known)| *known);
        let mut unknown: Vec<_> = self
            .entries
            .keys()
            .filter(|key| !known.contains(&key.get_ref().as_ref()))
            .collect();
        unknown.sort_by_key(|key| key.span().start);
        let Some(key) = unknown.first() else {
            return Ok(());
        };
        let name = key.get_ref().as_ref();
        let elsewhere = keys
            .iter()
            .find(|(other, known)| *other != table && known.contains(&name));
        let help = match elsewhere {
            Some(("", _)) => format!("`{name}` stands at the top of the file, before any [table]"),
            Some((other, _)) => match other.strip_suffix("[]") {
                Some(list) => format!("`{name}` belongs under [[{list}]], in two brackets"),
                None => format!("`{name}` belongs into [{other}]"),
            },
            None => format!(
                "did you mean `{}`? Known keys here: {}",
                nearest_word(name, known).unwrap_or_default(),
                known.join(", ")
            ),
        };
        let error = Error::bad_data("unknown key")
            .at_line(line_of_byte(self.text, key.span().start))
            .field(self.path(name));
        Err(error.found(name).expected(known.join(", ")).help(help))
    }

    /// The value of `key`, if it is there.
    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        self.entries
            .iter()
            .find(|(name, _)| name.get_ref() == key)
            .map(|(_, value)| Value {
                text: self.text,
                path: self.path(key),
                value,
            })
    }

    /// The value of `key`, or the error that asks for it.
    pub fn require(&self, key: &str, expected: &str) -> Result<Value<'a>> {
        self.get(key).ok_or_else(|| {
            let error = Error::bad_data("missing")
                .at_line(self.line)
                .field(self.path(key))
                .found("no such key")
                .expected(expected);
            error.help(format!("add `{key} = ...`"))
        })
    }
}

/// A value, its name and its place.
pub struct Value<'a> {
    text: &'a str,
    path: String,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Value<'a> {
    /// Line, counted from 1.
    pub fn line(&self) -> u64 {
        line_of_byte(self.text, self.value.span().start)
    }

    /// An error at this value: `message`, what stands here, what was expected.
    pub fn error(&self, message: &str, expected: impl std::fmt::Display) -> Error {
        let found = self.text.get(self.value.span()).unwrap_or_default();
        Error::bad_data(message)
            .at_line(self.line())
            .field(self.path.clone())
            .found(found)
            .expected(expected)
    }

    /// A finite number of at most `LARGEST`, written with or without a decimal point.
    pub fn number(&self) -> Result<f64> {
        let number = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .ok()
                .map(|i| i as f64),
            _ => None,
        };
        number.filter(|n: &f64| n.abs() <= LARGEST).ok_or_else(|| {
            let error = self.error(
                "not a number that can be used",
                format!("a number between -{LARGEST:e} and {LARGEST:e}"),
            );
            match self.value.get_ref() {
                DeValue::Float(_) | DeValue::Integer(_) => error,
                _ => error.help("write the number alone, without quotes, unit or brackets"),
            }
        })
    }

    /// A finite number greater than zero.
    pub fn positive(&self) -> Result<f64> {
        self.number_that(
            |n| n > 0.0,
            "must be greater than zero",
            "a number greater than 0",
        )
    }

    /// A finite number, zero or more.
    pub fn not_negative(&self) -> Result<f64> {
        self.number_that(
            |n| n >= 0.0,
            "must not be negative",
            "a number of 0 or more",
        )
    }

    /// A finite number for which a condition holds; else the error says `message` and what
    /// was `expected`.
    fn number_that(
        &self,
        holds: impl Fn(f64) -> bool,
        message: &str,
        expected: &str,
    ) -> Result<f64> {
        let number = self.number()?;
        match holds(number) {
            true => Ok(number),
            false => Err(self.error(message, expected)),
        }
    }

    /// A counting number, 1 or more.
    pub fn count(&self) -> Result<usize> {
        let DeValue::Integer(integer) = self.value.get_ref() else {
            return Err(self
                .error("not a whole number", "a whole number, 1 or more")
                .help("write the number alone, without decimal point, quotes or brackets"));
        };
        let count = usize::from_str_radix(integer.as_str(), integer.radix()).ok();
        count
            .filter(|&n| n > 0)
            .ok_or_else(|| self.error("not a count", "a whole number, 1 or more"))
    }

    /// A text.
    pub fn string(&self) -> Result<&'a str> {
        self.value.get_ref().as_str().ok_or_else(|| {
            self.error("not a text", "a text in quotes")
                .help("write the text alone, in quotes and without brackets")
        })
    }

    /// True for a text.
    pub fn is_string(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// True for a list.
    pub fn is_list(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// True for a table in braces.
    fn is_inline(&self) -> bool {
        let source = self.text.get(self.value.span()).unwrap_or_default();
        source.starts_with('{')
    }

    /// The entries of a list, named `path[1]`, `path[2]`, ...
    pub fn list(&self) -> Result<Vec<Value<'a>>> {
        let array = self
            .value
            .get_ref()
            .as_array()
            .ok_or_else(|| match self.value.get_ref() {
                DeValue::Table(_) if self.is_inline() => self
                    .error("a table, not a list of tables", "a list in [ ]")
                    .help("put [ ] around it if it is one table of several, as in [{ ... }]"),
                DeValue::Table(_) => self
                    .error("a table, not a list of tables", "a list in [ ]")
                    .help(format!("write [[{0}]] in place of [{0}]", self.path)),
                _ => self.error("not a list", "a list in [ ]"),
            })?;
        let entry = |(k, value)| Value {
            text: self.text,
            path: format!("{}[{}]", self.path, k + 1),
            value,
        };
        Ok(array.iter().enumerate().map(entry).collect())
    }

    /// A list of exactly N finite numbers.
    pub fn numbers<const N: usize>(&self, expected: &str) -> Result<[f64; N]> {
        let numbers = self
            .list()?
            .iter()
            .map(Value::number)
            .collect::<Result<Vec<f64>>>()?;
        <[f64; N]>::try_from(numbers).map_err(|_| self.error("wrong number of entries", expected))
    }

    /// A table.
    pub fn table(&self) -> Result<Table<'a>> {
        let entries = self
            .value
            .get_ref()
            .as_table()
            .ok_or_else(|| self.error("not a table", "a table, as in [name]"))?;
        Ok(Table {
            text: self.text,
            name: self.path.clone(),
            line: self.line(),
            entries,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of `read` at the key `touch` of a text.
    fn refusal(text: &str, read: impl Fn(&Value) -> Option<Error>) -> Error {
        let document = parse(text).unwrap();
        let value = Table::root(text, &document).get("touch").unwrap();
        read(&value).unwrap()
    }

    #[test]
    fn a_table_in_place_of_a_value_is_refused_with_its_line_and_advice() {
        let table = "\ntouch = {c = 1.5}\n";
        for (error, expected, help) in [
            (
                refusal(table, |value| value.positive().err()),
                "a number",
                "number alone",
            ),
            (
                refusal(table, |value| value.count().err()),
                "a whole number",
                "number alone",
            ),
            (
                refusal(table, |value| value.string().err()),
                "a text",
                "in quotes",
            ),
            (
                refusal(table, |value| value.list().err()),
                "a list in [ ]",
                "[{ ... }]",
            ),
        ] {
            assert_eq!(
                (error.line, error.field.as_deref(), error.found.as_deref()),
                (Some(2), Some("touch"), Some("{c = 1.5}"))
            );
            assert!(error.expected.unwrap().starts_with(expected));
            assert!(error.help.unwrap().contains(help), "{help}");
        }
        let headed = refusal("[touch]\nc = 1.5\n", |value| value.list().err());
        assert!(headed.help.unwrap().starts_with("write [[touch]]"));
    }

    #[test]
    fn a_name_that_occurs_twice_is_told_without_words_of_a_parser() {
        for (text, line, found) in [
            ("f = 1\ng = 2\nf = 3\n", 3, "f = 3"),
            ("[zones]\nhot = 1\n[zones]\n", 3, "[zones]"),
            ("touch = {c = 1, c = 2}\n", 1, "touch = {c = 1, c = 2}"),
        ] {
            let error = parse(text).unwrap_err();
            assert_eq!(
                (error.line, error.found.as_deref()),
                (Some(line), Some(found)),
                "{error}"
            );
            assert!(error.message.contains("twice"), "{error}");
            assert!(error.help.unwrap().contains("leave one"), "{text}");
        }
    }
}
