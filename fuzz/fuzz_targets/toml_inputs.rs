//! Any text as a scene, a panel or a selection.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| chladni_fuzz::toml_inputs(data));
