//! Time of the main stages on the named cases: `cargo bench`.

use chladni_bench::{corner_scene, panel_77x34_1997_lines, Case};
use chladni_render::{render, Method as RenderMethod, RenderOptions};
use chladni_rfp::{fit, FitOptions, Method};
use criterion::{criterion_group, criterion_main, Criterion};
use std::hint::black_box;

fn identification(c: &mut Criterion) {
    let mut group = c.benchmark_group("identification");
    group.sample_size(10);
    let panel = panel_77x34_1997_lines().expect("the committed panel").frf;
    let easy = Case::named("easy").expect("a case of that name").problem().expect("a constant case").measured(0);
    for method in Method::ALL {
        let options = FitOptions { method, ..FitOptions::default() };
        group.bench_function(format!("panel_77x34_1997_lines/{method}"), |b| b.iter(|| fit(black_box(&panel), &options, &|_| {})));
        group.bench_function(format!("easy/{method}"), |b| b.iter(|| fit(black_box(&easy), &options, &|_| {})));
    }
    group.finish();
}

fn rendering(c: &mut Criterion) {
    let mut group = c.benchmark_group("rendering");
    group.sample_size(20);
    let model = panel_77x34_1997_lines().expect("the committed panel").truth;
    let scene = corner_scene().expect("the committed scene");
    for method in RenderMethod::ALL {
        let options = RenderOptions { method: method.into(), ..RenderOptions::default() };
        group.bench_function(format!("corner_scene/{method}"), |b| b.iter(|| render(black_box(&model), &scene, &options)));
    }
    group.finish();
}

criterion_group!(stages, identification, rendering);
criterion_main!(stages);
