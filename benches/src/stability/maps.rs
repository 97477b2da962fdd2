//! The maps: which two things are turned, and over what range.

use super::drives::{self, Stage};
use super::measured;
use super::trial::{Measured, Trial};
use crate::solver::Solver;
use chladni_frf::Result;
use chladni_render::MethodChoice;

/// One axis of a map.
#[derive(Debug, Clone, Copy)]
pub struct MapAxis {
    /// Column of the table.
    pub column: &'static str,
    /// Label of the figure.
    pub label: &'static str,
    /// Unit of the figure; `–` for a plain number.
    pub unit: &'static str,
    values: &'static [f64],
    words: &'static [&'static str],
}

impl MapAxis {
    /// Steps of the axis.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True without steps.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Value number `k`.
    pub fn value(&self, k: usize) -> f64 {
        self.values[k]
    }

    /// The same as it is written.
    pub fn text(&self, k: usize) -> String {
        self.words
            .get(k)
            .map_or_else(|| self.values[k].to_string(), ToString::to_string)
    }
}

/// Seeds that belong to one cell; the next cell begins after them.
const SEEDS_OF_A_CELL: u64 = 1_000_000;

#[derive(Debug, Clone, Copy)]
enum Make {
    Fit(fn(f64, f64, u64) -> Result<Measured>),
    Drive(fn(&Stage, MethodChoice, f64, f64, u64) -> Result<Trial>),
}

/// A map: a grid of cells, in each the same tries with other seeds.
#[derive(Debug, Clone, Copy)]
pub struct Map {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// The quantities turned, in a sentence.
    pub about: &'static str,
    /// Horizontal.
    pub x: MapAxis,
    /// Vertical.
    pub y: MapAxis,
    make: Make,
}

const fn axis(
    column: &'static str,
    label: &'static str,
    unit: &'static str,
    values: &'static [f64],
) -> MapAxis {
    MapAxis {
        column,
        label,
        unit,
        values,
        words: &[],
    }
}

const SNR: MapAxis = axis(
    "snr_db",
    "Signal to noise",
    "dB",
    &[0.0, 10.0, 20.0, 30.0, 40.0, 60.0],
);
const LINES: MapAxis = axis(
    "lines_per_bandwidth",
    "Lines per bandwidth",
    "–",
    &[0.3, 0.6, 1.0, 2.0, 4.0, 8.0],
);

