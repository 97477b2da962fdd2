//! Error bars of shapes: noise in the shape itself, and what errors of poles and
//! participations do to it (theory.md, eq. 36–38).
//!
//! At given poles and participations shapes are linear least squares, x_i = G⁻¹Aᴴb_i for
//! response i; an error δθ of the others moves them by −Jδθ, and independent of it is the
//! noise of x_i itself. Last comes the scale, which hangs on the same numbers.

use crate::data::columns::Columns;
use crate::data::information::answer;
use crate::poles::pole::Pole;
use crate::shapes::inverse_root::{finite, inverse_root, inverse_root_beside};
use crate::shapes::limits;
use crate::shapes::line_products::LineProducts;
use crate::shapes::low_rank::Shapes;
use crate::shapes::residues::alike;
use crate::shapes::scale::Scale;
use crate::shapes::tangent::{mixing, overlapping, pivots, taken, unknowns, Tangent, Unknown};
use crate::shapes::term_noise::TermNoise;
use chladni_linalg::{matmul, matmul_h, LinalgError};
use ndarray::{concatenate, s, Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Responses measured from the same references, and what the normal equations look like
/// for them.
struct Group {
    responses: Vec<usize>,
    kept: Vec<bool>,
    /// L̄Lᵀ over the references kept, (term, term).
    along: Array2<Complex64>,
    /// x̄xᵀ over the responses, (term, term).
    across: Array2<Complex64>,
    /// Inverse of the Gram matrix of the columns φ_n⊗L_n.
    gram_inverse: Array2<Complex64>,
}

/// Shapes with what is known of their noise.
pub(crate) struct Noisy<'a> {
    /// Lines and weights.
    pub work: &'a Columns,
    /// Powers of x of the residual terms.
    pub powers: &'a [i32],
    pub poles: &'a [Pole],
    pub shapes: &'a Shapes,
    /// (response, reference): false where not measured.
    pub present: &'a Array2<bool>,
    /// Mean noise variance of a value of an FRF.
    pub variance: f64,
    /// Noise of each term over that mean.
    pub noise: &'a TermNoise,
    /// True where shapes and participations that came with poles are real.
    pub real: bool,
}

/// The errors of shapes, as far as they are known.
#[derive(Default)]
pub(crate) struct ShapeBars {
    /// √E|δψ|², (term, response).
    pub shape: Array2<f64>,
    /// Relative standard deviation of the scale t, (term).
    pub scale: Vec<f64>,
}

/// Error bars of every term, for shapes scaled as told. Modes of the band, and those
/// found together with them, are judged with the poles outside left free, as they were
/// found, and the other way round. A shape that the data do not tell has infinite ones, and so
/// have those of poles outside where these have too many terms to ask.
pub(crate) fn shape_bars(noisy: &Noisy, scales: &[Scale]) -> ShapeBars {
    let Noisy {
        work,
        poles,
        shapes,
        ..
    } = noisy;
    let twin = |n: usize| Complex64::new(1.0, poles[n].loss_factor) * poles[n].omega.powi(2);
    let (inside, outside): (Vec<usize>, Vec<usize>) =
        (0..poles.len()).partition(|&n| work.in_band(twin(n)) || poles[n].given.is_some());
    let of_rows = |kept: &[usize], others: &[usize]| {
        let rows: Vec<usize> = (0..shapes.owner.len())
            .filter(|&row| kept.contains(&shapes.owner[row]))
            .collect();
        let others: Vec<Complex64> = others.iter().map(|&n| twin(n)).collect();
        bars_of(noisy, rows, &others, scales).unwrap_or_default()
    };
    let terms = (shapes.owner.iter()).filter(|owner| outside.contains(owner));
    let asked = terms.count() * shapes.participation.ncols() <= limits::OUTSIDE_MOST;
    let (of_inside, of_outside) = rayon::join(
        || of_rows(&inside, &outside),
        || of_rows(if asked { &outside } else { &[] }, &inside),
    );
    let mut out = ShapeBars {
        shape: Array2::from_elem(shapes.shape.raw_dim(), f64::INFINITY),
        scale: vec![f64::INFINITY; scales.len()],
    };
    for (row, shape, scale) in of_inside.into_iter().chain(of_outside) {
        out.shape.row_mut(row).assign(&shape);
        out.scale[row] = scale;
    }
    out
}

