//! The fit in pieces: what it finds is what the whole finds, the bits depend on the
//! blocks alone, and pieces that do not belong together are refused by name.

use crate::common::{easy, fitted, resynthesis_error};
use chladni_frf::{FrfSet, FrfValues, ModalModel, Trust};
use chladni_plate::{add_noise_of_variance, gain_noise, outliers, SyntheticSet};
use chladni_rfp::pieces::{reduce, residues, solve, Partial, Poles, Reducer, Solved};
use chladni_rfp::{Effort, FitOptions};
use ndarray::{s, Array3, Axis};
use num_complex::Complex64;
use std::ops::Range;

/// The easy set at 64 responses and 3 references.
fn set() -> SyntheticSet {
    let mut set = easy(45.0, 5);
    (set.responses, set.references) = (64, 3);
    set.build().unwrap()
}

/// The FRFs of some responses.
fn rows(frf: &FrfSet, rows: Range<usize>) -> FrfSet {
    let FrfValues::F64(values) = &frf.values else {
        panic!("synthetic sets are in double precision")
    };
    FrfSet {
        values: FrfValues::F64(values.slice(s![rows.clone(), .., ..]).to_owned()),
        responses: frf.responses[rows].to_vec(),
        ..frf.clone()
    }
}

/// `count` blocks of about the same size, with their numbers.
fn blocks(frf: &FrfSet, count: usize) -> Vec<(u64, FrfSet)> {
    let of = |b: usize| b * frf.responses.len() / count;
    (0..count)
        .map(|b| (b as u64, rows(frf, of(b)..of(b + 1))))
        .collect()
}

fn reduced(blocks: &[(u64, FrfSet)], poles: Option<&Poles>) -> Vec<Partial> {
    blocks
        .iter()
        .map(|(number, frf)| {
            reduce(frf, &FitOptions::default(), *number, Vec::new(), poles).unwrap()
        })
        .collect()
}

/// All passes that are asked for, and the merged partial of the last; poles go through
/// their file.
fn in_pieces(blocks: &[(u64, FrfSet)]) -> (ModalModel, Partial) {
    let (model, merged, _) = in_passes(blocks);
    (model, merged)
}

/// The same with the number of passes.
fn in_passes(blocks: &[(u64, FrfSet)]) -> (ModalModel, Partial, usize) {
    let mut poles: Option<Poles> = None;
    for passes in 1..8 {
        let merged = Partial::merge(reduced(blocks, poles.as_ref())).unwrap();
        match solve(&merged, &FitOptions::default(), &|_| {}).unwrap() {
            Solved::Poles(found) => {
                let read = Poles::from_bytes(&found.to_bytes()).unwrap();
                assert_eq!(read, *found);
                poles = Some(read);
            }
            Solved::Fit(fit) => return (fit.model, merged, passes),
        }
    }
    panic!("no end")
}

/// Every mode of the band within so many standard deviations of the other model's, with
/// error bars within a part of its own, and sure where that one is.
fn agree(model: &ModalModel, memory: &ModalModel, deviations: f64, part: f64) {
    assert_eq!(
        model.in_band_modes().count(),
        memory.in_band_modes().count()
    );
    for (mode, other) in model.in_band_modes().zip(memory.in_band_modes()) {
        let off = (mode.frequency_hz - other.frequency_hz).abs() / other.frequency_std_hz;
        let eta = (mode.loss_factor - other.loss_factor).abs() / other.loss_factor_std;
        let bar = (mode.frequency_std_hz / other.frequency_std_hz - 1.0).abs();
        let at = other.frequency_hz;
        assert!(
            off < deviations && eta < deviations && bar < part,
            "{at} Hz: {off:.3}, {eta:.3} deviations, bar {bar:.3}"
        );
        assert_eq!(mode.trust, other.trust, "{at} Hz");
    }
}

/// The set with noise 45 dB below the data, times a factor of each response and reference.
fn unequal() -> FrfSet {
    let mut set = easy(f64::INFINITY, 3);
    (set.responses, set.references) = (64, 3);
    let mut frf = set.build().unwrap().frf;
    let FrfValues::F64(values) = &mut frf.values else {
        panic!("synthetic sets are in double precision")
    };
    let variance =
        10f64.powf(-4.5) * values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64;
    let mut noise = Array3::zeros(values.dim());
    add_noise_of_variance(&mut noise, variance, 103);
    for (((i, j, _), value), noise) in values.indexed_iter_mut().zip(&noise) {
        *value += noise * level(i, j);
    }
    frf
}

