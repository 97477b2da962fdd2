//! From poles to the model file: residues of every FRF, rank-one shapes, scaling, error bars.

use crate::error::FitError;
use crate::law::Law;
use crate::options::FitOptions;
use crate::refine::Refined;
use crate::screen::Screened;
use crate::structure::{low_rank, schur_weight, significant_rank, Residues, Shapes};
use crate::tolerances as tol;
use crate::validation::mpc;
use crate::viscous::viscous_basis;
use crate::work::{basis, Work};
use chladni_frf::{
    ComplexMatrix, ComplexVector, Damping, ModalModel, Mode, Quality, ResidualTerm, ResidualTerms, Scaling, Trust, CREATED_BY, MODEL_FORMAT,
};
use chladni_linalg::{inverse_hermitian, lstsq, matmul, LinalgError};
use ndarray::{s, Array2, Array3, ShapeBuilder};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Grade of one pole with its reasons.
pub(crate) type Grade = (Trust, Vec<String>);

/// One pole as the model will show it, in units of ω_max.
#[derive(Debug, Clone)]
pub(crate) struct Pole {
    /// λ (structural) or s (viscous), in units of ω_max² or ω_max.
    pub value: Complex64,
    /// ω_n/ω_max.
    pub omega: f64,
    /// η_n.
    pub loss_factor: f64,
    /// Standard deviations of the two.
    pub omega_std: f64,
    /// Standard deviation of η_n.
    pub loss_factor_std: f64,
    /// Grade.
    pub grade: Grade,
}

/// Poles of one law with the data they were found on.
#[derive(Debug)]
pub(crate) struct Identified {
    /// Law.
    pub damping: Damping,
    /// Poles.
    pub poles: Vec<Pole>,
    /// Powers of x of the residual terms.
    pub powers: Vec<i32>,
    /// Columns the residues are found on.
    pub work: Work,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<Array2<f64>>,
    /// Noise variance of a work value.
    pub variance: f64,
    /// Which path found them, and why.
    pub path: String,
    /// Warnings so far.
    pub warnings: Vec<String>,
    /// False where the data as a whole contradict the model.
    pub consistent: bool,
}

/// Undamped frequency, loss factor and their deviations of a structural pole with variance `c` = E|δλ|².
fn structural_pole(lambda: Complex64, c: f64, grade: Grade) -> Pole {
    let omega = lambda.re.max(0.0).sqrt();
    let deviation = (0.5 * c).max(0.0).sqrt();
    Pole {
        value: lambda,
        omega,
        loss_factor: lambda.im / lambda.re,
        omega_std: deviation / (2.0 * omega),
        loss_factor_std: deviation / lambda.re.abs(),
        grade,
    }
}

/// The same of a viscous pole with the 2 × 2 covariance of (Re s, Im s).
fn viscous_pole(s: Complex64, covariance: [[f64; 2]; 2], grade: Grade) -> Pole {
    let omega = s.norm();
    let zeta = -s.re / omega;
    // ∂|s| = (Re s, Im s)/|s|; ∂ζ = (−Im², Re·Im)/|s|³
    let along = |g: [f64; 2]| {
        (g[0] * g[0] * covariance[0][0] + 2.0 * g[0] * g[1] * covariance[0][1] + g[1] * g[1] * covariance[1][1]).max(0.0).sqrt()
    };
    let cubed = omega.powi(3);
    Pole {
        value: s,
        omega,
        loss_factor: 2.0 * zeta,
        omega_std: along([s.re / omega, s.im / omega]),
        loss_factor_std: 2.0 * along([-s.im * s.im / cubed, s.re * s.im / cubed]),
        grade,
    }
}

