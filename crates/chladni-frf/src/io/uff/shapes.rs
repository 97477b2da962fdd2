//! Mode shapes (datasets 55 and 2414): frequency and damping, for the listing. The shapes themselves are not read yet.
//!
//! | | 55 | 2414 |
//! |---|---|---|
//! | analysis type | record 6, second integer | record 9, second integer |
//! | normal mode (2) | record 8: frequency, modal mass, ζ, η | record 12: time, frequency, eigenvalue, mass, ζ, η |
//! | complex mode (3, 7) | record 8: Re λ, Im λ, ... in rad/s | record 13: Re λ, Im λ, ... |

use super::fields::{numbers, whole, Column, Record};
use crate::{Error, Result};
use std::f64::consts::TAU;

/// Frequency |s|/2π in Hz, and viscous damping ratio.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ModeNumbers {
    pub frequency_hz: Option<f64>,
    pub damping_ratio: Option<f64>,
}

const SIX_INTEGERS: [Column; 6] =
    [("model type", 10), ("analysis type", 10), ("data characteristic", 10), ("quantity", 10), ("data type", 10), ("values per node", 10)];
const SIX_REALS: [Column; 6] = [("real 1", 13), ("real 2", 13), ("real 3", 13), ("real 4", 13), ("real 5", 13), ("real 6", 13)];

/// Reads frequency and damping of dataset 55 or 2414.
///
/// # Errors
/// A record that is missing, or a field that is no number.
pub(super) fn read<'a>(number: u32, mut records: impl Iterator<Item = Record<'a>>, warnings: &mut Vec<String>) -> Result<ModeNumbers> {
    let (before_types, between) = if number == 55 { (5, 1) } else { (8, 2) };
    let too_short = || {
        let error = Error::bad_data("the dataset is too short").field("records before the values");
        error.found("too few").expected("the records of its definition").help("the file is cut short; copy or export it again")
    };
    let types = records.nth(before_types).ok_or_else(too_short)?;
    let analysis = whole(types, "analysis type", numbers(types, SIX_INTEGERS, warnings)?[1])?;
    let reals = numbers(records.nth(between).ok_or_else(too_short)?, SIX_REALS, warnings)?;
    if number == 55 {
        let [a, b, c, d, ..] = reals;
        return Ok(match analysis {
            2 => normal(a, c, d),
            3 | 7 => complex(a, b),
            5 => ModeNumbers { frequency_hz: Some(a), damping_ratio: None },
            _ => ModeNumbers::default(),
        });
    }
    let [_, frequency, _, _, viscous, hysteretic] = reals;
    let more = numbers(records.next().ok_or_else(too_short)?, SIX_REALS, warnings)?;
    Ok(match analysis {
        2 => normal(frequency, viscous, hysteretic),
        3 | 7 if more[0] == 0.0 && more[1] == 0.0 => normal(frequency, viscous, hysteretic),
        3 | 7 => complex(more[0], more[1]),
        5 => ModeNumbers { frequency_hz: Some(frequency), damping_ratio: None },
        _ => ModeNumbers::default(),
    })
}

/// A normal mode; without viscous damping, ζ = η/2.
fn normal(frequency_hz: f64, viscous: f64, hysteretic: f64) -> ModeNumbers {
    let ratio = if viscous == 0.0 { hysteretic / 2.0 } else { viscous };
    ModeNumbers { frequency_hz: Some(frequency_hz), damping_ratio: Some(ratio) }
}

/// s = −ζω + jω√(1−ζ²), rad/s.
fn complex(re: f64, im: f64) -> ModeNumbers {
    let omega = re.hypot(im);
    ModeNumbers { frequency_hz: Some(omega / TAU), damping_ratio: (omega > 0.0).then(|| -re / omega) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(number: u32, text: &str) -> Result<ModeNumbers> {
        read(number, text.lines().zip(1..).map(|(text, line)| Record { line, text: text.as_bytes() }), &mut Vec::new())
    }

    #[test]
    fn a_normal_mode_of_55_has_frequency_and_damping() {
        let ids = "NONE\n".repeat(5);
        let types = "         1         2         2         8         2         3\n         2         4         1         1\n";
        let text = format!("{ids}{types}  1.00000e+01  1.00000e+00  5.00000e-03  0.00000e+00\n");
        assert_eq!(read_text(55, &text).unwrap(), ModeNumbers { frequency_hz: Some(10.0), damping_ratio: Some(0.005) });
    }

    #[test]
    fn a_complex_mode_of_55_gives_the_undamped_frequency() {
        let ids = "NONE\n".repeat(5);
        let types = "         1         3         2         8         5         3\n         2         6         1         1\n";
        let text = format!("{ids}{types} -3.00000e+00  4.00000e+00  0.00000e+00  0.00000e+00\n");
        assert_eq!(read_text(55, &text).unwrap(), ModeNumbers { frequency_hz: Some(5.0 / TAU), damping_ratio: Some(0.6) });
    }

    #[test]
    fn modes_of_2414_are_read() {
        let head = "         1\nMode 1\n         1\n".to_string() + &"NONE\n".repeat(5);
        let integers = "         1         0         1         0         1         1         0         0\n         0         0\n";
        let normal = "  0.00000E+00  2.50000E+01  0.00000E+00  1.00000E+00  0.00000E+00  2.00000E-02\n";
        let zeros = "  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00\n";
        let types = |analysis: i32| format!("         1{analysis:10}         3         8         2         3\n");
        let text = format!("{head}{}{integers}{normal}{zeros}", types(2));
        assert_eq!(read_text(2414, &text).unwrap(), ModeNumbers { frequency_hz: Some(25.0), damping_ratio: Some(0.01) });
        let lambda = " -6.00000E+00  8.00000E+00\n";
        let text = format!("{head}{}{integers}{zeros}{lambda}", types(3));
        assert_eq!(read_text(2414, &text).unwrap(), ModeNumbers { frequency_hz: Some(10.0 / TAU), damping_ratio: Some(0.6) });
    }

    #[test]
    fn a_shape_that_ends_early_is_refused() {
        assert!(read_text(55, "NONE\nNONE\n").is_err());
        assert!(read_text(2414, "").is_err());
    }
}
