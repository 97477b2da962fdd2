//! `chladni block`: the fit in pieces.

use crate::asked_model::AskedModel;
use crate::fit::{echo_of, parse_band, written_model};
use crate::plan::Plan;
use crate::streaming::{explain_piece, Resume, Stream};
use chladni_console::input::{expand, model_of, read_frf, Reading};
use chladni_console::memory::{parse_memory, MEMORY};
use chladni_console::output::{Output, MODEL, PARTIAL, POLES_OR_MODEL};
use chladni_console::table::{counted, significant, table};
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Finding, Result, Severity};
use chladni_io::{extension_of, sha256_of, FrfParts};
use chladni_rfp::pieces::{residues, solve, Partial, Poles, Reducer, Solved};
use chladni_rfp::{FitOptions, Window};
use chladni_text::door::read_bytes;
use clap::Subcommand;
use serde_json::{json, Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The verbs.
#[derive(Debug, Subcommand)]
#[command(before_help = "Examples:
  chladni block reduce scan.h5 --block 3 --blocks 64 -o 3.part     first pass over a part of the data: one of these for each block
  chladni block merge *.part -o all.part
  chladni block solve all.part -o found.poles
  chladni block reduce scan.h5 --block 3 --blocks 64 --poles found.poles -o 3.second.part      second pass
  chladni block merge *.second.part -o second.part
  chladni block solve second.part -o model.json                    the model, as `chladni fit` finds it")]
pub enum Block {
    /// Run a pass over a block of FRFs: a small partial is left
    Reduce(Reduce),
    /// Merge partials, in any order and grouping
    Merge(Merge),
    /// Poles of the merged first pass; the model of the merged second
    Solve(Solve),
    /// Shapes of a block of FRFs at the poles of a model
    Residues(Residues),
}

/// Reading options that each block has its own of: DOFs and arrays of its files.
const OF_A_BLOCK: [&str; 4] = ["reference", "response", "dofs", "map"];

/// Arguments of `block reduce`.
#[derive(Debug, clap::Args)]
pub struct Reduce {
    /// FRF files, folders of them, or patterns
    #[arg(required = true, value_name = "FRF")]
    files: Vec<PathBuf>,
    /// Partial to write, .part
    #[arg(short, long, value_name = "PART")]
    output: PathBuf,
    /// Poles that the first pass led to: run the second
    #[arg(long, value_name = "POLES")]
    poles: Option<PathBuf>,
    /// Number of this block, from 0: each has one of its own
    #[arg(long, value_name = "I", default_value_t = 0)]
    block: usize,
    /// Blocks that the files are cut into, of which this is one [default: the files are
    /// this block]
    #[arg(long, value_name = "N")]
    blocks: Option<usize>,
    /// Band to fit, Hz, the same for all blocks [default: all lines; in the second pass
    /// that of the first]
    #[arg(long, value_name = "LO:HI", value_parser = parse_band, allow_hyphen_values = true)]
    band: Option<[f64; 2]>,
    /// Seed of the random mixtures, the same for all blocks [default: 0; in the second
    /// pass that of the first]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Window of the records that the FRFs were averaged from, as in `fit` [default: as
    /// the file says, else not known; in the second pass as in the first]
    #[arg(long, value_name = "WINDOW")]
    window: Option<Window>,
    /// Memory to keep within: bytes, or with K, M, G, T (powers of 1024)
    #[arg(long, value_name = "SIZE", default_value = MEMORY, value_parser = parse_memory)]
    memory: u64,
    /// Go on where an interrupted run with the same files, options and output ended
    #[arg(long)]
    resume: bool,
    /// Say what would be read and written, and end
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    reading: Reading,
}

/// Arguments of `block merge`.
#[derive(Debug, clap::Args)]
pub struct Merge {
    /// Partials of one pass
    #[arg(required = true, value_name = "PART")]
    files: Vec<PathBuf>,
    /// Partial to write, .part
    #[arg(short, long, value_name = "PART")]
    output: PathBuf,
}

/// Arguments of `block solve`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "--modes is decided in the first pass; --damping, --shapes and \
                  --exponential-window in the second."
)]
pub struct Solve {
    /// Merged partial of all blocks
    #[arg(value_name = "PART")]
    file: PathBuf,
    /// Poles file (.poles) of a first pass, model (.json, .h5) of a second
    #[arg(short, long, value_name = "POLES|MODEL")]
    output: PathBuf,
    #[command(flatten)]
    asked: AskedModel,
}

