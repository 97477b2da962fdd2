//! Charts: error, bias and coverage of damping over the lines per bandwidth, for the ways to
//! fit, for windows, and for forces that are not as they should be.

use super::cell::{POOR_DB, SNR_DB};
use super::{MeasuredForce, MeasuredSummary, MeasuredWay};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Height, Layer, Mark, Place, Stroke};

/// Width of a picture, px.
const WIDTH_PX: f64 = 720.0;
/// Height of a chart, px.
const CHART_PX: f64 = 150.0;
/// Diameter of a mark, px.
const MARK_PX: f64 = 9.0;
/// Blocks under Hann's window that stand for it.
const HANN_BLOCKS: usize = 46;
/// Coverage that intervals promise, %.
const PROMISED: f64 = 95.0;
/// Name of what intervals cover: charts of it show what they promise.
const COVERAGE: &str = "Coverage of";
/// Shift of the marks of one way beside the next, categories.
const SHIFT: f64 = 0.12;

/// A number of a summary, %.
type Value = fn(&MeasuredSummary) -> f64;
/// Points with a name.
type Series = (String, Vec<Place>);

/// The ways under Hann's window, the windows, and the forces; of tests with one force and few
/// responses.
pub fn measured_figures(summaries: &[MeasuredSummary]) -> Vec<Figure> {
    let simple = summaries.iter().filter(|row| row.cell.is_simple());
    let summaries: Vec<MeasuredSummary> = simple.cloned().collect();
    let figures = [ways(&summaries), windows(&summaries), forces(&summaries)];
    figures.into_iter().flatten().collect()
}

fn rmse(row: &MeasuredSummary) -> f64 {
    100.0 * row.loss_rmse
}

fn bias(row: &MeasuredSummary) -> f64 {
    100.0 * row.loss_bias
}

fn loss_covered(row: &MeasuredSummary) -> f64 {
    100.0 * row.coverage[1]
}

fn shape_covered(row: &MeasuredSummary) -> f64 {
    100.0 * row.coverage[2]
}

fn error_axis(what: &str) -> Axis {
    Axis::log(what, "%").padded(0.08)
}

/// Of 95 % intervals, from `least` on.
fn coverage_axis(what: &str, least: f64) -> Axis {
    let axis = Axis::linear(&format!("{COVERAGE} {what}"), "%");
    axis.range([least, 100.5 + 0.04 * (100.0 - least)])
        .step(0.25 * (100.0 - least))
}

/// Error, bias and coverage of every way under Hann's window, of the poor tests: those with
/// the widest range of lines per bandwidth.
fn ways(summaries: &[MeasuredSummary]) -> Option<Figure> {
    let rows: Vec<&MeasuredSummary> = summaries
        .iter()
        .filter(|row| row.cell.snr_db == POOR_DB)
        .collect();
    let series = |value: Value| by_way(&rows, |row| [row.cell.lines_per_bandwidth, value(row)]);
    let charts = vec![
        chart(
            lines_axis(),
            error_axis("Rms error of η"),
            &series(rmse),
            true,
        ),
        chart(
            lines_axis(),
            Axis::linear("Mean error of η", "%").padded(0.08),
            &unnamed(series(bias)),
            true,
        ),
        chart(
            lines_axis(),
            coverage_axis("η", 0.0),
            &unnamed(series(loss_covered)),
            true,
        ),
    ];
    let caption = "Loss factors under a Hann window, 46 blocks, responses with noise 30 dB below \
                   them, over the lines per half-power bandwidth: root mean square and mean of \
                   the relative error, and how many lie in their 95 % intervals.";
    figure(
        "measured-ways",
        "Ways to fit damping",
        caption,
        &rows,
        charts,
    )
}

/// Error of the plain fit, and error and coverage of the one that knows the window.
fn windows(summaries: &[MeasuredSummary]) -> Option<Figure> {
    let rows: Vec<&MeasuredSummary> = summaries
        .iter()
        .filter(|row| is_even(row) && row.cell.snr_db == SNR_DB)
        .filter(|row| kind(row).is_some())
        .collect();
    let series = |way: MeasuredWay, value: Value| {
        let own = rows.iter().filter(|row| row.way == way);
        let at = |row: &&&MeasuredSummary| [row.cell.lines_per_bandwidth, value(row)];
        grouped(own.filter_map(|row| Some((kind(row)?, at(&row)))))
    };
    let told = MeasuredWay::Told;
    let charts = vec![
        chart(
            lines_axis(),
            error_axis("Rms error, plain"),
            &series(MeasuredWay::Plain, rmse),
            true,
        ),
        chart(
            lines_axis(),
            error_axis("Rms error, told"),
            &unnamed(series(told, rmse)),
            true,
        ),
        chart(
            lines_axis(),
            coverage_axis("η, told", 80.0),
            &unnamed(series(told, loss_covered)),
            true,
        ),
    ];
    let caption = "Loss factors under every window, over the lines per half-power bandwidth: \
                   root mean square of the relative error of a fit of pure resonances and of one \
                   that knows the window, and how many of the latter lie in their 95 % intervals. \
                   Random noise in 30 to 46 blocks, bursts in 30, five blows.";
    figure("measured-windows", "Windows", caption, &rows, charts)
}

