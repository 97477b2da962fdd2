//! Sizes and numbers of partials and poles that came as bytes: a checksum says that they
//! are as they were written, not that they were written by this program.

use crate::data::source::{By, Way};
use crate::pieces::limits;
use crate::pieces::partial::{Block, Partial, ProductSums, Run, SketchSums};
use crate::pieces::plan::Plan;
use crate::pieces::poles::{DofWeights, Matrix, Pass, Poles};
use chladni_frf::Error;
use std::fmt::Display;

/// Content whose parts must fit each other.
pub(crate) trait Sound {
    /// Refuses what cannot have been written by a pass over data.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] naming the part.
    fn check(&self) -> Result<(), Error>;
}

fn refused(field: &str, found: impl Display, expected: impl Display) -> Error {
    Error::bad_data("the parts of the content do not fit each other")
        .field(field)
        .found(found)
        .expected(expected)
        .help("make it anew from the data")
}

/// Refuses a number that is not the one expected.
fn count(field: &str, found: usize, expected: usize) -> Result<(), Error> {
    match found == expected {
        true => Ok(()),
        false => Err(refused(field, found, expected)),
    }
}

/// Refuses a matrix of another size.
fn size<T>(field: &str, matrix: &Matrix<T>, rows: usize, columns: usize) -> Result<(), Error> {
    count(&format!("rows of {field}"), matrix.rows, rows)?;
    match rows.checked_mul(columns) {
        Some(values) => count(&format!("values of {field}"), matrix.values.len(), values),
        None => Err(refused(field, columns, "fewer columns")),
    }
}

fn finite(field: &str, values: impl IntoIterator<Item = f64>) -> Result<(), Error> {
    match values.into_iter().find(|value| !value.is_finite()) {
        Some(value) => Err(refused(field, value, "finite numbers")),
        None => Ok(()),
    }
}

fn positive(field: &str, mut values: impl Iterator<Item = f64>) -> Result<(), Error> {
    match values.find(|value| !(value.is_finite() && *value > 0.0)) {
        Some(value) => Err(refused(field, value, "positive numbers")),
        None => Ok(()),
    }
}

impl Plan {
    /// Number of lines in the band.
    fn check(&self) -> Result<usize, Error> {
        finite("frequency axis", self.frequency_hz.iter().copied())?;
        finite("length of the records", [self.record_s])?;
        finite("exponential window", self.exponential_window_per_s)?;
        let axis = &self.frequency_hz;
        if axis.first().is_some_and(|hz| *hz < 0.0) || axis.windows(2).any(|two| two[1] <= two[0]) {
            return Err(refused(
                "frequency axis",
                "another order",
                "rising frequencies",
            ));
        }
        finite("band", self.band_hz.into_iter().flatten())?;
        let lines = self.lines();
        let words = |error: &dyn Display| refused("band", error, "a band on the axis");
        lines
            .map(|(lines, _)| lines.len())
            .map_err(|error| words(&error))
    }
}

impl Sound for Partial {
    fn check(&self) -> Result<(), Error> {
        let lines = self.plan.check()?;
        if let Some(poles) = &self.poles {
            poles.check()?;
            self.plan.same(&poles.plan, "the poles of the partial")?;
        }
        for block in &self.blocks {
            block.check()?;
        }
        let by_number =
            |two: &[Block]| (two[0].number, two[0].piece) < (two[1].number, two[1].piece);
        if !self.blocks.windows(2).all(by_number) {
            return Err(refused("blocks", "another order", "rising numbers"));
        }
        let mut last = None;
        for run in &self.runs {
            last = Some(run.check(last)?);
            if let Some(sketch) = &run.sums.sketch {
                sketch.check(lines)?;
            }
            match (&run.sums.products, &self.poles) {
                (Some(products), Some(poles)) => products.check(poles.lines.len())?,
                (Some(_), None) => return Err(refused("poles", "none", "those of the products")),
                (None, _) => {}
            }
        }
        self.same_columns()?;
        self.same_unknowns()
    }
}

