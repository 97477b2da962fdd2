//! Detection of formats by content, never by the name of the file.

use super::{csv, FileFormat};
use crate::limits::{HEAD_BYTES, TABLE_HEAD_BYTES};
use crate::signatures::{is_npz, MAT_SIGNATURE, NPY_SIGNATURE};

use chladni_frf::{Error, ErrorKind, Result, MODEL_FORMAT};
use chladni_text::door;
use chladni_text::{json_error, json_format, json_kind};
use serde::Deserialize;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// First eight bytes of every HDF5 file, at offset 0, 512, 1024, 2048, ... (a user block
/// may stand before them).
const HDF5_SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// The formats that can be read, for messages.
const KNOWN: &str =
    "a universal file, HDF5, MATLAB, NumPy, a text table, WAV, or a model or weights as JSON";
/// Numbers of datasets that universal files begin with.
const DATASETS: [&str; 12] = [
    "15", "18", "55", "58", "82", "151", "164", "780", "2411", "2412", "2414", "2420",
];
/// Value of `format` in a weights file.
const WEIGHTS_FORMAT: &str = "chladni.weights";

/// The format of `file`, from its content.
///
/// * universal file: the first line that is not blank is `-1`
/// * HDF5: its signature at byte 0, 512, 1024, 2048, ...
/// * MATLAB 5 to 7, NumPy: their signatures (NPZ: a zip archive whose first entry is an
///   array)
/// * JSON: an object whose `format` is `chladni.model` or `chladni.weights`
/// * everything else that is text: a table
///
/// # Errors
/// [`chladni_frf::ErrorKind::NoInput`] without the file; [`chladni_frf::ErrorKind::BadData`] for an
/// empty file, a universal file below other lines, other JSON and other binary files, with
/// the way to export what can be read. Other files of this program are called by their kind.
pub fn detect_format(file: &Path) -> Result<FileFormat> {
    let on_read = |error: std::io::Error| Error::from_read(&error, file);
    let mut input = door::open(file)?;
    let mut head = Vec::with_capacity(HEAD_BYTES);
    input
        .by_ref()
        .take(HEAD_BYTES as u64)
        .read_to_end(&mut head)
        .map_err(on_read)?;
    if head.is_empty() {
        return Err(Error::bad_data("the file is empty")
            .file(file)
            .at_byte(0)
            .found("0 bytes")
            .expected("measured data, a model or weights")
            .help("export or copy it again"));
    }
    if has_hdf5_signature(&mut input).map_err(on_read)? {
        return Ok(FileFormat::Hdf5);
    }
    if is_universal(&head) {
        return Ok(FileFormat::Uff);
    }
    if is_universal(&with_line_feeds(&head)) {
        return Err(
            Error::bad_data("a universal file whose lines end with CR alone")
                .file(file)
                .at_line(1)
                .found("a carriage return without a line feed")
                .expected("lines that end with LF or CR LF")
                .help("export it again, or convert it: tr '\\r' '\\n' < old.unv > new.unv"),
        );
    }
    if is_wide_text(&head) && is_universal(csv::decode(&head).as_bytes()) {
        return Err(Error::bad_data(
            "a universal file in UTF-16; its columns are counted in bytes",
        )
        .file(file)
        .at_byte(0)
        .found("the mark of UTF-16")
        .expected("ASCII, Latin-1 or UTF-8")
        .help("save it as ASCII or UTF-8, or export it again"));
    }
    if head.starts_with(MAT_SIGNATURE) {
        return Ok(FileFormat::Matlab);
    }
    if head.starts_with(NPY_SIGNATURE) || is_npz(&head) {
        return Ok(FileFormat::Numpy);
    }
    if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WAVE") {
        return Ok(FileFormat::Wav);
    }
    if let Some(error) = universal_without_its_first_line(&head) {
        return Err(error.file(file));
    }
    if let Some(error) = foreign_binary(&head) {
        return Err(error.file(file));
    }
    if text_start(&head).first() == Some(&b'{') {
        input.seek(SeekFrom::Start(0)).map_err(on_read)?;
        let mut bytes = Vec::new();
        input.read_to_end(&mut bytes).map_err(on_read)?;
        return format_of_json(text_start(&bytes)).map_err(|error| error.file(file));
    }
    Ok(FileFormat::Csv)
}

