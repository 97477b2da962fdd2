//! The damping law where phases do not tell it, or a window turns them.

use crate::common::fitted;
use chladni_frf::{Damping, FrfSet, FrfValues, Mode, Trust};
use chladni_plate::Synthetic;
use chladni_rfp::FitOptions;
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use std::f64::consts::TAU;

const MODES_HZ: [f64; 8] = [36.4, 68.9, 109.3, 124.1, 216.2, 294.1, 349.8, 451.7];
const LOSS: f64 = 0.02;

/// FRFs of so many responses to two references: the values `of` (response, reference) and ω, and the
/// white noise of a synthetic set at their level.
fn set(
    responses: usize,
    snr_db: f64,
    seed: u64,
    of: impl Fn([usize; 2], f64) -> Complex64,
) -> FrfSet {
    let axis = Array1::range(9.8, 499.6, 0.30625);
    set_on(axis, responses, snr_db, seed, of)
}

/// The same on lines at these frequencies, Hz.
fn set_on(
    frequency_hz: Array1<f64>,
    responses: usize,
    snr_db: f64,
    seed: u64,
    of: impl Fn([usize; 2], f64) -> Complex64,
) -> FrfSet {
    let [mut frf, quiet] = [snr_db, f64::INFINITY].map(|snr_db| {
        let one = Synthetic {
            natural_frequency_hz: vec![100.0],
            loss_factor: vec![LOSS],
            responses,
            references: 2,
            frequency_hz: frequency_hz.clone(),
            snr_db,
            seed,
            ..Synthetic::default()
        };
        one.build().expect("a set").frf
    });
    let axis = frf.frequency_hz.clone();
    let (FrfValues::F64(values), FrfValues::F64(quiet)) = (&mut frf.values, quiet.values) else {
        panic!("simulated values are f64");
    };
    let wanted = Array3::from_shape_fn(values.raw_dim(), |(i, j, k)| of([i, j], TAU * axis[k]));
    let energy = |all: &Array3<Complex64>| all.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let level = (energy(&wanted) / energy(&quiet)).sqrt();
    *values = wanted + (&*values - &quiet) * Complex64::from(level);
    frf
}

/// The sum of the modes: of each (mode, response, reference) and its natural frequency, rad/s.
fn modes([i, j]: [usize; 2], of_mode: impl Fn([usize; 3], f64) -> Complex64) -> Complex64 {
    let of = |(n, f): (usize, &f64)| of_mode([n, i, j], TAU * f);
    MODES_HZ.iter().enumerate().map(of).sum()
}

/// The law that the data tell without a condition, and how far the sure mode next to each natural
/// frequency is off, in error bars.
fn told(frf: &FrfSet, expected_hz: &[f64]) -> (Option<Damping>, Vec<f64>) {
    let model = fitted(frf, &FitOptions::default());
    let findings = &model.quality.findings;
    let is_told = !findings.iter().any(|f| f.code.starts_with("law-"));
    let off = |f: &f64| {
        let sure = model.modes.iter().filter(|mode| mode.trust == Trust::Sure);
        let off = |mode: &Mode| (mode.frequency_hz - f).abs();
        let mode = sure
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .expect("a sure mode");
        assert!(!is_told || mode.frequency_std_hz < 1e-6 * f, "{mode:?}");
        off(mode) / mode.frequency_std_hz
    };
    let off = expected_hz.iter().map(off).collect();
    (is_told.then_some(model.damping), off)
}

/// A real shape and its participations, and the angle by which a complex one is turned, rad.
fn shapes([n, i, j]: [usize; 3], seed: u64) -> (f64, f64) {
    let (n, i, j, seed) = (n as f64, i as f64 + 1.0, j as f64 + 1.0, seed as f64);
    let real = ((3.0 * n + 2.0) * i + seed).sin() * ((5.0 * n + 3.0) * j).cos();
    (real, 0.3 * ((7.0 * n + 1.0) * i + 2.0 * seed).sin())
}

/// Modes of complex shapes in structural damping.
pub(super) fn complex_shapes(snr_db: f64, seed: u64) -> FrfSet {
    set(12, snr_db, seed, |at, omega| {
        modes(at, |at, natural| {
            let (real, angle) = shapes(at, seed);
            let squared = natural * natural * Complex64::new(1.0, LOSS);
            Complex64::from_polar(real, angle) * Complex64::I * omega / (squared - omega * omega)
        })
    })
}

/// Complex shapes hide the law from phases. With little noise the wrong law needs more poles, and
/// in the right one error bars hold no other law.
#[test]
fn of_complex_shapes_the_structural_law_needs_fewer_poles() {
    let (law, off) = told(&complex_shapes(110.0, 1), &MODES_HZ);
    assert_eq!(law, Some(Damping::Structural));
    assert!(off.iter().all(|off| *off < 5.0), "{off:?}");
}

/// Mobility of masses of 1 kg on springs, one of them damped by a dashpot (N·s/m) to the ground: two
/// masses, between which is one of the springs.
pub(super) struct OnOneDashpot {
    pub(super) dashpot: f64,
}

impl OnOneDashpot {
    const FIRST: f64 = 4e5;
    const BETWEEN: f64 = 3e5;
    const SECOND: f64 = 9e5;

    /// M·s² + C·s + K without its off-diagonal, which is −[`Self::BETWEEN`].
    fn diagonal(&self, s: Complex64) -> [Complex64; 2] {
        let whole = s * s + Self::BETWEEN;
        [whole + self.dashpot * s + Self::FIRST, whole + Self::SECOND]
    }

    fn determinant(&self, s: Complex64) -> Complex64 {
        let [a, d] = self.diagonal(s);
        a * d - Self::BETWEEN * Self::BETWEEN
    }