impl Partial {
    /// All sketches are of one mixing.
    fn same_columns(&self) -> Result<(), Error> {
        let sketches = self.runs.iter().filter_map(|run| run.sums.sketch.as_ref());
        let mut columns = sketches.map(|sketch| sketch.counts.len());
        let Some(first) = columns.next() else {
            return Ok(());
        };
        columns.try_for_each(|found| count("columns of the sketches", found, first))
    }

    /// All products are of one basis.
    fn same_unknowns(&self) -> Result<(), Error> {
        let products = self
            .runs
            .iter()
            .filter_map(|run| run.sums.products.as_ref());
        let mut unknowns = products.map(|products| products.gram.rows);
        let Some(first) = unknowns.next() else {
            return Ok(());
        };
        unknowns.try_for_each(|rows| count("unknowns of the products", rows, first))?;
        for block in &self.blocks {
            let Some(r0) = &block.r0 else {
                return Err(refused("products of a block", "none", "those of every FRF"));
            };
            size("the products of a block", r0, first, block.pairs.len())?;
        }
        Ok(())
    }
}

impl Block {
    fn check(&self) -> Result<(), Error> {
        let outside =
            |&&(i, j): &&(usize, usize)| i >= self.responses.len() || j >= self.references.len();
        if let Some((i, j)) = self.pairs.iter().find(outside) {
            let expected = format!("{} × {}", self.responses.len(), self.references.len());
            return Err(refused("FRFs", format!("({i}, {j})"), expected));
        }
        if let Some(of) = self.of.filter(|&of| self.number >= of) {
            let expected = format!("less than {of}, the number of blocks");
            return Err(refused("number of the block", self.number, expected));
        }
        if !self.energy.is_empty() {
            count("energies of the FRFs", self.energy.len(), self.pairs.len())?;
        }
        if let Some((_, noise)) = &self.given {
            count("noise of the FRFs", noise.len(), self.pairs.len())?;
        }
        if let Some(r0) = &self.r0 {
            size("the products of a block", r0, r0.rows, self.pairs.len())?;
            finite("products of a block", r0.values.iter().copied())?;
        }
        finite("energies of the FRFs", self.energy.iter().copied())?;
        finite("nodes", self.nodes.iter().flat_map(|node| node.xyz_m))
    }
}

impl Run {
    /// The number of its last block; the run before ended with `before`.
    fn check(&self, before: Option<u64>) -> Result<u64, Error> {
        let whole = self.length.is_power_of_two()
            && self.length <= limits::RUN_MOST
            && self.first.is_multiple_of(self.length)
            && before.is_none_or(|before| self.first > before);
        match whole {
            true => Ok(self.first + (self.length - 1)),
            false => Err(refused(
                "run of blocks",
                format!("{} from {}", self.length, self.first),
                "a power of two that divides its first number, after the run before",
            )),
        }
    }
}

impl SketchSums {
    fn check(&self, lines: usize) -> Result<(), Error> {
        count("lines of the sketch", self.line_energy.len(), lines)?;
        count("lines of the sketch", self.bad.len(), lines)?;
        if self.counts.iter().any(|&frfs| frfs > limits::FRFS_MOST) {
            return Err(refused("FRFs of a column", "too many", "their number"));
        }
        size("the sketch", &self.columns, lines, self.counts.len())
    }
}

impl ProductSums {
    fn check(&self, lines: usize) -> Result<(), Error> {
        let unknowns = self.gram.rows;
        size("the products", &self.t, 2 * lines, unknowns)?;
        size("the products", &self.gram, unknowns, unknowns)?;
        let values = self.t.values.iter().chain(&self.gram.values);
        finite("products", values.copied())
    }
}

