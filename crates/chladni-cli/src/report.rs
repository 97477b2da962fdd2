//! `chladni report`: models and weights as one HTML page, and its views as files.

use crate::curves::curves;
use crate::in_time::in_time;
use chladni_console::input::{expand, read_frf, read_weights, source, Reading};
use chladni_console::output::{make_folder, Output, HTML, PICTURE, TABLE};
use chladni_console::quoting::shell_path;
use chladni_console::table::{counted, shortened};
use chladni_console::{unbroken, Console, Outcome};
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result, Source};
use chladni_io::{detect_format, extension_of, try_place, FileFormat};
use chladni_render::{evaluate, Evaluation, On, Played, Scene, Weights};
use chladni_report::{
    charts, html, unlike, ChartFormats, Curves, RenderedScene, ReportInput, Table,
};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Method of the models that `simulate` writes; their source is a panel, not FRFs.
const SIMULATED: &str = "simulate";

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni report model.json -o report.html
  chladni report model.json weights-*.json -o report.html
  chladni report model.json bench/accuracy.csv -o report.html     with a table of `chladni bench`: speed against accuracy
  chladni report model.json weights.json --charts figures         every view as SVG and PNG, for papers

The page needs no network and no other file. In it: FRFs of any pair, stabilization diagram (click poles to keep or drop
them, copy the TOML for `chladni select`), pole table, MAC, moving shapes, fields, weights, curves, stress, and a board to
draw a scene on (copy the TOML for `chladni render`). Files that the results name as their sources (the measured FRFs, the
model, the scene) are shown too where they still lie beside them, or in a folder beside them, unchanged.")]
pub struct Args {
    /// At most one model, any number of weights, and tables that `chladni bench` wrote
    /// (.csv)
    #[arg(required = true, value_name = "MODEL|WEIGHTS|TABLE")]
    files: Vec<PathBuf>,
    /// Page to write
    #[arg(
        short,
        long,
        value_name = "report.html",
        required_unless_present = "charts"
    )]
    output: Option<PathBuf>,
    /// FRFs that the model was fitted to, where they lie elsewhere now
    #[arg(long, value_name = "FRF", num_args = 1..)]
    measured: Vec<PathBuf>,
    /// Folder to write every view into, as SVG and PNG files
    #[arg(long, value_name = "DIR")]
    charts: Option<PathBuf>,
}

/// Weights with the field that they make, where scene and model are at hand.
struct ShownWeights {
    weights: Weights,
    evaluation: Option<Evaluation>,
    curves: Option<Curves>,
    time: Option<Played>,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing; more than one model.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let output = Output::asked("-o", args.output.as_deref(), HTML, &args.files, console)?;
    if let Some(folder) = &args.charts {
        make_folder(folder, "--charts")?;
        unbroken(|| try_place(&folder.join("figure"), true))?;
    }
    console.stage("reading");
    let contents = Contents::read(&args.files, &args.measured, console)?;
    let input = contents.input(chladni_text::file_name(&args.files[0]), console);

    console.stage("drawing");
    if let Some(output) = &output {
        let page = html(&input)?;
        console.stage("writing");
        output.write_bytes(page)?;
    }
    let pictures = match &args.charts {
        Some(folder) => write_charts(folder, &input, console)?,
        None => 0,
    };
    let sources = args
        .files
        .iter()
        .map(|file| source(file))
        .collect::<Result<Vec<_>>>()?;
    let modes = input.model.map_or(0, |model| model.in_band_modes().count());
    let place = |path: &Option<PathBuf>| path.as_ref().map(|path| path.display().to_string());
    let json = json!({
        "output": place(&args.output),
        "charts": place(&args.charts),
        "pictures": pictures,
        "source": sources,
        "modes": modes,
        "measured": input.measured.is_some(),
        "scenes": input.scenes.len(),
        "tables": input.tables.len(),
    });
    let written = args
        .output
        .as_ref()
        .or(args.charts.as_ref())
        .unwrap_or(&args.files[0]);
    let mut text = format!(
        "{}: {}, {}",
        written.display(),
        counted(modes, "mode"),
        counted(input.scenes.len(), "scene")
    );
    if let Some(folder) = &args.charts {
        text += &format!("; {} in {}", counted(pictures, "picture"), folder.display());
    }
    Ok(Outcome::written(written, json, text + "\n"))
}

