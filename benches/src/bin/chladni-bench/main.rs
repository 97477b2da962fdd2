//! `chladni bench`: speed and accuracy on cases whose truth is known. A program of its
//! own, run by `chladni bench`.

mod accuracy;
mod measured;
mod own_data;
mod paper;
mod profile;
mod rig;
mod scene;
mod solvers;
mod stability;
mod time;
mod wild;

use chladni_bench::Journal;
use chladni_console::output::{make_folder, Output, HTML, PICTURE, TABLE};
use chladni_console::{start, Common, Console, Outcome};
use chladni_frf::Result;
use chladni_io::write_atomically;
use chladni_report::Figure;
use clap::Parser;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Pixels of a PNG file per px of the picture.
const PNG_SCALE: f64 = 2.0;

/// Speed and accuracy on cases whose truth is known
#[derive(Debug, Parser)]
#[command(name = "chladni-bench", bin_name = "chladni bench", version)]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    bench: Bench,
}

fn main() -> ExitCode {
    start(
        |cli: &Cli| &cli.common,
        |cli, console| run(&cli.bench, console),
    )
}

/// What to measure.
#[derive(Debug, clap::Subcommand)]
enum Bench {
    /// Error against time: every method on every case, over many noise seeds, measured by
    /// the Cramér-Rao bound
    Accuracy(accuracy::Args),
    /// Tests simulated in time: what windows, averages and force make of damping and its
    /// error bars
    Measured(measured::Args),
    /// Time of each stage of a fit, and the floor that no method can go below
    Profile(profile::Args),
    /// Drives corrected by measured fields, on rigs whose faults are drawn from a seed
    Rig(rig::Args),
    /// Success against time: every rendering method on named scenes, from noisy FRFs to
    /// the true plate
    Scene(scene::Args),
    /// Dense kernels at the sizes of a fit, every back end that is linked in, by turns
    Solvers(solvers::Args),
    /// Where methods fail and whether they know it: maps over two things at a time,
    /// calibration of warnings and error bars
    Stability(stability::Args),
    /// Structures drawn from a seed, in either damping law: what is found, made up and
    /// announced, and whether error bars hold
    Wild(wild::Args),
    /// Bursts: rise time, force and cold overshoot of every way of ramping, beside the
    /// spatio-temporal inverse filter
    Time(time::Args),
}

fn run(what: &Bench, console: &Console) -> Result<Outcome> {
    match what {
        Bench::Accuracy(args) => accuracy::run(args, console),
        Bench::Measured(args) => measured::run(args, console),
        Bench::Profile(args) => profile::run(args, console),
        Bench::Rig(args) => rig::run(args, console),
        Bench::Scene(args) => scene::run(args, console),
        Bench::Solvers(args) => solvers::run(args, console),
        Bench::Stability(args) => stability::run(args, console),
        Bench::Wild(args) => wild::run(args, console),
        Bench::Time(args) => time::run(args, console),
    }
}

/// Options of all benches.
#[derive(Debug, clap::Args)]
struct Place {
    /// Folder to write into
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Fewer cases and seeds: within a minute on two cores
    #[arg(long)]
    quick: bool,
}

impl Place {
    /// Makes the folder and refuses, before the work, tables that stand there already.
    fn prepare(&self, tables: &[&str], console: &Console) -> Result<()> {
        make_folder(&self.output, "--output")?;
        self.refuse_tables(tables, console)
    }

    /// Refuses tables that stand there already. Where inputs are read first, the folder is made
    /// after them: a wrong input leaves none.
    fn refuse_tables(&self, tables: &[&str], console: &Console) -> Result<()> {
        if !self.output.is_dir() {
            return Ok(());
        }
        tables.iter().try_for_each(|name| {
            Output::new(&self.output.join(name), TABLE, &[], console).map(drop)
        })
    }

    /// The pieces that an interrupted run of the same `verb` with the same `purpose` has finished in
    /// this folder; a new build begins anew.
    fn journal(&self, verb: &str, purpose: &str, console: &Console) -> Result<Journal> {
        let built = std::env::current_exe()
            .and_then(|program| program.metadata())
            .and_then(|file| file.modified());
        let journal = Journal::open(
            &self.output.join(format!("{verb}.journal")),
            &format!("{verb} {purpose} {:?}", built.ok()),
        )?;
        if journal.resumed() > 0 {
            console.note(&format!(
                "going on with an interrupted run: {} pieces are finished",
                journal.resumed()
            ));
        }
        Ok(journal)
    }

    /// Writes what `verb` found: tables, figures, and all figures as one page. Returns the
    /// files; the journal of the run ends.
    fn finish(
        &self,
        (verb, title, words): (&str, &str, &str),
        tables: &[(&str, String)],
        figures: &[Figure],
        journal: Journal,
        console: &Console,
    ) -> Result<Vec<PathBuf>> {
        let mut files = self.write(tables, figures, console)?;
        files.push(self.page(verb, title, words, figures, console)?);
        journal.finish();
        Ok(files)
    }

    /// The answer of a verb that tells no more than its files and the number of rows.
    fn answer(&self, files: &[PathBuf], rows: usize, text: String) -> Outcome {
        let json = json!({
            "output": self.output.display().to_string(),
            "files": names(files),
            "rows": rows,
        });
        Outcome::written(&self.output, json, text)
    }

    /// Writes all figures as one page, `verb`.html.
    fn page(
        &self,
        verb: &str,
        title: &str,
        words: &str,
        figures: &[Figure],
        console: &Console,
    ) -> Result<PathBuf> {
        let path = self.output.join(format!("{verb}.html"));
        let page = chladni_report::gallery(title, words, figures);
        Output::new(&path, HTML, &[], console)?.write(|path, force| {
            write_atomically(path, force, |out| out.write_all(page.as_bytes()))
        })?;
        Ok(path)
    }

    /// Writes tables, and figures as SVG and PNG; returns the files.
    fn write(
        &self,
        tables: &[(&str, String)],
        figures: &[Figure],
        console: &Console,
    ) -> Result<Vec<PathBuf>> {
        console.stage("writing");
        let mut files: Vec<(PathBuf, Vec<u8>)> = tables
            .iter()
            .map(|(name, csv)| (self.output.join(name), csv.clone().into_bytes()))
            .collect();
        for figure in figures {
            let drawing = figure.draw();
            for (extension, content) in PICTURE
                .iter()
                .zip([drawing.to_svg().into_bytes(), drawing.to_png(PNG_SCALE)])
            {
                files.push((
                    self.output.join(format!("{}.{extension}", figure.name)),
                    content,
                ));
            }
        }
        for (path, content) in &files {
            Output::new(path, &[TABLE, PICTURE].concat(), &[], console)?
                .write(|path, force| write_atomically(path, force, |out| out.write_all(content)))?;
        }
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }
}

fn names(files: &[PathBuf]) -> Vec<String> {
    files
        .iter()
        .map(|file| file.display().to_string())
        .collect()
}

/// A number for a table of the screen; a dash where it is not defined.
fn shown(value: f64, decimals: usize) -> String {
    match value.is_finite() {
        true => format!("{value:.decimals$}"),
        false => "–".into(),
    }
}
