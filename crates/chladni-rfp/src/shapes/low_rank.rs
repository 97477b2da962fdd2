//! Shapes and participations of all poles at once (theory.md, eq. 18–19).

use crate::data::information::answer;
use crate::poles::pole::Given;
use crate::shapes::acceleration::Acceleration;
use crate::shapes::alternation::{Halves, Problem};
use crate::shapes::limits;
use crate::shapes::residues::{ridge, strongest, Residues};
use chladni_linalg::blocked::blocked_matmul;
use chladni_linalg::{matmul, LinalgError};
use ndarray::{Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Shapes and participations of all poles.
#[derive(Debug, Clone)]
pub(crate) struct Shapes {
    /// Pole of each row.
    pub owner: Vec<usize>,
    /// (mode, response).
    pub shape: Array2<Complex64>,
    /// (mode, reference).
    pub participation: Array2<Complex64>,
    /// Rise of the sum of squares over free residues.
    pub rise: f64,
    /// Number of real constraints that the rank-one form sets on free residues.
    pub constraints: usize,
}

/// Fits R_n = Σ ψ·Lᵀ to all poles at once, with `ranks[n]` terms for pole n (one for a
/// mode; more for a repeated pole, or for an out-of-band pole that stands for several
/// modes). The result has one row per term, poles in order.
pub(crate) fn low_rank(residues: &Residues, ranks: &[usize]) -> Result<Shapes, LinalgError> {
    let (poles, (responses, references)) = (residues.values.nrows(), residues.present.dim());
    let owner: Vec<usize> = (0..poles)
        .flat_map(|n| std::iter::repeat_n(n, ranks[n]))
        .collect();
    let (mut shape, mut participation) = (
        Array2::zeros((owner.len(), responses).f()),
        Array2::zeros((owner.len(), references).f()),
    );
    let start = |n: usize| strongest(&residues.of_pole(n), ranks[n]);
    let starts = (0..poles)
        .into_par_iter()
        .map(start)
        .collect::<Result<Vec<_>, LinalgError>>()?;
    for (row, (own, other)) in starts.into_iter().flatten().enumerate() {
        shape.row_mut(row).assign(&own);
        participation.row_mut(row).assign(&other);
    }
    balance(&mut shape, &mut participation);
    let problem = Problem::new(residues, &owner);
    let mut rise = 0.0;
    if !owner.is_empty() && (references > 1 || residues.present.iter().any(|p| !p)) {
        let halves = Halves::new(&problem);
        let (mut from, mut acceleration) = (participation.clone(), Acceleration::default());
        let mut before = f64::MAX;
        for _ in 0..limits::RANK_ONE_ITERATIONS {
            let mut next = halves.shapes(&from)?;
            let (mut made, explained) = halves.participations(&next)?;
            balance(&mut next, &mut made);
            // of exact data the difference of two sums is rounding
            let known = halves.total - explained;
            let risen = if known > limits::RANK_ONE_KNOWN * halves.total {
                known
            } else {
                problem.misfit(&next, &made)
            };
            let change =
                limits::RANK_ONE_CHANGE * risen.max(limits::RANK_ONE_ROUNDING * halves.total);
            if risen > before + change {
                // too far: on from the best, one step at a time
                acceleration = Acceleration::default();
                from.assign(&participation);
                before = f64::MAX;
                continue;
            }
            (shape, participation, rise) = (next, made, risen);
            if before - rise <= change {
                break;
            }
            before = rise;
            from = acceleration.next(&from, &participation);
        }
    }
    Ok(Shapes {
        constraints: constraints(residues, &owner),
        owner,
        shape,
        participation,
        rise,
    })
}

/// Residues of which those of some poles have their shapes given, and the others are fitted
/// around them.
pub(crate) struct AroundGiven<'a> {
    residues: &'a Residues<'a>,
    given: &'a [&'a Given],
    /// The poles whose shapes are not given.
    open: Vec<usize>,
    /// Free residues of these, and their weight; `None` where there are none, or none is given.
    freed: Option<(Array2<Complex64>, Array2<Complex64>)>,
}

