//! Natural frequencies against converged values, and what shapes must satisfy.

use chladni_plate::{DampedPlate, Edges, Panel, Plate, PlateModes, PointMass, PointSpring};
use std::f64::consts::PI;

/// Relative tolerance: the values are given to five or six digits.
const PRINTED: f64 = 1e-4;

/// λ = ω a² √(ρh/D), free rectangles, ν = 0.3, converged series of 18 × 18 polynomials;
/// by a/b.
const FREE: [(f64, &[f64]); 3] = [
    (
        1.0,
        &[
            13.4682, 19.5961, 24.2702, 34.8009, 34.8009, 61.0932, 61.0932, 63.6861, 69.2654,
            77.1717,
        ],
    ),
    (
        1.5,
        &[
            20.0955, 21.4133, 46.3470, 49.9099, 57.7135, 67.0297, 85.8548, 98.8337,
        ],
    ),
    (
        2.5,
        &[
            21.4539, 32.9890, 59.6287, 70.8032, 116.4208, 118.2681, 140.2939, 152.7748,
        ],
    ),
];
const SIMPLY_SUPPORTED_SQUARE: [f64; 6] = [19.7392, 49.3480, 49.3480, 78.9568, 98.6960, 98.6960];
const CLAMPED_SQUARE: [f64; 6] = [35.9852, 73.3938, 73.3938, 108.2165, 131.5808, 132.2048];
/// Leissa 1973, 36 beam products: upper bounds, up to one per cent high.
const LEISSA_FREE_SQUARE: [f64; 5] = [13.49, 19.79, 24.43, 35.02, 35.02];
/// NAFEMS FV12 (10 m × 10 m × 0.05 m, E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³), converged,
/// Hz, modes 4 to 9.
const FV12_HZ: [f64; 6] = [1.6217, 2.3595, 2.9223, 4.1902, 4.1902, 7.3560];
/// Cantilever square, ν = 0.3 (Barton's case), converged.
const CANTILEVER_PUBLISHED: [f64; 6] = [3.492, 8.525, 21.43, 27.33, 31.11, 54.44];
/// The glass panel, Hz.
const PANEL_HZ: [f64; 14] = [
    54.35, 55.3, 124.9, 137.2, 149.4, 178.9, 226.0, 269.0, 299.4, 365.7, 383.7, 396.8, 413.1, 493.3,
];

fn plate(edges: &str, length_m: f64, width_m: f64) -> Plate {
    let edges = Edges::try_from(edges.to_string()).unwrap();
    Plate {
        length_m,
        width_m,
        thickness_m: 0.001,
        poisson_ratio: 0.3,
        edges,
        ..Plate::default()
    }
}

/// λ of the elastic modes.
fn lambda(plate: &Plate, count: usize) -> Vec<f64> {
    let modes = PlateModes::up_to(plate, &[], 1.0, count).unwrap();
    let scale = plate.length_m.powi(2) * (plate.mass_per_area() / plate.bending_stiffness()).sqrt();
    modes
        .omega()
        .iter()
        .skip(modes.rigid_count())
        .map(|omega| omega * scale)
        .collect()
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    for (n, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a / b - 1.0).abs() < tolerance,
            "mode {}: {a} instead of {b}",
            n + 1
        );
    }
    assert!(found.len() >= expected.len());
}

#[test]
fn free_rectangles_have_the_converged_frequencies() {
    for (ratio, expected) in FREE {
        assert_near(
            &lambda(&plate("FFFF", 0.3, 0.3 / ratio), expected.len()),
            expected,
            PRINTED,
        );
    }
}

#[test]
fn supported_and_clamped_squares_have_the_converged_frequencies() {
    assert_near(
        &lambda(&plate("SSSS", 0.3, 0.3), 6),
        &SIMPLY_SUPPORTED_SQUARE,
        PRINTED,
    );
    assert_near(
        &lambda(&plate("CCCC", 0.3, 0.3), 6),
        &CLAMPED_SQUARE,
        PRINTED,
    );
}

