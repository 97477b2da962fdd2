//! What the record itself says: was it padded with zeros?

use crate::work::Work;
use num_complex::Complex64;
use rustfft::FftPlanner;

/// Factor (2 or 4) by which the time record was padded with zeros, or 1.
///
/// A padded record's impulse response ends abruptly at T/2 or T/4; then only every second or fourth line carries
/// information, and on those lines alone the cut record is exactly a sum of modes.
pub(crate) fn padding_factor(work: &Work, frequency: &[f64]) -> usize {
    let n = frequency.len();
    if n < 64 {
        return 1;
    }
    let step = (frequency[n - 1] - frequency[0]) / (n - 1) as f64;
    let uniform = frequency.windows(2).all(|w| ((w[1] - w[0]) - step).abs() < 0.05 * step);
    if !uniform {
        return 1;
    }
    const SEGMENTS: usize = 32;
    let mut energy = [0.0; SEGMENTS];
    let fft = FftPlanner::new().plan_fft_inverse(n);
    for column in work.b.columns() {
        let mut response: Vec<Complex64> = column.to_vec();
        fft.process(&mut response);
        for (i, v) in response.iter().enumerate() {
            energy[i * SEGMENTS / n] += v.norm_sqr();
        }
    }
    let level: Vec<f64> = energy.iter().map(|e| 10.0 * e.max(1e-300).log10()).collect();
    for (factor, end) in [(4, SEGMENTS / 4), (2, SEGMENTS / 2)] {
        // the last segment before the cut, and everything after it but the wrap-around at the end
        let before = level[end - 1];
        let after = &level[end + 1..SEGMENTS - 2];
        let drop = before - after.iter().cloned().fold(f64::MIN, f64::max);
        let trend = level[end - 3] - before;
        if drop > 8.0 && trend < 0.5 * drop {
            return factor;
        }
    }
    1
}
