//! Scenes in time, in processor time of all threads: `cargo bench --bench time`.

use chladni_frf::ModalModel;
use chladni_plate::{simulate, Panel};
use chladni_render::{modal_ramp, play, render, PlayOptions, Ramps, RenderOptions, Scene, Weights};
use cpu_time::ProcessTime;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{criterion_group, criterion_main, Criterion};
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// Processor time of all threads: a machine that others use as well hardly changes it.
struct ProcessorTime;

impl Measurement for ProcessorTime {
    type Intermediate = ProcessTime;
    type Value = Duration;
    fn start(&self) -> ProcessTime {
        ProcessTime::now()
    }
    fn end(&self, started: ProcessTime) -> Duration {
        started.elapsed()
    }
    fn add(&self, a: &Duration, b: &Duration) -> Duration {
        *a + *b
    }
    fn zero(&self) -> Duration {
        Duration::ZERO
    }
    fn to_f64(&self, value: &Duration) -> f64 {
        value.as_nanos() as f64
    }
    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

fn truth() -> ModalModel {
    let mut panel = Panel::default();
    panel.frf.step_hz = 99.8;
    simulate(&panel, None, None)
        .expect("the panel of the examples")
        .truth
}

fn scene(time: &str) -> Scene {
    let text = format!(
        "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, \
         0.170]\n[time]\n{time}"
    );
    Scene::parse(&text, Path::new("")).expect("a scene")
}

/// A burst of 100 ms: 250 ms are judged.
fn burst(ramp_s: f64) -> Scene {
    scene(&format!(
        "[[time.burst]]\nduration_s = 0.1\nramp_s = {ramp_s}\n"
    ))
}

fn steady(model: &ModalModel) -> Weights {
    render(model, &burst(0.015), &RenderOptions::default())
        .expect("a scene that can be met")
        .weights
}

fn in_time(c: &mut Criterion<ProcessorTime>) {
    let model = truth();
    let weights = steady(&model);
    let mut group = c.benchmark_group("time");
    group.sample_size(10);
    group.bench_function("modal_ramp_77x34", |b| {
        b.iter(|| black_box(modal_ramp(&model, 300.0)))
    });
    let options = |ramps, area| PlayOptions {
        ramps: Some(ramps),
        area,
        ..PlayOptions::default()
    };
    for (name, ramps, ramp_s, area) in [
        ("play_77_responses_250_ms", Ramps::Plain, 0.015, false),
        ("play_and_5_mm_ground", Ramps::Plain, 0.015, true),
        ("play_program_5_ms", Ramps::Program, 0.005, false),
    ] {
        let scene = burst(ramp_s);
        group.bench_function(name, |b| {
            b.iter(|| black_box(play(&model, &scene, Some(&weights), &options(ramps, area))))
        });
    }
    // 120 mm: 16 keyframes
    let moving = scene(
        "[[time.move]]\npath_m = [[0.05, 0.045], [0.17, 0.045]]\nspeed_m_per_s = 0.4\nhot_radius_m = 0.025\nquiet_from_m = 0.06\nramp_s = 0.015\n",
    );
    group.bench_function("play_16_keyframes", |b| {
        b.iter(|| black_box(play(&model, &moving, None, &options(Ramps::Modal, false))))
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(ProcessorTime);
    targets = in_time
}
criterion_main!(benches);
