//! The page: one file, no external resource, readable without its script.

mod page;
pub(crate) mod tables;

pub(crate) use page::{gallery, page};
