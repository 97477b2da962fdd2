//! Kind of the FRFs, from the units of the channels.

use chladni_frf::{Error, FrfKind, ReferenceUnit, Result, Run, SignalUnit};

/// Kind and unit of the reference, which all channels must agree on; `None` where units
/// are not known.
pub(super) fn kind_of(runs: &[Run]) -> Result<(Option<FrfKind>, ReferenceUnit)> {
    let disagree = |what: &str, a: SignalUnit, b: SignalUnit, run: &Run| {
        Err(Error::bad_data(format!("{what} of different quantities"))
            .file(&run.file)
            .field("units")
            .found(b.name())
            .expected(a.name())
            .help(
                "estimate them apart: `-` in the list of `units` leaves a channel out, as in N,-,m/s",
            ))
    };
    let (mut response, mut reference) = (None, None);
    for run in runs {
        for channel in run.responses() {
            let known = *response.get_or_insert(channel.unit);
            if known != channel.unit {
                return disagree("responses", known, channel.unit, run);
            }
        }
        for channel in run.references() {
            let known = *reference.get_or_insert(channel.unit);
            if known != channel.unit {
                return disagree("references", known, channel.unit, run);
            }
        }
    }
    let unit = if reference == Some(SignalUnit::Volt) {
        ReferenceUnit::Volt
    } else {
        ReferenceUnit::Newton
    };
    let kind = match (response, reference) {
        (Some(response), Some(SignalUnit::Force | SignalUnit::Volt)) => response.frf_kind(),
        _ => None,
    };
    Ok((kind, unit))
}
