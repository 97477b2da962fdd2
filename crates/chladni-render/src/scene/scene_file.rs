//! The scene file: drive frequency, threshold, zones and actuators.

use super::actuators::{read_actuators, Actuators};
use super::beside::Beside;
use super::keys::KEYS;
use super::limits::Limits;
use super::read_threshold::{read_threshold, DEFAULT_LIMEN_DB};
use super::read_zones::read_zones;
use crate::rig::calibration::{CalibratedOperator, Calibration};
use crate::scene::drift::Drift;
use crate::scene::threshold::{Threshold, ThresholdTable};
use crate::scene::tones::{is_same, read_tones, Share, Tone};
use crate::scene::zones::Zones;
use crate::time::{read_time, TimeTable};
use crate::tolerances;
use crate::touch::{read_touch, Touch};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_text::read_text;
use chladni_text::toml_reader::{parse, Table};
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
    /// Fingers that the drive must tolerate; `None`: nobody touches.
    pub touch: Option<Touch>,
    /// Events over time; `None`: a steady tone.
    pub time: Option<TimeTable>,
    /// Errors that measured fields have left of the mobility; of scenes over a calibrated
    /// model.
    pub learned: Option<Arc<CalibratedOperator>>,
    /// Gains over frequency that each tone still takes at its own; of scenes of several
    /// tones over a calibrated model.
    pub tone_gains: Option<Arc<Calibration>>,
}

impl Scene {
    /// The error with the scene's file, where it names no other.
    pub fn blame(&self, error: Error) -> Error {
        // responses and modes are those of the model, and an internal error is nobody's
        let is_own = error.file.is_none()
            && error.kind != ErrorKind::Internal
            && !matches!(error.field.as_deref(), Some("responses" | "modes"));
        match &self.file {
            Some(file) if is_own => error.file(file),
            _ => error,
        }
    }

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
                    circuit: None,
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
            tone_gains: None,
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

fn read_drift(table: &Table) -> Result<Drift> {
    table.only_keys(KEYS, "drift")?;
    let mut drift = Drift::default();
    for (key, _) in Drift::default().named() {
        let Some(value) = table.get(key) else {
            continue;
        };
        if let Some(place) = drift.named_mut(key) {
            *place = match value.not_negative()? {
                relative if relative <= tolerances::MOST_DRIFT => relative,
                _ => {
                    return Err(value
                        .error("more than the whole", "a part from 0 to 1")
                        .help("write 0.01 for one per cent"))
                }
            };
        }
    }
    Ok(drift)
}
