//! Progress by stages, on stderr.

use crate::args::ProgressChoice;
use crate::limits::{ROUNDING, TICK};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// The display of progress, and the times of the stages.
pub struct Progress {
    display: Display,
    course: Mutex<Course>,
}

#[derive(Default)]
struct Course {
    /// Stages and their starts; a stage without a name is the end of the last.
    stages: Vec<(String, Instant)>,
    /// Tenths of the last stage that were told.
    tenths: f64,
}

enum Display {
    Bar(ProgressBar),
    Plain,
    None,
}

impl Progress {
    /// The chosen display; none with `quiet`.
    pub fn new(choice: ProgressChoice, quiet: bool) -> Self {
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        let display = match choice {
            _ if quiet => Display::None,
            ProgressChoice::Plain => Display::Plain,
            ProgressChoice::Auto if std::io::stderr().is_terminal() && !dumb => {
                Display::Bar(new_bar())
            }
            ProgressChoice::Auto | ProgressChoice::None => Display::None,
        };
        Self {
            display,
            course: Mutex::default(),
        }
    }

    fn course(&self) -> MutexGuard<'_, Course> {
        self.course.lock().expect("nothing panics while it is held")
    }

    /// Begins a stage and ends the one before.
    pub fn stage(&self, name: &str) {
        let mut course = self.course();
        course.stages.push((name.to_owned(), Instant::now()));
        course.tenths = 0.0;
        match &self.display {
            Display::Bar(bar) => {
                bar.set_message(name.to_owned());
                bar.enable_steady_tick(TICK);
            }
            Display::Plain => drop(writeln!(std::io::stderr(), "{name}")),
            Display::None => {}
        }
    }

    /// Shows the part of the stage that is done, 0 to 1, and the time that is left; as lines
    /// only at every tenth.
    pub fn so_far(&self, done: f64, left: Duration) {
        let mut course = self.course();
        let stage = course.stages.last().map_or("", |(name, _)| name.as_str());
        let words = format!(
            "{stage}: {:.0} %, {} s left",
            100.0 * done,
            left.as_secs_f64().ceil()
        );
        match &self.display {
            Display::Bar(bar) => bar.set_message(words),
            Display::Plain if (10.0 * done + ROUNDING).floor() > course.tenths => {
                course.tenths = (10.0 * done + ROUNDING).floor();
                drop(writeln!(std::io::stderr(), "{words}"));
            }
            Display::Plain | Display::None => {}
        }
    }

    /// Runs `print` while the bar is hidden.
    pub fn suspend(&self, print: impl FnOnce()) {
        match &self.display {
            Display::Bar(bar) => bar.suspend(print),
            Display::Plain | Display::None => print(),
        }
    }

    /// Ends the last stage.
    pub fn finish(&self) {
        self.course().stages.push((String::new(), Instant::now()));
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    /// Takes the seconds of each stage, stages of the same name together.
    pub fn take_times(&self) -> Vec<(String, f64)> {
        let stages = std::mem::take(&mut self.course().stages);
        let mut times: Vec<(String, f64)> = Vec::new();
        for pair in stages.windows(2).filter(|pair| !pair[0].0.is_empty()) {
            let seconds = (pair[1].1 - pair[0].1).as_secs_f64();
            match times.iter_mut().find(|(name, _)| *name == pair[0].0) {
                Some((_, total)) => *total += seconds,
                None => times.push((pair[0].0.clone(), seconds)),
            }
        }
        times
    }
}

fn new_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {msg} [{elapsed}]")
        .unwrap_or_else(|_| ProgressStyle::default_spinner());
    ProgressBar::new_spinner().with_style(style)
}
