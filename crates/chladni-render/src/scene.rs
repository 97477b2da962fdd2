//! The scene file: drive frequency, threshold, zones and actuators.

use crate::drift::Drift;
use crate::plane::Position;
use crate::rig::calibration::{CalibratedOperator, Calibration};
use crate::threshold::{Threshold, ThresholdTable};
use crate::time::{read_time, TimeTable};
use crate::tolerances;
use crate::tones::{is_same, read_tones, Share, Tone};
use crate::touch::{read_touch, Touch};
use crate::zones::{PolygonKind, ZoneLayout, ZonePolygon, Zones};
use chladni_frf::{nearest_word, Dof, Error, Result};
use chladni_text::read_text;
use chladni_text::toml_reader::{parse, Keys, Table, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Every key of a scene, by table.
const KEYS: Keys = &[
    (
        "",
        &[
            "frequency_hz",
            "threshold",
            "zones",
            "actuators",
            "drift",
            "touch",
            "time",
        ],
    ),
    (
        "drift",
        &[
            "frequency_relative",
            "loss_factor_relative",
            "shape_relative",
            "isotropic_relative",
            "drive_relative",
        ],
    ),
    ("threshold", &["profile", "limen_db"]),
    (
        "zones",
        &[
            "grid",
            "hot",
            "area_m",
            "cells_m",
            "transition_m",
            "polygon",
        ],
    ),
    ("zones.polygon", &["kind", "points_m", "level_db"]),
    (
        "actuators",
        &[
            "use",
            "max_force_n",
            "max_voltage_v",
            "max_effort",
            "dead",
            "calibration",
        ],
    ),
    (
        "touch",
        &[
            "fingers",
            "where",
            "points_m",
            "criterion",
            "impedance",
            "kappa_least",
        ],
    ),
    ("touch.impedance", &["c", "m", "k"]),
    (
        "time",
        &[
            "measure",
            "summation_s",
            "level",
            "ramps",
            "burst",
            "fade",
            "move",
        ],
    ),
    (
        "time.burst",
        &["start_s", "duration_s", "ramp_s", "repeat", "hot"],
    ),
    ("time.fade", &["from", "to", "start_s", "fade_s", "ramp_s"]),
    (
        "time.move",
        &[
            "start_s",
            "path_m",
            "speed_m_per_s",
            "hot_radius_m",
            "quiet_from_m",
            "ramp_s",
        ],
    ),
];

/// Difference limen on each side of the threshold, dB, where the scene gives none.
pub const DEFAULT_LIMEN_DB: f64 = 2.0;
/// Transition width, m, where the scene gives none.
pub const DEFAULT_TRANSITION_M: f64 = 0.010;
/// Force limit of each actuator, N peak, where the scene gives none.
pub const DEFAULT_MAX_FORCE_N: f64 = 0.1;

/// The field to be felt, place by place, and the means to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The file it was read from; results carry its name.
    pub file: Option<PathBuf>,
    /// Drive frequency, Hz; the first of several.
    pub frequency_hz: f64,
    /// The share of that frequency's tone in what all tones share.
    pub share: Share,
    /// Tones that sound with it.
    pub other_tones: Vec<Tone>,
    /// Threshold profile.
    pub threshold: Threshold,
    /// Distance of the limits from the threshold, dB: hot at least threshold + limen,
    /// cold at most threshold − limen.
    pub limen_db: f64,
    /// Zones.
    pub zones: Zones,
    /// Actuators.
    pub actuators: Actuators,
    /// Drift of the panel away from its model; `None`: as the options of the rendering
    /// say.
    pub drift: Option<Drift>,
    /// Fingers that the drive must bear; `None`: nobody touches.
    pub touch: Option<Touch>,
    /// Events over time; `None`: a steady tone.
    pub time: Option<TimeTable>,
    /// Errors that measured fields have left of the mobility; of scenes over a calibrated
    /// model.
    pub learned: Option<Arc<CalibratedOperator>>,
}

