//! Noise of known kind and size, the same for a seed at any number of threads: each FRF
//! has its own ChaCha8 stream.

use crate::tolerances::LEAST_SNR_DB;
use chladni_frf::{Error, FrfSet, FrfValues, Result};
use ndarray::Array3;
use num_complex::{Complex32, Complex64};
use rand::Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

/// First random stream of each kind of noise, one stream per FRF from there: kinds of one
/// seed are independent of each other.
const WHITE_STREAMS: u64 = 0;
const GAIN_STREAMS: u64 = 1 << 60;
const OUTLIER_STREAMS: u64 = 1 << 61;
/// The stream of gains that all FRFs share; no FRF has it.
const COMMON_STREAM: u64 = u64::MAX;

/// Random numbers number `stream` of `seed`.
pub(crate) fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

/// Circular complex Gaussian with E|z|² = 1.
pub(crate) fn circular(generator: &mut ChaCha8Rng) -> Complex64 {
    let (re, im): (f64, f64) = (
        generator.sample(StandardNormal),
        generator.sample(StandardNormal),
    );
    Complex64::new(re, im) * std::f64::consts::FRAC_1_SQRT_2
}

/// Mean of |value|² over all FRFs and lines, pairs and lines without a value (NaN) left
/// out; summed in a fixed order.
pub fn mean_square(values: &Array3<Complex64>) -> f64 {
    let (sum, count) = values
        .rows()
        .into_iter()
        .map(|frf| {
            frf.iter()
                .filter(|v| v.is_finite())
                .fold((0.0, 0usize), |(sum, count), v| {
                    (sum + v.norm_sqr(), count + 1)
                })
        })
        .fold((0.0, 0), |(sum, count), (s, c)| (sum + s, count + c));
    sum / count.max(1) as f64
}

/// Variance E|n|² of noise that lies `snr_db` below the mean square of all values.
pub fn noise_variance(values: &Array3<Complex64>, snr_db: f64) -> f64 {
    mean_square(values) * 10f64.powf(-snr_db / 10.0)
}

/// Checks that noise leaves something of what it is added to.
pub(crate) fn check_snr(field: &str, snr_db: f64) -> Result<()> {
    match snr_db >= LEAST_SNR_DB {
        true => Ok(()),
        false => Err(Error::bad_data("noise that leaves nothing of the FRFs")
            .field(field)
            .found(snr_db)
            .expected(format!("{LEAST_SNR_DB} dB or more"))),
    }
}

/// Adds white circular Gaussian noise of one variance, `snr_db` below the mean square of
/// all values; returns the variance E|n|².
///
/// An infinite `snr_db` adds nothing.
///
/// # Errors
/// A level that is no number, or leaves nothing of the values.
pub fn add_white_noise(values: &mut Array3<Complex64>, snr_db: f64, seed: u64) -> Result<f64> {
    check_snr("snr_db", snr_db)?;
    let variance = noise_variance(values, snr_db);
    add_noise_of_variance(values, variance, seed);
    Ok(variance)
}

/// Adds white circular Gaussian noise with E|n|² = `variance`, in the units of the values
/// squared.
pub fn add_noise_of_variance(values: &mut Array3<Complex64>, variance: f64, seed: u64) {
    if variance > 0.0 {
        let sigma = variance.sqrt();
        change_each(values, seed, WHITE_STREAMS, |generator, value| {
            value + sigma * circular(generator)
        });
    }
}

/// Multiplies every value by 1 + `fraction`·z, z circular Gaussian with E|z|² = 1: gain
/// noise, as a vibrometer on rough ground or an unsteady drive adds it.
///
/// * `common`: one z per line for all FRFs (the drive); otherwise one per value
pub fn gain_noise(set: &mut FrfSet, fraction: f64, common: bool, seed: u64) {
    let lines = set.frequency_hz.len();
    let mut shared = generator(seed, COMMON_STREAM);
    let gains: Vec<Complex64> = if common {
        (0..lines)
            .map(|_| 1.0 + fraction * circular(&mut shared))
            .collect()
    } else {
        Vec::new()
    };
    in_double(set, |values| match common {
        true => values
            .rows_mut()
            .into_iter()
            .for_each(|mut frf| frf.iter_mut().zip(&gains).for_each(|(v, gain)| *v *= gain)),
        false => change_each(values, seed, GAIN_STREAMS, |generator, value| {
            value * (1.0 + fraction * circular(generator))
        }),
    });
}

