//! Modes that have one phase each: what tells one damping law from the other
//! (theory.md, eq. L1–L3).
//!
//! Free residues take over nearly all that a wrong law leaves: it turns the residues of a
//! light mode by half its loss factor, all alike. Here residues are real but for one angle
//! θ_n per mode, and the fit tells pole and angle together, since an error of a natural
//! frequency turns all residues of its mode too.

use crate::damping::basis::{basis, basis_derivative};
use crate::damping::gram::Cauchy;
use crate::damping::limits;
use crate::damping::mixing::Mixing;
use crate::damping::partial_fractions::{viscous_gram_of, Kind};
use crate::damping::places::in_plane_of;
use crate::data::columns::Columns;
use crate::data::information::answer;
use crate::data::inner_products::{inner, sum_of_squares};
use crate::tolerances as tol;
use chladni_frf::Damping;
use chladni_linalg::blocked::{
    blocked_gram, blocked_matmul_h, blocked_matmul_mixed, projected, range,
};
use chladni_linalg::{matmul, solve_hermitian, LinalgError};
use ndarray::{concatenate, s, Array2, Axis};
use num_complex::Complex64;

/// The fit in one law.
#[derive(Debug)]
pub(crate) struct LawFit {
    /// Sum of squares left.
    pub sse: f64,
    /// Decrease of the residual with residues free in their phases.
    pub relief: f64,
    /// λ of each mode in the plane of the law; √Re λ is its natural frequency over ω_max.
    pub lambda: Vec<Complex64>,
    /// θ_n, rad.
    pub turn: Vec<f64>,
    /// Information of the data on the angles with all else free, over (σ²/2)⁻¹.
    pub information: Array2<f64>,
}

/// The data of both laws, with what neither has to explain taken out.
pub(crate) struct Common {
    background: Array2<Complex64>,
    data: Array2<Complex64>,
    energy: f64,
}

impl Common {
    /// Residual terms of both laws are taken out, and the poles `outside` the band in both
    /// laws, with their residues and, to first order, their positions: what one law needs
    /// of them must not count for or against its modes.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(work: &Columns, outside: &[Complex64], powers: &[i32]) -> Result<Self, LinalgError> {
        let odd = Array2::from_shape_fn((work.lines(), limits::ODD_POWERS.len()), |(k, p)| {
            Complex64::from(work.g[k] * work.x[k].sqrt().powi(limits::ODD_POWERS[p]))
        });
        let mut all = concatenate![Axis(1), basis(work, &[], powers), odd];
        for law in [Damping::Structural, Damping::Viscous] {
            let axis = work.axis().in_law(law);
            let own: Vec<Complex64> = match law == work.law {
                true => outside.to_vec(),
                false => outside
                    .iter()
                    .filter_map(|l| in_plane_of(law, *l))
                    .collect(),
            };
            all = concatenate![
                Axis(1),
                all,
                basis(&axis, &own, &[]),
                basis_derivative(&axis, &own)
            ];
        }
        for mut column in all.columns_mut() {
            let norm = column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
            column.mapv_inplace(|v| v / norm.max(f64::MIN_POSITIVE));
        }
        let background = range(all.view(), tol::FREE_RANK)?;
        let (_, data) = projected(background.view(), work.b.view());
        Ok(Self {
            energy: sum_of_squares(&data),
            background,
            data,
        })
    }

    /// The fit in the law of `work` from poles and angles.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn fit(
        &self,
        work: &Columns,
        start: &[(Complex64, f64)],
        variance: f64,
    ) -> Result<LawFit, LinalgError> {
        let (mut lambda, mut turn): (Vec<Complex64>, Vec<f64>) = start.iter().copied().unzip();
        let mut here = Point::new(self, work, &lambda, &turn)?;
        let mut damping = tol::LM_START;
        let mut system = here.system();
        let mut mixing = Mixing::default();
        let (mut looked_at, mut made) = (here.sse, 0);
        for _ in 0..limits::STEPS {
            let (information, gradient) = &system;
            let mut damped = information.clone();
            damped
                .diag_mut()
                .mapv_inplace(|v| v * (1.0 + damping) + f64::MIN_POSITIVE);
            let step = solve_hermitian(damped.view(), gradient.view()).ok();
            let promised = step.as_ref().map(|step| (step * gradient).sum());
            if promised.is_some_and(|promised| promised < limits::PROMISED * variance) {
                break;
            }
            let taken = |step: Array2<f64>| {
                let moved = moved(&lambda, &turn, &step);
                let point = Point::new(self, work, &moved.0, &moved.1).ok()?;
                (point.sse <= here.sse).then_some((moved, point))
            };
            let next = step.and_then(|step| {
                // heavily damped steps are not those of one map: they cannot be mixed
                let mixed = match damping <= tol::LM_START {
                    true => mixing.step(unknowns(&lambda, &turn), &step, information.diag()),
                    false => None,
                };
                mixed.and_then(taken).or_else(|| taken(step))
            });
            match next {
                Some((moved, point)) => {
                    ((lambda, turn), here) = (moved, point);
                    system = here.system();
                    damping *= tol::LM_DOWN;
                    made += 1;
                }
                None => {
                    damping = (damping * tol::LM_UP).max(tol::LM_LEAST);
                    // the next step is proposed at the same point
                    mixing = Mixing::default();
                }
            }
            if damping > tol::LM_GIVE_UP {
                break;
            }
            if made == limits::STEPS_TOGETHER {
                let least = limits::STEPS_TOGETHER as f64 * limits::PROMISED * variance;
                if looked_at - here.sse < least {
                    break;
                }
                (looked_at, made) = (here.sse, 0);
            }
        }
        let n = lambda.len();
        let all = system.0;
        let (of_poles, of_turns) = (
            all.slice(s![..2 * n, ..2 * n]),
            all.slice(s![2 * n.., 2 * n..]),
        );
        let across = all.slice(s![..2 * n, 2 * n..]);
        let follow = answer(of_poles, across)?;
        Ok(LawFit {
            sse: here.sse,
            relief: here.relief()?,
            lambda,
            turn,
            information: &of_turns - &matmul(across.t(), follow.view()),
        })
    }
}

