//! Any bytes as arrays of NumPy.
#![no_main]
use chladni_fuzz::{on_file, targets};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "npz", targets::any_file));
