//! The size of a set of FRFs.

use chladni_console::table::{counted, significant};
use chladni_frf::{FrfKind, FrfSet};
use std::fmt;

/// Kind, counts and frequency axis of a set of FRFs; `Display` gives a part of a sentence.
pub struct Extent {
    /// Kind of the FRFs; `None` where the units do not say it.
    pub kind: Option<FrfKind>,
    /// Number of responses.
    pub responses: usize,
    /// Number of references.
    pub references: usize,
    /// Number of lines.
    pub lines: usize,
    /// First and last line, Hz.
    pub axis_hz: [f64; 2],
}

impl Extent {
    /// The extent of `frf`, which holds at least one line.
    pub fn of(frf: &FrfSet) -> Self {
        let (responses, references, lines) = frf.values.dim();
        Self {
            kind: frf.kind,
            responses,
            references,
            lines,
            axis_hz: [frf.frequency_hz[0], frf.frequency_hz[lines - 1]],
        }
    }

    /// Number of lines, the first and the last, in words.
    pub fn axis(&self) -> String {
        format!(
            "{} from {} to {} Hz",
            counted(self.lines, "line"),
            significant(self.axis_hz[0], 6),
            significant(self.axis_hz[1], 6)
        )
    }
}

impl fmt::Display for Extent {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self.kind {
            Some(kind) => write!(out, "{kind}")?,
            None => write!(out, "FRFs")?,
        }
        write!(
            out,
            " of {} at {}, {}",
            counted(self.responses, "response"),
            counted(self.references, "reference"),
            self.axis()
        )
    }
}