fn level(i: usize, j: usize) -> f64 {
    [1.0, 4.0, 1.0, 6.0, 5.0, 2.0][i % 6] * [2.0, 1.0, 3.0][j % 3]
}

#[test]
fn frfs_of_unequal_noise_are_weighted_as_in_memory() {
    let frf = unequal();
    let (model, _, passes) = in_passes(&blocks(&frf, 5));
    let memory = fitted(&frf, &FitOptions::default());
    agree(&model, &memory, 0.1, 0.02);
    let weights = |model: &ModalModel| {
        let path = model.quality.path.clone().unwrap();
        path.split_once("FRFs weighted").unwrap().1.to_owned()
    };
    assert!(weights(&model).starts_with(" by their noise") && !weights(&memory).is_empty());
    assert!(
        passes <= 4,
        "{passes}: sketch, products, and both once more with weights"
    );
    // as the data themselves tell it: from the start
    let mut given = frf;
    given.variance = Some(Array3::from_shape_fn(given.values.dim(), |(i, j, _)| {
        (1e-3 * level(i, j)).powi(2)
    }));
    let cut = |count: usize| -> Vec<(u64, FrfSet)> {
        let variance = given.variance.as_ref().unwrap();
        let of = |b: usize| b * 64 / count;
        let with = |(b, block): (u64, FrfSet)| {
            let rows = of(b as usize)..of(b as usize + 1);
            let variance = Some(variance.slice(s![rows, .., ..]).to_owned());
            (b, FrfSet { variance, ..block })
        };
        blocks(&given, count).into_iter().map(with).collect()
    };
    let (model, _, passes) = in_passes(&cut(5));
    let memory = fitted(&given, &FitOptions::default());
    agree(&model, &memory, 0.1, 0.02);
    assert_eq!(weights(&model), weights(&memory));
    assert!(weights(&model).ends_with("as the variances of the set say"));
    assert!(passes <= 4, "{passes}");
}

#[test]
fn outlier_lines_of_measured_data_are_left_out_as_in_memory() {
    let mut noisy = set();
    gain_noise(&mut noisy.frf, 0.05, true, 4);
    outliers(&mut noisy.frf, 1e-4, 30.0, 3);
    let (model, _) = in_pieces(&blocks(&noisy.frf, 5));
    let memory = fitted(&noisy.frf, &FitOptions::default());
    let lines = |model: &ModalModel| -> Vec<f64> {
        let found = model.quality.findings.iter();
        let found = found.filter(|finding| finding.code == "outlier-lines");
        found
            .flat_map(|finding| finding.values["lines_hz"].as_slice().to_vec())
            .collect()
    };
    let (own, whole) = (lines(&model), lines(&memory));
    assert!(!whole.is_empty());
    let shared = own.iter().filter(|hz| whole.contains(hz)).count();
    assert!(
        10 * shared >= 8 * whole.len() && 10 * shared >= 8 * own.len(),
        "{own:?} against {whole:?}"
    );
    let sure = |model: &ModalModel| {
        let modes = model.in_band_modes();
        modes.filter(|mode| mode.trust == Trust::Sure).count()
    };
    assert_eq!((sure(&model), sure(&memory)), (8, 8));
}

/// Largest relative difference of natural frequencies and loss factors.
fn difference(a: &ModalModel, b: &ModalModel) -> f64 {
    assert_eq!(a.in_band_modes().count(), b.in_band_modes().count());
    let of = |(a, b): (&chladni_frf::Mode, &chladni_frf::Mode)| {
        let frequency = (a.frequency_hz / b.frequency_hz - 1.0).abs();
        frequency.max((a.loss_factor / b.loss_factor - 1.0).abs())
    };
    a.in_band_modes()
        .zip(b.in_band_modes())
        .map(of)
        .fold(0.0, f64::max)
}

