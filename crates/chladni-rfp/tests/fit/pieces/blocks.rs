//! A set cut into blocks, what its pieces come to, and how far two models are apart.

use crate::common::easy;
use chladni_frf::{FrfSet, FrfValues, ModalModel};
use chladni_plate::SyntheticSet;
use chladni_rfp::pieces::{reduce, solve, Partial, Poles, Solved};
use chladni_rfp::FitOptions;
use ndarray::s;
use std::ops::Range;

/// The easy set at 64 responses and 3 references.
pub(super) fn set() -> SyntheticSet {
    let mut set = easy(45.0, 5);
    (set.responses, set.references) = (64, 3);
    set.build().unwrap()
}

/// The FRFs of some responses.
pub(super) fn rows(frf: &FrfSet, rows: Range<usize>) -> FrfSet {
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
pub(super) fn blocks(frf: &FrfSet, count: usize) -> Vec<(u64, FrfSet)> {
    let of = |b: usize| b * frf.responses.len() / count;
    (0..count)
        .map(|b| (b as u64, rows(frf, of(b)..of(b + 1))))
        .collect()
}

pub(super) fn reduced(blocks: &[(u64, FrfSet)], poles: Option<&Poles>) -> Vec<Partial> {
    blocks
        .iter()
        .map(|(number, frf)| {
            reduce(frf, &FitOptions::default(), *number, Vec::new(), poles).unwrap()
        })
        .collect()
}

/// All passes that are asked for, and the merged partial of the last; poles go through
/// their file.
pub(super) fn in_pieces(blocks: &[(u64, FrfSet)]) -> (ModalModel, Partial) {
    let (model, merged, _) = in_passes(blocks);
    (model, merged)
}

/// The same with the number of passes.
pub(super) fn in_passes(blocks: &[(u64, FrfSet)]) -> (ModalModel, Partial, usize) {
    let mut poles: Option<Poles> = None;
    for passes in 1..8 {
        let merged = Partial::merge(reduced(blocks, poles.as_ref())).unwrap();
        match solve(merged.clone(), &FitOptions::default(), &|_| {}).unwrap() {
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
pub(super) fn agree(model: &ModalModel, memory: &ModalModel, deviations: f64, part: f64) {
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

/// Largest relative difference of natural frequencies and loss factors.
pub(super) fn difference(a: &ModalModel, b: &ModalModel) -> f64 {
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
