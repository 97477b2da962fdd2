//! The data of the studio: the measured FRFs, and the model of the moment.

use super::draft::few_lines;
use super::progress::Progress;
use super::question::{DataQuestion, FitQuestion, Turn};
use super::rendered::Rendered;
use crate::explain::explain;
use crate::fit::echo_of;
use crate::report::Contents;
use chladni_console::input::{expand, model_of, read_frf, Reading};
use chladni_console::quoting::shell_path;
use chladni_console::Console;
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result, Source};
use chladni_report::{data, draft_data, head_data, measured_data, studio_html, ReportInput};
use chladni_rfp::{fit_watched, CancelToken, Fit, FitError, FitOptions, Method};
use serde_json::{json, Value};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// Name that the commands on the page give to the model.
pub(super) const MODEL: &str = "model.json";

/// Everything between two questions of the page.
pub struct Session {
    /// Title of the page.
    title: String,
    /// Without measured FRFs nothing can be fitted again.
    frf: Option<FrfSet>,
    sources: Vec<Source>,
    findings: Vec<Finding>,
    /// The files and options of reading, as on a command line.
    words: String,
    /// The model was in the file.
    from_model: bool,
    fitted: RwLock<Fitted>,
    /// Pages served so far.
    pages: AtomicU64,
    /// The newest question about a fit: an older one is not worth going on with.
    newest: Mutex<Turn>,
    /// Stops the full fit that was begun last.
    running: Mutex<CancelToken>,
    /// Progress of that fit.
    pub(super) progress: Progress,
    /// The last rendering, with the whole model that it was made with.
    pub(super) last: Mutex<Option<(Arc<ModalModel>, Arc<Rendered>)>>,
}

/// The models of the moment.
#[derive(Default)]
struct Fitted {
    /// The question that `latest` answers: an answer to an older one that comes later is
    /// not kept.
    turn: Turn,
    /// The model that scenes are rendered by.
    latest: Option<Arc<ModalModel>>,
    /// The last one whose number of modes was decided by evidence or by the reader, not
    /// by a draft.
    settled: Option<Arc<ModalModel>>,
    /// The question that `settled` answers.
    settled_turn: Turn,
}

impl Session {
    /// Reads FRFs, or a model with the FRFs that it names.
    ///
    /// # Errors
    /// Those of reading.
    pub fn open(files: &[PathBuf], reading: &Reading, console: &Console) -> Result<Self> {
        let files = expand(files, console)?;
        let mut words: Vec<String> = files.iter().map(|file| shell_path(file)).collect();
        let (frf, sources, model) = match files.as_slice() {
            [file] if model_of(file)?.is_some() => {
                let contents = Contents::read(&files, &[], console)?;
                (contents.measured, Vec::new(), contents.model)
            }
            _ => {
                let (frf, sources) = read_frf(&files, reading, console)?;
                words.extend(reading.flags());
                (Some(frf), sources, None)
            }
        };
        Ok(Self {
            title: chladni_text::file_name(&files[0]),
            frf,
            sources: match &model {
                Some(model) => model.source.clone(),
                None => sources,
            },
            findings: console.findings(),
            words: words.join(" "),
            from_model: model.is_some(),
            fitted: RwLock::new(Fitted {
                latest: model.map(Arc::new),
                ..Fitted::default()
            }),
            pages: AtomicU64::new(0),
            newest: Mutex::default(),
            running: Mutex::default(),
            progress: Progress::default(),
            last: Mutex::default(),
        })
    }

    /// A new page.
    pub fn page(&self) -> String {
        studio_html(&self.title, 1 + self.pages.fetch_add(1, Ordering::Relaxed))
    }

    /// The data known before any fit: the FRFs as they were measured, and the places.
    ///
    /// # Errors
    /// Those of drawing.
    pub fn start(&self) -> Result<Value> {
        let data = self.frf.as_ref().map(measured_data).transpose()?;
        Ok(json!({
            "title": self.title,
            "data": data,
            "lines_hz": self.lines_hz(),
            "refit": self.refits(),
        }))
    }

    /// Stops the full fit at its next stage.
    pub fn cancel(&self) -> Result<Value> {
        let running = self.running.lock();
        running.unwrap_or_else(PoisonError::into_inner).cancel();
        Ok(json!({}))
    }

    /// First and last line of the data, Hz.
    fn lines_hz(&self) -> Option<[f64; 2]> {
        let axis = &self.frf.as_ref()?.frequency_hz;
        Some([*axis.first()?, *axis.last()?])
    }

    fn refits(&self) -> bool {
        !self.from_model && self.frf.is_some()
    }

    /// A model with its data, as a report takes them.
    pub(super) fn input<'a>(&'a self, model: &'a ModalModel) -> ReportInput<'a> {
        ReportInput {
            title: self.title.clone(),
            model: Some(model),
            measured: self.frf.as_ref(),
            findings: self.findings.clone(),
            ..ReportInput::default()
        }
    }