#[test]
fn blocks_find_what_the_whole_finds() {
    let set = set();
    let whole = in_pieces(&blocks(&set.frf, 1)).0;
    for count in [7, 64] {
        let model = in_pieces(&blocks(&set.frf, count)).0;
        let difference = difference(&model, &whole);
        assert!(difference < 1e-12, "{count} blocks: {difference:e}");
        let shapes = model
            .modes
            .iter()
            .zip(&whole.modes)
            .flat_map(|(a, b)| a.shape.0.iter().zip(&b.shape.0));
        let (error, size) = shapes.fold((0.0_f64, 0.0_f64), |(e, m), (a, b)| {
            (e.max((a - b).norm()), m.max(b.norm()))
        });
        assert!(
            error < 1e-10 * size,
            "{count} blocks: shapes {:e}",
            error / size
        );
    }
    // and what a fit of the set in memory finds, far within its error bars
    let memory = fitted(&set.frf, &FitOptions::default());
    for (mode, other) in whole.in_band_modes().zip(memory.in_band_modes()) {
        assert!((mode.frequency_hz - other.frequency_hz).abs() < 0.05 * other.frequency_std_hz);
        assert!((mode.frequency_std_hz / other.frequency_std_hz - 1.0).abs() < 0.01);
        assert_eq!(mode.trust, Trust::Sure);
    }
    assert!((whole.quality.relative_error / memory.quality.relative_error - 1.0).abs() < 1e-3);
    assert!(
        (resynthesis_error(&whole, &set.frf) / whole.quality.relative_error - 1.0).abs() < 1e-6
    );
}

/// The result of one pass over the blocks with the poles that a pilot of some responses
/// shows.
fn piloted(blocks: &[(u64, FrfSet)], pilot: &FrfSet) -> Solved {
    let options = FitOptions::default();
    let partial = reduce(pilot, &options, 0, Vec::new(), None).unwrap();
    let Solved::Poles(pilot) = solve(&partial, &options, &|_| {}).unwrap() else {
        panic!("poles")
    };
    let reducer = Reducer::with_pilot(&options, &pilot).unwrap();
    let merged = Partial::merge(
        blocks
            .iter()
            .map(|(number, frf)| reducer.block(frf, *number, Vec::new()).unwrap()),
    )
    .unwrap();
    assert!(merged.poles().is_none());
    assert_eq!(merged.pilot().unwrap().modes(), pilot.modes());
    solve(&merged, &options, &|_| {}).unwrap()
}

#[test]
fn one_pass_is_enough_where_a_pilot_showed_the_same_poles() {
    let set = set();
    let mut blocks = blocks(&set.frf, 7);
    let Solved::Fit(fit) = piloted(&blocks, &rows(&set.frf, 20..36)) else {
        panic!("a fit")
    };
    let memory = fitted(&set.frf, &FitOptions::default());
    for (mode, other) in fit.model.in_band_modes().zip(memory.in_band_modes()) {
        assert!((mode.frequency_hz - other.frequency_hz).abs() < 0.05 * other.frequency_std_hz);
        assert!((mode.loss_factor - other.loss_factor).abs() < 0.05 * other.loss_factor_std);
        assert!((mode.frequency_std_hz / other.frequency_std_hz - 1.0).abs() < 0.01);
    }
    assert!(
        (resynthesis_error(&fit.model, &set.frf) / memory.quality.relative_error - 1.0).abs()
            < 1e-3
    );
    // a pilot that saw less, and values missing where products are made: poles for a
    // second pass, those that no pilot would change
    let Solved::Poles(unled) = solve(
        &Partial::merge(reduced(&blocks, None)).unwrap(),
        &FitOptions::default(),
        &|_| {},
    )
    .unwrap() else {
        panic!("poles")
    };
    let Solved::Poles(found) = piloted(&blocks, &rows(&easy(-20.0, 5).build().unwrap().frf, 0..1))
    else {
        panic!("other poles")
    };
    assert_eq!(found, unled);
    let FrfValues::F64(values) = &mut blocks[4].1.values else {
        panic!("double precision")
    };
    values[[1, 1, 300]].re = f64::NAN;
    assert!(matches!(
        piloted(&blocks, &rows(&set.frf, 20..36)),
        Solved::Poles(_)
    ));
}

#[test]
fn order_and_grouping_of_blocks_do_not_change_a_bit() {
    let set = set();
    let (model, merged) = in_pieces(&blocks(&set.frf, 13));
    let poles = merged.poles().unwrap();
    let parts = reduced(&blocks(&set.frf, 13), Some(poles));
    let shuffled: Vec<Partial> = [8, 3, 12, 0, 5, 1, 11, 7, 2, 10, 6, 9, 4]
        .map(|b: usize| parts[b].clone())
        .to_vec();
    let mut grouped = Vec::new();
    for group in shuffled.chunks(4) {
        grouped.push(Partial::merge(group.to_vec()).unwrap());
    }
    let others = Partial::merge(grouped).unwrap();
    assert!(others.to_bytes() == merged.to_bytes());
    let Solved::Fit(fit) = solve(&others, &FitOptions::default(), &|_| {}).unwrap() else {
        panic!("a fit")
    };
    assert!(serde_json::to_string(&fit.model).unwrap() == serde_json::to_string(&model).unwrap());
    // and through files
    let read = Partial::from_bytes(&merged.to_bytes()).unwrap();
    assert!(read == merged);
}

