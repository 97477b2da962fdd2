//! FRF kind, unit of the reference and factors to SI, from the codes, exponents and unit
//! labels of a 58.
//!
//! Quantity codes tell the quantity, and dataset 164 its units. A label counts where the codes
//! tell nothing, as they never do for volts. Where label and 164 contradict each other, 164 is
//! used and a warning names both.

use super::header::Units;
use crate::unit_label::{self, Unit, STANDARD_GRAVITY};
use crate::Axis;
use chladni_frf::{Direction, Error, Finding, FrfKind, ReferenceUnit, Result};

pub(super) const DISPLACEMENT: i32 = 8;
pub(super) const VELOCITY: i32 = 11;
pub(super) const ACCELERATION: i32 = 12;
pub(super) const EXCITATION_FORCE: i32 = 13;
pub(super) const TIME: i32 = 17;
pub(super) const FREQUENCY: i32 = 18;
const RPM: i32 = 19;
const ORDER: i32 = 20;

/// Function type code of FRFs.
pub(super) const FRF: i32 = 4;
/// Function type code of coherence.
pub(super) const COHERENCE: i32 = 6;

/// The meaning of codes and labels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scaling {
    pub kind: Option<FrfKind>,
    pub reference_unit: ReferenceUnit,
    /// Multiplies ordinate values of the file to give SI.
    pub scale_to_si: f64,
    /// Multiplies abscissa values of the file to give Hz or s.
    pub abscissa_to_si: f64,
}

/// Relative difference up to which two unit factors, printed with few digits, are equal.
const FACTOR_TOLERANCE: f64 = 1e-3;

fn differ(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() > FACTOR_TOLERANCE
}

/// Reads codes and labels of a function. `units` is `None` in a file without dataset 164.
///
/// * `axes`: abscissa, ordinate numerator, ordinate denominator, z axis
/// * `directions`: of response and reference
pub(super) fn scaling(
    function_type: i32,
    axes: &[Axis; 4],
    directions: [Direction; 2],
    units: Option<Units>,
    warnings: &mut Vec<Finding>,
) -> Scaling {
    let mut scaling = Scaling {
        kind: None,
        reference_unit: ReferenceUnit::Newton,
        scale_to_si: 1.0,
        abscissa_to_si: 1.0,
    };
    match function_type {
        FRF => frf(axes, directions, units, &mut scaling, warnings),
        // products of two signals: vendors disagree on their units
        2 | 3 | 7..=10 => {
            if units.is_some_and(|units| !units.is_si()) {
                warnings.push(Finding::note(
                    "unit-kept",
                    "units of power quantities are not turned into SI: values are kept \
                               as in the file",
                ));
            }
        }
        // coherences, mode indicators and phases have no unit
        COHERENCE | 18 | 26 | 28 => {}
        _ => {
            let numerator = side(&axes[1], directions[0], units, warnings);
            let denominator = side(&axes[2], directions[1], units, warnings);
            scaling.scale_to_si = numerator / denominator;
        }
    }
    if !(scaling.scale_to_si.is_normal() && scaling.scale_to_si > 0.0) {
        warnings.push(Finding::caution(
            "unit-assumed",
            "the unit factor is out of range: values are kept as in the file",
        ));
        scaling.scale_to_si = 1.0;
    }
    scaling.abscissa_to_si = abscissa(&axes[0], function_type, warnings);
    scaling
}

/// Exponents of length and force of a quantity code; `None` where only a label tells.
pub(super) fn exponents(axis: &Axis, direction: Direction) -> Option<[i32; 2]> {
    /// Largest plausible exponent.
    const LARGEST: i32 = 9;
    let given = [axis.exponents[0], axis.exponents[1]];
    if (axis.quantity == 1 || direction == Direction::SCALAR) && given != [0, 0] {
        return Some(given).filter(|given| given.iter().all(|e| e.abs() <= LARGEST));
    }
    let rotation = direction.axis().code() >= 4;
    match axis.quantity {
        DISPLACEMENT | VELOCITY | ACCELERATION => Some(if rotation { [0, 0] } else { [1, 0] }),
        9 | EXCITATION_FORCE => Some(if rotation { [1, 1] } else { [0, 1] }),
        2 | 15 => Some([-2, 1]),
        16 => Some([-1, 1]),
        3 | 5 | 17..=20 => Some([0, 0]),
        _ => None,
    }
}

