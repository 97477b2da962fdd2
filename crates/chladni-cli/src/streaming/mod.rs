//! Fits of data larger than memory: passes over the files, which read, reduce and drop one
//! part after the other.

mod resume;

use crate::explain::explain;
use crate::limits::{
    FIT_OVER_SET, LANES_MOST, LANES_WAITING, PARTS_OF_MEMORY, PART_MOST, PILOT_PARTS, PILOT_SHARE,
};
use chladni_console::input::source;
use chladni_console::{refused_threads, Console};
use chladni_frf::{Error, ErrorKind, Finding, FrfValues, Result, Source};
use chladni_io::{Checksums, FrfParts, Part, Turn};
use chladni_rfp::pieces::{solve, Partial, PieceError, Poles, Reducer, Solved};
use chladni_rfp::{Fit, FitOptions};
pub use resume::Resume;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{sync_channel, Receiver, SyncSender};
use std::thread;
use std::time::{Duration, Instant};

/// True where FRFs of so many bytes are fitted part by part.
pub fn too_large(bytes: u64, memory: u64) -> bool {
    bytes.saturating_mul(FIT_OVER_SET) > memory
}

/// Files that are read part by part.
pub struct Stream<'a> {
    data: FrfParts,
    parts: Vec<Part>,
    files: Vec<PathBuf>,
    /// Checksums that the first pass computes; `None` where it cannot.
    checksums: Option<Checksums>,
    options: &'a FitOptions,
    console: &'a Console,
}

