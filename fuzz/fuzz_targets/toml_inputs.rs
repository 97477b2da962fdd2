//! Any text as a scene, a panel or a selection.
#![no_main]
use chladni_fuzz::{on_file, toml_inputs};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "toml", toml_inputs));
