//! Mode shapes as maps with contours and nodal lines, Chladni's figures.

use super::plane::{mm, Plane};
use crate::chart::{named, Axis, Chart, ColourBar, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Anchor, Colour, ColourMap, Dash, Image, Stroke};
use crate::sizes;
use crate::surface::{contours, Surface};
use crate::text::fixed;
use chladni_frf::{Dof, ModalModel, Mode, Trust};
use chladni_render::AREA_STEP_M;
use chladni_render::{AreaGrid, Position};
use ndarray::Array2;
use num_complex::Complex64;

/// Levels of the contours on both sides of the nodal line, part of the largest motion.
const CONTOURS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];

/// One figure per mode in the band.
pub(crate) fn mode_shapes(model: &ModalModel) -> Vec<Figure> {
    let shown = shown_responses(&model.responses);
    let plane = Plane::of(model);
    let places: Option<Vec<Position>> = plane.as_ref().and_then(|plane| {
        shown
            .iter()
            .map(|&k| plane.position(&model.nodes, &model.responses[k]))
            .collect()
    });
    let map = plane
        .as_ref()
        .zip(places.as_deref())
        .and_then(|(plane, places)| Map::new(plane, places));
    let modes = model.in_band_modes().take(sizes::MODE_SHAPES).enumerate();
    modes
        .map(|(number, mode)| {
            let (values, imaginary) = turned_real(model, mode, &shown);
            let chart = map.as_ref().map_or_else(
                || shape_list(model, &shown, &values),
                |map| map.chart(&values),
            );
            let doubt = if mode.trust == Trust::Weak {
                ", weak"
            } else {
                ""
            };
            Figure {
                name: format!("mode-{:02}", number + 1),
                title: format!(
                    "Mode {}: {} Hz, η = {} %{doubt}",
                    number + 1,
                    fixed(mode.frequency_hz, 2),
                    fixed(100.0 * mode.loss_factor, 2)
                ),
                caption: caption(mode, imaginary),
                width: sizes::SHAPE_PX,
                charts: vec![chart],
            }
        })
        .collect()
}

fn caption(mode: &Mode, imaginary: f64) -> String {
    let mpc = format!("MPC {}", fixed(mode.mpc, 3));
    // less is not visible
    if imaginary < 0.01 {
        mpc + "."
    } else {
        format!(
            "{mpc}; {} % of the largest motion is out of phase with it.",
            fixed(100.0 * imaginary, 0)
        )
    }
}

/// Indices of the responses along the most frequent axis.
pub(crate) fn shown_responses(responses: &[Dof]) -> Vec<usize> {
    let along = |code: i8| -> Vec<usize> {
        (0..responses.len())
            .filter(|&k| responses[k].direction.axis().code() == code)
            .collect()
    };
    // among equals Z comes before X, and X before Y: `max_by_key` takes the last
    [3, 1, 2, 0, 4, 5, 6]
        .into_iter()
        .map(along)
        .rev()
        .max_by_key(Vec::len)
        .unwrap_or_default()
}

/// The shape at the responses, turned to the phase at which it is most real and scaled to a
/// largest motion of +1.
pub(super) fn turned(model: &ModalModel, mode: &Mode, shown: &[usize]) -> Vec<Complex64> {
    let shape: Vec<Complex64> = shown
        .iter()
        .map(|&k| mode.shape.0[k] * model.responses[k].direction.sign())
        .collect();
    let phase = shape
        .iter()
        .map(|value| value * value)
        .sum::<Complex64>()
        .arg()
        / 2.0;
    let turned: Vec<Complex64> = shape
        .iter()
        .map(|value| value * Complex64::from_polar(1.0, -phase))
        .collect();
    let largest =
        turned
            .iter()
            .map(|value| value.re)
            .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let scale = if largest == 0.0 { 0.0 } else { 1.0 / largest };
    turned.iter().map(|value| value * scale).collect()
}

/// Real parts of [`turned`], and its largest imaginary part.
fn turned_real(model: &ModalModel, mode: &Mode, shown: &[usize]) -> (Vec<f64>, f64) {
    let turned = turned(model, mode, shown);
    (
        turned.iter().map(|value| value.re).collect(),
        turned
            .iter()
            .map(|value| value.im.abs())
            .fold(0.0, f64::max),
    )
}

/// The part that the maps of all modes share: the plane of the responses, and the
/// interpolation between them.
struct Map<'a> {
    plane: Plane,
    places: &'a [Position],
    grid: AreaGrid,
}

impl<'a> Map<'a> {
    /// The maps' plane and grid; `None` where the responses span no area.
    fn new(plane: &Plane, places: &'a [Position]) -> Option<Self> {
        let plane = plane.over(places)?;
        Some(Self {
            grid: AreaGrid::new(places, plane.around, AREA_STEP_M)?,
            plane,
            places,
        })
    }

