//! Any text as a model that is rendered.
#![no_main]
use chladni_fuzz::{on_file, scenes};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "json", scenes::model));
