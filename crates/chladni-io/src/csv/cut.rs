//! Tables that end in the middle of their last number.

use super::text::{Cell, Dialect, Line};
use crate::limits::{CUT_DIGITS, CUT_ROWS_LEAST, CUT_ROWS_MOST};
use chladni_frf::Finding;
use std::borrow::Cow;

/// A number as it is printed.
struct Printed {
    text: String,
    value: f64,
    decimals: usize,
    /// Digits of the mantissa from the first that is not zero.
    digits: usize,
    /// Sign and digits of the exponent; `None` without one.
    exponent: Option<String>,
}

impl Printed {
    fn new(text: String, value: f64) -> Self {
        let (mantissa, exponent) = match text.split_once(['e', 'E', 'd', 'D']) {
            Some((mantissa, exponent)) => (mantissa, Some(exponent.to_owned())),
            None => (text.as_str(), None),
        };
        let count = |text: &str| text.bytes().filter(u8::is_ascii_digit).count();
        let decimals = mantissa.split_once(['.', ',']);
        Self {
            value,
            decimals: decimals.map_or(0, |(_, decimals)| count(decimals)),
            digits: count(mantissa.trim_start_matches(|c| !('1'..='9').contains(&c))),
            exponent,
            text,
        }
    }

    /// The digits of the exponent.
    fn exponent_digits(&self) -> Option<&str> {
        let exponent = self.exponent.as_deref()?;
        Some(exponent.trim_start_matches(['+', '-']))
    }

    /// True where this number may be the beginning of one that is printed as those above are.
    fn is_cut(&self, above: &[Self]) -> bool {
        if self.value == 0.0 {
            return false;
        }
        if let Some(digits) = self.exponent_digits() {
            return self.is_cut_in_exponent(digits, above);
        }
        let is_whole = self.value.fract() == 0.0;
        let decimals = above[0].decimals;
        let is_even = above.iter().all(|other| other.decimals == decimals);
        let have_exponents = above.iter().all(|other| other.exponent.is_some());
        if have_exponents && (1.0..10.0).contains(&self.value.abs()) {
            // the mantissa alone
            return true;
        }
        let is_shorter = is_even && self.decimals < decimals;
        let lacks_exponent = is_even && have_exponents && self.decimals == decimals;
        let is_far_shorter = (above.iter()).all(|other| other.digits >= CUT_DIGITS * self.digits);
        !is_whole && (is_shorter || lacks_exponent || is_far_shorter)
    }

    /// True where the exponent is cut: no program prints `e-0`, and one that fills exponents
    /// with zeros (`e-05`) prints no shorter ones.
    fn is_cut_in_exponent(&self, digits: &str, above: &[Self]) -> bool {
        let is_zero = digits.bytes().all(|digit| digit == b'0');
        let exponents = || above.iter().filter_map(Self::exponent_digits);
        let is_filled = exponents().any(|other| other.len() > 1 && other.starts_with('0'));
        let least = exponents().map(str::len).min().unwrap_or(0);
        let is_negative = self.exponent.as_deref().is_some_and(|e| e.starts_with('-'));
        (is_zero && is_negative) || ((is_filled || is_zero) && digits.len() < least)
    }
}

/// The finding about a last row without a line end whose last number is shorter than those
/// above it: it lacks their exponent, or digits of it; it has fewer decimals than they all
/// have; or, where their decimals vary, several times fewer digits. A whole number may end a
/// table of long ones, as a phase of 180 or a coherence of 1, if it lacks no exponent.
pub(super) fn last_number(text: &str, lines: &[Line<'_>], dialect: Dialect) -> Option<Finding> {
    let last = lines.last()?;
    let ends_the_text =
        last.text.as_bytes().as_ptr_range().end == text.as_bytes().as_ptr_range().end;
    // a closing quote ends the number
    let is_ended = last.text.ends_with(|c: char| c.is_whitespace() || c == '"');
    if !ends_the_text || last.is_comment || is_ended {
        return None;
    }
    let columns = dialect.cells(last.text).len();
    let number = |line: &Line<'_>| {
        let mut cells = dialect.cells(line.text);
        let cell = cells.pop().filter(|_| cells.len() + 1 == columns);
        let cell = cell.map(Cow::into_owned)?;
        match dialect.number(&cell) {
            Cell::Value(value) => Some(Printed::new(cell, value)),
            _ => None,
        }
    };
    let found = number(last)?;
    let rows = lines.iter().rev().skip(1).filter(|line| !line.is_comment);
    let above: Vec<Printed> = rows.map_while(number).take(CUT_ROWS_MOST).collect();
    if above.len() < CUT_ROWS_LEAST || !found.is_cut(&above) {
        return None;
    }
    let longer = above
        .iter()
        .find(|other| other.text.len() > found.text.len());
    let words = format!(
        "line {} ends with `{}` and has no line end; the numbers above it are longer, such as \
         `{}`. The file may be cut within that number",
        last.number,
        found.text,
        longer.unwrap_or(&above[0]).text
    );
    Some(
        Finding::caution("number-cut", words)
            .help("copy or export the file again; if the number is whole, end the line"),
    )
}

