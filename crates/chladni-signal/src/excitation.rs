//! Tells continuous random excitation from blows, bursts, sweeps and periodic signals.

use super::whole_record::{smooth_length, spectrum};
use crate::limits::{
    ACTING, BLOCKS_APART, BLOCK_PIECES, LARGEST_NEIGHBOUR, LARGEST_REPEAT, LAST_PART, LEAST_LAG,
    LEAST_PIECE, LEAST_POWER, LEAST_SAMPLES, LINES, LONG_LAG, LOOKED_AT, OFFSET_MOST, PIECES,
    SMOOTH_NEIGHBOUR,
};
use chladni_frf::{Dof, Forcing, Run};
use chladni_linalg::fft;
use num_complex::Complex64;

/// True where the signal goes on through the whole record, its lines are independent and
/// nothing repeats.
pub(super) fn is_continuous_random(samples: &[f64]) -> bool {
    let samples = &samples[..smooth_length(samples.len())];
    if samples.len() < LEAST_SAMPLES || !is_steady(samples) {
        return false;
    }
    let lines = spectrum_without_mean(samples);
    neighbours(&lines) < LARGEST_NEIGHBOUR && !repeats(lines)
}

/// Course of a force that local fits of whole records cannot bear: where neighbouring lines are
/// alike, leakage looks like the response; where the force repeats, most lines have none.
pub(super) fn against_local_fits(runs: &[Run]) -> Option<Forcing> {
    let references = runs.iter().flat_map(Run::references);
    references
        .filter_map(|channel| {
            let samples = &channel.samples[..smooth_length(channel.samples.len())];
            if samples.len() < LEAST_SAMPLES {
                return None;
            }
            let lines = spectrum_without_mean(samples);
            if neighbours(&lines) > SMOOTH_NEIGHBOUR {
                return Some(Forcing::Transient);
            }
            repeats(lines).then_some(Forcing::Periodic)
        })
        .next()
}

/// Course of the force over blocks of `block` samples, where all references agree on it.
/// Bursts begin with their block.
pub(super) fn forcing(runs: &[Run], block: usize) -> Option<Forcing> {
    let references = runs.iter().map(|run| run.references().count()).min()?;
    let of = |reference: usize| course(&blocks(runs, reference, block), block);
    let first = (references > 0).then(|| of(0))??;
    let likewise = |reference: usize| match (first, of(reference)) {
        (Forcing::Burst { part }, Some(Forcing::Burst { part: other })) => {
            (part - other).abs() <= (2 * piece_of(block)) as f64 / block as f64
        }
        (_, other) => Some(first) == other,
    };
    (1..references).all(likewise).then_some(first)
}

/// The first reference whose signal repeats, but not from block to block: its lines leak.
pub(super) fn misses_period(runs: &[Run], block: usize) -> Option<Dof> {
    let references = runs.iter().map(|run| run.references().count()).min()?;
    let misses = |reference: &usize| {
        let samples = blocks(runs, *reference, block);
        if samples.len() < LEAST_SAMPLES || course(&samples, block).is_some() {
            return false;
        }
        let samples = without_means(&samples, block);
        repeats(spectrum_without_mean(
            &samples[..smooth_length(samples.len())],
        ))
    };
    let reference = (0..references).find(misses)?;
    let run = runs.first()?;
    run.references().nth(reference).map(|channel| channel.dof)
}

/// Whole blocks of one reference of all runs, one after the other.
fn blocks(runs: &[Run], reference: usize, block: usize) -> Vec<f64> {
    let channels = runs
        .iter()
        .filter_map(|run| run.references().nth(reference));
    let blocks = channels.flat_map(|channel| channel.samples.chunks_exact(block));
    let most = (LOOKED_AT.0 / block).max(LOOKED_AT.1);
    blocks.take(most).flatten().copied().collect()
}

/// `None` of a force that acts all the time, is not random, and is another in every block: what of
/// it leaks is not known.
fn course(samples: &[f64], block: usize) -> Option<Forcing> {
    // silence at the end of every block comes first: over many blocks it hardly shows
    let part = acting_part(samples, block);
    if part == 1.0 {
        let samples = without_means(samples, block);
        let repeats = blocks_repeat(&samples, block);
        // a fit must not take records that are too short to be judged for ones that leak nothing
        let is_one = samples.len() < 2 * block;
        let may_leak = samples.len() < LEAST_SAMPLES && (is_one || !repeats);
        return match may_leak || is_continuous_random(&samples) {
            true => Some(Forcing::Continuous),
            false => repeats.then_some(Forcing::Periodic),
        };
    }
    let acting = (part * block as f64) as usize;
    let bursts = samples
        .chunks_exact(block)
        .flat_map(|block| &block[..acting]);
    match is_continuous_random(&bursts.copied().collect::<Vec<f64>>()) {
        true => Some(Forcing::Burst { part }),
        false => Some(Forcing::Transient),
    }
}

