//! A set of measured FRFs on one frequency axis.

use crate::{Dof, Error, Estimation, FrfKind, Geometry, ReferenceUnit, Result};
use ndarray::{Array1, Array3, Axis};
use num_complex::{Complex32, Complex64};

/// FRF values in the precision of their source; axes (response, reference, line), lines
/// contiguous.
///
/// Single-precision data keep their size in memory and are widened inside the arithmetic.
#[derive(Debug, Clone, PartialEq)]
pub enum FrfValues {
    /// Double precision.
    F64(Array3<Complex64>),
    /// Single precision.
    F32(Array3<Complex32>),
}

impl FrfValues {
    /// (responses, references, lines).
    pub fn dim(&self) -> (usize, usize, usize) {
        match self {
            Self::F64(values) => values.dim(),
            Self::F32(values) => values.dim(),
        }
    }
    /// One value, widened.
    pub fn get(&self, response: usize, reference: usize, line: usize) -> Complex64 {
        match self {
            Self::F64(values) => values[[response, reference, line]],
            Self::F32(values) => widen(values[[response, reference, line]]),
        }
    }
    /// One FRF, widened: one value per line.
    pub fn frf(&self, response: usize, reference: usize) -> Array1<Complex64> {
        match self {
            Self::F64(values) => values
                .slice(ndarray::s![response, reference, ..])
                .to_owned(),
            Self::F32(values) => values
                .slice(ndarray::s![response, reference, ..])
                .mapv(widen),
        }
    }
}

/// Some lines of an array with the axes (response, reference, line).
fn chosen<T: Copy>(values: &Array3<T>, lines: &[usize]) -> Array3<T> {
    let (responses, references, _) = values.dim();
    let chosen = values
        .lanes(Axis(2))
        .into_iter()
        .flat_map(|frf| lines.iter().map(move |&line| frf[line]))
        .collect();
    Array3::from_shape_vec((responses, references, lines.len()), chosen).expect("as many as chosen")
}

fn widen(value: Complex32) -> Complex64 {
    Complex64::new(value.re.into(), value.im.into())
}

/// Measured FRFs of one structure on one frequency axis.
///
/// A pair (response, reference) that was not measured, and a line that was masked, hold
/// NaN in both parts; readers name them in their warnings. Readers mask or refuse values that
/// are not finite, and fits leave them out.
#[derive(Debug, Clone, PartialEq)]
pub struct FrfSet {
    /// Frequency axis, Hz, strictly rising, finite, ≥ 0.
    pub frequency_hz: Array1<f64>,
    /// Values in SI units of `kind` per `reference_unit`; axes (response, reference,
    /// line).
    pub values: FrfValues,
    /// Response DOFs, unique, one per entry of axis 0.
    pub responses: Vec<Dof>,
    /// Reference DOFs, unique, one per entry of axis 1.
    pub references: Vec<Dof>,
    /// `None` where the file does not say: ask, never guess.
    pub kind: Option<FrfKind>,
    /// Unit of the references.
    pub reference_unit: ReferenceUnit,
    /// Ordinary coherence γ², same axes as `values`, NaN where not given.
    pub coherence: Option<Array3<f32>>,
    /// E|δH|² of each value, in its units squared, same axes; NaN where not known.
    /// Written by `estimate`.
    pub variance: Option<Array3<f64>>,
    /// The estimation of the values from time records, where that is known.
    pub estimation: Option<Estimation>,
    /// Nodes, where the file has them.
    pub geometry: Geometry,
}

impl FrfSet {
    /// Checks what the fields promise: sizes that agree, a rising finite axis, unique
    /// DOFs, variances that are finite and not negative (or NaN). The values themselves
    /// are not looked at.
    ///
    /// # Errors
    /// [`crate::ErrorKind::BadData`] naming the field.
    pub fn checked(self) -> Result<Self> {
        self.check_sizes()?;
        if let Some(negative) = self
            .variance
            .iter()
            .flatten()
            .find(|&&variance| variance < 0.0 || variance.is_infinite())
        {
            return Err(
                Error::bad_data("a variance must be finite and not negative")
                    .field("variance")
                    .found(negative)
                    .expected("E|δH|², or NaN where it is not known")
                    .help("correct it in the program that wrote the file"),
            );
        }
        self.check_axis()?;
        for (field, dofs) in [
            ("responses", &self.responses),
            ("references", &self.references),
        ] {
            let mut seen = std::collections::HashSet::new();
            if let Some(twice) = dofs.iter().find(|dof| !seen.insert(**dof)) {
                return Err(Error::bad_data("a DOF occurs twice")
                    .field(field)
                    .found(twice)
                    .expected("every DOF once"));
            }
        }
        Ok(self)
    }

