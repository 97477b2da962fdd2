//! Steps of a search that closes in slowly along one direction, mixed with the ones before.
//!
//! Gauss–Newton steps shrink by a nearly constant factor if residuals stay large: the step before
//! and this one tell the factor, and with it the place to which they lead. D. G. Anderson, J. ACM
//! 12 (1965) 547–560, with a memory of one step.

use ndarray::{Array2, ArrayView1};

/// The last point of a search and the step proposed there.
#[derive(Default)]
pub(super) struct Mixing {
    last: Option<(Array2<f64>, Array2<f64>)>,
}

impl Mixing {
    /// The mixed step at `point`, where the search proposes `step`; both (unknown, 1), lengths
    /// weighted by `weight`. `None` on the first call and where the step did not change.
    pub fn step(
        &mut self,
        point: Array2<f64>,
        step: &Array2<f64>,
        weight: ArrayView1<f64>,
    ) -> Option<Array2<f64>> {
        let last = self.last.replace((point.clone(), step.clone()));
        let (point_before, step_before) = last?;
        let change = step - &step_before;
        let product = |other: &Array2<f64>| -> f64 {
            let values = change.iter().zip(other).zip(weight);
            values.map(|((a, b), weight)| a * b * weight).sum()
        };
        let part = product(step) / product(&change);
        part.is_finite()
            .then(|| step - (point - point_before + change) * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::arr2;

    /// Steps x → Ax + b with one direction that shrinks by 0.99 and one by 0.1.
    #[test]
    fn a_slow_direction_is_followed_to_its_end() {
        let end = arr2(&[[3.0], [-2.0]]);
        let proposed = |point: &Array2<f64>| {
            let left = &end - point;
            arr2(&[[0.01 * left[[0, 0]]], [0.9 * left[[1, 0]]]])
        };
        let mut mixing = Mixing::default();
        let mut point = arr2(&[[0.0], [0.0]]);
        let weight = arr2(&[[1.0, 1.0]]);
        for _ in 0..12 {
            let step = proposed(&point);
            let mixed = mixing.step(point.clone(), &step, weight.row(0));
            point += &mixed.unwrap_or(step);
        }
        let left = &end - &point;
        assert!(left.iter().all(|left| left.abs() < 1e-6), "{left}");
    }

    #[test]
    fn the_first_step_and_a_step_that_stays_are_not_mixed() {
        let (point, step) = (arr2(&[[1.0]]), arr2(&[[0.5]]));
        let weight = arr2(&[[2.0]]);
        let mut mixing = Mixing::default();
        assert!(mixing.step(point.clone(), &step, weight.row(0)).is_none());
        assert!(mixing.step(point, &step, weight.row(0)).is_none());
    }
}
