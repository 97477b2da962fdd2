//! Progress of the running fit: its stages with their times, for the page.

use serde_json::{json, Value};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The stages of the last full fit, the running one among them.
#[derive(Default)]
pub struct Progress(Mutex<Stages>);

#[derive(Default)]
struct Stages {
    /// Names and seconds of the stages that have ended.
    over: Vec<(String, f64)>,
    running: Option<(String, Instant)>,
}

impl Progress {
    /// Begins a new fit.
    pub fn begin(&self) {
        *self.stages() = Stages::default();
    }

    /// Begins a stage and ends the one before. Another round of a stage adds to its time.
    pub fn stage(&self, name: &str) {
        let mut stages = self.stages();
        if stages
            .running
            .as_ref()
            .is_some_and(|(known, _)| known == name)
        {
            return;
        }
        stages.close();
        stages.running = Some((name.to_owned(), Instant::now()));
    }

    /// Ends the fit.
    pub fn end(&self) {
        self.stages().close();
    }

    /// The stages as the page reads them.
    pub fn value(&self) -> Value {
        let stages = self.stages();
        let running = stages
            .running
            .as_ref()
            .map(|(name, since)| json!([name, since.elapsed().as_secs_f64()]));
        json!({"over": stages.over, "running": running})
    }

    fn stages(&self) -> MutexGuard<'_, Stages> {
        // after a panic the list is whole all the same
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Stages {
    fn close(&mut self) {
        let Some((name, since)) = self.running.take() else {
            return;
        };
        let seconds = since.elapsed().as_secs_f64();
        match self.over.iter_mut().find(|(known, _)| *known == name) {
            Some(known) => known.1 += seconds,
            None => self.over.push((name, seconds)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_follow_each_other_and_rounds_add_up() {
        let progress = Progress::default();
        for name in ["sketch", "poles", "poles", "sketch"] {
            progress.stage(name);
        }
        let value = progress.value();
        assert_eq!(value["running"][0], "sketch");
        assert_eq!(value["over"].as_array().unwrap().len(), 2, "{value}");
        progress.end();
        assert_eq!(progress.value()["running"], Value::Null);
        progress.begin();
        assert_eq!(progress.value(), json!({"over": [], "running": null}));
    }
}
