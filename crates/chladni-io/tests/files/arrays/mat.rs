//! MATLAB files made by hand.

use flate2::write::ZlibEncoder;
use std::io::Write;

/// A file in either byte order.
pub(super) struct Mat {
    pub(super) big: bool,
    pub(super) bytes: Vec<u8>,
}

impl Mat {
    pub(super) fn new(big: bool) -> Self {
        let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
        bytes.resize(124, b' ');
        bytes.extend(if big {
            [1, 0, b'M', b'I']
        } else {
            [0, 1, b'I', b'M']
        });
        Self { big, bytes }
    }
    pub(super) fn word(&self, value: u32) -> [u8; 4] {
        if self.big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        }
    }
    pub(super) fn element(&self, kind: u32, payload: &[u8]) -> Vec<u8> {
        // small elements keep type, size and data in eight bytes
        if (1..=4).contains(&payload.len()) {
            let mut small = self.word((payload.len() as u32) << 16 | kind).to_vec();
            small.extend(payload);
            small.resize(8, 0);
            return small;
        }
        let mut element = [self.word(kind), self.word(payload.len() as u32)].concat();
        element.extend(payload);
        element.resize(element.len().div_ceil(8) * 8, 0);
        element
    }
    /// An array of class `class` whose parts are stored as numbers of type `kind`.
    pub(super) fn array(
        &self,
        name: &str,
        dimensions: &[u32],
        class: u32,
        kind: u32,
        parts: &[Vec<u8>],
    ) -> Vec<u8> {
        let complex = if parts.len() > 1 { 0x0800 } else { 0 };
        let mut content = self.element(6, &[self.word(class | complex), self.word(0)].concat());
        content.extend(
            self.element(
                5,
                &dimensions
                    .iter()
                    .flat_map(|&extent| self.word(extent))
                    .collect::<Vec<u8>>(),
            ),
        );
        content.extend(self.element(1, name.as_bytes()));
        parts
            .iter()
            .for_each(|part| content.extend(self.element(kind, part)));
        self.element(14, &content)
    }
    pub(super) fn doubles(&self, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
        values
            .into_iter()
            .flat_map(|value| {
                if self.big {
                    value.to_be_bytes()
                } else {
                    value.to_le_bytes()
                }
            })
            .collect()
    }
    pub(super) fn singles(&self, values: impl IntoIterator<Item = f32>) -> Vec<u8> {
        values
            .into_iter()
            .flat_map(|value| {
                if self.big {
                    value.to_be_bytes()
                } else {
                    value.to_le_bytes()
                }
            })
            .collect()
    }
    pub(super) fn push(&mut self, element: &[u8], packed: bool) {
        if !packed {
            self.bytes.extend(element);
            return;
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(element).unwrap();
        let packed = encoder.finish().unwrap();
        self.bytes
            .extend([self.word(15), self.word(packed.len() as u32)].concat());
        self.bytes.extend(packed);
    }
}
