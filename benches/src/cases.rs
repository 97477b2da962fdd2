//! The named cases: each a question that practice asks, with its truth and its seeds
//! fixed.

use crate::problem::Problem;
use chladni_frf::Result;
use chladni_plate::{Panel, Synthetic};
use ndarray::Array1;

/// The goals of the fit of a case, as root mean square error over the Cramér-Rao
/// bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Median over the modes.
    pub median: f64,
    /// The worst mode.
    pub worst: f64,
}

/// Separate modes, or close ones that the lines resolve.
const TIGHT: Option<Target> = Some(Target {
    median: 1.05,
    worst: 1.4,
});
/// Overlapping modes.
const OVERLAPPING: Option<Target> = Some(Target {
    median: 1.2,
    worst: 1.6,
});

/// A named problem.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// The case, in a sentence.
    pub about: &'static str,
    /// Part of a quick run.
    pub quick: bool,
    /// The accuracy that must be reached; `None`: only the count of modes matters.
    pub target: Option<Target>,
    make: fn() -> Result<Problem>,
}

impl Case {
    /// Makes the problem; the same bits every time.
    ///
    /// # Errors
    /// None for the cases of [`CASES`].
    pub fn problem(&self) -> Result<Problem> {
        (self.make)()
    }

    /// The case of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        CASES.iter().find(|case| case.name == name)
    }
}

/// All cases, the simple ones first.
pub const CASES: [Case; 14] = [
    Case {
        name: "easy",
        about: "8 separate modes, 12 FRFs, 2 references, 2200 lines, 40 dB",
        quick: true,
        target: TIGHT,
        make: || easy(40.0),
    },
    Case {
        name: "easy-20-db",
        about: "the same at 20 dB",
        quick: true,
        target: TIGHT,
        make: || easy(20.0),
    },
    Case {
        name: "close",
        about: "4 pairs of modes 0.3 bandwidths apart, 12 FRFs, 2 references, 2000 lines, 40 dB",
        quick: true,
        target: TIGHT,
        make: close,
    },
    Case {
        name: "few-lines",
        about: "8 modes, 1.2 lines per bandwidth, 12 FRFs, 2 references, 40 dB",
        quick: true,
        target: TIGHT,
        make: few_lines,
    },
    Case {
        name: "single-reference",
        about: "12 separate modes, 40 responses, one reference, 2001 lines, 40 dB",
        quick: true,
        target: TIGHT,
        make: single_reference,
    },
    Case {
        name: "overlap-0.3",
        about: "12 modes, modal overlap 0.3, 12 FRFs, 3 references, 40 dB",
        quick: false,
        target: TIGHT,
        make: || overlap(0.3, 40.0),
    },
    Case {
        name: "overlap-1",
        about: "the same, modal overlap 1, 50 dB",
        quick: true,
        target: OVERLAPPING,
        make: || overlap(1.0, 50.0),
    },
    Case {
        name: "overlap-2",
        about: "the same, modal overlap 2, 40 dB",
        quick: false,
        target: None,
        make: || overlap(2.0, 40.0),
    },
    Case {
        name: "overlap-3",
        about: "the same, modal overlap 3, 60 dB",
        quick: false,
        target: None,
        make: || overlap(3.0, 60.0),
    },
    Case {
        name: "wide-band",
        about: "60 modes from 6 to 3900 Hz, 16001 lines, 12 FRFs, 60 dB",
        quick: false,
        target: None,
        make: wide_band,
    },
    Case {
        name: "panel",
        about: "glass panel, 77 x 34 FRFs, 1601 lines, 34 modes, a 35th just above the band, 40 dB",
        quick: true,
        target: TIGHT,
        make: || Problem::of_panel(&panel()),
    },
    Case {
        name: "exact-100-modes",
        about: "100 modes, 6401 lines, 12 FRFs, no noise",
        quick: false,
        target: None,
        make: exact,
    },
    Case {
        name: "common-gain-noise",
        about: "the easy set with a gain error of 5 % per line, common to all FRFs",
        quick: true,
        target: None,
        make: || Ok(easy(40.0)?.with_common_gain(0.05)),
    },
    Case {
        name: "only-noise",
        about: "white noise, no mode, 12 FRFs, 2200 lines",
        quick: true,
        target: None,
        make: || Ok(easy(40.0)?.without_modes()),
    },
];

/// The common part of all abstract cases: real shapes, six responses, two references, and a world
/// outside the band.
fn modes(
    natural_frequency_hz: Vec<f64>,
    loss_factor: Vec<f64>,
    frequency_hz: Array1<f64>,
) -> Synthetic {
    Synthetic {
        natural_frequency_hz,
        loss_factor,
        responses: 6,
        references: 2,
        frequency_hz,
        residual_powers: vec![-2, 0],
        // rigid-body motion then rises to a quarter of the rms at the lower end of most
        // cases
        residual_level: 0.02,
        snr_db: 40.0,
        seed: 1,
        ..Synthetic::default()
    }
}