/// The reason why no reader can read `file`, in words; `None` where one can. For files of a
/// folder, which the user did not name one by one.
///
/// # Errors
/// Those of reading.
pub(super) fn not_readable(file: &Path) -> Result<Option<String>> {
    match detect_format(file) {
        Ok(FileFormat::Csv) => {
            let on_read = |error: std::io::Error| Error::from_read(&error, file);
            let mut head = Vec::new();
            door::open(file)?
                .take(TABLE_HEAD_BYTES)
                .read_to_end(&mut head)
                .map_err(on_read)?;
            Ok((!csv::is_table(&head)).then(|| "text without rows of numbers".into()))
        }
        Ok(_) => Ok(None),
        Err(Error {
            kind: ErrorKind::BadData,
            message,
            found,
            ..
        }) => {
            Ok(Some(found.map_or(message.clone(), |found| {
                format!("{message}: {found}")
            })))
        }
        Err(error) => Err(error),
    }
}

fn has_hdf5_signature(input: &mut File) -> std::io::Result<bool> {
    let length = input.metadata()?.len();
    let mut offset = 0_u64;
    while offset.saturating_add(8) <= length {
        let mut bytes = [0; 8];
        input.seek(SeekFrom::Start(offset))?;
        input.read_exact(&mut bytes)?;
        if bytes == HDF5_SIGNATURE {
            return Ok(true);
        }
        offset = if offset == 0 {
            512
        } else {
            offset.saturating_mul(2)
        };
    }
    Ok(false)
}

/// True for a universal file: its first line is `-1`, right-justified in columns 1 to 6.
fn is_universal(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let first_line = text
        .split(|&byte| byte == b'\n')
        .map(<[u8]>::trim_ascii)
        .find(|line| !line.is_empty());
    first_line == Some(b"-1")
}

/// The text with a line feed in place of each carriage return.
fn with_line_feeds(head: &[u8]) -> Vec<u8> {
    let line_feed = |&byte: &u8| if byte == b'\r' { b'\n' } else { byte };
    head.iter().map(line_feed).collect()
}

/// The error of a universal file below a title, or without its first delimiter line, whose
/// columns would be taken for those of a table.
fn universal_without_its_first_line(head: &[u8]) -> Option<Error> {
    // in columns 1 to 6; a `b` may follow
    let is_dataset = |line: &[u8]| {
        let number = line.get(..6).map(<[u8]>::trim_ascii_start);
        let is_known = |known: &&str| number == Some(known.as_bytes());
        matches!(line.get(6), None | Some(b'b')) && DATASETS.iter().any(is_known)
    };
    // a number above a table is its count of points, not a dataset
    let is_row = |line: &[u8]| {
        let first = line.trim_ascii_start().first();
        first.is_none_or(|byte| byte.is_ascii_digit() || b"+-.,".contains(byte))
    };
    let text = |line: Option<(usize, &[u8])>| {
        String::from_utf8_lossy(line.map_or(b"", |(_, line)| line)).into_owned()
    };
    let mut lines = head
        .split(|&byte| byte == b'\n')
        .map(<[u8]>::trim_ascii_end)
        .enumerate()
        .filter(|(_, line)| !line.is_empty());
    let mut before: Option<&[u8]> = None;
    while let Some((at, line)) = lines.next() {
        let is_below = match before {
            Some(before) => before.trim_ascii() == b"-1",
            None => {
                let mut below = lines.clone();
                let next = below.next();
                next.is_some_and(|(_, next)| !is_row(next))
                    && !csv::is_header(&text(next), &text(below.next()))
            }
        };
        if is_below && is_dataset(line) {
            return Some(
                Error::bad_data("a universal file whose first line is not -1")
                    .at_line(at as u64 + 1)
                    .found(format!(
                        "dataset {}",
                        String::from_utf8_lossy(line.trim_ascii())
                    ))
                    .expected("`    -1` as the first line, right in front of the first dataset")
                    .help(
                        "delete the lines above it, add `    -1` where it is missing, or export \
                           the file again",
                    ),
            );
        }
        before = Some(line);
    }
    None
}

/// True for text that begins with the byte-order mark of UTF-16.
fn is_wide_text(head: &[u8]) -> bool {
    head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff")
}

