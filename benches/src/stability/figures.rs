//! Maps and calibration as charts.

use super::{Calibration, Map, MapAxis, StabilityRow, Trial};
use crate::solver::Solver;
use crate::statistics::{mean, median};
use chladni_report::{
    Axis, Cell, Chart, Colour, ColourBar, ColourMap, Dash, Figure, Height, Layer, Mark, Stroke,
};

/// Width of a picture, px.
const WIDTH_PX: f64 = 640.0;
/// Height of a cell, px.
const CELL_PX: f64 = 30.0;
/// Errors over the bound, or over what is stated, from here on are drawn alike.
const LARGEST_ERROR: f64 = 10.0;

/// A figure for each map and method, and those of the calibration.
pub fn stability_figures(rows: &[StabilityRow], calibrations: &[Calibration]) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut rest = rows;
    while let Some(first) = rest.first() {
        let end = rest
            .iter()
            .position(|row| row.map.name != first.map.name || row.solver != first.solver)
            .unwrap_or(rest.len());
        let (own, others) = rest.split_at(end);
        figures.push(map_figure(first.map, first.solver, own));
        rest = others;
    }
    figures.extend(announced_figure(calibrations));
    figures.extend(
        calibrations
            .iter()
            .filter(|c| c.map.is_none() && c.modes > 0)
            .map(ranks_figure),
    );
    figures
}

/// Three charts over the same axes: what goes wrong, what of it is silent, and how large
/// errors are.
fn map_figure(map: &Map, solver: Solver, rows: &[StabilityRow]) -> Figure {
    let first = match map.identifies() {
        true => "Modes missed / spurious per fit",
        false => "Hot or cold ground served",
    };
    let share = |label: &str| bar(Axis::linear(label, "share").range([0.0, 1.0]).step(0.25));
    let wrong = |row: &StabilityRow| per_try(row, &|trial| usize::from(trial.wrong()));
    let silent = |row: &StabilityRow| {
        let count = row.silent().count();
        let text = if count > 0 {
            count.to_string()
        } else {
            String::new()
        };
        (count as f64 / row.trials.len() as f64, text)
    };
    let silent_words = "Tries wrong without a word";
    let mut charts = vec![
        chart(map, rows, first, share("Wrong tries"), &|row| {
            (wrong(row), counts(map, row))
        }),
        chart(map, rows, silent_words, share("Silent tries"), &silent),
    ];
    if map.identifies() {
        let axis = Axis::linear("Error", "stated σ").range([0.0, LARGEST_ERROR]);
        let about = "Largest error over what is stated";
        charts.push(chart(map, rows, about, bar(axis.step(2.5)), &|row| {
            (error(row) / LARGEST_ERROR, short(error(row)))
        }));
    }
    let tries = rows.iter().map(|row| row.trials.len()).max().unwrap_or(0);
    Figure {
        name: format!("stability-{}-{solver}", map.name),
        title: format!("{}: {solver}", map.name),
        caption: format!(
            "{}; {tries} seeds in each cell. Wrong: a missed or spurious mode, or an \
                          error beyond 5 stated standard deviations; a drive that serves less than \
                          95 % of the hot or of the cold ground.",
            map.about
        ),
        width: WIDTH_PX,
        charts,
    }
}

/// The mean of a count over the tries of a cell.
fn per_try(row: &StabilityRow, count: &dyn Fn(&Trial) -> usize) -> f64 {
    mean(row.trials.iter().map(|(_, trial)| count(trial) as f64))
}

/// The median error of the tries of a cell.
fn error(row: &StabilityRow) -> f64 {
    let errors = row.trials.iter().map(|(_, trial)| trial.error);
    median(&errors.collect::<Vec<_>>())
}

/// Modes missed and spurious, or the ground that drives serve, in words.
fn counts(map: &Map, row: &StabilityRow) -> String {
    if !map.identifies() {
        return format!("{:.2}", error(row));
    }
    let spurious = per_try(row, &|trial| trial.spurious_sure + trial.spurious_weak);
    format!(
        "{} / {}",
        short(per_try(row, &|trial| trial.missed)),
        short(spurious)
    )
}

fn bar(axis: Axis) -> ColourBar {
    ColourBar {
        axis,
        map: ColourMap::White,
        bands: 0,
        lines: Vec::new(),
    }
}

fn chart(
    map: &Map,
    rows: &[StabilityRow],
    about: &str,
    bar: ColourBar,
    value: &dyn Fn(&StabilityRow) -> (f64, String),
) -> Chart {
    let steps = |axis: usize| {
        let mut steps: Vec<usize> = rows.iter().map(|row| row.cell[axis]).collect();
        steps.sort_unstable();
        steps.dedup();
        steps
    };
    let (xs, ys) = (steps(0), steps(1));
    let place = |steps: &[usize], step: usize| {
        steps.iter().position(|other| *other == step).unwrap_or(0) as f64
    };
    let cells = rows.iter().map(|row| {
        let (x, y) = (place(&xs, row.cell[0]), place(&ys, row.cell[1]));
        let (part, text) = value(row);
        Cell {
            sides: [[x - 0.49, x + 0.49], [y - 0.47, y + 0.47]],
            fill: bar.map.at(part),
            hint: format!(
                "{} {}, {} {}: {text}",
                map.x.label,
                map.x.text(row.cell[0]),
                map.y.label,
                map.y.text(row.cell[1])
            ),
            text,
        }
    });
    let named = |axis: &MapAxis, steps: &[usize], label: String| {
        let names = steps
            .iter()
            .enumerate()
            .map(|(k, &step)| (k as f64, axis.text(step)))
            .collect();
        Axis::linear(&label, axis.unit)
            .range([-0.5, steps.len() as f64 - 0.5])
            .names(names)
    };
    let x = named(&map.x, &xs, format!("{about}    │    {}", map.x.label));
    let y = named(&map.y, &ys, map.y.label.to_owned());
    let mut chart = Chart::new(x, y)
        .height(Height::Px(CELL_PX * ys.len().max(4) as f64))
        .with(Layer::Cells(cells.collect()));
    chart.grid = false;
    chart.colour_bar = Some(bar);
    chart
}

