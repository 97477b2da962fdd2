//! The estimation of FRFs: the group `/estimation` of attributes alone.

use crate::arrays::tree::{Attribute, Entry, Group};
use chladni_frf::{BlockWindow, Error, Estimation, Forcing, Result};

/// Path of the group.
pub(super) const PATH: &str = "/estimation";

/// The group of `made`.
pub(super) fn estimation_group<'a>(made: &Estimation) -> Group<'a> {
    let mut group = Group::new(PATH.trim_start_matches('/'));
    let count = |count: usize| Attribute::Integer(count as i64);
    let text = |text: &str| Attribute::FixedText(text.to_owned());
    group.set("estimator", text(made.estimator.name()));
    group.set("window", text(made.window.name()));
    if let Some(rate_per_s) = made.window.rate_per_s() {
        group.set("window_rate_per_s", Attribute::Real(rate_per_s));
    }
    if let Some(forcing) = made.forcing {
        group.set("forcing", text(forcing.name()));
        if let Some(part) = forcing.part() {
            group.set("burst_part", Attribute::Real(part));
        }
    }
    group.set("transform_s", Attribute::Real(made.transform_s));
    group.set("gate_s", Attribute::Real(made.gate_s));
    group.set("hop_s", Attribute::Real(made.hop_s));
    group.set("averages_least", count(made.averages[0]));
    group.set("averages_most", count(made.averages[1]));
    group.set("lines_per_value", count(made.lines_per_value));
    group
}

/// Reads the content of the group.
pub(super) fn read_estimation(entry: &Entry) -> Result<Estimation> {
    let wrong = |name: &str, expected: &str| {
        Error::bad_data("an attribute is missing or makes no sense")
            .field(format!("{name} of {PATH}"))
            .found(
                entry
                    .attribute(name)
                    .map_or("nothing".into(), |found| format!("{found:?}")),
            )
            .expected(expected)
            .help("correct it in the program that wrote the file, or remove the group")
    };
    let seconds = |name: &str| {
        entry
            .real(name)
            .filter(|value| value.is_finite() && *value > 0.0)
            .ok_or_else(|| wrong(name, "a time above 0 s"))
    };
    let count = |name: &str| {
        entry
            .integer(name)
            .and_then(|value| usize::try_from(value).ok())
            .ok_or_else(|| wrong(name, "a count"))
    };
    let estimator = entry.text("estimator").unwrap_or_default();
    let window = entry.text("window").unwrap_or_default();
    Ok(Estimation {
        estimator: estimator
            .parse()
            .map_err(|_| wrong("estimator", "h1, h2, hv, lpm or lrm"))?,
        window: BlockWindow::named(window, entry.real("window_rate_per_s")).ok_or_else(|| {
            wrong(
                "window",
                "rectangular, hann, or exponential with its window_rate_per_s",
            )
        })?,
        forcing: entry.text("forcing").map_or(Ok(None), |name| {
            let known = Forcing::named(name, entry.real("burst_part"));
            known.map(Some).ok_or_else(|| {
                wrong(
                    "forcing",
                    "continuous, transient, periodic, or burst with its burst_part",
                )
            })
        })?,
        transform_s: seconds("transform_s")?,
        gate_s: seconds("gate_s")?,
        hop_s: seconds("hop_s")?,
        averages: [count("averages_least")?, count("averages_most")?],
        lines_per_value: count("lines_per_value")?,
    })
}