impl Identified {
    /// Poles of the chosen law with their deviations: from the information matrix and `variance` (fast chain), or as given by
    /// `spread` = E|δλ|² per pole (measured-data path, where the residual decides).
    pub fn new(found: Found, law: Law) -> Result<Self, LinalgError> {
        let Found { refined, work, back, variance, spread, grades, path, warnings, consistent } = found;
        let structural = match &spread {
            Some(spread) => spread.clone(),
            None => {
                let covariance = inverse_hermitian(refined.information.view())?;
                covariance.diag().iter().map(|c| variance * c.re).collect()
            }
        };
        let mut poles: Vec<Pole> =
            refined.lambda.iter().zip(&structural).zip(grades).map(|((&lambda, &c), grade)| structural_pole(lambda, c, grade)).collect();
        if let Some(fit) = law.viscous {
            let own = match spread {
                Some(_) => None,
                None => Some(inverse_hermitian(fit.information.view())? * (0.5 * variance)),
            };
            let sources: Vec<usize> = (0..poles.len()).filter(|&n| crate::law::expressible_pole(refined.lambda[n])).collect();
            poles = fit
                .poles
                .iter()
                .zip(sources)
                .enumerate()
                .map(|(n, (&s, source))| {
                    let grade = poles[source].grade.clone();
                    let covariance = match &own {
                        Some(own) => {
                            [[own[[2 * n, 2 * n]], own[[2 * n, 2 * n + 1]]], [own[[2 * n + 1, 2 * n]], own[[2 * n + 1, 2 * n + 1]]]]
                        }
                        // |ds| = |dλ|/(2|√λ|), alike in all directions
                        None => {
                            let c = 0.5 * structural[source] / (4.0 * refined.lambda[source].norm());
                            [[c, 0.0], [0.0, c]]
                        }
                    };
                    viscous_pole(s, covariance, grade)
                })
                .collect();
        }
        Ok(Self { damping: law.damping, poles, powers: refined.powers, work, back, variance, path, warnings, consistent })
    }
}

/// What a path hands over.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    /// Poles in the x plane with their linear part.
    pub refined: Refined,
    /// Columns the residues are found on.
    pub work: Work,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<Array2<f64>>,
    /// Noise variance of a work value.
    pub variance: f64,
    /// E|δλ|² per pole where the residual decides; `None`: from the information matrix.
    pub spread: Option<Vec<f64>>,
    /// Grades.
    pub grades: Vec<Grade>,
    /// Which path, and why.
    pub path: String,
    /// Warnings.
    pub warnings: Vec<String>,
    /// False where the data as a whole contradict the model.
    pub consistent: bool,
}

/// Residues (mode, FRF) and residual coefficients (term, FRF) in work units.
struct Linear {
    residues: Array2<Complex64>,
    terms: Array2<Complex64>,
    /// Weight of residues with the residual terms eliminated, (mode, mode).
    weight: Array2<Complex64>,
    /// How the residual terms answer a change of residues: (term, mode) in the structural law, stacked reals in the viscous.
    answer: Answer,
    /// Sum of squares of the compressed columns at these poles.
    sse: f64,
}

enum Answer {
    Structural(Array2<Complex64>),
    Viscous(Array2<f64>),
}

fn linear(work: &Work, damping: Damping, poles: &[Complex64], powers: &[i32]) -> Result<Linear, LinalgError> {
    let (n, p) = (poles.len(), powers.len());
    match damping {
        Damping::Structural => {
            let a = basis(work, poles, powers);
            let solution = lstsq(a.view(), work.b.view())?;
            let sse = (&work.b - &matmul(a.view(), solution.view())).iter().map(|v| v.norm_sqr()).sum();
            let (modes, others) = (a.slice(s![.., ..n]).to_owned(), a.slice(s![.., n..]).to_owned());
            Ok(Linear {
                residues: solution.slice(s![..n, ..]).to_owned(),
                terms: solution.slice(s![n.., ..]).to_owned(),
                weight: schur_weight(&modes, &others)?,
                answer: Answer::Structural(lstsq(others.view(), modes.view())?),
                sse,
            })
        }
        Damping::Viscous => {
            let a = viscous_basis(work, poles, powers);
            let lines = work.lines();
            let mut b = Array2::zeros((2 * lines, work.columns()).f());
            b.slice_mut(s![..lines, ..]).assign(&work.b.mapv(|v| v.re));
            b.slice_mut(s![lines.., ..]).assign(&work.b.mapv(|v| v.im));
            let solution = lstsq(a.view(), b.view())?;
            let sse = (&b - &matmul(a.view(), solution.view())).iter().map(|v| v * v).sum();
            let pairs = |from: usize, count: usize| {
                Array2::from_shape_fn((count, work.columns()), |(i, c)| {
                    Complex64::new(solution[[from + 2 * i, c]], solution[[from + 2 * i + 1, c]])
                })
            };
            // near-pole columns weigh the residues: the far pole adds a smooth part of order η
            let near = Array2::from_shape_fn((lines, n).f(), |(k, i)| work.g[k] / (Complex64::new(0.0, work.x[k].sqrt()) - poles[i]));
            let others = basis(work, &[], powers);
            Ok(Linear {
                residues: pairs(0, n),
                terms: pairs(2 * n, p),
                weight: schur_weight(&near, &others)?,
                answer: Answer::Viscous(lstsq(a.slice(s![.., 2 * n..]), a.slice(s![.., ..2 * n]))?),
                sse,
            })
        }
    }
}

