//! Documents as readers make them.

use chladni_frf::{Checksum, Error, FrfKind, FrfSet, Geometry, ReferenceUnit};
use chladni_io::{assemble, Abscissa, Axis, Document, FileFormat, Function, Ordinate, ReadOptions};
use num_complex::Complex64;
use std::path::PathBuf;

pub(super) fn function(
    function_type: i32,
    response: &str,
    reference: &str,
    ordinate: Ordinate,
) -> Function {
    Function {
        function_type,
        id_lines: Default::default(),
        ids: [0; 3],
        entity_names: Default::default(),
        response: response.parse().unwrap(),
        reference: reference.parse().unwrap(),
        abscissa: Abscissa::Even {
            start: 1.0,
            step: 0.5,
        },
        z: 0.0,
        axes: std::array::from_fn(|_| Axis::default()),
        ordinate,
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        scale_to_si: 1.0,
        abscissa_to_si: 1.0,
        line: 12,
        warnings: Vec::new(),
    }
}

pub(super) fn frf(response: &str, reference: &str, value: f64) -> Function {
    function(
        4,
        response,
        reference,
        Ordinate::Complex64(vec![Complex64::new(value, 1.0); 3]),
    )
}

pub(super) fn document(name: &str, functions: Vec<Function>) -> Document {
    Document {
        file: PathBuf::from(name),
        format: FileFormat::Uff,
        checksum: Some(Checksum::Sha256(name.into())),
        geometry: Geometry::default(),
        datasets: Vec::new(),
        frf: None,
        functions,
        shapes: Vec::new(),
        errors: Vec::new(),
        warnings: Vec::new(),
    }
}

pub(super) fn merge(
    documents: Vec<Document>,
    options: &ReadOptions,
) -> Result<(FrfSet, Vec<String>), Error> {
    assemble(documents, options)
        .map(|contents| (contents.frf.unwrap(), crate::words(&contents.warnings)))
}

pub(super) fn names(dofs: &[chladni_frf::Dof]) -> Vec<String> {
    dofs.iter().map(ToString::to_string).collect()
}
