//! Drives in time against an FFT of the real signal, and steps against closed forms.

use super::*;

use crate::panel::operator::Operator;
use crate::time::envelope::{Edge, Envelope, Ramp};
use crate::time::tracks::{Track, Tracks};
use chladni_frf::{ComplexMatrix, Damping, ModalModel, Mode, ResidualTerm};
use chladni_linalg::fft;
use ndarray::Array1;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 48_000.0;
const FRAMES: usize = 96_000;
/// Lines of the FFT up to 12 kHz.
const LINES: i32 = 24_000;

fn panel() -> ModalModel {
    let mut panel = chladni_plate::Panel::default();
    (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 300.0);
    // so that two seconds later nothing rings
    panel.plate.loss_factor = chladni_plate::LossFactor::Common(0.05);
    (panel.responses.grid, panel.responses.spacing_m) = ([4, 3], 0.04);
    (panel.references.edge_count, panel.references.spacing_m) = ([3, 2], 0.07);
    chladni_plate::simulate(&panel, None, None).unwrap().truth
}

fn burst(actuators: usize) -> Tracks {
    let ramp = |start_s: f64| Ramp {
        start_s,
        duration_s: 0.01,
    };
    let some = |seed: f64| -> Array1<Complex64> {
        (0..actuators)
            .map(|j| Complex64::from_polar(1.0, seed * (j * j) as f64))
            .collect()
    };
    // whose derivatives the lines of a spectrum below 3 kHz can hold
    let spline = Track {
        pattern: some(1.3),
        correction: Some(some(1.9) * Complex64::from(1e-3)),
        envelope: Envelope::Spline {
            start_s: 0.03,
            knot_s: 0.005,
        },
    };
    let gate = Track {
        pattern: some(0.7),
        correction: None,
        envelope: Envelope::Gate {
            rise: Edge::Cosine(ramp(0.02)),
            fall: Edge::Cosine(ramp(0.12)),
        },
    };
    Tracks {
        frequency_hz: 300.0,
        tracks: vec![gate, spline],
    }
}

/// Signal that goes through the mobility.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Signal {
    /// The envelopes on their carrier, with the lines of both signs.
    Complex,
    /// Its real part, as a coil plays it, by the lines above 0 Hz.
    Real,
}

/// The mobility of a model at any frequency: the causal pairs of its modes, its
/// residual terms as they are, and what is left at the carrier as a real system has it.
struct Exact<'a> {
    model: &'a ModalModel,
    operator: &'a Operator,
    causal: &'a CausalModel,
    left: Array2<Complex64>,
}

impl<'a> Exact<'a> {
    fn new(model: &'a ModalModel, operator: &'a Operator, causal: &'a CausalModel) -> Self {
        let mut exact = Self {
            model,
            operator,
            causal,
            left: Array2::zeros(operator.mobility.dim()),
        };
        for (j, mut column) in exact.left.columns_mut().into_iter().enumerate() {
            let mut force = Array1::zeros(causal.inputs.ncols());
            force[j] = Complex64::ONE;
            let known = terms(model, operator, causal.carrier_rad_per_s, &force)
                + modal(causal, causal.carrier_rad_per_s, &force);
            column.assign(&(&operator.mobility.column(j) - &known));
        }
        exact
    }

    fn under(&self, omega: f64, force: &Array1<Complex64>) -> Array1<Complex64> {
        let turn = omega / self.causal.carrier_rad_per_s;
        let left = |value: Complex64| Complex64::new(value.re, turn * value.im);
        modal(self.causal, omega, force)
            + terms(self.model, self.operator, omega, force)
            + self.left.mapv(left).dot(force)
    }
}

impl Exact<'_> {
    /// Of the panel as a whole.
    fn acceleration(&self) -> Array2<Complex64> {
        let terms = &self.model.residual_terms;
        let mut sum = Array2::zeros(self.operator.mobility.dim());
        for term in terms.terms.iter().filter(|term| term.power == -2) {
            let factor = -terms.omega_scale_rad_per_s.powi(2);
            sum.scaled_add(factor.into(), &term.matrix.0);
        }
        sum
    }
}

/// Velocity of the modes.
fn modal(causal: &CausalModel, omega: f64, force: &Array1<Complex64>) -> Array1<Complex64> {
    let mut states = causal.inputs.dot(force);
    for (state, pole) in states.iter_mut().zip(&causal.poles) {
        *state = match *pole == Complex64::ZERO {
            true => Complex64::ZERO,
            false => *state / (Complex64::new(0.0, omega) - pole),
        };
    }
    causal.shapes.dot(&states)
}

