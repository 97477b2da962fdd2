//! Sets of many FRFs, made block by block so that they take no more memory than their
//! own.

use chladni_frf::{FrfSet, FrfValues, ModalModel, Result};
use chladni_plate::{add_noise_of_variance, noise_variance, synthesise_by_products, Synthetic};
use ndarray::{s, Array1, Array3, ArrayViewMut3, Axis};
use num_complex::{Complex32, Complex64};

/// Responses per block: some tens of megabytes.
const BLOCK: usize = 50;
/// Noise below the mean square of the first block, dB.
const SNR_DB: f64 = 40.0;

/// Size of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Responses.
    pub responses: usize,
    /// References.
    pub references: usize,
    /// Lines.
    pub lines: usize,
    /// Modes.
    pub modes: usize,
    /// Single precision.
    pub single: bool,
}

/// Separate modes with real shapes, 40 dB, as mobilities; the same bits every time.
///
/// # Errors
/// As [`Synthetic::build`].
pub fn large(size: Size) -> Result<FrfSet> {
    let axis = Array1::linspace(10.0, 1000.0, size.lines);
    let natural = (0..size.modes)
        .map(|n| 10.0 + 990.0 * (n as f64 + 0.5) / size.modes as f64)
        .collect();
    let spec = Synthetic {
        natural_frequency_hz: natural,
        loss_factor: vec![0.01],
        responses: size.responses,
        references: size.references,
        // the shapes alone are wanted here; the FRFs follow in blocks
        frequency_hz: Array1::from(vec![10.0, 1000.0]),
        snr_db: f64::INFINITY,
        ..Synthetic::default()
    };
    let set = spec.build()?;
    let dim = (size.responses, size.references, size.lines);
    let values = if size.single {
        let mut values = Array3::<Complex32>::zeros(dim);
        fill(&mut values, &set.truth, &axis, |v| {
            Complex32::new(v.re as f32, v.im as f32)
        });
        FrfValues::F32(values)
    } else {
        let mut values = Array3::<Complex64>::zeros(dim);
        fill(&mut values, &set.truth, &axis, |v| v);
        FrfValues::F64(values)
    };
    FrfSet {
        frequency_hz: axis,
        values,
        ..set.frf
    }
    .checked()
}

fn fill<T>(
    values: &mut Array3<T>,
    truth: &ModalModel,
    axis: &Array1<f64>,
    narrow: impl Fn(Complex64) -> T,
) {
    let mut variance = None;
    for (number, block) in values.axis_chunks_iter_mut(Axis(0), BLOCK).enumerate() {
        let mut frf = synthesise_by_products(
            &of_responses(truth, number * BLOCK, block.len_of(Axis(0))),
            axis,
        );
        let variance = *variance.get_or_insert_with(|| noise_variance(&frf, SNR_DB));
        add_noise_of_variance(&mut frf, variance, number as u64);
        assign(block, &frf, &narrow);
    }
}

fn assign<T>(
    mut block: ArrayViewMut3<T>,
    frf: &Array3<Complex64>,
    narrow: impl Fn(Complex64) -> T,
) {
    block.zip_mut_with(&frf.slice(s![.., .., ..]), |target, &value| {
        *target = narrow(value)
    });
}

/// The model of `count` responses from `first` on.
fn of_responses(truth: &ModalModel, first: usize, count: usize) -> ModalModel {
    let mut model = truth.clone();
    let rows = first..first + count;
    model.responses = truth.responses[rows.clone()].to_vec();
    for mode in &mut model.modes {
        mode.shape.0 = mode.shape.0[rows.clone()].to_vec();
        mode.shape_std = mode.shape_std[rows.clone()].to_vec();
    }
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_join_to_one_structure_and_precision_changes_digits_only() {
        let size = Size {
            responses: 2 * BLOCK + 3,
            references: 2,
            lines: 64,
            modes: 3,
            single: false,
        };
        let double = large(size).unwrap();
        let single = large(Size {
            single: true,
            ..size
        })
        .unwrap();
        let (FrfValues::F64(double), FrfValues::F32(single)) = (&double.values, &single.values)
        else {
            panic!("precisions")
        };
        let largest = double.iter().fold(0.0f64, |m, v| m.max(v.norm()));
        let apart = double.iter().zip(single).fold(0.0f64, |m, (a, b)| {
            m.max((a.re - f64::from(b.re)).hypot(a.im - f64::from(b.im)))
        });
        assert!(apart < 1e-6 * largest && apart > 0.0);
        assert!((0..size.responses).all(|i| double[[i, 0, 5]].norm() > 0.0));
    }
}
