//! Number of things to use: all, as few as the scene needs, or a number.

use chladni_frf::{Error, ErrorKind, Result};
use std::fmt;
use std::str::FromStr;

/// Number of modes or actuators that a rendering may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Count {
    /// All there are.
    #[default]
    All,
    /// As few as the scene needs.
    Auto,
    /// So many, the best choice of them.
    Number(usize),
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Auto => f.write_str("auto"),
            Self::Number(number) => number.fmt(f),
        }
    }
}

impl FromStr for Count {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        match text {
            "all" => Ok(Self::All),
            "auto" => Ok(Self::Auto),
            _ => match text.parse::<usize>() {
                Ok(number) if number > 0 => Ok(Self::Number(number)),
                _ => Err(Error::new(ErrorKind::Usage, "no such number")
                    .found(text)
                    .expected("all, auto, or a whole number above 0")),
            },
        }
    }
}
