//! Damping law: structural, viscous, or not to be told on these data (theory.md, eq.
//! L1–L3).
//!
//! Both laws describe a single light resonance almost equally well: the wrong one shifts
//! the frequency by η²/4 and the loss factor by 3η²/8 (relative), and turns the
//! residues by η/2. The turn decides, unless a phase or a delay of all FRFs explains it.

use crate::damping::basis::basis;
use crate::damping::law::constant_power;
use crate::damping::limits;
use crate::damping::phased::{Common, LawFit};
use crate::damping::places::in_plane_of;
use crate::data::columns::Columns;
use crate::data::information::answer;
use chladni_frf::{Damping, FrfKind};
use chladni_linalg::{matmul, LinalgError};
use ndarray::{Array1, Array2, ArrayView1};
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI};

/// Both laws, in the order of pairs.
const LAWS: [Damping; 2] = [Damping::Structural, Damping::Viscous];

/// The evidence of the data on the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Verdict {
    /// They follow this law, whatever phase and delay all FRFs have in common.
    Decided(Damping),
    /// They follow it if phases are true to better than so many degrees.
    IfPhasesTrue(Damping, f64),
    /// Their phases speak for one law, and one shape per mode holds only in the other.
    Disputed,
    /// They do not tell.
    Undecidable,
}

impl Verdict {
    /// The law, as far as there is one.
    pub fn law(self) -> Option<Damping> {
        match self {
            Self::Decided(law) | Self::IfPhasesTrue(law, _) => Some(law),
            Self::Disputed | Self::Undecidable => None,
        }
    }
}

/// Poles with the linear part of their fit, in the law of the columns they were found on.
pub(crate) struct Fitted<'a> {
    /// Poles in the x plane.
    pub lambda: &'a [Complex64],
    /// Powers of x of the residual terms.
    pub powers: &'a [i32],
    /// Residues, then residual terms; axes (row, column).
    pub coefficients: &'a Array2<Complex64>,
    /// Noise variance of a value.
    pub variance: f64,
    /// Number of FRFs.
    pub frfs: usize,
    /// Exponential window of the records.
    pub window: Window,
}

/// An exponential window of records, as it acts on FRFs of a kind. It turns residues (theory.md,
/// eq. F5) by about as much as the wrong law does.
#[derive(Clone, Copy)]
pub(crate) struct Window {
    pub kind: FrfKind,
    /// Decay, in units of ω_max; 0 without a window.
    pub decay: f64,
}

impl Window {
    /// Angle of the residues of a real shape, rad, where `pole` was fitted in this law.
    fn turn(self, law: Damping, pole: Complex64) -> f64 {
        let fitted = Complex64::I * pole.sqrt();
        let turn = fitted.arg() - (fitted + self.decay).arg();
        f64::from(constant_power(law, self.kind)) * turn
    }
}

/// The verdict on poles found in the law of `work`.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn verdict(work: &Columns, fitted: &Fitted) -> Result<Verdict, LinalgError> {
    let says = |n: &usize| {
        is_mode(work, fitted.lambda[*n]) && most_said(work, fitted, *n) > limits::SAYS_NOTHING
    };
    let (modes, others): (Vec<usize>, Vec<usize>) = (0..fitted.lambda.len()).partition(says);
    if modes.is_empty() {
        return Ok(Verdict::Undecidable);
    }
    let outside: Vec<Complex64> = others.into_iter().map(|n| fitted.lambda[n]).collect();
    let common = Common::new(work, &outside, fitted.powers)?;
    let angle = |n: usize| {
        let squares: Complex64 = fitted.coefficients.row(n).iter().map(|r| r * r).sum();
        0.5 * squares.arg()
    };
    let start = |law: Damping| -> Vec<(Complex64, f64)> {
        let of_mode = |&n: &usize| {
            let found = (fitted.lambda[n], angle(n));
            match law == work.law {
                true => Some(found),
                false => read_in(law, found),
            }
        };
        modes.iter().filter_map(of_mode).collect()
    };
    let fit = |law: Damping, start: &[(Complex64, f64)]| {
        common.fit(&work.axis().in_law(law), start, fitted.variance)
    };
    let (structural, viscous) = rayon::join(
        || fit(LAWS[0], &start(LAWS[0])),
        || fit(LAWS[1], &start(LAWS[1])),
    );
    let mut laws = [structural?, viscous?];
    for _ in 0..limits::RESTARTS {
        if !overtaken(&mut laws, fitted.variance, fit) {
            break;
        }
    }
    for (law, fit) in LAWS.into_iter().zip(&mut laws) {
        for (turn, pole) in fit.turn.iter_mut().zip(&fit.lambda) {
            *turn -= fitted.window.turn(law, *pole);
        }
    }
    Ok(weighed(&laws, fitted.variance, fitted.frfs))
}

