//! Questions to the studio, put together part by part.
#![no_main]
use chladni_fuzz::{in_time, questions};
libfuzzer_sys::fuzz_target!(|body: questions::Body| in_time(|| questions::ask(&body)));
