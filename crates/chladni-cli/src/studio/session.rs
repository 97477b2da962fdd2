//! The data of the studio: the measured FRFs and the current model.

use super::chosen::{with_added, MODEL};
use super::draft::few_lines;
use super::progress::Progress;
use super::question::{DataQuestion, FitQuestion, Turn};
use super::rendered::Rendered;
use crate::explain::explain;
use crate::fit::echo_of;
use crate::report::Contents;
use crate::select::options_adding;
use chladni_console::input::{expand, model_of, read_frf, source, Reading};
use chladni_console::quoting::shell_path;
use chladni_console::Console;
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result, Source};
use chladni_report::{data, draft_data, head_data, measured_data, studio_html, ReportInput};
use chladni_rfp::{fit_watched, CancelToken, Fit, FitError, FitOptions, Method};
use serde_json::{json, Map, Value};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// The state that the studio keeps between the questions of its pages.
pub struct Session {
    /// Title of the page.
    title: String,
    /// The measured FRFs; `None` where a model was opened without them.
    frf: Option<FrfSet>,
    sources: Vec<Source>,
    findings: Vec<Finding>,
    /// The files, as on a command line.
    pub(super) file_words: String,
    /// The options of reading, as on a command line.
    reading_words: Vec<String>,
    /// The same in a model's options.
    reading_echo: Map<String, Value>,
    /// The file of an opened model: nothing is fitted.
    pub(super) model_source: Option<Source>,
    fitted: RwLock<Fitted>,
    /// Pages served so far.
    pages: AtomicU64,
    /// The newest question about a fit; fits for older ones are given up.
    newest: Mutex<Turn>,
    /// Cancels the full fit that began last.
    running: Mutex<CancelToken>,
    /// Progress of that fit.
    pub(super) progress: Progress,
    /// The last rendering.
    pub(super) last: Mutex<Option<Arc<Rendered>>>,
}

/// The current models.
#[derive(Default)]
struct Fitted {
    /// The question that `latest` answers. A later answer to an older question is not kept.
    turn: Turn,
    /// The model that scenes are rendered by.
    latest: Option<Arc<ModalModel>>,
    /// The model of the last full fit: a draft takes its number of modes from there.
    settled: Option<Arc<ModalModel>>,
    /// The question that `settled` answers.
    settled_turn: Turn,
    /// The last full fit to which no mode was added, with the band and the number of modes that
    /// were asked for.
    without_added: Option<(Asked, Arc<ModalModel>)>,
}

/// The band, Hz, and the number of modes that a question asks for.
type Asked = (Option<[f64; 2]>, Option<usize>);