/// The actuators that may be used, and their limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuators {
    /// Reference DOFs that may be driven; `None`: all.
    pub only: Option<Vec<Dof>>,
    /// Force limit of each, N peak; `None`: not given, [`DEFAULT_MAX_FORCE_N`] holds.
    pub max_force_n: Option<f64>,
    /// Voltage limit of each, V peak, where the references are volts.
    pub max_voltage_v: Option<f64>,
    /// Limit of √Σ|A_i|² over all actuators, N or V peak.
    pub max_effort: Option<f64>,
    /// Reference DOFs that do not move the panel, and are known not to.
    pub dead: Vec<Dof>,
    /// Knowledge of the rig from earlier fields.
    pub calibration: Option<Arc<Calibration>>,
    /// The file that says so.
    pub calibration_file: Option<PathBuf>,
}

/// Velocity limits of a scene, m/s peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Threshold + limen, or the part of it that a line of a band owes: hot ground moves
    /// at least so fast.
    pub hot_m_per_s: f64,
    /// Threshold.
    pub threshold_m_per_s: f64,
    /// Threshold − limen, or the part of it that one of several tones may have: cold
    /// ground moves at most so fast.
    pub cold_m_per_s: f64,
}

impl Limits {
    /// True where ground that moves at `velocity_m_per_s` is felt.
    pub fn is_felt(&self, velocity_m_per_s: f64) -> bool {
        velocity_m_per_s >= self.hot_m_per_s * (1.0 - tolerances::LIMIT)
    }
    /// True where ground that moves at `velocity_m_per_s` is quiet.
    pub fn is_quiet(&self, velocity_m_per_s: f64) -> bool {
        velocity_m_per_s <= self.cold_m_per_s * (1.0 + tolerances::LIMIT)
    }
    /// Hot limit over cold limit, dB.
    pub fn apart_db(&self) -> f64 {
        20.0 * (self.hot_m_per_s / self.cold_m_per_s).log10()
    }
}

impl Scene {
    /// Reads a scene file; a threshold file is looked for beside it.
    ///
    /// # Errors
    /// No such file, or what [`Self::parse`] finds.
    pub fn read(file: &Path) -> Result<Self> {
        let text = read_text(file, "a scene, TOML")?;
        let mut scene = Self::parse(&text, file.parent().unwrap_or(Path::new("")))
            .map_err(|error| error.file(file))?;
        scene.file = Some(file.to_path_buf());
        Ok(scene)
    }

    /// A scene from its TOML text; a threshold file is looked for in `folder`.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with line, key, what stands there and what
    /// belongs there.
    pub fn parse(text: &str, folder: &Path) -> Result<Self> {
        Self::parse_beside(text, Beside::Folder(folder))
    }

    /// The same from its text alone: no file is looked at, and `threshold.profile` names a
    /// built-in profile or one of `tables`.
    ///
    /// # Errors
    /// As [`Self::parse`]; another profile.
    pub fn parse_alone(text: &str, tables: &[ThresholdTable]) -> Result<Self> {
        Self::parse_beside(text, Beside::Tables(tables))
    }

