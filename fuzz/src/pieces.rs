//! The state that an interrupted run left, with any head and any content: taken up, or
//! refused.

#[path = "../../crates/chladni-cli/src/streaming/resume.rs"]
pub mod resume;

use crate::questions::FRFS;
use crate::scenes::is_said;
use chladni_rfp::pieces::{solve, Partial, PieceError, Reducer};
use chladni_rfp::FitOptions;
use resume::Resume;
use serde_json::{json, Map};
use sha2::{Digest, Sha256};
use std::path::Path;

/// A partial is solved once in so many executions: that takes milliseconds.
const SOLVED_ONE_IN: u8 = 16;
/// Number of the block that a run goes on with.
const NEXT: u64 = 5;

/// Bytes as the file of an interrupted run: a first line, and behind it the content of a
/// partial, whose own head with its checksum is made here.
pub fn resumed(path: &Path, bytes: &[u8]) {
    let end = bytes
        .iter()
        .position(|byte| *byte == b'\n')
        .unwrap_or(bytes.len());
    let content = bytes.get(end + 1..).unwrap_or_default();
    let digest = Sha256::digest(content);
    let hexadecimal: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    let head = json!({"format": "chladni.partial", "version": 3, "created_by": "", "bytes": content.len(), "sha256": hexadecimal});
    let whole = [
        &bytes[..end],
        b"\n",
        head.to_string().as_bytes(),
        b"\n",
        content,
    ]
    .concat();
    std::fs::write(path.with_extension("json.resume"), whole).unwrap();
    let mut options = Map::new();
    options.insert("band_hz".into(), json!([50.0, 70.0]));
    match Resume::new(
        Some(&path.with_extension("json")),
        &[],
        1 << 20,
        options,
        true,
    ) {
        Err(error) => is_said(&error),
        Ok(mut resume) => {
            if let Some(partial) = resume.take() {
                goes_on(partial, digest[0] % SOLVED_ONE_IN == 0);
            }
        }
    }
}

/// A partial that was accepted is written as it was read, reduced further, and solved.
fn goes_on(partial: Partial, solved: bool) {
    let bytes = partial.to_bytes();
    let again = Partial::from_bytes(&bytes).expect("what was written is read");
    assert_eq!(again.to_bytes(), bytes);
    let options = FitOptions::default();
    let said = |error: PieceError| match error {
        PieceError::Data(error) => is_said(&error),
        PieceError::Fit(error) => is_said(&error.told(&options, str::to_owned)),
    };
    let next = Reducer::of(&options, &partial).and_then(|pass| pass.block(&FRFS, NEXT, Vec::new()));
    match next {
        Err(error) => said(error),
        Ok(next) => {
            if let Err(error) = Partial::merge([again, next]) {
                is_said(&error);
            }
        }
    }
    if solved {
        if let Err(error) = solve(&partial, &options, &|_| {}) {
            said(error);
        }
    }
}
