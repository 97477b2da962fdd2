//! `chladni info`: what is inside files, and what is wrong with it.

use crate::extent::Extent;
use crate::limits::SHOWN_ALIKE;
use chladni_console::input::{expand, read_weights, Reading};
use chladni_console::oddities;
use chladni_console::settings::{error_with_options, finding_with_options};
use chladni_console::table::{counted, shortened, significant, table};
use chladni_console::{Console, Outcome};
use chladni_frf::{warnings, Checksum, Dof, Error, Finding, FrfKind, Result};
use chladni_io::{
    assemble, checksum_of, list_document, read_field, read_model, DatasetInfo, Document,
    FileFormat, ReadOptions,
};
use serde_json::{json, Value};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Arguments of `info`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni info measurement.uff
  chladni info -v scans/                               every dataset by itself
  chladni info --json *.uff                            for programs")]
pub struct Args {
    /// Files of any format, folders, or patterns
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command: whatever can be listed is listed.
///
/// # Errors
/// The first error where nothing could be listed at all.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    console.stage("reading");
    let mut listings = Vec::new();
    let mut first_error = None;
    for file in &files {
        let listing = match list_document(file, &args.reading.options()) {
            Ok(document) => Listing::new(document, &args.reading.options()),
            Err(error) => match Listing::of_field(file) {
                Some(listing) => listing,
                None => {
                    let listing = Listing::of_error(file, &error);
                    first_error.get_or_insert(error);
                    listing
                }
            },
        };
        listings.push(listing);
    }
    match first_error {
        Some(error) if listings.iter().all(|listing| listing.format.is_none()) => {
            return Err(error)
        }
        _ => listings
            .iter()
            .for_each(|listing| console.find_all(&listing.all_findings())),
    }
    let doubt = listings
        .iter()
        .any(|listing| listing.damaged)
        .then(|| "some of it cannot be read: see above".to_owned());
    let json = json!({"files": listings.iter().map(Listing::json).collect::<Vec<_>>()});
    let text = match listings.len() > SHOWN_ALIKE && !console.verbose {
        true => {
            listings.iter().map(Listing::headline).collect::<String>()
                + "every dataset of each: -v\n"
        }
        false => listings
            .iter()
            .map(|listing| listing.text(console.verbose))
            .collect::<Vec<_>>()
            .join("\n"),
    };
    Ok(Outcome::shown(json, text).doubted(doubt))
}

/// The information on one file.
struct Listing {
    file: PathBuf,
    format: Option<FileFormat>,
    checksum: Option<Checksum>,
    frf_kind: Option<FrfKind>,
    nodes: usize,
    responses: Vec<Dof>,
    references: Vec<Dof>,
    axis: Option<String>,
    findings: Vec<Finding>,
    datasets: Vec<DatasetInfo>,
    damaged: bool,
}

impl Listing {
    /// The listing of a measured field; `None` where the file holds none.
    fn of_field(file: &Path) -> Option<Self> {
        let field = read_field(file).ok()?;
        let hz = significant(field.frequency_hz, 6);
        Some(Self {
            format: Some(FileFormat::Csv),
            checksum: checksum_of(file).ok(),
            responses: field.points.iter().map(|point| point.response).collect(),
            axis: Some(format!("a measured field at {hz} Hz")),
            ..Self::empty(file)
        })
    }

    fn empty(file: &Path) -> Self {
        Self {
            file: file.to_path_buf(),
            format: None,
            checksum: None,
            frf_kind: None,
            nodes: 0,
            responses: Vec::new(),
            references: Vec::new(),
            axis: None,
            findings: Vec::new(),
            datasets: Vec::new(),
            damaged: false,
        }
    }

    fn of_error(file: &Path, error: &Error) -> Self {
        Self {
            findings: vec![damage(error)],
            damaged: true,
            ..Self::empty(file)
        }
    }

    fn new(mut document: Document, options: &ReadOptions) -> Self {
        // an error that a dataset carries is listed with the dataset, not here
        let mut findings = std::mem::take(&mut document.warnings);
        let errors = std::mem::take(&mut document.errors);
        let beside = |error: &Error| {
            document.datasets.iter().any(|info| {
                error.line.is_some() && info.warnings.iter().any(|w| w.contains(&error.message))
            })
        };
        findings.extend(errors.iter().filter(|error| !beside(error)).map(damage));
        document
            .functions
            .iter_mut()
            .for_each(|function| function.warnings.clear());
        document
            .shapes
            .iter_mut()
            .for_each(|shape| shape.warnings.clear());
        let mut listing = Self {
            format: Some(document.format),
            checksum: document.checksum.clone(),
            nodes: document.geometry.nodes.len(),
            findings,
            datasets: std::mem::take(&mut document.datasets),
            damaged: !errors.is_empty(),
            ..Self::empty(&document.file)
        };
        let holds_model = document.format == FileFormat::Model
            || listing
                .datasets
                .iter()
                .any(|info| info.name.starts_with("/model/"));
        match document.format {
            _ if holds_model => listing.add_model(),
            FileFormat::Weights => listing.add_weights(),
            // no checksum: only the headers were read
            _ if document.checksum.is_none() => listing.add_headers(),
            _ => listing.add_set(document, options),
        }
        listing
    }

