//! Modes kept or dropped by hand, reproducibly: what a selection does to a model.
//!
//! Out-of-band poles (residual terms) stay; rejected candidates stay listed.

use crate::limits::{AS_SEEN, POINTS_OVER_BAND, POINTS_PER_MODE, SELECTION_SAME_MODE};
use crate::{Error, Finding, FrfKind, ModalModel, Mode, Result, Trust, CREATED_BY};
use serde_json::json;
use std::f64::consts::{FRAC_PI_2, TAU};

/// The modes of a model that stay, and those to be added to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    keep: bool,
    picks: Vec<ModePick>,
    added_hz: Vec<f64>,
    /// The model is fitted with the added ones.
    is_fitted: bool,
}

/// One mode that a selection names, and where it does.
#[derive(Debug, Clone, PartialEq)]
pub struct ModePick {
    /// The mode meant.
    pub name: ModeName,
    /// Line of the selection file, from 1; 0 where there is none.
    pub line: u64,
    /// Field of the selection file, for errors.
    pub field: String,
}

/// A mode by its number or by its frequency, or all sure ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModeName {
    /// In the table of modes, from 1.
    Number(usize),
    /// The mode within `within_hz` of `near_hz`.
    Frequency {
        /// Frequency that is sought, Hz.
        near_hz: f64,
        /// Largest distance, Hz.
        within_hz: f64,
    },
    /// All sure modes.
    Sure,
}

/// A model after the selection.
#[derive(Debug, Clone, PartialEq)]
pub struct Selected {
    /// The model that is left. Its error and χ² count the dropped part as unexplained.
    pub model: ModalModel,
    /// Number and frequency (Hz) of the modes that are gone.
    pub dropped: Vec<(usize, f64)>,
}

impl Selection {
    /// Keeps the modes picked, or drops them.
    pub fn new(keep: bool, picks: Vec<ModePick>) -> Self {
        Self {
            keep,
            picks,
            added_hz: Vec::new(),
            is_fitted: false,
        }
    }

    /// The same, and modes at these frequencies (Hz) are to be added by a new fit.
    #[must_use]
    pub fn adding(self, added_hz: Vec<f64>) -> Self {
        Self { added_hz, ..self }
    }

    /// Frequencies of the modes that are to be added, Hz.
    pub fn added_hz(&self) -> &[f64] {
        &self.added_hz
    }

    /// The same selection for `after`, which was fitted with the added modes: the modes
    /// that it names in `before` by number or frequency are those nearest to them, and
    /// what was added is kept.
    ///
    /// # Errors
    /// As [`Self::apply`], on `before`.
    pub fn carried(&self, before: &ModalModel, after: &ModalModel) -> Result<Self> {
        let (old, new): (Vec<&Mode>, Vec<&Mode>) = (
            before.in_band_modes().collect(),
            after.in_band_modes().collect(),
        );
        let mut picks = Vec::new();
        for pick in &self.picks {
            if pick.name == ModeName::Sure {
                picks.push(pick.clone());
                continue;
            }
            let found = pick.find(&old)?.into_iter();
            let again =
                found.filter_map(|n| nearest(&new, old[n].frequency_hz, SELECTION_SAME_MODE));
            picks.extend(again.map(|n| pick.numbered(n + 1)));
        }
        if self.keep {
            let all = self.added_hz.iter();
            let added = all.filter_map(|&hz| nearest(&new, hz, AS_SEEN));
            picks.extend(added.map(|n| ModePick {
                name: ModeName::Number(n + 1),
                line: 0,
                field: "add".into(),
            }));
        }
        Ok(Self {
            picks,
            is_fitted: true,
            ..self.clone()
        })
    }

    /// Takes out of `model` what the selection drops.
    ///
    /// # Errors
    /// [`crate::ErrorKind::BadData`] with the line, where a mode that is named does not
    /// exist (naming the nearest) or a frequency fits several.
    pub fn apply(&self, model: &ModalModel) -> Result<Selected> {
        if !self.is_fitted && !self.added_hz.is_empty() {
            return Err(Error::bad_data("a mode is added by a new fit")
                .field("add")
                .found(format!("{} Hz and no FRFs", self.added_hz[0]))
                .expected("the FRFs that the model was fitted to")
                .help("put them beside the model, or name them with `measured`"));
        }
        let modes: Vec<&Mode> = model.in_band_modes().collect();
        let mut named = vec![false; modes.len()];
        for pick in &self.picks {
            pick.find(&modes)?.into_iter().for_each(|n| named[n] = true);
        }
        let mut left = model.clone();
        let mut number = 0;
        let mut dropped = Vec::new();
        left.modes.retain(|mode| {
            let counts = mode.counts();
            number += usize::from(counts);
            let stays = !counts || named[number - 1] == self.keep;
            if !stays {
                dropped.push((number, mode.frequency_hz));
            }
            stays
        });
        left.created_by = CREATED_BY.into();
        self.echo(&mut left, &dropped);
        judge(model, &mut left, dropped.len());
        Ok(Selected {
            model: left,
            dropped,
        })
    }

