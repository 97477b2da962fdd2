//! Poles of a known model, moved until they explain a few FRFs of the same structure.
//!
//! Shapes and residual terms are those of the model; only ω_n and η_n of its modes are free. The
//! result is the most probable one given the FRFs, with white noise of one variance, and a wide prior
//! about a shift that all modes share. It is found by Gauss-Newton steps on relative changes, which
//! start from the common shift that explains the FRFs best. Six FRFs are enough for 1e-5 at 40 dB.

use super::limits;
use chladni_frf::{
    Damping, Dof, Error, Finding, FrfSet, FrfValues, ModalModel, Mode, Result, Severity,
};
use ndarray::{Array1, Array2, Array3};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A model with moved poles, and by how much they moved.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct MovedPoles {
    /// The model: shapes and residual terms as before.
    pub model: ModalModel,
    /// Mean relative shift of the natural frequencies, weighted by their certainty.
    pub common_shift: f64,
    /// Its standard deviation, from the FRFs.
    pub common_shift_std: f64,
    /// Rms of the shifts of single modes about the common one.
    pub own_shifts_rms: f64,
    /// Rms of the residual of the FRFs, over their rms.
    pub relative_error: f64,
}

/// Moves the poles of `model` to where `frf`, a few FRFs of the same structure, has them.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`]: an FRF between DOFs that the model lacks, another
/// unit, no line in the band of the model, no finite value.
pub fn poles_of(model: &ModalModel, frf: &FrfSet) -> Result<MovedPoles> {
    let data = TrackedFrfs::new(model, frf)?;
    let modes = counted(model);
    if modes.is_empty() {
        return Err(Error::bad_data("the model has no mode to follow")
            .field("modes")
            .found("none in the band")
            .expected("at least one mode"));
    }
    let mut moved = data.model.clone();
    let common = best_common_shift(&data, &modes);
    for &n in &modes {
        moved.modes[n].frequency_hz *= 1.0 + common;
    }
    let mut covariance = Array2::zeros((0, 0));
    for _ in 0..limits::TRACK_STEPS {
        let step = Step::new(&data, &moved, &modes, common)?;
        let mut largest_bandwidths = 0.0f64;
        for (k, &n) in modes.iter().enumerate() {
            let mode = &mut moved.modes[n];
            let [frequency, loss] = [step.change[2 * k], step.change[2 * k + 1]];
            let bandwidths = frequency.abs() / mode.loss_factor.max(f64::MIN_POSITIVE);
            largest_bandwidths = largest_bandwidths.max(bandwidths);
            mode.frequency_hz *= 1.0 + frequency.clamp(-mode.loss_factor, mode.loss_factor);
            mode.loss_factor *= 1.0 + loss.clamp(-limits::TRACK_LOSS_STEP, limits::TRACK_LOSS_STEP);
            mode.damping_ratio = 0.5 * mode.loss_factor;
        }
        covariance = step.covariance;
        if largest_bandwidths < limits::TRACK_CHANGE {
            break;
        }
    }
    Ok(with_moved_poles(model, &data, &moved, &modes, &covariance))
}

/// Indices of the modes to move: those of the band that count.
fn counted(model: &ModalModel) -> Vec<usize> {
    (0..model.modes.len())
        .filter(|&n| model.modes[n].counts())
        .collect()
}

/// The FRFs on the lines of the band, and the model at their DOFs.
struct TrackedFrfs {
    model: ModalModel,
    frequency_hz: Array1<f64>,
    /// Axes (response, reference, line); NaN if not measured.
    frf: Array3<Complex64>,
    rms: f64,
}

/// A DOF of the FRFs among those of the model.
struct Place {
    index: usize,
    /// Sign between both directions.
    sign: f64,
}

impl Place {
    /// The places of `dofs` among those `known` to the model, which the error calls `role`.
    fn all(known: &[Dof], dofs: &[Dof], role: &str) -> Result<Vec<Self>> {
        let place = |&dof: &Dof| {
            let index = known.iter().position(|known| known.same_axis(dof));
            let index = index.ok_or_else(|| {
                Error::bad_data(format!("the model has no such {role}"))
                    .field(role)
                    .found(dof)
                    .expected(format!("one of its {}", known.len()))
                    .help("give FRFs between DOFs that the model was fitted to")
            })?;
            Ok(Self {
                index,
                sign: known[index].direction.sign() * dof.direction.sign(),
            })
        };
        dofs.iter().map(place).collect()
    }
}

