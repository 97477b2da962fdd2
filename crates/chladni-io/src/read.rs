//! Reading of files into documents, and of documents into one set.

use super::checksums::{checksum_of, checksum_of_bytes};
use super::paths::shortened;
use super::{
    assemble, csv, detect_format, expand_paths, function_name, hdf5, mat, numpy, read_model, uff,
    wav, Contents, DatasetInfo, Document, FileFormat, ReadOptions,
};
use crate::limits::{FIRST_NODE, LISTED_BY_HEADERS, PATHS_LISTED};
use chladni_frf::{Error, Finding, FrfSet, Mode, Reason, Result, Source, Trust};
use chladni_text::door::{read_bytes, size_of, KeptInputs};
use chladni_text::{json_error_in, read_text};
use std::path::{Path, PathBuf};

/// Reads everything in one file; errors of damaged datasets are in the document.
///
/// # Errors
/// [`chladni_frf::ErrorKind::NoInput`] without the file, [`chladni_frf::ErrorKind::BadData`] where
/// nothing in it can be listed.
pub fn read_document(path: &Path, options: &ReadOptions) -> Result<Document> {
    read_numbered(path, options, &mut 1)
}

/// Reads a file to list its datasets. A large universal file is not held in memory: its
/// document has neither functions nor shapes nor checksum, and a warning says so. Other files
/// are read as by [`read_document`].
///
/// # Errors
/// As [`read_document`].
pub fn list_document(path: &Path, options: &ReadOptions) -> Result<Document> {
    let _kept = KeptInputs::new();
    if size_of(path)? <= LISTED_BY_HEADERS || detect_format(path)? != FileFormat::Uff {
        return read_document(path, options);
    }
    let mut document = uff::scan(path, options)?;
    let size = LISTED_BY_HEADERS >> 20;
    document.warnings.push(Finding::note(
        "headers-only",
        format!(
            "larger than {size} MiB: its headers are listed; values and checksum were not read"
        ),
    ));
    Ok(document)
}

/// Reads all files, in the order given. FRFs in tables that name no DOF become responses 1, 2,
/// ... in that order.
///
/// # Errors
/// The first error of [`read_document`].
pub fn read_documents(paths: &[PathBuf], options: &ReadOptions) -> Result<Vec<Document>> {
    let mut next_node = FIRST_NODE;
    let read = |(number, path): (usize, &PathBuf)| {
        let own = ReadOptions {
            references: nodes_of_file(&options.references, number, paths.len()),
            responses: nodes_of_file(&options.responses, number, paths.len()),
            ..options.clone()
        };
        read_numbered(path, &own, &mut next_node)
    };
    paths.iter().enumerate().map(read).collect()
}

/// The nodes of a list for file `number` of `count`: its own, where the list has one for each.
pub(super) fn nodes_of_file(nodes: &[u64], number: usize, count: usize) -> Vec<u64> {
    match nodes {
        nodes if nodes.len() > 1 && nodes.len() == count => vec![nodes[number]],
        nodes => nodes.to_vec(),
    }
}

/// Reads the content of files, folders and patterns together, with or without FRFs, as
/// `convert` and `info` need it.
///
/// # Errors
/// As [`expand_paths`], [`read_documents`] and [`assemble()`].
pub fn read_contents(paths: &[PathBuf], options: &ReadOptions) -> Result<Contents> {
    let _kept = KeptInputs::new();
    let inputs = expand_paths(paths)?;
    let mut contents = assemble(read_documents(&inputs.files, options)?, options)?;
    contents.warnings.splice(0..0, inputs.warnings);
    Ok(contents)
}

/// The word for a result of this program among files, if there is one.
fn result_among(documents: &[Document]) -> Option<&'static str> {
    documents.iter().find_map(|document| match document.format {
        FileFormat::Weights => Some("a weights file"),
        FileFormat::Model => Some("a model"),
        _ if document
            .datasets
            .iter()
            .any(|info| info.name.starts_with("/model/")) =>
        {
            Some("a model")
        }
        _ => None,
    })
}

/// The finding about arrays that may have been meant as FRFs.
fn unread_arrays(documents: &[Document]) -> Option<Finding> {
    let mut findings = documents.iter().flat_map(|document| &document.warnings);
    let is_told =
        |finding: &&Finding| ["no-frequency-axis", "real-array"].contains(&&*finding.code);
    findings.find(is_told).cloned()
}

/// Names of the datasets in files.
fn listed(documents: &[Document]) -> String {
    let mut names: Vec<String> = documents
        .iter()
        .flat_map(|document| &document.datasets)
        .map(|info| info.name.clone())
        .collect();
    names.dedup();
    if names.is_empty() {
        "nothing".into()
    } else {
        shortened(&names, PATHS_LISTED)
    }
}

