//! The studio's token. Other users of the machine reach the port too; only the token
//! distinguishes the owner.

use crate::limits::BYTES;
use chladni_frf::{Error, ErrorKind, Result};
use std::fmt::{Display, Formatter, Write};
use subtle::ConstantTimeEq;

/// A secret of one run, as hexadecimal digits.
pub struct Token(String);

impl Token {
    /// A new one, from the randomness of the operating system.
    ///
    /// # Errors
    /// A system that gives none.
    pub fn random() -> Result<Self> {
        let mut bytes = [0_u8; BYTES];
        getrandom::fill(&mut bytes).map_err(|error| {
            Error::new(
                ErrorKind::Io,
                format!("the system gives no random numbers: {error}"),
            )
            .help("without them the studio cannot keep other users of this machine out")
        })?;
        let mut digits = String::with_capacity(2 * BYTES);
        for byte in bytes {
            // writing to a text cannot fail
            let _ = write!(digits, "{byte:02x}");
        }
        Ok(Self(digits))
    }

    /// True for the token itself. The time of the comparison depends on the length of `shown`
    /// alone.
    pub fn is(&self, shown: &str) -> bool {
        self.0.as_bytes().ct_eq(shown.as_bytes()).into()
    }
}

impl Display for Token {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_itself_and_nothing_else() {
        let [one, other] = [Token::random().unwrap(), Token::random().unwrap()];
        let text = one.to_string();
        assert_eq!(text.len(), 2 * BYTES);
        assert!(text.bytes().all(|byte| byte.is_ascii_hexdigit()));
        assert!(one.is(&text) && !other.is(&text));
        assert!(!one.is("") && !one.is(&text[1..]) && !one.is(&format!("{text}0")));
    }
}