/// A number in a cell.
fn short(value: f64) -> String {
    match value {
        value if value.is_nan() => "–".into(),
        value if value.is_infinite() || value >= 1000.0 => "> 999".into(),
        value if value >= 9.95 => format!("{value:.0}"),
        value if value == value.round() => format!("{value:.0}"),
        value => format!("{value:.1}"),
    }
}

/// Each method's tries over all maps, in the four classes, as points of a share.
fn announced_figure(calibrations: &[Calibration]) -> Option<Figure> {
    let all: Vec<&Calibration> = calibrations.iter().filter(|c| c.map.is_none()).collect();
    if all.is_empty() {
        return None;
    }
    let names = all
        .iter()
        .enumerate()
        .map(|(k, c)| (k as f64, c.solver.to_string()))
        .collect();
    let tries = |c: &Calibration| (c.quiet + c.false_alarms + c.announced + c.silent) as f64;
    let points = |value: &dyn Fn(&Calibration) -> usize| {
        all.iter()
            .enumerate()
            .map(|(k, c)| [k as f64, 100.0 * value(c) as f64 / tries(c)])
            .collect::<Vec<_>>()
    };
    let chart = Chart::new(
        Axis::linear("Method", "over all maps")
            .range([-0.5, all.len() as f64 - 0.5])
            .names(names),
        Axis::linear("Part of all tries", "%").range([0.0, 100.0]),
    )
    .height(Height::Px(240.0))
    .marks(
        "wrong, announced",
        points(&|c| c.announced),
        Mark::Ring,
        Colour::Ink,
        11.0,
    )
    .marks(
        "wrong and silent",
        points(&|c| c.silent),
        Mark::Cross,
        Colour::Series(1),
        10.0,
    )
    .marks(
        "right, warned all the same",
        points(&|c| c.false_alarms),
        Mark::Triangle,
        Colour::Series(0),
        9.0,
    );
    Some(Figure {
        name: "stability-announced".into(),
        title: "Failures that were announced, and silent ones".into(),
        caption: "Over all cells of all maps. The maps go far beyond what can be done: the \
                  question is whether a method says so."
            .into(),
        width: WIDTH_PX,
        charts: vec![chart],
    })
}

/// Ranks of errors in their stated distributions.
fn ranks_figure(c: &Calibration) -> Figure {
    let expected = c.modes as f64 / c.frequency_ranks.len() as f64;
    // three standard deviations of a binomial count
    let spread = 3.0 * (expected * (1.0 - 1.0 / c.frequency_ranks.len() as f64)).sqrt() / expected;
    let stems = |name: &str, ranks: &[usize], aside: f64, series: u8| {
        let place = |k: usize, count: usize| [k as f64 + 0.5 + aside, count as f64 / expected];
        let points = ranks.iter().enumerate();
        Layer::Stems {
            name: Some(name.into()),
            points: points
                .map(|(k, &count)| (place(k, count), format!("{count} modes")))
                .collect(),
            mark: Mark::of_series(series.into()),
            colour: Colour::Series(series),
        }
    };
    let limit = |name: &str, at: Vec<f64>, dash: Dash| Layer::Horizontals {
        name: Some(name.into()),
        at,
        stroke: Stroke::new(Colour::Ink, 1.2).dashed(dash),
    };
    let tallest = c
        .frequency_ranks
        .iter()
        .chain(&c.loss_factor_ranks)
        .copied()
        .max()
        .unwrap_or(0) as f64
        / expected;
    let chart = Chart::new(
        Axis::linear("Place of the error in its stated distribution", "tenths")
            .range([0.0, c.frequency_ranks.len() as f64])
            .step(1.0),
        Axis::linear("Modes over their share", "–").range([0.0, (1.1 * tallest).max(1.6)]),
    )
    .height(Height::Px(220.0))
    .with(limit("bars that are right", vec![1.0], Dash::Dashed))
    .with(limit(
        "and their chance",
        vec![1.0 - spread, 1.0 + spread],
        Dash::Dotted,
    ))
    .with(stems("natural frequencies", &c.frequency_ranks, -0.12, 0))
    .with(stems("loss factors", &c.loss_factor_ranks, 0.12, 1));
    Figure {
        name: format!("stability-ranks-{}", c.solver),
        title: format!("Rank histogram of the error bars: {}", c.solver),
        caption: format!(
            "{} modes of the maps with white noise. High at both ends: bars too short; high in the \
             middle: too long.",
            c.modes
        ),
        width: WIDTH_PX,
        charts: vec![chart],
    }
}
