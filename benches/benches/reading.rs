//! Reading universal files, beside reading the raw bytes: `cargo bench --bench reading`.

use chladni_bench::panel_77x34_1997_lines;
use chladni_io::{uff, Contents, ReadOptions};
use criterion::{criterion_group, criterion_main, Criterion, Throughput};
use std::hint::black_box;
use std::path::Path;

fn reading(c: &mut Criterion) {
    let frf = panel_77x34_1997_lines().expect("the committed panel").frf;
    let contents = Contents {
        frf: Some(frf),
        ..Contents::default()
    };
    let mut group = c.benchmark_group("reading");
    group.sample_size(10);
    for (name, binary) in [("58b", true), ("58 text", false)] {
        let mut bytes = Vec::new();
        uff::write(
            &mut bytes,
            &contents,
            uff::WriteOptions {
                binary,
                old_datasets: false,
            },
        )
        .expect("a memory sink");
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(file.path(), &bytes).expect("room for the file");
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        let raw = || std::fs::read(file.path()).expect("the file just written");
        group.bench_function(format!("{name}/raw bytes"), |b| b.iter(|| black_box(raw())));
        group.bench_function(format!("{name}/functions"), |b| {
            b.iter(|| {
                uff::read(
                    black_box(&raw()),
                    Path::new("panel.uff"),
                    &ReadOptions::default(),
                )
                .expect("our own file")
            })
        });
    }
    group.finish();
}

criterion_group!(benches, reading);
criterion_main!(benches);
