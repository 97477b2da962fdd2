//! Reading `[time]`, key by key; what cannot be is refused with its line and name.

use crate::scene::plane::Rectangle;
use crate::scene::zones::{ZoneLayout, Zones};
use crate::time::plan::Plan;
use crate::time::table::{
    Burst, Fade, Level, Measure, Move, RampTime, Ramps, TimeTable, DEFAULT_SUMMATION_S,
};
use crate::tolerances;
use chladni_frf::{Error, Result};
use chladni_text::toml_reader::{Keys, Table, Value};

/// The table `[time]` of a scene with `zones`.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] with line, key, what stands there and what belongs
/// there.
pub(crate) fn read_time(table: &Table, zones: &Zones, keys: Keys) -> Result<TimeTable> {
    table.only_keys(keys, "time")?;
    let entries = |name: &str| -> Result<Vec<Value>> {
        table.get(name).map_or(Ok(Vec::new()), |value| value.list())
    };
    let read = TimeTable {
        measure: word(table, "measure", &Measure::ALL.map(|m| (m.as_str(), m)))?,
        summation_s: table
            .get("summation_s")
            .map_or(Ok(DEFAULT_SUMMATION_S), |value| value.positive())?,
        level: word(table, "level", &Level::ALL.map(|l| (l.as_str(), l)))?,
        ramps: word(table, "ramps", &Ramps::ALL.map(|r| (r.as_str(), r)))?,
        bursts: each(&entries("burst")?, |value| read_burst(value, zones, keys))?,
        fades: each(&entries("fade")?, |value| read_fade(value, zones, keys))?,
        moves: each(&entries("move")?, |value| read_move(value, zones, keys))?,
    };
    if read.bursts.is_empty() && read.fades.is_empty() && read.moves.is_empty() {
        return Err(Error::bad_data("nothing happens in [time]")
            .field("time")
            .found("no burst, no fade, no move")
            .expected("[[time.burst]], [[time.fade]] or [[time.move]]"));
    }
    Plan::new(&read, zones)?;
    Ok(read)
}

fn each<T>(entries: &[Value], read: impl Fn(&Value) -> Result<T>) -> Result<Vec<T>> {
    entries.iter().map(read).collect()
}

/// One of some words; the first where the key is absent.
fn word<T: Copy>(table: &Table, key: &str, known: &[(&str, T)]) -> Result<T> {
    let Some(value) = table.get(key) else {
        return Ok(known[0].1);
    };
    let text = value.string()?;
    known
        .iter()
        .find(|(name, _)| *name == text)
        .map(|known| known.1)
        .ok_or_else(|| {
            let names: Vec<String> = known
                .iter()
                .map(|(name, _)| format!("\"{name}\""))
                .collect();
            value.error("no such choice", names.join(", "))
        })
}

fn required<'a>(table: &Table<'a>, key: &str, expected: &str) -> Result<Value<'a>> {
    table.require(key, expected)
}

fn ramp(table: &Table) -> Result<RampTime> {
    match table.get("ramp_s") {
        None => Ok(RampTime::Auto),
        Some(value) if value.is_string() => match value.string()? {
            "auto" => Ok(RampTime::Auto),
            _ => Err(value.error("no such ramp", "\"auto\" or seconds")),
        },
        Some(value) => value.positive().map(RampTime::Seconds),
    }
}

/// Line of `ramp_s`; that of its event, `value`, where it has none.
fn ramp_line(table: &Table, value: &Value) -> u64 {
    table.get("ramp_s").map_or(value.line(), |ramp| ramp.line())
}

fn start(table: &Table) -> Result<f64> {
    table
        .get("start_s")
        .map_or(Ok(0.0), |value| value.not_negative())
}

fn read_burst(value: &Value, zones: &Zones, keys: Keys) -> Result<Burst> {
    let table = value.table()?;
    table.only_keys(keys, "time.burst[]")?;
    let duration = required(
        &table,
        "duration_s",
        "the length with both ramps in seconds",
    )?;
    let duration_s = duration.positive()?;
    let ramp = ramp(&table)?;
    if let (RampTime::Seconds(ramp_s), Some(value)) = (ramp, table.get("ramp_s")) {
        if 2.0 * ramp_s > duration_s {
            return Err(value.error(
                "rise and fall take longer than the burst",
                format!("at most {} s, half of duration_s", 0.5 * duration_s),
            ));
        }
    }
    let (count, period_s) = match table.get("repeat") {
        None => (1, duration_s),
        Some(value) => read_repeat(&value, duration_s)?,
    };
    Ok(Burst {
        start_s: start(&table)?,
        duration_s,
        ramp,
        ramp_line: ramp_line(&table, value),
        count,
        period_s,
        hot: table
            .get("hot")
            .map(|value| cells(&value, zones))
            .transpose()?,
        line: value.line(),
    })
}

