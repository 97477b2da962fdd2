//! Any bytes as HDF5: FRFs or a model.
#![no_main]
use chladni_fuzz::{on_file, targets};
libfuzzer_sys::fuzz_target!(|data: &[u8]| on_file(data, "h5", targets::any_file_or_model));
