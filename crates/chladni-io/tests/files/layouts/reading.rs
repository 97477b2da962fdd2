//! Each layout is read right, or refused by name.

use super::layout::{draw, DofPlace, Expected, Form, Layout, Shape, UnitPlace, ENCODINGS};
use super::table::{encoded, table, truth, Truth};
use chladni_frf::{Error, ErrorKind, FrfSet};
use chladni_io::{read_frf, ReadOptions};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Variants that the suite runs; the environment variable runs more.
const VARIANTS: usize = 400;

/// Largest relative error of a value that was printed with nine digits.
const TOLERANCE: f64 = 1e-6;

/// At least this part must be read: a reader that refuses everything misreads nothing.
const LEAST_READ: f64 = 0.7;

/// The fault of what was read.
fn misread(layout: &Layout, truth: &Truth, set: &FrfSet, warnings: &[String]) -> Option<String> {
    let said = layout.unit_place != UnitPlace::Nowhere;
    let factor = if said { 1.0 } else { 1.0 / layout.unit.1 };
    let spoken = warnings
        .iter()
        .any(|warning| warning.contains("taken as SI"));
    if said == spoken {
        return Some(format!("unit: {warnings:?}"));
    }
    if set.kind != said.then_some(layout.unit.2) {
        return Some(format!("kind {:?}", set.kind));
    }
    if said && set.reference_unit != layout.unit.3 {
        return Some("unit of the reference".into());
    }
    let axis = set.frequency_hz.to_vec();
    let is_near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * b.abs();
    let same_axis = axis.len() == truth.frequency_hz.len()
        && axis
            .iter()
            .zip(&truth.frequency_hz)
            .all(|(a, b)| is_near(*a, *b));
    if !same_axis {
        return Some(format!("axis {axis:?} for {:?}", truth.frequency_hz));
    }
    let named = layout.shape == Shape::Long || (layout.header && layout.dofs != DofPlace::Nowhere);
    for (i, (response, values)) in truth.frfs.iter().enumerate() {
        let expected = if named {
            (*response).to_owned()
        } else {
            format!("{}:+Z", i + 1)
        };
        if set.responses.get(i).map(ToString::to_string) != Some(expected) {
            return Some(format!("responses {:?}", set.responses));
        }
        // without any header the assumption is said: real part first
        let assumed = layout.form == Form::ImRe
            && !layout.header
            && warnings
                .iter()
                .any(|warning| warning.contains("taken as real"));
        let found = set.values.frf(i, 0);
        for (k, (a, b)) in found.iter().zip(values).enumerate() {
            let masked = k == 0 && layout.gap.is_some();
            let b = if assumed {
                Complex64::new(b.im, b.re)
            } else {
                *b
            } * factor;
            let right = if masked {
                a.re.is_nan() && a.im.is_nan()
            } else {
                (a - b).norm() <= 10.0 * TOLERANCE * b.norm()
            };
            if !right {
                return Some(format!("value {k} of FRF {i}: {a} for {b}"));
            }
            let coherence = set.coherence.as_ref().map(|coherence| coherence[[i, 0, k]]);
            if coherence != layout.coherence.then_some(truth.coherence as f32) {
                return Some(format!("coherence {coherence:?}"));
            }
        }
    }
    let reference = if named { "101:+Z" } else { "1:S" };
    (set.references.len() != 1 || set.references[0].to_string() != reference)
        .then(|| format!("references {:?}", set.references))
}

/// The fault of a refusal.
fn unhelpful(error: &Error) -> Option<String> {
    let has_place = error.line.is_some() || error.field.is_some();
    let says_what_to_do = error.help.is_some() || error.expected.is_some();
    (error.kind != ErrorKind::BadData || !has_place || !says_what_to_do || error.found.is_none())
        .then(|| "the refusal names no place, or not what to do".into())
}

#[test]
fn every_layout_is_read_right_or_refused_by_name() {
    let variants = std::env::var("CHLADNI_LAYOUTS").map_or(VARIANTS, |count| {
        count.parse().expect("a number of variants")
    });
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    let (mut read, mut refused) = (0, 0);
    for number in 0..variants {
        let mut random = ChaCha8Rng::seed_from_u64(number as u64);
        let layout = draw(&mut random);
        let truth = truth(&layout, &mut random);
        let text = table(&layout, &truth);
        let encoding = ENCODINGS[layout.encoding];
        let path = folder.path().join(format!("{number}.csv"));
        std::fs::write(&path, encoded(&text, encoding)).unwrap();
        let result = read_frf(&[path], &ReadOptions::default());
        let expected = layout.expected();
        let complaint = match &result {
            Ok((set, _, warnings)) => {
                read += 1;
                match misread(&layout, &truth, set, &crate::words(warnings)) {
                    None if expected == Expected::Refused => Some("read, by chance".into()),
                    complaint => complaint,
                }
            }
            Err(error) => {
                refused += 1;
                match unhelpful(error) {
                    None if expected == Expected::Read => Some("refused".into()),
                    complaint => complaint,
                }
                .map(|words: String| format!("{words}: {error}"))
            }
        };
        if let Some(complaint) = complaint {
            let head: Vec<&str> = text.split(layout.line_end).take(9).collect();
            wrong.push(format!(
                "variant {number}: {complaint}\n{layout:?}\n{}\n",
                head.join("\n")
            ));
        }
    }
    println!("{variants} layouts: {read} read, {refused} refused");
    assert!(
        wrong.is_empty(),
        "{} of {variants}:\n{}",
        wrong.len(),
        wrong[..wrong.len().min(12)].join("\n")
    );
    assert!(
        read as f64 >= LEAST_READ * variants as f64,
        "{read} of {variants} are read"
    );
}
