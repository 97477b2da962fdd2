//! Checks of a reader with any bytes; shared by the seeded mutations and by the targets
//! that coverage guides (`fuzz/`).

use chladni_frf::ErrorKind;
use chladni_io::{
    assemble, read_document, read_model, uff, write_contents, write_json, Contents, Document,
    ReadOptions,
};
use std::path::Path;

/// Bytes as a universal file, strictly, and leniently where that finds a fault: counts
/// are those that are there, the list made without the values is that of the file, and
/// what is written of it is read again.
pub fn universal(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let scanned = uff::scan(path, &ReadOptions::default());
    if let Ok(document) = uff::read(bytes, path, &ReadOptions::default()) {
        declared_is_read(bytes, &document);
        listed_is_read(scanned.as_ref().unwrap(), &document);
        let is_sound = document.errors.is_empty();
        let Document {
            functions,
            shapes,
            geometry: other_geometry,
            ..
        } = document.clone();
        let contents = Contents {
            functions,
            shapes,
            other_geometry,
            ..Contents::default()
        };
        for binary in [true, false] {
            written_is_read(path, &contents, binary);
        }
        if is_sound {
            if let Ok(merged) = assemble(vec![document], &ReadOptions::default()) {
                written_is_read(path, &merged, true);
            }
            return;
        }
    }
    let lenient = ReadOptions {
        lenient: true,
        snap_df: true,
        ..ReadOptions::default()
    };
    let _ = uff::read(bytes, path, &lenient);
    let _ = uff::scan(path, &lenient);
}

/// Bytes as any file, read, merged and written.
pub fn any_file(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    for lenient in [false, true] {
        let options = ReadOptions {
            lenient,
            ..ReadOptions::default()
        };
        let Ok(document) = read_document(path, &options) else {
            continue;
        };
        for error in &document.errors {
            assert!(!error.message.is_empty());
        }
        let Ok(contents) = assemble(vec![document], &options) else {
            continue;
        };
        written_is_read(path, &contents, true);
        let again = path.with_extension("again.h5");
        match write_contents(&again, &contents, true) {
            Ok(_) => drop(read_document(&again, &ReadOptions::default()).unwrap()),
            Err(error) => assert_ne!(error.kind, ErrorKind::Internal, "{error}"),
        }
        // what needs no leniency is read in the same way with it
        return;
    }
}

/// Bytes as any file, a model among them.
pub fn any_file_or_model(path: &Path, bytes: &[u8]) {
    any_file(path, bytes);
    if let Ok(model) = read_model(path) {
        let mut again = Vec::new();
        write_json(&mut again, &model).unwrap();
        std::fs::write(path, again).unwrap();
        assert_eq!(read_model(path).unwrap(), model, "what was written is read");
    }
}

/// Bytes as a selection of modes.
pub fn selection(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let _ = chladni_io::read_selection(path);
}

/// Checks that all that can be written as a universal file is read again.
fn written_is_read(path: &Path, contents: &Contents, binary: bool) {
    let mut again = Vec::new();
    match uff::write(
        &mut again,
        contents,
        uff::WriteOptions {
            binary,
            old_datasets: false,
        },
    ) {
        Ok(_) => {
            let read = uff::read(&again, path, &ReadOptions::default()).unwrap();
            assert_eq!(read.errors, [], "what was written is read");
            if contents.frf.is_none() {
                assert_eq!(
                    (read.functions.len(), read.shapes.len()),
                    (contents.functions.len(), contents.shapes.len())
                );
            }
        }
        Err(error) => assert_ne!(error.kind, ErrorKind::Internal, "{error}"),
    }
}

/// The count that record 7 declares is the count that was read, whatever else is wrong
/// with the file.
fn declared_is_read(bytes: &[u8], document: &Document) {
    let lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
    for function in &document.functions {
        // marker, number, five ID lines, record 6, record 7; blank lines may stand before
        // the number
        let Some(number) =
            (function.line as usize..lines.len()).find(|&k| !lines[k].trim_ascii().is_empty())
        else {
            continue;
        };
        let Some(record) = lines
            .get(number + 7)
            .filter(|_| lines[number].trim_ascii().starts_with(b"58"))
        else {
            continue;
        };
        let count = |field: &[u8]| {
            std::str::from_utf8(field)
                .ok()
                .and_then(|text| text.trim().parse::<usize>().ok())
        };
        // by column, or between blanks where a change has moved the columns
        let by_column = record.get(10..20).and_then(count);
        let by_blanks = record
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .nth(1)
            .and_then(count);
        if let (Some(by_column), Some(by_blanks)) = (by_column, by_blanks) {
            let read = function.ordinate.len();
            assert!(
                by_column == read || by_blanks == read,
                "declared {by_column} or {by_blanks}, read {read}, line {}",
                function.line
            );
        }
    }
}

/// The list of a file whose values are passed over is that of the file; it finds no fault
/// where there is none.
fn listed_is_read(scanned: &Document, read: &Document) {
    if read.errors.is_empty() {
        let listed = |document: &Document| {
            document
                .datasets
                .iter()
                .map(|info| (info.number, info.values, info.nodes))
                .collect::<Vec<_>>()
        };
        assert_eq!(scanned.errors, []);
        assert_eq!(listed(scanned), listed(read));
        assert_eq!(scanned.geometry, read.geometry);
    }
}
