//! Rendered scenes in words: the verdict, a map of the responses, and the robustness of the
//! drive.

use crate::indices::{stress_table, sweep_table, weights_table};
use crate::limits::{MOST_COLUMNS, MOST_ROWS, SAME_M};
use chladni_console::table::{counted, significant, table};
use chladni_render::{Field, Ground, Limits, Rendering, TouchIndices, Weights, ZoneMap};
use std::fmt::{self, Display, Formatter};

/// All tones, one below the other. `weights` are those of `rendering` with the outcome of the
/// trials.
pub fn text(weights: &Weights, rendering: &Rendering, verbose: bool) -> String {
    let fields = std::iter::once(rendering).chain(&rendering.other_tones);
    let tones: Vec<String> = weights
        .tones()
        .zip(fields)
        .map(|(weights, shown)| tone(weights, shown, verbose))
        .collect();
    tones.join("\n")
}

fn tone(weights: &Weights, shown: &Rendering, verbose: bool) -> String {
    let Rendering {
        field,
        limits,
        zones,
        ..
    } = shown;
    let judged = Judged::of(field, limits, zones);
    let mut text = format!("{}\n", sentence(weights, &judged));
    if let Some(map) = map(field, limits, zones) {
        text += &format!("{map}▲ felt  · quiet  △ ✕ limit missed; blank: not judged\n");
    }
    text += &indices(weights, &judged, limits);
    if verbose {
        text += &format!("\n{}", weights_table(weights));
    }
    text + &weights
        .stress
        .as_deref()
        .map(stress_table)
        .unwrap_or_default()
        + &weights
            .sweep
            .as_ref()
            .map(|sweep| sweep_table(sweep, weights, verbose))
            .unwrap_or_default()
}

/// Numbers of responses: those that keep their limit, and all.
#[derive(Default)]
struct Kept {
    kept: usize,
    all: usize,
}

impl Kept {
    fn count(&mut self, is_kept: bool) {
        self.kept += usize::from(is_kept);
        self.all += 1;
    }
}

impl Display for Kept {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        write!(out, "{} of {}", self.kept, self.all)
    }
}

/// The judged responses of a field.
#[derive(Default)]
struct Judged {
    hot: Kept,
    cold: Kept,
}

impl Judged {
    fn of(field: &Field, limits: &Limits, zones: &ZoneMap) -> Self {
        let mut judged = Self::default();
        for (k, ground) in field.ground.iter().enumerate() {
            let Some(is_kept) = field.keeps(k, limits, zones) else {
                continue;
            };
            match ground {
                Ground::Hot => judged.hot.count(is_kept),
                _ => judged.cold.count(is_kept),
            }
        }
        judged
    }
}

/// The verdict: the scene is met or not, the margin, and the reservation if there is one.
fn sentence(weights: &Weights, judged: &Judged) -> String {
    let hz = significant(weights.frequency_hz, 6);
    if weights.own_finding("scene-impossible").is_some() {
        return format!("The scene is impossible at {hz} Hz: no drive can meet it.");
    }
    if !weights.is_met() {
        let Judged { hot, cold } = judged;
        return format!("The scene is not met at {hz} Hz: {hot} hot felt, {cold} cold quiet.");
    }
    let spare = weights
        .indices
        .points
        .margin_db
        .map_or_else(String::new, |db| format!(" with {db:.1} dB to spare"));
    let but = weights
        .reservation()
        .map_or_else(String::new, |but| format!(", but {but}"));
    format!("The scene is met at {hz} Hz{spare}{but}.")
}