/// The content of the files that a report shows.
pub struct Contents {
    /// The model; that of the weights where none is named.
    pub model: Option<ModalModel>,
    /// The name of its file, as one word of a shell; that of standard input is not known.
    model_file: Option<String>,
    /// The FRFs that it was fitted to.
    pub measured: Option<FrfSet>,
    shown: Vec<ShownWeights>,
    tables: Vec<Table>,
}

impl Contents {
    /// Reads `files`, and their sources that lie unchanged beside them. The FRFs come from
    /// `measured` where that names any.
    ///
    /// # Errors
    /// Those of reading; more than one model.
    pub fn read(files: &[PathBuf], measured: &[PathBuf], console: &Console) -> Result<Self> {
        let NamedFiles {
            model,
            weights,
            tables,
        } = sorted(files)?;
        let of_weights = |(file, weights): &(PathBuf, Weights)| {
            let sources = beside(file, &weights.source);
            sources.into_iter().find(|path| is_model(path))
        };
        let model_file = model.or_else(|| weights.iter().find_map(of_weights));
        let model = model_file
            .as_deref()
            .map(chladni_io::read_model)
            .transpose()?;
        let measured = match (&model_file, &model) {
            (_, Some(model)) if !measured.is_empty() => {
                Some(measured_by_user(measured, model, console)?)
            }
            (Some(file), Some(model)) => measured_beside(file, model, console),
            _ => None,
        };
        let mut shown = Vec::new();
        for (file, weights) in weights {
            shown.extend(show(&file, weights, model.as_ref(), console)?);
        }
        let is_named = |file: &&PathBuf| file.as_os_str() != "-";
        let name = |file: &PathBuf| file.file_name().map(|name| shell_path(Path::new(name)));
        Ok(Self {
            model_file: model_file.as_ref().filter(is_named).and_then(name),
            model,
            measured,
            shown,
            tables,
        })
    }

    /// The input of the report.
    pub fn input(&self, title: String, console: &Console) -> ReportInput<'_> {
        ReportInput {
            title,
            model: self.model.as_ref(),
            model_file: self.model_file.clone(),
            measured: self.measured.as_ref(),
            scenes: self.shown.iter().map(ShownWeights::scene).collect(),
            tables: self.tables.clone(),
            findings: console.findings(),
        }
    }
}

/// Writes every view as SVG and PNG, and returns how many there are.
fn write_charts(folder: &Path, input: &ReportInput, console: &Console) -> Result<usize> {
    console.stage("drawing the charts");
    let files = charts(
        input,
        ChartFormats {
            svg: true,
            png: true,
            gif: true,
        },
    )?;
    let places: Vec<PathBuf> = files.iter().map(|(name, _)| folder.join(name)).collect();
    // all places are checked before the first file is written
    let outputs = places
        .iter()
        .map(|path| Output::new(path, PICTURE, &[], console))
        .collect::<Result<Vec<_>>>()?;
    for (output, (_, bytes)) in outputs.iter().zip(&files) {
        output.write_bytes(bytes)?;
    }
    Ok(files.len())
}

/// The named files by what they hold.
#[derive(Default)]
struct NamedFiles {
    model: Option<PathBuf>,
    weights: Vec<(PathBuf, Weights)>,
    tables: Vec<Table>,
}

