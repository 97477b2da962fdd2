//! The time sign of a file against the user's word.

use chladni_frf::{Finding, FrfSet, TimeSign};

/// Brings `set` to e^{+jωt}: conjugates it where the file says minus, or the user does
/// (once, where both do).
///
/// The user's minus wins over a file that says plus, with a warning; a plus is the
/// default and overrules nothing.
pub(super) fn to_plus(
    set: &mut FrfSet,
    said: Option<TimeSign>,
    told: TimeSign,
    warnings: &mut Vec<Finding>,
) {
    if told == TimeSign::Minus && said == Some(TimeSign::Plus) {
        warnings.push(Finding::note(
            "option-overrules-file",
            "the file says time sign +, you say -: conjugated, as you say",
        ));
    }
    if told == TimeSign::Minus || said == Some(TimeSign::Minus) {
        set.conjugate();
    }
}