impl Session {
    /// Reads FRFs, or a model with the FRFs that it names.
    ///
    /// # Errors
    /// Those of reading.
    pub fn open(files: &[PathBuf], reading: &Reading, console: &Console) -> Result<Self> {
        // as they were given: what is found in a folder belongs to a fit of the same words
        let words: Vec<String> = files.iter().map(|file| shell_path(file)).collect();
        let files = expand(files, console)?;
        let mut reading_echo = Map::new();
        let mut model_source = None;
        let (frf, sources, model) = match files.as_slice() {
            [file] if model_of(file)?.is_some() => {
                let contents = Contents::read(&files, &[], console)?;
                model_source = Some(source(file)?);
                (contents.measured, Vec::new(), contents.model)
            }
            _ => {
                let (frf, sources) = read_frf(&files, reading, console)?;
                reading.echo(&mut reading_echo);
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
            file_words: words.join(" "),
            reading_words: match model_source {
                Some(_) => Vec::new(),
                None => reading.flags(),
            },
            reading_echo,
            model_source,
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
        !self.is_model() && self.frf.is_some()
    }

    /// True where a model was opened.
    fn is_model(&self) -> bool {
        self.model_source.is_some()
    }

    /// The opened model on a command line.
    pub(super) fn opened_words(&self) -> Option<&str> {
        self.is_model().then_some(&self.file_words)
    }

    /// A model with its data, as a report takes them.
    pub(super) fn input<'a>(&'a self, model: &'a ModalModel) -> ReportInput<'a> {
        // a fitted model has those of reading already
        let is_new = |finding: &&Finding| !model.quality.findings.contains(finding);
        ReportInput {
            title: self.title.clone(),
            model: Some(model),
            measured: self.frf.as_ref(),
            findings: self.findings.iter().filter(is_new).cloned().collect(),
            ..ReportInput::default()
        }
    }

    /// Fits anew, or takes the opened model. Returns the data that the report would draw, or the
    /// draft's part of it, and the command that makes the same fit.
    ///
    /// # Errors
    /// Those of the question, of a fit, and of drawing.
    pub fn fit(&self, question: &FitQuestion) -> Result<Value> {
        let (options, turn) = question.checked(self.pages.load(Ordering::Relaxed))?;
        let model = match (&self.frf, self.current()) {
            (_, Some(model)) if self.is_model() => model,
            (Some(frf), _) => match self.fit_anew(frf, question, options, turn)? {
                Some(model) => model,
                None => return Ok(json!({ self.why_given_up(turn): true })),
            },
            (None, _) => return Err(Error::new(ErrorKind::Internal, "neither FRFs nor a model")),
        };
        let mut answer = json!({"model_file": self.model_file(&model), "refit": self.refits()});
        if question.draft || question.light {
            answer["draft"] = draft_data(&model);
        }
        if !question.draft {
            answer["command"] = self.fit_command(question).into();
            let added_hz = if self.is_model() {
                &[]
            } else {
                question.added_hz.as_slice()
            };
            let [command, toml] = self.add_command(added_hz);
            // of each added one, that of the mode which came of it
            let grade = |hz: &f64| model.mode_seen_at(*hz).map(|mode| mode.trust);
            let grades: Vec<_> = added_hz.iter().map(grade).collect();
            answer["added"] = json!({"command": command, "toml": toml, "grades": grades});
            let input = self.input(&model);
            match question.light {
                true => answer["head"] = head_data(&input),
                false => answer["data"] = data(&input)?,
            }
        }
        Ok(answer)
    }

    /// The data that the report would draw of a full fit, if that is still the last one.
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

    /// Fits the FRFs and keeps the model; `None` where the fit was given up.
    fn fit_anew(
        &self,
        frf: &FrfSet,
        question: &FitQuestion,
        mut options: FitOptions,
        turn: Turn,
    ) -> Result<Option<Arc<ModalModel>>> {
        let (mut thinned, mut before) = (None, None);
        if !question.draft && !options.added_hz.is_empty() {
            // as the commands on the page do: a fit, and then one with the added modes
            let Some(model) = self.fit_without_added(frf, question, &options, turn)? else {
                return Ok(None);
            };
            options = options_adding(&model, &question.added_hz, Path::new(MODEL))?;
            before = Some(model);
        }
        if question.draft {
            options.method = Method::Lean;
            let known = || self.known_modes(question.band_hz);
            options.modes = question.modes.or_else(known);
            let lines = self.settled().and_then(|settled| {
                few_lines(frf.frequency_hz.as_slice()?, question.band_hz, &settled)
            });
            thinned = lines.map(|lines| frf.on_lines(&lines));
        }
        let Some(fit) = self.fit_or_give_up(thinned.as_ref().unwrap_or(frf), &options, turn)?
        else {
            return Ok(None);
        };
        let model = Arc::new(match &before {
            Some(before) => with_added(fit.model, before, &options)?,
            None => self.named(fit.model, &options),
        });
        if let Ok(mut fitted) = self.fitted.write() {
            if turn >= fitted.turn {
                (fitted.turn, fitted.latest) = (turn, Some(model.clone()));
            }
            if !question.draft {
                (fitted.settled_turn, fitted.settled) = (turn, Some(model.clone()));
                let without_added = before.unwrap_or_else(|| model.clone());
                fitted.without_added = Some((question.asked(), without_added));
            }
        }
        Ok(Some(model))
    }

    /// The fit to which no mode is added; `None` where it was given up.
    fn fit_without_added(
        &self,
        frf: &FrfSet,
        question: &FitQuestion,
        options: &FitOptions,
        turn: Turn,
    ) -> Result<Option<Arc<ModalModel>>> {
        let known = self.fitted.read().ok();
        let known = known.and_then(|fitted| fitted.without_added.clone());
        if let Some((_, model)) = known.filter(|(asked, _)| *asked == question.asked()) {
            return Ok(Some(model));
        }
        let options = FitOptions {
            added_hz: Vec::new(),
            ..options.clone()
        };
        let fit = self.fit_or_give_up(frf, &options, turn)?;
        let model = fit.map(|fit| Arc::new(self.named(fit.model, &options)));
        if let (Some(model), Ok(mut fitted)) = (&model, self.fitted.write()) {
            // what comes next may be given up
            fitted.without_added = Some((question.asked(), model.clone()));
        }
        Ok(model)
    }

    /// A fitted model as its file holds it: with sources, options, and the findings of reading.
    fn named(&self, mut model: ModalModel, options: &FitOptions) -> ModalModel {
        (model.source, model.options) = (self.sources.clone(), echo_of(options));
        model.options.extend(self.reading_echo.clone());
        let findings = self.findings.iter().cloned();
        model.quality.findings.splice(0..0, findings);
        model
    }

    /// The command that makes the same fit; empty where a model was opened.
    fn fit_command(&self, question: &FitQuestion) -> String {
        if self.is_model() {
            return String::new();
        }
        let band = question
            .band_hz
            .map(|[low, high]| format!(" --band {low}:{high}"))
            .unwrap_or_default();
        let modes = question
            .modes
            .map(|modes| format!(" --modes {modes}"))
            .unwrap_or_default();
        let words = [std::slice::from_ref(&self.file_words), &self.reading_words].concat();
        format!("chladni fit {}{band}{modes} -o {MODEL}", words.join(" "))
    }

    /// Fits, and gives up at the next stage once a newer question has come. Drafts, which take
    /// a moment, are not given up.
    fn fit_or_give_up(
        &self,
        frf: &FrfSet,
        options: &FitOptions,
        turn: Turn,
    ) -> Result<Option<Fit>> {
        // after a panic the value is whole all the same: it is replaced at once
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
    fn why_given_up(&self, turn: Turn) -> &'static str {
        let newest = *self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        match newest > turn {
            true => "overtaken",
            false => "cancelled",
        }
    }

    fn settled(&self) -> Option<Arc<ModalModel>> {
        self.fitted.read().ok()?.settled.clone()
    }

    /// Number of modes that the last full fit found in a band; `None` where the band goes
    /// beyond that of the fit, so that a draft counts visible peaks.
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
}
