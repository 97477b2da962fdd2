//! The truth of a layout, and the file that states it.

use super::layout::{DofPlace, Form, Layout, Shape, UnitPlace, PRELUDES};
use chladni_frf::FrfKind;
use num_complex::Complex64;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The truth: SI values on an axis in Hz, three responses at one reference.
pub(super) struct Truth {
    pub(super) frequency_hz: Vec<f64>,
    pub(super) frfs: Vec<(&'static str, Vec<Complex64>)>,
    pub(super) coherence: f64,
}

pub(super) const PAIRS: [(&str, &str); 3] =
    [("1:+Z", "101:+Z"), ("2:+Z", "101:+Z"), ("7:-X", "101:+Z")];

pub(super) fn truth(layout: &Layout, random: &mut ChaCha8Rng) -> Truth {
    let lines = random.random_range(8..14);
    let start = if layout.gap.is_some() { 0.0 } else { 5.0 };
    let step = random.random_range(3.0..9.0);
    let frequency_hz: Vec<f64> = (0..lines).map(|k| start + step * k as f64).collect();
    let count = if layout.shape == Shape::One { 1 } else { 3 };
    let resonance = TAU * (start + step * (lines as f64 / 2.0 - 0.3));
    let frfs = (0..count).map(|i| {
        let residue = random.random_range(0.5..2.0) * if i == 1 { -1.0 } else { 1.0 };
        let of_line = |&f: &f64| {
            let w = TAU * f;
            let below = Complex64::new(resonance * resonance - w * w, 0.05 * resonance * w);
            let value = residue / below;
            match layout.unit.2 {
                FrfKind::Receptance => value,
                FrfKind::Mobility => value * Complex64::new(0.0, w),
                FrfKind::Accelerance => value * -w * w,
            }
        };
        ("", frequency_hz.iter().map(of_line).collect())
    });
    let frfs: Vec<(&'static str, Vec<Complex64>)> = frfs.collect();
    Truth {
        frequency_hz,
        frfs: frfs
            .into_iter()
            .zip(PAIRS)
            .map(|((_, values), (response, _))| (response, values))
            .collect(),
        coherence: 0.75,
    }
}

/// The two numbers of a value as the layout writes them.
pub(super) fn columns_of(layout: &Layout, value: Complex64) -> [f64; 2] {
    let value = value / layout.unit.1;
    match layout.form {
        Form::ReIm => [value.re, value.im],
        Form::ImRe => [value.im, value.re],
        Form::Degrees => [value.norm(), value.arg().to_degrees()],
        Form::Radians => [value.norm(), value.arg()],
        Form::Decibels => [20.0 * value.norm().log10(), value.arg().to_degrees()],
    }
}

pub(super) fn table(layout: &Layout, truth: &Truth) -> String {
    let d = layout.delimiter;
    let end = if layout.trailing_delimiter { d } else { "" };
    let mut lines: Vec<String> = PRELUDES[layout.prelude]
        .iter()
        .map(|line| (*line).to_owned())
        .collect();
    match layout.unit_place {
        UnitPlace::Remark => lines.push(format!("# unit = {}", layout.unit.0)),
        UnitPlace::Line => lines.push(format!("Units: {}", layout.unit.0)),
        _ => {}
    }
    if layout.header {
        lines.extend(
            headers(layout, truth)
                .into_iter()
                .map(|line| format!("{}{}{end}", layout.header_sign, line.join(d))),
        );
    }
    let gap = |row: usize| layout.gap.filter(|_| row == 0);
    let cells = |row: usize, value: Complex64| -> Vec<String> {
        let mut cells: Vec<String> = columns_of(layout, value)
            .into_iter()
            .map(|number| match gap(row) {
                Some("blank") => String::new(),
                Some(gap) => gap.to_owned(),
                None => layout.number(number),
            })
            .collect();
        if layout.coherence {
            cells.push(layout.number(truth.coherence));
        }
        cells
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    if layout.shape == Shape::Long {
        for (i, (response, values)) in truth.frfs.iter().enumerate() {
            for (row, value) in values.iter().enumerate() {
                let f = layout.number(truth.frequency_hz[row] / layout.frequency.1);
                let mut line: Vec<String> = if layout.names.is_multiple_of(2) {
                    let (node, direction) = response.split_once(':').unwrap();
                    let code = if direction == "-X" { "-1" } else { "3" };
                    vec![node.into(), code.into(), "101".into(), "3".into()]
                } else {
                    vec![PAIRS[i].0.into(), PAIRS[i].1.into()]
                };
                line.push(f);
                line.extend(cells(row, *value));
                rows.push(line);
            }
        }
    } else {
        for (row, f) in truth.frequency_hz.iter().enumerate() {
            let mut line = vec![layout.number(f / layout.frequency.1)];
            for (_, values) in &truth.frfs {
                line.extend(cells(row, values[row]));
            }
            rows.push(line);
        }
    }
    for (at, row) in rows.iter().enumerate() {
        lines.push(format!("{}{end}", row.join(d)));
        if let Some(sign) = layout.commented_rows.filter(|_| at == 2 || at == 3) {
            lines.push(format!("{sign}{}{end}", row.join(d)));
        }
    }
    if let Some(sign) = layout.commented_rows.filter(|_| layout.names % 2 == 1) {
        // the first row, commented out above the data
        let first = lines.len() - rows.len() - 2;
        lines.insert(first, format!("{sign}{}{end}", rows[1].join(d)));
    }
    lines.push(String::new());
    lines.join(layout.line_end)
}

/// Rows of names and units.
pub(super) fn headers(layout: &Layout, truth: &Truth) -> Vec<Vec<String>> {
    let mut names = Vec::new();
    if layout.shape == Shape::Long {
        if layout.names.is_multiple_of(2) {
            names.extend(["node", "dir", "ref_node", "ref_dir"].map(str::to_owned));
        } else {
            names.extend(["response", "reference"].map(str::to_owned));
        }
    }
    names.push(layout.frequency_name());
    let mut above = vec![String::new()];
    let mut units = vec![layout.frequency.0.to_owned()];
    let frfs = if layout.shape == Shape::Long {
        1
    } else {
        truth.frfs.len()
    };
    for (response, reference) in &PAIRS[..frfs] {
        let pair = match layout.names % 3 {
            0 => format!("{response}/{reference}"),
            1 => format!("{response}:{reference}"),
            _ => format!(
                "{}/{}",
                response.replace(':', ""),
                reference.replace(":+", "")
            ),
        };
        let in_name = Some(pair.as_str()).filter(|_| layout.shape != Shape::Long);
        names.extend([layout.name(false, in_name), layout.name(true, in_name)]);
        above.extend([pair, String::new()]);
        units.extend([layout.label(false), layout.label(true)]);
        if layout.coherence {
            names.push("coherence".into());
            above.push(String::new());
            units.push("-".into());
        }
    }
    let mut rows = Vec::new();
    if layout.dofs == DofPlace::RowAbove && layout.shape != Shape::Long {
        rows.push(above);
    }
    rows.push(names);
    if layout.unit_place == UnitPlace::Row {
        if !layout.frequency_labelled {
            units[0] = "Hz".into();
        }
        rows.push(units);
    }
    rows
}

pub(super) fn encoded(text: &str, encoding: &str) -> Vec<u8> {
    match encoding {
        "utf-8" => text.into(),
        "utf-8 with mark" => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        "utf-16 le" => [0xfeff]
            .into_iter()
            .chain(text.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect(),
        "utf-16 be" => [0xfeff]
            .into_iter()
            .chain(text.encode_utf16())
            .flat_map(u16::to_be_bytes)
            .collect(),
        _ => text.chars().map(|c| u8::try_from(c).unwrap()).collect(),
    }
}
