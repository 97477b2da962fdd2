//! The two steps of the seed paper, against closed forms and against what defines a
//! pseudo-inverse.

use crate::common::{actuators_m, cell_scene, scene, truth};
use chladni_frf::{ComplexVector, Damping, Direction, Dof, ModalModel, Mode, Node};
use chladni_plate::{simulate, Panel};
use chladni_render::{render, Ground, Method, ModalSteps, RenderOptions, Rendering, Scene};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

const DRIVE_HZ: f64 = 300.0;

fn two_steps(model: &ModalModel, scene: &Scene) -> (Rendering, ModalSteps) {
    let rendering = render(
        model,
        scene,
        &RenderOptions {
            method: Method::Modal.into(),
            ..Default::default()
        },
    )
    .unwrap();
    let steps = rendering.weights.modal.clone().unwrap();
    (rendering, steps)
}

fn drive(rendering: &Rendering) -> Array1<Complex64> {
    rendering
        .weights
        .weights
        .iter()
        .map(|weight| weight.value())
        .collect()
}

/// γ_n of eq. 8c with Λ_n = 1, without the shape.
fn gamma(mode: &Mode) -> Complex64 {
    let (omega, omega_n) = (TAU * DRIVE_HZ, TAU * mode.frequency_hz);
    Complex64::new(0.0, omega)
        / Complex64::new(
            omega_n.powi(2) - omega.powi(2),
            omega_n.powi(2) * mode.loss_factor,
        )
}

/// The k-th Walsh function of eight: ±1, any two orthogonal.
fn walsh(k: usize) -> impl Fn(usize) -> f64 {
    move |place| {
        if (k & place).count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    }
}

/// Eight responses on two rows and four actuators; three modes with Walsh functions for
/// shapes, at both.
fn orthogonal() -> ModalModel {
    let mut model = truth().clone();
    let dof = |label: usize| Dof::new(label as u64, Direction::PLUS_Z);
    let place = |k: usize| [0.02 * (k % 4) as f64, 0.03 * (k / 4) as f64, 0.0];
    model.nodes = (0..8)
        .map(|k| Node {
            label: k as u64 + 1,
            xyz_m: place(k),
        })
        .collect();
    model.responses = (1..=8).map(dof).collect();
    model.references = (101..=104).map(dof).collect();
    model.damping = Damping::Structural;
    model.residual_terms.terms.clear();
    let column = |k: usize, rows: usize, scale: f64| {
        ComplexVector(
            (0..rows)
                .map(|row| (scale * walsh(k)(row)).into())
                .collect(),
        )
    };
    let modes = [(120.0, 0.01, 1), (290.0, 0.02, 0), (410.0, 0.03, 2)];
    model.modes = modes
        .map(|(frequency_hz, loss_factor, k)| Mode {
            frequency_hz,
            loss_factor,
            in_band: true,
            shape: column(k, 8, 3.0),
            shape_std: vec![0.0; 8],
            participation: column(k, 4, 5.0),
            ..truth().modes[0].clone()
        })
        .to_vec();
    model
}

