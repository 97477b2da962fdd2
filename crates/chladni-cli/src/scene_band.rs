//! `chladni fit --scene`: the band that a scene needs, and a sentence on the modes outside.

use crate::limits::{MODES_SHOWN, TONES_SHOWN};
use chladni_console::input::source;
use chladni_console::table::{counted, shortened, significant};
use chladni_frf::{FrfKind, FrfSet, ModalModel, Result, Source};
use chladni_render::{needed_band, NeededBand, Operator, Scene};
use chladni_rfp::{FitOptions, Method};
use num_complex::Complex64;
use std::path::Path;

/// A scene and the band that it needs.
pub struct SceneBand {
    scene: Scene,
    needed: NeededBand,
    /// The scene's file.
    pub source: Source,
}

impl SceneBand {
    /// Reads the scene, and finds the band that it needs by a quick fit. Where that fails the
    /// band is the whole axis, and the fit itself reports the error.
    ///
    /// # Errors
    /// Those of the scene.
    pub fn of(file: &Path, frf: &FrfSet, options: &FitOptions) -> Result<Self> {
        let scene = Scene::read(file)?;
        let source = source(file)?;
        let whole_hz = [frf.frequency_hz.first(), frf.frequency_hz.last()]
            .map(|end| end.copied().unwrap_or(0.0));
        let look = FitOptions {
            method: Method::Peak,
            modes: None,
            band_hz: None,
            ..options.clone()
        };
        let needed = match chladni_rfp::fit(frf, &look) {
            Ok(quick) => {
                needed_band(&quick.model, &scene, whole_hz).map_err(|error| scene.blame(error))?
            }
            Err(_) => NeededBand {
                band_hz: whole_hz,
                inside_hz: Vec::new(),
                left_out_hz: Vec::new(),
                error_relative: 0.0,
            },
        };
        Ok(Self {
            scene,
            needed,
            source,
        })
    }

    /// Ends of the band that the scene needs, Hz.
    pub fn band_hz(&self) -> [f64; 2] {
        self.needed.band_hz
    }

    /// A sentence on the modes that were left out, the bound of the error that this causes, and
    /// the deviation of the model from the measured line.
    pub fn said(&self, model: &ModalModel, frf: &FrfSet) -> String {
        let NeededBand {
            band_hz: [low, high],
            inside_hz,
            left_out_hz,
            error_relative,
        } = &self.needed;
        let tones: Vec<String> = self
            .scene
            .tones()
            .iter()
            .map(|tone| significant(tone.frequency_hz, 6))
            .collect();
        let drive = shortened(&tones, TONES_SHOWN);
        let left_out = match left_out_hz.is_empty() {
            true => "nothing was left out".into(),
            false => {
                let shown: Vec<String> = left_out_hz
                    .iter()
                    .take(MODES_SHOWN)
                    .map(|&hz| significant(hz, 4))
                    .collect();
                let more = if left_out_hz.len() > shown.len() {
                    ", ..."
                } else {
                    ""
                };
                format!(
                    "{} outside ({}{more} Hz) stand as residual terms, whose series leaves out \
                     {:.2} % of the mobility at {drive} Hz",
                    counted(left_out_hz.len(), "mode"),
                    shown.join(", "),
                    100.0 * error_relative
                )
            }
        };
        let against = match self.missed(model, frf) {
            Some(missed) => format!(
                "; the model and the measured line there differ by {:.2} %, noise included",
                100.0 * missed
            ),
            None => String::new(),
        };
        format!(
            "fitted {} to {} Hz alone, what {} needs at {drive} Hz: {} seen inside; \
             {left_out}{against}",
            significant(*low, 4),
            significant(*high, 4),
            self.scene.name(),
            counted(inside_hz.len(), "mode"),
        )
    }

    /// Rms of the difference between model and measured line at the drive frequency, over the
    /// rms of the line; the largest of all tones. `None` where a line is missing.
    fn missed(&self, model: &ModalModel, frf: &FrfSet) -> Option<f64> {
        self.scene.tones().iter().try_fold(0.0, |most: f64, tone| {
            Some(most.max(missed(tone, model, frf)?))
        })
    }
}

/// The same for a scene of one tone.
fn missed(scene: &Scene, model: &ModalModel, frf: &FrfSet) -> Option<f64> {
    let line = Operator::of_line(frf, scene.frequency_hz, scene.actuators.only.as_deref()).ok()?;
    let modelled = model.frf_matrix(FrfKind::Mobility, line.frequency_hz);
    let (mut missed, mut all) = (0.0, 0.0);
    for ((i, j), &value) in line.mobility.indexed_iter() {
        let row = model
            .responses
            .iter()
            .position(|dof| *dof == line.responses[i])?;
        let column = model
            .references
            .iter()
            .position(|dof| *dof == line.references[j])?;
        missed += (modelled[[row, column]] * line.responses[i].direction.sign() - value).norm_sqr();
        all += Complex64::norm_sqr(&value);
    }
    (all > 0.0).then(|| (missed / all).sqrt())
}