#[test]
fn blocks_of_one_reference_each_make_the_same_set() {
    let set = set();
    let FrfValues::F64(values) = &set.frf.values else {
        panic!("double precision")
    };
    let of_reference = |j: usize| FrfSet {
        values: FrfValues::F64(values.slice(s![.., j..j + 1, ..]).to_owned()),
        references: vec![set.frf.references[j]],
        ..set.frf.clone()
    };
    let blocks_of_references: Vec<(u64, FrfSet)> =
        (0..3).map(|j| (j as u64, of_reference(j))).collect();
    let model = in_pieces(&blocks_of_references).0;
    assert_eq!(model.references, set.frf.references);
    assert!(difference(&model, &in_pieces(&blocks(&set.frf, 1)).0) < 1e-12);
    assert!(
        (resynthesis_error(&model, &set.frf) / model.quality.relative_error - 1.0).abs() < 1e-6
    );
}

#[test]
fn residues_of_a_block_are_those_of_the_whole() {
    let set = set();
    let whole = fitted(&set.frf, &FitOptions::default());
    for part in [0..4, 20..64] {
        let block = rows(&set.frf, part.clone());
        let model = residues(&block, &whole, &FitOptions::default()).unwrap();
        assert!(difference(&model, &whole) < 1e-14, "poles are given");
        for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
            for (i, shape) in part.clone().zip(&mode.shape.0) {
                for j in 0..3 {
                    let (residue, expected) = (
                        shape * mode.participation.0[j],
                        truth.shape.0[i] * truth.participation.0[j],
                    );
                    let strongest = truth.shape.0.iter().map(|v| v.norm()).fold(0.0, f64::max)
                        * truth.participation.0[j].norm();
                    assert!(
                        (residue - expected).norm() < 0.02 * strongest,
                        "{residue} {expected}"
                    );
                }
            }
        }
        assert!(
            (resynthesis_error(&model, &block) / model.quality.relative_error - 1.0).abs() < 0.01
        );
    }
}

#[test]
fn missing_lines_and_frfs_are_left_out_as_in_memory() {
    let mut set = set();
    let FrfValues::F64(values) = &mut set.frf.values else {
        panic!("double precision")
    };
    let nothing = Complex64::new(f64::NAN, f64::NAN);
    values.slice_mut(s![40, 1, ..]).fill(nothing);
    values
        .slice_mut(s![.., .., 700..703])
        .fill(Complex64::default());
    values[[3, 0, 100]] = nothing;
    let model = in_pieces(&blocks(&set.frf, 5)).0;
    let memory = fitted(&set.frf, &FitOptions::default());
    assert!(difference(&model, &memory) < 1e-6);
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.text.starts_with("4 lines hold no finite value")),
        "{:?}",
        model.quality.findings
    );
}

#[test]
fn outlier_lines_gain_noise_and_the_wrong_time_sign_take_their_paths() {
    let mut spoilt = set();
    outliers(&mut spoilt.frf, 1e-4, 30.0, 3);
    let (model, _) = in_pieces(&blocks(&spoilt.frf, 5));
    assert_eq!(
        model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Sure)
            .count(),
        8
    );
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.contains("outlier lines")),
        "{:?}",
        model.quality.findings
    );

    let mut noisy = set();
    gain_noise(&mut noisy.frf, 0.05, true, 4);
    let (model, _) = in_pieces(&blocks(&noisy.frf, 5));
    assert!(
        model
            .quality
            .path
            .as_deref()
            .unwrap()
            .starts_with("measured-data path"),
        "{:?}",
        model.quality.path
    );
    assert_eq!(
        model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Sure)
            .count(),
        8
    );

    let mut turned = set();
    turned.frf.conjugate();
    let (model, _) = in_pieces(&blocks(&turned.frf, 5));
    assert!(
        !model.quality.trusted
            && model
                .quality
                .findings
                .iter()
                .any(|w| w.contains("the other time sign")),
        "{:?}",
        model.quality.findings
    );
}

#[test]
fn noise_alone_gives_no_mode() {
    let mut set = set();
    let FrfValues::F64(values) = &mut set.frf.values else {
        panic!("double precision")
    };
    *values = Array3::zeros(values.dim());
    add_noise_of_variance(values, 1e-6, 9);
    let (model, _) = in_pieces(&blocks(&set.frf, 3));
    assert_eq!(model.in_band_modes().count(), 0);
    assert!(!model.quality.trusted);
}

