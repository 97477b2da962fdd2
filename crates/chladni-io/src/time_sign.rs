//! The time sign of a file and that of the user.

use chladni_frf::{Finding, FrfSet, TimeSign};

/// Brings `set` to e^{+jωt}: conjugates it once where the file, the user or both give minus.
///
/// The user's minus overrules a plus of the file, with a warning. The user's plus is the
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