fn sorted(files: &[PathBuf]) -> Result<NamedFiles> {
    let mut named = NamedFiles::default();
    for file in files {
        if let Some(table) = bench_table(file)? {
            named.tables.push(table);
            continue;
        }
        match detect_format(file)? {
            FileFormat::Weights => named.weights.push((file.clone(), read_weights(file)?)),
            FileFormat::Model | FileFormat::Hdf5 if named.model.is_none() => {
                named.model = Some(file.clone());
            }
            FileFormat::Model | FileFormat::Hdf5 => {
                return Err(Error::new(ErrorKind::Usage, "a report shows one model")
                    .file(file)
                    .found("a second model")
                    .expected("one model and any number of weights")
                    .help("make one report for each model"))
            }
            other => {
                return Err(chladni_io::not_a_model(file, other)
                    .expected("models, weights, or tables of `chladni bench`"))
            }
        }
    }
    Ok(named)
}

/// First columns of the tables that `chladni bench` writes.
const TABLE_STARTS: [&str; 2] = ["case,method,", "scene,method,"];

/// The table in a .csv file that `chladni bench` wrote; `None` for any other file.
fn bench_table(file: &Path) -> Result<Option<Table>> {
    if !TABLE.contains(&extension_of(file).as_str()) {
        return Ok(None);
    }
    let text = chladni_text::read_text(file, "a table of `chladni bench`, CSV")?;
    let mut lines = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    let Some(header) = lines
        .next()
        .filter(|line| TABLE_STARTS.iter().any(|start| line.starts_with(start)))
    else {
        return Ok(None);
    };
    Ok(Some(Table {
        name: chladni_text::file_name(file),
        header: cells(header),
        rows: lines.map(cells).collect(),
    }))
}

/// Cells of a line of CSV; a comma in quotation marks belongs to its cell.
fn cells(line: &str) -> Vec<String> {
    let (mut out, mut quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => out.push(String::new()),
            plain => out.last_mut().expect("there is always a cell").push(plain),
        }
    }
    out
}

fn is_model(path: &Path) -> bool {
    matches!(detect_format(path), Ok(FileFormat::Model))
}

/// The sources of a result that lie beside it, or in a folder beside it, unchanged.
fn beside(result: &Path, sources: &[Source]) -> Vec<PathBuf> {
    let folder = match result.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let folders: Vec<PathBuf> = std::iter::once(folder.clone())
        .chain(subfolders(&folder))
        .collect();
    let of = |source: &Source| {
        let place = |folder: &PathBuf| folder.join(&source.file);
        folders.iter().map(place).find(|path| {
            path.is_file()
                && chladni_io::checksum_of(path).is_ok_and(|found| found == source.checksum)
        })
    };
    sources.iter().filter_map(of).collect()
}

/// Folders inside a folder, in order, without hidden ones.
fn subfolders(folder: &Path) -> Vec<PathBuf> {
    let is_hidden = |path: &PathBuf| {
        path.file_name()
            .is_none_or(|name| name.to_string_lossy().starts_with('.'))
    };
    let entries = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()));
    let mut folders: Vec<PathBuf> = entries
        .filter(|path| path.is_dir() && !is_hidden(path))
        .collect();
    folders.sort();
    folders
}

/// The FRFs of the files that the user names, read as the model's own FRFs were. A finding
/// tells where the model does not explain them.
///
/// # Errors
/// Those of reading; no FRF that the model has.
pub fn measured_by_user(
    files: &[PathBuf],
    model: &ModalModel,
    console: &Console,
) -> Result<FrfSet> {
    let reading = Reading::from_echo(&model.options);
    let (frf, sources) = read_frf(&expand(files, console)?, &reading, console)?;
    let is_same = |source: &Source| {
        model
            .source
            .iter()
            .any(|known| known.checksum == source.checksum)
    };
    if !sources.iter().all(is_same) {
        console.find_all(unlike(model, &frf)?.iter());
    }
    Ok(frf)
}