    fn parse_beside(text: &str, beside: Beside) -> Result<Self> {
        let document = parse(text)?;
        let root = Table::root(text, &document);
        root.only_keys(KEYS, "")?;
        let optional = |name: &str| root.get(name).map(|value| value.table()).transpose();
        let (threshold, limen_db) = match optional("threshold")? {
            Some(table) => read_threshold(&table, beside)?,
            None => (Threshold::Paper, DEFAULT_LIMEN_DB),
        };
        let mut tones = read_tones(&root.require("frequency_hz", "the drive frequency in Hz")?)?;
        let Tone {
            frequency_hz,
            share,
        } = tones.remove(0);
        let zones = read_zones(
            &root
                .require(
                    "zones",
                    "a table [zones] with grid and hot, or [[zones.polygon]]",
                )?
                .table()?,
        )?;
        let time = optional("time")?
            .map(|table| read_time(&table, &zones, KEYS))
            .transpose()?;
        Ok(Self {
            file: None,
            frequency_hz,
            share,
            other_tones: tones,
            threshold,
            limen_db,
            zones,
            actuators: match optional("actuators")? {
                Some(table) => read_actuators(&table, beside)?,
                None => Actuators {
                    only: None,
                    max_force_n: None,
                    max_voltage_v: None,
                    max_effort: None,
                    dead: Vec::new(),
                    calibration: None,
                    calibration_file: None,
                },
            },
            drift: optional("drift")?
                .map(|table| read_drift(&table))
                .transpose()?,
            touch: optional("touch")?
                .map(|table| read_touch(&table, KEYS))
                .transpose()?,
            time,
            learned: None,
        })
    }

    /// The scene of each tone by itself.
    pub fn tones(&self) -> Vec<Self> {
        let first = Tone {
            frequency_hz: self.frequency_hz,
            share: self.share,
        };
        let alone = |tone: &Tone| Self {
            frequency_hz: tone.frequency_hz,
            share: tone.share,
            other_tones: Vec::new(),
            ..self.clone()
        };
        std::iter::once(&first)
            .chain(&self.other_tones)
            .map(alone)
            .collect()
    }

    /// The scene of the tone at `frequency_hz`; `None` where there is none.
    pub fn tone_at(&self, frequency_hz: f64) -> Option<Self> {
        self.tones()
            .into_iter()
            .find(|tone| is_same(tone.frequency_hz, frequency_hz))
    }

    /// Velocity limits at the drive frequency.
    ///
    /// # Errors
    /// No threshold is known at that frequency.
    pub fn limits(&self) -> Result<Limits> {
        let threshold = self.threshold.velocity_m_per_s(self.frequency_hz)?;
        let ratio = 10f64.powf(self.limen_db / 20.0);
        let [hot, cold] = [self.share.hot, self.share.cold].map(f64::sqrt);
        Ok(Limits {
            hot_m_per_s: threshold * ratio * hot,
            threshold_m_per_s: threshold,
            cold_m_per_s: threshold / ratio * cold,
        })
    }

    /// File name without its folder, as results carry it; empty for a scene that is no
    /// file.
    pub fn name(&self) -> String {
        self.file
            .as_deref()
            .map(chladni_text::file_name)
            .unwrap_or_default()
    }
}

