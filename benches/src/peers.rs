//! Rows of other tools, as `benches/peers/peers.py` writes them for the same exported
//! files: they join the charts and nothing else.

use chladni_frf::{Error, Result};

/// The result of another tool on a case.
#[derive(Debug, Clone, PartialEq)]
pub struct PeerRow {
    /// Name of the case.
    pub case: String,
    /// Tool and method.
    pub method: String,
    /// Median time of a fit, s.
    pub time_s: f64,
    /// Rms error of natural frequencies over the bound of free residues, a missed mode
    /// counting as half its bandwidth.
    pub with_missed: f64,
    /// Modes missed per fit.
    pub missed: f64,
}

/// Columns that must be there; others are passed over.
const COLUMNS: [&str; 5] = [
    "case",
    "method",
    "time_s",
    "frequency_rmse_with_missed_over_crlb",
    "missed",
];

impl PeerRow {
    /// The rows of a table.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: a column is missing, a cell is no number.
    pub fn parse(text: &str) -> Result<Vec<Self>> {
        let mut lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
        let header: Vec<&str> = lines.next().map_or_else(Vec::new, |(_, line)| {
            line.split(',').map(str::trim).collect()
        });
        let mut places = [0; COLUMNS.len()];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            *place = header
                .iter()
                .position(|name| *name == column)
                .ok_or_else(|| {
                    Error::bad_data("a column is missing in the table of peers")
                        .field(column)
                        .found(header.join(", "))
                        .expected(COLUMNS.join(", "))
                        .help("write it with benches/peers/peers.py")
                })?;
        }
        lines
            .map(|(number, line)| {
                let cells: Vec<&str> = line.split(',').map(str::trim).collect();
                let cell = |k: usize| cells.get(places[k]).copied().unwrap_or_default();
                let value = |k: usize| {
                    cell(k).parse::<f64>().map_err(|_| {
                        let error = Error::bad_data("no number in the table of peers")
                            .field(COLUMNS[k])
                            .found(cell(k))
                            .expected("a number");
                        Error {
                            line: Some(number as u64 + 1),
                            ..error
                        }
                    })
                };
                Ok(Self {
                    case: cell(0).into(),
                    method: cell(1).into(),
                    time_s: value(2)?,
                    with_missed: value(3)?,
                    missed: value(4)?,
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_faults_by_line() {
        let text = "# made\nmethod,case,missed,time_s,frequency_rmse_with_missed_over_crlb,more\ntool,easy,0.5,2,3.5,x\n";
        let rows = PeerRow::parse(text).unwrap();
        let known = PeerRow {
            case: "easy".into(),
            method: "tool".into(),
            time_s: 2.0,
            with_missed: 3.5,
            missed: 0.5,
        };
        assert_eq!(rows, [known]);
        let error = PeerRow::parse(&text.replace(",2,", ",two,")).unwrap_err();
        assert_eq!(
            (error.line, error.field.as_deref()),
            (Some(3), Some("time_s"))
        );
        assert!(PeerRow::parse("case,method\n")
            .unwrap_err()
            .to_string()
            .contains("time_s"));
    }
}
