//! From paths to documents, and from documents to one set.

use super::{assemble, csv, detect_format, hdf5, read_model, uff, Contents, DatasetInfo, Document, FileFormat, ReadOptions};
use crate::{Error, ErrorKind, FrfSet, Geometry, Result, Source, Trust};
use sha2::{Digest, Sha256};
use std::cmp::Ordering;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Everything in one file, by content; damaged datasets are in its `errors`.
///
/// # Errors
/// [`ErrorKind::NoInput`] without the file, [`ErrorKind::BadData`] where nothing in it can be listed.
pub fn read_document(path: &Path, options: &ReadOptions) -> Result<Document> {
    read_numbered(path, options, &mut 1)
}

/// All files, in the order given. FRFs in tables that name no DOF become responses 1, 2, ... in that order.
///
/// # Errors
/// The first of [`read_document`].
pub fn read_documents(paths: &[PathBuf], options: &ReadOptions) -> Result<Vec<Document>> {
    let mut next_node = 1;
    let per_file = options.references.len() > 1 && options.references.len() == paths.len();
    let read = |(number, path): (usize, &PathBuf)| {
        let own = per_file.then(|| ReadOptions { references: vec![options.references[number]], ..options.clone() });
        read_numbered(path, own.as_ref().unwrap_or(options), &mut next_node)
    };
    paths.iter().enumerate().map(read).collect()
}

/// Everything that files, folders and patterns hold together: what `convert` and `info` need, without FRFs too.
///
/// # Errors
/// As [`expand_paths`], [`read_documents`] and [`assemble()`].
pub fn read_contents(paths: &[PathBuf], options: &ReadOptions) -> Result<Contents> {
    let documents = read_documents(&expand_paths(paths)?, options)?;
    assemble(documents, options)
}

/// The FRFs of files, folders and patterns as one set, with the files and everything the user must know.
///
/// # Errors
/// As [`read_contents`]; [`ErrorKind::BadData`] where no file holds an FRF.
pub fn read_frf(paths: &[PathBuf], options: &ReadOptions) -> Result<(FrfSet, Vec<Source>, Vec<String>)> {
    let contents = read_contents(paths, options)?;
    let Contents { frf, sources, warnings, functions, .. } = contents;
    let frf = frf.ok_or_else(|| {
        let error = Error::bad_data("no FRF in the input").expected("functions of type 4 (58), a complex array (HDF5) or a table f,re,im");
        let error = match paths {
            [one] => error.file(one),
            _ => error,
        };
        match functions.first() {
            Some(function) => error
                .found(format!("{} other functions, the first a {}", functions.len(), super::function_name(function.function_type)))
                .help("`chladni info` lists what is inside; `chladni estimate` makes FRFs of time records"),
            None => error.help("`chladni info` lists what is inside; in HDF5 name the arrays with --map frf=PATH,freq=PATH"),
        }
    })?;
    Ok((frf, sources, warnings))
}

