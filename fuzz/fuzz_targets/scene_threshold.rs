//! Any text as a scene and its threshold table.
#![no_main]
use chladni_fuzz::{on_file, scenes};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "toml", scenes::scene_and_table));