/// A map with one sign for each response; `None` where the responses do not lie on a grid
/// that fits on a terminal.
fn map(field: &Field, limits: &Limits, zones: &ZoneMap) -> Option<String> {
    let axis = |k: usize| -> Vec<f64> {
        let mut places: Vec<f64> = field.positions_m.iter().map(|place| place[k]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < SAME_M);
        places
    };
    let [columns, rows] = [axis(0), axis(1)];
    let fits = columns.len() <= MOST_COLUMNS && rows.len() <= MOST_ROWS;
    let is_grid = columns.len() * rows.len() <= 2 * field.positions_m.len();
    if !fits || !is_grid || columns.len() < 2 || rows.len() < 2 {
        return None;
    }
    let mut cells = vec![vec![' '; columns.len()]; rows.len()];
    let nearest = |axis: &[f64], place: f64| axis.partition_point(|&known| known < place - SAME_M);
    for (k, place) in field.positions_m.iter().enumerate() {
        let is_hot = field.ground[k] == Ground::Hot;
        let sign = match (field.keeps(k, limits, zones), is_hot) {
            (Some(true), true) => '▲',
            (Some(false), true) => '△',
            (Some(true), false) => '·',
            (Some(false), false) => '✕',
            (None, _) => ' ',
        };
        cells[nearest(&rows, place[1])][nearest(&columns, place[0])] = sign;
    }
    let line = |row: &Vec<char>| {
        let signs: Vec<String> = row.iter().map(char::to_string).collect();
        signs.join(" ").trim_end().to_owned() + "\n"
    };
    // y rises upwards
    Some(cells.iter().rev().map(line).collect())
}

/// A table of the indices and of the robustness of the drive.
fn indices(weights: &Weights, judged: &Judged, limits: &Limits) -> String {
    let points = &weights.indices.points;
    let area = weights.indices.area.as_ref();
    let percent = |ratio: Option<f64>| {
        ratio.map_or_else(String::new, |ratio| format!("{:.1} %", 100.0 * ratio))
    };
    let one = |name: &str, value: String, remark: String| vec![name.to_owned(), value, remark];
    let mut rows = vec![
        one(
            "hot ground felt",
            judged.hot.to_string(),
            percent(area.and_then(|area| area.hot_ratio)),
        ),
        one(
            "cold ground quiet",
            judged.cold.to_string(),
            percent(area.and_then(|area| area.cold_ratio)),
        ),
    ];
    if let Some(db) = points.contrast_db {
        let needed = format!("{:.1} needed", limits.apart_db());
        rows.push(one("contrast", format!("{db:.1} dB"), needed));
    }
    if let Some(ceiling) = weights.ceiling {
        let [possible, asked] = ceiling.in_words();
        let asked = format!("{asked} asked (certified)");
        rows.push(one("possible", format!("{possible} dB"), asked));
    }
    if let Some(db) = points.margin_db {
        rows.push(one("least margin", format!("{db:.1} dB"), String::new()));
    }
    let drive = match (points.max_force_n, points.max_voltage_v) {
        (Some(force), _) => Some(format!("{} mN", significant(1e3 * force, 3))),
        (None, Some(voltage)) => Some(format!("{} V", significant(voltage, 3))),
        (None, None) => None,
    };
    let driven = format!(
        "{}, method {} (-v: all)",
        counted(weights.actuators_used, "actuator"),
        weights.method
    );
    rows.extend(drive.map(|drive| one("largest drive", drive, driven)));
    if let Some(kappa) = weights.kappa {
        let unit = "standard deviations of the model's error".into();
        rows.push(one("tolerates", format!("{kappa:.1}"), unit));
    }
    if let Some(endurance) = weights.endurance {
        let survives = format!("{:.0} %", 100.0 * endurance.survival_ratio);
        let rigs = format!("of {} simulated", endurance.rigs);
        rows.push(one("rigs that are served", survives, rigs));
    }
    if let Some(touch) = &weights.touch {
        let [tolerated, served, least] = under_fingers(touch);
        rows.push(one("tolerates fingers", tolerated, String::new()));
        rows.push(one("served under them", served, least));
    }
    table(&["", "responses", "ground between"], &rows)
}

/// The firmest finger that the drive withstands; the share of responses served under fingers;
/// the share at the worst place.
fn under_fingers(touch: &TouchIndices) -> [String; 3] {
    let kappa = touch.kappa.unwrap_or(f64::INFINITY);
    let tolerated = match &touch.firmest {
        Some(firmest) => format!("up to {firmest}, with {kappa:.1} standard deviations"),
        None => "none".into(),
    };
    let [served, least] = [touch.points.success_ratio, touch.points.min_ratio];
    [
        tolerated,
        format!("{:.1} %", 100.0 * served),
        format!(
            "at the worst place {:.0} % of the worse zone",
            100.0 * least
        ),
    ]
}