    fn check_sizes(&self) -> Result<()> {
        let (responses, references, lines) = self.values.dim();
        for (field, found, expected) in [
            ("responses", self.responses.len(), responses),
            ("references", self.references.len(), references),
            ("frequency_hz", self.frequency_hz.len(), lines),
        ] {
            if found != expected {
                return Err(Error::bad_data("sizes disagree")
                    .field(field)
                    .found(found)
                    .expected(format!("{expected}, as many as the FRF array has")));
            }
        }
        let beside = [
            ("coherence", self.coherence.as_ref().map(Array3::dim)),
            ("variance", self.variance.as_ref().map(Array3::dim)),
        ];
        for (field, dim) in beside {
            if let Some(dim) = dim.filter(|&dim| dim != self.values.dim()) {
                return Err(Error::bad_data("sizes disagree")
                    .field(field)
                    .found(format!("{dim:?}"))
                    .expected(format!("{:?}", self.values.dim())));
            }
        }
        Ok(())
    }

    fn check_axis(&self) -> Result<()> {
        for (k, &f) in self.frequency_hz.iter().enumerate() {
            if !f.is_finite() || f < 0.0 || (k > 0 && f <= self.frequency_hz[k - 1]) {
                return Err(Error::bad_data(
                    "the frequency axis must be finite, not negative and strictly rising",
                )
                .field(format!("frequency axis, entry {}", k + 1))
                .found(f)
                .expected(if k > 0 {
                    format!("a finite number above {}", self.frequency_hz[k - 1])
                } else {
                    "0 or more".into()
                })
                .help("correct the axis in the program that wrote the file"));
            }
        }
        Ok(())
    }

    /// Number of FRFs (pairs), measured or not.
    pub fn pairs(&self) -> usize {
        self.responses.len() * self.references.len()
    }