/// The source of a scene's threshold table.
#[derive(Clone, Copy)]
enum Beside<'a> {
    /// As a file, by its path from this folder.
    Folder(&'a Path),
    /// Among these, by its name.
    Tables(&'a [ThresholdTable]),
}

fn read_threshold(table: &Table, beside: Beside) -> Result<(Threshold, f64)> {
    table.only_keys(KEYS, "threshold")?;
    let threshold = match table.get("profile") {
        Some(value) => read_profile(&value, beside)?,
        None => Threshold::Paper,
    };
    let limen_db = table
        .get("limen_db")
        .map_or(Ok(DEFAULT_LIMEN_DB), |value| {
            value.not_negative()?;
            decibels(&value)
        })?;
    Ok((threshold, limen_db))
}

fn read_profile(value: &Value, beside: Beside) -> Result<Threshold> {
    let name = value.string()?;
    match (Threshold::built_in(name), beside) {
        (Some(profile), _) => Ok(profile),
        (None, Beside::Folder(folder)) => read_table(value, &folder.join(name)),
        (None, Beside::Tables(tables)) => {
            let same_name = |table: &&ThresholdTable| table.file.as_os_str() == name;
            let table = tables.iter().find(same_name).cloned();
            table.map(Threshold::Table).ok_or_else(|| {
                value
                    .error(
                        "no such threshold profile, and no file is looked for here",
                        Threshold::NAMES.join(", "),
                    )
                    .help("a table of your own is sent along as text, under the name that stands here")
            })
        }
    }
}

fn read_table(value: &Value, file: &Path) -> Result<Threshold> {
    if !file.exists() {
        let known = Threshold::NAMES;
        return Err(value
            .error(
                "neither a threshold profile nor a file",
                format!("{} or the path of a CSV file", known.join(", ")),
            )
            .help(format!(
                "did you mean `{}`? A path is taken relative to the scene file",
                nearest_word(value.string()?, &known).unwrap_or_default()
            )));
    }
    Ok(Threshold::Table(ThresholdTable::read(file)?))
}

fn read_zones(table: &Table) -> Result<Zones> {
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

fn decibels(value: &Value) -> Result<f64> {
    match value.number()? {
        level if level.abs() <= tolerances::MOST_DB => Ok(level),
        _ => Err(value.error(
            "too many decibels",
            format!("a level between -{0} and {0} dB", tolerances::MOST_DB),
        )),
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
    let polygons = value
        .list()?
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
    table.only_keys(KEYS, "zones.polygon")?;
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

fn read_actuators(table: &Table, beside: Beside) -> Result<Actuators> {
    table.only_keys(KEYS, "actuators")?;
    let limit = |key| {
        table
            .get(key)
            .map(|value: Value| value.positive())
            .transpose()
    };
    let calibration = table
        .get("calibration")
        .map(|value| calibration_file(&value, beside))
        .transpose()?;
    Ok(Actuators {
        only: table
            .get("use")
            .map(|value| read_use(&value))
            .transpose()?
            .flatten(),
        max_force_n: limit("max_force_n")?,
        max_voltage_v: limit("max_voltage_v")?,
        max_effort: limit("max_effort")?,
        dead: table
            .get("dead")
            .map(|value| read_dofs(&value, "a list of reference DOFs like \"110:+Z\""))
            .transpose()?
            .unwrap_or_default(),
        calibration: calibration
            .as_deref()
            .map(|file| Calibration::read(file).map(Arc::new))
            .transpose()?,
        calibration_file: calibration,
    })
}

/// The calibration file that a scene names.
fn calibration_file(value: &Value, beside: Beside) -> Result<PathBuf> {
    let name = value.string()?;
    let Beside::Folder(folder) = beside else {
        return Err(value
            .error(
                "no file is looked for here",
                "a scene without a calibration",
            )
            .help("take the line out, or give the scene as a file"));
    };
    let file = folder.join(name);
    if !file.exists() {
        return Err(value
            .error(
                "no such file",
                "the path of a calibration, from the scene file's folder",
            )
            .help("`chladni correct` writes calibrations"));
    }
    Ok(file)
}

fn read_dofs(list: &Value, expected: &str) -> Result<Vec<Dof>> {
    let entry = |entry: &Value| {
        entry
            .string()?
            .parse::<Dof>()
            .map_err(|reason| entry.error(&reason, expected))
    };
    list.list()?.iter().map(entry).collect()
}

fn read_drift(table: &Table) -> Result<Drift> {
    table.only_keys(KEYS, "drift")?;
    let mut drift = Drift::default();
    for (key, _) in Drift::default().named() {
        if let (Some(value), Some(place)) = (table.get(key), drift.named_mut(key)) {
            *place = value.not_negative()?;
        }
    }
    Ok(drift)
}

fn read_use(value: &Value) -> Result<Option<Vec<Dof>>> {
    const EXPECTED: &str = "\"all\" or a list of reference DOFs like \"101:+Z\"";
    if value.is_string() {
        return if value.string()? == "all" {
            Ok(None)
        } else {
            Err(value.error("no list of actuators", EXPECTED))
        };
    }
    let only = read_dofs(value, EXPECTED)?;
    if only.is_empty() {
        return Err(value.error("no actuator is left", EXPECTED));
    }
    Ok(Some(only))
}
