//! Any text as weights.
#![no_main]
use chladni_fuzz::{on_file, targets};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "json", targets::any_file_or_model));