#[cfg(test)]
mod tests {
    use super::super::remarks::lines_and_remarks;
    use super::*;

    fn told(text: &str) -> Option<String> {
        let (lines, _) = lines_and_remarks(text);
        let dialect = Dialect::detect(&lines).unwrap();
        last_number(text, &lines, dialect).map(|finding| finding.text)
    }

    fn table(cell: &str, rows: usize) -> String {
        (0..rows).fold("f,re,im\n".into(), |text, k| {
            text + &format!("{},1.5e-3,{cell}\n", 10 + k)
        })
    }

    #[test]
    fn a_last_number_shorter_than_all_above_it_may_be_cut() {
        for (whole, last) in [
            ("2.5e-4", "2"),
            ("2.5e-4", "2."),
            ("2.5e-4", "2.5"),
            ("2.50e-04", "2.50e-0"),
            ("0.01126", "0.011"),
            ("-1.5D+03", "-1.5"),
        ] {
            let text = table(whole, 12) + "30,1.5e-3," + last;
            let told = told(&text).unwrap_or_else(|| panic!("{text}"));
            assert!(told.contains("line 14") && told.contains(last), "{told}");
        }
        let varied = [
            "1.4246217913",
            "0.0159036710234",
            "-1.59e-300",
            "1.7637163421e-05",
        ];
        let varied: String = (0..12)
            .map(|k| {
                format!(
                    "{k},0.5,{}\n",
                    varied[k % 4].replace("1.59", "1.5903671023")
                )
            })
            .collect();
        assert!(told(&(varied + "12,0.5,1.1")).is_some());
        let comma = "f;re;im\n".to_owned() + &"1;0,5;0,25\n".repeat(12) + "30;0,5;0,2";
        assert!(told(&comma).is_some());
        // numbers of any length, of which the last is cut in its exponent
        let long = |k: usize| format!("-{}.{}", 1 + k, "3".repeat(k + 5));
        for (above, last) in [
            ("", "-1.4246217913e-0"),
            ("e-08", "-1.4246217913"),
            ("e-08", "1.4e-0"),
        ] {
            let rows: String = (0..12)
                .map(|k| format!("{k},0.5,{}{above}\n", long(k % 9)))
                .collect();
            assert!(told(&(rows + "12,0.5," + last)).is_some(), "{above} {last}");
        }
    }

    #[test]
    fn ordinary_files_without_a_last_line_end_are_left_alone() {
        let uneven = table("2.25", 12) + "30,1,2.5\n31,1,2.25\n32,1,2";
        let ended = table("2.25", 12) + "30,1,2.5\n";
        let few = table("2.25", 5) + "30,1,2.5";
        let longer = table("2.25", 12) + "30,1,2.255";
        let whole = table("2", 12) + "30,1,1";
        let exponent = table("2.5e-99", 12) + "30,1,2.5e-100";
        let remark = table("2.25", 12) + "30,1,2.5\n# unit = m/s/N";
        let blank = table("2.25", 12) + "30,1,2.5 ";
        // the last line of a phase or a coherence may be a whole number
        let long = (0..12).fold(String::new(), |text, k| {
            text + &format!("{k},0.5,-179.98{}\n", "3".repeat(k + 1))
        });
        let [half_turn, exact] = ["180.0", "0"].map(|cell| format!("{long}12,0.5,{cell}"));
        let shorter = long + "12,0.5,-179.98";
        let shorter_row = table("2.25", 12) + "30,1.5";
        let short_exponent = table("2.5432E-10", 12) + "30,1.5e-3,1.1234E-9";
        let zero = table("2.5432e-10", 12) + "30,1.5e-3,0.0000e+0";
        let one = table("0.998", 12) + "30,1.5e-3,1";
        let quoted = table("\"8.442\"", 12) + "30,1.5e-3,\"2.5\"";
        let no_exponent = table("2.5e-05", 12) + "30,1.5e-3,0.00012";
        for text in [
            uneven,
            ended,
            few,
            longer,
            whole,
            exponent,
            remark,
            blank,
            half_turn,
            exact,
            shorter,
            shorter_row,
            short_exponent,
            zero,
            one,
            quoted,
            no_exponent,
        ] {
            assert_eq!(told(&text), None, "{text}");
        }
    }
}