/// Error bars of the terms `rows` beside the poles `others`; of those alone that the data
/// tell from what stays free.
fn bars_of(
    noisy: &Noisy,
    mut rows: Vec<usize>,
    others: &[Complex64],
    scales: &[Scale],
) -> Result<Vec<Bars>, LinalgError> {
    while !rows.is_empty() {
        let errors = ShapeErrors::new(noisy, &rows, others)?;
        let told: Vec<usize> = (0..rows.len())
            .filter(|&n| errors.lines.is_left(n))
            .map(|n| rows[n])
            .collect();
        if told.len() == rows.len() {
            return Ok(errors.all(&rows, scales));
        }
        rows = told;
    }
    Ok(Vec::new())
}

/// A term (its row), its deviations, and that of its scale.
type Bars = (usize, Array1<f64>, f64);

/// The ingredients of the error bars of some terms.
struct ShapeErrors {
    /// (term, response).
    shape: Array2<Complex64>,
    /// (term, reference), and what it was multiplied by to meet the columns of the lines.
    participation: Array2<Complex64>,
    unit: Vec<Complex64>,
    lines: LineProducts,
    groups: Vec<Group>,
    /// λ of each term; in the viscous law that of the structural twin.
    lambda: Vec<Complex64>,
    /// E|δλ|² as stated with the pole of each term.
    stated: Vec<f64>,
    /// DᴴP⊥D of free residues, (term, term).
    outside: Array2<Complex64>,
    /// Noise variance of a value, and what the terms see of it.
    variance: f64,
    noise: TermNoise,
    /// True where shapes and participations are real.
    real: bool,
    /// True where poles were found with their participations, not from free residues.
    joint: bool,
}

impl ShapeErrors {
    /// `rows`: the terms; `others`: the poles that are fitted freely beside them.
    fn new(noisy: &Noisy, rows: &[usize], others: &[Complex64]) -> Result<Self, LinalgError> {
        let Noisy {
            work,
            powers,
            poles,
            shapes,
            present,
            variance,
            noise,
            real,
        } = *noisy;
        let of_terms: Vec<&Pole> = rows.iter().map(|&row| &poles[shapes.owner[row]]).collect();
        let lambda: Vec<Complex64> = of_terms
            .iter()
            .map(|p| Complex64::new(1.0, p.loss_factor) * p.omega.powi(2))
            .collect();
        let variance_of = |p: &&Pole| {
            (2.0 * p.omega * p.omega_std).powi(2) + (p.omega.powi(2) * p.loss_factor_std).powi(2)
        };
        let stated = of_terms.iter().map(variance_of).collect();
        let joint = of_terms.iter().any(|pole| pole.given.is_some());
        let shape = shapes.shape.select(Axis(0), rows);
        let mut participation = shapes.participation.select(Axis(0), rows);
        let unit: Vec<Complex64> = of_terms
            .iter()
            .map(|pole| pole.residue_unit(work.law))
            .collect();
        for (mut row, unit) in participation.rows_mut().into_iter().zip(&unit) {
            row.mapv_inplace(|v| v * unit);
        }
        let lines = LineProducts::beside(work, &lambda, others, powers)?;
        let outside = lines.outside()?;
        let real = real && joint;
        let groups = Vec::new();
        let mut errors = Self {
            shape,
            participation,
            unit,
            lines,
            groups,
            lambda,
            stated,
            outside,
            variance,
            noise: noise.select(rows),
            real,
            joint,
        };
        errors.groups = alike(present)
            .into_iter()
            .map(|(kept, responses)| errors.group(kept, responses))
            .collect::<Result<_, _>>()?;
        Ok(errors)
    }

