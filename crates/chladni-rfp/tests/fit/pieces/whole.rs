//! Pieces of clean data find what the whole finds, however they are cut.

use super::blocks::{blocks, difference, in_pieces, reduced, rows, set};
use crate::common::{easy, fitted, resynthesis_error};
use chladni_frf::{FrfSet, FrfValues, Trust};
use chladni_rfp::pieces::{
    reduce, residues, solve, solve_watched, Partial, PieceError, Reducer, Solved,
};
use chladni_rfp::{CancelToken, FitError, FitOptions};
use ndarray::{s, Axis};
use std::sync::atomic::{AtomicUsize, Ordering};

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
    let Solved::Poles(pilot) = solve(partial, &options, &|_| {}).unwrap() else {
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
    solve(merged, &options, &|_| {}).unwrap()
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
        Partial::merge(reduced(&blocks, None)).unwrap(),
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
    let Solved::Fit(fit) = solve(others, &FitOptions::default(), &|_| {}).unwrap() else {
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

#[test]
fn solving_stops_at_the_stage_at_which_it_is_asked_to() {
    let set = set();
    let merged = Partial::merge(reduced(&blocks(&set.frf, 2), None)).unwrap();
    let (cancel, stages) = (CancelToken::new(), AtomicUsize::new(0));
    let tell = |_: &str| {
        if stages.fetch_add(1, Ordering::Relaxed) == 1 {
            cancel.cancel();
        }
    };
    let stopped = solve_watched(merged, &FitOptions::default(), &tell, &cancel);
    assert!(
        matches!(stopped, Err(PieceError::Fit(FitError::Cancelled))),
        "{stopped:?}"
    );
    assert_eq!(stages.into_inner(), 2);
}
