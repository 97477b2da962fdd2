//! Refuses places of events that the responses cannot judge.

use crate::panel::operator::Operator;
use crate::scene::plane::Rectangle;
use crate::scene::scene_file::Scene;
use crate::scene::zones::{Ground, ZoneMap};
use crate::time::plan::{Place, Plan};
use crate::time::table::TimeTable;
use crate::time::timeline::zones_of;
use chladni_frf::{Error, Result};

/// Refuses paths that leave the ground that is judged, and spots that hold no response or
/// leave none to keep quiet.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`].
pub(crate) fn check_paths(
    operator: &Operator,
    scene: &Scene,
    table: &TimeTable,
    plan: &Plan,
) -> Result<()> {
    let Some(scanned) = Rectangle::around(&operator.positions_m) else {
        return Ok(());
    };
    let area = scene.zones.area_m.map_or(scanned, Rectangle::from_array);
    for (number, moving) in table.moves.iter().enumerate() {
        if let Some(outside) = moving.path_m.iter().find(|point| !area.contains(**point)) {
            return Err(Error::bad_data("the path leaves the ground that is judged")
                .at_line(moving.line)
                .field(format!("[[time.move]] {} path_m", number + 1))
                .found(format!("[{}, {}]", outside[0], outside[1]))
                .expected(format!(
                    "points inside x {:.4} to {:.4} m, y {:.4} to {:.4} m",
                    area.x_min, area.x_max, area.y_min, area.y_max
                )));
        }
    }
    check_spots(operator, scene, scanned, plan)
}

/// Refuses spots that hold no response or leave none to keep quiet.
fn check_spots(operator: &Operator, scene: &Scene, scanned: Rectangle, plan: &Plan) -> Result<()> {
    let spots = plan.events.iter().flat_map(|event| {
        let place = move |&stop: &usize| match &plan.places[stop] {
            Place::Spot(spot) => Some((event, *spot)),
            _ => None,
        };
        event.stops.iter().filter_map(place)
    });
    for (event, spot) in spots {
        let map = zones_of(&Place::Spot(spot.for_passing()), &scene.zones).over(scanned);
        let (key, value_m, what) = if !holds(operator, &map, Ground::Hot) {
            (
                "hot_radius_m",
                spot.hot_radius_m,
                "no response lies in the spot",
            )
        } else if !holds(operator, &map, Ground::Cold) {
            (
                "quiet_from_m",
                spot.quiet_from_m,
                "no response is left to keep quiet",
            )
        } else {
            continue;
        };
        let [x_m, y_m] = spot.centre;
        return Err(Error::bad_data(what)
            .at_line(event.line)
            .field(format!("{} {key}", event.name))
            .found(format!(
                "{value_m} m, with the spot at [{x_m:.4}, {y_m:.4}]"
            ))
            .expected("hot and cold responses wherever the spot is")
            .help("compare the radii with the spacing of the responses (metres)"));
    }
    Ok(())
}

/// Refuses bursts and fades whose cells hold no response or leave none to keep quiet.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`].
pub(crate) fn check_cells(operator: &Operator, scene: &Scene, table: &TimeTable) -> Result<()> {
    let Some(scanned) = Rectangle::around(&operator.positions_m) else {
        return Ok(());
    };
    let bursts = table.bursts.iter().enumerate().filter_map(|(k, burst)| {
        let name = format!("[[time.burst]] {} hot", k + 1);
        burst.hot.as_ref().map(|cells| (name, cells, burst.line))
    });
    let fades = table.fades.iter().enumerate().flat_map(|(k, fade)| {
        let of = |key: &str| format!("[[time.fade]] {} {key}", k + 1);
        [
            (of("from"), &fade.from, fade.line),
            (of("to"), &fade.to, fade.line),
        ]
    });
    for (name, cells, line) in bursts.chain(fades) {
        let map = zones_of(&Place::Cells(cells.clone()), &scene.zones).over(scanned);
        let (what, help) = if !holds(operator, &map, Ground::Hot) {
            (
                "no response lies in these cells",
                "compare area_m, cells_m and transition_m with the positions of the nodes (metres)",
            )
        } else if !holds(operator, &map, Ground::Cold) {
            (
                "no response is left to keep quiet",
                "name fewer cells, or check area_m and transition_m",
            )
        } else {
            continue;
        };
        return Err(Error::bad_data(what)
            .at_line(line)
            .field(name)
            .found(format!("{cells:?}"))
            .expected("at least one response inside the cells, and one outside")
            .help(help));
    }
    Ok(())
}

/// True where a response lies on such ground.
fn holds(operator: &Operator, map: &ZoneMap, class: Ground) -> bool {
    let mut places = operator.positions_m.iter();
    places.any(|&place| map.classify(place) == class)
}
