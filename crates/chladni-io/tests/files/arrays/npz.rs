//! NumPy archives made by hand.

use chladni_frf::{Error, FrfSet};
use chladni_io::{read_document, read_frf, Document, ReadOptions};
use num_complex::Complex64;
use std::io::Write;
use std::path::PathBuf;

/// An archive as `numpy.savez` writes it; texts have at most eight characters.
pub(super) struct Npz(pub(super) Vec<(String, Vec<u8>)>);

impl Npz {
    pub(super) fn add(mut self, name: &str, code: &str, shape: &[usize], data: Vec<u8>) -> Self {
        let extents: String = shape.iter().map(|extent| format!("{extent},")).collect();
        let head =
            format!("{{'descr': '{code}', 'fortran_order': False, 'shape': ({extents}), }}\n");
        let mut member = b"\x93NUMPY\x01\x00".to_vec();
        member.extend((head.len() as u16).to_le_bytes());
        member.extend(head.as_bytes());
        member.extend(data);
        self.0.push((format!("{name}.npy"), member));
        self
    }
    pub(super) fn reals(self, name: &str, values: &[f64]) -> Self {
        let data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(name, "<f8", &[values.len()], data)
    }
    pub(super) fn complex(self, name: &str, shape: &[usize], values: &[Complex64]) -> Self {
        let bytes = |v: &Complex64| [v.re.to_le_bytes(), v.im.to_le_bytes()].concat();
        let data = values.iter().flat_map(bytes).collect();
        self.add(name, "<c16", shape, data)
    }
    pub(super) fn texts(self, name: &str, texts: &[&str]) -> Self {
        let padded = |text: &&str| {
            let mut bytes = text.as_bytes().to_vec();
            bytes.resize(24, 0);
            bytes
        };
        let data = texts.iter().flat_map(padded).collect();
        self.add(name, "|S24", &[texts.len()], data)
    }
    pub(super) fn read(&self, options: &ReadOptions) -> Result<(FrfSet, Vec<String>), Error> {
        let (_folder, path) = self.saved();
        read_frf(&[path], options).map(|(set, _, warnings)| (set, crate::words(&warnings)))
    }
    pub(super) fn document(&self, options: &ReadOptions) -> Document {
        let (_folder, path) = self.saved();
        read_document(&path, options).unwrap()
    }
    fn saved(&self) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.npz");
        let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        for (name, bytes) in &self.0 {
            archive
                .start_file(name.as_str(), zip::write::SimpleFileOptions::default())
                .unwrap();
            archive.write_all(bytes).unwrap();
        }
        archive.finish().unwrap();
        (folder, path)
    }
}