#[test]
fn pieces_that_do_not_belong_together_are_refused_by_name() {
    let set = set();
    let parts = reduced(&blocks(&set.frf, 2), None);
    let error = |partials: Vec<Partial>| Partial::merge(partials).unwrap_err().to_string();
    assert!(error(Vec::new()).contains("nothing to merge"));
    let twice = error(vec![parts[0].clone(), parts[0].clone()]);
    assert!(twice.contains("block stands twice"), "{twice}");

    let block = rows(&set.frf, 0..10);
    let with = |options: FitOptions| reduce(&block, &options, 7, Vec::new(), None).unwrap();
    let effort = Effort {
        sketch_columns: 20,
        ..Effort::default()
    };
    for (options, field) in [
        (
            FitOptions {
                seed: 1,
                ..FitOptions::default()
            },
            "seed",
        ),
        (
            FitOptions {
                band_hz: Some([30.0, 200.0]),
                ..FitOptions::default()
            },
            "band",
        ),
        (
            FitOptions {
                effort,
                ..FitOptions::default()
            },
            "columns of the sketch",
        ),
    ] {
        let message = error(vec![parts[1].clone(), with(options)]);
        assert!(
            message.contains(field) && message.contains("block 7"),
            "{message}"
        );
    }
    let mut shifted = block.clone();
    shifted.frequency_hz.mapv_inplace(|f| f + 1.0);
    let shifted = reduce(&shifted, &FitOptions::default(), 7, Vec::new(), None).unwrap();
    assert!(error(vec![parts[1].clone(), shifted]).contains("frequency axis"));

    // the same FRFs under another number
    let again = reduce(&block, &FitOptions::default(), 7, Vec::new(), None).unwrap();
    let merged = Partial::merge([parts[0].clone(), again]).unwrap();
    let message = solve(&merged, &FitOptions::default(), &|_| {})
        .unwrap_err()
        .to_string();
    assert!(message.contains("an FRF stands in two blocks"), "{message}");

    // a second pass over half of the data, and one with other poles
    let Solved::Poles(poles) = solve(
        &Partial::merge(parts.clone()).unwrap(),
        &FitOptions::default(),
        &|_| {},
    )
    .unwrap() else {
        panic!("poles")
    };
    let half = reduced(&blocks(&set.frf, 2)[..1], Some(&poles));
    let message = solve(&half[0], &FitOptions::default(), &|_| {})
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("not run over the FRFs of the first"),
        "{message}"
    );
    let message = error(vec![half[0].clone(), parts[1].clone()]);
    assert!(message.contains("other poles"), "{message}");
}

#[test]
fn files_of_another_version_or_damaged_are_refused_by_name() {
    let part = reduced(&blocks(&set().frf, 2), None).remove(0);
    let bytes = part.to_bytes();
    let error = |bytes: &[u8]| Partial::from_bytes(bytes).unwrap_err().to_string();
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap();
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let with_head = |head: String| [head.as_bytes(), &bytes[end..]].concat();
    let other = error(&with_head(head.replace("\"version\":5", "\"version\":1")));
    assert!(
        other.contains("another version") && other.contains("1 (written by chladni"),
        "{other}"
    );
    assert!(error(&with_head(head.replace("partial", "poles"))).contains("chladni.poles"));
    assert!(error(&bytes[..bytes.len() - 1]).contains("cut off"));
    let mut damaged = bytes.clone();
    *damaged.last_mut().unwrap() ^= 1;
    assert!(error(&damaged).contains("damaged"));
    assert!(error(b"PK\x03\x04").contains("first line"));
    assert!(error(b"").contains("first line"));
}

#[test]
fn single_precision_and_both_axes_of_the_set_hold() {
    let set = set();
    let FrfValues::F64(values) = &set.frf.values else {
        panic!("double precision")
    };
    let single = FrfSet {
        values: FrfValues::F32(
            values.mapv(|v| num_complex::Complex32::new(v.re as f32, v.im as f32)),
        ),
        ..set.frf.clone()
    };
    let model = in_pieces(&[(3, single)]).0;
    let double = in_pieces(&blocks(&set.frf, 1)).0;
    assert!(difference(&model, &double) < 1e-7);
    assert_eq!(values.len_of(Axis(0)), model.responses.len());
}
