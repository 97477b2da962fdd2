//! Error bars from errors that neighbouring lines, and FRFs measured at once, share
//! (theory.md, eq. F4e).

use crate::damping::bars::in_either_case;
use crate::data::window::block_errors::BlockErrors;
use crate::poles::pole::Pole;
use crate::shapes::error_bars::ShapeBars;
use crate::shapes::force_drop::ForceDrop;
use crate::shapes::found::FittedPoles;
use crate::shapes::influence::{square, Influence, PairNoise};
use crate::shapes::leaked::{LeakageShare, Moments};
use crate::shapes::limits;
use crate::shapes::scale::Scale;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, ArrayView1};
use num_complex::Complex64;
use rayon::prelude::*;

/// The error bars of one term from one model of the errors.
struct LineBars {
    /// Error bars of Re λ and Im λ.
    pole: [f64; 2],
    /// Standard deviation of each response.
    shape: Vec<f64>,
    /// Standard deviation of the scale.
    scale: f64,
}

/// The bar that stays, of the one at hand and the new one.
#[derive(Clone, Copy)]
enum Keep {
    /// The larger one: all FRFs share noise of a force.
    Larger,
    /// The bar at hand where it is [`limits::BARS_CONTRADICT`] times the new one: it is that of
    /// a residual of blows, which is not white and does not tell.
    LargerIfContradicted,
    /// The new one.
    New,
}

/// The error bars of a term, and how they join those at hand.
pub(crate) struct TermBars {
    term: usize,
    owner: usize,
    new: LineBars,
    /// The same for independent errors, where the bars at hand are those of another
    /// estimator and only the ratio counts.
    white: Option<LineBars>,
    keep: Keep,
}

impl TermBars {
    /// Puts these in place of the bars of independent lines.
    pub fn put(self, poles: &mut [Pole], bars: &mut ShapeBars) {
        let Self {
            term,
            owner,
            new,
            white,
            keep,
        } = self;
        let white = white.as_ref();
        let pole = &mut poles[owner];
        let per_unit = [0.5 / pole.omega, pole.omega.powi(-2)];
        let sizes = [&mut pole.omega_std, &mut pole.loss_factor_std];
        for (side, size) in sizes.into_iter().enumerate() {
            let of = |bars: &LineBars| bars.pole[side] * per_unit[side];
            keep.replace(size, of(&new), white.map(of));
        }
        for (i, &of_response) in new.shape.iter().enumerate() {
            let white = white.map(|white| white.shape[i]);
            keep.replace(&mut bars.shape[[term, i]], of_response, white);
        }
        keep.replace(&mut bars.scale[term], new.scale, white.map(|w| w.scale));
    }
}

impl Keep {
    /// A bar that is known stays where the new one is not.
    fn replace(self, bar: &mut f64, new: f64, white: Option<f64>) {
        let value = match (white, self) {
            (Some(white), _) => *bar * (new / white).max(1.0),
            (None, Self::Larger) if *bar > new => *bar,
            (None, Self::LargerIfContradicted) if *bar > limits::BARS_CONTRADICT * new => *bar,
            (None, _) => new,
        };
        if bar.is_finite() && value.is_finite() {
            *bar = value;
        }
    }
}