    /// Fits anew, or hands over the model of the file; what the report would draw, all of
    /// it or the draft's part, and the command that does the same.
    ///
    /// # Errors
    /// Those of the question, of a fit, and of drawing.
    pub fn fit(&self, question: &FitQuestion) -> Result<Value> {
        let (options, turn) = question.checked(self.pages.load(Ordering::Relaxed))?;
        // a model that was read is the model; FRFs are fitted as they are asked to be
        let (model, command) = match (&self.frf, self.current()) {
            (_, Some(model)) if self.from_model => (model, String::new()),
            (Some(frf), _) => match self.fitted(frf, question, options, turn)? {
                Some(fitted) => fitted,
                None => return Ok(json!({ self.why_not(turn): true })),
            },
            (None, _) => return Err(Error::new(ErrorKind::Internal, "neither FRFs nor a model")),
        };
        let mut answer = json!({"model_file": self.model_file(), "refit": self.refits()});
        if question.draft || question.light {
            answer["draft"] = draft_data(&model);
        }
        if !question.draft {
            answer["command"] = command.into();
            let input = self.input(&model);
            match question.light {
                true => answer["head"] = head_data(&input),
                false => answer["data"] = data(&input)?,
            }
        }
        Ok(answer)
    }

    /// The data that the report would draw of a full fit, where that is still the last
    /// one.
    ///
    /// # Errors
    /// Those of drawing.
    pub fn data(&self, question: &DataQuestion) -> Result<Value> {
        let fitted = self.fitted.read().ok();
        let settled = fitted
            .filter(|fitted| fitted.settled_turn == question.turn())
            .and_then(|fitted| fitted.settled.clone());
        match settled {
            Some(model) => Ok(json!({"data": data(&self.input(&model))?})),
            None => Ok(json!({"overtaken": true})),
        }
    }

    /// `None` where a newer question has overtaken this one.
    fn fitted(
        &self,
        frf: &FrfSet,
        question: &FitQuestion,
        mut options: FitOptions,
        turn: Turn,
    ) -> Result<Option<(Arc<ModalModel>, String)>> {
        let mut thinned = None;
        if question.draft {
            (options.method, options.modes) = (
                Method::Lean,
                question
                    .modes
                    .or_else(|| self.known_modes(question.band_hz)),
            );
            let lines = self.settled().and_then(|settled| {
                few_lines(frf.frequency_hz.as_slice()?, question.band_hz, &settled)
            });
            thinned = lines.map(|lines| frf.on_lines(&lines));
        }
        let Some(fit) = self.unless_overtaken(thinned.as_ref().unwrap_or(frf), &options, turn)?
        else {
            return Ok(None);
        };
        let mut model = fit.model;
        (model.source, model.options) = (self.sources.clone(), echo_of(&options));
        let model = Arc::new(model);
        if let Ok(mut fitted) = self.fitted.write() {
            if turn >= fitted.turn {
                (fitted.turn, fitted.latest) = (turn, Some(model.clone()));
            }
            if !question.draft {
                (fitted.settled_turn, fitted.settled) = (turn, Some(model.clone()));
            }
        }
        let band = question
            .band_hz
            .map(|[low, high]| format!(" --band {low}:{high}"))
            .unwrap_or_default();
        let modes = question
            .modes
            .map(|modes| format!(" --modes {modes}"))
            .unwrap_or_default();
        Ok(Some((
            model,
            format!("chladni fit {}{band}{modes} -o {MODEL}", self.words),
        )))
    }

    /// Fits, and gives up at the next stage once a newer question has come; drafts, which
    /// are over in a moment, go on.
    fn unless_overtaken(
        &self,
        frf: &FrfSet,
        options: &FitOptions,
        turn: Turn,
    ) -> Result<Option<Fit>> {
        // a place that never holds anything half-written is sound whoever panicked with it
        let newest = || self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut newest = newest();
            *newest = turn.max(*newest);
        }
        let stop = CancelToken::new();
        let is_full = options.method == Method::Auto;
        if is_full {
            *self.running.lock().unwrap_or_else(PoisonError::into_inner) = stop.clone();
            self.progress.begin();
        }
        let look_around = |name: &str| {
            if is_full {
                self.progress.stage(name);
            }
            if is_full && *newest() > turn {
                stop.cancel();
            }
        };
        let fitted = fit_watched(frf, options, &look_around, &stop);
        if is_full {
            self.progress.end();
        }
        match fitted {
            Ok(fit) => Ok(Some(fit)),
            Err(FitError::Cancelled) => Ok(None),
            Err(error) => Err(explain(&error, options, Path::new(&self.title))),
        }
    }

    /// The reason that a fit was given up.
    fn why_not(&self, turn: Turn) -> &'static str {
        let newest = *self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        if newest > turn {
            "overtaken"
        } else {
            "cancelled"
        }
    }

    fn settled(&self) -> Option<Arc<ModalModel>> {
        self.fitted.read().ok()?.settled.clone()
    }

    /// Modes that the last full fit found in a band; `None` where the band goes beyond
    /// it, and visible peaks must do.
    fn known_modes(&self, band_hz: Option<[f64; 2]>) -> Option<usize> {
        let settled = self.settled()?;
        let [low, high] = band_hz.unwrap_or(settled.band_hz);
        let known = settled.band_hz[0] <= low && high <= settled.band_hz[1];
        let inside = settled
            .in_band_modes()
            .filter(|mode| (low..=high).contains(&mode.frequency_hz))
            .count();
        (known && inside > 0).then_some(inside)
    }

    pub(super) fn current(&self) -> Option<Arc<ModalModel>> {
        self.fitted.read().ok()?.latest.clone()
    }

    /// True where a model was read, and nothing is fitted.
    pub(super) fn is_of_model(&self) -> bool {
        self.from_model
    }

    /// The files and options of reading, as on a command line.
    pub(super) fn words(&self) -> &str {
        &self.words
    }
}
