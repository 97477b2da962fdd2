//! The bands of the method of 1982: few visible peaks in each, and the order there.
//!
//! The 1982 method is applied by hand, a few peaks at a time. Here a band with more than
//! [`PEAKS_PER_BAND`] visible peaks of the mean |FRF|² is cut at the deepest valley
//! between two of them (deep relative to the lower of its two peaks, and leaving at least
//! a quarter of the peaks on each side), again and again. Each band gets one pole pair
//! per peak, its share of the modes asked for beyond the peaks, and [`SPARE_PAIRS`] more.
//! The spare pairs take up noise and what lies outside the band; which poles are modes is
//! decided afterwards.

use crate::data::options::FitOptions;
use crate::data::peaks::Peak;
use crate::data::screening::Screened;
use crate::methods::equation_error::largest_order;
use crate::methods::limits::{
    CUT_LEAVES_ONE_IN, LINES_IN_PARTS, ORDER_HELD, PEAKS_PER_BAND, SPARE_PAIRS,
};
use crate::methods::survey::Survey;
use chladni_frf::Finding;
use ndarray::Array1;
use std::f64::consts::TAU;
use std::ops::Range;

/// Rows of the data fitted together, with the number of pole pairs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Band {
    /// Rows of the screened lines.
    pub rows: Range<usize>,
    /// Pole pairs of the denominator.
    pub order: usize,
}

/// All bands, and what a user should know about their choice.
#[derive(Debug)]
pub(crate) struct BandPlan {
    /// Bands, rising in frequency, without gaps or overlap.
    pub bands: Vec<Band>,
    /// In words.
    pub warnings: Vec<Finding>,
}

impl BandPlan {
    /// Peaks, cuts, orders. No bands where nothing stands out and no number of modes was
    /// asked for.
    pub fn new(survey: &Survey, options: &FitOptions) -> Self {
        let data = survey.data;
        let mean = &survey.energy / data.pairs.len() as f64;
        let mut visible = survey.peaks.clone();
        visible.truncate(options.modes.unwrap_or(usize::MAX));
        visible.sort_by_key(|peak| peak.row);
        let mut warnings = Vec::new();
        if visible.is_empty() && options.modes.is_none() {
            warnings.push(
                Finding::caution(
                    "no-peak",
                    "no peak stands out of the noise, so no order can be chosen",
                )
                .help("say how many modes the band holds"),
            );
            return Self {
                bands: Vec::new(),
                warnings,
            };
        }
        let mut bands = Vec::new();
        split(&visible, &mean, 0..data.x.len(), &mut bands);
        share(&mut bands, visible.len(), options.modes);
        for band in &mut bands {
            let label = in_hertz(data, &band.rows);
            let most = largest_order(band.rows.len(), data.kind.omega_power() as usize);
            if band.order > most {
                if band.order >= most + SPARE_PAIRS {
                    let lines = band.rows.len();
                    warnings.push(
                        Finding::caution(
                            "few-lines",
                            format!(
                                "{label}: {lines} lines support {most} pole pairs, none to spare \
                                 for noise"
                            ),
                        )
                        .help("widen the band, or measure finer lines"),
                    );
                }
                band.order = most;
            }
            if band.order > ORDER_HELD {
                warnings.push(
                    Finding::caution(
                        "order-too-high",
                        format!(
                            "{label}: {} pole pairs ({SPARE_PAIRS} of them spare) are more than \
                             this method holds in one band ({ORDER_HELD}): expect missed and \
                             spurious modes",
                            band.order
                        ),
                    )
                    .value("pole_pairs", band.order as f64)
                    .help("fit narrower bands, or use the method auto"),
                );
            }
        }
        Self { bands, warnings }
    }
}

/// "12.5 to 80 Hz".
pub(crate) fn in_hertz(data: &Screened, rows: &Range<usize>) -> String {
    let hz = |row: usize| data.x[row].sqrt() * data.omega_max / TAU;
    format!("{:.5} to {:.5} Hz", hz(rows.start), hz(rows.end - 1))
}

/// Cuts `rows` until no band holds more than [`PEAKS_PER_BAND`] of `visible`; the order
/// is the number of peaks for now.
fn split(visible: &[Peak], mean: &Array1<f64>, rows: Range<usize>, bands: &mut Vec<Band>) {
    if visible.len() <= PEAKS_PER_BAND {
        bands.push(Band {
            rows,
            order: visible.len(),
        });
        return;
    }
    let quarter = visible.len() / CUT_LEAVES_ONE_IN;
    let cut = (quarter..visible.len() - quarter - 1)
        .map(|left| {
            let (a, b) = (visible[left].row, visible[left + 1].row);
            let valley = (a..=b)
                .min_by(|p, q| mean[*p].total_cmp(&mean[*q]))
                .unwrap_or(a);
            (
                left,
                valley,
                mean[a].min(mean[b]) / mean[valley].max(f64::MIN_POSITIVE),
            )
        })
        .max_by(|p, q| p.2.total_cmp(&q.2));
    let Some((left, valley, _)) = cut else { return };
    split(&visible[..=left], mean, rows.start..valley, bands);
    split(&visible[left + 1..], mean, valley..rows.end, bands);
}

/// Modes asked for beyond the visible peaks go to the bands with most lines per mode;
/// then every band gets its spare pair.
fn share(bands: &mut [Band], visible: usize, asked: Option<usize>) {
    for _ in visible..asked.unwrap_or(visible) {
        if let Some(roomy) = bands
            .iter_mut()
            .max_by_key(|band| LINES_IN_PARTS * band.rows.len() / (band.order + 1))
        {
            roomy.order += 1;
        }
    }
    bands.iter_mut().for_each(|band| band.order += SPARE_PAIRS);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::peaks::peaks_at;

    #[test]
    fn a_crowded_band_is_cut_at_its_deepest_valley() {
        let rows: Vec<usize> = (0..10).map(|n| 10 + 20 * n).collect();
        let mut mean = Array1::from_shape_fn(220, |k| if rows.contains(&k) { 100.0 } else { 10.0 });
        mean[21] = 0.001; // deeper still, but it would cut off a single peak
        mean[121] = 1.0;
        let mut bands = Vec::new();
        split(&peaks_at(&rows), &mean, 0..220, &mut bands);
        assert_eq!(
            bands,
            [
                Band {
                    rows: 0..121,
                    order: 6
                },
                Band {
                    rows: 121..220,
                    order: 4
                }
            ]
        );
        share(&mut bands, 10, None);
        assert_eq!(
            [bands[0].order, bands[1].order],
            [6 + SPARE_PAIRS, 4 + SPARE_PAIRS]
        );
    }

    #[test]
    fn modes_without_a_peak_go_where_there_is_room() {
        let mut bands = vec![
            Band {
                rows: 0..100,
                order: 4,
            },
            Band {
                rows: 100..400,
                order: 4,
            },
        ];
        share(&mut bands, 8, Some(10));
        assert_eq!(
            [bands[0].order, bands[1].order],
            [4 + SPARE_PAIRS, 6 + SPARE_PAIRS]
        );
    }
}
