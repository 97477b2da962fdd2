//! Any bytes as a file: read, and where it could be read, written and read again.
#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| chladni_fuzz::file(data, "csv"));