/// Factor to SI of one side of a function that is no FRF.
fn side(
    axis: &Axis,
    direction: Direction,
    units: Option<Units>,
    warnings: &mut Vec<Finding>,
) -> f64 {
    let label = unit_label::parse(&axis.unit);
    let Some(exponents) = exponents(axis, direction) else {
        return label.map_or(1.0, |unit| unit.factor);
    };
    match (units, label) {
        (Some(units), Some(unit)) => {
            let factor = 1.0 / units.factor(exponents);
            // N = kg·m/s²: the power of kg is that of the force
            let measures_this = unit.powers[..2] == [exponents[0] + exponents[1], exponents[1]];
            if exponents != [0, 0] && (!measures_this || differ(factor, unit.factor)) {
                warnings.push(Finding::caution(
                    "unit-contradicted",
                    contradiction(&axis.unit, factor, unit.factor),
                ));
            }
            factor
        }
        (Some(units), None) => 1.0 / units.factor(exponents),
        (None, Some(unit)) => unit.factor,
        (None, None) => {
            if exponents != [0, 0] {
                warnings.push(Finding::caution(
                    "unit-assumed",
                    "neither a units dataset (164) nor a label states the unit: SI is assumed",
                ));
            }
            1.0
        }
    }
}

fn contradiction(label: &str, used: f64, by_label: f64) -> String {
    format!(
        "the unit label `{label}` (factor {by_label} to SI) contradicts the units dataset 164 and quantity codes (factor {used}); \
         {used} is used: check the values"
    )
}

fn motion(quantity: i32) -> Option<FrfKind> {
    match quantity {
        DISPLACEMENT => Some(FrfKind::Receptance),
        VELOCITY => Some(FrfKind::Mobility),
        ACCELERATION => Some(FrfKind::Accelerance),
        _ => None,
    }
}

/// Quantity code of the numerator of an FRF kind.
pub(super) fn motion_code(kind: FrfKind) -> i32 {
    match kind {
        FrfKind::Receptance => DISPLACEMENT,
        FrfKind::Mobility => VELOCITY,
        FrfKind::Accelerance => ACCELERATION,
    }
}

/// Reads kind, reference unit and factor of an FRF.
fn frf(
    axes: &[Axis; 4],
    directions: [Direction; 2],
    units: Option<Units>,
    scaling: &mut Scaling,
    warnings: &mut Vec<Finding>,
) {
    let [_, numerator, denominator, _] = axes;
    let (above, below) = (
        unit_label::parse(&numerator.unit),
        unit_label::parse(&denominator.unit).or_else(|| assumed_newton(axes, units, warnings)),
    );
    let volts = below.filter(|unit| unit.is_voltage());
    let reference = match denominator.quantity {
        EXCITATION_FORCE => Some(ReferenceUnit::Newton),
        0 | 1 => volts.map(|_| ReferenceUnit::Volt),
        _ => None,
    };
    let by_codes = motion(numerator.quantity).zip(reference);
    // the unit is numerator label over denominator label, or the numerator label alone
    let ratio = [
        above.zip(below).map(|(above, below)| above.per(below)),
        above,
    ]
    .into_iter()
    .flatten()
    .find(|unit| unit.frf_kind().is_some());
    let by_label = ratio.and_then(Unit::frf_kind);
    let shown = if denominator.unit.is_empty() {
        numerator.unit.clone()
    } else {
        format!("({})/({})", numerator.unit, denominator.unit)
    };

    if let Some((kind, reference)) = by_codes.or(by_label) {
        scaling.kind = Some(kind);
        scaling.reference_unit = reference;
    }
    warnings.extend(kinds_contradict(by_codes, by_label, &shown));
    let label_factor = ratio
        .filter(|unit| by_codes.is_none_or(|codes| unit.frf_kind() == Some(codes)))
        .map(|unit| unit.factor);
    let dataset_factor = units.and_then(|units| {
        let above = 1.0 / units.factor(exponents(numerator, directions[0])?);
        let below = match exponents(denominator, directions[1]) {
            Some(exponents) => 1.0 / units.factor(exponents),
            None => volts?.factor,
        };
        Some(above / below)
    });
    let sides = [(numerator, directions[0]), (denominator, directions[1])];
    let factors = [dataset_factor, label_factor];
    scaling.scale_to_si = frf_factor(factors, sides, &shown, units, warnings);
    let codes = [numerator.quantity, denominator.quantity];
    warnings.extend(swapped(codes, scaling.kind.is_none()));
}