/// Arguments of `block residues`.
#[derive(Debug, clap::Args)]
pub struct Residues {
    /// FRF files, folders of them, or patterns
    #[arg(required = true, value_name = "FRF")]
    files: Vec<PathBuf>,
    /// Model whose poles are taken
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Model to write, .json or .h5
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, of pieces that do not belong together, and of a fit that
/// cannot be made.
pub fn run(block: &Block, console: &Console) -> Result<Outcome> {
    match block {
        Block::Reduce(args) => reduce(args, console),
        Block::Merge(args) => merge(args, console),
        Block::Solve(args) => solved(args, console),
        Block::Residues(args) => residues_of(args, console),
    }
}

impl Reduce {
    /// The options that can change the partial.
    fn echo(&self, options: &FitOptions) -> Result<Map<String, Value>> {
        let mut echo = echo_of(options);
        self.reading.echo(&mut echo);
        echo.insert("block".into(), self.block.into());
        echo.insert("blocks".into(), self.blocks.into());
        let poles = self.poles.as_deref().map(sha256_of).transpose()?;
        echo.insert("poles".into(), poles.into());
        Ok(echo)
    }

    /// The reading options that all blocks of a fit share, as JSON.
    fn shared_reading(&self) -> BTreeMap<String, String> {
        let mut echo = Map::new();
        self.reading.echo(&mut echo);
        echo.into_iter()
            .filter(|(name, _)| !OF_A_BLOCK.contains(&name.as_str()))
            .map(|(name, value)| (name, value.to_string()))
            .collect()
    }

