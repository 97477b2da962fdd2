//! The measurements behind the maps of identification: each a function of two numbers and
//! a seed.

use super::trial::Measured;
use crate::problem::Problem;
use chladni_frf::{BlockWindow, Damping, FrfSet, FrfValues, ModalModel, Result};
use chladni_plate::{
    add_noise_of_variance, noise_variance, outliers, synthesise_by_products, Excitation, Synthetic,
    TimeTest,
};
use chladni_rfp::{FitOptions, Window};
use ndarray::{s, Array1};
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Seeds of shapes lie this far from those of noise.
const SHAPES: u64 = 1_000_000_000;
/// Modes of most maps.
const MODES: usize = 8;
/// The lowest of them, Hz, and the distance of the others, Hz.
const FIRST_HZ: f64 = 60.0;
const SPACING_HZ: f64 = 20.0;
/// Half-power bandwidth of separate modes, Hz.
const BANDWIDTH_HZ: f64 = 1.0;
/// Noise where it is not the question, dB.
const SNR_DB: f64 = 40.0;
/// Lines per bandwidth where they are not the question.
const LINES_PER_BANDWIDTH: f64 = 4.0;

/// Even lines over the modes and a distance to both sides.
fn axis(low_hz: f64, high_hz: f64, step_hz: f64) -> Array1<f64> {
    Array1::range(low_hz, high_hz + 0.5 * step_hz, step_hz)
}

/// Natural frequencies `SPACING_HZ` apart.
fn separate() -> Vec<f64> {
    (0..MODES)
        .map(|n| FIRST_HZ + SPACING_HZ * n as f64)
        .collect()
}

/// Real shapes, 4 × 3 FRFs, rigid-body motion and a constant term. Shapes differ from
/// seed to seed.
fn structure(
    natural_frequency_hz: Vec<f64>,
    bandwidth_hz: f64,
    frequency_hz: Array1<f64>,
    seed: u64,
) -> Synthetic {
    let loss_factor = natural_frequency_hz
        .iter()
        .map(|f| bandwidth_hz / f)
        .collect();
    Synthetic {
        natural_frequency_hz,
        loss_factor,
        responses: 4,
        references: 3,
        frequency_hz,
        residual_powers: vec![-2, 0],
        residual_level: 0.02,
        snr_db: SNR_DB,
        seed: SHAPES + seed,
        ..Synthetic::default()
    }
}

/// Separate modes on the usual lines.
fn usual(seed: u64) -> Synthetic {
    let natural = separate();
    let ends = [natural[0] - SPACING_HZ, natural[MODES - 1] + SPACING_HZ];
    structure(
        natural,
        BANDWIDTH_HZ,
        axis(ends[0], ends[1], BANDWIDTH_HZ / LINES_PER_BANDWIDTH),
        seed,
    )
}

/// White noise is all that is wrong.
fn noisy(spec: &Synthetic, options: FitOptions, seed: u64) -> Result<Measured> {
    let problem = Problem::of_modes(spec)?;
    Ok(Measured {
        frf: problem.measured(seed),
        problem,
        options,
        bounded: true,
    })
}

/// Signal to noise, dB × modal overlap.
pub(super) fn snr_overlap(snr_db: f64, overlap: f64, seed: u64) -> Result<Measured> {
    let natural = separate();
    let ends = [natural[0] - SPACING_HZ, natural[MODES - 1] + SPACING_HZ];
    let spec = structure(
        natural,
        overlap * SPACING_HZ,
        axis(ends[0], ends[1], 0.25),
        seed,
    );
    noisy(&Synthetic { snr_db, ..spec }, FitOptions::default(), seed)
}

/// Distance of the modes of three pairs, in bandwidths × references.
pub(super) fn spacing_references(spacing: f64, references: f64, seed: u64) -> Result<Measured> {
    let natural = [60.0, 100.0, 140.0]
        .iter()
        .flat_map(|f| [*f, f + spacing * BANDWIDTH_HZ])
        .collect();
    let spec = structure(natural, BANDWIDTH_HZ, axis(40.0, 160.0, 0.25), seed);
    noisy(
        &Synthetic {
            references: references as usize,
            responses: 6,
            ..spec
        },
        FitOptions::default(),
        seed,
    )
}

/// Modes asked for less modes present × ratio of the band's ends, which sets the
/// condition of every polynomial basis.
pub(super) fn order_conditioning(more: f64, ratio: f64, seed: u64) -> Result<Measured> {
    let low_hz = 200.0 / ratio;
    let natural: Vec<f64> = (0..MODES)
        .map(|n| low_hz * ratio.powf((n as f64 + 0.5) / MODES as f64))
        .collect();
    let narrowest = natural[1] - natural[0];
    let spec = structure(
        natural,
        0.1 * narrowest,
        axis(low_hz, 200.0, (200.0 - low_hz) / 2400.0),
        seed,
    );
    // rigid-body motion would bury everything else over so many octaves
    let spec = Synthetic {
        residual_powers: vec![0],
        ..spec
    };
    noisy(
        &spec,
        FitOptions {
            modes: Some((MODES as f64 + more) as usize),
            ..FitOptions::default()
        },
        seed,
    )
}