/// Velocity of the residual terms.
fn terms(
    model: &ModalModel,
    operator: &Operator,
    omega: f64,
    force: &Array1<Complex64>,
) -> Array1<Complex64> {
    let mut moved = Array1::zeros(operator.response_rows.len());
    let terms = &model.residual_terms;
    for term in &terms.terms {
        let factor = omega * (omega / terms.omega_scale_rad_per_s).powi(term.power);
        let field = term.matrix.0.dot(force);
        moved.scaled_add(Complex64::new(0.0, factor), &field);
    }
    moved
}

/// Velocities by an FFT of the signal: every line of it through the mobility.
fn by_fft(exact: &Exact, tracks: &Tracks, signal: Signal) -> Array2<Complex64> {
    let (rows, actuators) = exact.operator.mobility.dim();
    let (forward, back) = (fft::forward(FRAMES), fft::inverse(FRAMES));
    let mut forces = vec![vec![Complex64::ZERO; FRAMES]; actuators];
    let mut sum = vec![Complex64::ZERO; actuators];
    for k in 0..FRAMES {
        let time_s = k as f64 / RATE_HZ;
        tracks.at(time_s, &mut sum);
        for (force, a) in forces.iter_mut().zip(&sum) {
            let carrier = exact.causal.carrier_rad_per_s;
            let turn = Complex64::from_polar(1.0, carrier * time_s);
            force[k] = match signal {
                Signal::Complex => a * turn,
                Signal::Real => (a * turn).re.into(),
            };
        }
    }
    forces.iter_mut().for_each(|force| forward.process(force));
    let mut moved = vec![vec![Complex64::ZERO; FRAMES]; rows];
    let (first, scale) = match signal {
        Signal::Complex => (1 - LINES, 1.0),
        Signal::Real => (1, 2.0),
    };
    for signed in (first..LINES).filter(|&line| line != 0) {
        let line = signed.rem_euclid(FRAMES as i32) as usize;
        let frequency_hz = RATE_HZ * f64::from(signed) / FRAMES as f64;
        let force: Array1<Complex64> = forces.iter().map(|force| force[line]).collect();
        let field = exact.under(TAU * frequency_hz, &force);
        let factor = scale / FRAMES as f64;
        for (moved, v) in moved.iter_mut().zip(&field) {
            moved[line] = v * factor;
        }
    }
    moved.iter_mut().for_each(|row| back.process(row));
    // the line at 0 Hz drives the panel as a whole, from rest at the beginning
    let mean: Array1<Complex64> = forces
        .iter()
        .map(|force| force[0] / FRAMES as f64)
        .collect();
    let gain = exact.acceleration().dot(&mean);
    Array2::from_shape_fn((FRAMES, rows), |(k, row)| {
        moved[row][k] - moved[row][0] + gain[row] * (k as f64 / RATE_HZ)
    })
}

/// The model of a fit: modes above `above_hz` are residual terms.
fn folded(mut model: ModalModel, above_hz: f64) -> ModalModel {
    let scale = model.residual_terms.omega_scale_rad_per_s;
    let (keep, far) = model
        .modes
        .into_iter()
        .partition(|mode| mode.frequency_hz < above_hz);
    model.modes = keep;
    let far: Vec<Mode> = far;
    for power in [0, 2, 4] {
        let mut sum = Array2::zeros((model.responses.len(), model.references.len()));
        for mode in &far {
            let factor =
                (scale / (TAU * mode.frequency_hz)).powi(power) / (TAU * mode.frequency_hz).powi(2);
            for ((i, j), to) in sum.indexed_iter_mut() {
                *to += mode.shape.0[i] * mode.participation.0[j] * factor;
            }
        }
        model.residual_terms.terms.push(ResidualTerm {
            power,
            matrix: ComplexMatrix(sum),
        });
    }
    model
}

/// The difference of an FFT of the real signal through `truth` from envelopes through `model`,
/// over the largest velocity, at the worst place and time.
fn apart(model: &ModalModel, truth: &ModalModel, signal: Signal) -> f64 {
    let [operator, true_operator] =
        [model, truth].map(|model| Operator::of_model(model, 300.0, None).unwrap());
    let causal = CausalModel::new(model, &operator).unwrap();
    let true_causal = CausalModel::new(truth, &true_operator).unwrap();
    let tracks = burst(causal.inputs.ncols());
    let envelopes = Motion::new(&causal).under(&tracks.sampled(1.0 / RATE_HZ, 0, 14_400));
    let exact = by_fft(
        &Exact::new(truth, &true_operator, &true_causal),
        &tracks,
        signal,
    );
    let largest = envelopes.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let of = |((k, row), v): ((usize, usize), &Complex64)| {
        let turn = causal.carrier_rad_per_s * k as f64 / RATE_HZ;
        let apart = v * Complex64::from_polar(1.0, turn) - exact[[k, row]];
        match signal {
            Signal::Complex => apart.norm(),
            Signal::Real => apart.re.abs(),
        }
    };
    envelopes.indexed_iter().map(of).fold(0.0, f64::max) / largest
}