fn foreign_binary(head: &[u8]) -> Option<Error> {
    let refuse = |found: &str, help: &str| {
        Some(
            Error::bad_data("not a format that can be read")
                .at_byte(0)
                .found(found)
                .expected(KNOWN)
                .help(help),
        )
    };
    if head.starts_with(b"PK\x03\x04") {
        return refuse(
            "a zip archive or spreadsheet",
            "unpack it, or export the sheet as CSV",
        );
    }
    if is_wide_text(head) {
        return None; // full of zero bytes
    }
    if !head.contains(&0) {
        return None;
    }
    own_binary(head).or_else(|| {
        refuse(
            "a binary file of unknown kind",
            "export universal file (UFF 58), CSV or HDF5 from the program that wrote it",
        )
    })
}

/// The error of a binary file of this program: its first line is JSON that names the kind.
fn own_binary(bytes: &[u8]) -> Option<Error> {
    let first_line = bytes.split(|&byte| byte == b'\n').next()?;
    let format = json_format(std::str::from_utf8(first_line).ok()?)?;
    json_kind(&format).map(|_| other_json(Some(&format)))
}

/// The text after a byte-order mark and blanks.
fn text_start(bytes: &[u8]) -> &[u8] {
    bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start()
}

fn format_of_json(bytes: &[u8]) -> Result<FileFormat> {
    #[derive(Deserialize)]
    struct Header {
        format: Option<String>,
    }
    let header: Header = serde_json::from_slice(bytes).map_err(|error| {
        // the first line of such a file may be longer than its head
        own_binary(bytes).unwrap_or_else(|| {
            json_error("begins like JSON", &error).help("copy or write the file again")
        })
    })?;
    match header.format.as_deref() {
        Some(MODEL_FORMAT) => Ok(FileFormat::Model),
        Some(WEIGHTS_FORMAT) => Ok(FileFormat::Weights),
        other => Err(other_json(other)),
    }
}