#[test]
fn a_simply_supported_rectangle_follows_its_closed_form_to_nine_digits() {
    let plate = plate("SSSS", 0.4, 0.25);
    let mut exact: Vec<f64> = (1..12)
        .flat_map(|m| {
            (1..12)
                .map(move |n| PI * PI * ((m * m) as f64 + (n * n) as f64 * (0.4f64 / 0.25).powi(2)))
        })
        .collect();
    exact.sort_by(f64::total_cmp);
    assert_near(&lambda(&plate, 40), &exact[..40], 1e-9);
}

#[test]
fn published_short_series_lie_above_the_converged_values_by_at_most_one_and_a_half_per_cent() {
    for (found, published) in [
        (lambda(&plate("FFFF", 0.3, 0.3), 5), &LEISSA_FREE_SQUARE[..]),
        (
            lambda(&plate("CFFF", 0.3, 0.3), 6),
            &CANTILEVER_PUBLISHED[..],
        ),
    ] {
        for (a, b) in found.iter().zip(published) {
            assert!(*a < b * 1.0005 && *a > b * 0.985, "{a} against {b}");
        }
    }
}

#[test]
fn the_nafems_free_plate_has_its_frequencies_in_hertz() {
    let fv12 = Plate {
        length_m: 10.0,
        width_m: 10.0,
        thickness_m: 0.05,
        youngs_modulus_pa: 200e9,
        poisson_ratio: 0.3,
        density_kg_per_m3: 8000.0,
        ..Plate::default()
    };
    let modes = PlateModes::up_to(&fv12, &[], 8.0, 6).unwrap();
    assert_near(&modes.frequency_hz().to_vec()[3..], &FV12_HZ, PRINTED);
}

#[test]
fn the_glass_panel_has_its_frequencies_to_the_printed_digit_and_51_modes_below_2_khz() {
    let modes = PlateModes::up_to(&Plate::default(), &[], 4000.0, 60).unwrap();
    let frequencies = modes.frequency_hz();
    assert_eq!(
        frequencies.iter().take(3).copied().collect::<Vec<_>>(),
        [0.0; 3]
    );
    for (n, expected) in PANEL_HZ.iter().enumerate() {
        assert!(
            (frequencies[n + 3] - expected).abs() <= 0.05 + 1e-9,
            "{} instead of {expected}",
            frequencies[n + 3]
        );
    }
    let below = |limit: f64| frequencies.iter().skip(3).filter(|&&f| f < limit).count();
    assert_eq!([300.0, 600.0, 1000.0, 2000.0].map(below), [9, 17, 25, 51]);
}

#[test]
fn more_polynomials_change_no_kept_mode_by_a_millionth() {
    for edges in ["FFFF", "CSFS", "CCCC"] {
        let plate = plate(edges, 0.268, 0.170);
        let modes = PlateModes::up_to(&plate, &[], 3000.0, 60).unwrap();
        // the band decides the number of polynomials
        let finer = PlateModes::up_to(&plate, &[], 26_000.0, 60).unwrap();
        let more = |d: usize| finer.terms()[d] >= modes.terms()[d] + 12;
        assert!(more(0) && more(1), "{:?}", finer.terms());
        let in_band = finer
            .frequency_hz()
            .iter()
            .filter(|&&f| f <= 3000.0)
            .count();
        assert_eq!(modes.len(), in_band.max(modes.rigid_count() + 60));
        for (a, b) in modes
            .omega()
            .iter()
            .zip(finer.omega())
            .skip(modes.rigid_count())
        {
            assert!((a / b - 1.0).abs() < 1e-6, "{edges}: {a} against {b}");
        }
    }
}

