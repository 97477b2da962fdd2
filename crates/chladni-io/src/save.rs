//! Writing of measured data, in the format of the extension.

use super::atomic::write_atomically;
use super::mat::MatFile;
use super::{csv, hdf5, numpy, uff, vtk, Contents};
use chladni_frf::{BlockWindow, Error, ErrorKind, Estimation, Finding, Forcing, FrfSet, Result};
use std::borrow::Cow;
use std::path::Path;

/// Extensions of measured data, for messages.
const KNOWN: &str =
    ".h5, .hdf5, .npz, .mat, .csv, .txt, .uff, .ufb, .bunv, .unv, .uf, .vtu or .pvd";

/// Writes a set. Returns findings on losses: content that the format cannot hold.
///
/// | extension | format |
/// |---|---|
/// | `.h5`, `.hdf5` | HDF5, lossless |
/// | `.npz` | NumPy, lossless, no geometry |
/// | `.mat` | MATLAB 5, lossless, no geometry |
/// | `.csv`, `.txt` | text table, numbers in the digits of their precision, no geometry |
/// | `.uff`, `.ufb`, `.bunv` | universal file with binary functions (58b): values lossless |
/// | `.unv` | universal file with text functions (58), for programs that read no other: 13 digits |
/// | `.uf` | the same with the old datasets 15 and 55 |
/// | `.vtu` | nodes, lines, faces and shapes for ParaView; `.pvd` with one `.vtu` per shape |
///
/// # Errors
/// [`ErrorKind::Usage`] for another extension; else as [`write_atomically`].
pub fn write_frf(path: &Path, frf: &FrfSet, force: bool) -> Result<Vec<Finding>> {
    write(path, Some(frf), &Contents::default(), force)
}

/// Writes all of `contents` that the format can hold. Returns findings on the rest.
/// Extensions as for [`write_frf`].
///
/// # Errors
/// As [`write_frf`].
pub fn write_contents(path: &Path, contents: &Contents, force: bool) -> Result<Vec<Finding>> {
    write(path, contents.frf.as_ref(), contents, force)
}

fn write(
    path: &Path,
    frf: Option<&FrfSet>,
    contents: &Contents,
    force: bool,
) -> Result<Vec<Finding>> {
    match extension_of(path).as_str() {
        "h5" | "hdf5" => hdf5::write(path, frf, contents, force).map(|()| Vec::new()),
        "csv" | "txt" => write_table(path, frf, contents, force),
        "npz" => write_arrays(path, frf, contents, force),
        "mat" => {
            let set = needed(path, frf, "a MATLAB file")?;
            let file = MatFile::of_set(set).map_err(|error| error.file(path))?;
            write_atomically(path, force, |out| file.write(out))?;
            Ok(left_out("a MATLAB file", set, contents))
        }
        "uff" | "ufb" | "bunv" => write_universal(
            path,
            frf,
            contents,
            uff::WriteOptions {
                binary: true,
                old_datasets: false,
            },
            force,
        ),
        "unv" => write_universal(path, frf, contents, uff::WriteOptions::default(), force),
        "uf" => write_universal(
            path,
            frf,
            contents,
            uff::WriteOptions {
                binary: false,
                old_datasets: true,
            },
            force,
        ),
        "vtu" => vtk::write_vtu(path, contents, force),
        "pvd" => vtk::write_pvd(path, contents, force),
        _ => Err(unknown_extension(path, KNOWN)),
    }
}

fn write_arrays(
    path: &Path,
    frf: Option<&FrfSet>,
    contents: &Contents,
    force: bool,
) -> Result<Vec<Finding>> {
    let set = needed(path, frf, "a NumPy archive")?;
    numpy::write(path, set, force)?;
    Ok(left_out("a NumPy archive", set, contents))
}

/// The set; an error where there is none and the format holds only FRFs.
fn needed<'a>(path: &Path, frf: Option<&'a FrfSet>, format: &str) -> Result<&'a FrfSet> {
    frf.ok_or_else(|| {
        Error::new(
            ErrorKind::Usage,
            format!("there is no FRF to write, and {format} holds nothing else"),
        )
        .file(path)
        .found("no FRF")
        .expected("at least one FRF")
        .help("write HDF5 (.h5) or a universal file (.uff)")
    })
}