    fn group(&self, kept: Vec<bool>, responses: Vec<usize>) -> Result<Group, LinalgError> {
        let gram = |rows: &Array2<Complex64>, columns: &[usize]| {
            let part = rows.select(Axis(1), columns);
            matmul(part.mapv(|v| v.conj()).view(), part.t())
        };
        let references: Vec<usize> = (0..kept.len()).filter(|&j| kept[j]).collect();
        let along = gram(&self.participation, &references);
        let normal = (&self.lines.ff * &along).mapv(|v| taken(self.real, v));
        let normal = self.lines.regular(normal, |n| along[[n, n]].re);
        let unit = Array2::eye(normal.nrows());
        let across = gram(&self.shape, &responses);
        let gram_inverse = match references.is_empty() {
            true => Array2::zeros(normal.raw_dim()),
            false => answer(normal.view(), unit.view())?,
        };
        Ok(Group {
            responses,
            kept,
            along,
            across,
            gram_inverse,
        })
    }

    /// Error bars of the terms, which are `rows` of all.
    fn all(&self, rows: &[usize], scales: &[Scale]) -> Vec<Bars> {
        let clusters = overlapping(&self.lambda)
            .into_par_iter()
            .filter_map(|modes| self.of_cluster(modes, rows, scales).ok());
        clusters.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// Those of a cluster.
    fn of_cluster(
        &self,
        modes: Vec<usize>,
        rows: &[usize],
        scales: &[Scale],
    ) -> Result<Vec<Bars>, LinalgError> {
        // poles first: where they come from free residues they have a covariance of their
        // own
        let pivot = pivots(&self.participation);
        let references = self.participation.ncols();
        let mut unknowns = unknowns(&modes, &pivot, references, self.real);
        unknowns.sort_by_key(|unknown| unknown.other.is_some());
        let inside: Vec<Array2<Complex64>> = self
            .groups
            .iter()
            .map(|group| self.tangent(group).inside(&unknowns))
            .collect();
        let answers: Vec<Array2<Complex64>> = self
            .groups
            .iter()
            .zip(&inside)
            .map(|(group, inside)| matmul(group.gram_inverse.view(), inside.view()))
            .collect();
        let cluster = Cluster { modes, unknowns };
        let directions: Vec<Array2<Complex64>> = cluster
            .modes
            .iter()
            .flat_map(|&n| self.directions(n, &scales[rows[n]], &cluster, &answers))
            .collect();
        let all: Vec<_> = directions.iter().map(|columns| columns.view()).collect();
        let halves = self.halves(
            &cluster,
            &inside,
            &concatenate(Axis(1), &all).expect("as many unknowns"),
        )?;
        // (term, group) by turns, as they were stacked
        let spreads: Vec<Array2<Complex64>> = halves
            .axis_chunks_iter(Axis(1), cluster.modes.len() + 1)
            .map(|half| matmul_h(half, half))
            .collect();
        let of_term = |(&n, spreads): (&usize, &[Array2<Complex64>])| {
            let (shape, scale) = self.term(n, &scales[rows[n]], &cluster.modes, spreads);
            (rows[n], shape, scale)
        };
        Ok(cluster
            .modes
            .iter()
            .zip(spreads.chunks(self.groups.len()))
            .map(of_term)
            .collect())
    }

    fn tangent<'a>(&'a self, group: &'a Group) -> Tangent<'a> {
        Tangent {
            lines: &self.lines,
            participation: &self.participation,
            measured: &group.kept,
            along: &group.along,
            across: &group.across,
            gram_inverse: &group.gram_inverse,
            real: self.real,
        }
    }

    /// Variance of the part of complex noise that a shape value sees.
    fn seen_variance(&self) -> f64 {
        if self.real {
            0.5 * self.variance
        } else {
            self.variance
        }
    }

    /// Vᴴ·`columns`, where VVᴴ is the covariance of the unknowns of one cluster, poles
    /// first.
    fn halves(
        &self,
        cluster: &Cluster,
        inside: &[Array2<Complex64>],
        columns: &Array2<Complex64>,
    ) -> Result<Array2<Complex64>, LinalgError> {
        let Cluster { modes, unknowns } = cluster;
        let of_groups = self
            .groups
            .iter()
            .zip(inside)
            .map(|(group, inside)| self.tangent(group).information(unknowns, inside, 0.0));
        let information = of_groups.fold(
            Array2::zeros((unknowns.len(), unknowns.len()).f()),
            |sum, one| sum + one,
        );
        let deviation = self.seen_variance().sqrt();
        let noisy = self.noise.times(columns, unknowns);
        let idle = mixing(unknowns, &self.lambda, &self.participation);
        if self.joint && self.real {
            let [idle, information, noisy] =
                [idle, information, noisy].map(|all| all.mapv(|v| v.re));
            return Ok(
                inverse_root_beside(idle.view(), information.view(), noisy.view())?
                    .mapv(|v| (v * deviation).into()),
            );
        }
        if self.joint {
            return Ok(
                inverse_root_beside(idle.view(), information.view(), noisy.view())?
                    .mapv(|v| v * deviation),
            );
        }
        // poles came from free residues; participations follow them, and have an error of
        // their own besides
        let (of_poles, of_others) = columns.view().split_at(Axis(0), modes.len());
        let (of_all, of_own) = information
            .view()
            .split_at(Axis(0), modes.len())
            .1
            .split_at(Axis(1), modes.len());
        let idle = idle.slice(s![modes.len().., ..]);
        let both = concatenate(Axis(1), &[of_others, of_all]).expect("as many participations");
        let both = inverse_root_beside(idle, of_own, both.view())?;
        let (own, follow) = both.view().split_at(Axis(1), columns.ncols());
        let through = matmul(
            self.free_pole_root(modes)?.view(),
            (&of_poles - &matmul_h(follow, own)).view(),
        );
        // the way in which participations follow has no noise
        let own = match noisy == *columns {
            true => own.to_owned(),
            false => inverse_root_beside(idle, of_own, noisy.slice(s![modes.len().., ..]))?,
        };
        let own = own.mapv(|v| v * deviation);
        Ok(concatenate(Axis(0), &[through.view(), own.view()]).expect("as many directions"))
    }

    /// The same Vᴴ of E δλ_m δλ_n* of poles found from free residues: the correlations of
    /// (33), the sizes that the poles themselves state.
    fn free_pole_root(&self, cluster: &[usize]) -> Result<Array2<Complex64>, LinalgError> {
        let part = |a: &Array2<Complex64>| a.select(Axis(0), cluster).select(Axis(1), cluster);
        let none = Array2::zeros(self.outside.raw_dim());
        let products = self
            .groups
            .iter()
            .map(|group| &group.across * &group.along)
            .fold(none, |sum, one| sum + one);
        let information = part(&self.outside) * part(&products);
        let mut root = inverse_root(information.view(), Array2::eye(cluster.len()).view())?;
        for (mut column, &n) in root.columns_mut().into_iter().zip(cluster) {
            let size = (self.stated[n] / column.iter().map(|v| v.norm_sqr()).sum::<f64>()).sqrt();
            column.mapv_inplace(|v| v * finite(size));
        }
        Ok(root)
    }

    fn group_of(&self) -> Vec<usize> {
        let mut group_of = vec![0; self.shape.ncols()];
        self.groups
            .iter()
            .enumerate()
            .for_each(|(g, group)| group.responses.iter().for_each(|&i| group_of[i] = g));
        group_of
    }

    /// The directions that term `n` sees of the unknowns in each group, conjugate,
    /// (unknown, direction): a change of response i is Σ_m x_mi·(change along J of mode
    /// m) + x_ni·(change of the scale), few directions for all responses. `answers`: J of
    /// each group, (term, unknown).
    fn directions(
        &self,
        n: usize,
        scale: &Scale,
        cluster: &Cluster,
        answers: &[Array2<Complex64>],
    ) -> Vec<Array2<Complex64>> {
        let Cluster { modes, unknowns } = cluster;
        let (x, group_of) = (&self.shape, self.group_of());
        // relative change of the scale per unknown
        let along = |a: usize| {
            let own = |&&(j, _): &&(usize, Complex64)| {
                unknowns[a].mode == n && unknowns[a].other == Some(j)
            };
            let direct: Complex64 = scale.reference.iter().filter(own).map(|(_, c)| *c).sum();
            let direct = direct / self.unit[n];
            let shift = |d: usize| -answers[group_of[d]][[n, a]] * x[[unknowns[a].mode, d]];
            taken(
                self.real,
                direct
                    + scale
                        .response
                        .iter()
                        .map(|&(d, weight)| weight * shift(d))
                        .sum::<Complex64>(),
            )
        };
        let of_group = |answer: &Array2<Complex64>| {
            let seen = |(a, direction): (usize, usize)| match modes.get(direction) {
                Some(mode) if *mode == unknowns[a].mode => -taken(self.real, answer[[n, a]]).conj(),
                Some(_) => Complex64::ZERO,
                None => along(a).conj(),
            };
            Array2::from_shape_fn((unknowns.len(), modes.len() + 1), seen)
        };
        answers.iter().map(of_group).collect()
    }

    /// The deviations of term `n`, and that of its scale; `spreads`: covariance of its
    /// [`Self::directions`] in each group.
    fn term(
        &self,
        n: usize,
        scale: &Scale,
        modes: &[usize],
        spreads: &[Array2<Complex64>],
    ) -> (Array1<f64>, f64) {
        let (x, group_of) = (&self.shape, self.group_of());
        let noise = |i: usize| {
            self.groups[group_of[i]].gram_inverse[[n, n]].re
                * self.seen_variance()
                * self.noise.response[[n, i]]
        };
        let scale_noise: f64 = scale
            .response
            .iter()
            .map(|&(d, weight)| weight.norm_sqr() * noise(d))
            .sum();
        let of_unknowns = spreads
            .first()
            .map_or(0.0, |spread| spread[[modes.len(), modes.len()]].re);
        let scale_variance = (scale_noise + of_unknowns).max(0.0);
        let beyond_first_order = scale.second_order(scale_variance) * scale_variance;
        let of_response = |i: usize| {
            if !self.groups[group_of[i]].kept.contains(&true) {
                return f64::INFINITY;
            }
            let part = |row: usize| x[[modes.get(row).copied().unwrap_or(n), i]];
            let spread = &spreads[group_of[i]];
            let through: f64 = spread
                .indexed_iter()
                .map(|((a, b), v)| (part(a) * v * part(b).conj()).re)
                .sum();
            let shared: f64 = scale
                .response
                .iter()
                .filter(|(d, _)| *d == i)
                .map(|(_, weight)| 2.0 * (x[[n, i]] * weight).re)
                .sum();
            let own = noise(i) * (1.0 + shared)
                + x[[n, i]].norm_sqr() * (scale_noise + beyond_first_order);
            scale.factor.norm() * (own + through).max(0.0).sqrt()
        };
        (
            (0..x.ncols()).map(of_response).collect(),
            scale_variance.sqrt(),
        )
    }
}

/// Terms that overlap, and what they were found by.
struct Cluster {
    modes: Vec<usize>,
    unknowns: Vec<Unknown>,
}