#[test]
fn shapes_are_orthonormal_in_mass_also_within_repeated_pairs_and_with_point_masses() {
    let masses =
        [([0.01, 0.02], 0.004), ([0.2, 0.11], 0.002)].map(|(position_m, mass_kg)| PointMass {
            position_m,
            mass_kg,
        });
    for (edges, sides, masses) in [
        ("FFFF", [0.2, 0.2], &masses[..0]),
        ("SSSS", [0.2, 0.2], &masses[..0]),
        ("FFFF", [0.25, 0.15], &masses[..]),
        ("SFFF", [0.25, 0.15], &masses[..]),
    ] {
        let plate = plate(edges, sides[0], sides[1]);
        let modes = PlateModes::up_to(&plate, masses, 1500.0, 20).unwrap();
        let (points, weights) = quadrature(sides, 60);
        let shapes = modes.evaluate(&points).unwrap();
        let at_masses = modes
            .evaluate(&masses.iter().map(|m| m.position_m).collect::<Vec<_>>())
            .unwrap();
        for m in 0..modes.len() {
            for n in 0..=m {
                let spread: f64 = (0..points.len())
                    .map(|p| plate.mass_per_area() * weights[p] * shapes[[p, m]] * shapes[[p, n]])
                    .sum();
                let lumped: f64 = masses
                    .iter()
                    .enumerate()
                    .map(|(k, mass)| mass.mass_kg * at_masses[[k, m]] * at_masses[[k, n]])
                    .sum();
                let expected = if m == n { 1.0 } else { 0.0 };
                assert!(
                    (spread + lumped - expected).abs() < 1e-9,
                    "{edges}: modes {m}, {n}: {}",
                    spread + lumped
                );
            }
        }
    }
}

/// Gauss-Chebyshev points of the second kind with Fejér's weights: exact for polynomials
/// below `count` per side.
fn quadrature(sides: [f64; 2], count: usize) -> (Vec<[f64; 2]>, Vec<f64>) {
    let angle = |i: usize| PI * (i as f64 + 0.5) / count as f64;
    let weight = |i: usize| {
        let sum: f64 = (1..=count / 2)
            .map(|j| (2.0 * j as f64 * angle(i)).cos() / (4.0 * (j * j) as f64 - 1.0))
            .sum();
        2.0 / count as f64 * (1.0 - 2.0 * sum)
    };
    let rule: Vec<(f64, f64)> = (0..count)
        .map(|i| ((1.0 + angle(i).cos()) / 2.0, weight(i) / 2.0))
        .collect();
    rule.iter()
        .flat_map(|&(x, wx)| {
            rule.iter()
                .map(move |&(y, wy)| ([x * sides[0], y * sides[1]], wx * wy * sides[0] * sides[1]))
        })
        .unzip()
}

#[test]
fn point_masses_lower_every_frequency_and_coils_of_a_tenth_gram_move_the_first_mode_as_known() {
    let plate = Plate::default();
    let mut panel = chladni_plate::Panel::default();
    panel.references.mass_kg = 1e-4;
    let masses = panel.layout().masses;
    assert_eq!(masses.len(), 34);
    let bare = PlateModes::up_to(&plate, &[], 1000.0, 60).unwrap();
    let loaded = PlateModes::up_to(&plate, &masses, 1000.0, 60).unwrap();
    for (a, b) in bare.omega().iter().zip(loaded.omega()).skip(3) {
        assert!(b < a);
    }
    // modes 4: the first elastic one
    assert!((bare.frequency_hz()[3] - 54.35).abs() < 0.05);
    assert!(
        (loaded.frequency_hz()[3] - 52.4).abs() < 0.05,
        "{}",
        loaded.frequency_hz()[3]
    );
}

