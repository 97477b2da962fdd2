//! The common ground of all pieces of one fit.

use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::{Effort, FitOptions};
use crate::data::screening::lines_in_band;
use crate::data::window::kinds::Window;
use crate::data::window::of_set::record_s;
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

    /// The layout of some lines, without DOFs.
    pub fn layout(&self, lines: Vec<usize>, effort: Effort) -> Result<DataLayout, FitError> {
        let (_, band_hz) = self.lines()?;
        let layout = DataLayout::on_lines(
            ArrayView1::from(&self.frequency_hz),
            self.kind,
            lines,
            band_hz,
            effort,
        );
        Ok(DataLayout {
            reference_unit: self.reference_unit,
            ..layout.windowed(
                self.window(),
                self.exponential_window_per_s,
                self.record_s,
                None,
            )
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
        self.compared(other).map_err(|differs| {
            Error::bad_data(format!("{whose} belongs to another fit"))
                .field(differs.field)
                .found(differs.found)
                .expected(format!("{}, as in the others", differs.expected))
                .help("reduce all blocks with the same options, from data on one frequency axis")
        })
    }

    fn compared(&self, other: &Self) -> Result<(), Difference> {
        alike("FRF kind", [&self.kind, &other.kind], FrfKind::to_string)?;
        alike(
            "unit of the references",
            [&self.reference_unit, &other.reference_unit],
            ReferenceUnit::to_string,
        )?;
        alike(
            "frequency axis",
            [&self.frequency_hz, &other.frequency_hz],
            |axis| described(axis),
        )?;
        alike("band", [&self.band_hz, &other.band_hz], |band| {
            band.map_or("all lines".into(), |[low, high]| {
                format!("{low} to {high} Hz")
            })
        })?;
        alike("seed", [&self.seed, &other.seed], u64::to_string)?;
        alike(
            "columns of the sketch",
            [&self.columns, &other.columns],
            usize::to_string,
        )?;
        alike("window", [&self.window, &other.window], |window| {
            window.clone().unwrap_or_else(|| "not said".into())
        })?;
        alike(
            "length of the records",
            [&self.record_s, &other.record_s],
            |record_s| format!("{record_s} s"),
        )?;
        let decays = [
            &self.exponential_window_per_s,
            &other.exponential_window_per_s,
        ];
        alike("exponential window", decays, |decay| {
            decay.map_or("none".into(), |decay| format!("{decay} 1/s"))
        })?;
        for name in self.reading.keys().chain(other.reading.keys()) {
            let given = [self.reading.get(name), other.reading.get(name)];
            alike(&name.replace('_', " "), [&given[0], &given[1]], |given| {
                given.map_or("not given", String::as_str).to_owned()
            })?;
        }
        Ok(())
    }
}

/// A field in which two fits differ.
struct Difference {
    field: String,
    found: String,
    expected: String,
}

/// Checks that both have the same `field`; `words` tells a value.
fn alike<T: PartialEq>(
    field: &str,
    [own, other]: [&T; 2],
    words: impl Fn(&T) -> String,
) -> Result<(), Difference> {
    if own != other {
        return Err(Difference {
            field: field.into(),
            found: words(other),
            expected: words(own),
        });
    }
    Ok(())
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
