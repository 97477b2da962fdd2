//! Small FRF tables of known content in thousands of layouts. Each is read right, or refused
//! by a message that names the place and the next step. None is misread.
//!
//! `CHLADNI_LAYOUTS=2000 cargo test -p chladni-io --test files layouts` runs as many.

mod layout;
mod reading;
mod table;