#[test]
fn masses_without_symmetry_give_the_same_modes_as_with_it() {
    // a mass of nearly nothing breaks the parity classes; frequencies must not notice
    let plate = Plate::default();
    let speck = [PointMass {
        position_m: [0.05, 0.03],
        mass_kg: 1e-15,
    }];
    let whole = PlateModes::up_to(&plate, &speck, 600.0, 20).unwrap();
    let classes = PlateModes::up_to(&plate, &[], 600.0, 20).unwrap();
    assert_near(
        &whole.omega().to_vec()[3..],
        &classes.omega().to_vec()[3..],
        1e-10,
    );
    let point = [[0.01, 0.16]];
    let (a, b) = (
        whole.evaluate(&point).unwrap(),
        classes.evaluate(&point).unwrap(),
    );
    for n in 3..a.ncols() {
        assert!((a[[0, n]].abs() - b[[0, n]].abs()).abs() < 1e-6 * b[[0, n]].abs().max(1.0));
    }
}

#[test]
fn what_lies_off_the_plate_is_refused_with_its_position() {
    let modes = PlateModes::up_to(&Plate::default(), &[], 100.0, 5).unwrap();
    let error = modes.evaluate(&[[0.3, 0.1]]).unwrap_err().to_string();
    assert!(error.contains("0.3") && error.contains("0.268"), "{error}");
    assert!(
        modes.evaluate(&[[0.268 + 1e-12, 0.0]]).is_ok(),
        "roundings of a layout are on the edge"
    );
    let mass = [PointMass {
        position_m: [-0.1, 0.1],
        mass_kg: 1.0,
    }];
    assert!(PlateModes::up_to(&Plate::default(), &mass, 100.0, 5).is_err());
}

/// A plate on elastic edges or springs of a stiffness, and its frequencies, Hz.
fn held(edges: &str, stiffness_n_per_m2: f64, springs: &[PointSpring]) -> PlateModes {
    let plate = Plate {
        edges: Edges::try_from(edges.to_string()).unwrap(),
        stiffness_n_per_m2,
        ..Plate::default()
    };
    PlateModes::held(&plate, &[], springs, 500.0, 10).unwrap()
}

#[test]
fn elastic_edges_go_from_free_to_supported() {
    let [free, supported] = ["FFFF", "SFSF"].map(|edges| held(edges, 0.0, &[]).frequency_hz());
    // soft edges: two rigid motions on springs, ω² = 2k/(ρh a) and 6k/(ρh a), and a tilt about
    // the long axis of the same stiffness as up and down
    let (k, plate) = (10.0, Plate::default());
    let soft = held("EFEF", k, &[]);
    let omega2 = 2.0 * k / (plate.mass_per_area() * plate.length_m);
    let expected = [omega2, omega2, 3.0 * omega2].map(|w2| w2.sqrt() / std::f64::consts::TAU);
    assert_eq!(soft.rigid_count(), 0);
    for (found, expected) in soft.frequency_hz().iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
    let first = soft.frequency_hz()[3] / free[3] - 1.0;
    assert!((0.0..2e-2).contains(&first), "{first}");
    // hard ones: the frequencies of supports, from below
    let hard = held("EFEF", 1e8, &[]).frequency_hz();
    for (found, expected) in hard.iter().zip(&supported).take(8) {
        let off = found / expected - 1.0;
        assert!((-5e-3..1e-6).contains(&off), "{found} {expected}");
    }
    // one elastic edge leaves the rotation about it
    assert_eq!(held("EFFF", 1e3, &[]).rigid_count(), 1);
}

#[test]
fn springs_hold_a_plate_as_they_must() {
    let plate = Plate::default();
    // four soft springs in the corners: up and down is ω² = 4k/M, tilts have thrice that
    let corners = [[0.0, 0.0], [0.268, 0.0], [0.268, 0.170], [0.0, 0.170]];
    let springs = |stiffness_n_per_m: f64| {
        corners.map(|position_m| PointSpring {
            position_m,
            stiffness_n_per_m,
        })
    };
    let found = held("FFFF", 0.0, &springs(0.05));
    let square = 4.0 * 0.05 / plate.mass();
    let expected = [square, 3.0 * square, 3.0 * square].map(|w2: f64| w2.sqrt());
    for (found, expected) in found.omega().iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
    // one spring holds one motion, two hold two
    assert_eq!(held("FFFF", 0.0, &springs(1e3)[..1]).rigid_count(), 2);
    assert_eq!(held("FFFF", 0.0, &springs(1e3)[..2]).rigid_count(), 1);
    // shapes stay mass-normalised: springs of the same place and twice half the stiffness
    let once = held("FFFF", 0.0, &springs(1e3));
    let twice = held("FFFF", 0.0, &[springs(5e2), springs(5e2)].concat());
    let apart = once.omega() - twice.omega();
    assert!(apart.iter().all(|d| d.abs() < 1e-6), "{apart}");
    let off = PointSpring {
        position_m: [0.3, 0.0],
        stiffness_n_per_m: 1.0,
    };
    assert!(PlateModes::held(&plate, &[], &[off], 100.0, 4).is_err());
}

