//! Files in our own HDF5 layout that other programs wrote or changed: units, DOFs, coordinates.

use chladni_frf::{ErrorKind, FrfKind, FrfSet, FrfValues, ReferenceUnit};
use chladni_io::{read_frf, FrfParts, ReadOptions};
use hdf5_pure::{
    AttrValue, CompoundTypeBuilder, DatasetBuilder, Datatype, DatatypeByteOrder, FileBuilder,
    FloatingPointLayout,
};
use num_complex::Complex64;
use std::path::PathBuf;

/// The attributes of a file, its DOFs and its nodes.
struct Own {
    root: Vec<(&'static str, &'static str)>,
    frf_unit: Option<AttrValue>,
    freq_unit: Option<&'static str>,
    has_variance: bool,
    response: (u64, i8),
    node: Option<[f64; 3]>,
    /// Real and imaginary parts of both lines.
    values: [f64; 4],
}

impl Default for Own {
    fn default() -> Self {
        Self {
            root: vec![("frf_kind", "mobility"), ("reference_unit", "N")],
            frf_unit: None,
            freq_unit: None,
            has_variance: false,
            response: (1, 3),
            node: None,
            values: [1.0, 0.0, 2.0, 3.0],
        }
    }
}

fn text(text: &str) -> AttrValue {
    AttrValue::String(text.into())
}

/// Writes one DOF, and the DOF records of the built-in layout.
fn dof(builder: &mut DatasetBuilder, (node, direction): (u64, i8)) {
    let record = CompoundTypeBuilder::new()
        .u64_field("node")
        .i8_field("dir")
        .build()
        .unwrap();
    let bytes = [&node.to_le_bytes()[..], &direction.to_le_bytes()].concat();
    builder
        .with_compound_data(record, bytes, 1)
        .with_shape(&[1]);
}