impl<'a> Stream<'a> {
    /// Cuts files so that `memory` bytes are enough.
    ///
    /// # Errors
    /// Those of reading; a file that cannot be cut.
    pub fn new(
        data: FrfParts,
        files: &[PathBuf],
        memory: u64,
        options: &'a FitOptions,
        console: &'a Console,
    ) -> Result<Self> {
        let parts = data.parts((memory / PARTS_OF_MEMORY).min(PART_MOST))?;
        let checksums = data.checksums(files);
        console.find_all(data.findings());
        Ok(Self {
            data,
            parts,
            files: files.to_vec(),
            checksums,
            options,
            console,
        })
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// Bytes of all parts in memory, about.
    pub fn bytes(&self) -> u64 {
        let bytes = |part| self.data.part_bytes(part);
        self.parts.iter().map(bytes).sum()
    }

    /// Runs `work`, which makes passes, and computes the checksums of the files: in the first
    /// pass where possible, else on a thread beside.
    ///
    /// # Errors
    /// Those of either.
    pub fn with_sources<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<(T, Vec<Source>)> {
        if let Some(checksums) = &self.checksums {
            let made = work()?;
            return Ok((made, checksums.sources()?));
        }
        let files = self.files.clone();
        // not scoped: an error of `work` is told before all files are read
        let read = move || {
            files
                .iter()
                .map(|file| source(file))
                .collect::<Result<Vec<_>>>()
        };
        let sources = thread::Builder::new()
            .spawn(read)
            .map_err(|error| refused_threads(&error))?;
        let made = work()?;
        let sources = sources
            .join()
            .map_err(|_| Error::new(ErrorKind::Internal, "the thread of the checksums failed"))?;
        Ok((made, sources?))
    }

    /// One pass; `before` is the state of an interrupted one.
    ///
    /// # Errors
    /// Those of reading, of a fit that cannot be made, and of saving the state.
    pub fn pass(
        &self,
        reducer: &Reducer,
        before: Option<Partial>,
        resume: &mut Resume,
    ) -> Result<Partial> {
        self.console.stage(if reducer.is_second() {
            "second pass over the data"
        } else {
            "first pass over the data"
        });
        let pass = Pass::over(self, reducer, before.as_ref());
        let mut merged = before;
        thread::scope(|scope| {
            let lanes = pass.lanes(scope)?;
            let merging = self.merge_in_turn(&pass, &lanes, &mut merged, resume);
            // no lane may wait for a part that will not come
            if !matches!(merging, Ok(Merging::Complete)) {
                pass.give_up();
            }
            merging.map(drop)
        })?;
        merged.ok_or_else(|| {
            Error::bad_data("the input holds no FRF")
                .field("files")
                .found("none")
                .expected("at least one FRF")
                .help("look at the files with `chladni info`")
        })
    }

    /// Merges the parts of the `lanes` in the order of the data; their findings come in that
    /// order too.
    fn merge_in_turn(
        &self,
        pass: &Pass,
        lanes: &[Receiver<Result<ReducedPart>>],
        merged: &mut Option<Partial>,
        resume: &mut Resume,
    ) -> Result<Merging> {
        let bytes = |part: &Part| self.data.part_bytes(part) as f64;
        let all: f64 = pass.open.iter().map(|(_, part)| bytes(part)).sum();
        let (start, mut done) = (Instant::now(), 0.0);
        for ((_, part), lane) in pass.open.iter().zip(lanes.iter().cycle()) {
            let file = self.data.file(part);
            let Ok(received) = lane.recv() else {
                return Ok(Merging::LanePanicked);
            };
            let ReducedPart { partial, findings } = received?;
            self.console.find_all(&findings);
            done += bytes(part) / all;
            // files without bytes tell nothing of the time that is left
            let left = start.elapsed().as_secs_f64() * ((1.0 - done).max(0.0) / done);
            if let Ok(left) = Duration::try_from_secs_f64(left) {
                self.console.so_far(done, left);
            }
            let Some(partial) = partial? else {
                continue;
            };
            let whole = match merged.take() {
                Some(before) => {
                    Partial::merge([before, partial]).map_err(|error| error.file(file))?
                }
                None => partial,
            };
            resume.keep(merged.insert(whole))?;
        }
        Ok(Merging::Complete)
    }

    /// Fits the data by passes: one where the poles of a pilot serve, two otherwise, more where
    /// the solution asks for another.
    ///
    /// # Errors
    /// As [`Self::pass`].
    pub fn fit(&self, resume: &mut Resume) -> Result<Fit> {
        let file = self.data.file(&self.parts[0]);
        let explained = |error| self.explained(error, file);
        let mut before = resume.take();
        let mut reducer = match (&before, before.is_none().then(|| self.pilot()).flatten()) {
            (Some(partial), _) => Reducer::of(self.options, partial),
            (None, Some(pilot)) => Reducer::with_pilot(self.options, &pilot),
            (None, None) => Reducer::new(self.options, None),
        }
        .map_err(explained)?;
        loop {
            let partial = self.pass(&reducer, before.take(), resume)?;
            match solve(partial, self.options, &|stage| self.console.stage(stage))
                .map_err(explained)?
            {
                Solved::Fit(fit) => return Ok(*fit),
                Solved::Poles(found) => {
                    reducer = Reducer::new(self.options, Some(&found)).map_err(explained)?
                }
            }
        }
    }

    /// Poles of a few parts spread over the data; `None` where anything fails, since the passes
    /// then report the error.
    fn pilot(&self) -> Option<Poles> {
        self.console.stage("pilot");
        let reducer = Reducer::new(self.options, None).ok()?;
        let step = self.parts.len().div_ceil(PILOT_PARTS).max(PILOT_SHARE);
        let mut spare = None;
        let mut partial = |part: (u64, &Part)| {
            reduced(&self.data, self.options, &reducer, &part, None, &mut spare)
                .ok()?
                .partial
                .ok()
        };
        let partials: Option<Vec<Option<Partial>>> = (0..)
            .zip(&self.parts)
            .skip(step / 2)
            .step_by(step)
            .map(&mut partial)
            .collect();
        match solve(
            Partial::merge(partials?.into_iter().flatten()).ok()?,
            self.options,
            &|_| (),
        )
        .ok()?
        {
            Solved::Poles(poles) => Some(*poles),
            Solved::Fit(_) => None,
        }
    }

    fn explained(&self, error: PieceError, file: &Path) -> Error {
        explain_piece(error, self.options, file)
    }
}

/// A part that was read and reduced.
struct ReducedPart {
    /// `None` where the part holds no FRF.
    partial: Result<Option<Partial>>,
    /// Findings of reading, told even where the part cannot be reduced.
    findings: Vec<Finding>,
}

/// The end of merging the parts of a pass.
enum Merging {
    Complete,
    /// A lane panicked; the scope of the threads passes the panic on.
    LanePanicked,
}

/// The parts that a pass still has to reduce. With n lanes (threads), each takes every n-th.
struct Pass<'a> {
    data: &'a FrfParts,
    options: &'a FitOptions,
    reducer: &'a Reducer,
    /// The parts with their numbers.
    open: Vec<(u64, &'a Part)>,
    /// Checksums of the files, in the pass that computes them.
    checksums: Option<&'a Checksums>,
    /// Number of lanes.
    count: usize,
}

impl<'a> Pass<'a> {
    fn over(stream: &'a Stream, reducer: &'a Reducer, before: Option<&Partial>) -> Self {
        let held = |number: u64| before.is_some_and(|before| before.holds(number));
        let open = (0..)
            .zip(&stream.parts)
            .filter(|(number, _)| !held(*number))
            .collect();
        let checksums = stream.checksums.as_ref();
        Self {
            data: &stream.data,
            options: stream.options,
            reducer,
            open,
            checksums: checksums.filter(|checksums| checksums.begin()),
            count: (rayon::current_num_threads() + LANES_WAITING).min(LANES_MOST),
        }
    }

