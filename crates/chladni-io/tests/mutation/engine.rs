//! Mutations of files and the run of a target under a budget of time; shared by the
//! readers of all crates.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::{Duration, Instant};

const SEED: u64 = 0x5eed;
/// Time from which a reader counts as hanging.
const SLOWEST: Duration = Duration::from_secs(1);
/// Words that numbers and other values are replaced with.
const WORDS: [&str; 32] = [
    "0",
    "-1",
    "1",
    "2",
    "999999999",
    "9999999999",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "1e308",
    "-1e-308",
    "1e999",
    "NaN",
    "-Inf",
    "nan",
    "inf",
    "*****",
    "1.5",
    "-0",
    "    -1",
    "\"\"",
    "\"x\"",
    "''",
    "[]",
    "[1]",
    "[[0.0]]",
    "{}",
    "true",
    "null",
    "1979-05-27",
    "=",
    "{\"a\":1}",
];
/// Integers that sizes are replaced with.
const SIZES: [u32; 8] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
];

fn budget() -> Duration {
    let seconds = std::env::var("CHLADNI_FUZZ_SECONDS")
        .ok()
        .and_then(|text| text.parse().ok());
    seconds.map_or(Duration::from_millis(900), Duration::from_secs)
}

/// One to eight changes of a seed, or of two joined.
fn mutated(seeds: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seeds[random.random_range(0..seeds.len())].clone();
    for _ in 0..random.random_range(1..=8) {
        if bytes.is_empty() {
            return bytes;
        }
        let at = random.random_range(0..bytes.len());
        match random.random_range(0..12) {
            0 => bytes[at] = random.random(),
            1 => bytes[at] ^= 1 << random.random_range(0..8),
            2 => bytes[at] = b"0123456789 -+.EDb\n*,;#"[random.random_range(0..22)],
            3 => drop(bytes.remove(at)),
            4 => bytes.insert(at, random.random()),
            5 => bytes.truncate(at),
            6 => {
                let end = (at + random.random_range(1..200)).min(bytes.len());
                bytes.drain(at..end);
            }
            7 => {
                let end = (at + random.random_range(1..200)).min(bytes.len());
                let part = bytes[at..end].to_vec();
                let to = random.random_range(0..=bytes.len());
                bytes.splice(to..to, part);
            }
            8 => replace_word(
                &mut bytes,
                at,
                |byte| byte.is_ascii_digit() || b"+-.EeDd".contains(&byte),
                random,
            ),
            9 => replace_word(
                &mut bytes,
                at,
                |byte| !byte.is_ascii_whitespace() && !b"[]{},=:;".contains(&byte),
                random,
            ),
            10 => {
                let size = SIZES[random.random_range(0..SIZES.len())];
                let size = if random.random() {
                    size.to_le_bytes()
                } else {
                    size.to_be_bytes()
                };
                for (byte, new) in bytes[at..].iter_mut().zip(size) {
                    *byte = new;
                }
            }
            _ => {
                let other = &seeds[random.random_range(0..seeds.len())];
                let from = random.random_range(0..=other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
        }
    }
    bytes
}

/// Replaces the word around `at`, with or without its width.
fn replace_word(
    bytes: &mut Vec<u8>,
    at: usize,
    is_part: impl Fn(u8) -> bool,
    random: &mut ChaCha8Rng,
) {
    let start = at
        - bytes[..at]
            .iter()
            .rev()
            .take_while(|&&byte| is_part(byte))
            .count();
    let end = at
        + bytes[at..]
            .iter()
            .take_while(|&&byte| is_part(byte))
            .count();
    let word = WORDS[random.random_range(0..WORDS.len())];
    let width = if random.random() { end - start } else { 0 };
    bytes.splice(start..end, format!("{word:>width$}").into_bytes());
}

/// Runs a target until the budget is spent.
fn run(name: &str, seeds: &[Vec<u8>], mut target: impl FnMut(&[u8])) {
    assert!(!seeds.is_empty());
    let (started, budget) = (Instant::now(), budget());
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut executions = 0_u64;
    let mut slowest = Duration::ZERO;
    while started.elapsed() < budget {
        for _ in 0..64 {
            let bytes = mutated(seeds, &mut random);
            let mut once = || {
                let (start, worked) = (Instant::now(), cpu_time::ProcessTime::now());
                let outcome =
                    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| target(&bytes)));
                // a busy machine may hold up any run, a reader that hangs is at work
                (outcome, start.elapsed().min(worked.elapsed()))
            };
            let (mut outcome, mut elapsed) = once();
            // other tests of this process work too: what hangs does so every time
            for _ in 0..3 {
                if outcome.is_ok() && elapsed > SLOWEST {
                    (outcome, elapsed) = once();
                }
            }
            if outcome.is_err() || elapsed > SLOWEST {
                let kept = std::env::temp_dir().join(format!("chladni-{name}-{executions}"));
                std::fs::write(&kept, &bytes).unwrap();
                panic!(
                    "{name}, execution {executions}, {elapsed:?}: kept as {}",
                    kept.display()
                );
            }
            slowest = slowest.max(elapsed);
            executions += 1;
        }
    }
    println!(
        "{name}: {executions} executions in {:.1?}, slowest {slowest:.1?}",
        started.elapsed()
    );
}

/// Runs a target whose reader needs a file.
pub fn run_files(name: &str, extension: &str, seeds: &[Vec<u8>], target: impl Fn(&Path, &[u8])) {
    // in memory, where the system has a place for it
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        tempfile::tempdir_in(memory)
    } else {
        tempfile::tempdir()
    }
    .unwrap();
    let path = folder.path().join(format!("mutated.{extension}"));
    run(name, seeds, |bytes| target(&path, bytes));
}