/// Blocks without the mean of each: an offset that drifts from block to block is no force.
fn without_means(samples: &[f64], block: usize) -> Vec<f64> {
    let blocks = samples.chunks_exact(block);
    let moved = blocks.flat_map(|block| {
        let mean = block.iter().sum::<f64>() / block.len() as f64;
        block.iter().map(move |x| x - mean)
    });
    moved.collect()
}

/// True where each block is the one before it, but for noise; of one block, too, which says nothing
/// against it.
fn blocks_repeat(samples: &[f64], block: usize) -> bool {
    let before = samples.chunks_exact(block);
    let (mut apart, mut power) = (0.0, 0.0);
    for (a, b) in before.clone().zip(before.skip(1)) {
        apart += a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        power += a.iter().map(|a| a * a).sum::<f64>();
    }
    apart <= BLOCKS_APART * power
}

/// Samples of the pieces of a block whose powers are compared: a few at least, since one sample of
/// noise may be small by chance.
fn piece_of(block: usize) -> usize {
    (block / BLOCK_PIECES)
        .max(LEAST_PIECE.min(block / 2))
        .max(1)
}

/// Part of a block after which the force is silent, the mean over all blocks.
pub(super) fn acting_part(samples: &[f64], block: usize) -> f64 {
    let piece = piece_of(block);
    // the last piece takes what is left: it must not be shorter than the others
    let mut powers = vec![0.0; block / piece];
    let place = |k: usize| (k / piece).min(block / piece - 1);
    for samples in samples.chunks_exact(block) {
        let silence = rest_level(samples);
        for (k, x) in samples.iter().enumerate() {
            powers[place(k)] += (x - silence).powi(2);
        }
    }
    let largest = powers.iter().copied().fold(0.0, f64::max);
    let acts = |power: &f64| *power > ACTING * largest;
    match powers.iter().rposition(acts) {
        None => 0.0,
        Some(last) if last + 1 == powers.len() => 1.0,
        Some(last) => ((last + 1) * piece) as f64 / block as f64,
    }
}

/// Offset of the sensor in a block that ends in silence: the median of its last part, where that
/// is at rest and well below the largest value. 0 elsewhere: the last level of a signal that
/// switches is none.
pub(super) fn rest_level(samples: &[f64]) -> f64 {
    let mut last = samples[samples.len() - samples.len().div_ceil(LAST_PART)..].to_vec();
    let middle = last.len() / 2;
    let (_, median, _) = last.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    let power = |x: &f64| (x - median).powi(2);
    let largest = samples.iter().map(power).fold(0.0, f64::max);
    let at_rest = last.iter().map(power).sum::<f64>() < ACTING * largest * last.len() as f64;
    match at_rest && median.powi(2) < OFFSET_MOST.powi(2) * largest {
        true => median,
        false => 0.0,
    }
}

