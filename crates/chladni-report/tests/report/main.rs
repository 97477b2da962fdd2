//! The report through its public door.

mod data;
mod figures;
mod inputs;
mod page;