    /// Every pair (response index, reference index), response by response.
    pub fn all_pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.responses.len()).flat_map(|i| (0..self.references.len()).map(move |j| (i, j)))
    }

    /// Pairs (response index, reference index) that were not measured: NaN on every line.
    pub fn missing_pairs(&self) -> Vec<(usize, usize)> {
        let lines = self.frequency_hz.len();
        let is_missing = |i, j| (0..lines).all(|k| self.values.get(i, j, k).re.is_nan());
        let pairs = self.all_pairs();
        pairs.filter(|&(i, j)| is_missing(i, j)).collect()
    }

    /// The same set on some of its lines (indices, rising).
    pub fn on_lines(&self, lines: &[usize]) -> Self {
        Self {
            frequency_hz: self.frequency_hz.select(Axis(0), lines),
            values: match &self.values {
                FrfValues::F64(values) => FrfValues::F64(chosen(values, lines)),
                FrfValues::F32(values) => FrfValues::F32(chosen(values, lines)),
            },
            responses: self.responses.clone(),
            references: self.references.clone(),
            coherence: self
                .coherence
                .as_ref()
                .map(|coherence| chosen(coherence, lines)),
            variance: self
                .variance
                .as_ref()
                .map(|variance| chosen(variance, lines)),
            geometry: self.geometry.clone(),
            ..*self
        }
    }

    /// Complex conjugate of every value: from e^{−jωt} to e^{+jωt} and back.
    pub fn conjugate(&mut self) {
        match &mut self.values {
            FrfValues::F64(values) => values.mapv_inplace(|v| v.conj()),
            FrfValues::F32(values) => values.mapv_inplace(|v| v.conj()),
        }
    }

    /// Lets all responses come `seconds` earlier: takes off a delay e^{−jωτ}, which all FRFs share.
    pub fn advance(&mut self, seconds: f64) {
        let axis = self.frequency_hz.iter();
        let phasors: Vec<Complex64> = axis
            .map(|hz| Complex64::from_polar(1.0, std::f64::consts::TAU * hz * seconds))
            .collect();
        match &mut self.values {
            FrfValues::F64(values) => {
                for mut frf in values.rows_mut() {
                    frf.iter_mut()
                        .zip(&phasors)
                        .for_each(|(v, phasor)| *v *= phasor);
                }
            }
            FrfValues::F32(values) => {
                let single = |v: Complex64| Complex32::new(v.re as f32, v.im as f32);
                for mut frf in values.rows_mut() {
                    for (v, phasor) in frf.iter_mut().zip(&phasors) {
                        *v = single(Complex64::new(v.re.into(), v.im.into()) * phasor);
                    }
                }
            }
        }
    }

    /// The same FRFs as `kind`, in double precision; a line at 0 Hz becomes NaN where the
    /// conversion divides by jω.
    ///
    /// # Errors
    /// [`crate::ErrorKind::UnknownFrfKind`] where the set's own kind is unknown.
    pub fn to_kind(&self, kind: FrfKind) -> Result<Self> {
        let from = self.known_kind()?;
        let (responses, references, lines) = self.values.dim();
        let factors: Vec<Complex64> = self
            .frequency_hz
            .iter()
            .map(|&f| {
                let omega = std::f64::consts::TAU * f;
                kind.from_receptance(omega) / from.from_receptance(omega)
            })
            .map(|factor| {
                if factor.is_finite() {
                    factor
                } else {
                    Complex64::new(f64::NAN, f64::NAN)
                }
            })
            .collect();
        let values = Array3::from_shape_fn((responses, references, lines), |(i, j, k)| {
            self.values.get(i, j, k) * factors[k]
        });
        let variance = self.variance.as_ref().map(|variance| {
            Array3::from_shape_fn(variance.dim(), |(i, j, k)| {
                variance[[i, j, k]] * factors[k].norm_sqr()
            })
        });
        Ok(Self {
            values: FrfValues::F64(values),
            kind: Some(kind),
            variance,
            ..self.clone()
        })
    }

    /// The kind, or the error that asks for it.
    ///
    /// # Errors
    /// [`crate::ErrorKind::UnknownFrfKind`].
    pub fn known_kind(&self) -> Result<FrfKind> {
        self.kind.ok_or_else(|| {
            Error::new(
                crate::ErrorKind::UnknownFrfKind,
                "the file does not say what kind of FRF it holds",
            )
            .field("FRF kind")
            .found("neither quantity codes nor unit labels that name one")
            .expected("receptance (m/N), mobility (m/s/N) or accelerance (m/s^2/N)")
            .help("say it with `frf_kind receptance|mobility|accelerance`")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_line(kind: FrfKind) -> FrfSet {
        FrfSet {
            frequency_hz: Array1::from(vec![0.0, 10.0]),
            values: FrfValues::F64(Array3::from_elem((1, 1, 2), Complex64::new(1.0, 2.0))),
            responses: vec!["1:+Z".parse().unwrap()],
            references: vec!["2:+Z".parse().unwrap()],
            kind: Some(kind),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: Some(Array3::from_elem((1, 1, 2), 0.5)),
            estimation: None,
            geometry: Geometry::default(),
        }
    }

    #[test]
    fn a_delay_that_is_taken_off_turns_each_line_in_either_precision() {
        let mut set = one_line(FrfKind::Mobility);
        let value = Complex64::new(1.0, 2.0);
        let single = Complex32::new(1.0, 2.0);
        for values in [
            set.values.clone(),
            FrfValues::F32(Array3::from_elem((1, 1, 2), single)),
        ] {
            set.values = values;
            // an eighth of the period at 10 Hz
            set.advance(0.0125);
            assert!((set.values.get(0, 0, 0) - value).norm() < 1e-6);
            let turned = value * Complex64::from_polar(1.0, std::f64::consts::FRAC_PI_4);
            assert!((set.values.get(0, 0, 1) - turned).norm() < 1e-6);
        }
    }

    #[test]
    fn kinds_differ_by_powers_of_j_omega() {
        let omega = std::f64::consts::TAU * 10.0;
        let mobility = one_line(FrfKind::Receptance)
            .to_kind(FrfKind::Mobility)
            .unwrap();
        let expected = Complex64::new(0.0, omega) * Complex64::new(1.0, 2.0);
        assert!((mobility.values.get(0, 0, 1) - expected).norm() < 1e-12 * omega);
        assert!(
            (mobility.variance.as_ref().unwrap()[[0, 0, 1]] - 0.5 * omega * omega).abs()
                < 1e-9 * omega * omega
        );
        let back = mobility.to_kind(FrfKind::Receptance).unwrap();
        assert!((back.values.get(0, 0, 1) - Complex64::new(1.0, 2.0)).norm() < 1e-14);
        assert!(
            back.values.get(0, 0, 0).re.is_nan(),
            "0 Hz cannot be divided by j omega"
        );
    }

    #[test]
    fn an_axis_that_falls_is_refused() {
        let mut set = one_line(FrfKind::Mobility);
        set.frequency_hz[1] = 0.0;
        assert!(set.checked().unwrap_err().to_string().contains("entry 2"));
    }
}
