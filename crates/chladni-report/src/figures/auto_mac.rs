//! AutoMAC: the MAC of every shape with every other.

use crate::chart::{Axis, Cell, Chart, ColourBar, Figure, Height, Layer};
use crate::drawing::ColourMap;
use crate::sizes;
use crate::text::fixed;
use chladni_frf::{ModalModel, Mode};
use num_complex::Complex64;

/// The MAC matrix of the shapes; `None` without modes in the band.
pub(crate) fn auto_mac(model: &ModalModel) -> Option<Figure> {
    let modes: Vec<&Mode> = model.in_band_modes().take(sizes::MAC_MODES).collect();
    if modes.is_empty() {
        return None;
    }
    let shapes: Vec<&[Complex64]> = modes.iter().map(|mode| mode.shape.0.as_slice()).collect();
    let mac = chladni_rfp::mac_matrix(&shapes, &shapes);
    let numbered = modes.len() <= sizes::NUMBERED_MODES;
    let cells = mac.indexed_iter().map(|((row, column), &value)| Cell {
        sides: [
            [column as f64 + 0.5, column as f64 + 1.5],
            [row as f64 + 0.5, row as f64 + 1.5],
        ],
        fill: ColourMap::White.at(value),
        text: if numbered && value >= 0.005 {
            fixed(value, 2)
        } else {
            String::new()
        },
        hint: format!(
            "modes {} and {}, {} Hz and {} Hz: MAC {}",
            row + 1,
            column + 1,
            fixed(modes[row].frequency_hz, 1),
            fixed(modes[column].frequency_hz, 1),
            fixed(value, 3)
        ),
    });
    let ends = [0.5, modes.len() as f64 + 0.5];
    let names: Vec<(f64, String)> = (1..=modes.len())
        .map(|k| (k as f64, k.to_string()))
        .collect();
    let axis = |label| {
        Axis::linear(label, "number in the pole table")
            .range(ends)
            .names(thin_names(&names))
    };
    let mut chart = Chart::new(axis("Mode"), axis("Mode"))
        .height(Height::EqualScales(470.0))
        .with(Layer::Cells(cells.collect()));
    chart.grid = false;
    chart.colour_bar = Some(ColourBar {
        axis: Axis::linear("MAC", "0 to 1").range([0.0, 1.0]).step(0.2),
        map: ColourMap::White,
        bands: 0,
        lines: Vec::new(),
    });
    Some(Figure {
        name: "auto-mac".into(),
        title: "AutoMAC of the shapes".into(),
        caption: caption(&mac),
        width: sizes::MAP_PX,
        charts: vec![chart],
    })
}

/// All names, or every second, fifth, ... where there are many.
fn thin_names(names: &[(f64, String)]) -> Vec<(f64, String)> {
    let every = [1, 2, 5, 10, 20]
        .into_iter()
        .find(|every| names.len() / every <= 26)
        .unwrap_or(50);
    names
        .iter()
        .filter(|(place, _)| (*place as usize).is_multiple_of(every))
        .cloned()
        .collect()
}

fn caption(mac: &ndarray::Array2<f64>) -> String {
    let beside = mac.indexed_iter().filter(|((row, column), _)| row < column);
    let largest = beside.max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
    match largest {
        Some(((row, column), &value)) => format!(
            "The largest value beside the diagonal is {} (modes {} and {}).{}",
            fixed(value, 3),
            row + 1,
            column + 1,
            if value > sizes::HIGH_MAC {
                " Shapes that agree so far are hardly two modes, or the responses are too few to \
                 tell them apart."
            } else {
                " The responses tell all shapes apart."
            }
        ),
        None => "One shape agrees with itself.".into(),
    }
}
