//! Many files into one set: single-reference surveys, duplicates, gaps, contradictions.

mod axes_and_units;
mod beside;
mod documents;
mod pairs;
