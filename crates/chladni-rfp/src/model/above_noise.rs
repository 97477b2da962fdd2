//! The finding of a model that leaves more than the noise, where error bars follow the noise alone.

use super::limits;
use chladni_frf::Finding;

/// A note where χ² per degree of freedom is so far above 1 that neither chance nor the misfit that
/// the search for shapes accepts explains it; `None` beyond [`limits::SHAPE_MISFIT`], which has a
/// finding of its own.
///
/// * `values`: complex values that χ² is a sum over
pub(super) fn above_noise(chi2_per_dof: f64, values: usize) -> Option<Finding> {
    let excess = chi2_per_dof - 1.0;
    let by_chance = limits::ABOVE_CHANCE / (values.max(1) as f64).sqrt();
    let is_told = excess > limits::ABOVE_NOISE.max(by_chance);
    (is_told && chi2_per_dof <= limits::SHAPE_MISFIT).then(|| {
        let words = format!(
            "the model leaves {:.0} % more than the noise (χ² per degree of freedom \
             {chi2_per_dof:.2}): the modes are not quite of one shape each, or the terms for what lies \
             outside the band are not quite right; error bars follow the noise alone",
            100.0 * excess
        );
        Finding::note("above-noise", words)
            .value("chi2_per_dof", chi2_per_dof)
            .help("nothing to do for frequencies and damping; for shapes, fit a narrower band")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_and_accepted_misfit_are_not_told() {
        let told = |chi2, values| above_noise(chi2, values).is_some();
        assert!(told(1.15, 20_000) && told(1.4, 2_000));
        assert!(!told(1.05, 1_000_000) && !told(1.3, 400));
        // that has words of its own
        assert!(!told(1.6, 20_000));
    }
}