    /// FRFs of both masses to both.
    pub(super) fn set(&self, snr_db: f64, seed: u64) -> FrfSet {
        set(2, snr_db, seed, |at, omega| {
            let s = Complex64::I * omega;
            let [a, d] = self.diagonal(s);
            let cofactor = match at {
                [0, 0] => d,
                [1, 1] => a,
                _ => Self::BETWEEN.into(),
            };
            s * cofactor / self.determinant(s)
        })
    }

    fn natural_hz(&self) -> [f64; 2] {
        [800.0, 1150.0].map(|start| {
            let mut s = Complex64::new(-1.0, start);
            for _ in 0..50 {
                let slope = (self.determinant(s + 1e-3) - self.determinant(s - 1e-3)) / 2e-3;
                s -= self.determinant(s) / slope;
            }
            s.norm() / TAU
        })
    }
}

/// Two masses on springs, one of them damped by a dashpot to the ground: noise may leave the law
/// open, and never makes it the wrong one.
#[test]
fn of_masses_with_one_dashpot_the_viscous_law_needs_fewer_poles() {
    let masses = OnOneDashpot { dashpot: 100.0 };
    let expected_hz = masses.natural_hz();
    let mut laws = Vec::new();
    for seed in 1..=8 {
        let frf = masses.set(80.0, seed);
        let (law, off) = told(&frf, &expected_hz);
        assert!(off.iter().all(|off| *off < 5.0), "seed {seed}: {off:?}");
        laws.push(law);
    }
    assert!(laws.contains(&Some(Damping::Viscous)), "{laws:?}");
    assert!(!laws.contains(&Some(Damping::Structural)), "{laws:?}");
}

/// An exponential window turns the residues of a viscous mode by α/ω, which is as much as the law
/// does: where the α is told it decides nothing.
#[test]
fn an_exponential_window_makes_the_law_no_other() {
    let alpha = 0.5;
    for seed in 1..=2 {
        let windowed = set(12, 50.0, seed, |at, omega| {
            let s = Complex64::new(alpha, omega);
            modes(at, |at, natural| {
                shapes(at, seed).0 * s / (s * s + LOSS * natural * s + natural * natural)
            })
        });
        let options = FitOptions {
            exponential_window_per_s: Some(alpha),
            ..FitOptions::default()
        };
        let model = fitted(&windowed, &options);
        assert_eq!(model.damping, Damping::Viscous, "seed {seed}");
        assert_eq!(model.in_band_modes().count(), MODES_HZ.len());
        for (mode, f) in model.in_band_modes().zip(MODES_HZ) {
            let off = (mode.frequency_hz - f).abs() / mode.frequency_std_hz;
            assert!(off < 5.0, "{f} Hz, seed {seed}: {off} error bars");
        }
    }
}

/// Complex shapes without noise: the right law explains them with the modes alone.
#[test]
fn of_complex_shapes_without_noise_only_the_modes_are_found() {
    let seed = 1;
    for law in [Damping::Structural, Damping::Viscous] {
        let frf = set(12, f64::INFINITY, seed, |at, omega| {
            modes(at, |at, natural| {
                let (real, angle) = shapes(at, seed);
                let (residue, s) = (Complex64::from_polar(real, angle), Complex64::I * omega);
                match law {
                    Damping::Structural => {
                        let squared = natural * natural * Complex64::new(1.0, LOSS);
                        residue * s / (squared - omega * omega)
                    }
                    Damping::Viscous => {
                        let damping = 0.5 * LOSS;
                        let damped = natural * (1.0 - damping * damping).sqrt();
                        let pole = Complex64::new(-natural * damping, damped);
                        let residue = residue / (2.0 * Complex64::I * damped);
                        s * (residue / (s - pole) + residue.conj() / (s - pole.conj()))
                    }
                }
            })
        });
        let model = fitted(&frf, &FitOptions::default());
        assert_eq!(model.damping, law);
        let found: Vec<f64> = model
            .in_band_modes()
            .map(|mode| mode.frequency_hz)
            .collect();
        assert_eq!(found.len(), MODES_HZ.len(), "{law:?}: {found:?}");
        for (found, truth) in found.iter().zip(MODES_HZ) {
            let error = (found / truth - 1.0).abs();
            assert!(error < 1e-8, "{law:?}: {found} for {truth}");
        }
    }
}

/// Two masses on springs, of which the one between them has losses: a mode far narrower than a line,
/// beside a wide one. Without noise a search for few poles went astray in the structural law, and the
/// viscous one was told.
#[test]
fn a_search_that_goes_astray_tells_no_law() {
    let masses = [0.4463016044358767, 0.5576103249518385];
    let ground = [325280.59210080304, 337206.26194611785];
    let between = 1082246.6186273394 * Complex64::new(1.0, 0.09692681239587321);
    let axis = Array1::linspace(10.0, 400.0, 400);
    let frf = set_on(axis, 2, f64::INFINITY, 41, |[i, j], omega| {
        let [a, d] = [0, 1].map(|n| between + ground[n] - masses[n] * omega * omega);
        let cofactor = match [i, j] {
            [0, 0] => d,
            [1, 1] => a,
            _ => between,
        };
        Complex64::I * omega * cofactor / (a * d - between * between)
    });
    let model = fitted(&frf, &FitOptions::default());
    let is_open = model
        .quality
        .findings
        .iter()
        .any(|f| f.code.starts_with("law-"));
    assert!(
        is_open || model.damping == Damping::Structural,
        "{:?}",
        model.quality
    );
    assert_eq!(model.in_band_modes().count(), 2);
}
