//! A model in words: the sentence that a fit begins with, and the table of its modes.

use crate::limits::{COLUMN_WIDTH, FEW_MODES, MOST_MODES, TERMINAL_WIDTH};
use chladni_console::table::{bounded, counted, significant, table, SIGMAS_95};
use chladni_frf::{Damping, ModalModel, Mode, Scaling, Trust};
use chladni_report::sentence;
use std::io::{stdout, IsTerminal};

/// The sentence, the table of modes, and a line about the whole.
pub fn text(model: &ModalModel, verbose: bool) -> String {
    let mut text = format!("{}\n", for_terminal(&headline(model)));
    text += &match verbose {
        true => every_mode(model),
        false => modes(model),
    };
    text += &format!("{}\n", whole(model, verbose));
    match &model.quality.path {
        Some(path) if verbose => text + &format!("path: {path}\n"),
        _ => text,
    }
}

/// The sentence on modes and the explained part of the data. Where poles were moved to new
/// data, their shift instead, since the quality is that of the known model.
fn headline(model: &ModalModel) -> String {
    let is_followed = model.options.contains_key("poles_of");
    let findings = &model.quality.findings;
    let moved = findings.iter().rfind(|one| one.code == "poles-followed");
    match moved.filter(|_| is_followed) {
        Some(moved) => format!("{}.", moved.text.replacen("poles", "Poles", 1)),
        None => sentence(model),
    }
}

