//! Channels that are constant: a cable that is off, or a channel that is not connected.

use chladni_frf::{Channel, Dof, Finding, Run};
use std::collections::BTreeSet;

/// True where all samples of a channel are the same.
pub(super) fn is_still(channel: &Channel) -> bool {
    let first = channel.samples.first();
    channel.samples.iter().all(|sample| Some(sample) == first)
}

/// Responses of a run that move: the others are left out of every average.
pub(super) fn moving(run: &Run) -> impl Iterator<Item = &Channel> {
    run.responses().filter(|channel| !is_still(channel))
}

/// The finding on responses that are constant in some records and move in others.
pub(super) fn still_in_some(runs: &[Run], moves: &BTreeSet<Dof>) -> Option<Finding> {
    let lost = || {
        let of_run = |run| Run::responses(run).map(move |channel| (run, channel));
        let lost =
            |(_, channel): &(&Run, &Channel)| moves.contains(&channel.dof) && is_still(channel);
        runs.iter().flat_map(of_run).filter(lost)
    };
    let (run, first) = lost().next()?;
    let of_first = format!("{} in {}", first.dof, run.file.display());
    let words = match lost().count() {
        1 => format!("the response {of_first} is constant; that record of it is left out"),
        count => format!(
            "{count} records of single responses are constant, and left out; the first is that of \
             {of_first}"
        ),
    };
    let dofs: BTreeSet<Dof> = lost().map(|(_, channel)| channel.dof).collect();
    Some(
        Finding::caution("still-responses", words)
            .dofs(dofs)
            .help(HELP),
    )
}

/// The next step where a response is constant.
pub(super) const HELP: &str = "look at the cable and the sensor of that channel";