/// The warning where codes and label name different kinds.
fn kinds_contradict(
    by_codes: Option<(FrfKind, ReferenceUnit)>,
    by_label: Option<(FrfKind, ReferenceUnit)>,
    shown: &str,
) -> Option<Finding> {
    let (codes, label) = by_codes.zip(by_label)?;
    let words = format!(
        "the quantity codes say {} ({}), the unit label `{shown}` says {} ({}); the codes are used",
        codes.0,
        codes.0.unit(codes.1),
        label.0,
        label.0.unit(label.1)
    );
    (codes != label).then(|| Finding::caution("unit-contradicted", words))
}

/// The newton, assumed where only the motion has a label and nothing else tells the unit of
/// the force.
fn assumed_newton(
    axes: &[Axis; 4],
    units: Option<Units>,
    warnings: &mut Vec<Finding>,
) -> Option<Unit> {
    let [_, numerator, denominator, _] = axes;
    let unsaid = denominator.unit.is_empty() && denominator.quantity == EXCITATION_FORCE;
    let newton = unit_label::parse("N").filter(|_| unsaid && units.is_none())?;
    let is_motion = |unit: &Unit| {
        let kind = unit.per(newton).frf_kind().map(|(kind, _)| kind);
        // with inches and feet, the force is hardly in newtons
        let metric = unit.factor.log10().fract() == 0.0 || unit.factor == STANDARD_GRAVITY;
        kind.is_some() && kind == motion(numerator.quantity) && metric
    };
    unit_label::parse(&numerator.unit).filter(is_motion)?;
    let words = format!(
        "the file states the unit of the motion ({}), not that of the force: N is assumed",
        numerator.unit
    );
    warnings.push(Finding::caution("unit-assumed", words));
    Some(newton)
}

/// Factor to SI of an FRF: that of dataset 164, else that of the label.
fn frf_factor(
    factors: [Option<f64>; 2],
    sides: [(&Axis, Direction); 2],
    shown: &str,
    units: Option<Units>,
    warnings: &mut Vec<Finding>,
) -> f64 {
    match factors {
        [Some(used), Some(label)] => {
            if differ(used, label) {
                warnings.push(Finding::caution(
                    "unit-contradicted",
                    contradiction(shown, used, label),
                ));
            }
            used
        }
        [Some(used), None] => {
            // the label of one side may still contradict the dataset
            for (axis, direction) in sides {
                if unit_label::parse(&axis.unit).is_some_and(|unit| unit.frf_kind().is_none()) {
                    side(axis, direction, units, warnings);
                }
            }
            used
        }
        [None, Some(label)] => label,
        [None, None] => {
            warnings.extend(units.is_none_or(|units| !units.is_si()).then(|| {
                Finding::caution(
                    "unit-assumed",
                    "the file does not state the unit of the FRF: SI is assumed",
                )
            }));
            1.0
        }
    }
}