    /// Appends to the options what was asked for and what went: a model that is selected
    /// twice tells both.
    fn echo(&self, model: &mut ModalModel, dropped: &[(usize, f64)]) {
        let named: Vec<serde_json::Value> =
            self.picks.iter().map(|pick| pick.name.echo()).collect();
        let gone: Vec<serde_json::Value> = dropped
            .iter()
            .map(|(n, f)| json!({"number": n, "frequency_hz": f}))
            .collect();
        let mut entry = json!({ if self.keep { "keep" } else { "drop" }: named, "dropped": gone });
        if !self.added_hz.is_empty() {
            let place = |hz: &f64| json!({ "frequency_hz": hz });
            entry["add"] = self.added_hz.iter().map(place).collect();
        }
        match model
            .options
            .get_mut("selections")
            .and_then(|list| list.as_array_mut())
        {
            Some(list) => list.push(entry),
            None => drop(model.options.insert("selections".into(), json!([entry]))),
        }
    }
}

impl ModeName {
    fn echo(self) -> serde_json::Value {
        match self {
            Self::Number(number) => json!(number),
            Self::Frequency { near_hz, within_hz } => {
                json!({"near_hz": near_hz, "within_hz": within_hz})
            }
            Self::Sure => json!("sure"),
        }
    }
}

impl ModePick {
    /// The mode of this number, named in the same place.
    fn numbered(&self, number: usize) -> Self {
        Self {
            name: ModeName::Number(number),
            ..self.clone()
        }
    }

    /// Indices of the modes meant: one, all of a repeated pole, or all sure ones.
    fn find(&self, modes: &[&Mode]) -> Result<Vec<usize>> {
        let say = |message: &str| {
            Error::bad_data(message)
                .at_line(self.line)
                .field(self.field.clone())
        };
        let show = |n: usize| format!("mode {} at {:.3} Hz", n + 1, modes[n].frequency_hz);
        let range = match self.name {
            ModeName::Number(number) if (1..=modes.len()).contains(&number) => number - 1..number,
            ModeName::Number(number) => {
                let error = say("no such mode")
                    .found(number)
                    .expected(match modes.len() {
                        0 => "nothing: the model has no mode in its band".into(),
                        count => format!("1 to {count}: the model's modes in the band"),
                    });
                return Err(if modes.is_empty() {
                    error
                } else {
                    error.help(format!("the nearest is {}", show(modes.len() - 1)))
                });
            }
            ModeName::Frequency { near_hz, within_hz } => {
                let off = |n: usize| (modes[n].frequency_hz - near_hz).abs();
                let near: Vec<usize> = (0..modes.len()).filter(|&n| off(n) <= within_hz).collect();
                let (Some(&first), Some(&last)) = (near.first(), near.last()) else {
                    let error = say("no mode there")
                        .found(format!("near_hz = {near_hz}, within_hz = {within_hz}"));
                    let nearest = (0..modes.len()).min_by(|&a, &b| off(a).total_cmp(&off(b)));
                    let error = error.expected("the frequency of a mode in the band");
                    return Err(match nearest {
                        Some(n) => {
                            error.help(format!("the nearest is {}, {:.3} Hz away", show(n), off(n)))
                        }
                        None => error,
                    });
                };
                if modes[first].frequency_hz != modes[last].frequency_hz {
                    return Err(say("several modes lie there")
                        .found(near.iter().map(|&n| show(n)).collect::<Vec<_>>().join(", "))
                        .expected("one mode (or those of a repeated pole)")
                        .help("make within_hz smaller, or name the modes by number"));
                }
                first..last + 1
            }
            ModeName::Sure => {
                let is_sure = |n: &usize| modes[*n].trust == Trust::Sure;
                let sure: Vec<usize> = (0..modes.len()).filter(is_sure).collect();
                return match sure.is_empty() {
                    true => Err(say("no mode is sure")
                        .found(format!("{} weak modes", modes.len()))
                        .expected("at least one sure mode")
                        .help("name modes by their numbers")),
                    false => Ok(sure),
                };
            }
        };
        Ok(range.collect())
    }
}