#[test]
fn actuators_load_hold_and_damp_a_panel() {
    let text = |keys: &str| format!("[references]\n{keys}\n[frf]\nstop_hz = 400\n");
    let plate = |keys: &str| {
        let panel = Panel::from_toml(&text(keys), 2 << 30).unwrap();
        DampedPlate::of_panel(&panel, panel.frf.stop_hz).unwrap()
    };
    let plain = plate("");
    let damped = plate("damping_n_s_per_m = 0.01");
    assert_eq!(plain.modes.omega(), damped.modes.omega());
    let rigid = plain.modes.rigid_count();
    let added = damped.loss_factors() - plain.loss_factors();
    // ω·η·m of a mode is what its dampers take: c·Σψ²
    let places = Panel::default().layout().references_m;
    let shapes = plain.modes.evaluate(&places).unwrap();
    for n in rigid..rigid + 8 {
        let taken: f64 = shapes.column(n).iter().map(|v| 0.01 * v * v).sum();
        let found = added[n] * plain.modes.omega()[n];
        assert!((found / taken - 1.0).abs() < 1e-9, "{found} {taken}");
    }
    let held = plate("stiffness_n_per_m = 2\nmass_kg = 0.0005");
    let mass = Plate::default().mass() + 34.0 * 5e-4;
    let expected = (34.0 * 2.0 / mass).sqrt();
    let nearest = held
        .modes
        .omega()
        .iter()
        .map(|w| (w / expected - 1.0).abs());
    assert!(held.modes.rigid_count() == 0 && nearest.fold(1.0, f64::min) < 0.05);
    for (keys, field) in [
        ("stiffness_n_per_m = -1", "references.stiffness_n_per_m"),
        ("damping_n_s_per_m = nan", "references.damping_n_s_per_m"),
    ] {
        let error = Panel::from_toml(&text(keys), 2 << 30)
            .unwrap_err()
            .to_string();
        assert!(error.contains(field) && error.contains("line 2"), "{error}");
    }
    // dampers that hold the panel still leave no damped modes
    let held = Panel::from_toml(&text("damping_n_s_per_m = 1e6"), 2 << 30).unwrap();
    let error = DampedPlate::of_panel(&held, held.frf.stop_hz).unwrap_err();
    assert_eq!(error.field.as_deref(), Some("references.damping_n_s_per_m"));
    let most = error.expected.as_deref().and_then(|text| {
        let number = text.strip_prefix("at most about ")?.split(',').next()?;
        number.parse::<f64>().ok()
    });
    let most = most.unwrap();
    for (times, passes) in [(0.99, true), (1.1, false)] {
        let keys = format!("damping_n_s_per_m = {}", times * most);
        let panel = Panel::from_toml(&text(&keys), 2 << 30).unwrap();
        let made = DampedPlate::of_panel(&panel, panel.frf.stop_hz);
        assert_eq!(made.is_ok(), passes, "{keys}");
    }
    let error = Panel::from_toml("[plate]\nedges = \"EFFF\"", 2 << 30).unwrap_err();
    assert!(
        error.to_string().contains("plate.stiffness_n_per_m2"),
        "{error}"
    );
}
