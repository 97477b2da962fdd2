//! The wrong FRF kind: data of one kind that are declared as another.

use super::*;
use chladni_frf::{Dof, FrfKind};

const KINDS: [FrfKind; 3] = [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance];

/// The set as `is`, declared as `declared`; without driving points where the references
/// get nodes of their own.
fn declared_as(is: FrfKind, declared: FrfKind, with_driving_point: bool, seed: u64) -> FrfSet {
    let set = Synthetic {
        kind: is,
        ..easy(40.0, seed)
    }
    .build()
    .unwrap();
    let mut frf = FrfSet {
        kind: Some(declared),
        ..set.frf
    };
    if !with_driving_point {
        frf.references = frf
            .references
            .iter()
            .map(|dof| Dof::new(dof.node + 100, dof.direction))
            .collect();
    }
    frf
}

#[test]
fn at_driving_points_every_wrong_kind_is_named() {
    for is in KINDS {
        for declared in KINDS {
            let model = fitted(&declared_as(is, declared, true, 31));
            let named = says(&model, "wrong FRF kind");
            assert_eq!(
                named,
                is != declared,
                "{is} as {declared}: {:?}",
                model.quality.findings
            );
            assert_eq!(model.quality.trusted, is == declared, "{is} as {declared}");
            if is != declared {
                assert!(
                    says(&model, &format!("read them as {is}")),
                    "{is} as {declared}: {:?}",
                    model.quality.findings
                );
            }
        }
    }
}

#[test]
fn without_driving_points_one_derivative_is_named() {
    for is in KINDS {
        for declared in KINDS {
            let model = fitted(&declared_as(is, declared, false, 32));
            let quarter = (is.omega_power() - declared.omega_power()).abs() == 1;
            assert_eq!(
                says(&model, "wrong FRF kind"),
                quarter,
                "{is} as {declared}: {:?}",
                model.quality.findings
            );
            assert_eq!(model.quality.trusted, !quarter, "{is} as {declared}");
        }
    }
}

#[test]
fn a_reversed_direction_is_not_taken_for_another_kind() {
    for kind in KINDS {
        let mut set = Synthetic {
            kind,
            ..easy(40.0, 33)
        }
        .build()
        .unwrap();
        spoil(&mut set.frf, |_, _, _, v| -v);
        let model = fitted(&set.frf);
        assert!(
            says(&model, "points the other way") && !says(&model, "kind?"),
            "{kind}: {:?}",
            model.quality.findings
        );
        assert!(model.quality.trusted);
    }
}
