//! The table `[zones]`: a grid or polygons.

use super::keys::KEYS;
use super::read_threshold::decibels;
use crate::scene::plane::{crosses_itself, Position};
use crate::scene::zones::{PolygonKind, ZoneLayout, ZonePolygon, Zones};
use crate::tolerances;
use chladni_frf::{Error, Result};
use chladni_text::toml_reader::{Table, Value};

/// Transition width, m, where the scene gives none.
pub const DEFAULT_TRANSITION_M: f64 = 0.010;

pub(super) fn read_zones(table: &Table) -> Result<Zones> {
    table.only_keys(KEYS, "zones")?;
    let layout = match (table.get("grid"), table.get("polygon")) {
        (Some(_), Some(polygon)) => {
            return Err(polygon.error("a scene has either a grid or polygons", "one of them"))
        }
        (None, Some(polygon)) => read_polygons(table, &polygon)?,
        _ => read_grid(table)?,
    };
    Ok(Zones {
        layout,
        area_m: table
            .get("area_m")
            .map(|value| rectangle(&value))
            .transpose()?,
        transition_m: table
            .get("transition_m")
            .map_or(Ok(DEFAULT_TRANSITION_M), |value| value.not_negative())?,
    })
}

fn read_grid(table: &Table) -> Result<ZoneLayout> {
    let grid_value = table.require(
        "grid",
        "[columns, rows] of equal cells, or [[zones.polygon]]",
    )?;
    let grid = grid_value
        .list()?
        .iter()
        .map(Value::count)
        .collect::<Result<Vec<usize>>>()?;
    let grid = <[usize; 2]>::try_from(grid)
        .map_err(|_| grid_value.error("wrong number of entries", "[columns, rows]"))?;
    let cells = grid[0]
        .checked_mul(grid[1])
        .filter(|&cells| cells <= tolerances::MAX_CELLS)
        .ok_or_else(|| {
            grid_value.error(
                "too many cells",
                format!("at most {} cells", tolerances::MAX_CELLS),
            )
        })?;
    let hot_value = table.require("hot", "a list of hot cells, counted from 1")?;
    let mut hot = Vec::new();
    for value in hot_value.list()? {
        match value.count() {
            Ok(cell) if cell <= cells => hot.push(cell),
            _ => return Err(value.error("no such cell", format!("a cell from 1 to {cells}"))),
        }
    }
    if hot.is_empty() {
        return Err(hot_value.error(
            "no cell is hot",
            format!("at least one cell from 1 to {cells}"),
        ));
    }
    Ok(ZoneLayout::Grid {
        grid,
        hot,
        cells_m: table
            .get("cells_m")
            .map(|value| rectangle(&value))
            .transpose()?,
    })
}

fn rectangle(value: &Value) -> Result<[f64; 4]> {
    const EXPECTED: &str =
        "[x_min, y_min, x_max, y_max] in metres, each maximum greater than its minimum";
    let numbers = value.numbers::<4>(EXPECTED)?;
    let [x_min, y_min, x_max, y_max] = numbers;
    if x_max - x_min > tolerances::POSITION_M && y_max - y_min > tolerances::POSITION_M {
        Ok(numbers)
    } else {
        Err(value.error("an empty rectangle", EXPECTED))
    }
}

fn read_polygons(zones: &Table, value: &Value) -> Result<ZoneLayout> {
    for key in ["hot", "cells_m"] {
        if let Some(misplaced) = zones.get(key) {
            return Err(misplaced.error(
                "belongs to a grid, and this scene has polygons",
                "no such key here",
            ));
        }
    }
    let entries = value.list()?;
    let polygons = entries
        .iter()
        .map(read_polygon)
        .collect::<Result<Vec<_>>>()?;
    if polygons
        .iter()
        .map(|polygon| polygon.points_m.len())
        .sum::<usize>()
        > tolerances::MAX_POLYGON_POINTS
    {
        return Err(value.error(
            "too many corners",
            format!("at most {} in all polygons", tolerances::MAX_POLYGON_POINTS),
        ));
    }
    let crossed = |(_, polygon): &(_, &ZonePolygon)| crosses_itself(&polygon.points_m);
    if let Some((entry, _)) = entries.iter().zip(&polygons).find(crossed) {
        let corners = entry.table()?.require("points_m", "corners")?;
        return Err(corners
            .error(
                "a polygon whose sides cross",
                "corners in their order along the border",
            )
            .help("change the order of the corners, or write one polygon for each part"));
    }
    if !polygons
        .iter()
        .any(|polygon| polygon.kind == PolygonKind::Hot)
    {
        return Err(Error::bad_data("no polygon is hot")
            .at_line(value.line())
            .field("zones.polygon")
            .found("none")
            .expected("one of kind = \"hot\""));
    }
    Ok(ZoneLayout::Polygons(polygons))
}

fn read_polygon(value: &Value) -> Result<ZonePolygon> {
    let table = value.table()?;
    table.only_keys(KEYS, "zones.polygon[]")?;
    let kind_value = table.require("kind", "\"hot\", \"cold\" or \"ignore\"")?;
    let kind = match kind_value.string()? {
        "hot" => PolygonKind::Hot,
        "cold" => PolygonKind::Cold,
        "ignore" => PolygonKind::Ignore,
        _ => {
            return Err(kind_value.error("no such kind of zone", "\"hot\", \"cold\" or \"ignore\""))
        }
    };
    let points_value = table.require("points_m", "corners [[x, y], ...] in metres")?;
    let points_m = points_value
        .list()?
        .iter()
        .map(|point| point.numbers::<2>("[x, y] in metres"))
        .collect::<Result<Vec<_>>>()?;
    if polygon_area(&points_m) <= tolerances::POSITION_M.powi(2) {
        return Err(points_value.error(
            "an empty polygon",
            "at least three corners that enclose some ground",
        ));
    }
    let level_db = match table.get("level_db") {
        Some(value) if kind == PolygonKind::Hot => decibels(&value)?,
        Some(value) => {
            return Err(value.error("only hot polygons have a level", "no such key here"))
        }
        None => 0.0,
    };
    Ok(ZonePolygon {
        kind,
        level_db,
        points_m,
    })
}

/// Sum of the absolute areas of the triangles from the first corner, m²: zero only where
/// all corners lie on one line.
fn polygon_area(points: &[Position]) -> f64 {
    let Some(&[x0, y0]) = points.first() else {
        return 0.0;
    };
    let triangle = |pair: &[Position]| {
        ((pair[0][0] - x0) * (pair[1][1] - y0) - (pair[0][1] - y0) * (pair[1][0] - x0)).abs()
    };
    0.5 * points.windows(2).map(triangle).sum::<f64>()
}
