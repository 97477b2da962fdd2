//! Real files, and files that no program writes.

use super::round_trip::example_set;
use super::{binary_58, identifier, le64, options, read_with};
use chladni_frf::FrfKind;
use chladni_io::uff::{read, write, Plan, WriteOptions};
use chladni_io::{Contents, Ordinate, ReadOptions};
use num_complex::Complex64;
use proptest::prelude::*;
use std::path::Path;

fn sample(name: &str) -> Option<Vec<u8>> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        crate::skipped(&format!("{name} is not beside this workspace"));
    }
    bytes
}

#[test]
fn a_measured_beam_is_read() {
    let Some(bytes) = sample("pyuff-beam/beam.uff") else {
        return;
    };
    let started = std::time::Instant::now();
    let document = read_with(&bytes, &options());
    println!("beam.uff: {} bytes in {:?}", bytes.len(), started.elapsed());
    assert_eq!(document.errors, []);
    let numbers: Vec<_> = document.datasets.iter().filter_map(|d| d.number).collect();
    assert_eq!(numbers, [151, 164, 2420, 2411, 58, 58, 58]);
    assert_eq!(document.geometry.nodes.len(), 10);
    for (k, function) in document.functions.iter().enumerate() {
        assert_eq!(
            (function.kind, function.scale_to_si),
            (Some(FrfKind::Accelerance), 1.0)
        );
        assert_eq!(
            (function.response.node, function.reference.to_string()),
            (k as u64 + 1, "21:+X".to_string())
        );
        assert_eq!(function.ordinate.len(), 64000);
        assert_eq!(function.abscissa.values(64000)[63999], 6399.9);
        assert_eq!(function.warnings, Vec::<chladni_frf::Finding>::new());
    }
    let Ordinate::Complex64(values) = &document.functions[2].ordinate else {
        panic!()
    };
    assert_eq!(
        values[63999],
        Complex64::new(-1.96455290343e-03, -2.13040254619e-03)
    );
}

#[test]
fn small_samples_of_other_programs_are_read() {
    let Some(bytes) = sample("pyuff-uff-samples/heat_engine_housing.uff") else {
        return;
    };
    let document = read_with(bytes, &options());
    assert_eq!(document.errors, []);
    assert_eq!(
        document.geometry.nodes[0].xyz_m[0],
        -1.711755676269531e+02 / 1000.0
    );
    let Some(bytes) = sample("pyuff-uff-samples/uff55_translation.uff") else {
        return;
    };
    let document = read_with(bytes, &options());
    let frequencies: Vec<_> = document.datasets.iter().map(|d| d.frequency_hz).collect();
    assert_eq!(frequencies, [Some(10.0), Some(12.0), Some(13.0)]);
    let Some(bytes) = sample("pyuff-uff-samples/mesh_test_uff2412_mixed.uff") else {
        return;
    };
    let document = read_with(bytes, &options());
    assert_eq!(
        (document.errors.len(), document.geometry.nodes.len()),
        (0, 5)
    );
}

fn small_file(binary: bool) -> Vec<u8> {
    let set = example_set(vec![1.0, 2.0, 3.0]);
    let mut bytes = Vec::new();
    write(
        &mut bytes,
        &Contents {
            frf: Some(set),
            ..Contents::default()
        },
        WriteOptions {
            binary,
            ..WriteOptions::default()
        },
    )
    .unwrap();
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_never_panic(
        binary in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..5u8), 1..12),
        lenient in any::<bool>(),
    ) {
        let mut bytes = small_file(binary);
        for (at, byte, how) in changes {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => bytes[at] = b"0123456789 -+.Eb\n*"[usize::from(byte) % 18],
                2 => drop(bytes.remove(at)),
                3 => bytes.insert(at, byte),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let options = ReadOptions { lenient, snap_df: lenient, ..ReadOptions::default() };
        if let Ok(document) = read(&bytes, Path::new("mutated"), &options) {
            let contents = Contents { functions: document.functions, other_geometry: document.geometry, ..Contents::default() };
            for binary in [false, true] {
                if let Ok(plan) = Plan::new(&contents, WriteOptions { binary, ..WriteOptions::default() }) {
                    let mut again = Vec::new();
                    plan.write(&mut again).unwrap();
                    prop_assert_eq!(read(&again, Path::new("again"), &ReadOptions::default()).unwrap().errors, vec![]);
                }
            }
        }
    }

    #[test]
    fn any_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut file = b"    -1\n    58\n".to_vec();
        file.extend(&bytes);
        let _ = read(&file, Path::new("any"), &ReadOptions::default());
        let _ = read(&bytes, Path::new("any"), &ReadOptions { lenient: true, ..ReadOptions::default() });
    }

    #[test]
    fn any_double_survives_the_binary_form(values in prop::collection::vec(any::<f64>().prop_filter("finite", |v| v.is_finite()), 2..40)) {
        let mut payload = values;
        payload.truncate(payload.len() / 2 * 2);
        let record_7 = format!("         6{:10}         1  1.00000E+00  5.00000E-01  \
                                0.00000E+00", payload.len() / 2);
        let document = read_with(binary_58(&identifier(1, 8 * payload.len()), &record_7, &le64(&payload), "    -1\n"), &options());
        let pairs = payload.chunks(2).map(|p| Complex64::new(p[0], p[1])).collect();
        prop_assert_eq!(&document.functions[0].ordinate, &Ordinate::Complex64(pairs));
    }
}
