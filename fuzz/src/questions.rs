//! Questions to the studio, put together part by part: what its page sends, and what
//! somebody may send who has the token.
//!
//! They go through what the studio's server makes of a body: it is parsed, checked, and what
//! is left of it fits a small set of FRFs or is rendered on a small panel.

use crate::question::{FitQuestion, SceneQuestion};
use crate::scenes::{is_said, rendered, SMALL};
use arbitrary::Arbitrary;
use chladni_frf::{FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_render::{MethodChoice, Threshold};
use chladni_rfp::{FitOptions, Method};
use ndarray::{Array1, Array3};
use serde_json::{json, Map, Value};
use std::fmt::Write;
use std::sync::LazyLock;

/// Pages that were served.
const PAGES: u64 = 3;

/// A body that the page might send.
#[derive(Debug, Arbitrary)]
pub enum Body {
    /// To `/api/fit`.
    Fit(Fit),
    /// To `/api/scene`.
    Scene(Scene),
    /// Anything, to both.
    Text(String),
}

/// The fields of a question about a fit, and one more.
#[derive(Debug, Arbitrary)]
pub struct Fit {
    page: Option<Number>,
    number: Number,
    draft: Option<bool>,
    band_hz: Option<[Number; 2]>,
    modes: Option<Number>,
    other: Option<(String, Number)>,
}

/// A question about a scene.
#[derive(Debug, Arbitrary)]
pub struct Scene {
    frequencies: Vec<Number>,
    profile: Option<Profile>,
    levels: [Option<Number>; 2],
    zones: Zones,
    numbers: Vec<(Key, Number)>,
    method: Option<u8>,
    table: Option<(Profile, Vec<(Number, Number)>, Option<String>)>,
    more: Option<String>,
}

/// A threshold profile, or what is none.
#[derive(Debug, Arbitrary)]
pub enum Profile {
    /// A built-in one, or nearly.
    Known(u8),
    /// The name of the table.
    Table,
    /// A path.
    Path(u8),
    /// Any text.
    Text(String),
}

/// The ground where it is to be felt.
#[derive(Debug, Arbitrary)]
pub enum Zones {
    /// Cells.
    Grid([u32; 2], Vec<u32>, Option<[Number; 4]>),
    /// Corners.
    Polygons(Vec<(u8, Vec<[Number; 2]>)>),
}

/// A key of a scene that holds a number.
#[derive(Debug, Clone, Copy, Arbitrary)]
pub enum Key {
    Transition,
    Force,
    Voltage,
    Effort,
    Drift(u8),
}

/// A number, as often one that means something as one of all there are.
#[derive(Debug, Clone, Copy, Arbitrary)]
pub enum Number {
    Small(u8),
    Metres(u8),
    Any(f64),
    Whole(u64),
}

impl Number {
    fn json(self) -> Value {
        match self {
            Self::Small(value) => value.into(),
            Self::Metres(value) => (f64::from(value) / 1e3).into(),
            Self::Any(value) => value.into(),
            Self::Whole(value) => value.into(),
        }
    }
    fn toml(self) -> String {
        match self {
            Self::Any(value) => format!("{value:e}"),
            Self::Metres(value) => format!("{:?}", f64::from(value) / 1e3 - 0.1),
            value => value.json().to_string(),
        }
    }
}

impl Profile {
    fn text(&self) -> String {
        match self {
            Self::Known(k) => {
                ["paper", "classic", "press-flat", "Paper"][usize::from(k % 4)].into()
            }
            Self::Table => "mine.csv".into(),
            Self::Path(k) => {
                ["/etc/hostname", "/dev/zero", "../x.csv", ".", ""][usize::from(k % 5)].into()
            }
            Self::Text(text) => text.clone(),
        }
    }
}

impl Fit {
    fn json(&self) -> String {
        let mut body = Map::new();
        body.insert("number".into(), self.number.json());
        let given = [
            ("page", self.page.map(Number::json)),
            ("draft", self.draft.map(Value::from)),
            (
                "band_hz",
                self.band_hz.map(|band| json!(band.map(Number::json))),
            ),
            ("modes", self.modes.map(Number::json)),
        ];
        for (name, value) in given {
            value.map(|value| body.insert(name.into(), value));
        }
        if let Some((name, value)) = &self.other {
            body.insert(name.clone(), value.json());
        }
        Value::Object(body).to_string()
    }
}

impl Scene {
    fn json(&self) -> String {
        let method = self.method.map_or("fast", |k| {
            ["fast", "default", "best", "modal", "rm -rf"][usize::from(k % 5)]
        });
        let mut body = json!({"toml": self.toml(), "method": method});
        if let Some((name, rows, more)) = &self.table {
            let mut csv = String::new();
            for (hz, velocity) in rows {
                let _ = writeln!(csv, "{},{}", hz.toml(), velocity.toml());
            }
            csv += more.as_deref().unwrap_or_default();
            body["threshold"] = json!({"name": name.text(), "csv": csv});
        }
        body.to_string()
    }

    fn toml(&self) -> String {
        let list = |numbers: &[Number]| -> String {
            let words: Vec<String> = numbers.iter().map(|number| number.toml()).collect();
            format!("[{}]", words.join(", "))
        };
        let mut toml = match self.frequencies.as_slice() {
            [] => "frequency_hz = 60.0\n".to_owned(),
            [one] => format!("frequency_hz = {}\n", one.toml()),
            several => format!(
                "frequency_hz = {}\n",
                list(&several[..several.len().min(3)])
            ),
        };
        toml += "[threshold]\n";
        if let Some(profile) = &self.profile {
            let _ = writeln!(toml, "profile = {}", json!(profile.text()));
        }
        if let Some(limen) = self.levels[0] {
            let _ = writeln!(toml, "limen_db = {}", limen.toml());
        }
        self.add_zones(&mut toml, list);
        let mut tables = ["", "[actuators]\n", "[drift]\n"].map(String::from);
        for (key, number) in &self.numbers {
            let (table, name) = key.place();
            let _ = writeln!(tables[table], "{name} = {}", number.toml());
        }
        // the transition belongs to the zones, which come first where there are cells
        toml += &tables.concat();
        toml + self.more.as_deref().unwrap_or_default()
    }

    fn add_zones(&self, toml: &mut String, list: impl Fn(&[Number]) -> String) {
        match &self.zones {
            Zones::Grid(grid, hot, cells) => {
                let _ = writeln!(toml, "[zones]\ngrid = {grid:?}\nhot = {hot:?}");
                if let Some(cells) = cells {
                    let _ = writeln!(toml, "cells_m = {}", list(cells));
                }
            }
            Zones::Polygons(polygons) => {
                for (kind, points) in polygons {
                    let kind = ["hot", "cold", "ignore", "warm"][usize::from(kind % 4)];
                    let corners: Vec<String> = points.iter().map(|point| list(point)).collect();
                    let _ = writeln!(
                        toml,
                        "[[zones.polygon]]\nkind = \"{kind}\"\npoints_m = [{}]",
                        corners.join(", ")
                    );
                    if let (Some(level), "hot") = (self.levels[1], kind) {
                        let _ = writeln!(toml, "level_db = {}", level.toml());
                    }
                }
            }
        }
    }
}

impl Key {
    /// Number of its table, and its name there.
    fn place(self) -> (usize, &'static str) {
        const DRIFT: [&str; 5] = [
            "frequency_relative",
            "loss_factor_relative",
            "shape_relative",
            "isotropic_relative",
            "drive_relative",
        ];
        match self {
            Self::Transition => (0, "transition_m"),
            Self::Force => (1, "max_force_n"),
            Self::Voltage => (1, "max_voltage_v"),
            Self::Effort => (1, "max_effort"),
            Self::Drift(k) => (2, DRIFT[usize::from(k % 5)]),
        }
    }
}

/// FRFs of the small panel on a few lines.
pub static FRFS: LazyLock<FrfSet> = LazyLock::new(|| {
    let frequency_hz = Array1::from_iter((0..40).map(|k| 40.0 + f64::from(k)));
    let values = SMALL.synthesise(&frequency_hz);
    FrfSet {
        frequency_hz,
        values: FrfValues::F64(Array3::from_shape_fn(values.dim(), |at| values[at])),
        responses: SMALL.responses.clone(),
        references: SMALL.references.clone(),
        kind: Some(SMALL.frf_kind),
        reference_unit: ReferenceUnit::Newton,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: Geometry {
            nodes: SMALL.nodes.clone(),
            ..Geometry::default()
        },
    }
});

/// Asks what the studio is asked.
pub fn ask(body: &Body) {
    match body {
        Body::Fit(fit) => ask_for_fit(&fit.json()),
        Body::Scene(scene) => ask_for_scene(&scene.json()),
        Body::Text(text) => {
            ask_for_fit(text);
            ask_for_scene(text);
        }
    }
}

fn ask_for_fit(body: &str) {
    let Ok(question) = serde_json::from_str::<FitQuestion>(body) else {
        return;
    };
    match question.checked(PAGES) {
        Err(error) => is_said(&error),
        Ok((options, turn)) => {
            assert!(options
                .modes
                .is_none_or(|modes| (1..=1000).contains(&modes)));
            assert!(options
                .band_hz
                .is_none_or(|band| band.into_iter().all(|hz| (0.0..=1e10).contains(&hz))));
            let (_, newest) = serde_json::from_value::<FitQuestion>(
                json!({"page": PAGES, "number": (1_u64 << 53) - 1}),
            )
            .unwrap()
            .checked(PAGES)
            .unwrap();
            assert!(turn <= newest);
            // only drafts: a full fit takes too long for millions
            if question.draft {
                let options = FitOptions {
                    method: Method::Lean,
                    ..options
                };
                if let Err(error) = chladni_rfp::fit(&FRFS, &options) {
                    is_said(&error.told(&options, str::to_owned));
                }
            }
        }
    }
}

fn ask_for_scene(body: &str) {
    let Ok(question) = serde_json::from_str::<SceneQuestion>(body) else {
        return;
    };
    match question.checked() {
        Err(error) => is_said(&error),
        Ok((scene, method)) => {
            // no file was read: a table has the name that was sent along
            if let Threshold::Table(table) = &scene.threshold {
                let sent: Value = serde_json::from_str(body).unwrap();
                assert_eq!(sent["threshold"]["name"].as_str(), table.file.to_str());
            }
            let quick = match method {
                MethodChoice::Fast => "fast",
                _ => "modal",
            };
            rendered(&SMALL, &scene, quick);
        }
    }
}
