//! Packed elements of version 7: zlib, with a limit to the unpacked size.

use super::element::Element;
use crate::limits::{LEAST_ROOM, MOST_EXPANSION};
use chladni_frf::{Error, Result};
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Bytes that a file may still unpack to.
pub(super) struct Budget {
    left: usize,
    limit: usize,
}

impl Budget {
    /// The budget of a file of `bytes` bytes.
    pub(super) fn new(bytes: usize) -> Self {
        let limit = bytes.saturating_mul(MOST_EXPANSION).max(LEAST_ROOM);
        Self { left: limit, limit }
    }

    /// The content of a packed element.
    ///
    /// # Errors
    /// Damaged data, or more than the budget.
    pub(super) fn unpack(&mut self, element: &Element<'_>) -> Result<Vec<u8>> {
        let wrong = |message: &str| {
            Error::bad_data(message)
                .at_byte(element.byte as u64)
                .field("compressed element")
        };
        let mut unpacked = Vec::new();
        let mut decoder = ZlibDecoder::new(element.bytes).take(self.left as u64 + 1);
        decoder.read_to_end(&mut unpacked).map_err(|error| {
            let error = wrong("the packed data are damaged")
                .found(error)
                .expected("zlib data");
            error.help(
                "the file is cut short or was changed by a text transfer: save or copy it again",
            )
        })?;
        if unpacked.len() > self.left {
            return Err(wrong("the packed data unfold to more than is plausible")
                .found(format!("more than {} bytes", self.limit))
                .expected(format!("at most {MOST_EXPANSION} times the file's size"))
                .help(
                    "save the file with -v7.3 or -nocompression if it really holds that many \
                       equal values",
                ));
        }
        self.left -= unpacked.len();
        Ok(unpacked)
    }
}
