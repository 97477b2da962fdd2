//! The damping law by fewest poles, and data that are a delay alone: as in memory.

use super::blocks::{agree, blocks, in_passes};
use crate::common::fitted;
use crate::law::{complex_shapes, OnOneDashpot};
use crate::noise_only::delayed;
use chladni_frf::{Damping, ModalModel};
use chladni_rfp::FitOptions;

/// Codes of the findings on the law.
fn on_law(model: &ModalModel) -> Vec<&str> {
    let findings = model.quality.findings.iter();
    let codes = findings.map(|finding| finding.code.as_ref());
    codes.filter(|code| code.starts_with("law-")).collect()
}

#[test]
fn fewest_poles_tell_the_law_of_blocks_as_in_memory() {
    let frf = complex_shapes(110.0, 1);
    let (model, _, passes) = in_passes(&blocks(&frf, 4));
    let memory = fitted(&frf, &FitOptions::default());
    assert_eq!(model.damping, Damping::Structural);
    assert_eq!(memory.damping, Damping::Structural);
    assert!(on_law(&model).is_empty(), "{:?}", model.quality.findings);
    assert!(on_law(&memory).is_empty(), "{:?}", memory.quality.findings);
    agree(&model, &memory, 0.1, 0.02);
    assert!(passes <= 2, "{passes}");
}

/// The lead of the viscous law is near the least that tells: it may be told of blocks where it is open
/// in memory, and the other way round. The wrong law is never told.
#[test]
fn blocks_of_masses_with_one_dashpot_are_told_no_wrong_law() {
    let masses = OnOneDashpot { dashpot: 100.0 };
    let mut told = Vec::new();
    for seed in 1..=8 {
        let (model, _, _) = in_passes(&blocks(&masses.set(80.0, seed), 2));
        if on_law(&model).is_empty() {
            told.push(model.damping);
        }
    }
    assert!(told.contains(&Damping::Viscous), "{told:?}");
    assert!(!told.contains(&Damping::Structural), "{told:?}");
}

#[test]
fn a_delay_alone_is_told_of_blocks_as_in_memory() {
    for (seed, cycles) in [1.5, -4.0, 40.0].into_iter().enumerate() {
        let frf = delayed(cycles, seed as u64);
        let (model, _, passes) = in_passes(&blocks(&frf, 3));
        let memory = fitted(&frf, &FitOptions::default());
        let told_ms = |model: &ModalModel| {
            let mut findings = model.quality.findings.iter();
            let told = findings.find(|told| told.code == "delay-alone");
            told.map(|told| told.values["delay_ms"].as_slice()[0])
        };
        let [own, whole] = [&model, &memory].map(|model| told_ms(model).expect("the finding"));
        assert!((own - whole).abs() < 0.02, "{own} instead of {whole} ms");
        assert_eq!(model.in_band_modes().count(), 0, "{cycles} cycles");
        assert!(!model.quality.trusted);
        assert_eq!(model.quality.path, memory.quality.path);
        let (own, whole) = (model.quality.relative_error, memory.quality.relative_error);
        assert!((own / whole - 1.0).abs() < 1e-6, "{own} instead of {whole}");
        assert!(passes <= 2, "{passes}");
    }
}