/// Files as they are; a folder stands for all its files, a name with `*` or `?` for what fits, both in natural order
/// (`point_2` before `point_10`). Hidden files are left out.
///
/// # Errors
/// [`ErrorKind::NoInput`] for an empty folder, or a pattern that nothing fits.
pub fn expand_paths(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if path.is_dir() {
            let found = files_in(path, "*")?;
            if found.is_empty() {
                return Err(Error::new(ErrorKind::NoInput, "the folder has no files").file(path));
            }
            files.extend(found);
        } else if name.contains(['*', '?']) && !path.exists() {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
            let found = files_in(folder, &name)?;
            if found.is_empty() {
                return Err(Error::new(ErrorKind::NoInput, "no file fits the pattern").file(path));
            }
            files.extend(found);
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

fn files_in(folder: &Path, pattern: &str) -> Result<Vec<PathBuf>> {
    let on_read = |error: std::io::Error| Error::from_read(&error, folder);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(on_read)? {
        let path = entry.map_err(on_read)?.path();
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if path.is_file() && !name.starts_with('.') && fits(&name, pattern) {
            found.push((name, path));
        }
    }
    found.sort_by(|(a, _), (b, _)| natural_order(a, b));
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// `*` for any text, `?` for one character.
fn fits(name: &str, pattern: &str) -> bool {
    let (name, pattern): (Vec<char>, Vec<char>) = (name.chars().collect(), pattern.chars().collect());
    // reachable[k]: the pattern up to here fits the first k characters
    let mut reachable = vec![false; name.len() + 1];
    reachable[0] = true;
    for symbol in pattern {
        if symbol == '*' {
            for k in 1..=name.len() {
                reachable[k] |= reachable[k - 1];
            }
        } else {
            for k in (1..=name.len()).rev() {
                reachable[k] = reachable[k - 1] && (symbol == '?' || symbol == name[k - 1]);
            }
            reachable[0] = false;
        }
    }
    reachable[name.len()]
}

/// Runs of digits compare as numbers.
fn natural_order(a: &str, b: &str) -> Ordering {
    let key = |text: &str| {
        let mut parts: Vec<(bool, usize, String)> = Vec::new();
        for c in text.chars() {
            let digit = c.is_ascii_digit();
            match parts.last_mut().filter(|(is_number, ..)| *is_number == digit) {
                Some((.., part)) => part.push(c),
                None => parts.push((digit, 0, c.to_string())),
            }
        }
        for (is_number, length, part) in &mut parts {
            if *is_number {
                *part = part.trim_start_matches('0').to_owned();
                *length = part.len();
            }
        }
        parts
    };
    key(a).cmp(&key(b)).then_with(|| a.cmp(b))
}

fn read_numbered(path: &Path, options: &ReadOptions, next_node: &mut u64) -> Result<Document> {
    let bytes = || fs::read(path).map_err(|error| Error::from_read(&error, path));
    let mut document = match detect_format(path)? {
        FileFormat::Uff => {
            let bytes = bytes()?;
            let mut document = uff::read(&bytes, path, options)?;
            document.sha256 = hexadecimal(Sha256::digest(&bytes));
            document
        }
        FileFormat::Csv => {
            let bytes = bytes()?;
            let mut document = csv::read(&bytes, path, options, next_node)?;
            document.sha256 = hexadecimal(Sha256::digest(&bytes));
            document
        }
        FileFormat::Hdf5 => hdf5::read(path, options)?,
        FileFormat::Model => model_document(path)?,
        FileFormat::Weights => weights_document(path)?,
    };
    if document.sha256.is_empty() {
        document.sha256 = sha256_of(path)?;
    }
    Ok(document)
}

/// SHA-256 of a file, hexadecimal.
///
/// # Errors
/// Those of reading.
pub fn sha256_of(path: &Path) -> Result<String> {
    let on_read = |error: std::io::Error| Error::from_read(&error, path);
    let mut file = fs::File::open(path).map_err(on_read)?;
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 20];
    loop {
        match file.read(&mut block).map_err(on_read)? {
            0 => return Ok(hexadecimal(hash.finalize())),
            count => hash.update(&block[..count]),
        }
    }
}

fn hexadecimal(bytes: impl AsRef<[u8]>) -> String {
    bytes.as_ref().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn empty_document(path: &Path, format: FileFormat) -> Document {
    Document {
        file: path.to_path_buf(),
        format,
        sha256: String::new(),
        geometry: Geometry::default(),
        datasets: Vec::new(),
        frf: None,
        functions: Vec::new(),
        errors: Vec::new(),
        warnings: Vec::new(),
    }
}

/// A model file as `info` lists it: one entry per mode.
fn model_document(path: &Path) -> Result<Document> {
    let model = read_model(path)?;
    let listed = model.modes.iter().map(|mode| DatasetInfo {
        number: None,
        line: None,
        name: if mode.in_band { "mode" } else { "pole outside the band" }.into(),
        function: None,
        response: None,
        reference: None,
        values: Some(model.responses.len()),
        nodes: None,
        frequency_hz: Some(mode.frequency_hz),
        damping_ratio: Some(mode.damping_ratio),
        warnings: if mode.trust == Trust::Sure { Vec::new() } else { mode.reasons.clone() },
    });
    Ok(Document {
        datasets: listed.collect(),
        geometry: Geometry { nodes: model.nodes.clone(), ..Geometry::default() },
        warnings: model.quality.warnings.clone(),
        ..empty_document(path, FileFormat::Model)
    })
}

/// A weights file as `info` lists it: one entry per reference.
fn weights_document(path: &Path) -> Result<Document> {
    #[derive(serde::Deserialize)]
    struct Weight {
        reference: String,
    }
    #[derive(serde::Deserialize)]
    struct Weights {
        frequency_hz: f64,
        weights: Vec<Weight>,
    }
    let text = fs::read_to_string(path).map_err(|error| Error::from_read(&error, path))?;
    let weights: Weights = serde_json::from_str(text.trim_start_matches('\u{feff}'))
        .map_err(|error| Error::bad_data(format!("weights: {error}")).file(path).at_line(error.line() as u64))?;
    let listed = weights.weights.into_iter().map(|weight| DatasetInfo {
        number: None,
        line: None,
        name: "weight".into(),
        function: None,
        response: None,
        reference: Some(weight.reference),
        values: Some(1),
        nodes: None,
        frequency_hz: Some(weights.frequency_hz),
        damping_ratio: None,
        warnings: Vec::new(),
    });
    Ok(Document { datasets: listed.collect(), ..empty_document(path, FileFormat::Weights) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_as_in_a_shell() {
        for (name, pattern, expected) in [
            ("scan_1.uff", "*.uff", true),
            ("scan_1.uff", "scan_?.uff", true),
            ("scan_12.uff", "scan_?.uff", false),
            ("scan", "*a*", true),
            ("", "*", true),
            ("a", "", false),
        ] {
            assert_eq!(fits(name, pattern), expected, "{name} {pattern}");
        }
    }

    #[test]
    fn numbers_in_names_are_ordered_as_numbers() {
        let mut names = ["p10.csv", "p2.csv", "p1.csv", "q1.csv", "p02.csv"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["p1.csv", "p02.csv", "p2.csv", "p10.csv", "q1.csv"]);
    }
}
