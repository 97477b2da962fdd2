//! The least work of a stage: the arithmetic and the memory traffic of its passes over
//! all FRFs.

/// Real operations of a complex multiply and add.
const COMPLEX: f64 = 8.0;

/// flop and bytes of the passes over the data that `stage` must make, for N·M values and
/// m unknowns per FRF; NaN for stages that work on compressed data, whose cost does not
/// follow from the size of the set.
///
/// A stage may do more, as the pass of `projection` is repeated where modes are found
/// late, so that rates from here are lower limits.
pub(super) fn least_work(stage: &str, [values, unknowns]: [f64; 2], bytes: f64) -> [f64; 2] {
    match stage {
        // one look at every value: is it there, how large is it
        "screening" => [4.0 * values, bytes],
        // every value goes to one column of the sketch with a sign, and its square into
        // the sum
        "sketch" => [6.0 * values, bytes],
        // residues QᴴB and compressed data B(QᴴB)ᵀ
        "projection" => [2.0 * COMPLEX * values * unknowns, bytes],
        // the last residual of every FRF
        "shapes" | "residues" => [COMPLEX * values * unknowns, bytes],
        _ => [f64::NAN; 2],
    }
}