    /// The block that is asked for: a share of the files, or all of them.
    fn data(&self, files: &[PathBuf]) -> Result<FrfParts> {
        let data = FrfParts::open(files, &self.reading.options())?;
        match self.blocks {
            None => Ok(data),
            Some(blocks) if self.block < blocks => data.share(self.block, blocks),
            Some(blocks) => Err(Error::new(ErrorKind::Usage, "there is no such block")
                .field("--block")
                .found(self.block)
                .expected(format!(
                    "0 to {}, of {blocks} blocks",
                    blocks.saturating_sub(1)
                ))
                .help("blocks are counted from 0")),
        }
    }
}

fn reduce(args: &Reduce, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    let output = Output::new(&args.output, PARTIAL, &files, console)?;
    let poles = args
        .poles
        .as_deref()
        .map(|path| Poles::from_bytes(&read_bytes(path)?).map_err(|error| error.file(path)))
        .transpose()?;
    let first = poles.as_ref().map(Poles::options).unwrap_or_default();
    let options = FitOptions {
        band_hz: args.band.or(first.band_hz),
        seed: args.seed.unwrap_or(first.seed),
        window: args.window.or(first.window),
        ..first
    };
    let stream = Stream::new(args.data(&files)?, &files, args.memory, &options, console)?;
    if args.dry_run {
        let plan = Plan {
            files: &files,
            frf_bytes: stream.bytes(),
            parts: Some(stream.count()),
            memory: args.memory,
            outputs: vec![&args.output],
        };
        return Ok(plan.outcome());
    }
    let mut resume = Resume::new(
        Some(&args.output),
        &files,
        args.memory,
        args.echo(&options)?,
        args.resume,
    )?;
    let reducer = Reducer::new(&options, poles.as_ref())
        .map_err(|error| explain_piece(error, &options, &files[0]))?
        .with_reading(args.shared_reading());
    let stage = match reducer.is_second() {
        true => "second pass",
        false => "first pass",
    };
    let before = resume.take();
    let (partial, sources) = stream.with_sources(|| stream.pass(&reducer, before, &mut resume))?;
    let partial = partial
        .as_block(args.block as u64)
        .of_blocks(args.blocks.map(|count| count as u64))
        .with_sources(&sources);
    output.write_bytes(partial.to_bytes())?;
    resume.done();
    let text = format!(
        "{}: block {}, {}, {stage}\n",
        args.output.display(),
        args.block,
        counted(partial.frfs(), "FRF")
    );
    let json = json!({"output": shown(&args.output), "block": args.block, "frfs": partial.frfs(), "pass": pass(&partial)});
    Ok(Outcome::written(&args.output, json, text))
}

fn merge(args: &Merge, console: &Console) -> Result<Outcome> {
    let output = Output::new(&args.output, PARTIAL, &args.files, console)?;
    let mut merged: Option<Partial> = None;
    for path in &args.files {
        let partial = partial_of(path)?;
        merged = Some(match merged {
            Some(merged) => Partial::merge([merged, partial]).map_err(|error| error.file(path))?,
            None => partial,
        });
    }
    let merged = merged.expect("the command line asks for one");
    // others may be merged with it later
    let note = |missing: Finding| Finding {
        severity: Severity::Note,
        ..missing
    };
    merged
        .missing()
        .map(note)
        .iter()
        .for_each(|note| console.find(note));
    output.write_bytes(merged.to_bytes())?;
    let text = format!(
        "{}: {}, {}\n",
        args.output.display(),
        counted(merged.blocks(), "block"),
        counted(merged.frfs(), "FRF")
    );
    let json = json!({"output": shown(&args.output), "blocks": merged.blocks(), "frfs": merged.frfs(), "pass": pass(&merged)});
    Ok(Outcome::written(&args.output, json, text))
}

fn solved(args: &Solve, console: &Console) -> Result<Outcome> {
    let inputs = std::slice::from_ref(&args.file);
    let output = Output::new(&args.output, POLES_OR_MODEL, inputs, console)?;
    let partial = partial_of(&args.file)?;
    let wants_poles = extension_of(&args.output) == "poles";
    if wants_poles == partial.poles().is_some() {
        return Err(other_pass(args, wants_poles));
    }
    let options = options_of(&args.asked, partial.poles())?;
    partial
        .missing()
        .iter()
        .for_each(|missing| console.find(missing));
    let (sources, reading) = (partial.sources(), partial.reading().clone());
    let solved = solve(partial, &options, &|stage| console.stage(stage))
        .map_err(|error| explain_piece(error, &options, &args.file))?;
    match solved {
        Solved::Poles(poles) if wants_poles => poles_written(&poles, &args.output, &output),
        Solved::Poles(poles) => {
            let path = args.output.with_extension("poles");
            let output = Output::new(&path, POLES_OR_MODEL, inputs, console)?;
            let outcome = poles_written(&poles, &path, &output)?;
            let doubt = format!(
                "another pass is needed ({}): reduce all blocks once more, with --poles {}, then merge \
                 and solve",
                poles.evidence(),
                path.display()
            );
            Ok(outcome.doubted(Some(doubt)))
        }
        Solved::Fit(fit) => {
            let mut model = fit.model;
            model.source = sources;
            model.options = echo_of(&options);
            for (name, json) in reading {
                let value = serde_json::from_str(&json).unwrap_or_else(|_| json.as_str().into());
                model.options.insert(name, value);
            }
            written_model(&model, &args.output, &output, console)
        }
    }
}

/// The error of an output of the other kind: poles of a second pass, or a model of a first.
fn other_pass(args: &Solve, wants_poles: bool) -> Error {
    let (pass, expected) = if wants_poles {
        ("second", ".json or .h5, a model")
    } else {
        ("first", ".poles")
    };
    Error::new(
        ErrorKind::Usage,
        format!("the partial is of the {pass} pass"),
    )
    .file(&args.file)
    .field("-o")
    .found(args.output.display())
    .expected(expected)
    .help("a first pass leads to poles, a second to a model")
}

/// Writes poles to `path`, and lists them.
fn poles_written(poles: &Poles, path: &Path, output: &Output) -> Result<Outcome> {
    output.write_bytes(poles.to_bytes())?;
    let (json, text) = (poles_json(poles, path), poles_text(poles, path));
    Ok(Outcome::written(path, json, text))
}

/// The options for solving the pass of a partial; an option of the other pass is refused.
fn options_of(asked: &AskedModel, poles: Option<&Poles>) -> Result<FitOptions> {
    let (given, pass, other) = match poles {
        Some(_) => (asked.modes.map(|_| "--modes"), "second", "first"),
        None => {
            let of_second = [
                ("--damping", asked.damping.is_some()),
                ("--shapes", asked.shapes.is_some()),
                ("--exponential-window", asked.exponential_window.is_some()),
            ];
            (
                of_second
                    .iter()
                    .find(|(_, given)| *given)
                    .map(|(name, _)| *name),
                "first",
                "second",
            )
        }
    };
    if let Some(name) = given {
        return Err(Error::new(
            ErrorKind::Usage,
            format!("the option changes nothing in a {pass} pass"),
        )
        .field(name)
        .found(format!("a partial of the {pass} pass"))
        .expected(format!("a partial of the {other} pass"))
        .help(format!("give {name} where the {other} pass is solved")));
    }
    let asked = asked.options();
    Ok(match poles {
        Some(poles) => FitOptions {
            damping: asked.damping,
            shapes: asked.shapes,
            exponential_window_per_s: asked.exponential_window_per_s,
            ..poles.options()
        },
        None => asked,
    })
}

fn residues_of(args: &Residues, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    let output = Output::new(&args.output, MODEL, &files, console)?;
    let given = model_of(&args.model)?.ok_or_else(|| {
        Error::bad_data("the file holds no model")
            .file(&args.model)
            .field("--model")
            .found("measured data")
            .expected("a model")
    })?;
    let (frf, mut sources) = read_frf(&files, &args.reading, console)?;
    let options = FitOptions::default();
    let mut model = residues(&frf, &given, &options)
        .map_err(|error| explain_piece(error, &options, &files[0]))?;
    sources.push(chladni_console::input::source(&args.model)?);
    model.source = sources;
    args.reading.echo(&mut model.options);
    written_model(&model, &args.output, &output, console)
}

fn partial_of(path: &Path) -> Result<Partial> {
    Partial::from_bytes(&read_bytes(path)?).map_err(|error| error.file(path))
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// Number of the pass that made a partial.
fn pass(partial: &Partial) -> u8 {
    1 + u8::from(partial.poles().is_some())
}

fn poles_json(poles: &Poles, path: &Path) -> Value {
    let modes: Vec<Value> = poles
        .modes()
        .iter()
        .map(|(f, eta)| json!({"frequency_hz": f, "loss_factor": eta}))
        .collect();
    json!({"output": shown(path), "poles": poles.count(), "modes": modes, "evidence": poles.evidence()})
}

fn poles_text(poles: &Poles, path: &Path) -> String {
    let rows: Vec<Vec<String>> = poles
        .modes()
        .iter()
        .map(|(f, eta)| vec![significant(*f, 7), significant(*eta, 3)])
        .collect();
    let modes = rows.len();
    let listed = if rows.is_empty() {
        String::new()
    } else {
        table(&["frequency, Hz", "loss factor"], &rows)
    };
    format!(
        "{listed}{}: {} in the band, {} beside it, as far as the first pass tells; {}\n",
        path.display(),
        counted(modes, "mode"),
        counted(poles.count() - modes, "pole"),
        poles.evidence()
    )
}
