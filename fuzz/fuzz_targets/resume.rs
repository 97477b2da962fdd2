//! Any bytes as what an interrupted run left.
#![no_main]
use chladni_fuzz::{on_file, pieces};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "json", pieces::resumed));
