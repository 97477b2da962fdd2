//! Assignment of actuators to the channels of a converter.

use crate::tolerances::MOST_CHANNELS;
use chladni_frf::{Dof, Error, Result};

/// A channel of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapped {
    /// Counted from 1.
    pub channel: usize,
    /// Its actuator.
    pub reference: Dof,
    /// Factor on its samples, as V/N of its amplifier and coil.
    pub gain: f64,
}

/// An error of line `line`, counted from 0, in a field with what was found there.
fn bad(line: usize, message: &str, [field, found]: [&str; 2], expected: &str) -> Error {
    Error::bad_data(message)
        .at_line(line as u64 + 1)
        .field(field)
        .found(found)
        .expected(expected)
}

fn cells(line: &str) -> Vec<String> {
    line.split(',').map(|cell| cell.trim().to_owned()).collect()
}

impl Mapped {
    /// From two cells, or three with a gain.
    fn parse(line: usize, cells: &[String]) -> Result<Self> {
        let channel = cells[0]
            .parse::<usize>()
            .ok()
            .filter(|channel| (1..=MOST_CHANNELS).contains(channel))
            .ok_or_else(|| {
                let expected = format!("a number from 1 to {MOST_CHANNELS}");
                bad(line, "no such channel", ["channel", &cells[0]], &expected)
            })?;
        let reference = cells[1].parse::<Dof>().map_err(|_| {
            let found = ["reference", &*cells[1]];
            bad(line, "no DOF", found, "a reference like 101:+Z")
        })?;
        let gain = match cells.get(2) {
            Some(cell) => cell.parse::<f64>().unwrap_or(f64::NAN),
            None => 1.0,
        };
        if !(gain.is_finite() && gain != 0.0) {
            return Err(bad(
                line,
                "no usable gain",
                ["gain", &cells[2]],
                "a finite number other than 0",
            ));
        }
        Ok(Self {
            channel,
            reference,
            gain,
        })
    }
}

/// Assignment of actuators to channels.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMap(pub Vec<Mapped>);

impl ChannelMap {
    /// Actuators in their order, without gains.
    pub(crate) fn plain(references: &[Dof]) -> Self {
        let mapped = references.iter().enumerate().map(|(k, &reference)| Mapped {
            channel: k + 1,
            reference,
            gain: 1.0,
        });
        Self(mapped.collect())
    }

    /// From the text of a CSV file `channel,reference,gain`; the gain may be left out.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with the line: another header, no channel number, no DOF, a
    /// gain of 0, a channel or an actuator twice.
    pub fn parse(text: &str) -> Result<Self> {
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k, line.trim().trim_start_matches('\u{feff}')))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let header = lines.next().map(|(k, line)| (k, cells(line)));
        let with_gain = match &header {
            Some((_, names)) if *names == ["channel", "reference", "gain"] => true,
            Some((_, names)) if *names == ["channel", "reference"] => false,
            other => {
                let (line, found) = other.clone().unwrap_or_default();
                return Err(bad(
                    line,
                    "not a channel map",
                    ["header", &found.join(",")],
                    "channel,reference,gain",
                ));
            }
        };
        let mut mapped: Vec<Mapped> = Vec::new();
        for (line, text) in lines {
            let cells = cells(text);
            if cells.len() != 2 + usize::from(with_gain) {
                return Err(bad(
                    line,
                    "wrong number of cells",
                    ["row", text],
                    "one cell for each name of the header",
                ));
            }
            let row = Mapped::parse(line, &cells)?;
            if mapped.iter().any(|m| m.channel == row.channel) {
                return Err(bad(
                    line,
                    "a channel occurs twice",
                    ["channel", &cells[0]],
                    "each channel once",
                ));
            }
            if mapped.iter().any(|m| m.reference.same_axis(row.reference)) {
                return Err(bad(
                    line,
                    "an actuator occurs twice",
                    ["reference", &cells[1]],
                    "each actuator once",
                ));
            }
            mapped.push(row);
        }
        mapped.sort_by_key(|mapped| mapped.channel);
        Ok(Self(mapped))
    }
}
