//! The common ground of all pieces of one fit.

use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::{Effort, FitOptions, Window};
use crate::data::screening::lines_in_band;
use crate::data::window::record_s;
use chladni_frf::{Error, FrfKind, FrfSet, ReferenceUnit};
use ndarray::ArrayView1;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Axis, kind and the options that a sketch depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Plan {
    /// The whole frequency axis of the data, Hz.
    pub frequency_hz: Vec<f64>,
    pub kind: FrfKind,
    pub reference_unit: ReferenceUnit,
    /// As asked for.
    pub band_hz: Option<[f64; 2]>,
    pub seed: u64,
    /// Of the sketch.
    pub columns: usize,
    /// Window of the records.
    pub window: Option<String>,
    /// Part of each record that holds samples, s.
    pub record_s: f64,
    /// Decay that the data say was added to every pole, 1/s.
    pub exponential_window_per_s: Option<f64>,
    /// Options that the data were read with, as the caller names them.
    pub reading: BTreeMap<String, String>,
}

impl Plan {
    pub fn new(frf: &FrfSet, options: &FitOptions) -> Result<Self, FitError> {
        Ok(Self {
            frequency_hz: frf.frequency_hz.to_vec(),
            kind: frf.kind.ok_or(FitError::UnknownKind)?,
            reference_unit: frf.reference_unit,
            band_hz: options.band_hz,
            seed: options.seed,
            columns: options.effort.sketch_columns.max(1),
            window: options.window.map(|window| window.to_string()),
            record_s: record_s(frf, options)?,
            exponential_window_per_s: options.exponential_window_per_s,
            reading: BTreeMap::new(),
        })
    }

    /// Indices of the lines of the band, and its ends, Hz.
    pub fn lines(&self) -> Result<(Vec<usize>, [f64; 2]), FitError> {
        lines_in_band(ArrayView1::from(&self.frequency_hz), self.band_hz)
    }

    /// A head without DOFs on some lines.
    pub fn head(&self, lines: Vec<usize>, effort: Effort) -> Result<DataLayout, FitError> {
        let (_, band_hz) = self.lines()?;
        let head = DataLayout::on_lines(
            ArrayView1::from(&self.frequency_hz),
            self.kind,
            lines,
            band_hz,
            effort,
        );
        Ok(DataLayout {
            reference_unit: self.reference_unit,
            ..head.windowed(self.window(), self.record_s, None)
        })
    }

    /// Window of the records, where it is known.
    pub fn window(&self) -> Option<Window> {
        self.window.as_deref().and_then(|name| name.parse().ok())
    }

    /// Checks that `other` belongs to the same fit.
    ///
    /// # Errors
    /// The field that differs, `whose` it is.
    pub fn same(&self, other: &Self, whose: &str) -> Result<(), Error> {
        let error = |field: &str, found: String, expected: String| {
            Err(Error::bad_data(format!("{whose} belongs to another fit"))
                .field(field)
                .found(found)
                .expected(format!("{expected}, as in the others"))
                .help("reduce all blocks with the same options, from data on one frequency axis"))
        };
        if self.kind != other.kind {
            return error("FRF kind", other.kind.to_string(), self.kind.to_string());
        }
        if self.reference_unit != other.reference_unit {
            return error(
                "unit of the references",
                other.reference_unit.to_string(),
                self.reference_unit.to_string(),
            );
        }
        if self.frequency_hz != other.frequency_hz {
            return error(
                "frequency axis",
                described(&other.frequency_hz),
                described(&self.frequency_hz),
            );
        }
        if self.band_hz != other.band_hz {
            let words = |band: Option<[f64; 2]>| {
                band.map_or("all lines".into(), |[low, high]| {
                    format!("{low} to {high} Hz")
                })
            };
            return error("band", words(other.band_hz), words(self.band_hz));
        }
        if self.seed != other.seed {
            return error("seed", other.seed.to_string(), self.seed.to_string());
        }
        if self.columns != other.columns {
            return error(
                "columns of the sketch",
                other.columns.to_string(),
                self.columns.to_string(),
            );
        }
        if self.window != other.window {
            let words =
                |window: &Option<String>| window.clone().unwrap_or_else(|| "not said".into());
            return error("window", words(&other.window), words(&self.window));
        }
        if self.record_s != other.record_s {
            let words = |record_s: f64| format!("{record_s} s");
            return error(
                "length of the records",
                words(other.record_s),
                words(self.record_s),
            );
        }
        if self.exponential_window_per_s != other.exponential_window_per_s {
            let words =
                |decay: Option<f64>| decay.map_or("none".into(), |decay| format!("{decay} 1/s"));
            return error(
                "exponential window",
                words(other.exponential_window_per_s),
                words(self.exponential_window_per_s),
            );
        }
        let differs = |name: &&String| self.reading.get(*name) != other.reading.get(*name);
        if let Some(name) = self
            .reading
            .keys()
            .chain(other.reading.keys())
            .find(differs)
        {
            let words = |reading: &BTreeMap<String, String>| {
                reading
                    .get(name)
                    .map_or("not given", String::as_str)
                    .to_owned()
            };
            return error(
                &name.replace('_', " "),
                words(&other.reading),
                words(&self.reading),
            );
        }
        Ok(())
    }
}

/// An axis in words.
fn described(frequency_hz: &[f64]) -> String {
    let end = |f: Option<&f64>| f.copied().unwrap_or(f64::NAN);
    format!(
        "{} lines from {} to {} Hz",
        frequency_hz.len(),
        end(frequency_hz.first()),
        end(frequency_hz.last())
    )
}