/// The finding about quantity codes that no FRF has.
fn swapped([above, below]: [i32; 2], is_unknown: bool) -> Option<Finding> {
    let words = if above == EXCITATION_FORCE && motion(below).is_some() {
        "the quantity codes say force over motion: response and reference are swapped (correct \
         the export), or these are dynamic stiffnesses (export the FRFs themselves)"
            .into()
    } else if is_unknown && (above > 1 || below > 1) {
        format!(
            "quantity codes {above} over {below} are no receptance (8/13), mobility (11/13) or \
             accelerance (12/13)"
        )
    } else {
        return None;
    };
    Some(Finding::caution("swapped-codes", words))
}

/// Refuses a function of frequency over orders without a unit of frequency: without the speed
/// they are no frequencies.
pub(super) fn refuse_orders(function_type: i32, axis: &Axis, line: u64) -> Result<()> {
    let is_order = axis.quantity == ORDER && [FRF, COHERENCE].contains(&function_type);
    if !is_order || unit_label::parse(&axis.unit).is_some_and(|unit| unit.to_hertz().is_some()) {
        return Ok(());
    }
    Err(Error::bad_data("an FRF or coherence over orders")
        .at_line(line)
        .field("quantity code of the abscissa (record 8)")
        .found(format!("{ORDER}, an order"))
        .expected(format!("{FREQUENCY} (frequency) or {RPM} (rpm)"))
        .help("export the function over frequency; orders are none without the speed"))
}

/// Factor to Hz of a speed of rotation: that of its unit, else that of rpm.
fn rotation(axis: &Axis, label: Option<Unit>, warnings: &mut Vec<Finding>) -> f64 {
    let rpm = 1.0 / 60.0;
    let by_label = label.and_then(Unit::to_hertz);
    let words = match by_label {
        Some(factor) if differ(factor, rpm) => format!(
            "quantity code {RPM} of the abscissa says rpm, its unit says `{}`; the unit is used",
            axis.unit
        ),
        None if !axis.unit.is_empty() => format!(
            "abscissa unit `{}` is not understood: rpm is assumed (quantity code {RPM})",
            axis.unit
        ),
        _ => return rpm,
    };
    let code = by_label.map_or("unit-assumed", |_| "unit-contradicted");
    warnings.push(Finding::caution(code, words));
    by_label.unwrap_or(rpm)
}

fn abscissa(axis: &Axis, function_type: i32, warnings: &mut Vec<Finding>) -> f64 {
    let label = unit_label::parse(&axis.unit);
    let over_frequency = function_type == FRF || function_type == COHERENCE;
    if axis.quantity == TIME && over_frequency {
        warnings.push(Finding::caution(
            "frequency-over-time",
            format!(
                "a function of frequency over an abscissa of time (quantity code {TIME}): the \
                 abscissa is taken as Hz"
            ),
        ));
    }
    if axis.quantity == RPM && over_frequency {
        return rotation(axis, label, warnings);
    }
    if axis.quantity == ORDER && over_frequency {
        warnings.push(Finding::caution(
            "unit-contradicted",
            format!(
                "quantity code {ORDER} of the abscissa says orders, its unit says `{}`; the unit \
                 is used",
                axis.unit
            ),
        ));
    }
    let (factor, assumed) = match axis.quantity {
        TIME if !over_frequency => (label.and_then(Unit::to_seconds), "s"),
        FREQUENCY => (label.and_then(Unit::to_hertz), "Hz"),
        _ if over_frequency => (label.and_then(Unit::to_hertz), "Hz"),
        _ => return 1.0,
    };
    factor.unwrap_or_else(|| {
        if !axis.unit.is_empty() {
            warnings.push(Finding::caution(
                "unit-assumed",
                format!(
                    "abscissa unit `{}` is not understood: {assumed} is assumed",
                    axis.unit
                ),
            ));
        }
        1.0
    })
}

#[cfg(test)]
mod tests;
