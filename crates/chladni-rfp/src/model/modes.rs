//! Modes in SI units, scaled.

use crate::data::layout::DataLayout;
use crate::model::limits;
use crate::poles::pole::Pole;
use crate::shapes::error_bars::ShapeBars;
use crate::shapes::low_rank::Shapes;
use crate::shapes::scale::Scale;
use crate::validation::complexity::mpc;
use chladni_frf::{ComplexVector, Damping, Finding, Mode, ReferenceUnit, Scaling, Trust};
use ndarray::Array1;
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Factor that takes a participation in work units to SI units of receptance residues.
fn to_si(data: &DataLayout, damping: Damping, pole: &Pole) -> Complex64 {
    // R = ω_max²(λ − x) × receptance
    let size = data.rms * data.omega_max.powi(2 - data.kind.omega_power());
    size * pole.residue_unit(damping)
}

/// Shape and participations of one term as the measured FRFs have them, weights undone.
fn measured(
    data: &DataLayout,
    shapes: &Shapes,
    n: usize,
) -> (Array1<Complex64>, Array1<Complex64>) {
    let (shape, participation) = (shapes.shape.row(n), shapes.participation.row(n));
    let of_responses = Array1::from_shape_fn(shape.len(), |i| shape[i] / data.weight(i, 0)[0]);
    (
        of_responses,
        Array1::from_shape_fn(participation.len(), |j| {
            participation[j] / data.weight(0, j)[1]
        }),
    )
}

/// Response index, reference index, and the sign between their directions.
type DrivingPoint = (usize, usize, f64);

/// Scale of the shapes: of unit modal mass where the set has driving points and forces,
/// one at the largest response otherwise.
pub(crate) fn scales(
    data: &DataLayout,
    damping: Damping,
    poles: &[Pole],
    shapes: &Shapes,
) -> (Vec<Scale>, Scaling) {
    let references = || data.references.iter().enumerate();
    let driving: Vec<DrivingPoint> = data
        .responses
        .iter()
        .enumerate()
        .flat_map(|(i, r)| {
            references()
                .filter(move |(_, f)| r.same_axis(**f))
                .map(move |(j, f)| (i, j, r.direction.sign() * f.direction.sign()))
        })
        .collect();
    let massed = !driving.is_empty() && data.reference_unit == ReferenceUnit::Newton;
    let of_term = |n: usize| {
        let (shape, participation) = measured(data, shapes, n);
        let scale = match massed {
            true => {
                let si = to_si(data, damping, &poles[shapes.owner[n]]);
                of_unit_mass(data, &driving, &shape, &participation, si)
            }
            false => of_unit_largest(data, &shape),
        };
        scale.unwrap_or_else(|| Scale {
            factor: Complex64::new(1.0, 0.0),
            response: Vec::new(),
            reference: Vec::new(),
        })
    };
    (
        (0..shapes.owner.len()).map(of_term).collect(),
        if massed {
            Scaling::UnitModalMass
        } else {
            Scaling::Unscaled
        },
    )
}

/// The scale of unit modal mass; `None` where the mode does not move at driving points.
/// `si`: what takes the participation to SI units.
fn of_unit_mass(
    data: &DataLayout,
    driving: &[DrivingPoint],
    shape: &Array1<Complex64>,
    participation: &Array1<Complex64>,
    si: Complex64,
) -> Option<Scale> {
    // t² = Σ sign·conj(s)·L / Σ|s|² makes shape·t and participation/t agree at the
    // driving points
    let up: Complex64 = driving
        .iter()
        .map(|&(i, j, sign)| shape[i].conj() * participation[j] * si * sign)
        .sum();
    let down: f64 = driving.iter().map(|&(i, _, _)| shape[i].norm_sqr()).sum();
    let factor = (up / down).sqrt();
    let of_response =
        |&(i, _, _): &DrivingPoint| (i, -0.5 * shape[i].conj() / (down * data.weight(i, 0)[0]));
    let of_reference = |&(i, j, sign): &DrivingPoint| {
        let over = 2.0 * down * factor * factor * data.weight(0, j)[1];
        (j, sign * shape[i].conj() * si / over)
    };
    (down > 0.0 && factor.norm() > 0.0).then(|| Scale {
        factor,
        response: driving.iter().map(of_response).collect(),
        reference: driving.iter().map(of_reference).collect(),
    })
}

/// The scale of one at the largest response; `None` where no response moves.
fn of_unit_largest(data: &DataLayout, shape: &Array1<Complex64>) -> Option<Scale> {
    let (i, &largest) = shape
        .indexed_iter()
        .max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))?;
    (largest.norm() > 0.0).then(|| Scale {
        factor: largest.inv(),
        response: vec![(i, -largest.inv() / data.weight(i, 0)[0])],
        reference: Vec::new(),
    })
}

/// Modes in SI units with the error `bars` of their terms.
pub(crate) fn modes(
    data: &DataLayout,
    damping: Damping,
    poles: &[Pole],
    shapes: &Shapes,
    scales: &[Scale],
    bars: &ShapeBars,
) -> Vec<Mode> {
    (0..shapes.owner.len())
        .map(|n| {
            let pole = &poles[shapes.owner[n]];
            let factor = scales[n].factor;
            let si = to_si(data, damping, pole);
            let (shape, participation) = measured(data, shapes, n);
            let shape: Vec<Complex64> = shape.iter().map(|v| v * factor).collect();
            let participation = participation.iter().map(|v| v * si / factor).collect();
            // a shape that is not known may be anything of its own size
            let largest = norm_of_largest(&shape);
            let deviation = |(i, v): (usize, &f64)| {
                if v.is_finite() {
                    v / data.weight(i, 0)[0]
                } else {
                    largest
                }
            };
            let deviation = bars
                .shape
                .row(n)
                .iter()
                .enumerate()
                .map(deviation)
                .collect();
            let scale_std = scales[n].stated(bars.scale[n]);
            Mode {
                scale_std,
                ..mode(
                    data,
                    pole,
                    ComplexVector(shape),
                    deviation,
                    ComplexVector(participation),
                )
            }
        })
        .collect()
}

