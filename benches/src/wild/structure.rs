//! The modes of a drawn structure, in the band and beyond both its ends, as a model.

use super::draw::{Difficulty, Draw};
use super::random::Random;
use chladni_frf::{
    ComplexMatrix, ComplexVector, Direction, Dof, ModalModel, Mode, Quality, ReferenceUnit,
    ResidualTerm, ResidualTerms, Scaling, Trust, CREATED_BY, MODEL_FORMAT,
};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Streams of random numbers.
const POLES: u64 = 2;
const SHAPES: u64 = 3;

/// Least participation of a mode in its best reference in calm draws, over the usual one:
/// a mode that no reference drives is not measured.
const DRIVEN: f64 = 0.7;
/// Chance that a mode of a hard draw lies as close to its neighbour as is drawn.
const CROWDED: f64 = 0.25;
/// Distances of modes beyond the upper end grow by this factor.
const FARTHER: f64 = 1.2;
/// Rigid-body motion at the lower end over the peak of a mode.
const RIGID_BODY: f64 = 0.3;
/// First label of references that are no responses.
const FIRST_REFERENCE: u64 = 10_001;

/// Natural frequency, loss factor and wished peak of a mode.
struct Resonance {
    frequency_hz: f64,
    loss_factor: f64,
    peak: f64,
}

/// The structure as a model, and the lines that it is measured on.
pub(super) fn structure(draw: &Draw) -> (ModalModel, Array1<f64>) {
    let (inside, band_hz) = inside(draw);
    let outside = outside(draw, band_hz);
    let mut shapes = Random::new(draw.seed, SHAPES);
    let mut modes: Vec<Mode> = inside
        .iter()
        .chain(&outside)
        .map(|resonance| mode(draw, resonance, band_hz, &mut shapes))
        .collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let terms = if draw.rigid_body {
        vec![rigid_body(draw, band_hz, &mut shapes)]
    } else {
        Vec::new()
    };
    (model(draw, modes, terms, band_hz), axis(draw, band_hz))
}

/// Modes of the band, and the band around them.
fn inside(draw: &Draw) -> (Vec<Resonance>, [f64; 2]) {
    let mut random = Random::new(draw.seed, POLES);
    let spacing_hz = draw.spacing_hz();
    let low_hz = draw.middle_hz - 0.5 * spacing_hz * (draw.modes + 1) as f64;
    let end = |random: &mut Random| spacing_hz * random.even([0.5, 1.0]);
    let mut frequency_hz = low_hz + end(&mut random);
    let mut modes: Vec<Resonance> = Vec::new();
    for n in 0..draw.modes {
        if n > 0 {
            let least_hz = draw.least_spacing * draw.loss_factor * frequency_hz;
            let crowded = draw.difficulty == Difficulty::Hard && random.chance(CROWDED);
            let usual_hz = spacing_hz * random.even([0.2, 1.8]);
            frequency_hz += if crowded {
                least_hz
            } else {
                usual_hz.max(least_hz)
            };
        }
        modes.push(Resonance {
            frequency_hz,
            loss_factor: loss_factor(draw, &mut random),
            peak: random.spread([1.0 / draw.uneven_modes, 1.0]),
        });
    }
    let high_hz = frequency_hz + end(&mut random);
    (modes, [low_hz, high_hz])
}

/// Modes below the band and above it.
fn outside(draw: &Draw, [low_hz, high_hz]: [f64; 2]) -> Vec<Resonance> {
    let mut random = Random::new(draw.seed, POLES + 100);
    let spacing_hz = draw.spacing_hz();
    let mut modes = Vec::new();
    let mut add = |frequency_hz: f64, nearest: bool, random: &mut Random| {
        let weight = if nearest { draw.outside_weight } else { 1.0 };
        modes.push(Resonance {
            frequency_hz,
            loss_factor: loss_factor(draw, random),
            peak: weight * random.spread([1.0 / draw.uneven_modes, 1.0]),
        });
    };
    let mut below_hz = low_hz - draw.outside_distance * spacing_hz;
    for n in 0..draw.outside[0] {
        let frequency_hz = if below_hz > 0.05 * low_hz {
            below_hz
        } else {
            low_hz * random.spread([0.02, 0.9])
        };
        add(frequency_hz, n == 0, &mut random);
        below_hz -= spacing_hz * random.even([0.3, 1.7]);
    }
    let mut gap_hz = draw.outside_distance * spacing_hz;
    let mut above_hz = high_hz;
    for n in 0..draw.outside[1] {
        above_hz += gap_hz;
        add(above_hz, n == 0, &mut random);
        gap_hz = spacing_hz * random.even([0.3, 1.7]) * FARTHER.powi(n as i32);
    }
    modes
}

fn loss_factor(draw: &Draw, random: &mut Random) -> f64 {
    draw.loss_factor * random.spread([1.0 / draw.loss_spread, draw.loss_spread])
}

