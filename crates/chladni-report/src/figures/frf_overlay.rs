//! Measured FRFs overlaid with their synthesis.

use super::{level, natural_frequencies};
use crate::chart::{named, Axis, Chart, Figure, Height, Layer, Place};
use crate::comparison::{Comparison, Pair, Sums};
use crate::drawing::{Colour, Dash, Stroke};
use crate::sizes;
use num_complex::Complex64;

fn measured_stroke() -> Stroke {
    Stroke::new(Colour::Muted, 2.6)
}

fn synthesis_stroke() -> Stroke {
    Stroke::new(Colour::Series(1), 1.3)
}

/// Amplitude and phase of a pair of DOFs; `number` is that of the figure.
pub(crate) fn frf_overlay(comparison: &Comparison, pair: &Pair, number: usize) -> Figure {
    let [measured, synthesis] = comparison.curves(pair);
    let levels = |curve: &Option<Vec<Complex64>>| {
        curve
            .as_ref()
            .map(|values| values.iter().map(|v| level(v.norm())).collect())
    };
    let residual = measured
        .as_ref()
        .zip(synthesis.as_ref())
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect());
    let amplitude = amplitude_chart(
        comparison,
        [levels(&measured), levels(&synthesis), levels(&residual)],
    )
    .height(Height::Px(250.0));

    let mut phase = Chart::new(
        frequency_axis(comparison),
        Axis::linear("Phase", "degrees")
            .range([-180.0, 180.0])
            .step(90.0),
    );
    phase = phase.height(Height::Px(120.0));
    for (curve, stroke) in [
        (&measured, Stroke::new(Colour::Muted, 2.0)),
        (&synthesis, synthesis_stroke()),
    ] {
        if let Some(values) = curve {
            let lines = wrapped(&comparison.frequency_hz.to_vec(), values);
            phase = phase.with(Layer::Lines {
                name: None,
                lines,
                stroke,
            });
        }
    }
    Figure {
        name: format!("frf-{number:02}"),
        title: format!(
            "{} of response / reference {} ({})",
            comparison.quantity.name(),
            pair.label,
            pair.why
        ),
        caption: String::new(),
        width: sizes::WIDE_PX,
        charts: vec![amplitude, phase],
    }
}

/// Root mean square over all FRFs, measured, synthesised and of the residual.
pub(crate) fn frf_sum(comparison: &Comparison, sums: &Sums) -> Figure {
    let levels = |curve: &Option<Vec<f64>>| {
        curve
            .as_ref()
            .map(|values| values.iter().map(|&v| level(v)).collect())
    };
    let curves = [&sums.measured, &sums.synthesis, &sums.difference].map(levels);
    let chart = amplitude_chart(comparison, curves).height(Height::Px(300.0));
    Figure {
        name: "frf-sum".into(),
        title: format!(
            "{}, root mean square over all FRFs",
            comparison.quantity.name()
        ),
        caption: match (&sums.measured, &sums.synthesis) {
            (Some(_), Some(_)) => {
                "Where the residual is flat and shapeless it is noise; peaks in it are motion that \
                 the model lacks."
                    .into()
            }
            (None, Some(_)) => "Synthesis alone: the measured FRFs are not at hand.".into(),
            _ => "Measured FRFs alone: there is no model.".into(),
        },
        width: sizes::WIDE_PX,
        charts: vec![chart],
    }
}

pub(super) fn frequency_axis(comparison: &Comparison) -> Axis {
    let (first, last) = (
        comparison.frequency_hz.first().copied(),
        comparison.frequency_hz.last().copied(),
    );
    match (first, last) {
        (Some(first), Some(last)) if first < last => {
            Axis::linear("Frequency", "Hz").range([first, last])
        }
        _ => Axis::linear("Frequency", "Hz"),
    }
}

/// Levels over frequency with the natural frequencies and the borders of the fitted band.
fn amplitude_chart(
    comparison: &Comparison,
    [measured, synthesis, residual]: [Option<Vec<f64>>; 3],
) -> Chart {
    let curves = [
        ("measured", measured, measured_stroke()),
        ("synthesis of the model", synthesis, synthesis_stroke()),
        (
            "residual",
            residual,
            Stroke::new(Colour::Series(0), 1.2).dashed(Dash::Dashed),
        ),
    ];
    let highest = curves
        .iter()
        .filter_map(|curve| curve.1.as_ref())
        .flatten()
        .copied()
        .fold(f64::NAN, f64::max);
    let lowest = curves
        .iter()
        .filter_map(|curve| curve.1.as_ref())
        .flatten()
        .copied()
        .fold(f64::NAN, f64::min);
    let mut axis = Axis::linear(
        comparison.quantity.name(),
        &comparison.quantity.level_unit(),
    )
    .padded(0.05);
    if highest.is_finite() && lowest.is_finite() {
        axis = axis.range([
            lowest.max(highest - sizes::AMPLITUDE_RANGE_DB) - 3.0,
            highest + 5.0,
        ]);
    }
    let mut chart = Chart::new(frequency_axis(comparison), axis);
    chart = chart.with(pole_lines(&natural_frequencies(comparison.model)));
    if let Some(band) = band_lines(comparison) {
        chart = chart.with(band);
    }
    for (name, values, stroke) in curves {
        if let Some(values) = values {
            let points: Vec<Place> = comparison
                .frequency_hz
                .iter()
                .zip(values)
                .map(|(&f, v)| [f, v])
                .collect();
            chart = chart.line(name, points, stroke);
        }
    }
    chart
}

/// A line at every natural frequency.
pub(super) fn pole_lines(frequencies: &[f64]) -> Layer {
    let name = if frequencies.is_empty() {
        ""
    } else {
        "natural frequency"
    };
    Layer::Verticals {
        name: named(name),
        at: frequencies.to_vec(),
        stroke: Stroke::new(Colour::Series(2), 1.0).dashed(Dash::Dotted),
    }
}

/// The borders of the fitted band that lie inside the data; `None` without any.
pub(super) fn band_lines(comparison: &Comparison) -> Option<Layer> {
    let model = comparison.model?;
    let (first, last) = (
        comparison.frequency_hz.first()?,
        comparison.frequency_hz.last()?,
    );
    let at: Vec<f64> = model
        .band_hz
        .into_iter()
        .filter(|f| f > first && f < last)
        .collect();
    let stroke = Stroke::new(Colour::Ink, 1.2).dashed(Dash::Dashed);
    (!at.is_empty()).then(|| Layer::Verticals {
        name: named("border of the fitted band"),
        at,
        stroke,
    })
}

/// Phases in degrees, broken where they pass ±180°.
fn wrapped(frequency_hz: &[f64], values: &[Complex64]) -> Vec<Vec<Place>> {
    let mut lines: Vec<Vec<Place>> = vec![Vec::new()];
    for (&f, value) in frequency_hz.iter().zip(values) {
        let phase = value.arg().to_degrees();
        let line = lines.last_mut().expect("there is always a line");
        let jumps = line
            .last()
            .is_some_and(|last| (last[1] - phase).abs() > 180.0);
        if jumps {
            lines.push(vec![[f, phase]]);
        } else {
            line.push([f, phase]);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_broken_where_they_wrap() {
        let values: Vec<Complex64> = [170.0f64, 179.0, -179.0, -170.0]
            .iter()
            .map(|d| Complex64::from_polar(1.0, d.to_radians()))
            .collect();
        let lines = wrapped(&[1.0, 2.0, 3.0, 4.0], &values);
        assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
    }
}
