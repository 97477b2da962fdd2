//! Tables that end in the middle of their last number.

use super::text::{Cell, Dialect, Line};
use crate::limits::{CUT_DIGITS, CUT_ROWS_LEAST, CUT_ROWS_MOST};
use chladni_frf::Finding;
use std::borrow::Cow;

/// The form of a printed number: decimals, and digits of its exponent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Form {
    decimals: usize,
    /// `None` without an exponent.
    exponent: Option<usize>,
}

impl Form {
    fn of(cell: &str) -> Self {
        let (mantissa, exponent) = match cell.split_once(['e', 'E', 'd', 'D']) {
            Some((mantissa, exponent)) => (mantissa, Some(exponent)),
            None => (cell, None),
        };
        let digits = |text: &str| text.bytes().filter(u8::is_ascii_digit).count();
        Self {
            decimals: mantissa
                .split_once(['.', ','])
                .map_or(0, |(_, decimals)| digits(decimals)),
            exponent: exponent.map(digits),
        }
    }

    /// True where the beginning of a number of the form `whole` has this form.
    fn is_begin_of(self, whole: Self) -> bool {
        match (self.exponent, whole.exponent) {
            (None, _) if self.decimals < whole.decimals => true,
            (None, Some(_)) => self.decimals == whole.decimals,
            (Some(own), Some(digits)) => self.decimals == whole.decimals && own < digits,
            _ => false,
        }
    }
}

/// Significant digits of a number as it is printed.
fn digits(cell: &str) -> usize {
    let mantissa = cell.split(['e', 'E', 'd', 'D']).next().unwrap_or_default();
    let digits = mantissa.bytes().filter(u8::is_ascii_digit);
    digits.skip_while(|digit| *digit == b'0').count()
}

/// The finding about a last row without a line end whose last number is shorter than those
/// above it: they all have the same decimals and as many digits of the exponent, or several
/// times its digits. A whole number may end a table of long ones, as a phase of 180.
pub(super) fn last_number(text: &str, lines: &[Line<'_>], dialect: Dialect) -> Option<Finding> {
    let last = lines.last()?;
    let ends_the_text =
        last.text.as_bytes().as_ptr_range().end == text.as_bytes().as_ptr_range().end;
    if !ends_the_text || last.is_comment || last.text.ends_with(char::is_whitespace) {
        return None;
    }
    let columns = dialect.cells(last.text).len();
    let number = |line: &Line<'_>| {
        let mut cells = dialect.cells(line.text);
        let cell = cells.pop().filter(|_| cells.len() + 1 == columns);
        let cell = cell.map(Cow::into_owned)?;
        match dialect.number(&cell) {
            Cell::Value(value) => Some((cell, value)),
            _ => None,
        }
    };
    let (found, value) = number(last)?;
    let rows = lines.iter().rev().skip(1).filter(|line| !line.is_comment);
    let above = rows.map_while(number).take(CUT_ROWS_MOST);
    let above: Vec<String> = above.map(|(cell, _)| cell).collect();
    let neighbour = above.first().filter(|_| above.len() >= CUT_ROWS_LEAST)?;
    let whole = Form::of(neighbour);
    let breaks_form =
        Form::of(&found).is_begin_of(whole) && above.iter().all(|cell| Form::of(cell) == whole);
    let is_far_shorter = value.fract() != 0.0
        && (above.iter()).all(|cell| digits(cell) >= CUT_DIGITS * digits(&found));
    (breaks_form || is_far_shorter).then(|| {
        let words = format!(
            "line {} ends with `{found}`, shorter than the numbers above it, as `{neighbour}`, and \
             without a line end: the file may be cut within that number",
            last.number
        );
        Finding::caution("number-cut", words).help("copy or export the file again")
    })
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
        let comma = "f;re;im\n".to_owned() + &"1;0,5;0,25\n".repeat(12) + "30;0,5;0";
        assert!(told(&comma).is_some());
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
        ] {
            assert_eq!(told(&text), None, "{text}");
        }
    }
}
