//! The text of a unit label: products of powers, from left to right.

use super::{named, Unit, ONE};
use crate::limits::{LARGEST_POWER, LONGEST_LABEL, PARSER_MAX_DEPTH};

/// The unit that a label names; `None` for an empty label or one that is not understood.
/// Brackets of any kind are parentheses.
pub(crate) fn parse(label: &str) -> Option<Unit> {
    let text = label.trim();
    if text.is_empty() || text.len() > LONGEST_LABEL {
        return None;
    }
    let plain = |c| match c {
        '[' | '{' => '(',
        ']' | '}' => ')',
        other => other,
    };
    let chars: Vec<char> = text
        .chars()
        .filter(|c| !c.is_control())
        .map(plain)
        .collect();
    let mut parser = Parser {
        chars: &chars,
        at: 0,
    };
    let unit = parser.product(0)?;
    (parser.at == chars.len() && unit.factor.is_finite() && unit.factor > 0.0).then_some(unit)
}

struct Parser<'a> {
    chars: &'a [char],
    at: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }
    fn skip_blanks(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// factor {(* | / | · | blank) factor}, from left to right.
    fn product(&mut self, depth: usize) -> Option<Unit> {
        let mut unit = self.factor(depth)?;
        loop {
            self.skip_blanks();
            match self.peek() {
                None | Some(')') => return Some(unit),
                Some('/') => {
                    self.at += 1;
                    unit = unit.per(self.factor(depth)?);
                }
                Some('*' | '·' | '⋅' | '.' | '×' | '-') => {
                    self.at += 1;
                    unit = unit.times(self.factor(depth)?);
                }
                Some(_) => unit = unit.times(self.factor(depth)?),
            }
        }
    }

    /// (name | 1 | parenthesis) [power].
    fn factor(&mut self, depth: usize) -> Option<Unit> {
        self.skip_blanks();
        let base = match self.peek()? {
            '(' if depth < PARSER_MAX_DEPTH => {
                self.at += 1;
                let inner = self.product(depth + 1)?;
                if self.peek() != Some(')') {
                    return None;
                }
                self.at += 1;
                inner
            }
            '1' => {
                self.at += 1;
                return Some(ONE);
            }
            _ => {
                let start = self.at;
                while self.peek().is_some_and(|c| {
                    (c.is_alphabetic() && superscript(c).is_none()) || matches!(c, '"' | '°')
                }) {
                    self.at += 1;
                }
                named(&self.chars[start..self.at].iter().collect::<String>())?
            }
        };
        Some(base.power(self.exponent()?))
    }

    /// `^2`, `**2`, `2`, `-1`, `²`, `⁻¹`, or nothing: 1.
    fn exponent(&mut self) -> Option<i32> {
        let rest = &self.chars[self.at..];
        let marker = match rest {
            ['^', ..] => 1,
            ['*', '*', ..] => 2,
            _ => 0,
        };
        self.at += marker;
        let parenthesis = marker > 0 && self.peek() == Some('(');
        self.at += usize::from(parenthesis);
        let mut sign = 1;
        if let Some(c @ ('-' | '+' | '⁻')) = self.peek() {
            if self
                .chars
                .get(self.at + 1)
                .is_some_and(|&next| next.is_ascii_digit() || superscript(next).is_some())
            {
                sign = if c == '+' { 1 } else { -1 };
                self.at += 1;
            }
        }
        let digit = self.peek().and_then(|c| c.to_digit(10).or(superscript(c)));
        match digit {
            Some(digit) => {
                self.at += 1;
                if parenthesis {
                    if self.peek() != Some(')') {
                        return None;
                    }
                    self.at += 1;
                }
                Some(sign * digit as i32).filter(|e| e.abs() <= LARGEST_POWER)
            }
            None => (marker == 0 && sign == 1).then_some(1),
        }
    }
}

fn superscript(c: char) -> Option<u32> {
    "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|s| s == c).map(|k| k as u32)
}