/// True for a pole of the band that is no background.
fn is_mode(work: &Columns, pole: Complex64) -> bool {
    work.in_band(pole) && pole.im > 0.0 && pole.im < limits::BROAD * pole.re
}

/// Difference of −2 ln likelihood that the turn of a mode's residues by η/2 makes where no other
/// mode is near, which would hide a part of it.
fn most_said(work: &Columns, fitted: &Fitted, n: usize) -> f64 {
    let power = |values: ArrayView1<Complex64>| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let pole = fitted.lambda[n];
    let column = power(basis(work, &[pole], &[]).column(0));
    let turn = 0.5 * pole.im / pole.re;
    2.0 / fitted.variance * column * power(fitted.coefficients.row(n)) * turn * turn
}

/// The phase of all FRFs, degrees, that would pass for the other law: a quarter of the mean loss
/// factor, as [`confusing_turn_of_fits`] finds it in angles.
pub(crate) fn confusing_turn(work: &Columns, lambda: &[Complex64]) -> f64 {
    let modes = lambda.iter().filter(|&&pole| is_mode(work, pole));
    let loss_factors: Vec<f64> = modes.map(|pole| pole.im / pole.re).collect();
    let mean = loss_factors.iter().sum::<f64>() / loss_factors.len().max(1) as f64;
    (limits::SHAPE_TURN * mean).to_degrees()
}

/// Pole and angle of a mode of the other law as they come out in `law`: the same resonance, its
/// residue turned by half the loss factor.
fn read_in(law: Damping, (pole, angle): (Complex64, f64)) -> Option<(Complex64, f64)> {
    let turn = match law {
        Damping::Structural => 0.5,
        Damping::Viscous => -0.5,
    };
    Some((in_plane_of(law, pole)?, angle + turn * pole.im / pole.re))
}

/// Fits the law that explains less again, from the poles and angles of the other, where they
/// differ enough to decide: a search may have ended in a minimum that is not the best. A fit that
/// already stands there is not repeated. True where it now explains more than the other.
fn overtaken(
    laws: &mut [LawFit; 2],
    variance: f64,
    fit: impl Fn(Damping, &[(Complex64, f64)]) -> Result<LawFit, LinalgError>,
) -> bool {
    let worse = usize::from(laws[1].sse > laws[0].sse);
    let [best, most] = [1 - worse, worse].map(|law| laws[law].sse);
    if 2.0 * (most - best) < limits::DECIDES * variance {
        return false;
    }
    let start = laws[1 - worse].lambda.iter().zip(&laws[1 - worse].turn);
    let start: Option<Vec<(Complex64, f64)>> = start
        .map(|(&pole, &turn)| read_in(LAWS[worse], (pole, turn)))
        .collect();
    let Some(start) = start else { return false };
    let ended = laws[worse].lambda.iter().zip(&laws[worse].turn);
    let stands_there = |((ended, turn), (pole, angle)): ((&Complex64, &f64), &(Complex64, f64))| {
        let off = wrapped(&[turn - angle], 0.0)[0];
        (ended - pole).norm() < limits::SAME_END * pole.im && off.abs() < limits::SAME_END
    };
    if ended.zip(&start).all(stands_there) {
        return false;
    }
    // both fits are kept if a third cannot be made
    let Ok(again) = fit(LAWS[worse], &start) else {
        return false;
    };
    let overtakes = again.sse < best;
    if again.sse < most {
        laws[worse] = again;
    }
    overtakes
}