impl Answer {
    /// Residual terms after residues changed by `change`: c − answer·δr, both (·, FRF).
    fn apply(&self, terms: &mut Array2<Complex64>, change: &Array2<Complex64>) {
        match self {
            Self::Structural(answer) => *terms = &*terms - &matmul(answer.view(), change.view()),
            Self::Viscous(answer) => {
                let (n, m) = change.dim();
                let stacked =
                    Array2::from_shape_fn((2 * n, m).f(), |(i, c)| if i % 2 == 0 { change[[i / 2, c]].re } else { change[[i / 2, c]].im });
                let shift = matmul(answer.view(), stacked.view());
                for ((i, c), value) in terms.indexed_iter_mut() {
                    *value -= Complex64::new(shift[[2 * i, c]], shift[[2 * i + 1, c]]);
                }
            }
        }
    }
}

/// True where the model's fields can hold the pole.
fn expressible(damping: Damping, pole: &Pole) -> bool {
    let values = pole.omega > 1e-6 && pole.loss_factor.is_finite() && pole.loss_factor > 0.0;
    values && (damping == Damping::Structural || pole.loss_factor < 1.98)
}

/// Builds the model.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn assemble(data: &Screened, identified: Identified, options: &FitOptions) -> Result<ModalModel, FitError> {
    let Identified { damping, mut poles, powers, work, back, variance, path, mut warnings, consistent } = identified;
    let (rejected, kept): (Vec<Pole>, Vec<Pole>) = poles.into_iter().partition(|pole| pole.grade.0 == Trust::Rejected);
    poles = kept;
    poles.retain(|pole| expressible(damping, pole));
    poles.sort_by(|a, b| a.omega.total_cmp(&b.omega));
    let values: Vec<Complex64> = poles.iter().map(|p| p.value).collect();
    let mut linear = linear(&work, damping, &values, &powers)?;
    if let Some(back) = &back {
        let complex = back.mapv(|v| Complex64::new(v, 0.0));
        linear.residues = matmul(linear.residues.view(), complex.view());
        linear.terms = matmul(linear.terms.view(), complex.view());
    }

    // rank one
    let (responses, references) = (data.frf.responses.len(), data.frf.references.len());
    let mut cube = Array3::zeros((values.len(), responses, references));
    let mut present = Array2::from_elem((responses, references), false);
    for (l, &(i, j)) in data.pairs.iter().enumerate() {
        present[[i, j]] = true;
        for n in 0..values.len() {
            cube[[n, i, j]] = linear.residues[[n, l]];
        }
    }
    let free = Residues { values: &cube, weight: &linear.weight, present: &present };
    let (low, high) = work.range();
    let mut ranks = vec![1; values.len()];
    for n in (0..poles.len()).filter(|&n| !(low..=high).contains(&poles[n].omega.powi(2))) {
        ranks[n] = significant_rank(&free, n, variance)?;
    }
    let shapes = low_rank(&free, &ranks)?;
    let mut change = linear.residues.mapv(|v| -v);
    for (term, &n) in shapes.owner.iter().enumerate() {
        for (l, &(i, j)) in data.pairs.iter().enumerate() {
            change[[n, l]] += shapes.shape[[term, i]] * shapes.participation[[term, j]];
        }
    }
    linear.answer.apply(&mut linear.terms, &change);

    // χ² of the model as saved: free residues leave `variance` per degree of freedom, the low-rank form adds its rise
    let all = (work.lines() * work.columns()) as f64;
    let free_dof = (all - ((values.len() + powers.len()) * work.columns()) as f64).max(1.0);
    let chi2_per_dof =
        if variance > 0.0 { (linear.sse + shapes.rise) / (variance * (free_dof + 0.5 * shapes.constraints as f64)) } else { 1.0 };
    if chi2_per_dof > 1.5 {
        warnings.push(format!(
            "one shape per mode explains the references together worse than free residues (χ² per degree of freedom {chi2_per_dof:.1}): \
             modes may be missing, or a reference is delayed or not reciprocal"
        ));
    }

    let mut modes = modes(data, damping, &poles, &shapes, variance, &mut warnings);
    modes.0.extend(rejected.iter().filter(|pole| expressible(damping, pole)).map(|pole| rejected_mode(data, pole)));
    modes.0.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let scale = data.rms / data.omega_max.powi(data.kind.omega_power());
    let residual_terms = ResidualTerms {
        omega_scale_rad_per_s: data.omega_max,
        terms: powers
            .iter()
            .enumerate()
            .map(|(p, &power)| {
                let mut matrix = Array2::zeros((responses, references));
                for (l, &(i, j)) in data.pairs.iter().enumerate() {
                    matrix[[i, j]] = linear.terms[[p, l]] * scale;
                }
                ResidualTerm { power: 2 * power, matrix: ComplexMatrix(matrix) }
            })
            .collect(),
    };
    let in_band = modes.0.iter().filter(|m| m.in_band && m.trust != Trust::Rejected).count();
    let sure = modes.0.iter().filter(|m| m.in_band && m.trust == Trust::Sure).count();
    if in_band == 0 {
        warnings.push("no mode stands out of the noise in this band".into());
    } else if sure == 0 {
        warnings.push("no mode is sure: see the reasons given with each".into());
    }
    let mut all_warnings = data.warnings.clone();
    all_warnings.append(&mut warnings);
    let mut model = ModalModel {
        format: MODEL_FORMAT.into(),
        version: 1,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: serde_json::Map::new(),
        frf_kind: data.kind,
        reference_unit: data.frf.reference_unit,
        band_hz: data.band_hz,
        damping,
        scaling: modes.1,
        responses: data.frf.responses.clone(),
        references: data.frf.references.clone(),
        nodes: data.frf.geometry.nodes.clone(),
        method: options.method.to_string(),
        modes: modes.0,
        residual_terms,
        quality: Quality { relative_error: 0.0, chi2_per_dof, trusted: consistent && sure > 0, warnings: all_warnings, path: Some(path) },
    };
    model.quality.relative_error = relative_error(data, &model);
    Ok(model)
}

