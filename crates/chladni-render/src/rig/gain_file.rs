//! A calibration that a person writes: CSV, a row for each channel and frequency.
//!
//! Columns in any order: `reference` (left out: every channel), `frequency_hz` (left out:
//! every frequency), `gain` or `gain_db` with `phase_deg` (left out: 0), or `re` and `im`,
//! and `std` where it is known.

use super::gain_table::GainTable;
use chladni_frf::{Dof, Error, Result};
use num_complex::Complex64;

const COLUMNS: [&str; 8] = [
    "reference",
    "frequency_hz",
    "gain",
    "gain_db",
    "phase_deg",
    "re",
    "im",
    "std",
];
const EXPECTED: &str = "reference,frequency_hz,gain,phase_deg or reference,frequency_hz,re,im, \
                        with std where it is known";

/// The tables of a CSV file, in the order of their first rows.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] with line and column: an unknown column, no gain, a
/// cell that is no number, or what [`GainTable::check`] finds.
pub(super) fn parse(text: &str) -> Result<Vec<GainTable>> {
    let mut header: Option<Header> = None;
    let mut tables: Vec<GainTable> = Vec::new();
    for (number, line) in (1u64..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(header) = &header else {
            header = Some(Header::of(&cells).map_err(|error| error.at_line(number))?);
            continue;
        };
        let row = header.row(&cells).map_err(|error| error.at_line(number))?;
        let same = |table: &&mut GainTable| match (table.reference, row.reference) {
            (Some(known), Some(own)) => known.same_axis(own),
            (known, own) => known == own,
        };
        match tables.iter_mut().find(same) {
            Some(table) => row.push_to(table),
            None => {
                let mut table = GainTable {
                    reference: row.reference,
                    ..GainTable::default()
                };
                row.push_to(&mut table);
                tables.push(table);
            }
        }
    }
    if tables.is_empty() {
        return Err(Error::bad_data("not a calibration file")
            .found("no row of gains")
            .expected(format!("a header {EXPECTED}, then rows")));
    }
    tables.iter().try_for_each(GainTable::check)?;
    Ok(tables)
}

/// Places of the columns.
struct Header(Vec<usize>);

/// A row.
struct Row {
    reference: Option<Dof>,
    frequency_hz: Option<f64>,
    gain: f64,
    phase_deg: f64,
    std: Option<f64>,
}

impl Row {
    fn push_to(&self, table: &mut GainTable) {
        table.frequency_hz.extend(self.frequency_hz);
        table.gain.push(self.gain);
        table.phase_deg.push(self.phase_deg);
        table.std.extend(self.std);
    }
}

impl Header {
    fn of(cells: &[&str]) -> Result<Self> {
        let wrong = |message: &str, found: &str| {
            Error::bad_data(message)
                .field("header")
                .found(found)
                .expected(EXPECTED)
        };
        let mut columns = Vec::with_capacity(cells.len());
        for name in cells {
            let Some(column) = COLUMNS.iter().position(|known| known == name) else {
                return Err(wrong("not a calibration file", name)
                    .help("give a calibration file of Chladni, or a table of gains (CSV)"));
            };
            if columns.contains(&column) {
                return Err(wrong("a column occurs twice", name));
            }
            columns.push(column);
        }
        let has = |name: &str| columns.iter().any(|&column| COLUMNS[column] == name);
        let complex = has("re") && has("im");
        let forms = [has("gain"), has("gain_db"), has("re") || has("im")];
        let one_form = forms.iter().filter(|form| **form).count() == 1;
        if !one_form || (forms[2] && (!complex || has("phase_deg"))) {
            let message = "one of gain, gain_db, or re and im must be there";
            return Err(wrong(message, &cells.join(",")));
        }
        Ok(Self(columns))
    }

    fn row(&self, cells: &[&str]) -> Result<Row> {
        if cells.len() != self.0.len() {
            return Err(Error::bad_data("wrong number of cells")
                .found(format!("{} cells", cells.len()))
                .expected(format!("{}, as the header", self.0.len())));
        }
        let cell = |name: &str| {
            let known = self.0.iter().position(|&column| COLUMNS[column] == name);
            known.map(|place| cells[place])
        };
        let number = |name: &str| {
            let value = |cell: &str| {
                let value = cell.parse().ok().filter(|value: &f64| value.is_finite());
                value.ok_or_else(|| {
                    Error::bad_data("not a number")
                        .field(name)
                        .found(cell)
                        .expected("a finite number")
                })
            };
            cell(name).map(value).transpose()
        };
        let dof = |cell: &str| {
            cell.parse::<Dof>().map_err(|_| {
                Error::bad_data("no DOF")
                    .field("reference")
                    .found(cell)
                    .expected("a reference like 101:+Z")
                    .help("leave the column out where a gain holds for every channel")
            })
        };
        let (gain, phase_deg) = match (number("re")?, number("im")?) {
            (Some(re), Some(im)) => {
                let value = Complex64::new(re, im);
                (value.norm(), value.arg().to_degrees())
            }
            _ => {
                let of_level = number("gain_db")?.map(|level| 10f64.powf(level / 20.0));
                let gain = number("gain")?.or(of_level).unwrap_or(f64::NAN);
                (gain, number("phase_deg")?.unwrap_or(0.0))
            }
        };
        Ok(Row {
            reference: cell("reference").map(dof).transpose()?,
            frequency_hz: number("frequency_hz")?,
            gain,
            phase_deg,
            std: number("std")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_may_be_written_in_every_way() {
        let plain = parse("reference,frequency_hz,gain,phase_deg\n101:+Z,300,2,90\n").unwrap();
        for text in [
            "# bench\nphase_deg,gain_db,frequency_hz,reference\n90,6.020599913279624,300,101:+Z\n",
            "reference,frequency_hz,re,im\n101:+Z,300,0,2\n",
        ] {
            let other = parse(text).unwrap();
            let [own, other] = [&plain[0], &other[0]].map(|table| table.at(300.0).unwrap().factor);
            assert!((own - other).norm() < 1e-14, "{text}: {own} {other}");
        }
        let all = parse("gain,std\n0.5,0.01\n").unwrap();
        assert_eq!((all.len(), all[0].reference), (1, None));
        assert_eq!(all[0].at(77.0).unwrap().std_relative, Some(0.02));
        assert!(parse("gain_db\n30\n").is_ok());
    }

    #[test]
    fn a_wrong_file_is_refused_with_line_and_column() {
        for (text, line, field) in [
            ("reference,gian\n101:+Z,1\n", Some(1), "header"),
            ("reference,frequency_hz\n101:+Z,300\n", Some(1), "header"),
            ("reference,re\n101:+Z,1\n", Some(1), "header"),
            ("gain,gain\n1,1\n", Some(1), "header"),
            ("reference,gain\n101:+Z,two\n", Some(2), "gain"),
            ("reference,gain\nhundred,2\n", Some(2), "reference"),
            ("frequency_hz,gain\n300,1\n300,1\n", None, "frequency_hz"),
            ("gain\n1\n1\n", None, "gain"),
            ("gain\n-1\n", None, "gain"),
            ("gain\n98\n", None, "gain"),
            ("gain_db\n40\n", None, "gain"),
        ] {
            let error = parse(text).unwrap_err();
            assert_eq!(
                (error.line, error.field.as_deref()),
                (line, Some(field)),
                "{text}"
            );
        }
        assert!(parse("# nothing\n")
            .unwrap_err()
            .to_string()
            .contains("no row"));
        assert!(parse("gain\n1,2\n")
            .unwrap_err()
            .to_string()
            .contains("2 cells"));
    }
}
