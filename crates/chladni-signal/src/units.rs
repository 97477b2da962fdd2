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
            .help("estimate them apart"))
    };
    let mut seen: [Option<SignalUnit>; 2] = [None, None];
    for run in runs {
        for channel in &run.channels {
            let slot = &mut seen[usize::from(channel.is_reference)];
            match *slot {
                Some(known) if known != channel.unit => {
                    return disagree(
                        if channel.is_reference {
                            "references"
                        } else {
                            "responses"
                        },
                        known,
                        channel.unit,
                        run,
                    )
                }
                _ => *slot = Some(channel.unit),
            }
        }
    }
    let unit = if seen[1] == Some(SignalUnit::Volt) {
        ReferenceUnit::Volt
    } else {
        ReferenceUnit::Newton
    };
    let kind = match (seen[0], seen[1]) {
        (Some(response), Some(SignalUnit::Force | SignalUnit::Volt)) => response.frf_kind(),
        _ => None,
    };
    Ok((kind, unit))
}
