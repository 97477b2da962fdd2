//! Text: escaping for HTML and SVG, base64, numbers.

use base64::engine::general_purpose::STANDARD;
use base64::Engine;
pub(crate) use chladni_frf::counted;

/// `text` without characters that HTML or SVG would read as markup. Control characters, and marks
/// that reverse the direction of writing, become a visible box.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(' '),
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => out.push('□'),
            control if control.is_control() => out.push('□'),
            '\u{fffe}' | '\u{ffff}' => out.push('□'),
            plain => out.push(plain),
        }
    }
    out
}

/// Base64 with padding (RFC 4648, section 4).
pub(crate) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// `value` with `decimals` places and a true minus sign; without a sign where it rounds to zero.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return if value.is_nan() {
            "–".into()
        } else {
            format!("{}∞", if value < 0.0 { "−" } else { "" })
        };
    }
    let digits = format!("{:.decimals$}", value.abs());
    let is_zero = digits.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    format!("{}{digits}", if value < 0.0 && !is_zero { "−" } else { "" })
}

/// `value` with `digits` significant digits, and a power of ten where it is very large or small.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return fixed(value, 0);
    }
    let exponent = value.abs().log10().floor() as i32;
    if (-4..6).contains(&exponent) {
        return fixed(value, (digits as i32 - 1 - exponent).max(0) as usize);
    }
    let mantissa = fixed(value / 10f64.powi(exponent), digits - 1);
    format!("{mantissa}·10{}", superscript(exponent))
}

/// `value` to six significant digits, without trailing zeros.
pub(crate) fn plain(value: f64) -> String {
    let text = significant(value, 6);
    match text.contains('.') && !text.contains('·') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// An exponent in small raised digits.
pub(crate) fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = exponent.unsigned_abs().to_string();
    let raised: String = digits
        .bytes()
        .map(|digit| DIGITS[usize::from(digit - b'0')])
        .collect();
    format!("{}{raised}", if exponent < 0 { "⁻" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_and_controls_are_neutralised() {
        assert_eq!(
            escape("<script>alert('&')</script>\u{0}"),
            "&lt;script&gt;alert(&#39;&amp;&#39;)&lt;/script&gt;□"
        );
        assert_eq!(escape("a\u{202e}b"), "a□b");
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(fixed(-0.04, 1), "0.0");
        assert_eq!(fixed(-12.34, 1), "−12.3");
        assert_eq!(significant(0.00001234, 3), "1.23·10⁻⁵");
        assert_eq!(significant(1234.6, 3), "1235");
        assert_eq!(
            [plain(300.0), plain(12.5), plain(1000.0)],
            ["300", "12.5", "1000"]
        );
        assert_eq!(counted(1, "mode") + &counted(0, "line"), "1 mode0 lines");
    }
}