/// Widens the bars of a mass-scaled shape by a doubt of its scale; `widened`: by bar and size of
/// a value. The bar of the scale takes what is added, in the mean over the shape, so that what is
/// known of a shape beside its scale stays.
pub(crate) fn widen_scale(mode: &mut Mode, widened: impl Fn(f64, f64) -> f64) {
    let (mut added, mut power) = (0.0, 0.0);
    for (value, std) in mode.shape.0.iter().zip(&mut mode.shape_std) {
        let before = *std;
        *std = widened(before, value.norm());
        if std.is_finite() {
            added += std.powi(2) - before.powi(2);
            power += value.norm_sqr();
        }
    }
    if power > 0.0 {
        let wider = |std: f64| (std.powi(2) + added / power).sqrt();
        mode.scale_std = mode.scale_std.map(wider);
    }
}

/// Relative error of the scale that turned phases suggest: √2 times the rms angle of the
/// mass-normalised shapes of the band, without what their error bars explain. A sensor that
/// is turned round turns shapes by 90 degrees and changes no size.
pub(crate) fn turned(modes: &[Mode]) -> f64 {
    let angle = |mode: &Mode| -> Option<f64> {
        let known = mode.scale_std.filter(|std| *std < limits::SCALE_TELLS)?;
        let squares: Complex64 = mode.shape.0.iter().map(|v| v * v).sum();
        let angle = 0.5 * squares.arg().abs();
        let square = angle.min(FRAC_PI_2 - angle).powi(2) - 0.5 * known.powi(2);
        mode.in_band.then_some(square.max(0.0))
    };
    let squares: Vec<f64> = modes.iter().filter_map(angle).collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    (2.0 * mean).sqrt()
}

/// The reason that shapes have no absolute scale.
pub(crate) fn unscaled(unit: ReferenceUnit) -> Finding {
    match unit {
        ReferenceUnit::Volt => Finding::note(
            "unscaled",
            "shapes are not mass-scaled: the references are voltages",
        ),
        ReferenceUnit::Newton => Finding::note(
            "unscaled",
            "shapes are not mass-scaled: no driving point was measured (a response at a \
             reference); frequencies, damping and rendering do not need one",
        )
        .help("for modal masses, measure at one driver at least"),
    }
}

/// The finding of a band without a mode, or without a sure one.
pub(crate) fn few_modes(modes: &[Mode]) -> Option<Finding> {
    let mut inside = modes.iter().filter(|mode| mode.counts()).peekable();
    if inside.peek().is_none() {
        return Some(
            Finding::fault("no-mode", "no mode stands out of the noise in this band")
                .help("look at the FRFs, and fit a band with visible peaks"),
        );
    }
    (!inside.any(|m| m.trust == Trust::Sure)).then(|| {
        Finding::fault("none-sure", "no mode is sure").help("see the reasons given with each mode")
    })
}

/// Modes of the band whose driving points say nothing of their scale.
pub(crate) fn scale_unknown<'a>(
    data: &DataLayout,
    poles: impl Iterator<Item = &'a Pole>,
) -> Option<Finding> {
    let hz = data.omega_max / TAU;
    let inside = poles
        .map(|pole| pole.omega * hz)
        .filter(|f| (data.band_hz[0]..=data.band_hz[1]).contains(f));
    let places: Vec<f64> = inside.collect();
    let named: Vec<String> = places.iter().map(|f| format!("{f:.1}")).collect();
    (!places.is_empty()).then(|| {
        Finding::caution(
            "scale-unknown",
            format!(
                "the driving point lies near a node of the modes at {} Hz: their scale to unit \
                 modal mass is not known, their shapes hold up to a factor",
                named.join(", ")
            ),
        )
        .modes_hz(places)
        .help("measure a driving point where these modes move")
    })
}

/// A rejected pole as it is listed: no shape, no part in the synthesis.
pub(crate) fn rejected_mode(data: &DataLayout, pole: &Pole) -> Mode {
    let zeros = |count| ComplexVector(vec![Complex64::default(); count]);
    let (responses, references) = (data.responses.len(), data.references.len());
    mode(
        data,
        pole,
        zeros(responses),
        vec![0.0; responses],
        zeros(references),
    )
}

fn norm_of_largest(shape: &[Complex64]) -> f64 {
    shape.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// A pole in Hz with its shape. An unknown standard deviation is stated as the width of the
/// band. (JSON has no infinity, and readers expect a number.)
fn mode(
    data: &DataLayout,
    pole: &Pole,
    shape: ComplexVector,
    shape_std: Vec<f64>,
    participation: ComplexVector,
) -> Mode {
    let hz = data.omega_max / TAU;
    let frequency_hz = pole.omega * hz;
    let width_hz = data.band_hz[1] - data.band_hz[0];
    Mode {
        frequency_hz,
        frequency_std_hz: (pole.omega_std * hz).min(width_hz),
        loss_factor: pole.loss_factor,
        loss_factor_std: pole.loss_factor_std.min(limits::LOSS_FACTOR_UNKNOWN),
        damping_ratio: 0.5 * pole.loss_factor,
        in_band: frequency_hz >= data.band_hz[0] && frequency_hz <= data.band_hz[1],
        trust: pole.grade.trust,
        reasons: pole.grade.reasons.clone().into(),
        mpc: mpc(&shape.0),
        shape,
        shape_std,
        scale_std: None,
        participation,
    }
}
