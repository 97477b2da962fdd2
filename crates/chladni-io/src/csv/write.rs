//! Tables of our own: remarks, a header, one row per FRF and line.

use chladni_frf::{Dof, FrfSet, FrfValues};
use std::io::{self, Write};

/// Writes the set as a long table; a pair that was not measured has no rows, a masked line has NaN.
///
/// The column `coherence` is there only where the set has coherence. Numbers are the
/// shortest that read back the same.
pub(crate) fn write(out: &mut dyn Write, set: &FrfSet) -> io::Result<()> {
    if let Some(kind) = set.kind {
        writeln!(out, "# frf_kind = {kind}")?;
        writeln!(out, "# unit = {}", kind.unit(set.reference_unit))?;
    }
    writeln!(out, "# reference_unit = {}", set.reference_unit)?;
    writeln!(out, "# time_sign = +")?;
    writeln!(out, "# created_by = {}", chladni_frf::CREATED_BY)?;
    write!(out, "node,dir,ref_node,ref_dir,f,re,im")?;
    writeln!(
        out,
        "{}",
        if set.coherence.is_some() {
            ",coherence"
        } else {
            ""
        }
    )?;
    for (i, response) in set.responses.iter().enumerate() {
        for (j, reference) in set.references.iter().enumerate() {
            if !set.values.frf(i, j).iter().all(|value| value.re.is_nan()) {
                write_pair(out, set, (i, j), response, reference)?;
            }
        }
    }
    Ok(())
}

fn write_pair(
    out: &mut dyn Write,
    set: &FrfSet,
    (i, j): (usize, usize),
    response: &Dof,
    reference: &Dof,
) -> io::Result<()> {
    for (k, f) in set.frequency_hz.iter().enumerate() {
        let (a, b) = (response.direction.code(), reference.direction.code());
        write!(out, "{},{a},{},{b},{f:?},", response.node, reference.node)?;
        // six digits of a text file stay six digits
        match &set.values {
            FrfValues::F64(values) => {
                let value = values[[i, j, k]];
                write!(out, "{:?},{:?}", value.re, value.im)?;
            }
            FrfValues::F32(values) => {
                let value = values[[i, j, k]];
                write!(out, "{:?},{:?}", value.re, value.im)?;
            }
        }
        match &set.coherence {
            Some(coherence) if coherence[[i, j, k]].is_nan() => writeln!(out, ",")?,
            Some(coherence) => writeln!(out, ",{:?}", coherence[[i, j, k]])?,
            None => writeln!(out)?,
        }
    }
    Ok(())
}
