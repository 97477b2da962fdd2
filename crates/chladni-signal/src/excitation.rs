//! Tells continuous random excitation from blows, bursts, sweeps and periodic signals.

use super::whole_record::{smooth_length, spectrum};
use num_complex::Complex64;
use rustfft::FftPlanner;

/// Shortest record that is judged, samples.
const LEAST_SAMPLES: usize = 1024;
/// Pieces of a record whose powers are compared.
const PIECES: usize = 16;
/// Least power of a piece beside the mean; pieces of a random signal scatter, silence
/// between bursts lies far below.
const LEAST_POWER: f64 = 0.1;
/// Lines over which products of neighbours are summed.
const LINES: usize = 13;
/// Largest |Σ X_k·X*_{k+1}| beside Σ|X|²: about 0.24 for random lines, near 1 for the smooth
/// spectrum of a blow or a sweep.
const LARGEST_NEIGHBOUR: f64 = 0.5;
/// Largest autocorrelation at long lags: near 1 for periodic signals.
const LARGEST_REPEAT: f64 = 0.5;
/// Long lags begin at this part of the record.
const LONG_LAG: usize = 64;

/// True where the signal goes on through the whole record, its lines are independent and
/// nothing repeats.
pub(super) fn is_continuous_random(samples: &[f64]) -> bool {
    let samples = &samples[..smooth_length(samples.len())];
    if samples.len() < LEAST_SAMPLES || !is_steady(samples) {
        return false;
    }
    let mut lines = spectrum(samples);
    lines[0] = Complex64::default();
    has_rough_lines(&lines) && !repeats(lines)
}

fn is_steady(samples: &[f64]) -> bool {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let powers: Vec<f64> = samples
        .chunks_exact(samples.len() / PIECES)
        .map(|piece| piece.iter().map(|x| (x - mean).powi(2)).sum::<f64>())
        .collect();
    let average = powers.iter().sum::<f64>() / powers.len() as f64;
    average > 0.0 && powers.iter().all(|&power| power >= LEAST_POWER * average)
}

fn has_rough_lines(lines: &[Complex64]) -> bool {
    let (mut neighbours, mut power) = (0.0, 0.0);
    for window in lines[1..].chunks_exact(LINES) {
        let products = window.windows(2).map(|pair| pair[0] * pair[1].conj());
        neighbours += products.sum::<Complex64>().norm();
        power += window.iter().map(Complex64::norm_sqr).sum::<f64>();
    }
    neighbours < LARGEST_NEIGHBOUR * power
}

/// Autocorrelation at long lags, over the one at lag 0.
fn repeats(mut lines: Vec<Complex64>) -> bool {
    let half = lines.len() - 1;
    for line in &mut lines {
        *line = line.norm_sqr().into();
    }
    // one side of an even spectrum: twice its real part is the autocorrelation
    lines[half] = Complex64::default();
    lines.resize(2 * half, Complex64::default());
    FftPlanner::new()
        .plan_fft_inverse(2 * half)
        .process(&mut lines);
    let largest = lines[2 * half / LONG_LAG..=half]
        .iter()
        .map(|value| value.re.abs())
        .fold(0.0, f64::max);
    largest > LARGEST_REPEAT * lines[0].re
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;

    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| random.sample(StandardNormal)).collect()
    }

    /// Noise of a resonator: a narrow band.
    fn narrow(count: usize, seed: u64) -> Vec<f64> {
        let mut last = [0.0; 2];
        let of = |x: f64| {
            let y = x + 1.8 * last[0] - 0.9 * last[1];
            last = [y, last[0]];
            y
        };
        noise(count, seed).into_iter().map(of).collect()
    }

    #[test]
    fn continuous_noise_is_told_from_all_else() {
        for seed in 0..20 {
            for count in [1024, 5000, 20_000] {
                assert!(is_continuous_random(&noise(count, seed)), "{seed} {count}");
            }
            assert!(is_continuous_random(&narrow(20_000, seed)), "{seed}");
        }
        let periodic: Vec<f64> = noise(2000, 1).repeat(10);
        let long_period: Vec<f64> = noise(10_000, 1).repeat(2);
        let uneven = periodic[..17_300].to_vec();
        let burst: Vec<f64> = noise(20_000, 2)
            .into_iter()
            .enumerate()
            .map(|(k, x)| if k % 10_000 < 6000 { x } else { 0.0 })
            .collect();
        let blow: Vec<f64> = (0..20_000).map(|k| f64::from(u8::from(k < 9))).collect();
        let sweep: Vec<f64> = (0..20_000)
            .map(|k| (1e-5 * f64::from(k).powi(2)).sin())
            .collect();
        let sine: Vec<f64> = (0..20_000).map(|k| (0.3 * f64::from(k)).sin()).collect();
        for (name, signal) in [
            ("periodic", periodic),
            ("two periods", long_period),
            ("cut periods", uneven),
            ("bursts", burst),
            ("blow", blow),
            ("sweep", sweep),
            ("sine", sine),
            ("silence", vec![0.0; 20_000]),
            ("constant", vec![1.0; 20_000]),
            ("short", noise(500, 3)),
        ] {
            assert!(!is_continuous_random(&signal), "{name}");
        }
    }
}