/// All maps, those of identification first.
pub const MAPS: [Map; 12] = [
    Map {
        name: "snr-overlap",
        about: "8 modes, 12 FRFs, white noise",
        x: SNR,
        y: axis(
            "modal_overlap",
            "Modal overlap",
            "–",
            &[0.05, 0.2, 0.5, 1.0, 2.0, 3.0],
        ),
        make: Make::Fit(measured::snr_overlap),
    },
    Map {
        name: "spacing-references",
        about: "three pairs of modes, 6 responses, 40 dB, 4 lines per bandwidth",
        x: axis(
            "spacing_bandwidths",
            "Distance within a pair",
            "bandwidths",
            &[0.03, 0.06, 0.1, 0.2, 0.4, 1.0],
        ),
        y: axis("references", "References", "–", &[1.0, 2.0, 3.0, 4.0]),
        make: Make::Fit(measured::spacing_references),
    },
    Map {
        name: "order-conditioning",
        about: "8 modes, the order given and wrong, bands of one third of an octave to ten \
                octaves, 40 dB",
        x: axis(
            "modes_asked_less_present",
            "Modes asked for less modes \
                                             present",
            "–",
            &[-2.0, -1.0, 0.0, 1.0, 3.0, 6.0],
        ),
        y: axis(
            "band_ratio",
            "Upper over lower end of the \
                               band",
            "–",
            &[1.25, 3.0, 10.0, 30.0, 100.0],
        ),
        make: Make::Fit(measured::order_conditioning),
    },
    Map {
        name: "lines-snr",
        about: "8 separate modes, 12 FRFs, white \
                                     noise",
        x: LINES,
        y: SNR,
        make: Make::Fit(measured::lines_snr),
    },
    Map {
        name: "outside-residuals",
        about:
            "8 modes inside, four modes 4 and 12 bandwidths outside both ends of the band, 40 dB",
        x: axis(
            "outside_level_db",
            "Modes outside over modes \
                                     inside",
            "dB",
            &[-20.0, 0.0, 10.0, 20.0, 30.0, 40.0],
        ),
        y: axis(
            "residual_terms",
            "Residual terms in the data",
            "–",
            &[0.0, 1.0, 2.0, 3.0, 4.0],
        ),
        make: Make::Fit(measured::outside_residuals),
    },
    Map {
        name: "damping-law",
        about: "6 modes of overlap 0.3 at any damping, 12 FRFs, 60 dB; the law decided by the \
                data, or the wrong one forced",
        x: axis(
            "loss_factor",
            "Loss factor of all modes",
            "–",
            &[0.003, 0.01, 0.03, 0.1, 0.2, 0.4],
        ),
        y: MapAxis {
            words: &[
                "structural",
                "viscous",
                "structural as viscous",
                "viscous as structural",
            ],
            ..axis("law", "Law", "and as fitted", &[0.0, 1.0, 2.0, 3.0])
        },
        make: Make::Fit(measured::damping_law),
    },
    Map {
        name: "outliers",
        about: "8 separate modes, 12 FRFs, 40 dB; values replaced at random places",
        x: axis(
            "outlier_share",
            "Share of outliers",
            "–",
            &[0.0, 0.0003, 0.001, 0.003, 0.01, 0.03],
        ),
        y: axis(
            "outlier_size",
            "Size over the rms of the \
                                 data",
            "–",
            &[0.1, 0.3, 1.0, 3.0, 10.0, 100.0],
        ),
        make: Make::Fit(measured::outliers_share),
    },
    Map {
        name: "window-lines",
        about:
            "5 viscous modes, 4 responses, simulated in time and estimated with this window, 40 dB",
        x: axis(
            "lines_per_bandwidth",
            "Lines per bandwidth",
            "–",
            &[0.5, 1.0, 2.0, 4.0, 8.0, 16.0],
        ),
        y: MapAxis {
            words: &[
                "hammer, none",
                "hammer, exp. untold",
                "hammer, exp. told",
                "burst, none",
                "random, Hann untold",
                "random, Hann told",
            ],
            ..axis(
                "window",
                "Window",
                "as told",
                &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
            )
        },
        make: Make::Fit(measured::window_lines),
    },
    Map {
        name: "scatter-frfs",
        about: "8 separate modes whose frequencies move from FRF to FRF, 40 dB",
        x: axis(
            "scatter_bandwidths",
            "Scatter of natural \
                                       frequencies",
            "bandwidths",
            &[0.0, 0.003, 0.01, 0.03, 0.1, 0.3],
        ),
        y: axis("frfs", "FRFs", "–", &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0]),
        make: Make::Fit(measured::scatter_frfs),
    },
    Map {
        name: "render-error-ridge",
        about: "one quarter of the glass panel, 300 Hz; natural frequencies of the model moved \
                before the drive is sought",
        x: axis(
            "model_error",
            "Error of natural frequencies, \
                                rms",
            "–",
            &[0.0, 3e-4, 1e-3, 3e-3, 1e-2],
        ),
        y: axis(
            "isotropic_relative",
            "Regularisation: isotropic error \
                                       assumed",
            "–",
            &[0.0, 1e-3, 3e-3, 1e-2, 3e-2],
        ),
        make: Make::Drive(drives::error_ridge),
    },
    Map {
        name: "render-frequency-touch",
        about: "one quarter of the glass panel; a fingertip in the hot zone that the model does \
                not know",
        x: axis(
            "frequency_hz",
            "Drive frequency",
            "Hz",
            &[255.0, 275.0, 300.0, 320.0, 335.0, 345.0],
        ),
        y: axis(
            "touch",
            "Impedance over that of a light touch",
            "–",
            &[0.0, 0.03, 0.1, 0.3, 1.0],
        ),
        make: Make::Drive(drives::frequency_touch),
    },
    Map {
        name: "render-actuators-zones",
        about: "one of n × n cells of the glass panel, 300 Hz",
        x: axis(
            "actuators",
            "Actuators",
            "–",
            &[3.0, 6.0, 9.0, 12.0, 20.0, 34.0],
        ),
        y: axis(
            "cells_per_side",
            "Cells along each side",
            "–",
            &[2.0, 3.0, 4.0, 5.0],
        ),
        make: Make::Drive(drives::actuators_zones),
    },
];

