//! Questions that the page may ask, and the bounds of every number in it. No question
//! names a file: what a scene needs besides comes along as text.

use crate::limits::{HIGHEST_HZ, MOST_QUESTIONS, QUESTION_MOST_MODES};
use chladni_frf::{Error, Result};
use chladni_render::{MethodChoice, Scene, Threshold, ThresholdTable};
use chladni_rfp::FitOptions;
use serde::Deserialize;
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::path::Path;

/// A question's place among those about fits: what a newer page asks is newer, and of one
/// page what has the higher number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Turn {
    /// The page, as it was numbered when it was served.
    page: u64,
    /// Rises from question to question of a page.
    number: u64,
}

/// Settings of a fit; of no account where a model was read.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitQuestion {
    /// Number of the page that asks; 0 for who asks without one.
    #[serde(default)]
    page: u64,
    /// Rises from question to question.
    number: u64,
    /// The hand still moves: the model that is quickest to have, and what changes with it
    /// alone.
    #[serde(default)]
    pub draft: bool,
    /// Hz; all lines where it is missing.
    pub band_hz: Option<[f64; 2]>,
    /// Decided by evidence where it is missing.
    pub modes: Option<usize>,
    /// Modes that the reader has seen, Hz.
    #[serde(default)]
    pub added_hz: Vec<f64>,
    /// True where the page asks afterwards for what takes longer than the fit.
    #[serde(default)]
    pub light: bool,
}

/// The fit that is to be drawn.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataQuestion {
    /// The page that asked for the fit.
    #[serde(default)]
    page: u64,
    /// The question that it answered.
    number: u64,
}

impl DataQuestion {
    /// The turn of that question.
    pub fn turn(&self) -> Turn {
        Turn {
            page: self.page,
            number: self.number,
        }
    }
}

impl FitQuestion {
    /// The fit that is asked for, and its turn; `pages` were served so far.
    ///
    /// # Errors
    /// A number out of its bounds, by name.
    pub fn checked(&self, pages: u64) -> Result<(FitOptions, Turn)> {
        within("page", self.page, 0..=pages)?;
        within("number", self.number, 0..=MOST_QUESTIONS)?;
        if let Some(modes) = self.modes {
            within("modes", modes, 1..=QUESTION_MOST_MODES)?;
        }
        for hz in self.band_hz.into_iter().flatten() {
            within("band_hz", hz, 0.0..=HIGHEST_HZ)?;
        }
        within(
            "number of added_hz",
            self.added_hz.len(),
            0..=QUESTION_MOST_MODES,
        )?;
        for &hz in &self.added_hz {
            within("added_hz", hz, 0.0..=HIGHEST_HZ)?;
        }
        let options = FitOptions {
            band_hz: self.band_hz,
            modes: self.modes,
            added_hz: self.added_hz.clone(),
            ..FitOptions::default()
        };
        let turn = Turn {
            page: self.page,
            number: self.number,
        };
        Ok((options, turn))
    }
}

/// The scene that is to be rendered.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneQuestion {
    /// The scene file's text.
    toml: String,
    /// A method of `chladni render`.
    pub method: String,
    /// The table that `threshold.profile` names, where it names none that is built in.
    threshold: Option<TableText>,
    /// Numbers of the modes that were dropped on the page, from 1.
    #[serde(default)]
    pub drop: Vec<usize>,
    /// Drive frequencies to try, Hz; for a sweep.
    pub range_hz: Option<[f64; 2]>,
}

/// A result to take along.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileQuestion {
    /// Name of the file.
    pub name: FileName,
    /// Numbers of the modes that were dropped on the page, from 1.
    #[serde(default)]
    pub drop: Vec<usize>,
    /// The rendered scene, for files of a scene.
    pub scene: Option<SceneQuestion>,
}

/// The files that the studio hands out; it writes none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum FileName {
    /// The model without what was dropped.
    #[serde(rename = "model.json")]
    Model,
    /// The weights.
    #[serde(rename = "weights.json")]
    Weights,
    /// The drive signals.
    #[serde(rename = "drive.wav")]
    Sound,
    /// The file beside them.
    #[serde(rename = "drive.json")]
    Sidecar,
    /// The report.
    #[serde(rename = "report.html")]
    Report,
}

/// A threshold table, as its file holds it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct TableText {
    name: String,
    csv: String,
}

impl TableText {
    fn table(&self) -> Result<ThresholdTable> {
        if Threshold::built_in(&self.name).is_some() {
            return Err(
                Error::bad_data("a threshold table with the name of a built-in profile")
                    .field("threshold.name")
                    .found(&self.name)
                    .expected("another name"),
            );
        }
        ThresholdTable::parse(&self.csv, Path::new(&self.name))
            .map_err(|error| error.file(&self.name))
    }
}

impl SceneQuestion {
    /// The scene and the method.
    ///
    /// # Errors
    /// A scene or a table that cannot be read, an unknown method, a threshold profile that
    /// is neither built in nor sent along.
    pub fn checked(&self) -> Result<(Scene, MethodChoice)> {
        let table = self.threshold.as_ref().map(TableText::table).transpose()?;
        for hz in self.range_hz.into_iter().flatten() {
            within("range_hz", hz, 0.0..=HIGHEST_HZ)?;
        }
        let scene = Scene::parse_alone(&self.toml, table.as_slice())?;
        Ok((scene, self.method()?))
    }

    /// The method.
    ///
    /// # Errors
    /// An unknown one.
    pub fn method(&self) -> Result<MethodChoice> {
        self.method.parse()
    }
}

fn within<T: PartialOrd + Debug>(field: &str, value: T, bounds: RangeInclusive<T>) -> Result<()> {
    if bounds.contains(&value) {
        return Ok(());
    }
    Err(Error::bad_data("a number out of its bounds")
        .field(field)
        .found(format!("{value:?}"))
        .expected(format!("{:?} to {:?}", bounds.start(), bounds.end())))
}