    fn add_weights(&mut self) {
        match read_weights(&self.file) {
            Ok(weights) => {
                self.axis = Some(format!(
                    "{} Hz, method {}",
                    significant(weights.frequency_hz, 6),
                    weights.method
                ));
                self.references = weights
                    .weights
                    .iter()
                    .map(|weight| weight.reference)
                    .collect();
                self.findings.extend(weights.findings.0);
            }
            Err(error) => self.refuse(&error),
        }
    }

    fn add_model(&mut self) {
        match read_model(&self.file) {
            Ok(model) => {
                self.frf_kind = Some(model.frf_kind);
                self.nodes = model.nodes.len();
                self.axis = Some(format!(
                    "band {} to {} Hz",
                    significant(model.band_hz[0], 6),
                    significant(model.band_hz[1], 6)
                ));
                (self.responses, self.references) = (model.responses, model.references);
            }
            Err(error) => self.refuse(&error),
        }
    }

    /// Adds the FRFs of a file whose headers alone were read.
    fn add_headers(&mut self) {
        let frfs: Vec<&DatasetInfo> = self
            .datasets
            .iter()
            .filter(|info| info.function.as_deref() == Some("frf"))
            .collect();
        let dofs = |name: fn(&DatasetInfo) -> &Option<String>| {
            let names: BTreeSet<&str> = frfs
                .iter()
                .filter_map(|info| name(info).as_deref())
                .collect();
            let mut dofs: Vec<Dof> = names
                .into_iter()
                .filter_map(|name| name.parse().ok())
                .collect();
            dofs.sort_unstable();
            dofs
        };
        let (responses, references) = (dofs(|info| &info.response), dofs(|info| &info.reference));
        self.frf_kind = frfs
            .first()
            .and_then(|info| info.frf_kind)
            .filter(|&kind| frfs.iter().all(|info| info.frf_kind == Some(kind)));
        (self.responses, self.references) = (responses, references);
    }

    /// Adds the FRFs of the file, read as by every other command.
    fn add_set(&mut self, document: Document, options: &ReadOptions) {
        let contents = match assemble(vec![document], options) {
            Ok(contents) => contents,
            Err(error) => return self.refuse(&error),
        };
        let prefix = format!("{}: ", self.file.display());
        self.findings
            .extend(contents.warnings.into_iter().map(|finding| Finding {
                text: finding.text.trim_start_matches(&prefix).to_owned(),
                ..finding
            }));
        let Some(frf) = contents.frf else { return };
        if frf.kind.is_none() {
            self.findings.push(
                Finding::caution("kind-unknown", "the file does not say its FRF kind")
                    .help("other commands need `frf_kind receptance|mobility|accelerance`"),
            );
        }
        self.findings.extend(oddities::of_set(&frf));
        self.findings.extend(oddities::of_listing(&frf));
        self.axis = (!frf.frequency_hz.is_empty()).then(|| Extent::of(&frf).axis());
        (self.frf_kind, self.responses, self.references) =
            (frf.kind, frf.responses, frf.references);
    }

    fn refuse(&mut self, error: &Error) {
        self.damaged = true;
        self.findings.push(damage(error));
    }

    /// Findings of the file and of its datasets, each with its place. A finding of several
    /// datasets is given once, with their number.
    fn all_findings(&self) -> Vec<Finding> {
        let file = self.file.display();
        let of_file = self.findings.iter().map(|finding| finding.about(&file));
        let mut alike: Vec<(&DatasetInfo, &Finding, usize)> = Vec::new();
        for info in &self.datasets {
            for finding in &info.warnings {
                match alike.iter_mut().find(|(_, known, _)| *known == finding) {
                    Some((.., count)) => *count += 1,
                    None => alike.push((info, finding, 1)),
                }
            }
        }
        let more = |count: usize| {
            if count > 1 {
                format!(" (and {})", counted(count - 1, "more dataset"))
            } else {
                String::new()
            }
        };
        let of_datasets = alike.iter().map(|(info, finding, count)| {
            let mut finding = finding.about(place(info)).about(&file);
            finding.text += &more(*count);
            finding
        });
        of_file.chain(of_datasets).collect()
    }

    fn json(&self) -> Value {
        let with_options: Vec<Finding> = self.findings.iter().map(finding_with_options).collect();
        let (sha256, blake3) = match &self.checksum {
            Some(Checksum::Sha256(digits)) => (Some(digits), None),
            Some(Checksum::Blake3(digits)) => (None, Some(digits)),
            None => (None, None),
        };
        json!({
            "file": self.file.display().to_string(),
            "format": self.format,
            "sha256": sha256,
            "blake3": blake3,
            "frf_kind": self.frf_kind,
            "nodes": self.nodes,
            "responses": self.responses,
            "references": self.references,
            "warnings": warnings(&with_options),
            "findings": with_options,
            "datasets": self.datasets,
        })
    }