/// (Re λ, Im λ, θ) of all modes, one below the other.
fn unknowns(lambda: &[Complex64], turn: &[f64]) -> Array2<f64> {
    let n = lambda.len();
    Array2::from_shape_fn((3 * n, 1), |(u, _)| match u / n {
        0 => lambda[u % n].re,
        1 => lambda[u % n].im,
        _ => turn[u % n],
    })
}

/// Poles and angles after a step of (Re λ, Im λ, θ), at most half a half-bandwidth. A pole at or
/// below 0 Hz is no resonance, and has no column in the viscous law: none gets there.
fn moved(lambda: &[Complex64], turn: &[f64], step: &Array2<f64>) -> (Vec<Complex64>, Vec<f64>) {
    let n = lambda.len();
    let pole = |m: usize| {
        let delta = Complex64::new(step[[m, 0]], step[[n + m, 0]]);
        let cap = limits::PHASED_STEP * lambda[m].im;
        let next = lambda[m] + delta * (cap / delta.norm().max(cap));
        let least = lambda[m] * limits::PHASED_KEPT;
        Complex64::new(next.re.max(least.re), next.im.max(least.im))
    };
    let angle = |m: usize| turn[m] + step[[2 * n + m, 0]].clamp(-limits::TURN, limits::TURN);
    ((0..n).map(pole).collect(), (0..n).map(angle).collect())
}

/// Everything at one set of poles and angles.
struct Point {
    /// Inner products of φ, −j·∂φ/∂Im λ and, where it is another, ∂φ/∂Re λ, without
    /// background: (2n, 2n) or (3n, 3n).
    gram: Array2<Complex64>,
    /// Those of φ with the data, (n, column).
    against: Array2<Complex64>,
    /// Those of all with Σ_c r_c·b_c, r the residues of the mode and b the data.
    along: Vec<Complex64>,
    turn: Vec<f64>,
    /// Real residues, (mode, column).
    residues: Array2<f64>,
    /// Gram matrix of the columns e^{jθ}φ over the reals.
    own: Array2<f64>,
    energy: f64,
    sse: f64,
}

