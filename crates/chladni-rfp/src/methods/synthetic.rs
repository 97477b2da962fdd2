//! FRFs by a plain sum over viscous modes, for the tests of this module.

use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::methods::band_lines::BandLines;
use crate::methods::bands::Band;
use crate::methods::found::LocalPoles;
use crate::methods::survey::Survey;
use chladni_frf::{Damping, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_plate::{Synthetic, SyntheticSet};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A structure by its poles, seen at `responses` points from one reference.
pub(crate) struct Structure {
    /// Natural frequency, Hz, and damping ratio.
    pub modes: Vec<(f64, f64)>,
    /// Response points.
    pub responses: usize,
    /// First and last line, Hz.
    pub band_hz: [f64; 2],
    /// Number of lines.
    pub lines: usize,
    /// Kind of the FRFs.
    pub kind: FrfKind,
    /// Noise below the rms of the FRFs, dB.
    pub snr_db: Option<f64>,
}

impl Structure {
    /// Four separated modes, three responses, mobility.
    pub fn four_modes() -> Self {
        let modes = vec![(31.0, 0.01), (52.0, 0.006), (70.5, 0.012), (91.0, 0.008)];
        Self {
            modes,
            responses: 3,
            band_hz: [20.0, 105.0],
            lines: 400,
            kind: FrfKind::Mobility,
            snr_db: None,
        }
    }

    /// `count` modes every 20 Hz, about two bandwidths of lines each.
    pub fn even_modes(count: u32) -> Self {
        let modes = (1..=count)
            .map(|n| 20.0 * f64::from(n))
            .map(|f| (f, 0.12 / f + 0.002))
            .collect();
        Self {
            modes,
            band_hz: [10.0, 10.0 + 20.0 * f64::from(count)],
            lines: 1601,
            ..Self::four_modes()
        }
    }

    /// Poles in rad/s.
    fn poles(&self) -> Vec<Complex64> {
        self.modes
            .iter()
            .map(|&(f, zeta)| TAU * f * Complex64::new(-zeta, (1.0 - zeta * zeta).sqrt()))
            .collect()
    }

    /// Poles in units of the last line's ω.
    pub fn scaled_poles(&self) -> Vec<Complex64> {
        self.poles()
            .iter()
            .map(|s| s / (TAU * self.band_hz[1]))
            .collect()
    }

    /// Worst |s − s_true|/|s_true| over the true modes.
    pub fn worst(&self, found: &LocalPoles) -> f64 {
        let nearest = |p: &Complex64| {
            found
                .poles
                .iter()
                .map(|s| (s - p).norm() / p.norm())
                .fold(f64::INFINITY, f64::min)
        };
        self.scaled_poles().iter().map(nearest).fold(0.0, f64::max)
    }

    /// All lines as one band.
    pub fn lines(&self) -> BandLines {
        let frf = self.frf(0);
        let data = Screened::new(&frf, &FitOptions::default()).unwrap();
        BandLines::new(
            &data,
            &Band {
                rows: 0..self.lines,
                order: 4,
            },
        )
        .unwrap()
    }

    /// The measurement.
    pub fn frf(&self, seed: u64) -> FrfSet {
        let [low, high] = self.band_hz;
        let frequency_hz = Array1::linspace(low, high, self.lines);
        let poles = self.poles();
        let mut values = Array3::from_shape_fn((self.responses, 1, self.lines), |(i, _, k)| {
            let omega = TAU * frequency_hz[k];
            let s = Complex64::new(0.0, omega);
            let sum: Complex64 = poles
                .iter()
                .enumerate()
                .map(|(n, p)| {
                    // two incommensurable angles: no node, either sign; residues with a
                    // small phase are viscous and complex
                    let shape = (0.4 + 1.7 * (i as f64 + 1.0) * (n as f64 + 1.0)).sin();
                    let residue =
                        Complex64::new(0.05 * shape, -shape - 0.3 * shape.signum()) / p.im;
                    residue / (s - p) + residue.conj() / (s - p.conj())
                })
                .sum();
            sum * self.kind.from_receptance(omega)
        });
        if let Some(snr_db) = self.snr_db {
            chladni_plate::add_white_noise(&mut values, snr_db, seed).unwrap();
        }
        FrfSet {
            frequency_hz,
            values: FrfValues::F64(values),
            responses: (0..self.responses)
                .map(|i| format!("{}:+Z", i + 1).parse().unwrap())
                .collect(),
            references: vec!["1:+Z".parse().unwrap()],
            kind: Some(self.kind),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        }
    }
}

/// So many structural or viscous modes every 10 Hz, 1 Hz wide, 12 FRFs.
pub(crate) fn even(modes: usize, snr_db: f64, damping: Damping, seed: u64) -> SyntheticSet {
    let natural: Vec<f64> = (0..modes).map(|n| 20.0 + 10.0 * n as f64).collect();
    let top = 25.0 + 10.0 * modes as f64;
    Synthetic {
        loss_factor: natural.iter().map(|f| 1.0 / f).collect(),
        natural_frequency_hz: natural,
        responses: 6,
        references: 2,
        frequency_hz: Array1::linspace(10.0, top, 64 * modes + 1),
        snr_db,
        seed,
        damping,
        ..Synthetic::default()
    }
    .build()
    .unwrap()
}

/// Runs a method that fits single FRFs with default options but for the number of modes.
pub(crate) fn run(
    method: fn(&Survey, &FitOptions) -> Result<LocalPoles, FitError>,
    frf: &FrfSet,
    modes: Option<usize>,
) -> LocalPoles {
    let options = FitOptions {
        modes,
        ..FitOptions::default()
    };
    let data = Screened::new(frf, &options).unwrap();
    method(&Survey::new(&data, options.seed), &options).unwrap()
}