impl Sound for Poles {
    fn check(&self) -> Result<(), Error> {
        self.plan.check()?;
        let lines = self.lines.len();
        let outside = self
            .lines
            .last()
            .is_none_or(|&last| last >= self.plan.frequency_hz.len());
        if outside || self.lines.windows(2).any(|two| two[1] <= two[0]) {
            return Err(refused(
                "lines",
                format!("{lines} lines"),
                "lines of the axis, rising",
            ));
        }
        let columns = self.sketch.values.len().checked_div(lines).unwrap_or(0);
        size("the sketch", &self.sketch, lines, columns)?;
        count("energies of the lines", self.line_energy.len(), lines)?;
        finite("energies of the lines", self.line_energy.iter().copied())?;
        let sketch = self.sketch.values.iter();
        finite("sketch", sketch.flat_map(|value| [value.re, value.im]))?;
        if !(self.rms.is_finite() && self.rms > 0.0) {
            return Err(refused("root mean square", self.rms, "a positive number"));
        }
        if self.outlier_rounds > limits::ROUNDS_MOST {
            return Err(refused("rounds", self.outlier_rounds, "a few"));
        }
        if let Some(weighting) = &self.weighting {
            weighting.check()?;
        }
        match &self.way {
            Some(way) => way.check(self.lines.len()),
            None if self.pass == Pass::Products => Err(refused("poles", "none", "some")),
            None => Ok(()),
        }
    }
}

impl Way {
    /// * `lines`: number of lines used
    fn check(&self, lines: usize) -> Result<(), Error> {
        let poles = self.lambda.iter();
        finite("poles", poles.flat_map(|value| [value.re, value.im]))?;
        match &self.by {
            By::Measured {
                spread,
                grades,
                weights,
                ..
            } => {
                count("spread of the poles", spread.len(), self.lambda.len())?;
                count("grades of the poles", grades.len(), self.lambda.len())?;
                if !weights.is_empty() {
                    count("weights of lines", weights.len(), lines)?;
                }
                positive("weights of lines", weights.iter().copied())
            }
            By::Fast { extra_passes, .. } if *extra_passes > limits::ROUNDS_MOST => {
                Err(refused("passes", extra_passes, "a few"))
            }
            By::Delay(seconds) => finite("delay", [*seconds]),
            By::Fast { .. } | By::Conjugated => Ok(()),
        }
    }
}

impl DofWeights {
    fn check(&self) -> Result<(), Error> {
        positive("weights", self.numbers())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::options::FitOptions;
    use crate::pieces::block::reduce;
    use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
    use ndarray::{Array1, Array3};
    use num_complex::Complex64;

    fn partial() -> Partial {
        let frequency_hz = Array1::from_iter((0..40).map(|k| 10.0 + f64::from(k)));
        let of = |(i, _, k): (usize, usize, usize)| {
            let f: f64 = frequency_hz[k];
            (i + 1) as f64 / Complex64::new(900.0 - f * f, 18.0)
        };
        let frf = FrfSet {
            values: FrfValues::F64(Array3::from_shape_fn((3, 1, 40), of)),
            frequency_hz,
            responses: ["1:+Z", "2:+Z", "3:+Z"]
                .map(|dof| dof.parse().unwrap())
                .to_vec(),
            references: vec!["9:+Z".parse().unwrap()],
            kind: Some(FrfKind::Receptance),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        };
        reduce(&frf, &FitOptions::default(), 6, Vec::new(), None).unwrap()
    }

    #[test]
    fn content_that_was_put_together_by_somebody_is_refused_by_name() {
        let sound = partial();
        assert_eq!(Partial::from_bytes(&sound.to_bytes()).unwrap(), sound);
        type Change = fn(&mut Partial);
        let changes: [(&str, Change); 8] = [
            ("FRFs", |part| part.blocks[0].pairs[0].0 = 3),
            ("energies", |part| part.blocks[0].energy = vec![1.0]),
            ("values of the sketch", |part| {
                sketch(part).columns.values.pop();
            }),
            ("lines of the sketch", |part| {
                sketch(part).bad.pop();
            }),
            ("FRFs of a column", |part| sketch(part).counts[0] = u64::MAX),
            ("run of blocks", |part| part.runs[0].length = 4),
            ("frequency axis", |part| {
                part.plan.frequency_hz[3] = f64::NAN
            }),
            ("blocks", |part| part.blocks.push(part.blocks[0].clone())),
        ];
        for (words, change) in changes {
            let mut part = sound.clone();
            change(&mut part);
            let error = Partial::from_bytes(&part.to_bytes())
                .unwrap_err()
                .to_string();
            assert!(error.contains(words), "{words}: {error}");
        }
    }

    fn sketch(part: &mut Partial) -> &mut SketchSums {
        part.runs[0].sums.sketch.as_mut().unwrap()
    }
}