/// Rms residual of the model as saved over rms data, in the measured kind, over the lines and pairs used.
fn relative_error(data: &Screened, model: &ModalModel) -> f64 {
    use rayon::prelude::*;
    let blocks: Vec<usize> = (0..data.lines.len()).step_by(tol::BLOCK_LINES / 4).collect();
    let parts: Vec<[f64; 2]> = blocks
        .par_iter()
        .map(|&a| {
            let mut sums = [0.0; 2];
            for &k in &data.lines[a..(a + tol::BLOCK_LINES / 4).min(data.lines.len())] {
                let fitted = model.frf_matrix(model.frf_kind, data.frf.frequency_hz[k]);
                for &(i, j) in &data.pairs {
                    let value = data.frf.values.get(i, j, k);
                    sums[0] += (value - fitted[[i, j]]).norm_sqr();
                    sums[1] += value.norm_sqr();
                }
            }
            sums
        })
        .collect();
    let total = parts.iter().fold([0.0; 2], |t, p| [t[0] + p[0], t[1] + p[1]]);
    (total[0] / total[1]).sqrt()
}

/// A rejected pole as it is listed: no shape, no part in the synthesis.
fn rejected_mode(data: &Screened, pole: &Pole) -> Mode {
    let frequency_hz = pole.omega * data.omega_max / TAU;
    let zeros = |count| ComplexVector(vec![Complex64::default(); count]);
    Mode {
        frequency_hz,
        frequency_std_hz: pole.omega_std * data.omega_max / TAU,
        loss_factor: pole.loss_factor,
        loss_factor_std: pole.loss_factor_std,
        damping_ratio: 0.5 * pole.loss_factor,
        in_band: frequency_hz >= data.band_hz[0] && frequency_hz <= data.band_hz[1],
        trust: Trust::Rejected,
        reasons: pole.grade.1.clone(),
        mpc: 0.0,
        shape: zeros(data.frf.responses.len()),
        shape_std: vec![0.0; data.frf.responses.len()],
        participation: zeros(data.frf.references.len()),
    }
}