/// Quality of what is left. A dropped mode leaves the synthesis, and nothing is fitted
/// again: its part joins the residual, to which it is orthogonal as every part of a
/// least-squares fit, ε'² = ε² + (1 − ε²)·‖dropped part‖²/‖whole model‖² (ε relative
/// error; theory.md, eq. F6), and χ² grows as ε².
fn judge(whole: &ModalModel, left: &mut ModalModel, dropped: usize) {
    if dropped == 0 {
        return;
    }
    let before = whole.quality.relative_error.powi(2);
    let after = before + (1.0 - before).max(0.0) * dropped_share(whole, left);
    left.quality.relative_error = after.sqrt();
    if before > 0.0 {
        left.quality.chi2_per_dof *= after / before;
    }
    left.quality.findings.push(
        Finding::caution(
            "dropped-by-hand",
            format!(
                "modes dropped by hand: {dropped}; nothing was fitted again, so their part counts as \
                 unexplained, and the relative error is {:.3} instead of {:.3} (computed from the \
                 model, without the FRFs)",
                after.sqrt(),
                before.sqrt()
            ),
        )
        .value("modes_dropped", dropped as f64)
        .value("relative_error", after.sqrt())
        .help(
            "keep modes whose part counts: poles stay as they were fitted beside the dropped ones",
        ),
    );
    if !left.in_band_modes().any(|mode| mode.trust == Trust::Sure) {
        left.quality.trusted = false;
        left.quality.findings.push(
            Finding::fault("none-sure-left", "no sure mode is left after the selection")
                .help("keep a sure mode"),
        );
    }
}

/// ‖whole − left‖²/‖whole‖² over the band, in the measured kind, by the trapezoidal rule
/// on a grid that resolves every mode.
fn dropped_share(whole: &ModalModel, left: &ModalModel) -> f64 {
    let grid = grid(whole);
    let mut sums = [0.0; 2];
    for k in 0..grid.len() {
        let weight = grid[(k + 1).min(grid.len() - 1)] - grid[k.saturating_sub(1)];
        let all = whole.receptance(grid[k]);
        let gone = &all - &left.receptance(grid[k]);
        let square = |m: &ndarray::Array2<num_complex::Complex64>| {
            m.iter().map(|v| v.norm_sqr()).sum::<f64>()
        };
        let kind = kind_weight(whole.frf_kind, grid[k]);
        sums[0] += weight * kind * square(&gone);
        sums[1] += weight * kind * square(&all);
    }
    if sums[1] > 0.0 {
        sums[0] / sums[1]
    } else {
        0.0
    }
}

/// Place of the mode nearest to `hz`, no farther than so many half-bandwidths, or that part of `hz`.
fn nearest(modes: &[&Mode], hz: f64, (half_widths, part): (f64, f64)) -> Option<usize> {
    let off = |n: &usize| (modes[*n].frequency_hz - hz).abs();
    let near = (0..modes.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
    let half_width = 0.5 * modes[near].loss_factor * modes[near].frequency_hz;
    (off(&near) <= (half_widths * half_width).max(part * hz)).then_some(near)
}

impl ModalModel {
    /// The in-band mode, rejected ones too, that came of adding one at `hz` (Hz), where a reader
    /// saw it; `None` where no mode lies so near.
    pub fn mode_seen_at(&self, hz: f64) -> Option<&Mode> {
        let modes: Vec<&Mode> = self.modes.iter().filter(|mode| mode.in_band).collect();
        nearest(&modes, hz, AS_SEEN).map(|n| modes[n])
    }
}

fn kind_weight(kind: FrfKind, frequency_hz: f64) -> f64 {
    kind.from_receptance(TAU * frequency_hz).norm_sqr()
}

/// Frequencies over the band, Hz: even ones, and around each mode f_n + (η_n f_n/2)·tan θ
/// with even θ, which follow its resonance.
fn grid(model: &ModalModel) -> Vec<f64> {
    let [low, high] = model.band_hz;
    let even =
        (0..=POINTS_OVER_BAND).map(|k| low + (high - low) * k as f64 / POINTS_OVER_BAND as f64);
    let around = model.in_band_modes().flat_map(|mode| {
        let half_width = 0.5 * mode.loss_factor.abs() * mode.frequency_hz;
        (0..POINTS_PER_MODE).map(move |k| {
            let angle = FRAC_PI_2 * (2.0 * (k as f64 + 0.5) / POINTS_PER_MODE as f64 - 1.0);
            mode.frequency_hz + half_width * angle.tan()
        })
    });
    let mut grid: Vec<f64> = even
        .chain(around)
        .filter(|f| (low..=high).contains(f) && *f > 0.0)
        .collect();
    grid.sort_by(f64::total_cmp);
    grid
}