/// The verdict on the fits in the structural and in the viscous law.
fn weighed(laws: &[LawFit; 2], variance: f64, frfs: usize) -> Verdict {
    let modes = laws[0].turn.len();
    // the mean of angles that differ from FRF to FRF is less certain
    let scatter = laws
        .each_ref()
        .map(|law| law.relief / (0.5 * variance) / (modes * frfs.saturating_sub(1)).max(1) as f64);
    let of_sums = 2.0 / variance * (laws[0].sse - laws[1].sse);
    let decided = |angles: [f64; 2], freedom: usize| {
        let k = freedom as f64;
        let gain = of_sums + angles[0] - angles[1];
        let better = usize::from(gain > 0.0);
        let scale = 1f64.max(angles[better] / k).max(scatter[better]);
        let explained = (angles[better] / scatter[better].max(1.0) - k) / (2.0 * k).sqrt();
        // poles that fell together leave no information that could be weighed
        let sound = angles.iter().all(|angle| *angle > limits::FORM_LEAST);
        (sound && gain.abs() > limits::DECIDES * scale && explained < limits::ANGLES_EXPLAINED)
            .then_some(LAWS[better])
    };
    let weight = 2.0 / variance;
    if modes > 2 {
        let angles = laws.each_ref().map(|law| weight * beside_delay(law));
        if let Some(law) = decided(angles, modes - 2) {
            return Verdict::Decided(law);
        }
    }
    let angles = laws
        .each_ref()
        .map(|law| weight * form(&law.information, &wrapped(&law.turn, 0.0)));
    match decided(angles, modes) {
        Some(law) => Verdict::IfPhasesTrue(law, confusing_turn_of_fits(laws).to_degrees()),
        None => Verdict::Undecidable,
    }
}

