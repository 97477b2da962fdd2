//! FRFs from local fits to the transforms of whole records, of runs with the same
//! references.

use super::force_noise::{corrections, Correction, ForceNoise};
use super::local_basis::{LocalLine, LocalLines};
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
        let fit = RunFit::new(setting, run, group);
        let responses: Vec<&Channel> = moving(run).collect();
        for set in responses.chunks(fit.responses_together()) {
            let response_spectra = spectra(set, fit.samples);
            let share = |channel: &Channel| {
                let all = measured.get(&channel.dof).map_or(1, |sum| sum.0);
                run.samples() as f64 / all as f64
            };
            let part = TablePart {
                rows: set
                    .iter()
                    .map(|channel| (table.row(channel.dof), share(channel)))
                    .collect(),
                columns: &columns,
            };
            let mut force_noise = Vec::with_capacity(setting.grid.count);
            for first in (0..setting.grid.count).step_by(BATCH) {
                let end = (first + BATCH).min(setting.grid.count);
                let fitted: Vec<Option<LocalLine>> = (first..end)
                    .into_par_iter()
                    .map(|k| fit.line(k, &response_spectra))
                    .collect();
                force_noise.extend(fitted.iter().map(|line| line.as_ref()?.force_noise));
                for (k, line) in (first..end).zip(fitted) {
                    part.store(table, k, line);
                }
            }
            // a mean of several records would need the force of each
            if part.rows.iter().all(|&(_, share)| share == 1.0) {
                let record_s = fit.samples as f64 / run.sample_rate_hz;
                part.correct(table, &force_noise, setting.grid.step(record_s));
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

/// Local fits of one run.
struct RunFit<'a> {
    setting: &'a LocalSetting,
    run: &'a Run,
    /// Samples of its transform.
    samples: usize,
    /// Spectra of its references, in the order of the group.
    references: Vec<Vec<Complex64>>,
}

impl<'a> RunFit<'a> {
    fn new(setting: &'a LocalSetting, run: &'a Run, group: &Group) -> Self {
        let samples = smooth_length(run.samples());
        let references: Vec<&Channel> = group
            .references
            .iter()
            .filter_map(|dof| run.references().find(|channel| channel.dof == *dof))
            .collect();
        Self {
            setting,
            run,
            samples,
            references: spectra(&references, samples),
        }
    }

    /// Responses whose spectra are held at a time.
    fn responses_together(&self) -> usize {
        let room = SPECTRA_BYTES / (size_of::<Complex64>() * self.samples / 2).max(1);
        room.saturating_sub(self.references.len()).max(1)
    }

    /// FRFs of each response at frequency `k`; `None` where they cannot be told.
    fn line(&self, k: usize, responses: &[Vec<Complex64>]) -> Option<LocalLine> {
        let grid = &self.setting.grid;
        let lines = grid.lines(k, self.samples, self.run.sample_rate_hz);
        let local = LocalLines {
            places: lines.places().collect(),
            references: self
                .references
                .iter()
                .map(|s| &s[lines.range.clone()])
                .collect(),
            responses: responses.iter().map(|s| &s[lines.range.clone()]).collect(),
        };
        match self.setting.estimator {
            Estimator::Lpm => lpm::estimate(&local),
            _ => lrm::estimate(&local),
        }
    }
}

/// The part of a table that some responses of a run fill.
struct TablePart<'a> {
    /// Row of each response, and the share of this record in its mean.
    rows: Vec<(usize, f64)>,
    columns: &'a [usize],
}

impl TablePart<'_> {
    /// Adds the line of frequency `k`.
    fn store(&self, table: &mut Table, k: usize, line: Option<LocalLine>) {
        let unknown = (Complex64::new(f64::NAN, f64::NAN), f64::NAN);
        for (index, &(row, share)) in self.rows.iter().enumerate() {
            let of = line.as_ref().map(|line| &line.responses[index]);
            if of.is_none() {
                table.mask(k);
            }
            let coherence = of.map_or(f64::NAN, |of| of.coherence);
            for (j, &column) in self.columns.iter().enumerate() {
                let value = of.map_or(unknown, |of| of.values[j]);
                table.add([row, column, k], value, coherence, share);
            }
        }
    }

    /// Undoes what noise in the record of the force takes from the FRFs.
    ///
    /// * `step`: lines of the record from one frequency to the next
    fn correct(&self, table: &mut Table, force_noise: &[Option<ForceNoise>], step: f64) {
        let Some(corrections) = corrections(force_noise, step) else {
            return;
        };
        for &(k, correction) in &corrections {
            for &(row, _) in &self.rows {
                self.columns
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
}