/// The sentence in lines that fit on a terminal; in one line for a file or another program.
fn for_terminal(sentence: &str) -> String {
    if !stdout().is_terminal() {
        return sentence.to_owned();
    }
    let mut lines = vec![String::new()];
    for word in sentence.split(' ') {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && line + 1 + word.chars().count() > TERMINAL_WIDTH {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join("\n")
}

/// A mode with its number in the table.
struct Numbered<'a> {
    number: usize,
    mode: &'a Mode,
    /// The doubt about its damping, or the reason why the mode is weak.
    remark: String,
}

/// A table of the modes in the band that fits on a screen. Weak modes are listed where the
/// modes are few.
fn modes(model: &ModalModel) -> String {
    let all: Vec<Numbered> = model
        .in_band_modes()
        .zip(1..)
        .map(|(mode, number)| Numbered {
            number,
            mode,
            remark: remark(model, mode, number),
        })
        .collect();
    let lists_weak = all.len() <= FEW_MODES;
    let listed: Vec<&Numbered> = all
        .iter()
        .filter(|one| lists_weak || one.mode.trust == Trust::Sure)
        .take(MOST_MODES)
        .collect();
    let mut text = match listed.is_empty() {
        true => String::new(),
        false if listed.len() > FEW_MODES && listed.iter().all(|one| one.remark.is_empty()) => {
            two_columns(&listed)
        }
        false => with_remarks(&listed),
    };
    let left: Vec<&Numbered> = all
        .iter()
        .filter(|one| !listed.iter().any(|listed| listed.number == one.number))
        .collect();
    if let (Some(first), Some(last)) = (left.first(), left.last()) {
        let kind = match left.iter().all(|one| one.mode.trust == Trust::Weak) {
            true => "weak mode",
            false => "more mode",
        };
        text += &format!(
            "{}, {:.1} to {:.1} Hz: -v lists them with their reasons\n",
            counted(left.len(), kind),
            first.mode.frequency_hz,
            last.mode.frequency_hz
        );
    }
    text
}

/// Number, frequency and damping ratio in percent, with their bounds.
fn cells(one: &Numbered) -> [String; 3] {
    let Mode {
        frequency_hz,
        frequency_std_hz,
        damping_ratio,
        loss_factor_std,
        ..
    } = *one.mode;
    let bound = 0.5 * SIGMAS_95 * loss_factor_std;
    [
        one.number.to_string(),
        bounded(frequency_hz, SIGMAS_95 * frequency_std_hz),
        bounded(100.0 * damping_ratio, 100.0 * bound),
    ]
}

const HEADER: [&str; 4] = ["mode", "f, Hz ± 95 %", "ζ, % ± 95 %", ""];

fn with_remarks(listed: &[&Numbered]) -> String {
    let row = |one: &&Numbered| [cells(one).to_vec(), vec![one.remark.clone()]].concat();
    let rows: Vec<Vec<String>> = listed.iter().map(row).collect();
    format!("\n{}", table(&HEADER, &rows))
}

fn two_columns(listed: &[&Numbered]) -> String {
    let half = listed.len().div_ceil(2);
    let parts = [&listed[..half], &listed[half..]];
    let width = |lines: &[String]| lines.iter().map(|line| line.chars().count()).max();
    let bounded = parts.map(|part| column(part, true));
    let wide: usize = bounded.iter().filter_map(|lines| width(lines)).sum();
    // where the bounds of ζ do not fit on a terminal, one line below gives the largest
    let is_wide = wide + 2 > TERMINAL_WIDTH;
    let [left, right] = match is_wide {
        true => parts.map(|part| column(part, false)),
        false => bounded,
    };
    let beside = |(k, line): (usize, &String)| {
        let right = right.get(k).map_or("", String::as_str);
        let gap = COLUMN_WIDTH.saturating_sub(line.chars().count()) + 2;
        format!("{line}{:gap$}{right}", "").trim_end().to_owned() + "\n"
    };
    let bound = listed
        .iter()
        .map(|one| 50.0 * SIGMAS_95 * one.mode.loss_factor_std)
        .fold(0.0, f64::max);
    let worst = match is_wide {
        true => format!("ζ ± {} % or better (95 %).\n", significant(bound, 1)),
        false => String::new(),
    };
    format!(
        "\n{}{worst}",
        left.iter().enumerate().map(beside).collect::<String>()
    )
}

/// The lines of a column, with or without the bounds of ζ.
fn column(part: &[&Numbered], bounds: bool) -> Vec<String> {
    let row = |one: &&Numbered| {
        let [number, frequency, damping] = cells(one);
        let value = damping.split(" ±").next().unwrap_or_default().to_owned();
        vec![number, frequency, if bounds { damping } else { value }]
    };
    let rows: Vec<Vec<String>> = part.iter().map(row).collect();
    let shown = match bounds {
        true => table(&HEADER[..3], &rows),
        false => table(&[HEADER[0], HEADER[1], "ζ, %"], &rows),
    };
    shown.lines().map(str::to_owned).collect()
}

/// The remark in a mode's row beside its numbers.
fn remark(model: &ModalModel, mode: &Mode, number: usize) -> String {
    let said = |code: &str| {
        let mut findings = model.quality.findings.iter();
        findings.any(|finding| finding.code == code && finding.modes.contains(&number))
    };
    let damping = if said("damping-upper-bound") {
        "ζ is an upper bound"
    } else if said("damping-indicative") {
        "ζ is indicative only"
    } else {
        ""
    };
    let weak = (mode.trust != Trust::Sure).then(|| {
        let first = mode.reasons.first().map_or("", |reason| &reason.text);
        match mode.reasons.len() {
            0 => "weak".to_owned(),
            1 => format!("weak: {first}"),
            more => format!("weak: {first}; {} more", more - 1),
        }
    });
    weak.unwrap_or_else(|| damping.to_owned())
}

/// A table of every mode with its reasons, rejected ones and those outside the band included.
fn every_mode(model: &ModalModel) -> String {
    const HEADER: [&str; 5] = ["mode", "f, Hz ± 95 %", "ζ, % ± 95 %", "", "reasons"];
    let mut number = 0;
    let row = |mode: &Mode| {
        let counts = mode.counts();
        number += usize::from(counts);
        let one = Numbered {
            number,
            mode,
            remark: String::new(),
        };
        let [own, frequency, damping] = cells(&one);
        let grade = match (mode.in_band, mode.trust) {
            (false, _) => "outside the band",
            (true, Trust::Sure) => "sure",
            (true, Trust::Weak) => "weak",
            (true, Trust::Rejected) => "rejected",
        };
        vec![
            if counts { own } else { String::new() },
            frequency,
            damping,
            grade.into(),
            mode.reasons.sentences().join("; "),
        ]
    };
    let rows: Vec<Vec<String>> = model.modes.iter().map(row).collect();
    match rows.is_empty() {
        true => String::new(),
        false => format!("\n{}", table(&HEADER, &rows)),
    }
}

/// Damping law and scale; with `verbose` also the method and the poles outside the band.
fn whole(model: &ModalModel, verbose: bool) -> String {
    let law = match model.damping {
        Damping::Structural => "structural",
        Damping::Viscous => "viscous",
    };
    let scaling = match model.scaling {
        Scaling::UnitModalMass => "shapes of unit modal mass",
        Scaling::Unscaled => "shapes not mass-scaled",
    };
    let outside = model
        .modes
        .iter()
        .filter(|mode| !mode.in_band && mode.trust != Trust::Rejected)
        .count();
    let mut line = format!("Damping law: {law}; {scaling}");
    if verbose {
        line += &format!(
            "; method {}; {} outside the band (residual terms)",
            model.method,
            counted(outside, "pole")
        );
    }
    line + "."
}