impl Point {
    fn new(
        common: &Common,
        work: &Columns,
        lambda: &[Complex64],
        turn: &[f64],
    ) -> Result<Self, LinalgError> {
        let n = lambda.len();
        let (columns, whole) = columns(work, lambda);
        // the data have nothing inside the background
        let against = blocked_matmul_h(columns.slice(s![.., ..n]), common.data.view());
        let inside = blocked_matmul_h(common.background.view(), columns.view());
        // what is left of a column is known to the rounding of the whole of it
        let gram = whole - blocked_gram(inside.view());
        let phase: Vec<Complex64> = turn
            .iter()
            .map(|t| Complex64::from_polar(1.0, *t))
            .collect();
        let own = Array2::from_shape_fn((n, n), |(m, q)| {
            (phase[m].conj() * phase[q] * gram[[m, q]]).re
        });
        let right = Array2::from_shape_fn((n, against.ncols()), |(m, c)| {
            (phase[m].conj() * against[[m, c]]).re
        });
        let residues = answer(own.view(), right.view())?;
        let explained: f64 = residues.iter().zip(&right).map(|(a, b)| a * b).sum();
        // one product with all columns for each mode, in place of one with each column
        let mixed = blocked_matmul_mixed(&common.data, residues.t());
        let along = columns.columns().into_iter().enumerate();
        let along = along.map(|(c, column)| {
            let values = column.iter().zip(mixed.column(c % n));
            values.map(|(a, b)| a.conj() * b).sum()
        });
        Ok(Self {
            along: along.collect(),
            gram,
            against,
            turn: turn.to_vec(),
            residues,
            own,
            energy: common.energy,
            sse: common.energy - explained,
        })
    }

    /// Column and factor of the tangent along one unknown: Re λ of all modes, then Im λ,
    /// then θ.
    fn tangent(&self, unknown: usize) -> (usize, Complex64) {
        let n = self.turn.len();
        let m = unknown % n;
        let phase = Complex64::from_polar(1.0, self.turn[m]);
        match unknown / n {
            0 => (self.gram.nrows() - n + m, phase),
            1 => (n + m, phase * Complex64::I),
            _ => (m, phase * Complex64::I),
        }
    }

    /// Gauss–Newton matrix and gradient of (Re λ, Im λ, θ), residues eliminated.
    fn system(&self) -> (Array2<f64>, Array2<f64>) {
        let n = self.turn.len();
        let tangents: Vec<(usize, Complex64)> = (0..3 * n).map(|u| self.tangent(u)).collect();
        let product = |(a, u): (usize, Complex64), (b, v): (usize, Complex64)| {
            (u.conj() * v * self.gram[[a, b]]).re
        };
        let plain = |m: usize| (m, Complex64::from_polar(1.0, self.turn[m]));
        let inside = Array2::from_shape_fn((n, 3 * n), |(m, u)| product(plain(m), tangents[u]));
        let known = answer(self.own.view(), inside.view())
            .map(|follow| matmul(inside.t(), follow.view()))
            .unwrap_or_else(|_| Array2::zeros((3 * n, 3 * n)));
        let residues = matmul(self.residues.view(), self.residues.t());
        let information = Array2::from_shape_fn((3 * n, 3 * n), |(u, v)| {
            (product(tangents[u], tangents[v]) - known[[u, v]]) * residues[[u % n, v % n]]
        });
        let gradient = Array2::from_shape_fn((3 * n, 1), |(u, _)| {
            let (column, factor) = tangents[u];
            let met = (factor.conj() * self.along[column]).re;
            let model: f64 = (0..n).map(|m| inside[[m, u]] * residues[[m, u % n]]).sum();
            met - model
        });
        (information, gradient)
    }

    /// Decrease of the sum of squares by complex residues at the same poles.
    fn relief(&self) -> Result<f64, LinalgError> {
        let n = self.turn.len();
        let (gram, against) = (self.gram.slice(s![..n, ..n]), self.against.view());
        let free = answer(gram, against)?;
        let explained = inner(free.view(), against);
        Ok((explained - (self.energy - self.sse)).max(0.0))
    }
}

/// φ, −j·∂φ/∂Im λ and, where it is another, ∂φ/∂Re λ in the law of `work`, side by side; and
/// their inner products.
fn columns(work: &Columns, lambda: &[Complex64]) -> (Array2<Complex64>, Array2<Complex64>) {
    let cauchy = Cauchy::new(work, lambda, &[]);
    if work.law == Damping::Structural {
        let gram = cauchy.gram();
        return (cauchy.columns, gram);
    }
    let columns = with_frequency(work, lambda, cauchy.columns);
    let kinds = [Kind::Pole, Kind::Loss, Kind::Frequency];
    let gram = viscous_gram_of(work, lambda, &kinds, &columns);
    (columns, gram)
}

/// The columns φ and −j·∂φ/∂Im λ of the viscous law with ∂φ/∂Re λ beside them.
fn with_frequency(
    work: &Columns,
    lambda: &[Complex64],
    mut columns: Array2<Complex64>,
) -> Array2<Complex64> {
    let across = columns.slice(s![.., lambda.len()..]);
    let down = along_frequency(work, lambda, across.to_owned());
    columns
        .append(Axis(1), down.view())
        .expect("the same lines");
    columns
}

