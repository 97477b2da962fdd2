//! The fit in pieces: what it finds is what the whole finds, the bits depend on the
//! blocks alone, and pieces that do not belong together are refused by name.

mod blocks;
mod law;
mod refusals;
mod spoilt;
mod whole;