    /// Starts the lanes.
    fn lanes<'scope>(
        &'scope self,
        scope: &'scope thread::Scope<'scope, '_>,
    ) -> Result<Vec<Receiver<Result<ReducedPart>>>> {
        let lane = |first: usize| {
            let (sender, receiver) = sync_channel(1);
            let started =
                thread::Builder::new().spawn_scoped(scope, move || self.run_lane(first, &sender));
            started
                .map(|_| receiver)
                .map_err(|error| refused_threads(&error))
        };
        let lanes: Result<Vec<_>> = (0..self.count).map(lane).collect();
        if lanes.is_err() {
            // no lane may wait for one that was not started
            self.give_up();
        }
        lanes
    }

    /// Reduces the open parts of the lane whose first part is `first`.
    fn run_lane(&self, first: usize, sender: &SyncSender<Result<ReducedPart>>) {
        let mut spare = None;
        let mut run = || {
            for (number, part) in self.open.iter().enumerate().skip(first).step_by(self.count) {
                let turn = self
                    .checksums
                    .map(|checksums| self.data.turn(checksums, number, part.1));
                let made = reduced(
                    self.data,
                    self.options,
                    self.reducer,
                    part,
                    turn,
                    &mut spare,
                );
                if sender.send(made).is_err() {
                    break;
                }
            }
        };
        // one thread for each part: its products are too short to be worth waking others
        match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
            Ok(alone) => alone.install(run),
            Err(_) => run(),
        }
    }

    /// Ends the wait for the turns of checksums.
    fn give_up(&self) {
        self.checksums
            .iter()
            .for_each(|checksums| checksums.give_up());
    }
}

/// Reads a part in its `turn` and reduces it. The values in `spare` are memory that the parts
/// reuse, so that it is not cleared for each.
fn reduced(
    data: &FrfParts,
    options: &FitOptions,
    reducer: &Reducer,
    (number, part): &(u64, &Part),
    turn: Option<Turn>,
    spare: &mut Option<FrfValues>,
) -> Result<ReducedPart> {
    let (frf, findings) = data.read(part, turn, spare.take())?;
    let Some(frf) = frf else {
        let partial = Ok(None);
        return Ok(ReducedPart { partial, findings });
    };
    let file = data.file(part);
    let partial = match frf.known_kind() {
        Ok(_) => reducer
            .block(&frf, *number, Vec::new())
            .map(Some)
            .map_err(|error| explain_piece(error, options, file)),
        Err(error) => Err(error.file(file)),
    };
    *spare = Some(frf.values);
    Ok(ReducedPart { partial, findings })
}

/// The error of a piece that cannot be made or solved, with its file and the options.
pub fn explain_piece(error: PieceError, options: &FitOptions, file: &Path) -> Error {
    match error {
        PieceError::Fit(error) => explain(&error, options, file),
        PieceError::Data(error) if is_copy(&error) => copies_apart(error),
        PieceError::Data(error) => error.file(file),
    }
}

/// True for the error of an FRF that occurs in two parts or blocks.
fn is_copy(error: &Error) -> bool {
    error.field.as_deref() == Some("response and reference")
}

/// The same error in words for files: which of them hold the copies is not known any more.
fn copies_apart(error: Error) -> Error {
    let copy = Error::bad_data("an FRF occurs twice, in two files or in two blocks of files")
        .field("response and reference")
        .expected("every FRF once: files that are read part by part are not compared")
        .help(
            "convert the files into one with --duplicates first, last or mean, and give that one; \
             where all files name the same reference node, say --reference N,M,...; blocks must \
             not share an FRF",
        );
    Error {
        found: error.found,
        ..copy
    }
}
