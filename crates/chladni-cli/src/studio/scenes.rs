//! Scenes of the studio: renderings with the current model, sweeps, and files.

use super::chosen::selected;
use super::measured::{corrected, Corrected};
use super::question::{FileName, FileQuestion, MeasuredQuestion, SceneQuestion};
use super::rendered::Rendered;
use super::session::Session;
use crate::curves::curves;
use crate::in_time::in_time;
use chladni_frf::{Error, ModalModel, Result};
use chladni_render::{
    play, render, stress, sweep, MethodChoice, PlayOptions, RenderOptions, Scene, SignalOptions,
    StressOptions, Weights,
};
use chladni_report::{html, scene_data, RenderedScene, ReportInput};
use serde_json::{json, Value};
use std::sync::{Arc, PoisonError};

impl Session {
    /// Renders a scene with the current model.
    ///
    /// # Errors
    /// A scene that cannot be read or does not fit the model.
    pub fn render(&self, question: &SceneQuestion) -> Result<Value> {
        let rendered = self.rendered(question)?;
        let (model, rendering) = (&rendered.model, &rendered.rendering);
        // the quick drives while zones are dragged have no curves
        let curves = (question.method()? != MethodChoice::Fast)
            .then(|| curves(model, &rendered.scene, &rendering.weights))
            .transpose()?;
        let scenes = vec![RenderedScene::of_rendering(rendering).with_curves(curves.as_ref())];
        let input = ReportInput {
            model: Some(model),
            scenes,
            ..ReportInput::default()
        };
        Ok(json!({
            "scene": scene_data(&input),
            "command": self.render_command(&rendered),
            "findings": rendering.weights.findings.0,
        }))
    }

    /// The scene at other drive frequencies.
    ///
    /// # Errors
    /// Those of [`Self::render`]; no range, or none that can be swept.
    pub fn sweep(&self, question: &SceneQuestion) -> Result<Value> {
        let model = selected(&self.current_model()?, &question.selection)?;
        let (scene, _) = question.checked()?;
        let range = question.range_hz.ok_or_else(|| {
            Error::bad_data("no range of frequencies")
                .field("range_hz")
                .expected("two frequencies, Hz")
        })?;
        let swept = sweep(&model, &scene, &RenderOptions::default(), range)?;
        Ok(json!({ "sweep": swept }))
    }

    /// The scene over time, under the drive of its rendering.
    ///
    /// # Errors
    /// Those of [`Self::render`]; a scene without `[time]`, or one that cannot be played.
    pub fn in_time(&self, question: &SceneQuestion) -> Result<Value> {
        let rendered = self.rendered(question)?;
        let (model, rendering) = (&rendered.model, &rendered.rendering);
        let played = in_time(model, &rendered.scene, &rendering.weights)?.ok_or_else(|| {
            Error::bad_data("the scene is a steady tone")
                .field("toml")
                .expected("a table [time]")
        })?;
        let scene = RenderedScene::of_rendering(rendering).with_time(Some(&played));
        let input = ReportInput {
            model: Some(model),
            scenes: vec![scene],
            ..ReportInput::default()
        };
        let model = self.rendered_file(&rendered);
        Ok(json!({
            "time": scene_data(&input)["time"],
            "command": format!("chladni play {model} scene.toml --weights weights.json -o drive.wav"),
            "findings": played.findings,
        }))
    }

    /// A result as the file that the command line would write.
    ///
    /// # Errors
    /// Those of [`Self::render`]; a file of a scene without one.
    pub fn file(&self, question: &FileQuestion) -> Result<Vec<u8>> {
        let model = self.chosen(&self.current_model()?, &question.selection)?;
        match question.name {
            FileName::Model => return Ok(chladni_io::model_json(&model)?.into_bytes()),
            FileName::Report => return self.report(&model, question),
            _ => {}
        }
        let scene = question.scene.as_ref().ok_or_else(|| {
            Error::bad_data("no scene")
                .field("scene")
                .expected("what was rendered")
        })?;
        let rendered = self.rendered(scene)?;
        let corrected = corrected_drive(&rendered, question)?;
        let weights = match &corrected {
            Some(corrected) => &corrected.weights,
            None => &rendered.rendering.weights,
        };
        Ok(match question.name {
            FileName::Weights => weights.to_json()?.into_bytes(),
            FileName::Sound => signal(&rendered, weights)?.wav(SignalOptions::default().format)?,
            FileName::Calibration => {
                let corrected = corrected.ok_or_else(|| {
                    Error::bad_data("no correction yet")
                        .field("fields")
                        .expected("a measured field")
                })?;
                corrected.calibration.to_json()?.into_bytes()
            }
            _ => signal(&rendered, weights)?.sidecar.to_json()?.into_bytes(),
        })
    }

