//! Memory that a command may take.

/// Default of `--memory`.
pub const MEMORY: &str = "2G";

/// `500M`, `2G`, `2GiB` or a plain number of bytes.
pub fn parse_memory(text: &str) -> std::result::Result<u64, String> {
    let wrong = || "no size such as 500M or 2G".to_owned();
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match text[number.len()..]
        .to_ascii_lowercase()
        .trim_end_matches('b')
        .trim_end_matches('i')
    {
        "" => 0,
        "k" => 1,
        "m" => 2,
        "g" => 3,
        "t" => 4,
        _ => return Err(wrong()),
    };
    let number: f64 = number.parse().map_err(|_| wrong())?;
    let bytes = number * 1024_f64.powi(power);
    match bytes.is_finite() && (1.0..=2f64.powi(60)).contains(&bytes) {
        true => Ok(bytes as u64),
        false => Err(wrong()),
    }
}

/// A size for people.
pub fn in_mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / (1 << 20) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, bytes) in [
            ("10", 10),
            ("1K", 1024),
            ("2G", 2 << 30),
            ("2GiB", 2 << 30),
            ("1.5m", 3 << 19),
            ("3kb", 3072),
        ] {
            assert_eq!(parse_memory(text), Ok(bytes), "{text}");
        }
        for text in ["", "G", "-1", "1X", "nan", "1e99", "0"] {
            assert!(parse_memory(text).is_err(), "{text}");
        }
    }
}
