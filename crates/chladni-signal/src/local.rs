//! FRFs from local fits to the transforms of whole records, of runs with the same
//! references.

use super::force_noise::{corrections, Correction, ForceNoise};
use super::lpm::{LocalLine, Window};
use super::setting::LocalSetting;
use super::still::moving;
use super::table::Table;
use super::whole_record::{smooth_length, spectrum};
use super::{lpm, lrm, Group};
use crate::limits::{BATCH, SPECTRA_BYTES};
use chladni_frf::{Channel, Dof, Estimator, Finding, Run};
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
        let responses: Vec<&Channel> = moving(run).collect();
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
            let mut force_noise = Vec::with_capacity(setting.grid.count);
            for first in (0..setting.grid.count).step_by(BATCH) {
                let end = (first + BATCH).min(setting.grid.count);
                let fitted: Vec<Option<LocalLine>> = (first..end)
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
                force_noise.extend(fitted.iter().map(|line| line.as_ref()?.force_noise));
                for (k, line) in (first..end).zip(fitted) {
                    store(table, k, line, &rows, &columns);
                }
            }
            // a mean of several records would need the force of each
            if rows.iter().all(|&(_, share)| share == 1.0) {
                correct(table, &force_noise, &rows, &columns);
            }
        }
    }
}

/// Samples and records of each response, where it moves.
fn measured(group: &Group) -> BTreeMap<Dof, (usize, usize)> {
    let mut measured: BTreeMap<Dof, (usize, usize)> = BTreeMap::new();
    for run in group.runs {
        for channel in moving(run) {
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
) -> Option<LocalLine> {
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
    line: Option<LocalLine>,
    rows: &[(usize, f64)],
    columns: &[usize],
) {
    let unknown = (Complex64::new(f64::NAN, f64::NAN), f64::NAN);
    for (index, &(row, share)) in rows.iter().enumerate() {
        let of = line.as_ref().map(|line| &line.responses[index]);
        if of.is_none() {
            table.mask(k);
        }
        let coherence = of.map_or(f64::NAN, |of| of.coherence);
        for (j, &column) in columns.iter().enumerate() {
            let value = of.map_or(unknown, |of| of.values[j]);
            table.add([row, column, k], value, coherence, share);
        }
    }
}

/// Undoes what noise in the record of the force takes from the FRFs of some responses.
fn correct(
    table: &mut Table,
    force_noise: &[Option<ForceNoise>],
    rows: &[(usize, f64)],
    columns: &[usize],
) {
    let Some(corrections) = corrections(force_noise) else {
        return;
    };
    for &(k, correction) in &corrections {
        for &(row, _) in rows {
            columns
                .iter()
                .for_each(|&column| table.correct([row, column, k], correction));
        }
    }
    let of_line = |(_, correction): &(usize, Correction)| 1.0 - 1.0 / correction.factor;
    let mut shares: Vec<f64> = corrections.iter().map(of_line).collect();
    shares.sort_by(f64::total_cmp);
    let (usual, most) = (shares[shares.len() / 2], shares[shares.len() - 1]);
    let noise_db = 10.0 * usual.max(f64::MIN_POSITIVE).log10();
    let words = format!(
        "noise in the record of the force, {noise_db:.0} dB beside it on the median line: all \
         responses share its errors; their FRFs were raised for it, by up to {:.2} %",
        100.0 * most / (1.0 - most)
    );
    table.warn_once(
        Finding::note("force-noise", words)
            .value("noise_db", noise_db)
            .value("largest_share", most)
            .help("amplify the force sensor's signal, or drive harder where the force drops"),
    );
}
