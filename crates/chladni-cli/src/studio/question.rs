//! Questions of the page, and the bounds of every number in them. No question names a file:
//! a threshold table or a measured field comes along as text.

use crate::limits::{HIGHEST_HZ, MOST_QUESTIONS, QUESTION_MOST_MODES};
use chladni_frf::{Error, Result, Source};
use chladni_io::checksum_of_bytes;
use chladni_render::{MethodChoice, Scene, Threshold, ThresholdTable};
use chladni_rfp::FitOptions;
use serde::Deserialize;
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::path::Path;

/// The order of the questions about fits: by page, then by number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Turn {
    /// Number of the page, in the order in which pages were served.
    page: u64,
    /// Rises from question to question of a page.
    number: u64,
}

/// Settings of a fit; ignored where a model was opened.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitQuestion {
    /// Number of the page that asks; 0 without a page.
    #[serde(default)]
    page: u64,
    /// Rises from question to question.
    number: u64,
    /// True while something is dragged: the answer is a quick fit, without what only a full
    /// fit changes.
    #[serde(default)]
    pub draft: bool,
    /// Hz; all lines where it is missing.
    pub band_hz: Option<[f64; 2]>,
    /// Decided by evidence where it is missing.
    pub modes: Option<usize>,
    /// Modes that the reader has seen, Hz.
    #[serde(default)]
    pub added_hz: Vec<f64>,
    /// True where the page asks later for the data that take longer than the fit.
    #[serde(default)]
    pub light: bool,
}

/// Asks for the data of a fit.
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
    /// The band, Hz, and the number of modes.
    pub fn asked(&self) -> (Option<[f64; 2]>, Option<usize>) {
        (self.band_hz, self.modes)
    }

    /// The options of the fit, and its turn. `pages` were served so far.
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
            if hz == 0.0 {
                return Err(Error::bad_data("no frequency of a mode")
                    .field("added_hz")
                    .found("0 Hz")
                    .expected("more than 0 Hz"));
            }
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

/// Name of the scene in the commands on the page.
const SCENE_FILE: &str = "scene.toml";

/// Asks for the rendering of a scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneQuestion {
    /// The scene file's text.
    toml: String,
    /// A method of `chladni render`.
    pub method: String,
    /// The table that `threshold.profile` names, where it names none that is built in.
    threshold: Option<TableText>,
    /// The selection file's text, where modes were dropped on the page; else empty.
    #[serde(default)]
    pub selection: String,
    /// Drive frequencies to try, Hz; for a sweep.
    pub range_hz: Option<[f64; 2]>,
}

/// Fields that were measured while the rendered scene was played.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredQuestion {
    /// The scene whose weights were played first.
    pub scene: SceneQuestion,
    /// Oldest first. Each but the first was measured under the drive that the fields before it
    /// correct.
    pub fields: Vec<FieldText>,
}

/// A measured field, as its file holds it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldText {
    /// Name of the file.
    pub name: String,
    /// Its text.
    pub csv: String,
}

/// Asks for a result as a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileQuestion {
    /// Name of the file.
    pub name: FileName,
    /// The selection file's text, where modes were dropped on the page; else empty.
    #[serde(default)]
    pub selection: String,
    /// The rendered scene, for files of a scene.
    pub scene: Option<SceneQuestion>,
    /// The measured fields that corrected its drive; empty for the rendered drive.
    #[serde(default)]
    pub fields: Vec<FieldText>,
}

/// The files that the page can download; the studio writes none to disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum FileName {
    /// The model without what was dropped.
    #[serde(rename = "model.json")]
    Model,
    /// The weights.
    #[serde(rename = "weights.json")]
    Weights,
    /// The calibration of the rig by the measured fields.
    #[serde(rename = "calibration.json")]
    Calibration,
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
        let mut scene = Scene::parse_alone(&self.toml, table.as_slice())?;
        scene.file = Some(SCENE_FILE.into());
        Ok((scene, self.method()?))
    }

    /// The scene file of the commands on the page.
    pub fn source(&self) -> Source {
        source_of_text(SCENE_FILE, &self.toml)
    }

    /// The method.
    ///
    /// # Errors
    /// An unknown one.
    pub fn method(&self) -> Result<MethodChoice> {
        self.method.parse()
    }
}

/// A file of the commands on the page, by its text.
pub fn source_of_text(file: &str, text: &str) -> Source {
    Source {
        file: file.into(),
        checksum: checksum_of_bytes(text.as_bytes()),
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
