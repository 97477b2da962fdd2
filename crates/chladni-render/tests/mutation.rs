//! Damaged scenes and panels by the thousand: never a panic, never a hang. As `crates/chladni-frf/tests/mutation.rs`;
//! `CHLADNI_FUZZ_SECONDS` makes it long.

use chladni_plate::Panel;
use chladni_render::Scene;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::{Duration, Instant};

const SEED: u64 = 0x5eed;
const SLOWEST: Duration = Duration::from_secs(1);
const WORDS: [&str; 20] = [
    "0",
    "-1",
    "1",
    "999999999",
    "9223372036854775807",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "-inf",
    "\"\"",
    "\"x\"",
    "[]",
    "[1]",
    "[[0.0]]",
    "{}",
    "true",
    "1979-05-27",
    "''",
    "=",
];

fn mutated(seeds: &[String], random: &mut ChaCha8Rng) -> String {
    let mut text: Vec<char> = seeds[random.random_range(0..seeds.len())].chars().collect();
    for _ in 0..random.random_range(1..=6) {
        if text.is_empty() {
            break;
        }
        let at = random.random_range(0..text.len());
        match random.random_range(0..7) {
            0 => text[at] = char::from(random.random_range(9..127)),
            1 => drop(text.remove(at)),
            2 => text.truncate(at),
            3 => {
                let end = (at + random.random_range(1..60)).min(text.len());
                let part: Vec<char> = text[at..end].to_vec();
                let to = random.random_range(0..=text.len());
                text.splice(to..to, part);
            }
            4 => {
                let end = (at + random.random_range(1..60)).min(text.len());
                text.drain(at..end);
            }
            // a value becomes another one
            5 => {
                let value = |c: &char| !c.is_whitespace() && !"[],=".contains(*c);
                let start = at - text[..at].iter().rev().take_while(|c| value(c)).count();
                let end = at + text[at..].iter().take_while(|c| value(c)).count();
                text.splice(start..end, WORDS[random.random_range(0..WORDS.len())].chars());
            }
            _ => {
                let other: Vec<char> = seeds[random.random_range(0..seeds.len())].chars().collect();
                let from = random.random_range(0..=other.len());
                text.truncate(at);
                text.extend(&other[from..]);
            }
        }
    }
    text.into_iter().collect()
}

#[test]
fn scene_and_panel_toml() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let mut seeds: Vec<String> = Vec::new();
    for name in ["scene-corner.toml", "panel.toml", "panel-driving-points.toml"] {
        seeds.extend(std::iter::repeat_n(std::fs::read_to_string(fixtures.join(name)).unwrap(), 5));
    }
    for class in ["scene", "panel"] {
        let mut files: Vec<_> =
            std::fs::read_dir(fixtures.join("malformed").join(class)).unwrap().flatten().map(|entry| entry.path()).collect();
        files.sort();
        seeds.extend(files.iter().map(|file| std::fs::read_to_string(file).unwrap()));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mutated.toml");
    let seconds = std::env::var("CHLADNI_FUZZ_SECONDS").ok().and_then(|text| text.parse().ok());
    let budget = seconds.map_or(Duration::from_millis(900), Duration::from_secs);
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let (started, mut executions, mut slowest) = (Instant::now(), 0_u64, Duration::ZERO);
    while started.elapsed() < budget {
        let text = mutated(&seeds, &mut random);
        std::fs::write(&path, &text).unwrap();
        let once = || {
            let start = Instant::now();
            let outcome = std::panic::catch_unwind(|| {
                let _ = Scene::read(&path);
                let _ = Panel::read(&path, 1 << 28);
            });
            assert!(outcome.is_ok(), "execution {executions}:\n{text}");
            start.elapsed()
        };
        // a busy machine may hold up any run, a reader that hangs does so every time
        let elapsed = (0..3).map(|_| once()).find(|elapsed| *elapsed < SLOWEST);
        let Some(elapsed) = elapsed else { panic!("execution {executions} hangs:\n{text}") };
        slowest = slowest.max(elapsed);
        executions += 1;
    }
    println!("scene_and_panel_toml: {executions} executions in {:.1?}, slowest {slowest:.1?}", started.elapsed());
}