/// Error bars of the modes of the band, and the forces that the residual leaves possible.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn line_bars(
    found: &FittedPoles,
    errors: &BlockErrors,
) -> Result<(Vec<TermBars>, Option<ForceDrop>), LinalgError> {
    let influence = Influence::new(found, errors)?;
    let variances = influence.line_variances();
    let own: Vec<f64> = variances
        .iter()
        .map(|v| influence.shared.alone * v)
        .collect();
    let correlated = influence.noise_products(|cycles| errors.of_noise(cycles), &own);
    let independent = |cycles: f64| f64::from(u8::from(cycles == 0.0)).into();
    let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
    let white = influence.noise_products(independent, &vec![mean; variances.len()]);
    let (share, force_drop) = influence.leakage_share();
    // the leakage of the median line covers what is not known: the number of blocks, or how
    // loud noise is where a force drops
    let drops = force_drop.as_ref().is_some_and(ForceDrop::may_be);
    let noise = match drops || errors.blocks().is_none() {
        true => &influence.seen,
        false => &influence.noise,
    };
    let by_force = influence.shared.by_force;
    let keep = match by_force {
        true => Keep::Larger,
        false if !found.residual_is_noise && errors.of_blows() => Keep::LargerIfContradicted,
        false => Keep::New,
    };
    let of_term = |term: usize| {
        let owner = found.shapes.owner[term];
        let moments = influence.moments(
            owner,
            (&correlated, noise),
            share,
            &influence.shared_near(owner, force_drop.as_ref()),
            force_drop.as_ref(),
        );
        let other = found.poles[owner].given.as_ref();
        let white = other.filter(|_| !by_force).map(|_| {
            let white = (&white, &influence.seen);
            let moments = influence.moments(owner, white, LeakageShare::default(), &[], None);
            influence.bars(term, &moments, white)
        });
        TermBars {
            term,
            owner,
            new: influence.bars(term, &moments, (&correlated, noise)),
            white,
            keep,
        }
    };
    let inside = |term: &usize| {
        found
            .work
            .in_band(influence.lambda[found.shapes.owner[*term]])
    };
    let terms: Vec<usize> = (0..found.shapes.owner.len()).filter(inside).collect();
    Ok((terms.into_par_iter().map(of_term).collect(), force_drop))
}