/// Lines per half-power bandwidth × signal to noise, dB.
pub(super) fn lines_snr(lines: f64, snr_db: f64, seed: u64) -> Result<Measured> {
    let spec = usual(seed);
    let ends = [
        spec.frequency_hz[0],
        spec.frequency_hz[spec.frequency_hz.len() - 1],
    ];
    let frequency_hz = axis(ends[0], ends[1], BANDWIDTH_HZ / lines);
    noisy(
        &Synthetic {
            snr_db,
            frequency_hz,
            ..spec
        },
        FitOptions::default(),
        seed,
    )
}

/// Level of four modes outside the band over those inside, dB × number of residual terms
/// that the world adds.
pub(super) fn outside_residuals(level_db: f64, terms: f64, seed: u64) -> Result<Measured> {
    let spec = usual(seed);
    let ends = [
        spec.frequency_hz[0],
        spec.frequency_hz[spec.frequency_hz.len() - 1],
    ];
    let outside = [ends[0] - 12.0, ends[0] - 4.0, ends[1] + 4.0, ends[1] + 12.0];
    let natural: Vec<f64> = spec
        .natural_frequency_hz
        .iter()
        .copied()
        .chain(outside)
        .collect();
    let loss_factor = natural.iter().map(|f| BANDWIDTH_HZ / f).collect();
    let residual_powers = [-2, 0, 2, 4][..terms as usize].to_vec();
    let spec = Synthetic {
        natural_frequency_hz: natural,
        loss_factor,
        residual_powers,
        residual_level: 0.1,
        ..spec
    };
    let mut problem = Problem::of_modes(&Synthetic {
        snr_db: f64::INFINITY,
        ..spec
    })?;
    // residues of the level asked for: half of it in the shape, half in the participation
    let factor = 10f64.powf(level_db / 40.0);
    for mode in problem.truth.modes.iter_mut().filter(|mode| !mode.in_band) {
        mode.shape
            .0
            .iter_mut()
            .chain(&mut mode.participation.0)
            .for_each(|value| *value *= factor);
    }
    let problem = problem.of_truth(SNR_DB);
    Ok(Measured {
        frf: problem.measured(seed),
        problem,
        options: FitOptions::default(),
        bounded: true,
    })
}

/// Loss factor of all modes × which law holds and which is fitted (see the words of the
/// map).
pub(super) fn damping_law(loss_factor: f64, law: f64, seed: u64) -> Result<Measured> {
    let (structural, viscous) = (Damping::Structural, Damping::Viscous);
    let (holds, fitted) = [
        (structural, None),
        (viscous, None),
        (structural, Some(viscous)),
        (viscous, Some(structural)),
    ][law as usize];
    // modes so far apart that their overlap is 0.3 at any damping
    let ratio = 1.0 + loss_factor / 0.3;
    let natural: Vec<f64> = (0..6).map(|n| 100.0 * ratio.powi(n)).collect();
    let (low_hz, high_hz) = (100.0 / ratio.min(2.0), natural[5] * ratio.min(2.0));
    let step_hz = loss_factor * 100.0 / LINES_PER_BANDWIDTH;
    let lines = (((high_hz - low_hz) / step_hz) as usize).clamp(200, 2000);
    let spec = structure(natural, 0.0, Array1::linspace(low_hz, high_hz, lines), seed);
    let spec = Synthetic {
        loss_factor: vec![loss_factor],
        damping: holds,
        snr_db: 60.0,
        ..spec
    };
    noisy(
        &spec,
        FitOptions {
            damping: fitted,
            ..FitOptions::default()
        },
        seed,
    )
}

/// Share of outliers × their size over the rms of the data.
pub(super) fn outliers_share(share: f64, size: f64, seed: u64) -> Result<Measured> {
    let problem = Problem::of_modes(&usual(seed))?;
    let mut frf = problem.measured(seed);
    outliers(&mut frf, share, size, seed);
    Ok(Measured {
        frf,
        problem,
        options: FitOptions::default(),
        bounded: false,
    })
}

