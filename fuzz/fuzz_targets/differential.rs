//! Any set of FRFs, written and read.
#![no_main]
use chladni_fuzz::{differential, on_file};
libfuzzer_sys::fuzz_target!(|case: differential::Case| {
    on_file(&[], "h5", |path, _| differential::through(&case, path));
});
