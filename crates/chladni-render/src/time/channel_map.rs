//! Assignment of actuators to the channels of a converter.

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

/// Assignment of actuators to channels.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMap(pub Vec<Mapped>);

impl ChannelMap {
    /// Most channels of a converter.
    const MOST: usize = 1024;

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
        let bad = |line: usize, message: &str, field: &str, found: &str, expected: &str| {
            Error::bad_data(message)
                .at_line(line as u64 + 1)
                .field(field)
                .found(found)
                .expected(expected)
        };
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k, line.trim().trim_start_matches('\u{feff}')))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let cells = |line: &str| -> Vec<String> {
            line.split(',').map(|cell| cell.trim().to_owned()).collect()
        };
        let header = lines.next().map(|(k, line)| (k, cells(line)));
        let with_gain = match &header {
            Some((_, names)) if *names == ["channel", "reference", "gain"] => true,
            Some((_, names)) if *names == ["channel", "reference"] => false,
            other => {
                let (line, found) = other.clone().unwrap_or_default();
                return Err(bad(
                    line,
                    "not a channel map",
                    "header",
                    &found.join(","),
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
                    "row",
                    text,
                    "one cell for each name of the header",
                ));
            }
            let channel = cells[0]
                .parse::<usize>()
                .ok()
                .filter(|channel| (1..=Self::MOST).contains(channel))
                .ok_or_else(|| {
                    bad(
                        line,
                        "no such channel",
                        "channel",
                        &cells[0],
                        "a number from 1 to 1024",
                    )
                })?;
            let reference = cells[1].parse::<Dof>().map_err(|_| {
                bad(
                    line,
                    "no DOF",
                    "reference",
                    &cells[1],
                    "a reference like 101:+Z",
                )
            })?;
            let gain = if with_gain {
                cells[2].parse::<f64>().unwrap_or(f64::NAN)
            } else {
                1.0
            };
            if !(gain.is_finite() && gain != 0.0) {
                return Err(bad(
                    line,
                    "no usable gain",
                    "gain",
                    &cells[2],
                    "a finite number other than 0",
                ));
            }
            if mapped.iter().any(|m| m.channel == channel) {
                return Err(bad(
                    line,
                    "a channel occurs twice",
                    "channel",
                    &cells[0],
                    "each channel once",
                ));
            }
            if mapped.iter().any(|m| m.reference.same_axis(reference)) {
                return Err(bad(
                    line,
                    "an actuator occurs twice",
                    "reference",
                    &cells[1],
                    "each actuator once",
                ));
            }
            mapped.push(Mapped {
                channel,
                reference,
                gain,
            });
        }
        mapped.sort_by_key(|mapped| mapped.channel);
        Ok(Self(mapped))
    }
}
