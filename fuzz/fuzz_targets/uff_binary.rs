//! Any bytes as a universal file, from binary functions.
#![no_main]
use chladni_fuzz::{on_file, targets};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "uff", targets::universal));
