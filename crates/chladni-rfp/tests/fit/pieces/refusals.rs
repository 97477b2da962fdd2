//! Pieces that do not belong together, and files that are damaged, are refused by name.

use super::blocks::{blocks, reduced, rows, set};
use chladni_rfp::pieces::{reduce, solve, Partial, Solved};
use chladni_rfp::{Effort, FitOptions};

#[test]
fn pieces_that_do_not_belong_together_are_refused_by_name() {
    let set = set();
    let parts = reduced(&blocks(&set.frf, 2), None);
    let error = |partials: Vec<Partial>| Partial::merge(partials).unwrap_err().to_string();
    assert!(error(Vec::new()).contains("nothing to merge"));
    let twice = error(vec![parts[0].clone(), parts[0].clone()]);
    assert!(twice.contains("block occurs twice"), "{twice}");

    let block = rows(&set.frf, 0..10);
    let with = |options: FitOptions| reduce(&block, &options, 7, Vec::new(), None).unwrap();
    let effort = Effort {
        sketch_columns: 20,
        ..Effort::default()
    };
    for (options, field) in [
        (
            FitOptions {
                seed: 1,
                ..FitOptions::default()
            },
            "seed",
        ),
        (
            FitOptions {
                band_hz: Some([30.0, 200.0]),
                ..FitOptions::default()
            },
            "band",
        ),
        (
            FitOptions {
                effort,
                ..FitOptions::default()
            },
            "columns of the sketch",
        ),
    ] {
        let message = error(vec![parts[1].clone(), with(options)]);
        assert!(
            message.contains(field) && message.contains("block 7"),
            "{message}"
        );
    }
    let mut shifted = block.clone();
    shifted.frequency_hz.mapv_inplace(|f| f + 1.0);
    let shifted = reduce(&shifted, &FitOptions::default(), 7, Vec::new(), None).unwrap();
    assert!(error(vec![parts[1].clone(), shifted]).contains("frequency axis"));

    // the same FRFs under another number
    let again = reduce(&block, &FitOptions::default(), 7, Vec::new(), None).unwrap();
    let merged = Partial::merge([parts[0].clone(), again]).unwrap();
    let message = solve(merged, &FitOptions::default(), &|_| {})
        .unwrap_err()
        .to_string();
    assert!(message.contains("an FRF stands in two blocks"), "{message}");

    // a second pass over half of the data, and one with other poles
    let Solved::Poles(poles) = solve(
        Partial::merge(parts.clone()).unwrap(),
        &FitOptions::default(),
        &|_| {},
    )
    .unwrap() else {
        panic!("poles")
    };
    let half = reduced(&blocks(&set.frf, 2)[..1], Some(&poles));
    let message = solve(half[0].clone(), &FitOptions::default(), &|_| {})
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("not run over the FRFs of the first"),
        "{message}"
    );
    let message = error(vec![half[0].clone(), parts[1].clone()]);
    assert!(message.contains("other poles"), "{message}");
}

#[test]
fn files_of_another_version_or_damaged_are_refused_by_name() {
    let part = reduced(&blocks(&set().frf, 2), None).remove(0);
    let bytes = part.to_bytes();
    let error = |bytes: &[u8]| Partial::from_bytes(bytes).unwrap_err().to_string();
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap();
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let with_head = |head: String| [head.as_bytes(), &bytes[end..]].concat();
    let other = error(&with_head(head.replace("\"version\":8", "\"version\":1")));
    assert!(
        other.contains("another version") && other.contains("1 (written by chladni"),
        "{other}"
    );
    assert!(error(&with_head(head.replace("partial", "poles"))).contains("chladni.poles"));
    assert!(error(&bytes[..bytes.len() - 1]).contains("cut off"));
    let mut damaged = bytes.clone();
    *damaged.last_mut().unwrap() ^= 1;
    assert!(error(&damaged).contains("damaged"));
    assert!(error(b"PK\x03\x04").contains("first line"));
    assert!(error(b"").contains("first line"));
}