/// Replaces a random `share` of all values (0..=1) by `factor` times the root mean square
/// of the set, at random phase: dropouts and spikes.
pub fn outliers(set: &mut FrfSet, share: f64, factor: f64, seed: u64) {
    in_double(set, |values| {
        let size = factor * mean_square(values).sqrt();
        change_each(values, seed, OUTLIER_STREAMS, |generator, value| {
            // both numbers are drawn for every value, so that the same seed hits the same
            // values at every share
            let (chance, phase): (f64, f64) = (generator.random(), generator.random());
            match chance < share {
                true => Complex64::from_polar(size, std::f64::consts::TAU * phase),
                false => value,
            }
        });
    });
}

/// Applies `change` to every value, each FRF with its own random stream.
fn change_each(
    values: &mut Array3<Complex64>,
    seed: u64,
    first_stream: u64,
    change: impl Fn(&mut ChaCha8Rng, Complex64) -> Complex64 + Sync,
) {
    let frfs: Vec<_> = values.rows_mut().into_iter().enumerate().collect();
    frfs.into_par_iter().for_each(|(index, frf)| {
        let mut generator = generator(seed, first_stream + index as u64);
        for value in frf {
            *value = change(&mut generator, *value);
        }
    });
}

/// Works on the values in double precision and returns them in their own.
fn in_double(set: &mut FrfSet, work: impl FnOnce(&mut Array3<Complex64>)) {
    match &mut set.values {
        FrfValues::F64(values) => work(values),
        FrfValues::F32(values) => {
            let mut wide = values.mapv(|v| Complex64::new(v.re.into(), v.im.into()));
            work(&mut wide);
            *values = wide.mapv(|v| Complex32::new(v.re as f32, v.im as f32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEED: u64 = 7;

    #[test]
    fn white_noise_is_circular_and_of_the_announced_variance() {
        let mut values = Array3::from_elem((10, 10, 1000), Complex64::new(3.0, 4.0));
        let variance = add_white_noise(&mut values, 20.0, SEED).unwrap();
        assert!((variance - 0.25).abs() < 1e-12);
        let noise = values.mapv(|v| v - Complex64::new(3.0, 4.0));
        let count = noise.len() as f64;
        // 1e5 values: the variance scatters by 1/√1e5 = 0.3 %, the mean of n² too
        assert!((mean_square(&noise) / variance - 1.0).abs() < 0.015);
        let square = noise.iter().map(|n| n * n).sum::<Complex64>() / count;
        assert!(
            square.norm() < 0.015 * variance,
            "circular: E n² = 0, got {square}"
        );
        let neighbours = noise
            .rows()
            .into_iter()
            .map(|r| (1..1000).map(|k| r[k] * r[k - 1].conj()).sum::<Complex64>())
            .sum::<Complex64>();
        assert!(
            (neighbours / count).norm() < 0.015 * variance,
            "white: neighbours are independent"
        );
    }

    #[test]
    fn a_seed_gives_the_same_bits_at_any_number_of_threads() {
        let run = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let mut values = Array3::from_elem((3, 4, 50), Complex64::new(1.0, 0.0));
            pool.install(|| add_white_noise(&mut values, 10.0, seed).unwrap());
            values
        };
        assert_eq!(run(1, SEED), run(3, SEED));
        assert_ne!(run(1, SEED), run(1, SEED + 1));
    }

    #[test]
    fn infinite_snr_adds_nothing_and_nan_is_refused() {
        let mut values = Array3::from_elem((1, 1, 5), Complex64::new(1.0, 0.0));
        let before = values.clone();
        assert_eq!(
            add_white_noise(&mut values, f64::INFINITY, SEED).unwrap(),
            0.0
        );
        assert_eq!(values, before);
        assert!(add_white_noise(&mut values, f64::NAN, SEED).is_err());
    }
}