impl<'a> AroundGiven<'a> {
    /// `given`: of each pole.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(residues: &'a Residues<'a>, given: &'a [&'a Given]) -> Result<Self, LinalgError> {
        let open: Vec<usize> = (0..given.len()).filter(|&n| given[n].is_none()).collect();
        let freed = match open.is_empty() || open.len() == given.len() {
            true => None,
            false => Some(freed(residues, &open, given)?),
        };
        Ok(Self {
            residues,
            given,
            open,
            freed,
        })
    }

    /// As [`low_rank`], `ranks[n]` terms for pole n where its shapes are not given.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn shapes(&self, ranks: &[usize]) -> Result<Shapes, LinalgError> {
        let Self {
            residues,
            given,
            open,
            freed,
        } = self;
        if open.len() == given.len() {
            return low_rank(residues, ranks);
        }
        let fitted = match freed {
            None => None,
            Some((values, weight)) => {
                let ranks: Vec<usize> = open.iter().map(|&n| ranks[n]).collect();
                let present = residues.present;
                let freed = Residues {
                    values,
                    weight,
                    present,
                };
                Some(low_rank(&freed, &ranks)?)
            }
        };
        // pole, shape and participation of each row
        let mut rows = Vec::new();
        for n in 0..given.len() {
            if let Some((shape, participation)) = given[n] {
                let terms = shape.rows().into_iter().zip(participation.rows());
                rows.extend(terms.map(|(shape, participation)| (n, shape, participation)));
            } else if let Some(fitted) = &fitted {
                let terms = (0..fitted.owner.len()).filter(|&row| open[fitted.owner[row]] == n);
                rows.extend(
                    terms.map(|row| (n, fitted.shape.row(row), fitted.participation.row(row))),
                );
            }
        }
        let (responses, references) = residues.present.dim();
        let mut shape = Array2::zeros((rows.len(), responses));
        let mut participation = Array2::zeros((rows.len(), references));
        for (row, (_, of_responses, of_references)) in rows.iter().enumerate() {
            shape.row_mut(row).assign(of_responses);
            participation.row_mut(row).assign(of_references);
        }
        let owner: Vec<usize> = rows.iter().map(|row| row.0).collect();
        drop(fitted);
        let rise = Problem::new(residues, &owner).misfit(&shape, &participation);
        Ok(Shapes {
            constraints: constraints(residues, &owner),
            owner,
            shape,
            participation,
            rise,
        })
    }
}

/// Free residues of the `open` poles where those of the others are as given, and their
/// weight.
fn freed(
    residues: &Residues,
    open: &[usize],
    given: &[&Given],
) -> Result<(Array2<Complex64>, Array2<Complex64>), LinalgError> {
    let (poles, references) = (given.len(), residues.present.ncols());
    let closed: Vec<usize> = (0..poles).filter(|&n| given[n].is_some()).collect();
    let part = |rows: &[usize], columns: &[usize]| {
        residues
            .weight
            .select(Axis(0), rows)
            .select(Axis(1), columns)
    };
    let own = part(open, open);
    // what the open residues follow a change of the closed ones by
    let follow = answer(ridge(&own).view(), part(open, &closed).view())?;
    let mut mixing = Array2::zeros((open.len(), poles));
    for (row, &n) in open.iter().enumerate() {
        mixing[[row, n]] = Complex64::ONE;
        for (c, &n) in closed.iter().enumerate() {
            mixing[[row, n]] = follow[[row, c]];
        }
    }
    let mut moved = blocked_matmul(mixing.view(), residues.values.view());
    for (mut values, follow) in moved.rows_mut().into_iter().zip(follow.rows()) {
        let mut of_given = Array2::zeros(residues.present.raw_dim());
        for (&n, &follow) in closed.iter().zip(follow) {
            if let Some((shape, participation)) = given[n] {
                of_given += &matmul(shape.mapv(|v| follow * v).t(), participation.view());
            }
        }
        for (l, value) in values.iter_mut().enumerate() {
            let at = [l / references, l % references];
            *value = match residues.present[at] {
                true => *value - of_given[at],
                false => Complex64::ZERO,
            };
        }
    }
    Ok((moved, own))
}

/// Real constraints that rows of low rank set on free residues.
pub(crate) fn constraints(residues: &Residues, owner: &[usize]) -> usize {
    let (poles, (responses, references)) = (residues.values.nrows(), residues.present.dim());
    let present = residues.present.iter().filter(|p| **p).count();
    let rank = |n: usize| owner.iter().filter(|&&m| m == n).count();
    let used: usize = (0..poles)
        .map(|n| rank(n) * (responses + references - rank(n).min(responses + references)))
        .sum();
    (2 * poles * present).saturating_sub(2 * used)
}

/// Equal norms of both factors: keeps the alternation away from overflow.
pub(crate) fn balance(shape: &mut Array2<Complex64>, participation: &mut Array2<Complex64>) {
    for (mut s, mut p) in shape.rows_mut().into_iter().zip(participation.rows_mut()) {
        let norm =
            |v: ndarray::ArrayView1<Complex64>| v.iter().map(|c| c.norm_sqr()).sum::<f64>().sqrt();
        let (a, b) = (norm(s.view()), norm(p.view()));
        if a > 0.0 && b > 0.0 {
            let factor = (b / a).sqrt();
            s.mapv_inplace(|v| v * factor);
            p.mapv_inplace(|v| v / factor);
        }
    }
}
