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
            self.error(
                "not a number that can be used",
                format!("a number between -{LARGEST:e} and {LARGEST:e}"),
            )
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
            return Err(self.error("not a whole number", "a whole number, 1 or more"));
        };
        let count = usize::from_str_radix(integer.as_str(), integer.radix()).ok();
        count
            .filter(|&n| n > 0)
            .ok_or_else(|| self.error("not a count", "a whole number, 1 or more"))
    }

    /// A text.
    pub fn string(&self) -> Result<&'a str> {
        self.value
            .get_ref()
            .as_str()
            .ok_or_else(|| self.error("not a text", "a text in quotes"))
    }

    /// True for a text.
    pub fn is_string(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// True for a list.
    pub fn is_list(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// The entries of a list, named `path[1]`, `path[2]`, ...
    pub fn list(&self) -> Result<Vec<Value<'a>>> {
        let array = self
            .value
            .get_ref()
            .as_array()
            .ok_or_else(|| match self.value.get_ref() {
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