/// Findings on what a format of FRFs alone cannot hold.
fn left_out(format: &str, set: &FrfSet, contents: &Contents) -> Vec<Finding> {
    let mut lost = Vec::new();
    if !set.geometry.nodes.is_empty() {
        lost.push(Finding::caution(
            "not-carried",
            format!(
                "{format} holds no geometry: {} nodes are left out",
                set.geometry.nodes.len()
            ),
        ));
    }
    lost.extend(set.variance.as_ref().map(|_| lost_variance(format)));
    lost.extend(
        set.estimation
            .as_ref()
            .and_then(|made| lost_estimation(format, made)),
    );
    if !contents.functions.is_empty() {
        lost.push(Finding::caution(
            "not-carried",
            format!(
                "{format} holds FRFs only: {} other functions are left out",
                contents.functions.len()
            ),
        ));
    }
    if !contents.shapes.is_empty() {
        lost.push(Finding::caution(
            "not-carried",
            format!(
                "{format} holds FRFs only: {} shapes are left out",
                contents.shapes.len()
            ),
        ));
    }
    lost
}

fn lost_variance(format: &str) -> Finding {
    Finding::caution(
        "not-carried",
        format!("{format} holds no variances: those of the FRFs are left out (HDF5 holds them)"),
    )
}

/// The finding about an estimation that a format does not hold, with the setting that gives it
/// to a fit by hand; `None` where a fit needs none.
fn lost_estimation(format: &str, made: &Estimation) -> Option<Finding> {
    let leaks = made
        .forcing
        .is_none_or(|forcing| forcing == Forcing::Continuous);
    let (lost, advice) = match (made.window, made.added_decay_per_s()) {
        _ if made.estimator.is_local() => (
            "that no window broadens their lines".into(),
            "`window none`".into(),
        ),
        (_, Some(rate)) => (
            format!("the exponential window, which raises every decay by {rate} 1/s"),
            format!("`exponential_window {rate}`"),
        ),
        (BlockWindow::Rectangular, None) if !leaks => return None,
        (window, None) => (format!("the {} window", window.name()), "its window".into()),
    };
    let words = format!(
        "{format} does not hold how the FRFs were estimated: {lost} (HDF5 and universal files do)"
    );
    Some(Finding::caution("not-carried", words).help(format!("say {advice} when you fit")))
}

fn write_table(
    path: &Path,
    frf: Option<&FrfSet>,
    contents: &Contents,
    force: bool,
) -> Result<Vec<Finding>> {
    let set = needed(path, frf, "a text table")?;
    write_atomically(path, force, |out| csv::write(out, set))?;
    let mut lost = left_out("a text table", set, contents);
    let (responses, references) = unmeasured(set);
    for (count, what) in [(responses, "responses"), (references, "references")] {
        if count > 0 {
            lost.push(Finding::caution(
                "not-carried",
                format!("{count} {what} without any FRF are left out of the table"),
            ));
        }
    }
    Ok(lost)
}

/// Responses and references of which no pair was measured.
fn unmeasured(set: &FrfSet) -> (usize, usize) {
    let missing = set.missing_pairs();
    let full = |total: usize, others: usize, axis: fn(&(usize, usize)) -> usize| {
        let mut counts = vec![0; total];
        missing.iter().for_each(|pair| counts[axis(pair)] += 1);
        counts.into_iter().filter(|&count| count == others).count()
    };
    let (responses, references) = (set.responses.len(), set.references.len());
    (
        full(responses, references, |pair| pair.0),
        full(references, responses, |pair| pair.1),
    )
}

fn write_universal(
    path: &Path,
    frf: Option<&FrfSet>,
    contents: &Contents,
    options: uff::WriteOptions,
    force: bool,
) -> Result<Vec<Finding>> {
    let whole = match (&contents.frf, frf) {
        (None, Some(frf)) => Cow::Owned(Contents {
            frf: Some(frf.clone()),
            ..Contents::default()
        }),
        _ => Cow::Borrowed(contents),
    };
    let plan = uff::Plan::new(&whole, options).map_err(|error| error.file(path))?;
    write_atomically(path, force, |out| plan.write(out))?;
    let variance = whole.frf.as_ref().and_then(|set| set.variance.as_ref());
    Ok(plan
        .warnings()
        .iter()
        .cloned()
        .chain(variance.map(|_| lost_variance("a universal file")))
        .collect())
}

/// Extension of a path in lower case, without the dot; empty where it has none.
pub fn extension_of(path: &Path) -> String {
    path.extension()
        .map(|extension| extension.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default()
}

/// The error of an output with an unknown extension.
pub(super) fn unknown_extension(path: &Path, known: &str) -> Error {
    Error::new(
        ErrorKind::Usage,
        "the extension of the output names no format that can be written",
    )
    .file(path)
    .found(
        path.extension()
            .map_or("none".into(), |extension| extension.to_string_lossy()),
    )
    .expected(known)
    .help("the extension of the output decides the format")
}
