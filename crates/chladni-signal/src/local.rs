//! FRFs from local fits to the transforms of whole records, of runs with the same
//! references.

use super::lpm::{LocalEstimate, Window};
use super::setting::LocalSetting;
use super::table::Table;
use super::whole_record::{smooth_length, spectrum};
use super::{lpm, lrm, Group};
use crate::limits::{BATCH, SPECTRA_BYTES};
use chladni_frf::{Channel, Dof, Estimator, Run};
use num_complex::Complex64;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Adds the FRFs of a group. A response of several runs is averaged, each run by its
/// length.
pub(super) fn add_group(table: &mut Table, group: &Group, setting: &LocalSetting) {
    let measured = measured(group);
    for (_, records) in measured.values() {
        table.count(*records);
    }
    let columns = table.columns(group);
    for &response in &group.responses {
        let row = table.row(response);
        columns
            .iter()
            .for_each(|&column| table.start_mean(row, column));
    }
    for run in group.runs {
        let samples = smooth_length(run.samples());
        let references: Vec<&Channel> = group
            .references
            .iter()
            .filter_map(|dof| run.references().find(|channel| channel.dof == *dof))
            .collect();
        let responses: Vec<&Channel> = run.responses().collect();
        let reference_spectra = spectra(&references, samples);
        let room = SPECTRA_BYTES / (size_of::<Complex64>() * samples / 2).max(1);
        let together = room.saturating_sub(references.len()).max(1);
        for set in responses.chunks(together) {
            let response_spectra = spectra(set, samples);
            let share = |channel: &Channel| {
                let all = measured.get(&channel.dof).map_or(1, |sum| sum.0);
                run.samples() as f64 / all as f64
            };
            let rows: Vec<(usize, f64)> = set
                .iter()
                .map(|channel| (table.row(channel.dof), share(channel)))
                .collect();
            for first in (0..setting.grid.count).step_by(BATCH) {
                let end = (first + BATCH).min(setting.grid.count);
                let fitted: Vec<Option<Vec<LocalEstimate>>> = (first..end)
                    .into_par_iter()
                    .map(|k| {
                        fit(
                            setting,
                            run,
                            samples,
                            k,
                            &reference_spectra,
                            &response_spectra,
                        )
                    })
                    .collect();
                for (k, line) in (first..end).zip(fitted) {
                    store(table, k, line, &rows, &columns);
                }
            }
        }
    }
}

/// Samples and records of each response.
fn measured(group: &Group) -> BTreeMap<Dof, (usize, usize)> {
    let mut measured: BTreeMap<Dof, (usize, usize)> = BTreeMap::new();
    for run in group.runs {
        for channel in run.responses() {
            let sum = measured.entry(channel.dof).or_default();
            *sum = (sum.0 + run.samples(), sum.1 + 1);
        }
    }
    measured
}

fn spectra(channels: &[&Channel], samples: usize) -> Vec<Vec<Complex64>> {
    channels
        .par_iter()
        .map(|channel| spectrum(&channel.samples[..samples]))
        .collect()
}

/// FRFs of each response at frequency `k`; `None` where they cannot be told.
fn fit(
    setting: &LocalSetting,
    run: &Run,
    samples: usize,
    k: usize,
    references: &[Vec<Complex64>],
    responses: &[Vec<Complex64>],
) -> Option<Vec<LocalEstimate>> {
    let lines = setting.grid.lines(k, samples, run.sample_rate_hz);
    let window = Window {
        places: lines.places().collect(),
        references: references.iter().map(|s| &s[lines.range.clone()]).collect(),
        responses: responses.iter().map(|s| &s[lines.range.clone()]).collect(),
    };
    match setting.estimator {
        Estimator::Lpm => lpm::estimate(&window),
        _ => lrm::estimate(&window),
    }
}

/// Adds line `k` of some responses; `rows` are their places and the shares of this record.
fn store(
    table: &mut Table,
    k: usize,
    line: Option<Vec<LocalEstimate>>,
    rows: &[(usize, f64)],
    columns: &[usize],
) {
    let unknown = (Complex64::new(f64::NAN, f64::NAN), f64::NAN);
    for (index, &(row, share)) in rows.iter().enumerate() {
        let of = line.as_ref().map(|line| &line[index]);
        if of.is_none() {
            table.mask();
        }
        let coherence = of.map_or(f64::NAN, |of| of.coherence);
        for (j, &column) in columns.iter().enumerate() {
            let value = of.map_or(unknown, |of| of.values[j]);
            table.add([row, column, k], value, coherence, share);
        }
    }
}