impl TrackedFrfs {
    fn new(model: &ModalModel, frf: &FrfSet) -> Result<Self> {
        if frf.reference_unit != model.reference_unit {
            return Err(
                Error::bad_data("the FRFs are per another unit than the model")
                    .field("reference_unit")
                    .found(frf.reference_unit)
                    .expected(model.reference_unit),
            );
        }
        let rows = Place::all(&model.responses, &frf.responses, "response")?;
        let columns = Place::all(&model.references, &frf.references, "reference")?;
        let frf = frf.to_kind(model.frf_kind)?;
        let [low, high] = model.band_hz;
        let lines = (0..frf.frequency_hz.len())
            .filter(|&k| low <= frf.frequency_hz[k] && frf.frequency_hz[k] <= high);
        let part = frf.on_lines(&lines.collect::<Vec<_>>());
        let mut values = match part.values {
            FrfValues::F64(values) => values,
            FrfValues::F32(values) => {
                values.mapv(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
            }
        };
        for ((i, j, _), value) in values.indexed_iter_mut() {
            *value *= rows[i].sign * columns[j].sign;
        }
        let known = values.iter().filter(|value| !value.re.is_nan());
        let (count, sum) = known.fold((0, 0.0), |(n, s), v| (n + 1, s + v.norm_sqr()));
        if sum == 0.0 {
            return Err(Error::bad_data("no FRF value in the band of the model")
                .field("band_hz")
                .found(format!("{count} values, all zero"))
                .expected(format!("lines between {low} and {high} Hz")));
        }
        let indices = |places: &[Place]| places.iter().map(|place| place.index).collect::<Vec<_>>();
        Ok(Self {
            model: model.at_dofs(&indices(&rows), &indices(&columns)),
            frequency_hz: part.frequency_hz,
            frf: values,
            rms: (sum / f64::from(count)).sqrt(),
        })
    }

    /// FRFs less those of `model`; 0 for values that were not measured.
    fn residual(&self, model: &ModalModel) -> Array3<Complex64> {
        let mut residual = &self.frf - &model.synthesise(&self.frequency_hz);
        residual.mapv_inplace(|value| {
            if value.re.is_nan() {
                Complex64::ZERO
            } else {
                value
            }
        });
        residual
    }

    /// Residual sum of squares.
    fn misfit(&self, model: &ModalModel) -> f64 {
        self.residual(model).iter().map(Complex64::norm_sqr).sum()
    }

    /// Number of measured values.
    fn values(&self) -> usize {
        self.frf.iter().filter(|value| !value.re.is_nan()).count()
    }
}

/// The relative shift of all natural frequencies with the least misfit, from a grid.
fn best_common_shift(data: &TrackedFrfs, modes: &[usize]) -> f64 {
    let narrowest = modes
        .iter()
        .map(|&n| data.model.modes[n].loss_factor)
        .fold(f64::INFINITY, f64::min);
    let largest = limits::MOST_TRACKED_SHIFT;
    let steps = (largest / (limits::TRACK_SPACING * narrowest)).ceil();
    let steps = steps.min(limits::MOST_TRACK_TRIALS) as i32;
    let shifts = (-steps..=steps).map(|k| largest * f64::from(k) / f64::from(steps));
    let misfit = |shift: f64| {
        let mut moved = data.model.clone();
        for &n in modes {
            moved.modes[n].frequency_hz *= 1.0 + shift;
        }
        data.misfit(&moved)
    };
    let trials = shifts.map(|shift| (misfit(shift), shift));
    trials
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.abs().total_cmp(&b.1.abs())))
        .map_or(0.0, |best| best.1)
}

/// A Gauss-Newton step on the relative changes of ω_1, η_1, ω_2, ….
struct Step {
    change: Array1<f64>,
    covariance: Array2<f64>,
}

