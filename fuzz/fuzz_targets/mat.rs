//! Any bytes as a MATLAB file.
#![no_main]
use chladni_fuzz::{on_file, targets};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "mat", targets::any_file));