#[test]
fn envelopes_move_the_ground_as_the_real_signal_does() {
    let viscous = ModalModel {
        damping: Damping::Viscous,
        ..panel()
    };
    // without the damping that real powers of ω cannot have
    let mut ringing = panel();
    let above_band = |mode: &&mut Mode| mode.frequency_hz >= 1500.0;
    for mode in ringing.modes.iter_mut().filter(above_band) {
        mode.loss_factor = 0.005;
    }
    // Powers of ω stand for modes above the band. The ground that a signal moves is that of
    // these modes: powers themselves answer the bend at either end of a ramp by an impulse.
    for (name, model, truth) in [
        ("structural", &panel(), &panel()),
        ("viscous", &viscous, &viscous),
        ("powers", &folded(ringing.clone(), 1500.0), &ringing),
    ] {
        for signal in [Signal::Complex, Signal::Real] {
            let apart = apart(model, truth, signal);
            eprintln!("{name}, {signal:?}: {apart:.1e}");
            assert!(apart < 1e-4, "{name}, {signal:?}: {apart:.1e}");
        }
    }
}

#[test]
fn a_plateau_is_what_the_operator_says_whatever_the_blocks() {
    let model = panel();
    let operator = Operator::of_model(&model, 300.0, None).unwrap();
    let causal = CausalModel::new(&model, &operator).unwrap();
    let ramp = |start_s: f64| Ramp {
        start_s,
        duration_s: 0.05,
    };
    let mut tracks = burst(causal.inputs.ncols());
    tracks.tracks[0].envelope = Envelope::Gate {
        rise: Edge::Cosine(ramp(0.0)),
        fall: Edge::Cosine(ramp(9.0)),
    };
    tracks.tracks.truncate(1);
    let steady = operator.mobility.dot(&tracks.tracks[0].pattern);
    let mut motion = Motion::new(&causal);
    let mut last = Array1::zeros(0);
    for block in 0..24 {
        let moved = motion.under(&tracks.sampled(2.5e-4, 500 * block, 500));
        last = moved.row(499).to_owned();
    }
    for (v, steady) in last.iter().zip(&steady) {
        // 0.01 dB
        assert!((v - steady).norm() < 1e-3 * steady.norm(), "{v} {steady}");
    }
    let once = Motion::new(&causal).under(&tracks.sampled(2.5e-4, 0, 1000));
    let mut again = Motion::new(&causal);
    again.under(&tracks.sampled(2.5e-4, 0, 600));
    let rest = again.under(&tracks.sampled(2.5e-4, 600, 400));
    for (a, b) in once.slice(ndarray::s![600.., ..]).iter().zip(&rest) {
        assert!((a - b).norm() <= 1e-12 * a.norm().max(1e-9));
    }
}

#[test]
fn a_step_is_exact_for_forces_that_run_straight() {
    // ż = λz + t from rest: z = (e^{λt} − 1 − λt)/λ²
    for rate in [
        Complex64::new(-3.0, 40.0),
        Complex64::new(-1e-3, 0.0),
        Complex64::new(0.0, 3e-2),
    ] {
        let (h, mut z) = (0.01, Complex64::ZERO);
        let step = Step::new(rate, h);
        for k in 0..50 {
            let t = h * f64::from(k);
            z = step.decay * z + step.last * t + step.next * (t + h);
        }
        let t: f64 = 0.5;
        let expected = (0..20)
            .map(|k| {
                let factorial: f64 = (1..=k + 2).map(f64::from).product();
                rate.powi(k) * t.powi(k + 2) / factorial
            })
            .sum::<Complex64>();
        if rate.norm() < 1.0 {
            assert!(
                (z - expected).norm() < 1e-13 * expected.norm(),
                "{z} {expected}"
            );
        } else {
            let exact = ((rate * t).exp() - 1.0 - rate * t) / (rate * rate);
            assert!((z - exact).norm() < 1e-13, "{z} {exact}");
        }
    }
}

#[test]
fn a_cubic_step_is_exact_for_forces_that_are_cubics() {
    // ż = λz + t³ from rest, in one step or in many
    let h = 0.01;
    for rate in [
        Complex64::new(-3.0, 40.0),
        Complex64::new(-3.0, 400.0),
        Complex64::new(-1e-3, 0.0),
    ] {
        let by = |count: usize| {
            let h = h * 50.0 / count as f64;
            let step = CubicStep::new(rate, h);
            (0..count).fold(Complex64::ZERO, |z, k| {
                let at = |t: f64| [t.powi(3), 3.0 * t * t].map(Complex64::from);
                let [before, rising] = at(h * k as f64);
                let [after, then] = at(h * (k + 1) as f64);
                step.decay * z + step.of(before, rising, after, then)
            })
        };
        let [few, many] = [by(50), by(1000)];
        assert!((few - many).norm() < 1e-11 * many.norm(), "{few} {many}");
    }
}
