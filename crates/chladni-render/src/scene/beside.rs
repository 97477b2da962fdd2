//! Places of the files that a scene names.

use crate::scene::threshold::ThresholdTable;
use std::path::Path;

/// The source of a scene's threshold table.
#[derive(Clone, Copy)]
pub(super) enum Beside<'a> {
    /// As a file, by its path from this folder.
    Folder(&'a Path),
    /// Among these, by its name.
    Tables(&'a [ThresholdTable]),
}
