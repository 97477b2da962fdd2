//! `chladni bench`: speed and accuracy on cases whose truth is known.

mod accuracy;
mod profile;

use crate::console::Console;
use crate::outcome::Outcome;
use crate::output::{make_folder, Output, PICTURE, TABLE};
use chladni_frf::io::write_atomically;
use chladni_frf::Result;
use chladni_report::Figure;
use chladni_rfp::Method;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::path::{Path, PathBuf};

/// Pixels of a PNG file per px of the picture.
const PNG_SCALE: f64 = 2.0;

/// What to measure.
#[derive(Debug, clap::Subcommand)]
pub enum Bench {
    /// Error against time: every method on every case, over many noise seeds, measured by the Cramér-Rao bound
    Accuracy(accuracy::Args),
    /// Time of each stage of a fit, and the floor that no method can go below
    Profile(profile::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(what: &Bench, console: &Console) -> Result<Outcome> {
    match what {
        Bench::Accuracy(args) => accuracy::run(args, console),
        Bench::Profile(args) => profile::run(args, console),
    }
}

/// Options of all benches.
#[derive(Debug, clap::Args)]
pub struct Place {
    /// Folder to write into
    #[arg(short, value_name = "DIR")]
    output: PathBuf,
    /// Fewer cases and seeds: within a minute on two cores
    #[arg(long)]
    quick: bool,
    /// Methods to run; may be repeated [default: all]
    #[arg(long = "method", value_name = "METHOD", value_parser = PossibleValuesParser::new(Method::ALL.map(Method::as_str))
        .try_map(|name| name.parse::<Method>()))]
    methods: Vec<Method>,
}

impl Place {
    fn methods(&self) -> Vec<Method> {
        if self.methods.is_empty() {
            Method::ALL.to_vec()
        } else {
            self.methods.clone()
        }
    }

    /// Makes the folder and refuses, before the work, a table that stands there already.
    fn table(&self, name: &str, console: &Console) -> Result<PathBuf> {
        make_folder(&self.output)?;
        let path = self.output.join(name);
        Output::new(&path, TABLE, &[], console)?;
        Ok(path)
    }

    /// Writes the table and the figures as SVG and PNG; returns the files. Figures of an earlier run go with its table.
    fn write(&self, table: &Path, csv: &str, figures: &[Figure], console: &Console) -> Result<Vec<PathBuf>> {
        console.stage("writing");
        Output::new(table, TABLE, &[], console)?.write(|path, force| bytes(path, csv.as_bytes(), force))?;
        let mut files = vec![table.to_path_buf()];
        for figure in figures {
            let drawing = figure.draw();
            for (extension, content) in PICTURE.iter().zip([drawing.to_svg().into_bytes(), drawing.to_png(PNG_SCALE)]) {
                let path = self.output.join(format!("{}.{extension}", figure.name));
                Output::new(&path, PICTURE, &[], console)?.write(|path, force| bytes(path, &content, force))?;
                files.push(path);
            }
        }
        Ok(files)
    }
}

fn bytes(path: &Path, content: &[u8], force: bool) -> Result<()> {
    write_atomically(path, force, |out| out.write_all(content))
}

/// A number for a table of the screen; a dash where it is not defined.
fn shown(value: f64, decimals: usize) -> String {
    match value.is_finite() {
        true => format!("{value:.decimals$}"),
        false => "–".into(),
    }
}