/// Reads the FRFs of files, folders and patterns as one set. Returns with it the sources and
/// the findings.
///
/// # Errors
/// As [`read_contents`]; [`chladni_frf::ErrorKind::BadData`] where no file holds an FRF.
pub fn read_frf(
    paths: &[PathBuf],
    options: &ReadOptions,
) -> Result<(FrfSet, Vec<Source>, Vec<Finding>)> {
    let _kept = KeptInputs::new();
    let inputs = expand_paths(paths)?;
    let documents = read_documents(&inputs.files, options)?;
    let (result, listed) = (result_among(&documents), listed(&documents));
    let unread = unread_arrays(&documents);
    let Contents {
        frf,
        sources,
        mut warnings,
        functions,
        ..
    } = assemble(documents, options)?;
    warnings.splice(0..0, inputs.warnings);
    let frf = frf.ok_or_else(|| {
        let error = Error::bad_data("no FRF in the input").expected(
            "functions of type 4 (58), a complex array beside its frequencies (HDF5, NumPy, \
             MATLAB) or a table f,re,im",
        );
        let error = match paths {
            [one] => error.file(one),
            _ => error,
        };
        match (functions.first(), result) {
            (Some(function), _) => error
                .found(format!(
                    "{} other functions, the first a {}",
                    functions.len(),
                    function_name(function.function_type)
                ))
                .help(
                    "look at the contents of the file; where they are time records, estimate \
                     FRFs first",
                ),
            (None, Some(result)) => error.found(result).help(
                "give the measured FRFs that it was \
                made from",
            ),
            (None, None) => match unread {
                Some(Finding { text, help, .. }) if !help.is_empty() => {
                    error.found(text).help(help)
                }
                found => error
                    .found(found.map_or(listed, |finding| finding.text))
                    .help(
                        "look at the contents of the file; name arrays (HDF5, NumPy, MATLAB) \
                         with `map frf=PATH,freq=PATH`",
                    ),
            },
        }
    })?;
    Ok((frf, sources, warnings))
}

/// Reads a file; FRFs in tables that name no DOF are numbered from `next_node` on.
///
/// # Errors
/// As [`read_document`].
pub(super) fn read_numbered(
    path: &Path,
    options: &ReadOptions,
    next_node: &mut u64,
) -> Result<Document> {
    let _kept = KeptInputs::new();
    let format = detect_format(path)?;
    // the checksum of a file in memory needs no second read
    let bytes = match format {
        FileFormat::Hdf5 | FileFormat::Model | FileFormat::Weights => None,
        _ => Some(read_bytes(path)?),
    };
    let hash = || match &bytes {
        Some(bytes) => Ok(checksum_of_bytes(bytes)),
        None => checksum_of(path),
    };
    std::thread::scope(|scope| {
        let beside = std::thread::Builder::new().spawn_scoped(scope, hash);
        let bytes = bytes.as_deref().unwrap_or_default();
        let mut document = match format {
            FileFormat::Uff => uff::read(bytes, path, options)?,
            FileFormat::Csv => csv::read(bytes, path, options, next_node)?,
            FileFormat::Hdf5 => hdf5::read(path, options)?,
            FileFormat::Matlab => mat::read(bytes, path, options)?,
            FileFormat::Numpy if bytes.starts_with(crate::signatures::NPY_SIGNATURE) => {
                numpy::read_npy(bytes, path, options)?
            }
            FileFormat::Numpy => numpy::read_npz(bytes, path, options)?,
            FileFormat::Wav => wav::read(bytes, path)?,
            FileFormat::Model => model_document(path)?,
            FileFormat::Weights => weights_document(path)?,
        };
        // a system that starts no more threads costs time, not the file
        document.checksum = Some(match beside {
            Ok(thread) => thread.join().unwrap_or_else(|_| checksum_of(path))?,
            Err(_) => hash()?,
        });
        Ok(document)
    })
}

/// A model file as `info` lists it: one entry per mode.
fn model_document(path: &Path) -> Result<Document> {
    let model = read_model(path)?;
    let listed = model.modes.iter().map(|mode| DatasetInfo {
        name: if mode.in_band {
            "mode"
        } else {
            "pole outside the band"
        }
        .into(),
        values: Some(model.responses.len()),
        frequency_hz: Some(mode.frequency_hz),
        damping_ratio: Some(mode.damping_ratio),
        warnings: if mode.trust == Trust::Sure {
            Vec::new()
        } else {
            doubts(mode)
        },
        ..DatasetInfo::default()
    });
    Ok(Document {
        datasets: listed.collect(),
        geometry: model.geometry(),
        warnings: model.quality.findings.clone(),
        ..Document::new(path, FileFormat::Model)
    })
}

/// The reasons against a mode, as findings.
fn doubts(mode: &Mode) -> Vec<Finding> {
    let doubt = |reason: &Reason| Finding {
        code: reason.code.clone(),
        ..Finding::from(reason.to_string())
    };
    mode.reasons.iter().map(doubt).collect()
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
    let text = read_text(path, "a weights file, JSON")?;
    let weights: Weights = serde_json::from_str(&text)
        .map_err(|error| json_error_in(&text, "weights", &error).file(path))?;
    let listed = weights.weights.into_iter().map(|weight| DatasetInfo {
        name: "weight".into(),
        reference: Some(weight.reference),
        values: Some(1),
        frequency_hz: Some(weights.frequency_hz),
        ..DatasetInfo::default()
    });
    Ok(Document {
        datasets: listed.collect(),
        ..Document::new(path, FileFormat::Weights)
    })
}