/// Natural frequencies of the separate modes, Hz.
const SEPARATE_HZ: [f64; 8] = [31.0, 52.0, 78.0, 101.0, 133.0, 160.0, 187.0, 215.0];

fn easy(snr_db: f64) -> Result<Problem> {
    let loss_factor = vec![0.01, 0.012, 0.008, 0.01, 0.015, 0.01, 0.009, 0.011];
    Problem::of_modes(&Synthetic {
        snr_db,
        ..modes(SEPARATE_HZ.to_vec(), loss_factor, lines(20.0, 0.1, 2200))
    })
}

/// Half-power bandwidth 1 Hz everywhere.
fn close() -> Result<Problem> {
    let natural: Vec<f64> = [40.0, 90.0, 140.0, 190.0]
        .iter()
        .flat_map(|f| [*f, f + 0.3])
        .collect();
    let loss_factor = natural.iter().map(|f| 1.0 / f).collect();
    Problem::of_modes(&modes(natural, loss_factor, lines(20.0, 0.1, 2000)))
}

/// Half-power bandwidth 1.2 line spacings everywhere.
fn few_lines() -> Result<Problem> {
    let loss_factor = SEPARATE_HZ.iter().map(|f| 0.6 / f).collect();
    Problem::of_modes(&modes(
        SEPARATE_HZ.to_vec(),
        loss_factor,
        lines(20.0, 0.5, 441),
    ))
}

fn single_reference() -> Result<Problem> {
    let natural = (0..12)
        .map(|n| 40.0 + 15.0 * f64::from(n) + f64::from(n * n % 7))
        .collect();
    Problem::of_modes(&Synthetic {
        responses: 40,
        references: 1,
        ..modes(natural, vec![0.008], lines(25.0, 0.1, 2001))
    })
}

/// Natural frequencies 10 % apart; the modal overlap is the bandwidth over their
/// distance.
fn overlap(overlap: f64, snr_db: f64) -> Result<Problem> {
    let natural = (0..12).map(|n| 100.0 * 1.1f64.powi(n)).collect();
    let spec = modes(
        natural,
        vec![0.1 * overlap],
        Array1::linspace(80.0, 340.0, 1601),
    );
    Problem::of_modes(&Synthetic {
        responses: 4,
        references: 3,
        snr_db,
        ..spec
    })
}

/// At the lower end five modes share the bandwidth of a few lines, at the upper end each
/// has a hundred.
fn wide_band() -> Result<Problem> {
    let natural = (0..60)
        .map(|n| 6.0 * (3900.0f64 / 6.0).powf(f64::from(n) / 59.0))
        .collect();
    // the level of the other cases would let rigid-body motion stand 60 dB above all
    // modes over so many octaves, and the noise with it
    let residual_level = 4e-7;
    Problem::of_modes(&Synthetic {
        snr_db: 60.0,
        residual_level,
        ..modes(natural, vec![0.01], Array1::linspace(5.0, 4005.0, 16001))
    })
}

fn exact() -> Result<Problem> {
    let natural: Vec<f64> = (0..100).map(|n| 20.0 + 10.0 * f64::from(n)).collect();
    let loss_factor = natural.iter().map(|f| 1.0 / f).collect();
    let spec = modes(natural, loss_factor, Array1::linspace(10.0, 1030.0, 6401));
    Problem::of_modes(&Synthetic {
        snr_db: f64::INFINITY,
        residual_powers: Vec::new(),
        ..spec
    })
}

/// The demonstration's panel in thinner glass: 34 modes from 10 to 700 Hz, and one at 702
/// Hz.
pub fn panel() -> Panel {
    let mut panel = Panel::default();
    panel.plate.thickness_m = 0.000_376_03;
    (panel.frf.start_hz, panel.frf.stop_hz, panel.frf.step_hz) = (10.0, 700.0, 690.0 / 1600.0);
    panel
}

fn lines(start_hz: f64, step_hz: f64, count: usize) -> Array1<f64> {
    (0..count).map(|k| start_hz + step_hz * k as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_panel_holds_what_its_name_says() {
        let problem = Problem::of_panel(&panel()).unwrap();
        assert_eq!(problem.clean.values.dim(), (77, 34, 1601));
        assert_eq!(problem.truth.in_band_modes().count(), 34);
        let above = problem
            .truth
            .modes
            .iter()
            .map(|mode| mode.frequency_hz)
            .find(|&f| f > 700.0)
            .unwrap();
        assert!(
            (701.0..703.0).contains(&above),
            "the next mode lies just above the band: {above}"
        );
    }

    #[test]
    fn every_case_can_be_made_and_names_are_unique() {
        for (k, case) in CASES.iter().enumerate() {
            assert!(CASES[..k].iter().all(|other| other.name != case.name));
            if case.name != "panel" {
                assert!(case.problem().is_ok(), "{}", case.name);
            }
        }
    }
}
