//! Small FRF tables in thousands of layouts, with the truth beside them: each is read
//! right, or refused by a message that names the place and what to do. None is misread.
//!
//! `CHLADNI_LAYOUTS=2000 cargo test -p chladni-io --test files layouts` runs as many.

mod layout;
mod reading;
mod table;