/// Lines per bandwidth × window and excitation (see the words of the map): simulated in
/// time.
pub(super) fn window_lines(lines: f64, which: f64, seed: u64) -> Result<Measured> {
    let record_s = lines / BANDWIDTH_HZ;
    let rate_per_s = 100f64.ln() / record_s;
    // three samples: the blow excites the whole band
    let hammer = Excitation::Hammer { contact_s: 6e-3 };
    let exponential = BlockWindow::Exponential { rate_per_s };
    let (excitation, window, averages) = [
        (hammer, BlockWindow::Rectangular, 5),
        (hammer, exponential, 5),
        (hammer, exponential, 5),
        (
            Excitation::BurstRandom { part: 0.5 },
            BlockWindow::Rectangular,
            50,
        ),
        (Excitation::Random, BlockWindow::Hann, 50),
        (Excitation::Random, BlockWindow::Hann, 50),
    ][which as usize];
    let options = match which as usize {
        2 => FitOptions {
            exponential_window_per_s: Some(rate_per_s),
            ..FitOptions::default()
        },
        5 => FitOptions {
            window: Some(Window::Hann),
            ..FitOptions::default()
        },
        _ => FitOptions::default(),
    };
    let natural_frequency_hz: Vec<f64> = [40.0, 70.0, 105.0, 130.0, 165.0].to_vec();
    let test = TimeTest {
        damping_ratio: natural_frequency_hz
            .iter()
            .map(|f| 0.5 * BANDWIDTH_HZ / f)
            .collect(),
        natural_frequency_hz,
        responses: 4,
        sample_rate_hz: 512.0,
        record_s,
        padding: 1,
        // a window is undone on whole records only
        band_hz: [1e-3, 200.0],
        averages,
        excitation,
        window,
        snr_db: SNR_DB,
        seed: SHAPES + seed,
    };
    in_time(&test, options)
}

/// The FRFs of a test that is simulated in time.
fn in_time(test: &TimeTest, options: FitOptions) -> Result<Measured> {
    let set = test.build()?;
    let truth = ModalModel {
        band_hz: [20.0, 190.0],
        ..set.truth
    };
    let clean = FrfSet {
        values: FrfValues::F64(synthesise_by_products(&truth, &set.frf.frequency_hz)),
        ..set.frf.clone()
    };
    let problem = Problem {
        clean,
        truth,
        noise_variance: 0.0,
        common_gain: 0.0,
    };
    Ok(Measured {
        frf: set.frf,
        problem,
        options: FitOptions {
            band_hz: Some([20.0, 190.0]),
            ..options
        },
        bounded: false,
    })
}

/// Scatter of the natural frequencies from FRF to FRF, in bandwidths × number of FRFs, as
/// temperature or a wandering mass does it. The truth is the mean that a fit of all FRFs
/// sees: each FRF counts by the energy of the mode in it.
pub(super) fn scatter_frfs(scatter: f64, frfs: f64, seed: u64) -> Result<Measured> {
    let frfs = frfs as usize;
    let mut problem = Problem::of_modes(&Synthetic {
        responses: frfs,
        references: 1,
        ..usual(seed)
    })?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut moved = Vec::new();
    for _ in 0..frfs {
        let mut model = problem.truth.clone();
        for mode in &mut model.modes {
            let normal: f64 = StandardNormal.sample(&mut random);
            mode.frequency_hz += scatter * BANDWIDTH_HZ * normal;
        }
        moved.push(model);
    }
    for (n, mode) in problem.truth.modes.iter_mut().enumerate() {
        let weights: Vec<f64> = mode.shape.0.iter().map(|value| value.norm_sqr()).collect();
        let sum: f64 = weights
            .iter()
            .zip(&moved)
            .map(|(weight, model)| weight * model.modes[n].frequency_hz)
            .sum();
        mode.frequency_hz = sum / weights.iter().sum::<f64>();
    }
    let mut frf = problem.clean.clone();
    if let FrfValues::F64(values) = &mut frf.values {
        for (i, model) in moved.iter().enumerate() {
            values.slice_mut(s![i, .., ..]).assign(
                &synthesise_by_products(model, &problem.clean.frequency_hz).slice(s![i, .., ..]),
            );
        }
        add_noise_of_variance(values, problem.noise_variance, seed);
    }
    Ok(Measured {
        frf,
        problem,
        options: FitOptions::default(),
        bounded: scatter == 0.0,
    })
}

impl Problem {
    /// The same structure as its truth says now, `snr_db` above white noise.
    fn of_truth(&self, snr_db: f64) -> Self {
        let values = synthesise_by_products(&self.truth, &self.clean.frequency_hz);
        let noise_variance = noise_variance(&values, snr_db);
        let clean = FrfSet {
            values: FrfValues::F64(values),
            ..self.clean.clone()
        };
        Self {
            clean,
            truth: self.truth.clone(),
            noise_variance,
            common_gain: 0.0,
        }
    }
}