impl Step {
    /// * `common`: shift about which natural frequencies are expected
    fn new(data: &TrackedFrfs, moved: &ModalModel, modes: &[usize], common: f64) -> Result<Self> {
        let unknowns = 2 * modes.len();
        let residual = data.residual(moved);
        let values = data.values();
        let dof = (2 * values).saturating_sub(unknowns).max(1) as f64;
        let variance = residual.iter().map(Complex64::norm_sqr).sum::<f64>() / dof;
        let variance = variance.max((limits::TRACK_ROUNDING * data.rms).powi(2));
        let (mut normal, mut right) = normal_equations(data, moved, modes, &residual);
        normal.mapv_inplace(|value| value / variance);
        right.mapv_inplace(|value| value / variance);
        for (k, &n) in modes.iter().enumerate() {
            let [mode, first] = [&moved.modes[n], &data.model.modes[n]];
            let frequency = mode.frequency_hz / (first.frequency_hz * (1.0 + common)) - 1.0;
            let loss = mode.loss_factor / first.loss_factor - 1.0;
            for (unknown, prior_std, change) in [
                (2 * k, limits::TRACK_FREQUENCY_PRIOR, frequency),
                (2 * k + 1, limits::TRACK_LOSS_PRIOR, loss),
            ] {
                normal[[unknown, unknown]] += prior_std.powi(-2);
                right[unknown] -= change * prior_std.powi(-2);
            }
        }
        let solved = |error: chladni_linalg::LinalgError| {
            Error::bad_data(format!("the poles cannot be followed: {error}"))
                .help("give FRFs in which the modes can be seen")
        };
        let covariance = chladni_linalg::inverse_hermitian(normal.view()).map_err(solved)?;
        Ok(Self {
            change: covariance.dot(&right),
            covariance,
        })
    }
}

/// The normal matrix of relative changes and its right-hand side, for a `residual` of unit
/// variance.
fn normal_equations(
    data: &TrackedFrfs,
    moved: &ModalModel,
    modes: &[usize],
    residual: &Array3<Complex64>,
) -> (Array2<f64>, Array1<f64>) {
    let unknowns = 2 * modes.len();
    let (responses, references, _) = data.frf.dim();
    let mut normal = Array2::<f64>::zeros((unknowns, unknowns));
    let mut right = Array1::<f64>::zeros(unknowns);
    let mut slopes = vec![Complex64::ZERO; unknowns];
    for (line, &hz) in data.frequency_hz.iter().enumerate() {
        let omega = TAU * hz;
        let kind = moved.frf_kind.from_receptance(omega);
        let slopes_of_modes: Vec<ReceptanceSlopes> = modes
            .iter()
            .map(|&n| ReceptanceSlopes::new(&moved.modes[n], moved.damping, omega))
            .collect();
        for i in 0..responses {
            for j in 0..references {
                if data.frf[[i, j, line]].re.is_nan() {
                    continue;
                }
                for (k, &n) in modes.iter().enumerate() {
                    let mode = &moved.modes[n];
                    let residue = mode.shape.0[i] * mode.participation.0[j];
                    let ReceptanceSlopes { frequency, loss } = &slopes_of_modes[k];
                    slopes[2 * k] = kind * frequency.of_residue(residue);
                    slopes[2 * k + 1] = kind * loss.of_residue(residue);
                }
                let residual = residual[[i, j, line]];
                for a in 0..unknowns {
                    right[a] += (slopes[a].conj() * residual).re;
                    for b in 0..=a {
                        normal[[a, b]] += (slopes[a].conj() * slopes[b]).re;
                    }
                }
            }
        }
    }
    for a in 0..unknowns {
        for b in 0..a {
            normal[[b, a]] = normal[[a, b]];
        }
    }
    (normal, right)
}

/// Derivatives of the receptance of a mode.
struct ReceptanceSlopes {
    /// ∂/∂ln ω_n.
    frequency: Slope,
    /// ∂/∂ln η_n.
    loss: Slope,
}

/// One derivative: per residue, and per conjugate residue.
struct Slope([Complex64; 2]);

impl Slope {
    fn of_residue(&self, residue: Complex64) -> Complex64 {
        self.0[0] * residue + self.0[1] * residue.conj()
    }
}