    /// The report of the model, and of the scene where one is rendered.
    fn report(&self, model: &ModalModel, question: &FileQuestion) -> Result<Vec<u8>> {
        let scene = question.scene.as_ref();
        let rendered = scene.map(|scene| self.rendered(scene)).transpose()?;
        let (mut corrected, mut played) = (None, None);
        if let Some(rendered) = &rendered {
            corrected = corrected_drive(rendered, question)?;
            let weights = &rendered.rendering.weights;
            played = in_time(&rendered.model, &rendered.scene, weights)?;
        }
        let scenes = rendered.iter().map(|rendered| match &corrected {
            Some(corrected) => corrected.scene(),
            None => RenderedScene::of_rendering(&rendered.rendering).with_time(played.as_ref()),
        });
        let input = ReportInput {
            scenes: scenes.collect(),
            ..self.input(model)
        };
        Ok(html(&input)?.into_bytes())
    }

    /// The command that renders the same.
    fn render_command(&self, rendered: &Rendered) -> String {
        let question = &rendered.question;
        let stress = if question.method == "best" {
            " --stress"
        } else {
            ""
        };
        format!(
            "chladni render {} scene.toml --method {}{stress} -o weights.json",
            self.rendered_file(rendered),
            question.method
        )
    }

    /// The file of the model that renders a scene, in the commands on the page.
    pub(super) fn rendered_file(&self, rendered: &Rendered) -> &str {
        self.chosen_file(&rendered.whole, &rendered.question.selection)
    }

    /// The rendering of the last question, or a new one.
    pub(super) fn rendered(&self, question: &SceneQuestion) -> Result<Arc<Rendered>> {
        let whole = self.current_model()?;
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last().as_ref() {
            if Arc::ptr_eq(&known.whole, &whole) && known.question == *question {
                return Ok(known.clone());
            }
        }
        let (scene, method) = question.checked()?;
        // the quick drives while zones are dragged are not played: they name no source
        let is_quick = method == MethodChoice::Fast;
        let model = match is_quick {
            true => selected(&whole, &question.selection)?,
            false => self.chosen(&whole, &question.selection)?,
        };
        let options = RenderOptions {
            method,
            ..RenderOptions::default()
        };
        let mut rendering = render(&model, &scene, &options)?;
        // as the command on the page writes them, since a measured field may name their file
        if !is_quick {
            let file = self.chosen_source(&model, &question.selection)?;
            rendering.weights.source = vec![file, question.source()];
        }
        if method == MethodChoice::Best {
            try_out(&mut rendering.weights, &scene, &model)?;
        }
        let rendered = Arc::new(Rendered {
            question: question.clone(),
            whole,
            model,
            scene,
            rendering,
        });
        *last() = Some(rendered.clone());
        Ok(rendered)
    }
}

/// Puts the weights to the trials of `render --stress`.
fn try_out(weights: &mut Weights, scene: &Scene, model: &ModalModel) -> Result<()> {
    let options = StressOptions::default();
    let (rows, findings) = stress(weights, scene, model, &options)?;
    weights
        .options
        .insert("stress_seed".into(), options.seed.into());
    weights.stress = Some(rows);
    weights.findings.extend(findings);
    Ok(())
}

/// The drive that measured fields corrected; `None` where it is as rendered.
fn corrected_drive(rendered: &Rendered, question: &FileQuestion) -> Result<Option<Corrected>> {
    if question.fields.is_empty() {
        return Ok(None);
    }
    let measured = MeasuredQuestion {
        scene: rendered.question.clone(),
        fields: question.fields.clone(),
    };
    corrected(rendered, &measured).map(Some)
}

fn signal(rendered: &Rendered, weights: &Weights) -> Result<chladni_render::Signal> {
    let (model, scene) = (&rendered.model, &rendered.scene);
    let played = play(model, scene, Some(weights), &PlayOptions::default())?;
    played.signal(&SignalOptions::default(), &scene.name())
}
