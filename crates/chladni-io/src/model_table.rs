//! A model as a table for spreadsheets: one row per mode, one pair of columns for each
//! DOF of shape and participation.

use super::mat::{damping_name, scaling_name, trust_name, PER_MODE};
use chladni_frf::ModalModel;
use std::io::{self, Write};

/// Writes the modes of a model, without residual terms and geometry.
pub(super) fn write(out: &mut dyn Write, model: &ModalModel) -> io::Result<()> {
    writeln!(out, "# format = chladni.modes")?;
    writeln!(out, "# frf_kind = {}", model.frf_kind)?;
    writeln!(out, "# reference_unit = {}", model.reference_unit)?;
    writeln!(out, "# damping = {}", damping_name(model.damping))?;
    writeln!(out, "# scaling = {}", scaling_name(model.scaling))?;
    writeln!(out, "# created_by = {}", model.created_by)?;
    write!(out, "mode")?;
    for (name, _) in PER_MODE {
        write!(out, ",{name}")?;
    }
    write!(out, ",trust,reasons")?;
    for (what, dofs) in [
        ("shape", &model.responses),
        ("participation", &model.references),
    ] {
        for dof in dofs {
            write!(out, ",{what} {dof} re,{what} {dof} im")?;
        }
    }
    writeln!(out)?;
    for (k, mode) in model.modes.iter().enumerate() {
        write!(out, "{}", k + 1)?;
        for (_, value) in PER_MODE {
            write!(out, ",{}", value(mode))?;
        }
        let reasons = mode.reasons.sentences().join("; ").replace('"', "'");
        write!(out, ",{},\"{reasons}\"", trust_name(mode.trust))?;
        for value in mode.shape.0.iter().chain(&mode.participation.0) {
            write!(out, ",{:?},{:?}", value.re, value.im)?;
        }
        writeln!(out)?;
    }
    Ok(())
}
