//! The virtual panel, its truth, and models that are a little wrong.
#![allow(dead_code)] // each test program uses a part of this

pub mod rig;

use chladni_frf::{ComplexMatrix, FrfKind, ModalModel, ResidualTerm};
use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::{Rendering, Scene};
use ndarray::Array1;
use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::FRAC_1_SQRT_2;
use std::path::Path;
use std::sync::OnceLock;

/// 77 responses, 34 actuators, exact modes; made once per test program. Few lines: the
/// tests need only some of them.
pub fn panel() -> &'static Simulation {
    static PANEL: OnceLock<Simulation> = OnceLock::new();
    PANEL.get_or_init(|| {
        let mut panel = Panel::default();
        (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 10.0);
        simulate(&panel, None, None).unwrap()
    })
}

/// Exact modal model of [`panel`].
pub fn truth() -> &'static ModalModel {
    &panel().truth
}

/// Positions of the 34 actuators, m.
pub fn actuators_m() -> Vec<[f64; 2]> {
    Panel::default().layout().references_m
}

/// The field that the drive of a rendering makes on the panel, at the places of its area.
pub fn true_area_field(rendering: &Rendering, frequency_hz: f64) -> Array1<Complex64> {
    let area = rendering.area.as_ref().unwrap();
    let places: Vec<[f64; 2]> = area
        .y_m
        .iter()
        .flat_map(|&y| area.x_m.iter().map(move |&x| [x, y]))
        .collect();
    let weights = &rendering.weights.weights;
    let drive: Array1<_> = weights.iter().map(|weight| weight.value()).collect();
    let plate = &panel().plate;
    plate
        .mobility_matrix(&places, &actuators_m(), frequency_hz)
        .unwrap()
        .dot(&drive)
}

/// A scene on cells of the whole panel.
pub fn cell_scene(grid: [usize; 2], hot: usize, rest: &str) -> Scene {
    let text = format!(
        "frequency_hz = 300.0\n[zones]\ngrid = [{}, {}]\nhot = [{hot}]\ncells_m = [0.0, 0.0, \
         0.268, 0.170]\n{rest}",
        grid[0], grid[1]
    );
    Scene::parse(&text, Path::new("")).unwrap()
}

/// The scene from `[zones]` on.
pub fn scene(text: &str) -> Scene {
    Scene::parse(text, Path::new("")).unwrap()
}

/// Standard deviations of the errors of a model, relative.
#[derive(Clone, Copy)]
pub struct Errors {
    pub frequency: f64,
    pub loss_factor: f64,
    pub shape: f64,
    /// Of each entry of the receptance at 300 Hz, over its rms.
    pub residual: f64,
}

/// Errors that a fit to 40 dB data leaves: together some 0.4 % of the mobility at 300 Hz.
pub const FIT_40_DB: Errors = Errors {
    frequency: 2e-5,
    loss_factor: 2e-3,
    shape: 3e-3,
    residual: 2e-3,
};
/// The drift of the study: a panel some kelvin warmer.
pub const DRIFT: Errors = Errors {
    frequency: 1e-3,
    loss_factor: 0.1,
    shape: 0.0,
    residual: 0.0,
};

/// `model` with random errors of its in-band modes, which its standard deviations state.
pub fn disturbed(model: &ModalModel, errors: Errors, seed: u64) -> ModalModel {
    use rand_chacha::rand_core::SeedableRng;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
    let mut model = model.clone();
    let circular = |size: f64, normal: &mut dyn FnMut() -> f64| {
        Complex64::new(normal(), normal()) * (size * FRAC_1_SQRT_2)
    };
    for mode in model.modes.iter_mut().filter(|mode| mode.in_band) {
        mode.frequency_std_hz = errors.frequency * mode.frequency_hz;
        mode.frequency_hz *= 1.0 + errors.frequency * normal();
        mode.loss_factor_std = errors.loss_factor * mode.loss_factor;
        mode.loss_factor *= 1.0 + errors.loss_factor * normal();
        mode.shape_std = mode
            .shape
            .0
            .iter()
            .map(|value| errors.shape * value.norm())
            .collect();
        for value in mode.shape.0.iter_mut().chain(&mut mode.participation.0) {
            *value += circular(errors.shape * value.norm(), &mut normal);
        }
    }
    let receptance = model.frf_matrix(FrfKind::Receptance, 300.0);
    let rms =
        (receptance.iter().map(Complex64::norm_sqr).sum::<f64>() / receptance.len() as f64).sqrt();
    let residual = receptance.mapv(|_| circular(errors.residual * rms, &mut normal));
    model.residual_terms.terms.push(ResidualTerm {
        power: 0,
        matrix: ComplexMatrix(residual),
    });
    model
}