    /// The first line of [`Self::text`].
    fn headline(&self) -> String {
        self.text(false)
            .lines()
            .next()
            .unwrap_or_default()
            .to_owned()
            + "\n"
    }

    fn text(&self, verbose: bool) -> String {
        let Some(format) = self.format else {
            return format!("{}: cannot be read\n", self.file.display());
        };
        let mut parts = vec![format!("{format:?}").to_lowercase()];
        parts.extend(self.frf_kind.map(|kind| kind.to_string()));
        for (dofs, noun) in [
            (&self.responses, "response"),
            (&self.references, "reference"),
        ] {
            let names: Vec<String> = dofs.iter().map(ToString::to_string).collect();
            if !names.is_empty() {
                parts.push(format!(
                    "{} ({})",
                    counted(names.len(), noun),
                    shortened(&names, 3)
                ));
            }
        }
        parts.extend(self.axis.clone());
        parts.push(counted(self.nodes, "node"));
        let heading = format!("{}: {}\n", self.file.display(), parts.join(", "));
        if self.datasets.is_empty() {
            return heading;
        }
        const HEADER: [&str; 9] = [
            "dataset",
            "line",
            "name",
            "function",
            "response",
            "reference",
            "values",
            "frequency, Hz",
            "warnings",
        ];
        // columns without a value are left out
        let rows = rows(&self.datasets, verbose);
        let is_filled = |column: &usize| rows.iter().any(|row| !row[*column].is_empty());
        let columns: Vec<usize> = (0..HEADER.len()).filter(is_filled).collect();
        let kept = |row: &Vec<String>| columns.iter().map(|&column| row[column].clone()).collect();
        let header: Vec<&str> = columns.iter().map(|&column| HEADER[column]).collect();
        heading
            + &table(
                &header,
                &rows.iter().map(kept).collect::<Vec<Vec<String>>>(),
            )
    }
}

/// An error as a finding of the file, in one line.
fn damage(error: &Error) -> Finding {
    let error = error_with_options(Error {
        file: None,
        ..error.clone()
    });
    Finding::fault(
        "damaged",
        error.to_string().replace("\n  help: ", "; help: "),
    )
}

fn place(info: &DatasetInfo) -> String {
    let name = info
        .number
        .map_or_else(|| info.name.clone(), |number| format!("dataset {number}"));
    match info.line {
        Some(line) => format!("{name}, line {line}"),
        None => name,
    }
}

/// A row for each dataset; a long run of alike ones is one row unless `verbose`.
fn rows(datasets: &[DatasetInfo], verbose: bool) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    let mut start = 0;
    while start < datasets.len() {
        let alike = |info: &&DatasetInfo| is_alike(info, &datasets[start]);
        let count = 1 + datasets[start + 1..].iter().take_while(alike).count();
        if count > SHOWN_ALIKE && !verbose {
            rows.push(run_row(&datasets[start..start + count]));
        } else {
            rows.extend(datasets[start..start + count].iter().map(row));
        }
        start += count;
    }
    rows
}

fn is_alike(a: &DatasetInfo, b: &DatasetInfo) -> bool {
    (a.number, &a.name, &a.function, a.values) == (b.number, &b.name, &b.function, b.values)
        && a.frequency_hz.is_none()
        && b.frequency_hz.is_none()
        && a.warnings == b.warnings
}

fn row(info: &DatasetInfo) -> Vec<String> {
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    vec![
        info.number
            .map(|number| number.to_string())
            .unwrap_or_default(),
        info.line.map(|line| line.to_string()).unwrap_or_default(),
        info.name.clone(),
        text(&info.function),
        text(&info.response),
        text(&info.reference),
        info.values
            .or(info.nodes)
            .map(|count| count.to_string())
            .unwrap_or_default(),
        info.frequency_hz
            .map(|hz| significant(hz, 6))
            .unwrap_or_default(),
        match info.warnings.as_slice() {
            [] => String::new(),
            warnings => counted(warnings.len(), "warning"),
        },
    ]
}

fn run_row(run: &[DatasetInfo]) -> Vec<String> {
    let different = |field: fn(&DatasetInfo) -> &Option<String>| {
        let mut names: Vec<&String> = run.iter().filter_map(|info| field(info).as_ref()).collect();
        names.sort_unstable();
        names.dedup();
        match names.as_slice() {
            [one] => one.to_string(),
            [] => String::new(),
            all => format!("{} different", all.len()),
        }
    };
    let mut row = row(&run[0]);
    row[2] = format!("{} ({} of them)", row[2], run.len());
    row[4] = different(|info| &info.response);
    row[5] = different(|info| &info.reference);
    row
}