/// Angles modulo π, as near to `middle` as they come: the sign of a residue is free.
fn wrapped(turn: &[f64], middle: f64) -> Array1<f64> {
    turn.iter()
        .map(|angle| middle + (angle - middle + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2)
        .collect()
}

/// θᵀWθ.
fn form(weight: &Array2<f64>, angles: &Array1<f64>) -> f64 {
    angles.dot(&weight.dot(angles))
}

/// The least of (θ − θ₀ + ωτ)ᵀW(θ − θ₀ + ωτ).
fn beside_delay(law: &LawFit) -> f64 {
    let sum: Complex64 = law
        .turn
        .iter()
        .zip(law.information.diag())
        .map(|(angle, weight)| Complex64::from_polar(*weight, 2.0 * angle))
        .sum();
    let turn = wrapped(&law.turn, 0.5 * sum.arg());
    let design = Array2::from_shape_fn((turn.len(), 2), |(n, p)| {
        if p == 0 {
            1.0
        } else {
            law.lambda[n].re.sqrt()
        }
    });
    let weighted = matmul(law.information.view(), design.view());
    let right = weighted.t().dot(&turn).insert_axis(ndarray::Axis(1));
    match answer(matmul(design.t(), weighted.view()).view(), right.view()) {
        Ok(found) => form(&law.information, &(&turn - &design.dot(&found.column(0)))),
        Err(_) => form(&law.information, &turn),
    }
}

/// Half the weighted mean difference of the modes' angles in the two laws: the phase error of all
/// FRFs that makes both laws equally good.
fn confusing_turn_of_fits(laws: &[LawFit; 2]) -> f64 {
    let [structural, viscous] = laws.each_ref().map(|law| wrapped(&law.turn, 0.0));
    let weight = laws[0].information.diag();
    let mean = |values: &Array1<f64>| values.dot(&weight) / weight.sum();
    (mean(&structural) - mean(&viscous)).abs() / 2.0
}

/// The loss factor of the structure: `loss_factor` less what an exponential window adds to it,
/// 2·`decay`/`omega`, both in one unit. Poles of the structure differ between the laws by this one.
pub(crate) fn without_decay(loss_factor: f64, omega: f64, decay: f64) -> f64 {
    (loss_factor - 2.0 * decay / omega).max(0.0)
}

/// Shift of frequency or loss factor under the wrong law, whichever is more, in error
/// bars.
pub(crate) fn shift(loss_factor: f64, relative_omega_std: f64, loss_factor_std: f64) -> f64 {
    let [omega, loss, _] = shifts(loss_factor);
    (omega / relative_omega_std).max(loss / loss_factor_std)
}

/// Shifts under the wrong law: of the frequency, relative, of the loss factor, and of the
/// angle of a mass-normalised shape, rad.
pub(crate) fn shifts(loss_factor: f64) -> [f64; 3] {
    let square = loss_factor * loss_factor;
    [
        limits::FREQUENCY_SHIFT * square,
        limits::LOSS_SHIFT * square * loss_factor,
        limits::SHAPE_TURN * loss_factor,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles of eight modes with the same weight, loss factors within a factor of two.
    fn laws(error: impl Fn(f64) -> f64) -> [LawFit; 2] {
        let omega: Vec<f64> = (1..=8).map(|n| 0.12 * f64::from(n)).collect();
        let loss = |n: usize| 0.01 * (1.0 + ((7 * n) % 5) as f64 / 4.0);
        [0.0, 0.5].map(|turned| LawFit {
            sse: 1.0,
            relief: 0.0,
            turn: (0..8).map(|n| error(omega[n]) - turned * loss(n)).collect(),
            lambda: omega.iter().map(|omega| (omega * omega).into()).collect(),
            information: Array2::eye(8),
        })
    }

    #[test]
    fn shifts_are_those_of_one_pole_read_in_both_laws() {
        for loss_factor in [0.005, 0.02, 0.08] {
            let viscous = Complex64::new(1.0, loss_factor);
            let structural = in_plane_of(Damping::Structural, viscous).unwrap();
            let [omega, loss, _] = shifts(loss_factor);
            let of_omega = 1.0 - structural.re.sqrt();
            let of_loss = structural.im / structural.re - loss_factor;
            for (told, seen) in [(omega, of_omega), (loss, of_loss)] {
                assert!(
                    (seen / told - 1.0).abs() < 0.01,
                    "{loss_factor}: {seen} for {told}"
                );
            }
        }
    }

    #[test]
    fn a_phase_and_a_delay_decide_nothing_and_hide_nothing() {
        // angles known to 1e-4 rad
        let variance = 2.0 * 1e-8;
        let errors: [fn(f64) -> f64; 3] = [|_| 0.0, |_| 0.01, |omega| 0.003 - 0.02 * omega];
        for error in errors {
            assert_eq!(
                weighed(&laws(error), variance, 12),
                Verdict::Decided(Damping::Structural)
            );
        }
        // known to 0.1 rad
        assert_eq!(
            weighed(&laws(|_| 0.0), 2.0 * 1e-2, 12),
            Verdict::Undecidable
        );
    }

    #[test]
    fn angles_that_no_law_explains_decide_nothing() {
        let wild = |omega: f64| 0.05 * (40.0 * omega).sin();
        assert_eq!(weighed(&laws(wild), 2.0 * 1e-8, 12), Verdict::Undecidable);
    }

    /// Receptances on 900 lines of modes (x, loss factor) in one law, real residues.
    fn lines(law: Damping, modes: &[(f64, f64)], residues: &Array2<Complex64>) -> Columns {
        let x: Vec<f64> = (0..900)
            .map(|k| (0.1 + 0.001 * f64::from(k)).powi(2))
            .collect();
        let work = Columns {
            g: vec![1.0; 900],
            b: Array2::zeros((900, 0)),
            x,
            law,
            leakage: None,
            neighbours: 0.0,
        };
        let b = matmul(basis(&work, &poles(modes), &[]).view(), residues.view());
        work.with_columns(b)
    }

    fn poles(modes: &[(f64, f64)]) -> Vec<Complex64> {
        let pole = |&(x, loss): &(f64, f64)| Complex64::new(x, x * loss);
        modes.iter().map(pole).collect()
    }

    #[test]
    fn poles_of_noise_have_no_say_in_the_law() {
        let modes: Vec<(f64, f64)> = [(0.09, 0.02), (0.3, 0.03), (0.6, 0.01)]
            .into_iter()
            .chain((0..20).map(|n| (0.62 + 0.015 * f64::from(n), 1e-5)))
            .collect();
        // those of noise are a thousandth as large
        let residues = Array2::from_shape_fn((modes.len(), 4), |(n, c)| {
            let size = if n < 3 { 1.0 } else { 1e-3 };
            Complex64::from(size * (1.0 + 0.5 * ((3 * n + 2 * c) as f64).sin()))
        });
        let variance = 1e-2;
        for law in LAWS {
            let work = lines(law, &modes, &residues);
            let lambda = poles(&modes);
            let fitted = Fitted {
                lambda: &lambda,
                powers: &[-1, 0, 1],
                coefficients: &residues,
                variance,
                frfs: 4,
                window: Window {
                    kind: FrfKind::Mobility,
                    decay: 0.0,
                },
            };
            let says: Vec<usize> = (0..modes.len())
                .filter(|&n| most_said(&work, &fitted, n) > limits::SAYS_NOTHING)
                .collect();
            assert_eq!(says, [0, 1, 2]);
            assert_eq!(verdict(&work, &fitted).unwrap().law(), Some(law));
            // none of them says anything
            let weak = residues.mapv(|value| 1e-3 * value);
            let silent = Fitted {
                coefficients: &weak,
                variance: 1e4,
                ..fitted
            };
            assert_eq!(verdict(&work, &silent).unwrap(), Verdict::Undecidable);
        }
    }

    #[test]
    fn a_law_that_a_search_left_half_way_starts_again_from_the_other() {
        let modes = [(0.09, 0.02), (0.3, 0.03)];
        let residues = Array2::from_shape_fn((2, 4), |(n, c)| {
            Complex64::from(1.0 + 0.5 * ((3 * n + 2 * c) as f64).sin())
        });
        let work = lines(Damping::Viscous, &modes, &residues);
        let common = Common::new(&work, &[], &[-1, 0, 1]).unwrap();
        let variance = 1e-12;
        let made = std::cell::Cell::new(0);
        let fit = |law: Damping, start: &[(Complex64, f64)]| {
            made.set(made.get() + 1);
            common.fit(&work.axis().in_law(law), start, variance)
        };
        let start: Vec<(Complex64, f64)> = poles(&modes).into_iter().map(|p| (p, 0.0)).collect();
        let good = fit(Damping::Structural, &start).unwrap();
        let (sse, spoilt) = (good.sse, good.sse * 1e6 + 1.0);
        // as if the search in the true law had ended far away
        let found = fit(Damping::Viscous, &start).unwrap();
        let lost = LawFit {
            sse: spoilt,
            lambda: found.lambda.iter().map(|pole| 1.1 * pole).collect(),
            ..found
        };
        let mut laws = [good, lost];
        assert!(overtaken(&mut laws, variance, fit));
        assert!(laws[1].sse < 1e-2 * sse, "{} {sse}", laws[1].sse);
        // what stands cannot be overtaken, and a fit that stands there is not made again
        laws[0].turn[1] += PI;
        let before = made.get();
        assert!(!overtaken(&mut laws, variance, fit));
        assert_eq!(made.get(), before);
    }
}