/// Modes in SI units, scaled by a driving point where there is one.
fn modes(
    data: &Screened,
    damping: Damping,
    poles: &[Pole],
    shapes: &Shapes,
    variance: f64,
    warnings: &mut Vec<String>,
) -> (Vec<Mode>, Scaling) {
    let kind_power = data.kind.omega_power();
    // (response index, reference index, sign) of driving points
    let driving: Vec<(usize, usize, f64)> = data
        .frf
        .responses
        .iter()
        .enumerate()
        .flat_map(|(i, r)| {
            data.frf
                .references
                .iter()
                .enumerate()
                .filter(move |(_, f)| r.same_axis(**f))
                .map(move |(j, f)| (i, j, r.direction.sign() * f.direction.sign()))
        })
        .collect();
    let massed = !driving.is_empty() && data.frf.reference_unit == chladni_frf::ReferenceUnit::Newton;
    let modes = shapes
        .owner
        .iter()
        .map(|&n| &poles[n])
        .enumerate()
        .map(|(n, pole)| {
            // R in receptance units: structural ω_max²(λ − x); viscous r·2jω_d
            let scale = match damping {
                Damping::Structural => Complex64::new(data.rms * data.omega_max.powi(2 - kind_power), 0.0),
                Damping::Viscous => Complex64::new(0.0, 2.0 * pole.value.im * data.rms * data.omega_max.powi(2 - kind_power)),
            };
            let mut shape: Vec<Complex64> = shapes.shape.row(n).to_vec();
            let mut participation: Vec<Complex64> = shapes.participation.row(n).iter().map(|v| v * scale).collect();
            let factor = if massed {
                // t² = Σ sign·conj(s)·L / Σ|s|² makes shape·t and participation/t agree at the driving points
                let up: Complex64 = driving.iter().map(|&(i, j, sign)| shape[i].conj() * participation[j] * sign).sum();
                let down: f64 = driving.iter().map(|&(i, _, _)| shape[i].norm_sqr()).sum();
                if down > 0.0 {
                    (up / down).sqrt()
                } else {
                    Complex64::new(1.0, 0.0)
                }
            } else {
                let largest = shape.iter().copied().max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr())).unwrap_or_default();
                if largest.norm() > 0.0 {
                    largest.inv()
                } else {
                    Complex64::new(1.0, 0.0)
                }
            };
            let mut deviation: Vec<f64> = shapes.shape_variance.row(n).iter().map(|v| (variance * v).sqrt() * factor.norm()).collect();
            shape.iter_mut().for_each(|v| *v *= factor);
            participation.iter_mut().for_each(|v| *v /= factor);
            deviation.iter_mut().for_each(|v| {
                if !v.is_finite() {
                    *v = 0.0
                }
            });
            let frequency_hz = pole.omega * data.omega_max / TAU;
            Mode {
                frequency_hz,
                frequency_std_hz: pole.omega_std * data.omega_max / TAU,
                loss_factor: pole.loss_factor,
                loss_factor_std: pole.loss_factor_std,
                damping_ratio: 0.5 * pole.loss_factor,
                in_band: frequency_hz >= data.band_hz[0] && frequency_hz <= data.band_hz[1],
                trust: pole.grade.0,
                reasons: pole.grade.1.clone(),
                mpc: mpc(&shape),
                shape: ComplexVector(shape),
                shape_std: deviation,
                participation: ComplexVector(participation),
            }
        })
        .collect();
    if !massed {
        warnings.push(match data.frf.reference_unit {
            chladni_frf::ReferenceUnit::Volt => "shapes are not mass-scaled: the references are voltages".into(),
            chladni_frf::ReferenceUnit::Newton => {
                "shapes are not mass-scaled: no response is measured at a reference (driving point)".to_string()
            }
        });
    }
    (modes, if massed { Scaling::UnitModalMass } else { Scaling::Unscaled })
}
