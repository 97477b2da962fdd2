//! Our own tables, read back; random text.

use super::reading::{c, read};
use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_io::{read_frf, write_frf, ReadOptions};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use proptest::prelude::*;

fn small_set(values: Array3<Complex64>, coherence: bool) -> FrfSet {
    let dim = values.dim();
    FrfSet {
        frequency_hz: Array1::from_iter((0..dim.2).map(|k| 0.1 + k as f64 / 3.0)),
        responses: (0..dim.0)
            .map(|i| {
                format!("{}:-RX", 1000 * i as u64 + u64::from(u32::MAX))
                    .parse()
                    .unwrap()
            })
            .collect(),
        references: (0..dim.1)
            .map(|j| format!("{}:S", j + 1).parse().unwrap())
            .collect(),
        kind: Some(FrfKind::Accelerance),
        reference_unit: ReferenceUnit::Volt,
        coherence: coherence.then(|| Array3::from_elem(dim, 1.0 / 3.0)),
        variance: None,
        estimation: None,
        values: FrfValues::F64(values),
        geometry: Geometry::default(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn own_tables_read_back_to_the_last_bit(
        responses in 1_usize..4, references in 1_usize..3, lines in 1_usize..5, coherence: bool,
        numbers in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 48),
    ) {
        let values = Array3::from_shape_fn((responses, references, lines), |(i, j, k)| {
            let at = 2 * ((i * references + j) * lines + k);
            // never zero on every line, which means missing
            Complex64::new(numbers[at % 48], if k == 0 { 1.0 } else { numbers[(at + 1) % 48] })
        });
        let set = small_set(values, coherence);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.csv");
        write_frf(&path, &set, false).unwrap();
        let (back, _, warnings) = read_frf(&[path], &ReadOptions::default()).unwrap();
    let warnings = crate::words(&warnings);
        prop_assert_eq!(&back, &set);
        prop_assert!(warnings.is_empty(), "{:?}", warnings);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "(f,re,im\n)?([0-9eE+.,;# \
                                               =\tnaiZ:\"-]{0,12}\n){0,8}") {
        let _ = read(text);
    }
}

#[test]
fn own_tables_keep_gaps_and_say_what_they_cannot_hold() {
    let mut values = Array3::from_elem((2, 2, 3), c(1.0, 2.0));
    values
        .slice_mut(ndarray::s![0, 1, ..])
        .fill(c(f64::NAN, f64::NAN));
    values[[1, 0, 1]] = c(f64::NAN, f64::NAN);
    let mut set = small_set(values, true);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.csv");
    set.geometry.nodes.push(chladni_frf::Node {
        label: 1,
        xyz_m: [0.0; 3],
    });
    let lost = write_frf(&path, &set, false).unwrap();
    assert!(lost[0].contains("no geometry"), "{lost:?}");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.starts_with("# frf_kind = accelerance\n# unit = m/s^2/V\n"),
        "{text}"
    );
    assert!(
        text.contains("\nnode,dir,ref_node,ref_dir,f,re,im,coherence\n"),
        "{text}"
    );
    let (back, _, warnings) = read_frf(&[path], &ReadOptions::default()).unwrap();
    let warnings = crate::words(&warnings);
    set.geometry = Geometry::default();
    let measured = |set: &FrfSet| format!("{:?}", set.values);
    assert_eq!(measured(&back), measured(&set));
    let text = warnings.join("\n");
    assert!(
        text.contains("1 rows hold no finite value") && text.contains("1 of 4 pairs are missing"),
        "{text}"
    );
}