#[test]
fn orthogonal_shapes_have_coefficients_in_closed_form() {
    let model = orthogonal();
    let scene = scene(
        "frequency_hz = 300.0\n[zones]\ngrid = [2, 1]\nhot = [1]\narea_m = [0.0, \
                       0.0, 0.06, 0.03]\ntransition_m = 0.0\n",
    );
    let (rendering, steps) = two_steps(&model, &scene);
    let hot: Vec<f64> = rendering
        .field
        .ground
        .iter()
        .map(|&ground| if ground == Ground::Hot { 1.0 } else { 0.0 })
        .collect();
    assert_eq!(hot, [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
    // columns of Γ are orthogonal: W_n = ⟨ψ_n, v⟩/(γ_n‖ψ_n‖²); columns of Ψᵀ too: A = Σ_n
    // W_n ψ_n/‖ψ_n‖²
    let expected: Vec<Complex64> = model
        .modes
        .iter()
        .map(|mode| {
            let (product, norm) = mode
                .shape
                .0
                .iter()
                .zip(&hot)
                .fold((0.0, 0.0), |(a, b), (psi, v)| {
                    (a + psi.re * v, b + psi.re * psi.re)
                });
            product / (gamma(mode) * norm)
        })
        .collect();
    let weights: Array1<Complex64> = (0..4)
        .map(|i| {
            model
                .modes
                .iter()
                .zip(&expected)
                .map(|(mode, w)| w * mode.participation.0[i] / (4.0 * 25.0))
                .sum::<Complex64>()
        })
        .collect();
    let found = drive(&rendering);
    let gain = found[0] / weights[0];
    assert!(gain.re > 0.0 && gain.im.abs() < 1e-12 * gain.re, "{gain}");
    let near =
        |a: Complex64, b: Complex64, scale: f64| (a - b * gain).norm() < 1e-12 * scale * gain.re;
    let largest = expected
        .iter()
        .map(|value| value.norm())
        .fold(0.0, f64::max);
    assert!(
        steps
            .asked
            .0
            .iter()
            .zip(&expected)
            .all(|(a, b)| near(*a, *b, largest)),
        "{steps:?} {expected:?}"
    );
    assert!(
        steps
            .driven
            .0
            .iter()
            .zip(&expected)
            .all(|(a, b)| near(*a, *b, largest)),
        "{steps:?} {expected:?}"
    );
    assert!(
        found
            .iter()
            .zip(&weights)
            .all(|(a, b)| near(*a, *b, largest)),
        "{found} {weights}"
    );
    assert_eq!(steps.frequency_hz, [120.0, 290.0, 410.0]);
    assert_eq!((steps.gamma.rank, steps.psi.rank), (3, 3));
    // Ψ is √(4·25) times rows of length one
    assert!(
        steps
            .psi
            .singular_values
            .iter()
            .all(|value| (value - 10.0).abs() < 1e-12),
        "{:?}",
        steps.psi
    );
    assert!((steps.psi.condition() - 1.0).abs() < 1e-12);
}

/// The exact model of the panel with 31 elastic modes in its band.
fn to_1210_hz() -> ModalModel {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.stop_hz, panel.frf.step_hz) = (10.0, 1210.0, 600.0);
    simulate(&panel, None, None).unwrap().truth
}

/// Rows of `shapes` (DOF × mode) of the modes in the band.
fn in_band(model: &ModalModel, pick: fn(&Mode) -> &ComplexVector) -> Array2<Complex64> {
    let columns: Vec<&ComplexVector> = model.in_band_modes().map(pick).collect();
    Array2::from_shape_fn((columns[0].0.len(), columns.len()), |(k, n)| {
        columns[n].0[k]
    })
}

#[test]
fn both_steps_are_least_squares_on_the_panel() {
    let model = to_1210_hz();
    let (rendering, steps) = two_steps(&model, &cell_scene([2, 2], 1, ""));
    let [asked, driven] =
        [&steps.asked, &steps.driven].map(|values| Array1::from(values.0.clone()));
    let gammas: Array1<Complex64> = model.in_band_modes().map(gamma).collect();
    let judged: Vec<usize> = (0..77)
        .filter(|&k| rendering.field.ground[k] != Ground::Ignored)
        .collect();
    let shapes = in_band(&model, |mode| &mode.shape).select(ndarray::Axis(0), &judged) * &gammas;
    let target: Array1<Complex64> = judged
        .iter()
        .map(|&k| {
            Complex64::from(if rendering.field.ground[k] == Ground::Hot {
                1.0
            } else {
                0.0
            })
        })
        .collect();
    let adjoint = shapes.t().mapv(|value| value.conj());
    // the normal equations ΓᴴΓ W = gain·Γᴴ v: Γ has full rank, so that they have one
    // solution
    let (left, right) = (adjoint.dot(&shapes.dot(&asked)), adjoint.dot(&target));
    let norm =
        |vector: &Array1<Complex64>| vector.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    let gain = Complex64::from(norm(&left) / norm(&right));
    assert_eq!(steps.gamma.rank, 31);
    assert!(
        norm(&(&left - &right * gain)) < 1e-9 * norm(&left),
        "{} of {}",
        norm(&(&left - &right * gain)),
        norm(&left)
    );

    // what the actuators give is Ψ·A, and what they cannot give is orthogonal to all they
    // can
    let psi = in_band(&model, |mode| &mode.participation);
    let weights = drive(&rendering);
    assert!(norm(&(psi.t().dot(&weights) - &driven)) < 1e-9 * norm(&driven));
    let short = &asked - &driven;
    assert!(
        norm(&short) > 1e-3 * norm(&asked),
        "Psi has no full rank, and yet everything is given"
    );
    assert!(
        norm(&psi.dot(&short)) < 1e-9 * norm(&short) * steps.psi.singular_values[0],
        "{}",
        norm(&psi.dot(&short))
    );
}

#[test]
fn the_rank_of_psi_is_what_symmetry_allows() {
    let model = to_1210_hz();
    let (_, steps) = two_steps(&model, &cell_scene([2, 2], 1, ""));
    // actuators: patterns of each parity are as many as orbits under both mirrors allow,
    // the short ones on an axis where even
    let places = actuators_m();
    let mirrored = |mirror: [bool; 2]| -> Vec<usize> {
        let image = |p: &[f64; 2]| {
            [
                if mirror[0] { 0.268 - p[0] } else { p[0] },
                if mirror[1] { 0.170 - p[1] } else { p[1] },
            ]
        };
        let nearest = |q: [f64; 2]| {
            places
                .iter()
                .position(|p| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9)
                .unwrap()
        };
        places.iter().map(|p| nearest(image(p))).collect()
    };
    // characters of the group of mirrors: dimension = ¼ Σ_g χ(g)·(actuators that g leaves
    // in place)
    let fixed = |mirror| {
        mirrored(mirror)
            .iter()
            .enumerate()
            .filter(|(k, image)| k == *image)
            .count() as f64
    };
    let patterns = |odd: [bool; 2]| -> usize {
        let sum: f64 = [[false, false], [true, false], [false, true], [true, true]]
            .map(|mirror| {
                let sign = if (mirror[0] && odd[0]) != (mirror[1] && odd[1]) {
                    -1.0
                } else {
                    1.0
                };
                sign * fixed(mirror)
            })
            .iter()
            .sum();
        (sum / 4.0).round() as usize
    };
    let responses: Vec<[f64; 3]> = model.nodes[..77].iter().map(|node| node.xyz_m).collect();
    let is_odd = |mode: &Mode, axis: usize| {
        let image = |p: &[f64; 3]| {
            if axis == 0 {
                [0.268 - p[0], p[1]]
            } else {
                [p[0], 0.170 - p[1]]
            }
        };
        let at = |q: [f64; 2]| {
            responses
                .iter()
                .position(|p| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9)
                .unwrap()
        };
        responses
            .iter()
            .enumerate()
            .map(|(k, p)| mode.shape.0[k].re * mode.shape.0[at(image(p))].re)
            .sum::<f64>()
            < 0.0
    };
    let classes = [[false, false], [true, false], [false, true], [true, true]];
    let modes = classes.map(|odd| {
        model
            .in_band_modes()
            .filter(|mode| [is_odd(mode, 0), is_odd(mode, 1)] == odd)
            .count()
    });
    let actuators = classes.map(patterns);
    assert_eq!((modes, actuators), ([10, 8, 6, 7], [9, 8, 9, 8]));
    let rank: usize = modes
        .iter()
        .zip(actuators)
        .map(|(&modes, actuators)| modes.min(actuators))
        .sum();
    assert_eq!(
        (steps.psi.rank, steps.psi.condition()),
        (rank, f64::INFINITY)
    );
}
