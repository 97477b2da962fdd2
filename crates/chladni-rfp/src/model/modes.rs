//! Modes of the model, scaled and in SI units.

use crate::data::layout::DataLayout;
use crate::model::limits;
use crate::poles::pole::Pole;
use crate::shapes::error_bars::ShapeBars;
use crate::shapes::low_rank::Shapes;
use crate::shapes::scale::Scale;
use crate::validation::complexity::mpc;
use chladni_frf::{
    driving_points, ComplexVector, Damping, DrivingPoint, Finding, Mode, ReferenceUnit, Scaling,
    Trust,
};
use ndarray::Array1;
use num_complex::Complex64;
use std::f64::consts::FRAC_PI_2;

/// Factor from a participation in work units to one in SI units of receptance residues.
fn si_factor(data: &DataLayout, damping: Damping, pole: &Pole) -> Complex64 {
    let size = data.rms * data.omega_max.powi(2 - data.kind.omega_power());
    size * pole.residue_unit(damping)
}

/// Shape and participations of one term with the weights of FRFs undone.
fn unweighted(
    data: &DataLayout,
    shapes: &Shapes,
    n: usize,
) -> (Array1<Complex64>, Array1<Complex64>) {
    let (shape, participation) = (shapes.shape.row(n), shapes.participation.row(n));
    let of_response = |i| shape[i] / data.weight(i, 0)[0];
    let of_reference = |j| participation[j] / data.weight(0, j)[1];
    (
        Array1::from_shape_fn(shape.len(), of_response),
        Array1::from_shape_fn(participation.len(), of_reference),
    )
}

/// Scale of each shape: unit modal mass if the set has driving points and forces, else one at the
/// largest response.
pub(crate) fn scales(
    data: &DataLayout,
    damping: Damping,
    poles: &[Pole],
    shapes: &Shapes,
) -> (Vec<Scale>, Scaling) {
    let driving = driving_points(&data.responses, &data.references);
    let has_mass_scale = !driving.is_empty() && data.reference_unit == ReferenceUnit::Newton;
    let of_term = |n: usize| {
        let (shape, participation) = unweighted(data, shapes, n);
        let scale = match has_mass_scale {
            true => {
                let si = si_factor(data, damping, &poles[shapes.owner[n]]);
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
    let scaling = match has_mass_scale {
        true => Scaling::UnitModalMass,
        false => Scaling::Unscaled,
    };
    ((0..shapes.owner.len()).map(of_term).collect(), scaling)
}

/// The scale of unit modal mass; `None` if the mode does not move at driving points.
///
/// * `si`: factor from the participation to SI units
fn of_unit_mass(
    data: &DataLayout,
    driving: &[DrivingPoint],
    shape: &Array1<Complex64>,
    participation: &Array1<Complex64>,
    si: Complex64,
) -> Option<Scale> {
    // t² = Σ sign·conj(s)·L / Σ|s|² makes shape·t and participation/t agree at the
    // driving points
    let product = |point: &DrivingPoint| {
        shape[point.response].conj() * participation[point.reference] * si * point.sign
    };
    let products: Complex64 = driving.iter().map(product).sum();
    let square = |point: &DrivingPoint| shape[point.response].norm_sqr();
    let squares: f64 = driving.iter().map(square).sum();
    let factor = (products / squares).sqrt();
    let of_response = |point: &DrivingPoint| {
        let i = point.response;
        let weight = data.weight(i, 0)[0];
        (i, -0.5 * shape[i].conj() / (squares * weight))
    };
    let of_reference = |point: &DrivingPoint| {
        let weight = data.weight(0, point.reference)[1];
        let over = 2.0 * squares * factor * factor * weight;
        let value = point.sign * shape[point.response].conj() * si / over;
        (point.reference, value)
    };
    (squares > 0.0 && factor.norm() > 0.0).then(|| Scale {
        factor,
        response: driving.iter().map(of_response).collect(),
        reference: driving.iter().map(of_reference).collect(),
    })
}

/// The scale of one at the largest response; `None` if no response moves.
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
            let si = si_factor(data, damping, pole);
            let (shape, participation) = unweighted(data, shapes, n);
            let shape: Vec<Complex64> = shape.iter().map(|v| v * factor).collect();
            let participation = participation.iter().map(|v| v * si / factor).collect();
            // an unknown error bar is stated as the size of the shape
            let largest = shape.iter().map(|v| v.norm()).fold(0.0, f64::max);
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

/// Widens the error bars of a mass-scaled shape by a doubt about its scale. The error bar of the scale
/// widens by the same variance, in the mean over the shape, so that the errors of the shape beside
/// its scale stay.
///
/// * `widened`: the new error bar of a value, from the old one and the size of the value
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
/// mass-normalised shapes of the band, less the part that their error bars explain. A sensor with
/// the wrong sign turns shapes by 90 degrees and changes no size, so angles are taken from the
/// nearer axis.
pub(crate) fn scale_error_by_turns(modes: &[Mode]) -> f64 {
    let excess_square = |mode: &Mode| -> Option<f64> {
        let known = mode.scale_std.filter(|std| *std < limits::SCALE_TELLS)?;
        let squares: Complex64 = mode.shape.0.iter().map(|v| v * v).sum();
        let angle = 0.5 * squares.arg().abs();
        let square = angle.min(FRAC_PI_2 - angle).powi(2) - 0.5 * known.powi(2);
        mode.in_band.then_some(square.max(0.0))
    };
    let squares: Vec<f64> = modes.iter().filter_map(excess_square).collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    (2.0 * mean).sqrt()
}

/// The finding that shapes have no absolute scale.
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

/// The finding that the band has no mode, or no sure one.
pub(crate) fn no_sure_mode(modes: &[Mode]) -> Option<Finding> {
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

/// The finding of modes of the band whose driving points do not determine their scale.
pub(crate) fn scale_unknown<'a>(
    data: &DataLayout,
    poles: impl Iterator<Item = &'a Pole>,
) -> Option<Finding> {
    let hz = data.hz();
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

/// A rejected pole as models list it: its shape is zero, so that it takes no part in the synthesis.
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

/// A pole in Hz with its shape. An unknown standard deviation is stated as the width of the
/// band, for JSON has no infinity and readers expect a number.
fn mode(
    data: &DataLayout,
    pole: &Pole,
    shape: ComplexVector,
    shape_std: Vec<f64>,
    participation: ComplexVector,
) -> Mode {
    let hz = data.hz();
    let frequency_hz = pole.omega * hz;
    let width_hz = data.band_hz[1] - data.band_hz[0];
    Mode {
        frequency_hz,
        frequency_std_hz: (pole.omega_std * hz).min(width_hz),
        loss_factor: pole.loss_factor,
        loss_factor_std: pole.loss_factor_std.min(limits::LOSS_FACTOR_UNKNOWN),
        damping_ratio: 0.5 * pole.loss_factor,
        in_band: (data.band_hz[0]..=data.band_hz[1]).contains(&frequency_hz),
        trust: pole.grade.trust,
        reasons: pole.grade.reasons.clone().into(),
        mpc: mpc(&shape.0),
        shape,
        shape_std,
        scale_std: None,
        participation,
    }
}