fn spectrum_without_mean(samples: &[f64]) -> Vec<Complex64> {
    let mut lines = spectrum(samples);
    lines[0] = Complex64::default();
    lines
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

/// |Σ X_k·X*_{k+1}| beside Σ|X|², sums over a few lines.
fn neighbours(lines: &[Complex64]) -> f64 {
    let (mut neighbours, mut power) = (0.0, 0.0);
    for window in lines[1..].chunks_exact(LINES) {
        let products = window.windows(2).map(|pair| pair[0] * pair[1].conj());
        neighbours += products.sum::<Complex64>().norm();
        power += window.iter().map(Complex64::norm_sqr).sum::<f64>();
    }
    neighbours / power.max(f64::MIN_POSITIVE)
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
    fft::inverse(2 * half).process(&mut lines);
    let long = (2 * half / LONG_LAG).max(LEAST_LAG).min(half);
    let largest = lines[long..=half]
        .iter()
        .map(|value| value.re.abs())
        .fold(0.0, f64::max);
    largest > LARGEST_REPEAT * lines[0].re
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::{Channel, SignalUnit};
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
            for count in [256, 500, 1024, 5000, 20_000] {
                assert!(is_continuous_random(&noise(count, seed)), "{seed} {count}");
            }
            assert!(is_continuous_random(&narrow(20_000, seed)), "{seed}");
            // two poles: values nine samples apart, a 64th of the record, correlate by 0.57
            let mut last = [0.0; 2];
            let low = noise(600, seed).into_iter().map(|x| {
                last[0] += 0.15 * (x - last[0]);
                last[1] += 0.15 * (last[0] - last[1]);
                last[1]
            });
            assert!(
                !repeats(spectrum_without_mean(&low.collect::<Vec<_>>())),
                "{seed}"
            );
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
            ("short", noise(250, 3)),
        ] {
            assert!(!is_continuous_random(&signal), "{name}");
        }
    }

    fn run(samples: Vec<f64>) -> Run {
        Run {
            file: "a".into(),
            line: 0,
            sample_rate_hz: 1.0,
            channels: vec![Channel {
                dof: "1:+Z".parse().unwrap(),
                unit: SignalUnit::Force,
                is_reference: true,
                samples,
            }],
        }
    }

    #[test]
    fn local_fits_bear_noise_of_the_whole_record_and_long_bursts() {
        let count = 20_000;
        let cut = |part: f64| -> Vec<f64> {
            let acts = |k: usize| f64::from(u8::from((k as f64) < part * count as f64));
            noise(count, 7)
                .iter()
                .enumerate()
                .map(|(k, x)| x * acts(k))
                .collect()
        };
        let sweep = (0..20_000).map(|k| (1e-5 * f64::from(k).powi(2)).sin());
        for part in [0.3, 0.6, 1.0] {
            assert_eq!(against_local_fits(&[run(cut(part))]), None, "{part}");
        }
        let transient = Some(Forcing::Transient);
        for part in [0.0005, 0.05, 0.1] {
            assert_eq!(against_local_fits(&[run(cut(part))]), transient, "{part}");
        }
        assert_eq!(against_local_fits(&[run(sweep.collect())]), transient);
        let periodic = noise(2000, 1).repeat(10);
        let random = run(noise(count, 2));
        assert_eq!(
            against_local_fits(&[random, run(periodic)]),
            Some(Forcing::Periodic)
        );
        // too short to be judged
        assert_eq!(against_local_fits(&[run(vec![1.0; 250])]), None);
    }

    #[test]
    fn the_course_of_a_force_over_its_blocks() {
        let block = 4000;
        let cut = |samples: Vec<f64>, part: f64| -> Vec<f64> {
            let acts = |k: usize| f64::from(u8::from(((k % block) as f64) < part * block as f64));
            samples
                .into_iter()
                .enumerate()
                .map(|(k, x)| x * acts(k))
                .collect()
        };
        let all = noise(10 * block, 4);
        let part_of = |forcing| match forcing {
            Some(Forcing::Burst { part }) => part,
            other => panic!("{other:?}"),
        };
        assert_eq!(
            forcing(&[run(all.clone())], block),
            Some(Forcing::Continuous)
        );
        for part in [0.3, 0.5, 0.9] {
            let found = part_of(forcing(&[run(cut(all.clone(), part))], block));
            assert!((found - part).abs() < 0.01, "{found} for {part}");
            // a sensor with an offset
            let moved = cut(all.clone(), part).iter().map(|x| x + 0.5).collect();
            let found = part_of(forcing(&[run(moved)], block));
            assert!((found - part).abs() < 0.01, "{found} for {part}");
        }
        // an offset of its own in each block
        let offset = |k: usize| (k / block) as f64;
        let drifting = all.iter().enumerate().map(|(k, x)| x + offset(k)).collect();
        assert_eq!(forcing(&[run(drifting)], block), Some(Forcing::Continuous));
        // short noise has no silence, whatever its last sample is
        for seed in 0..100 {
            for (samples, block) in [(400, 400), (401, 401), (257, 257), (200, 40), (200, 200)] {
                let short = forcing(&[run(noise(samples, seed))], block);
                assert_eq!(short, Some(Forcing::Continuous), "{seed}");
            }
        }
        let blows = cut(vec![1.0; 10 * block], 0.002);
        assert_eq!(
            forcing(&[run(blows.clone())], block),
            Some(Forcing::Transient)
        );
        let moved = blows.iter().map(|x| x + 0.3).collect();
        assert_eq!(forcing(&[run(moved)], block), Some(Forcing::Transient));
        let levels = noise(512, 6).iter().map(|x| x.signum()).collect::<Vec<_>>();
        assert_eq!(
            forcing(&[run(levels.repeat(80))], 512),
            Some(Forcing::Periodic)
        );
        let constant = vec![0.7; 10 * block];
        assert_eq!(forcing(&[run(constant)], block), Some(Forcing::Periodic));
        let periodic = run(noise(block, 5).repeat(10));
        let runs = [periodic];
        assert_eq!(forcing(&runs, block), Some(Forcing::Periodic));
        assert_eq!(misses_period(&runs, block), None);
        assert_eq!(misses_period(&runs, 2 * block), None);
        // blocks of another length than the period
        assert_eq!(forcing(&runs, block + 100), None);
        assert!(misses_period(&runs, block + 100).is_some());
        assert_eq!(misses_period(&[run(all.clone())], block), None);
        // a run of each kind is none of them
        assert_ne!(
            forcing(&[run(all), run(blows)], block),
            Some(Forcing::Continuous)
        );
    }
}
