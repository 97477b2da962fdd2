//! A scene in time: traces, forces, and pictures of the ground with a byte for each place.

use super::array::u8s;
use super::chart;
use crate::figures::time::{time, unjudged};
use crate::sizes::RANGE_DB;
use chladni_render::{AreaFrames, Played, TimeFrames};
use serde_json::{json, Value};

/// Largest code of a level.
const LAST: f64 = 254.0;
/// Code of ground without a level.
const NONE: u8 = 255;

/// The data of a scene in time.
pub(crate) fn value(played: &Played) -> Value {
    let figure = time("time", "Hot and cold ground over time", played);
    let frames = played.frames.as_ref();
    json!({
        "sentence": played.indices.sentence(),
        "figure": chart::value(&figure, 2),
        "places": frames.map(places),
        "ground": frames.and_then(|frames| Some(ground(frames, frames.area.as_ref()?))),
    })
}

/// Every response over time, from hot to cold ground.
fn places(frames: &TimeFrames) -> Value {
    let (order, hot) = frames.by_ground();
    let levels = |&k: &usize| {
        frames
            .responses
            .column(k)
            .into_iter()
            .map(|&value| code(value))
    };
    json!({
        "names": order.iter().map(|&k| frames.names[k]).collect::<Vec<_>>(),
        "hot": hot,
        "unjudged": unjudged(frames),
        "count": frames.responses.nrows(),
        "step_s": frames.step_s,
        "codes": u8s(order.iter().flat_map(levels)),
    })
}

fn ground(frames: &TimeFrames, area: &AreaFrames) -> Value {
    let columns = area.x_m.len();
    let size = columns * area.y_m.len();
    let mut codes = vec![NONE; size * area.values.nrows()];
    for (picture, values) in codes.chunks_mut(size.max(1)).zip(area.values.rows()) {
        for (&[row, column], &value) in area.places.iter().zip(values) {
            picture[row * columns + column] = code(value);
        }
    }
    json!({
        "x": area.x_m,
        "y": area.y_m,
        "count": area.values.nrows(),
        "step_s": frames.step_s,
        "hot": frames.hot,
        "area_m": frames.area_m,
        "codes": u8s(codes),
    })
}

/// The code of an amplitude over the threshold, which the page turns into a colour.
pub(crate) fn code(value: f64) -> u8 {
    let place = 0.5 + 0.5 * 20.0 * value.log10() / RANGE_DB;
    (LAST * place.clamp(0.0, 1.0)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_lies_in_the_middle_of_the_colours() {
        assert_eq!([code(0.0), code(1.0), code(100.0)], [0, 127, 254]);
        assert_eq!(code(10f64.powf(0.15)), 159, "3 dB");
    }
}