impl Influence<'_> {
    /// Variance of leakage over that in one block, and the forces that the residual leaves
    /// possible. A force that drops at resonances leaks more than one of even spectrum, and one
    /// of several that act at once into the FRFs of the others, too: so the residual is asked
    /// before the number of blocks.
    fn leakage_share(&self) -> (LeakageShare, Option<ForceDrop>) {
        let of_blocks = self.errors.blocks().map(|blocks| 1.0 / blocks);
        let believed = |[less, whole]: [f64; 2]| match of_blocks {
            Some(share) if less < limits::LEAKS_AS_TOLD * share => share,
            Some(_) => less,
            None => whole,
        };
        let force_drop = self.force_drop(believed(self.share_of_leakage(None)));
        let only_force = self.found.data.references.len() == 1;
        let drops = force_drop.as_ref().and_then(ForceDrop::decided).is_some();
        let all = match of_blocks {
            // the residual holds what the likeliest drop misses of the true one, too
            Some(share) if only_force && drops && !self.shared.over_lines => share,
            // noise of a force that drops is loudest where leakage is
            _ => believed(self.share_of_leakage(force_drop.as_ref())),
        };
        let own = match only_force {
            true => all,
            false => of_blocks.map_or(all, |share| all.min(share)),
        };
        (LeakageShare { all, own }, force_drop)
    }

    /// The parts of `moments` in Σ coefficient·δR_n over pairs, for each force.
    fn parts(
        &self,
        n: usize,
        near: &[usize],
        coefficients: impl Iterator<Item = (usize, Complex64)>,
    ) -> Vec<Vec<Complex64>> {
        let size = near.len();
        let mut parts = vec![vec![Complex64::ZERO; 2 * size]; self.forces];
        for (l, coefficient) in coefficients {
            for (a, &m) in near.iter().enumerate() {
                let own = coefficient * self.residues[[m, l]];
                parts[self.force[l]][a] += own;
                parts[0][size + a] -= self.follow[[n, m]] * own;
            }
        }
        // errors of poles are those of all forces together
        let of_poles = parts[0][size..].to_vec();
        parts[1..]
            .iter_mut()
            .for_each(|part| part[size..].copy_from_slice(&of_poles));
        parts
    }

    /// Derivatives of the scale of a term by the residue of each FRF: through its shape `x`,
    /// and through its participation `l`, which is that of the shapes times `unit`.
    fn of_scale(
        &self,
        scale: &Scale,
        unit: Complex64,
        x: ArrayView1<Complex64>,
        l: &Array1<Complex64>,
    ) -> Vec<Complex64> {
        let (x2, l2) = (square(x.iter()), square(l.iter()));
        let by_shape = |i: usize| -> Complex64 {
            let own = scale.response.iter().filter(|(d, _)| *d == i);
            own.map(|(_, weight)| *weight).sum()
        };
        let along: Complex64 = scale.reference.iter().map(|&(j, c)| c / unit * l[j]).sum();
        let by_participation = |j: usize| -> Complex64 {
            let own = scale.reference.iter().filter(|(r, _)| *r == j);
            own.map(|(_, c)| *c / unit).sum::<Complex64>() - along * l[j].conj() / l2
        };
        let of_pair = |&(i, j): &(usize, usize)| {
            by_shape(i) * (l[j].conj() / l2) + by_participation(j) * x[i].conj() / x2
        };
        self.found.data.pairs.iter().map(of_pair).collect()
    }

    /// The error bars of a term.
    fn bars(
        &self,
        term: usize,
        moments: &Moments,
        (noise, own): (&Array2<Complex64>, &PairNoise),
    ) -> LineBars {
        let FittedPoles {
            data,
            poles,
            shapes,
            scales,
            work,
            ..
        } = self.found;
        let (n, scale) = (shapes.owner[term], &scales[term]);
        let unit = poles[n].residue_unit(work.law);
        let x = shapes.shape.row(term);
        let l = shapes.participation.row(term).mapv(|v| v * unit);
        let l2 = square(l.iter());
        // x_i is Σ_j R_ij·L_j*/|L|²
        let direct = |p: usize| l[data.pairs[p].1].conj() / l2;
        let of_scale = self.of_scale(scale, unit, x, &l);
        let spread = |parts: &[Vec<Complex64>]| -> f64 {
            let of_force = |(part, leaked): (&Vec<Complex64>, &Array2<Complex64>)| -> f64 {
                let each = leaked.indexed_iter();
                each.map(|((a, b), v)| (part[a] * v * part[b].conj()).re)
                    .sum()
            };
            parts.iter().zip(&moments.leaked).map(of_force).sum()
        };
        let (near, own_noise) = (&moments.near, noise[[n, n]].re);
        let scale_parts = self.parts(n, near, of_scale.iter().copied().enumerate());
        let noise_of = |p: usize, coefficient: Complex64| coefficient.norm_sqr() * own.variances[p];
        let scale_noise: f64 = of_scale
            .iter()
            .enumerate()
            .map(|(p, c)| noise_of(p, *c))
            .sum();
        let scale_variance = (spread(&scale_parts) + own_noise * scale_noise).max(0.0);
        let beyond_first_order = scale.second_order(scale_variance) * scale_variance;
        let of_response = |i: usize| {
            let pairs = &self.of_response[i];
            let mut parts = self.parts(n, near, pairs.iter().map(|&p| (p, direct(p))));
            for (part, shared) in parts.iter_mut().zip(&scale_parts) {
                part.iter_mut()
                    .zip(shared)
                    .for_each(|(v, s)| *v += x[i] * s);
            }
            let own = |&p: &usize| {
                noise_of(p, direct(p) + x[i] * of_scale[p]) - noise_of(p, x[i] * of_scale[p])
            };
            let noise = x[i].norm_sqr() * scale_noise + pairs.iter().map(own).sum::<f64>();
            let all = spread(&parts) + own_noise * noise + x[i].norm_sqr() * beyond_first_order;
            scale.factor.norm() * all.max(0.0).sqrt()
        };
        LineBars {
            pole: [0, 1].map(|side| {
                let [std, shift] = [moments.pole, moments.pole_shift].map(|v| v[side].sqrt());
                in_either_case(std, shift)
            }),
            shape: (0..x.len()).map(of_response).collect(),
            scale: scale_variance.sqrt(),
        }
    }
}
