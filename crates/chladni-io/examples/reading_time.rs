//! Processor time that reading universal files takes, beside that of their raw bytes:
//! `cargo run --release -p chladni-io --example reading_time FILE...` prints seconds of
//! both, the least of ten, for each file.

use chladni_io::{uff, ReadOptions};
use cpu_time::ProcessTime;
use std::hint::black_box;
use std::path::Path;

/// Seconds of processor time, the least of ten runs.
fn least_seconds(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = ProcessTime::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..10).map(once).fold(f64::INFINITY, f64::min)
}

fn main() {
    for name in std::env::args().skip(1) {
        let path = Path::new(&name);
        let bytes = || std::fs::read(path).expect("a file that can be read");
        let raw = least_seconds(|| drop(black_box(bytes())));
        let functions = least_seconds(|| {
            drop(
                black_box(uff::read(&bytes(), path, &ReadOptions::default()))
                    .expect("a universal file"),
            )
        });
        println!("{functions:.6} {raw:.6} {name}");
    }
}
