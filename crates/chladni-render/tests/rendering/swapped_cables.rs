//! Two cables that are swapped: the correction, and what it keeps of the rig.

use crate::common::rig::Rig;
use crate::common::{cell_scene, truth};
use crate::correction::{corner, first_drive, rendered, served, served_in, with};
use chladni_frf::{Finding, MeasuredField};
use chladni_render::{calibrate, evaluate_field, Calibration, PlayedField, RenderOptions, Weights};

/// Rigs of each kind.
const RIGS: u64 = 6;

fn whole(rig: &mut Rig, weights: &Weights) -> MeasuredField {
    rig.measured(weights, 0.01, &(0..77).collect::<Vec<_>>())
}

/// Two channels of the ten that the first drive drives most.
fn pair(seed: u64) -> [usize; 2] {
    let weights = first_drive().weights;
    let mut order: Vec<usize> = (0..34).collect();
    order.sort_by(|&a, &b| weights[b].amplitude.total_cmp(&weights[a].amplitude));
    [order[seed as usize], order[seed as usize + 4]]
}

fn scattered(seed: u64) -> Rig {
    Rig::new(300.0, seed).scattered(0.01, 1.0)
}

fn swapped(mut rig: Rig, [one, other]: [usize; 2]) -> Rig {
    let plain = rig.mobility.clone();
    rig.mobility.column_mut(one).assign(&plain.column(other));
    rig.mobility.column_mut(other).assign(&plain.column(one));
    rig
}

fn corrected(played: &[PlayedField]) -> (Weights, Calibration) {
    calibrate(truth(), &corner(), played, &RenderOptions::default()).unwrap()
}

fn of_swap<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> Option<&'a Finding> {
    (findings.into_iter()).find(|finding| finding.code == "channels-swapped")
}

#[test]
fn weights_behind_swapped_cables_serve_the_rig_as_it_is() {
    let weights = first_drive();
    let (mut named, mut as_it_is, mut mended, mut plain) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..RIGS {
        let pair = pair(seed);
        let mut rig = swapped(scattered(seed), pair);
        let first = PlayedField::new(weights.clone(), whole(&mut rig, &weights));
        let (after, calibration) = corrected(std::slice::from_ref(&first));
        // nine of ten are named
        let Some(finding) = of_swap(after.findings.iter()) else {
            eprintln!("{seed}: {pair:?} not named");
            continue;
        };
        named += 1.0;
        assert!(pair
            .iter()
            .all(|&k| finding.dofs.contains(&truth().references[k])));
        as_it_is += served(&rig, &after);
        // no gain is kept of either
        for &k in &pair {
            let gain = &calibration.gains[k];
            assert!(!gain.odd && (gain.re, gain.im) == (1.0, 0.0), "{gain:?}");
        }
        assert!(calibration.dead.is_empty());
        // the next scene, once both cables are in their places
        let next = cell_scene([2, 2], 4, "");
        let sound = scattered(seed);
        mended += served_in(&next, &sound, &rendered(&with(&calibration, &next)));
        plain += served_in(&next, &sound, &rendered(&next));
        // the second field of the same rig, and of the mended one
        for (mut rig, is_swapped) in [(rig, true), (scattered(seed), false)] {
            let second = PlayedField::new(after.clone(), whole(&mut rig, &after));
            let (last, _) = corrected(&[first.clone(), second]);
            let ratio = served(&rig, &last);
            assert!(ratio >= 0.9, "{seed}, swapped {is_swapped}: {ratio}");
        }
    }
    for mean in [&mut as_it_is, &mut mended, &mut plain] {
        *mean /= named;
    }
    eprintln!("as it is {as_it_is:.3}, next scene mended {mended:.3}, without {plain:.3}");
    assert!(named >= RIGS as f64 - 1.0, "{named}");
    // as two odd gains 0.3
    assert!(as_it_is >= 0.85, "{as_it_is}");
    assert!(mended >= plain - 0.02, "{mended} {plain}");
}

#[test]
fn faults_of_several_channels_are_not_called_a_swap() {
    let weights = first_drive();
    for seed in 0..2 * RIGS {
        let [one, other] = pair(seed);
        let third = (one + other) % 34;
        let rig = |seed| Rig::new(300.0, seed);
        let known = |one_gain: f64, other_gain: f64| {
            scattered(seed)
                .channel(one, one_gain)
                .channel(other, other_gain)
        };
        for (name, mut rig) in [
            ("two reversed", known(-1.0, -1.0)),
            ("reversed and dead", known(-1.0, 0.0)),
            ("three dead", known(0.0, 0.0).channel(third, 0.0)),
            ("half and more", known(0.5, 1.5)),
            ("a tenth", rig(seed).scattered(0.07, 4.0)),
            ("a fifth", rig(seed).scattered(0.14, 8.0)),
        ] {
            let field = whole(&mut rig, &weights);
            let told = evaluate_field(&weights, &corner(), truth(), &field, None).unwrap();
            assert!(of_swap(&told.findings).is_none(), "{seed}: {name}");
        }
    }
}