impl ReceptanceSlopes {
    fn new(mode: &Mode, damping: Damping, omega: f64) -> Self {
        let step = limits::TRACK_SLOPE_STEP;
        let at = |frequency: f64, loss: f64| {
            let mut other = without_shape(mode);
            other.frequency_hz *= 1.0 + frequency;
            other.loss_factor *= 1.0 + loss;
            other.damping_ratio = 0.5 * other.loss_factor;
            other.receptance_factors(damping, omega)
        };
        let slope = |low: [Complex64; 2], high: [Complex64; 2]| {
            Slope([0, 1].map(|k| (high[k] - low[k]) / (2.0 * step)))
        };
        Self {
            frequency: slope(at(-step, 0.0), at(step, 0.0)),
            loss: slope(at(0.0, -step), at(0.0, step)),
        }
    }
}

/// A mode without its shape.
fn without_shape(mode: &Mode) -> Mode {
    Mode {
        shape: Default::default(),
        shape_std: Vec::new(),
        participation: Default::default(),
        reasons: Default::default(),
        ..*mode
    }
}

/// The model with its poles moved, their error bars, and the findings.
fn with_moved_poles(
    model: &ModalModel,
    data: &TrackedFrfs,
    moved: &ModalModel,
    modes: &[usize],
    covariance: &Array2<f64>,
) -> MovedPoles {
    let mut followed = model.clone();
    let (mut weights, mut weighted_shifts, mut shifts) = (0.0, 0.0, Vec::new());
    for (k, &n) in modes.iter().enumerate() {
        let [before, after] = [&model.modes[n], &moved.modes[n]];
        let shift = after.frequency_hz / before.frequency_hz - 1.0;
        let variance = covariance[[2 * k, 2 * k]];
        weighted_shifts += shift / variance;
        weights += 1.0 / variance;
        shifts.push(shift);
        let mode = &mut followed.modes[n];
        mode.frequency_hz = after.frequency_hz;
        mode.frequency_std_hz = after.frequency_hz * variance.sqrt();
        mode.loss_factor = after.loss_factor;
        mode.loss_factor_std = after.loss_factor * covariance[[2 * k + 1, 2 * k + 1]].sqrt();
        mode.damping_ratio = after.damping_ratio;
    }
    let common_shift = weighted_shifts / weights;
    let squares = shifts.iter().map(|shift| (shift - common_shift).powi(2));
    let own_shifts_rms = (squares.sum::<f64>() / shifts.len() as f64).sqrt();
    let misfit = data.misfit(moved) / data.values() as f64;
    let relative_error = misfit.sqrt() / data.rms;
    let mut result = MovedPoles {
        model: followed,
        common_shift,
        common_shift_std: weights.recip().sqrt(),
        own_shifts_rms,
        relative_error,
    };
    let finding = poles_followed(&result);
    let quality = &mut result.model.quality;
    quality.findings.push(finding);
    let changed = shapes_changed(relative_error, model.quality.relative_error);
    let is_fault = |finding: &Finding| finding.severity == Severity::Fault;
    quality.trusted &= !changed.as_ref().is_some_and(is_fault);
    quality.findings.extend(changed);
    result
}

/// The finding on the shifts of the poles.
fn poles_followed(moved: &MovedPoles) -> Finding {
    let words = format!(
        "poles of a model, followed: natural frequencies moved by {:+.4} % together (± {:.4} %), \
         and by {:.4} % rms each",
        100.0 * moved.common_shift,
        100.0 * moved.common_shift_std,
        100.0 * moved.own_shifts_rms
    );
    Finding::note("poles-followed", words)
        .value("common_shift", moved.common_shift)
        .value("common_shift_std", moved.common_shift_std)
        .value("own_shifts_rms", moved.own_shifts_rms)
        .value("relative_error", moved.relative_error)
}

/// The finding that moved poles explain these FRFs far worse than the model explained its own.
fn shapes_changed(relative_error: f64, before: f64) -> Option<Finding> {
    let allowed = limits::TRACK_MISFIT * before.max(limits::LEAST_MISFIT);
    let lost = relative_error > limits::TRACK_LOST;
    (lost || relative_error > allowed).then(|| {
        let words = format!(
            "moved poles leave {:.1} % of these FRFs, the model left {:.1} % of its own: ",
            100.0 * relative_error,
            100.0 * before
        );
        let finding = match lost {
            true => Finding::fault(
                "shapes-changed",
                words + "they are of another structure, or mostly noise",
            ),
            false => Finding::caution(
                "shapes-changed",
                words + "the shapes are no longer those of the model",
            ),
        };
        finding
            .value("relative_error", relative_error)
            .help("scan again, and fit that")
    })
}