/// Lines from end to end of the band, the spacing even or growing.
fn axis(draw: &Draw, [low_hz, high_hz]: [f64; 2]) -> Array1<f64> {
    let width_hz = high_hz - low_hz;
    let lines = (width_hz / draw.bandwidth_hz() * draw.lines_per_bandwidth).ceil() as usize;
    // the slope of u + s·u(u − 1) grows by the factor asked for
    let slope = (draw.uneven_axis - 1.0) / (draw.uneven_axis + 1.0);
    (0..=lines)
        .map(|k| k as f64 / lines as f64)
        .map(|u| low_hz + width_hz * (u + slope * u * (u - 1.0)))
        .collect()
}

/// Shape and participation of a mode, scaled to its peak.
fn mode(draw: &Draw, resonance: &Resonance, band_hz: [f64; 2], random: &mut Random) -> Mode {
    let &Resonance {
        frequency_hz,
        loss_factor,
        peak,
    } = resonance;
    let mut entries = |count: usize| -> Vec<Complex64> {
        let entry = |_| Complex64::new(random.normal(), draw.complexity * random.normal());
        (0..count).map(entry).collect()
    };
    let mut shape = entries(draw.responses);
    let mut participation = match draw.driving_points {
        true => shape[..draw.references].to_vec(),
        false => entries(draw.references),
    };
    let strongest = participation.iter().map(|v| v.norm()).fold(0.0, f64::max);
    if draw.difficulty == Difficulty::Calm && strongest < DRIVEN {
        let factor = DRIVEN / strongest.max(1e-3);
        participation.iter_mut().for_each(|v| *v *= factor);
        let own = if draw.driving_points {
            draw.references
        } else {
            0
        };
        shape[..own].copy_from_slice(&participation[..own]);
    }
    let rms = |values: &[Complex64]| {
        (values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64).sqrt()
    };
    let omega = TAU * frequency_hz;
    let resonance = draw.kind.from_receptance(omega).norm() / (omega * omega * loss_factor);
    let scale = (peak / (resonance * rms(&shape) * rms(&participation))).sqrt();
    shape.iter_mut().for_each(|v| *v *= scale);
    participation.iter_mut().for_each(|v| *v *= scale);
    Mode {
        frequency_hz,
        frequency_std_hz: 0.0,
        loss_factor,
        loss_factor_std: 0.0,
        damping_ratio: 0.5 * loss_factor,
        in_band: band_hz[0] <= frequency_hz && frequency_hz <= band_hz[1],
        trust: Trust::Sure,
        reasons: Default::default(),
        mpc: chladni_rfp::mpc(&shape),
        shape_std: vec![0.0; shape.len()],
        scale_std: None,
        shape: ComplexVector(shape),
        participation: ComplexVector(participation),
    }
}

/// −ψφᵀ/ω², receptance of a free body.
fn rigid_body(draw: &Draw, [low_hz, _]: [f64; 2], random: &mut Random) -> ResidualTerm {
    let size = RIGID_BODY / draw.kind.from_receptance(TAU * low_hz).norm();
    let mut draws = |count: usize| -> Vec<f64> { (0..count).map(|_| random.normal()).collect() };
    let (own, other) = (draws(draw.responses), draws(draw.references));
    let entry = |(i, j): (usize, usize)| Complex64::new(-size * own[i] * other[j], 0.0);
    let dim = (draw.responses, draw.references);
    ResidualTerm {
        power: -2,
        matrix: ComplexMatrix(Array2::from_shape_fn(dim, entry)),
    }
}

fn model(draw: &Draw, modes: Vec<Mode>, terms: Vec<ResidualTerm>, band_hz: [f64; 2]) -> ModalModel {
    let dof = |label: u64| Dof::new(label, Direction::PLUS_Z);
    let first = if draw.driving_points {
        1
    } else {
        FIRST_REFERENCE
    };
    ModalModel {
        format: MODEL_FORMAT.into(),
        version: 1,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: Default::default(),
        frf_kind: draw.kind,
        reference_unit: ReferenceUnit::Newton,
        band_hz,
        damping: draw.law,
        scaling: match draw.driving_points {
            true => Scaling::UnitModalMass,
            false => Scaling::Unscaled,
        },
        responses: (1..=draw.responses as u64).map(dof).collect(),
        references: (first..).take(draw.references).map(dof).collect(),
        nodes: Vec::new(),
        lines: Vec::new(),
        faces: Vec::new(),
        method: "drawn".into(),
        modes,
        residual_terms: ResidualTerms {
            omega_scale_rad_per_s: TAU * band_hz[0],
            terms,
        },
        quality: Quality {
            relative_error: 0.0,
            chi2_per_dof: 1.0,
            trusted: true,
            findings: Vec::new(),
            path: None,
        },
    }
}
