//! Tests of the page's colours: any two of what is drawn together differ for every kind
//! of colour vision, and in grey.

use super::STYLE;
use crate::drawing::{Colour, ColourMap, SERIES};

/// Simulated vision in linear RGB (Machado, Oliveira and Fernandes, IEEE Trans. Vis.
/// Comput. Graph. 15, 2009, table 1, severity 1.0), and the common one.
const VISIONS: [(&str, [[f64; 3]; 3]); 4] = [
    (
        "common vision",
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ),
    (
        "protanopia",
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
    ),
    (
        "deuteranopia",
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
    ),
    (
        "tritanopia",
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    ),
];
/// From linear sRGB to XYZ (IEC 61966-2-1), and its white.
const TO_XYZ: [[f64; 3]; 3] = [
    [0.4124564, 0.3575761, 0.1804375],
    [0.2126729, 0.7151522, 0.0721750],
    [0.0193339, 0.1191920, 0.9503041],
];
const WHITE_XYZ: [f64; 3] = [0.95047, 1.0, 1.08883];
/// Least colour difference ΔE*ab of curves in one chart: about six of those that are just
/// seen.
const LEAST_DIFFERENCE: f64 = 15.0;
/// Least difference of lightness L* of two series, for grey prints.
const LEAST_LIGHTNESS: f64 = 6.0;
/// Least contrast of a curve with its ground (Web Content Accessibility Guidelines 2.2,
/// 1.4.11).
const LEAST_CONTRAST: f64 = 3.0;

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
}

fn linear(rgb: [u8; 3]) -> [f64; 3] {
    rgb.map(|value| match f64::from(value) / 255.0 {
        v if v <= 0.04045 => v / 12.92,
        v => ((v + 0.055) / 1.055).powf(2.4),
    })
}

/// L*, a*, b* (CIE 1976) as seen by `vision`.
fn lab(rgb: [u8; 3], vision: &[[f64; 3]; 3]) -> [f64; 3] {
    let seen = times(vision, linear(rgb)).map(|value| value.clamp(0.0, 1.0));
    let xyz = times(&TO_XYZ, seen);
    let [x, y, z] = [0, 1, 2].map(|k| match xyz[k] / WHITE_XYZ[k] {
        t if t > 216.0 / 24389.0 => t.cbrt(),
        t => (24389.0 / 27.0 * t + 16.0) / 116.0,
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn contrast(a: [u8; 3], b: [u8; 3]) -> f64 {
    let [a, b] = [a, b].map(|rgb| times(&TO_XYZ, linear(rgb))[1] + 0.05);
    a.max(b) / a.min(b)
}

/// The values of `names` in the light theme and in the dark one.
fn themes(names: &[&str]) -> [Vec<[u8; 3]>; 2] {
    let of = |name: &str| -> Vec<[u8; 3]> {
        let key = format!("--{name}: #");
        let values = STYLE
            .split(&key)
            .skip(1)
            .map(|rest| u32::from_str_radix(&rest[..6], 16).unwrap());
        values
            .map(|value| [value >> 16, value >> 8, value].map(|byte| (byte & 255) as u8))
            .collect()
    };
    [0, 1].map(|theme| names.iter().map(|name| of(name)[theme]).collect())
}

fn series() -> [Vec<[u8; 3]>; 2] {
    let names: Vec<String> = (0..SERIES).map(|k| format!("series-{k}")).collect();
    themes(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// ΔE*ab (CIE 1976) as seen by `vision`.
fn difference(a: [u8; 3], b: [u8; 3], vision: &[[f64; 3]; 3]) -> f64 {
    let (p, q) = (lab(a, vision), lab(b, vision));
    (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
}

fn assert_apart(colours: &[[u8; 3]]) {
    for (vision, matrix) in VISIONS {
        for (k, &a) in colours.iter().enumerate() {
            for &b in &colours[..k] {
                let difference = difference(a, b, &matrix);
                assert!(
                    difference >= LEAST_DIFFERENCE,
                    "{a:?} and {b:?} differ by {difference:.1} for {vision}"
                );
            }
        }
    }
}

#[test]
fn the_simulation_is_that_of_its_source() {
    // white stays white; vermilion and ochre, far apart for common vision, are the same
    // to protanopes
    for (vision, matrix) in VISIONS {
        let white = lab([255; 3], &matrix);
        assert!(
            (white[0] - 100.0).abs() < 0.1 && white[1].abs() < 0.5 && white[2].abs() < 0.5,
            "{vision}: {white:?}"
        );
    }
    assert!((lab([255, 0, 0], &VISIONS[0].1)[0] - 53.24).abs() < 0.01);
    let [common, protanope] =
        [0, 1].map(|k| difference([213, 94, 0], [165, 115, 0], &VISIONS[k].1));
    assert!(common > 30.0 && protanope < 3.0, "{common} {protanope}");
}

#[test]
fn series_are_told_apart_by_every_vision_in_grey_and_from_the_ground() {
    for (colours, ground) in series().into_iter().zip(themes(&["paper"])) {
        assert_apart(&colours);
        for (k, &a) in colours.iter().enumerate() {
            assert!(
                contrast(a, ground[0]) >= LEAST_CONTRAST,
                "{a:?} on {ground:?}: {:.2}",
                contrast(a, ground[0])
            );
            for &b in &colours[..k] {
                let lightness = (lab(a, &VISIONS[0].1)[0] - lab(b, &VISIONS[0].1)[0]).abs();
                assert!(
                    lightness >= LEAST_LIGHTNESS,
                    "{a:?} and {b:?} differ by {lightness:.1} in grey"
                );
            }
        }
    }
}

#[test]
fn measured_synthesised_and_residual_curves_are_told_apart_and_so_are_grades() {
    for colours in themes(&["measured", "series-1", "series-0"]) {
        assert_apart(&colours);
    }
    for colours in themes(&["good", "warn", "bad"]) {
        assert_apart(&colours);
    }
}

#[test]
fn levels_rise_in_lightness_for_every_vision() {
    for (vision, matrix) in VISIONS {
        let lightness: Vec<f64> = (0..=50)
            .map(|k| lab(ColourMap::Sequential.at(f64::from(k) / 50.0), &matrix)[0])
            .collect();
        assert!(
            lightness.windows(2).all(|pair| pair[1] > pair[0]),
            "{vision}: {lightness:?}"
        );
    }
}

#[test]
fn chart_files_have_the_colours_of_the_light_page() {
    let files: Vec<[u8; 3]> = (0..SERIES).map(|k| Colour::Series(k).rgb()).collect();
    assert_eq!(files, series()[0]);
}
