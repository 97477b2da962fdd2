//! Degrees of freedom: a node and a direction, as text `12:+Z`.

use std::fmt;
use std::str::FromStr;

/// Direction of a DOF, by the codes of the universal file format: 0 scalar, ±1 X, ±2 Y,
/// ±3 Z, ±4 RX, ±5 RY, ±6 RZ.
///
/// A negative code means that the measured positive sense is the negative axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Direction(i8);

impl Direction {
    /// No direction (pressure, temperature, an actuator's voltage).
    pub const SCALAR: Self = Self(0);
    /// Out of the plane of a plate that lies in x, y.
    pub const PLUS_Z: Self = Self(3);

    /// From the code −6..=6; `None` outside.
    pub fn from_code(code: i64) -> Option<Self> {
        (-6..=6).contains(&code).then_some(Self(code as i8))
    }
    /// The code, −6..=6.
    pub fn code(self) -> i8 {
        self.0
    }
    /// +1 or −1 (scalar: +1).
    pub fn sign(self) -> f64 {
        if self.0 < 0 {
            -1.0
        } else {
            1.0
        }
    }
    /// The same axis in its positive sense.
    pub fn axis(self) -> Self {
        Self(self.0.abs())
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMES: [&str; 7] = ["S", "X", "Y", "Z", "RX", "RY", "RZ"];
        let sign = match self.0 {
            0 => "",
            code if code < 0 => "-",
            _ => "+",
        };
        write!(f, "{sign}{}", NAMES[self.0.unsigned_abs() as usize])
    }
}

impl FromStr for Direction {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let trimmed = text.trim();
        let (negative, name) = match (
            trimmed.strip_prefix('-').or(trimmed.strip_suffix('-')),
            trimmed,
        ) {
            (Some(rest), _) => (true, rest),
            (None, all) => (
                false,
                all.strip_prefix('+')
                    .or(all.strip_suffix('+'))
                    .unwrap_or(all),
            ),
        };
        let code = match name.to_ascii_uppercase().as_str() {
            "S" | "SCALAR" | "" => 0,
            "X" => 1,
            "Y" => 2,
            "Z" => 3,
            "RX" => 4,
            "RY" => 5,
            "RZ" => 6,
            _ => {
                return Err(format!(
                    "`{text}` is no direction; write X, Y, Z, RX, RY, RZ or S with a sign"
                ))
            }
        };
        Ok(Self(if negative { -code } else { code }))
    }
}

/// Degree of freedom: where and in which direction something moves or is pushed.
///
/// Accepts `12:+Z`, `12:Z`, `12Z`, `12Z+`, `+12Z`, `comp:12:+Z`, `12:-RX`, `12:S`; prints
/// `12:+Z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Dof {
    /// Node label: any number, never an index.
    pub node: u64,
    /// Direction at that node.
    pub direction: Direction,
}

impl Dof {
    /// A DOF at `node` along `direction`.
    pub fn new(node: u64, direction: Direction) -> Self {
        Self { node, direction }
    }
    /// True where both name the same node and axis, whatever their sense.
    pub fn same_axis(self, other: Self) -> bool {
        self.node == other.node && self.direction.axis() == other.direction.axis()
    }
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.node, self.direction)
    }
}

impl FromStr for Dof {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is no DOF; write node and direction like 12:+Z");
        let trimmed = text.trim();
        // comp:12:+Z -> 12:+Z
        let mut parts: Vec<&str> = trimmed.split(':').map(str::trim).collect();
        if parts.len() == 3 {
            parts.remove(0);
        }
        match parts.as_slice() {
            [node, direction] => {
                let node = node.parse().map_err(|_| wrong())?;
                if direction.is_empty() {
                    return Err(wrong());
                }
                Ok(Self::new(node, direction.parse().map_err(|_| wrong())?))
            }
            [compact] => {
                let (sign, rest) = match compact.strip_prefix(['+', '-']) {
                    Some(rest) => (&compact[..1], rest),
                    None => ("", *compact),
                };
                let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
                let (node, direction) = rest.split_at(digits);
                if direction.is_empty() || (!sign.is_empty() && direction.contains(['+', '-'])) {
                    return Err(wrong());
                }
                let node = node.parse().map_err(|_| wrong())?;
                Ok(Self::new(
                    node,
                    format!("{sign}{direction}").parse().map_err(|_| wrong())?,
                ))
            }
            _ => Err(wrong()),
        }
    }
}

impl serde::Serialize for Dof {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for Dof {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = <std::borrow::Cow<'de, str>>::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_formats_section_6_is_read() {
        for text in ["12:+Z", "12:Z", "12Z", "12Z+", "+12Z", "comp:12:+Z"] {
            assert_eq!(text.parse::<Dof>().unwrap().to_string(), "12:+Z", "{text}");
        }
        for (text, printed) in [
            ("12:-RX", "12:-RX"),
            ("12:S", "12:S"),
            ("-7Y", "7:-Y"),
            ("4294967297:X", "4294967297:+X"),
        ] {
            assert_eq!(text.parse::<Dof>().unwrap().to_string(), printed);
        }
    }

    #[test]
    fn what_is_no_dof_is_refused() {
        for text in [
            "", "Z", "12", "12:", "a:Z", "12:Q", "-1:Z", "1:2:3:Z", "+12Z+",
        ] {
            assert!(text.parse::<Dof>().is_err(), "{text}");
        }
    }
}