    fn chart(&self, values: &[f64]) -> Chart {
        let complex: Vec<Complex64> = values.iter().map(|&value| value.into()).collect();
        let fine = Surface::on(&self.grid, &complex).refined(sizes::SHAPE_COLUMNS);
        shape_map(self.plane.chart(300.0), &fine, self.places, values)
    }
}

fn shape_map(mut chart: Chart, fine: &Surface, places: &[Position], values: &[f64]) -> Chart {
    let field = fine.values.mapv(|value| value.re);
    let [x, y] =
        [&fine.x, &fine.y].map(|axis| axis.iter().map(|value| 1e3 * value).collect::<Vec<f64>>());
    chart = chart.with(pixels(&x, &y, &field));
    let level_lines = |sign: f64| {
        CONTOURS
            .iter()
            .flat_map(|&part| contours(&x, &y, &field, sign * part))
            .collect::<Vec<_>>()
    };
    let thin = Stroke::new(Colour::Rgb([40, 40, 44]), 0.7);
    chart = chart.with(Layer::Lines {
        name: None,
        lines: level_lines(1.0),
        stroke: thin,
    });
    chart = chart.with(Layer::Lines {
        name: None,
        lines: level_lines(-1.0),
        stroke: thin.dashed(Dash::Dashed),
    });
    let nodal = Stroke::new(Colour::Rgb([0, 0, 0]), 2.2);
    chart = chart.with(Layer::Lines {
        name: named("nodal line"),
        lines: contours(&x, &y, &field, 0.0),
        stroke: nodal,
    });
    let dots: Vec<Place> = places.iter().map(|&place| mm(place)).collect();
    chart = chart.marks("response", dots, Mark::Dot, Colour::Rgb([70, 70, 76]), 2.6);
    for (sign, text) in [(1.0, "+"), (-1.0, "−")] {
        let extreme =
            (0..values.len()).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b])));
        if let Some(extreme) = extreme.filter(|&k| sign * values[k] > 0.1) {
            let at = mm(places[extreme]);
            chart = chart.with(Layer::Words {
                at,
                text: text.into(),
                anchor: Anchor::Middle,
                bold: true,
            });
        }
    }
    chart.colour_bar = Some(ColourBar {
        axis: Axis::linear("Shape", "largest = 1")
            .range([-1.0, 1.0])
            .step(0.5),
        map: ColourMap::Diverging,
        bands: 0,
        lines: vec![(0.0, nodal)],
    });
    chart
}

fn pixels(x: &[f64], y: &[f64], field: &Array2<f64>) -> Layer {
    let (rows, columns) = field.dim();
    let mut rgba = Vec::with_capacity(4 * rows * columns);
    for value in field.rows().into_iter().rev().flatten() {
        let [r, g, b] = ColourMap::Diverging.at(0.5 + 0.5 * value);
        rgba.extend([r, g, b, if value.is_nan() { 0 } else { 255 }]);
    }
    Layer::Pixels {
        x: whole(x),
        y: whole(y),
        image: Image {
            columns,
            rows,
            rgba,
        },
    }
}

/// Ends of a row of pixels with these centres.
pub(super) fn whole(centres: &[f64]) -> Place {
    let half = (centres[1] - centres[0]) / 2.0;
    [centres[0] - half, centres[centres.len() - 1] + half]
}

/// The shape over the number of the response, for responses that span no area.
fn shape_list(model: &ModalModel, shown: &[usize], values: &[f64]) -> Chart {
    let places: Vec<Place> = values
        .iter()
        .enumerate()
        .map(|(k, &value)| [k as f64 + 1.0, value])
        .collect();
    let names = shown
        .iter()
        .enumerate()
        .map(|(k, &i)| (k as f64 + 1.0, model.responses[i].to_string()))
        .collect();
    let x = Axis::linear("Response", "DOF")
        .range([0.0, values.len() as f64 + 1.0])
        .names(names);
    let y = Axis::linear("Shape", "largest = 1")
        .range([-1.1, 1.1])
        .step(0.5);
    let stroke = Stroke::new(Colour::Series(0), 1.4);
    Chart::new(x, y)
        .height(Height::Px(190.0))
        .line("", places.clone(), stroke)
        .marks("", places, Mark::Dot, Colour::Series(0), 5.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_turned_real_with_their_largest_motion_up() {
        let sim = chladni_plate::simulate(
            &chladni_plate::Panel::from_toml("[frf]\nstop_hz = 120\n", 1 << 30).unwrap(),
            None,
            None,
        )
        .unwrap();
        let mut mode = sim.truth.modes[0].clone();
        mode.shape
            .0
            .iter_mut()
            .for_each(|value| *value *= Complex64::from_polar(3.0, 2.0));
        let shown = shown_responses(&sim.truth.responses);
        let (values, imaginary) = turned_real(&sim.truth, &mode, &shown);
        assert!(imaginary < 1e-12);
        assert!((values.iter().copied().fold(f64::MIN, f64::max) - 1.0).abs() < 1e-12);
    }
}
