//! Time of each stage on the named cases: `cargo bench`, or `cargo bench -- uff` for some
//! of them.

use chladni_bench::{corner_scene, panel_77x34_1997_lines, Case};
use chladni_frf::FrfSet;
use chladni_io::{read_frf, write_contents, Contents, ReadOptions};
use chladni_render::{render, Method as RenderMethod, RenderOptions};
use chladni_rfp::{fit, fit_watched, CancelToken, Effort, FitOptions, Method};
use criterion::{criterion_group, criterion_main, Criterion, Throughput};
use std::hint::black_box;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Stages of a fit by the names that it gives them.
const STAGES: [(&str, &str); 4] = [
    ("sketch", "reduce"),
    ("pole pool", "vector_fitting_and_refinement"),
    ("projection", "varpro_and_second_pass"),
    ("shapes", "residues_and_shapes"),
];

/// Modes of the panel in its band.
const PANEL_MODES: usize = 25;

fn panel() -> FrfSet {
    panel_77x34_1997_lines().expect("the committed panel").frf
}

/// Time that a fit spends in the stage `name`.
fn time_in(frf: &FrfSet, options: &FitOptions, name: &str) -> Duration {
    let marks = Mutex::new(Vec::new());
    let mark = |stage: &str| {
        marks
            .lock()
            .expect("nothing panics while it is held")
            .push((stage == name, Instant::now()))
    };
    let fitted = fit_watched(frf, options, &mark, &CancelToken::new());
    mark("the end");
    let _ = black_box(fitted);
    let marks = marks.into_inner().expect("nothing panics while it is held");
    marks
        .windows(2)
        .filter(|pair| pair[0].0)
        .map(|pair| pair[1].1 - pair[0].1)
        .sum()
}

fn stages(c: &mut Criterion) {
    let mut group = c.benchmark_group("stage");
    group.sample_size(10);
    let (panel, easy) = (
        panel(),
        Case::named("easy")
            .expect("a case of that name")
            .problem()
            .expect("a constant case")
            .measured(0),
    );
    for (case, frf) in [("panel_77x34_1997_lines", &panel), ("easy", &easy)] {
        for (stage, name) in STAGES {
            let timed = |repeats: u64| {
                (0..repeats)
                    .map(|_| time_in(frf, &FitOptions::default(), stage))
                    .sum::<Duration>()
            };
            group.bench_function(format!("{case}/{name}"), |b| b.iter_custom(timed));
        }
    }
    group.finish();
}

/// Searches of each kind that a step is the difference of: the least time of them counts,
/// for a machine that others use as well only makes times longer.
const TRIES: usize = 3;

/// Time of one step: what two searches for poles that differ by some steps differ by.
fn step(
    frf: &FrfSet,
    options: impl Fn(usize) -> FitOptions,
    [fewer, more]: [usize; 2],
) -> Duration {
    let least_time = |steps: usize| {
        (0..TRIES)
            .map(|_| time_in(frf, &options(steps), "poles"))
            .min()
            .unwrap_or_default()
    };
    let difference = least_time(more).saturating_sub(least_time(fewer)) / (more - fewer) as u32;
    // criterion takes no zero, which is what noise can make of a short step
    difference.max(Duration::from_nanos(1))
}

fn steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("step");
    group.sample_size(10);
    let panel = panel();
    let lean = |effort: Effort| FitOptions {
        method: Method::Lean,
        modes: Some(PANEL_MODES),
        effort,
        ..FitOptions::default()
    };
    let pool = |pool_iterations| {
        lean(Effort {
            pool_iterations,
            ..Effort::default()
        })
    };
    let likelihood = |likelihood_steps| {
        lean(Effort {
            likelihood_steps,
            ..Effort::default()
        })
    };
    let timed = |options: &dyn Fn(usize) -> FitOptions, steps: [usize; 2], repeats: u64| {
        (0..repeats)
            .map(|_| step(&panel, options, steps))
            .sum::<Duration>()
    };
    group.bench_function("panel_77x34_1997_lines/vector_fitting", |b| {
        b.iter_custom(|repeats| timed(&pool, [4, 104], repeats))
    });
    group.bench_function("panel_77x34_1997_lines/varpro", |b| {
        b.iter_custom(|repeats| timed(&likelihood, [0, 3], repeats))
    });
    group.finish();
}

fn identification(c: &mut Criterion) {
    let mut group = c.benchmark_group("identification");
    group.sample_size(10);
    let (panel, easy) = (
        panel(),
        Case::named("easy")
            .expect("a case of that name")
            .problem()
            .expect("a constant case")
            .measured(0),
    );
    for method in Method::ALL {
        let options = FitOptions {
            method,
            ..FitOptions::default()
        };
        group.bench_function(format!("panel_77x34_1997_lines/{method}"), |b| {
            b.iter(|| fit(black_box(&panel), &options))
        });
        group.bench_function(format!("easy/{method}"), |b| {
            b.iter(|| fit(black_box(&easy), &options))
        });
    }
    group.finish();
}

fn rendering(c: &mut Criterion) {
    let mut group = c.benchmark_group("rendering");
    group.sample_size(20);
    let model = panel_77x34_1997_lines().expect("the committed panel").truth;
    let scene = corner_scene().expect("the committed scene");
    for method in RenderMethod::ALL {
        let options = RenderOptions {
            method: method.into(),
            ..RenderOptions::default()
        };
        group.bench_function(format!("corner_scene/{method}"), |b| {
            b.iter(|| render(black_box(&model), &scene, &options))
        });
    }
    group.finish();
}

fn files(c: &mut Criterion) {
    let mut group = c.benchmark_group("files");
    group.sample_size(10);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let contents = Contents {
        frf: Some(panel()),
        ..Contents::default()
    };
    for (extension, name) in [
        ("uff", "uff58_text"),
        ("ufb", "uff58b_binary"),
        ("h5", "hdf5"),
    ] {
        let path = folder.path().join(format!("panel.{extension}"));
        write_contents(&path, &contents, false).expect("room for the panel");
        let bytes = path.metadata().expect("the file just written").len();
        group.throughput(Throughput::Bytes(bytes));
        group.bench_function(format!("read/{name}"), |b| {
            b.iter(|| {
                read_frf(
                    black_box(std::slice::from_ref(&path)),
                    &ReadOptions::default(),
                )
                .expect("the file just written")
            })
        });
    }
    group.finish();
}

criterion_group!(all, stages, steps, identification, rendering, files);
criterion_main!(all);