/// The error of JSON that is neither a model nor weights, by its kind where it is known.
fn other_json(format: Option<&str>) -> Error {
    let message = match format.and_then(json_kind) {
        Some(kind) => format!("{kind}, neither measured data nor a model nor weights"),
        None => "JSON of unknown format".into(),
    };
    let advice = match format {
        Some("chladni.calibration") => {
            "a calibration file of Chladni says what a rig was found to do: name it as \
             `calibration` in a scene"
        }
        Some("chladni.signal") => {
            "it says which actuator is on which channel of the sound file beside it: give the \
             model or the data that the signal was made with"
        }
        Some("chladni.comparison") => "give one of the models that were compared",
        Some("chladni.partial") => "merge it with the partials of the other blocks, and solve them",
        Some("chladni.poles") => "reduce the blocks again with these poles",
        Some("chladni.resume") => "repeat the interrupted fit, and let it go on from there",
        Some(own) if own.starts_with("chladni.") => {
            "it is no data: give it where such a file is asked for"
        }
        _ => {
            "give a model or weights that this program wrote, or export the data as a universal \
             file, HDF5 or a table"
        }
    };
    Error::bad_data(message)
        .field("format")
        .found(format.unwrap_or("nothing"))
        .expected(format!("{MODEL_FORMAT} or {WEIGHTS_FORMAT}"))
        .help(advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format_of(bytes: &[u8]) -> Result<FileFormat> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        detect_format(file.path())
    }

    #[test]
    fn content_decides() {
        assert_eq!(format_of(b"    -1\n   151\n").unwrap(), FileFormat::Uff);
        assert_eq!(
            format_of(b"\r\n    -1      \r\n    58\r\n").unwrap(),
            FileFormat::Uff
        );
        assert_eq!(
            format_of(b"\xef\xbb\xbf    -1\n    58\n").unwrap(),
            FileFormat::Uff
        );
        assert_eq!(format_of(b"\x89HDF\r\n\x1a\n").unwrap(), FileFormat::Hdf5);
        let mut behind_user_block = b"MATLAB 7.3 MAT-file".to_vec();
        behind_user_block.resize(512, 0);
        behind_user_block.extend(HDF5_SIGNATURE);
        assert_eq!(format_of(&behind_user_block).unwrap(), FileFormat::Hdf5);
        assert_eq!(
            format_of(b"\xef\xbb\xbf{\"format\": \"chladni.model\"}").unwrap(),
            FileFormat::Model
        );
        assert_eq!(
            format_of(b" {\"version\": 1, \"format\": \"chladni.weights\"}").unwrap(),
            FileFormat::Weights
        );
        assert_eq!(
            format_of(b"MATLAB 5.0 MAT-file, Platform: GLNXA64").unwrap(),
            FileFormat::Matlab
        );
        assert_eq!(format_of(b"\x93NUMPY\x01\x00").unwrap(), FileFormat::Numpy);
        assert_eq!(format_of(b"f,re,im\n1,2,3\n").unwrap(), FileFormat::Csv);
        assert_eq!(format_of(b"-1,2,3\n").unwrap(), FileFormat::Csv);
        for counted in [
            &b"    15\n1 2 3\n"[..],
            b"    15\nf re im\n1 2 3\n",
            b"    15\nf re im\nHz m/s/N m/s/N\n1 2 3\n",
            b"    58\nt 1:+Z\n0 1\n1 2\n",
        ] {
            assert_eq!(format_of(counted).unwrap(), FileFormat::Csv);
        }
        assert_eq!(format_of(b"\xff\xfef\0,\0").unwrap(), FileFormat::Csv);
    }

    #[test]
    fn other_files_of_this_program_are_called_by_their_kind() {
        let inputs = "\"scan.h5\",".repeat(HEAD_BYTES);
        let long_first_line =
            format!("{{\"format\":\"chladni.resume\",\"inputs\":[{inputs}0]}}\n\0").into_bytes();
        for (bytes, kind, advice) in [
            (
                &b"{\n  \"version\": 1,\n  \"format\": \"chladni.calibration\"}"[..],
                "a calibration file, neither measured data nor a model",
                "a calibration file of Chladni",
            ),
            (
                b"{\"format\": \"chladni.signal\"}",
                "the sidecar of a signal, neither",
                "sound file",
            ),
            (
                &long_first_line,
                "the state of an interrupted fit, neither",
                "go on from there",
            ),
            (
                b"{\"format\": \"chladni.comparison\"}",
                "a comparison of models, neither",
                "models that were compared",
            ),
            (
                b"{\"format\":\"chladni.partial\",\"bytes\":2}\n\x00\x01",
                "a partial of a fit in pieces, neither",
                "other blocks",
            ),
            (
                b"{\"format\":\"chladni.poles\"}\n\x00",
                "poles of a fit in pieces, neither",
                "blocks again",
            ),
            (
                b"{\"format\":\"chladni.resume\"}\n{}\n\x00",
                "the state of an interrupted fit, neither",
                "go on from there",
            ),
        ] {
            let error = format_of(bytes).unwrap_err();
            assert!(error.message.starts_with(kind), "{error}");
            assert_eq!(error.field.as_deref(), Some("format"), "{error}");
            assert!(error.found.is_some() && error.expected.is_some(), "{error}");
            assert!(error.help.unwrap().contains(advice), "{kind}");
        }
        let foreign = format_of(b"{\"format\":\"music\"}\n\x00").unwrap_err();
        assert_eq!(foreign.message, "not a format that can be read");
    }

    #[test]
    fn what_cannot_be_read_says_how_to_export_it() {
        for (bytes, words) in [
            (&b""[..], "empty"),
            (b"PK\x03\x04xl/", "CSV"),
            (b"\x01\x00\x02", "UFF 58"),
            (b"{\"format\": \"other\"}", "chladni.model"),
            (b"{\"format\": ", "line 1"),
            (b"\xff\xfe \0 \0 \0 \0-\x001\0\n\0", "UTF-16"),
            (b"Export of XYZ\r\n    -1\r\n    58\r\nNONE\r\n", "line 3"),
            (b"    58\nNONE\nNONE\n", "first line is not -1"),
            (b"    -1\r   151\rNONE\r", "end with CR alone"),
            (
                b"    58\nFrequency response\n22-Jul-26\n",
                "first line is not -1",
            ),
        ] {
            let error = format_of(bytes).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
        assert_eq!(
            detect_format(Path::new("/no/such/file")).unwrap_err().kind,
            chladni_frf::ErrorKind::NoInput
        );
    }
}