/// The FRFs that the model in `file` was fitted to, read as they were then; `None` where one
/// of their files does not lie beside it or has changed.
pub fn measured_beside(file: &Path, model: &ModalModel, console: &Console) -> Option<FrfSet> {
    if model.source.is_empty() || model.method == SIMULATED {
        return None;
    }
    // `select` adds the model it started from and the selection
    let selected = model
        .options
        .get("selections")
        .and_then(|list| list.as_array())
        .map_or(0, Vec::len);
    let fitted = &model.source[..model.source.len().saturating_sub(2 * selected)];
    let files = beside(file, fitted);
    if files.len() < fitted.len() {
        let names: Vec<String> = fitted.iter().map(|source| source.file.clone()).collect();
        let names = shortened(&names, 3);
        let words = format!(
            "the measured FRFs ({names}) do not lie beside the model, unchanged: its synthesis \
             alone is shown"
        );
        console
            .find(&Finding::caution("measured-not-found", words).help("name them with `measured`"));
        return None;
    }
    match chladni_io::read_frf(&files, &Reading::from_echo(&model.options).options()) {
        Ok((frf, ..)) => Some(frf),
        Err(error) => {
            let words = format!(
                "the measured FRFs cannot be read: {}; the model's synthesis alone is shown",
                error.message
            );
            console.find(&Finding::caution("measured-not-found", words));
            None
        }
    }
}

/// The weights of each tone, with field and curves where the scene lies beside the file.
fn show(
    file: &Path,
    mut weights: Weights,
    model: Option<&ModalModel>,
    console: &Console,
) -> Result<Vec<ShownWeights>> {
    let scene = beside(file, &weights.source)
        .into_iter()
        .find(|path| path.file_name().is_some_and(|name| *name == *weights.scene));
    let whole = weights.clone();
    let other_tones = std::mem::take(&mut weights.other_tones);
    let several = !other_tones.is_empty();
    let tones = std::iter::once(weights).chain(other_tones);
    let without_field = |weights: Weights| ShownWeights {
        weights,
        evaluation: None,
        curves: None,
        time: None,
    };
    match (scene, model) {
        (Some(scene), Some(model)) => {
            let scene = Scene::read(&scene)?;
            let mut played = said_in_time(model, &scene, &whole, console);
            tones
                .map(|weights| show_tone(weights, model, &scene, several, &mut played))
                .collect::<Result<_>>()
                .map_err(|error| error.file(file))
        }
        (None, _) => {
            let shown: Vec<ShownWeights> = tones.map(without_field).collect();
            let words = format!(
                "{}: this scene does not lie beside the weights, unchanged: no field is shown",
                shown[0].weights.scene
            );
            console.find(&Finding::caution("scene-not-found", words));
            Ok(shown)
        }
        (Some(_), None) => Ok(tones.map(without_field).collect()),
    }
}

/// A tone of weights with its field and curves; the first one takes the scene in time.
fn show_tone(
    weights: Weights,
    model: &ModalModel,
    scene: &Scene,
    several: bool,
    played: &mut Option<Played>,
) -> Result<ShownWeights> {
    let evaluation = Some(evaluate(&weights, scene, On::Model(model))?);
    let tone = scene.tone_at(weights.frequency_hz);
    let curves = Some(curves(model, tone.as_ref().unwrap_or(scene), &weights)?);
    let scene = if several {
        format!("{}, {} Hz", weights.scene, weights.frequency_hz)
    } else {
        weights.scene
    };
    Ok(ShownWeights {
        weights: Weights { scene, ..weights },
        evaluation,
        curves,
        time: played.take(),
    })
}

/// The scene in time; a finding tells why a scene cannot be played.
fn said_in_time(
    model: &ModalModel,
    scene: &Scene,
    weights: &Weights,
    console: &Console,
) -> Option<Played> {
    in_time(model, scene, weights).unwrap_or_else(|error| {
        let words = format!(
            "{}: the scene cannot be shown in time: {}",
            weights.scene, error.message
        );
        console.find(&Finding::caution("scene-not-in-time", words));
        None
    })
}

impl ShownWeights {
    fn scene(&self) -> RenderedScene<'_> {
        match &self.evaluation {
            Some(evaluation) => {
                RenderedScene::of_evaluation(&self.weights, evaluation, "the model")
                    .with_curves(self.curves.as_ref())
                    .with_time(self.time.as_ref())
            }
            None => RenderedScene::of_weights(&self.weights),
        }
    }
}