impl Own {
    /// One response, one reference, and lines at 10 and 20.
    fn saved(&self) -> (tempfile::TempDir, PathBuf) {
        let mut file = FileBuilder::new();
        file.set_attr("format", text("chladni"));
        file.set_attr("version", AttrValue::I64(1));
        for (name, value) in &self.root {
            file.set_attr(name, text(value));
        }
        let freq = file.create_dataset("freq");
        freq.with_f64_data(&[10.0, 20.0]);
        if let Some(unit) = self.freq_unit {
            freq.set_attr("unit", text(unit));
        }
        let complex = CompoundTypeBuilder::new().f64_field("r").f64_field("i");
        let bytes = self.values.into_iter().flat_map(f64::to_le_bytes).collect();
        let frf = file.create_dataset("frf");
        frf.with_compound_data(complex.build().unwrap(), bytes, 2)
            .with_shape(&[1, 1, 2]);
        if let Some(unit) = &self.frf_unit {
            frf.set_attr("unit", unit.clone());
        }
        if self.has_variance {
            let variance = file.create_dataset("variance");
            variance.with_f64_data(&[4.0, 8.0]).with_shape(&[1, 1, 2]);
        }
        dof(file.create_dataset("response"), self.response);
        dof(file.create_dataset("reference"), (101, 3));
        if let Some(place) = self.node {
            let record = CompoundTypeBuilder::new()
                .u64_field("label")
                .f64_field("x")
                .f64_field("y")
                .f64_field("z")
                .build()
                .unwrap();
            let place = place.into_iter().flat_map(f64::to_le_bytes);
            let bytes = 1_u64.to_le_bytes().into_iter().chain(place).collect();
            let mut geometry = file.create_group("geometry");
            let nodes = geometry.create_dataset("nodes");
            nodes.with_compound_data(record, bytes, 1).with_shape(&[1]);
            let geometry = geometry.finish();
            file.add_group(geometry);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.h5");
        file.write(&path).unwrap();
        (folder, path)
    }

    fn read(&self) -> chladni_frf::Result<FrfSet> {
        let (_folder, path) = self.saved();
        read_frf(&[path], &ReadOptions::default()).map(|(set, ..)| set)
    }

    /// The set as it is read in parts.
    fn read_in_parts(&self) -> chladni_frf::Result<FrfSet> {
        let (_folder, path) = self.saved();
        let data = FrfParts::open(std::slice::from_ref(&path), &ReadOptions::default())?;
        let parts = data.parts(1 << 20)?;
        data.read(&parts[0], None, None)
            .map(|(set, ..)| set.unwrap())
    }

    /// The errors of reading it whole and in parts.
    #[track_caller]
    fn refusals(&self) -> [String; 2] {
        [self.read(), self.read_in_parts()].map(|read| {
            let error = read.unwrap_err();
            assert_eq!(error.kind, ErrorKind::BadData, "{error}");
            error.to_string()
        })
    }
}

#[test]
fn units_of_values_and_frequencies_count_whole_and_in_parts() {
    let own = Own {
        frf_unit: Some(text("mm/s/N")),
        freq_unit: Some("kHz"),
        ..Own::default()
    };
    for set in [own.read().unwrap(), own.read_in_parts().unwrap()] {
        assert_eq!(set.frequency_hz.to_vec(), [10e3, 20e3]);
        let FrfValues::F64(values) = &set.values else {
            panic!("{set:?}");
        };
        let off = values[[0, 0, 1]] - Complex64::new(2e-3, 3e-3);
        assert!(off.norm() < 1e-18, "{values:?}");
    }
    let with_variance = Own {
        has_variance: true,
        ..own
    };
    let variance = with_variance.read().unwrap().variance.unwrap();
    assert!((variance[[0, 0, 1]] - 8e-6).abs() < 1e-18, "{variance:?}");
    // what the root leaves unsaid
    let by_unit = Own {
        root: Vec::new(),
        frf_unit: Some(text("m/V")),
        ..Own::default()
    };
    let set = by_unit.read().unwrap();
    assert_eq!(
        (set.kind, set.reference_unit),
        (Some(FrfKind::Receptance), ReferenceUnit::Volt)
    );
}

#[test]
fn texts_for_no_unit_are_no_unit() {
    for label in ["", "-", "1", "none"] {
        let own = Own {
            frf_unit: Some(text(label)),
            freq_unit: Some(label),
            ..Own::default()
        };
        assert_eq!(own.read().unwrap().kind, Some(FrfKind::Mobility), "{label}");
    }
}

#[test]
fn units_that_are_not_understood_or_contradict_the_root_are_refused() {
    let of_frf = |label: AttrValue| Own {
        frf_unit: Some(label),
        ..Own::default()
    };
    for (own, words) in [
        (of_frf(text("furlong/N")), "unit of /frf"),
        (of_frf(AttrValue::F64(1e-3)), "found 0.001"),
        (of_frf(text("mm/N")), "mobility with unit mm/N"),
        (of_frf(text("mm/s/V")), "N with unit mm/s/V"),
        (
            Own {
                freq_unit: Some("furlong"),
                ..Own::default()
            },
            "unit of /freq",
        ),
    ] {
        for said in own.refusals() {
            assert!(said.contains(words), "{words}: {said}");
            assert!(said.contains("correct the attribute"), "{said}");
        }
    }
}

#[test]
fn a_coordinate_that_is_no_number_and_an_unknown_direction_are_named() {
    let lost = Own {
        node: Some([0.0, f64::NAN, 0.0]),
        ..Own::default()
    };
    for said in lost.refusals() {
        assert!(said.contains("y of node 1 in /geometry/nodes"), "{said}");
        assert!(said.contains("found NaN"), "{said}");
    }
    let turned = Own {
        response: (5, 9),
        ..Own::default()
    };
    for said in turned.refusals() {
        assert!(said.contains("direction code 9 of node 5"), "{said}");
        assert!(said.contains("±3 Z"), "{said}");
    }
}

#[test]
fn an_infinite_value_is_masked_as_in_binary_universal_files() {
    let own = Own {
        values: [f64::INFINITY, 0.0, 2.0, 3.0],
        ..Own::default()
    };
    let (_folder, path) = own.saved();
    let (set, _, warnings) = read_frf(&[path], &ReadOptions::default()).unwrap();
    assert!(set.values.get(0, 0, 0).is_nan());
    assert_eq!(set.values.get(0, 0, 1), Complex64::new(2.0, 3.0));
    let codes: Vec<&str> = warnings.iter().map(|finding| &*finding.code).collect();
    assert!(codes.contains(&"lines-masked"), "{warnings:?}");
}

#[test]
fn complex_numbers_of_half_precision_are_called_so() {
    let half = Datatype::FloatingPoint {
        size: 2,
        byte_order: DatatypeByteOrder::LittleEndian,
        layout: FloatingPointLayout {
            bit_offset: 0,
            bit_precision: 16,
            exponent_location: 10,
            exponent_size: 5,
            mantissa_location: 0,
            mantissa_size: 10,
            exponent_bias: 15,
        },
    };
    let complex = CompoundTypeBuilder::new()
        .field("re", half.clone())
        .field("im", half);
    let mut file = FileBuilder::new();
    file.create_dataset("f").with_f64_data(&[1.0, 2.0, 3.0]);
    file.create_dataset("H")
        .with_compound_data(complex.build().unwrap(), vec![0; 12], 3)
        .with_shape(&[3]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.h5");
    file.write(&path).unwrap();
    let error = read_frf(&[path], &ReadOptions::default()).unwrap_err();
    let told = error.to_string();
    assert!(told.contains("found complex, half precision"), "{told}");
    assert!(told.contains("complex64"), "{told}");
}