/// The window in a word, of one number of blocks each.
fn kind(row: &MeasuredSummary) -> Option<String> {
    let cell = &row.cell;
    let window = match cell.window_name() {
        name if name == "flattop" => "flat top".into(),
        name => name,
    };
    match cell.force {
        MeasuredForce::Random if window == "hann" && cell.averages() != HANN_BLOCKS => None,
        MeasuredForce::Random => Some(window),
        MeasuredForce::Burst(_) if window == "rectangular" => Some("bursts".into()),
        // whatever the lines per bandwidth, no fit undoes that
        MeasuredForce::Burst(_) => None,
        MeasuredForce::Hammer if window == "rectangular" => Some("blows".into()),
        MeasuredForce::Hammer => Some(format!("blows, {window}")),
        MeasuredForce::Sines => None,
    }
}

/// Error and coverage where the force drops at resonances, or is noisy.
fn forces(summaries: &[MeasuredSummary]) -> Option<Figure> {
    let rows: Vec<&MeasuredSummary> = summaries.iter().filter(|row| !is_even(row)).collect();
    let mut names: Vec<String> = Vec::new();
    for row in &rows {
        let name = force_name(row);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let place = |row: &MeasuredSummary| {
        let own = force_name(row);
        names.iter().position(|name| *name == own).unwrap_or(0) as f64
    };
    // marks of the ways side by side
    let series = |value: Value| {
        let mut all = by_way(&rows, |row| [place(row), value(row)]);
        for (n, (_, points)) in all.iter_mut().enumerate() {
            let shift = SHIFT * (n as f64 - 0.5 * (MeasuredWay::ALL.len() - 1) as f64);
            points.iter_mut().for_each(|point| point[0] += shift);
        }
        all
    };
    let x = || {
        let places = names.iter().enumerate();
        Axis::linear("Force at resonances, lines per bandwidth", "–")
            .range([-0.5, names.len() as f64 - 0.5])
            .names(places.map(|(n, name)| (n as f64, name.clone())).collect())
    };
    let charts = vec![
        chart(x(), error_axis("Rms error of η"), &series(rmse), false),
        chart(
            x(),
            coverage_axis("η", 0.0),
            &unnamed(series(loss_covered)),
            false,
        ),
        chart(
            x(),
            coverage_axis("shapes", 0.0),
            &unnamed(series(shape_covered)),
            false,
        ),
    ];
    let caption = "Forces that drop at every resonance by so many dB, and forces measured with \
                   noise 34 dB below them, b lines per half-power bandwidth: root mean square of \
                   the relative error of loss factors, and how many loss factors and shape \
                   values lie in their 95 % intervals.";
    figure(
        "measured-forces",
        "Drop and noise of the force",
        caption,
        &rows,
        charts,
    )
}

/// True where the force neither drops nor is noisy.
fn is_even(row: &MeasuredSummary) -> bool {
    row.cell.drop_db == 0.0 && row.cell.force_snr_db.is_infinite()
}

/// In a few signs.
fn force_name(row: &MeasuredSummary) -> String {
    let cell = &row.cell;
    let mut parts = Vec::new();
    if cell.drop_db > 0.0 {
        parts.push(format!("−{} dB", cell.drop_db));
    }
    if cell.force_snr_db.is_finite() {
        parts.push("noise".to_owned());
    }
    format!("{}, b={}", parts.join(" + "), cell.lines_per_bandwidth)
}

/// One series for each way.
fn by_way(rows: &[&MeasuredSummary], at: impl Fn(&MeasuredSummary) -> Place) -> Vec<Series> {
    let of_way = |way: MeasuredWay| {
        let own = rows.iter().filter(|row| row.way == way);
        (way.name().to_owned(), own.map(|row| at(row)).collect())
    };
    MeasuredWay::ALL.into_iter().map(of_way).collect()
}

/// One series for each name, in the order of their first points.
fn grouped(points: impl Iterator<Item = (String, Place)>) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for (name, point) in points {
        match all.iter_mut().find(|(known, _)| *known == name) {
            Some((_, own)) => own.push(point),
            None => all.push((name, vec![point])),
        }
    }
    all
}

/// Without names: the legend of the chart above holds them.
fn unnamed(series: Vec<Series>) -> Vec<Series> {
    let without = |(_, points)| (String::new(), points);
    series.into_iter().map(without).collect()
}

fn lines_axis() -> Axis {
    let ticks = [0.5, 1.0, 2.0, 4.0, 8.0];
    Axis::log("Lines per half-power bandwidth", "–")
        .padded(0.06)
        .names(ticks.map(|b| (b, b.to_string())).to_vec())
}

/// Series by sign and colour, `joined` by lines; coverage beside what intervals promise.
fn chart(x: Axis, y: Axis, series: &[Series], joined: bool) -> Chart {
    let promises = y.label.starts_with(COVERAGE);
    let mut chart = Chart::new(x, y).height(Height::Px(CHART_PX));
    if promises {
        let stroke = Stroke {
            dash: Dash::Dashed,
            ..Stroke::new(Colour::Muted, 1.0)
        };
        chart = chart.with(Layer::Horizontals {
            name: None,
            at: vec![PROMISED],
            stroke,
        });
    }
    for (n, (name, points)) in series.iter().enumerate() {
        let colour = Colour::Series(n as u8);
        if joined {
            chart = chart.line("", points.clone(), Stroke::new(colour, 1.2));
        }
        chart = chart.marks(name, points.clone(), Mark::of_series(n), colour, MARK_PX);
    }
    chart
}

/// `None` where no test serves it.
fn figure(
    name: &str,
    title: &str,
    caption: &str,
    rows: &[&MeasuredSummary],
    charts: Vec<Chart>,
) -> Option<Figure> {
    (!rows.is_empty()).then(|| Figure {
        name: name.into(),
        title: format!("Damping of tests simulated in time: {title}"),
        caption: caption.into(),
        width: WIDTH_PX,
        charts,
    })
}