/// ∂φ/∂Re λ of the viscous law from −j·∂φ/∂Im λ.
fn along_frequency(
    work: &Columns,
    lambda: &[Complex64],
    mut across: Array2<Complex64>,
) -> Array2<Complex64> {
    // λ − x → Re λ + j·Im λ·√(x/Re λ) − x
    let over_y: Vec<f64> = work.x.iter().map(|x| 1.0 / x.sqrt()).collect();
    for (mut column, pole) in across.columns_mut().into_iter().zip(lambda) {
        let turn = -0.5 * pole.im / pole.re;
        let root = pole.re.sqrt();
        for (value, over_y) in column.iter_mut().zip(&over_y) {
            *value *= Complex64::new(root * over_y, turn);
        }
    }
    across
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    /// Lines of FRFs whose kind is the receptance times so many powers of jω.
    fn lines(law: Damping, kind: i32) -> Columns {
        let x: Vec<f64> = (0..900)
            .map(|k| (0.1 + 0.001 * f64::from(k)).powi(2))
            .collect();
        Columns {
            g: x.iter().map(|x| x.sqrt().powi(kind)).collect(),
            b: Array2::zeros((900, 0)),
            x,
            law,
            leakage: None,
            neighbours: 0.0,
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences() {
        let pole = Complex64::new(0.25, 0.01);
        for law in [Damping::Structural, Damping::Viscous] {
            let work = lines(law, 1);
            let across = basis_derivative(&work, &[pole]);
            let down = match law {
                Damping::Structural => across.clone(),
                Damping::Viscous => along_frequency(&work, &[pole], across.clone()),
            };
            let across = across.mapv(|v| v * Complex64::I);
            for (slope, unit) in [(down, Complex64::ONE), (across, Complex64::I)] {
                let step = 1e-6;
                let at = |sign: f64| basis(&work, &[pole + unit * (sign * step)], &[]);
                let difference = (at(1.0) - at(-1.0)) / Complex64::from(2.0 * step);
                let size = slope.iter().map(|v| v.norm()).fold(0.0, f64::max);
                let error = (&difference - &slope)
                    .iter()
                    .map(|v| v.norm())
                    .fold(0.0, f64::max);
                assert!(error < 1e-5 * size, "{law:?} {unit}: {error} of {size}");
            }
        }
    }

    /// A broad pole at 0 Hz: the step would carry it below.
    #[test]
    fn a_pole_stays_a_resonance() {
        let pole = Complex64::new(0.01, 0.1);
        let step = array![[-1.0], [0.0], [0.0]];
        let (lambda, _) = moved(&[pole], &[0.0], &step);
        assert!(lambda[0].re > 0.0, "{lambda:?}");
    }

    /// The other law turns residues by half a loss factor, whatever the kind of the FRFs.
    #[test]
    fn a_viscous_mode_seen_structurally_is_turned_by_its_damping_ratio() {
        let poles = [(0.09, 0.02), (0.3, 0.03), (0.6, 0.01)];
        let poles = poles.map(|(x, loss)| Complex64::new(x, x * loss));
        let turns = [(Damping::Viscous, 1.0), (Damping::Structural, -1.0)];
        for ((law, sign), kind) in turns.into_iter().flat_map(|t| (0..=2).map(move |k| (t, k))) {
            let work = lines(law, kind);
            let residues = Array2::from_shape_fn((3, 4), |(n, c)| {
                Complex64::from(1.0 + 0.5 * ((3 * n + 2 * c) as f64).sin())
            });
            let b = matmul(basis(&work, &poles, &[]).view(), residues.view());
            let work = work.with_columns(b);
            let common = Common::new(&work, &[], &[-1, 0, 1, 2]).unwrap();
            let start = poles.map(|pole| (pole, 0.0));
            let own = common.fit(&work, &start, 1e-12).unwrap();
            let wrong = common
                .fit(&work.clone().in_law(law.other()), &start, 1e-12)
                .unwrap();
            let most = 1e-9 * wrong.sse + 1e-14 * common.energy;
            assert!(own.sse < most, "{} {}", own.sse, wrong.sse);
            for (n, pole) in poles.iter().enumerate() {
                let expected = sign * 0.5 * pole.im / pole.re;
                assert!(
                    (wrong.turn[n] - expected).abs() < 0.05 * expected.abs(),
                    "{wrong:?}"
                );
                assert!(own.turn[n].abs() < 1e-6, "{own:?}");
            }
        }
    }
}
