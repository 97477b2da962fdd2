//! A scene over the number of modes and over the number of actuators. Each number has weights
//! of its own, judged in the whole model.

use crate::limits::POINTS;
use chladni_frf::{Dof, ModalModel, Result};
use chladni_render::{
    evaluate, render, Count, Indices, MethodChoice, On, RenderOptions, Scene, Weights,
};
use chladni_report::{CurvePoint, Curves};
use rayon::prelude::*;

/// The method of every point, quick enough to draw curves with their scene.
const METHOD: MethodChoice = MethodChoice::Fast;

/// Both curves of the scene that `weights` were made for. Actuators are added in falling order
/// of their amplitudes in `weights`.
///
/// # Errors
/// Those of rendering.
pub fn curves(model: &ModalModel, scene: &Scene, weights: &Weights) -> Result<Curves> {
    let modes = model.in_band_modes().count();
    let mut order: Vec<_> = weights
        .weights
        .iter()
        .filter(|weight| weight.amplitude > 0.0)
        .collect();
    order.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let order: Vec<Dof> = order.into_iter().map(|weight| weight.reference).collect();
    let of_modes = |count: usize| -> Result<CurvePoint> {
        let weights = render(
            model,
            scene,
            &RenderOptions {
                modes: Count::Number(count),
                ..options()
            },
        )?
        .weights;
        Ok(point(
            count,
            &evaluate(&weights, scene, On::Model(model))?.indices,
        ))
    };
    let of_actuators = |count: usize| -> Result<CurvePoint> {
        let mut fewer = scene.clone();
        fewer.actuators.only = Some(order[..count].to_vec());
        // with all modes the indices of the weights are those of the whole model
        Ok(point(
            count,
            &render(model, &fewer, &options())?.weights.indices,
        ))
    };
    Ok(Curves {
        method: METHOD.to_string(),
        modes: steps(modes)
            .into_par_iter()
            .map(of_modes)
            .collect::<Result<_>>()?,
        actuators: steps(order.len())
            .into_par_iter()
            .map(of_actuators)
            .collect::<Result<_>>()?,
    })
}

fn options() -> RenderOptions {
    RenderOptions {
        method: METHOD,
        ..RenderOptions::default()
    }
}

/// 1 to `last`, at most about [`POINTS`] of them, the last one always among them.
fn steps(last: usize) -> Vec<usize> {
    let step = last.div_ceil(POINTS).max(1);
    (1..=last)
        .filter(|count| (last - count).is_multiple_of(step))
        .collect()
}

fn point(count: usize, indices: &Indices) -> CurvePoint {
    let points = &indices.points;
    CurvePoint {
        count,
        hot_ratio: points.hot_ratio,
        cold_ratio: points.cold_ratio,
        success_ratio: points.success_ratio,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_the_last_and_stay_few() {
        assert_eq!(steps(3), [1, 2, 3]);
        assert!(steps(0).is_empty());
        let many = steps(205);
        assert!(
            many.len() <= POINTS + 1 && many.last() == Some(&205),
            "{many:?}"
        );
    }
}