impl Map {
    /// The map of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        MAPS.iter().find(|map| map.name == name)
    }

    /// True where it tries methods of identification.
    pub fn identifies(&self) -> bool {
        matches!(self.make, Make::Fit(_))
    }

    /// True where white noise is all that stands between data and model, and the fit is
    /// free to decide: error bars must hold.
    pub fn calibrates(&self) -> bool {
        matches!(
            self.name,
            "snr-overlap" | "spacing-references" | "lines-snr" | "outside-residuals"
        )
    }

    /// The seed of shapes and noise in a cell: each cell has its own, so that what chance
    /// does in one says nothing of the next.
    fn seed_of(&self, [x, y]: [usize; 2], seed: u64) -> u64 {
        seed + SEEDS_OF_A_CELL * (self.x.len() * y + x) as u64
    }

    /// One try in the cell (x, y); `None` where the solver is of the other kind.
    pub(super) fn try_once(
        &self,
        stage: Option<&Stage>,
        solver: Solver,
        cell: [usize; 2],
        seed: u64,
    ) -> Result<Option<Trial>> {
        let (x, y, seed) = (
            self.x.value(cell[0]),
            self.y.value(cell[1]),
            self.seed_of(cell, seed),
        );
        Ok(match (self.make, solver, stage) {
            (Make::Fit(make), Solver::Identify(method), _) => {
                Some(Trial::identify(&make(x, y, seed)?, method))
            }
            (Make::Drive(make), Solver::Render(method), Some(stage)) => {
                Some(make(stage, method, x, y, seed)?)
            }
            _ => None,
        })
    }

    /// The measurement of a cell, where the map has one.
    pub(super) fn measured(&self, cell: [usize; 2], seed: u64) -> Result<Option<Measured>> {
        match self.make {
            Make::Fit(make) => make(
                self.x.value(cell[0]),
                self.y.value(cell[1]),
                self.seed_of(cell, seed),
            )
            .map(Some),
            Make::Drive(_) => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_words_are_as_many_as_values() {
        for (k, map) in MAPS.iter().enumerate() {
            assert!(MAPS[..k].iter().all(|other| other.name != map.name));
            for axis in [map.x, map.y] {
                assert!((1..=6).contains(&axis.len()), "{}", map.name);
                assert!(
                    axis.words.is_empty() || axis.words.len() == axis.len(),
                    "{}",
                    map.name
                );
            }
        }
    }

    #[test]
    fn every_corner_of_every_map_of_identification_can_be_measured() {
        for map in MAPS.iter().filter(|map| map.identifies()) {
            for cell in [
                [0, 0],
                [map.x.len() - 1, 0],
                [0, map.y.len() - 1],
                [map.x.len() - 1, map.y.len() - 1],
            ] {
                let measured = map.measured(cell, 1).unwrap().expect("a measurement");
                assert!(
                    measured.problem.truth.in_band_modes().count() >= 5,
                    "{} {cell:?}",
                    map.name
                );
                let again = map.measured(cell, 1).unwrap().expect("a measurement");
                assert_eq!(
                    measured.frf.values, again.frf.values,
                    "{} {cell:?}: the same seed, the same bits",
                    map.name
                );
            }
        }
    }
}