fn read_repeat(value: &Value, duration_s: f64) -> Result<(usize, f64)> {
    const EXPECTED: &str = "[count, period in seconds], as in [3, 0.2]";
    let entries = value.list()?;
    let [count, period] = entries.as_slice() else {
        return Err(value.error("wrong number of entries", EXPECTED));
    };
    let (count, period_s) = (count.count()?, period.positive()?);
    if count > tolerances::MOST_EVENTS {
        return Err(value.error(
            "too many bursts",
            format!("at most {}", tolerances::MOST_EVENTS),
        ));
    }
    if period_s < duration_s {
        return Err(value.error(
            "a burst begins before the last one ended",
            format!("a period of at least duration_s, {duration_s} s"),
        ));
    }
    Ok((count, period_s))
}

fn read_fade(value: &Value, zones: &Zones, keys: Keys) -> Result<Fade> {
    let table = value.table()?;
    table.only_keys(keys, "time.fade[]")?;
    let from = cells(&required(&table, "from", "a list of hot cells")?, zones)?;
    let to_value = required(&table, "to", "a list of hot cells")?;
    let to = cells(&to_value, zones)?;
    if from == to {
        return Err(to_value.error(
            "a fade from some cells to the same",
            "other cells than `from`",
        ));
    }
    Ok(Fade {
        from,
        to,
        start_s: required(&table, "start_s", "when the fade begins in seconds")?.not_negative()?,
        fade_s: required(&table, "fade_s", "how long the fade takes in seconds")?.positive()?,
        ramp: ramp(&table)?,
        ramp_line: ramp_line(&table, value),
        line: value.line(),
    })
}

fn read_move(value: &Value, zones: &Zones, keys: Keys) -> Result<Move> {
    let table = value.table()?;
    table.only_keys(keys, "time.move[]")?;
    let path = required(&table, "path_m", "corners [[x, y], ...] in metres")?;
    let path_m = each(&path.list()?, |point| {
        point.numbers::<2>("[x, y] in metres")
    })?;
    if let Some(area) = zones.area_m.map(Rectangle::from_array) {
        if let Some(outside) = path
            .list()?
            .iter()
            .zip(&path_m)
            .find(|(_, point)| !area.contains(**point))
        {
            return Err(outside.0.error(
                "the path leaves the ground that is judged",
                "points inside zones.area_m",
            ));
        }
    }
    let hot_radius_m = required(
        &table,
        "hot_radius_m",
        "the radius of the hot spot in metres",
    )?
    .positive()?;
    let quiet = required(
        &table,
        "quiet_from_m",
        "the distance from which ground is cold in metres",
    )?;
    let quiet_from_m = quiet.positive()?;
    if quiet_from_m <= hot_radius_m {
        return Err(quiet.error(
            "cold ground would begin inside the hot spot",
            format!("more than hot_radius_m, {hot_radius_m} m"),
        ));
    }
    let speed = required(&table, "speed_m_per_s", "the speed of the spot in m/s")?;
    let speed_m_per_s = speed.positive()?;
    if speed_m_per_s > tolerances::FASTEST_M_PER_S {
        let most = tolerances::FASTEST_M_PER_S;
        return Err(speed.error(
            "the spot is too fast to be felt anywhere",
            format!("at most {most} m/s"),
        ));
    }
    let read = Move {
        start_s: start(&table)?,
        path_m,
        speed_m_per_s,
        hot_radius_m,
        quiet_from_m,
        ramp: ramp(&table)?,
        ramp_line: ramp_line(&table, value),
        line: value.line(),
    };
    let keyframes = read.length_m() / tolerances::KEYFRAME_M;
    if keyframes.is_nan() || read.length_m() <= tolerances::POSITION_M {
        return Err(path.error("a path without length", "at least two different points"));
    }
    if keyframes > tolerances::MOST_EVENTS as f64 {
        let most = tolerances::MOST_EVENTS as f64 * tolerances::KEYFRAME_M;
        return Err(path.error("the path is too long", format!("at most {most} m")));
    }
    Ok(read)
}

/// Cells of the scene's grid, sorted.
fn cells(value: &Value, zones: &Zones) -> Result<Vec<usize>> {
    let ZoneLayout::Grid { grid, .. } = &zones.layout else {
        return Err(value.error(
            "cells belong to a grid, and this scene has polygons",
            "a scene with zones.grid",
        ));
    };
    let count = grid[0] * grid[1];
    let mut cells = Vec::new();
    for entry in value.list()? {
        match entry.count() {
            Ok(cell) if cell <= count => cells.push(cell),
            _ => return Err(entry.error("no such cell", format!("a cell from 1 to {count}"))),
        }
    }
    if cells.is_empty() {
        return Err(value.error(
            "no cell is hot",
            format!("at least one cell from 1 to {count}"),
        ));
    }
    cells.sort_unstable();
    cells.dedup();
    Ok(cells)
}
