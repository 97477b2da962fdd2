//! Any bytes as a table.
#![no_main]
use chladni_fuzz::{on_file, targets};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "csv", targets::any_file));
