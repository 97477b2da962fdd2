//! Loads on the panel as parts of a structured update: fingers that stay, masses.
//!
//! A load at x changes the mobility by −b·y_x·h_xᵀ: y_x is the mobility from x to the
//! responses, h_x that from the actuators to x, b = Z/(1 + Z·Y_xx). Its place is the one of
//! the largest evidence over what gains and poles explain. With c the two whitened columns
//! of b, J those of the other unknowns, Σ their posterior covariance, r the whitened
//! residual at the most probable gains and poles and D the prior of b,
//!
//! ln BF = ½ uᵀ(G + D⁻¹)⁻¹u − ½ ln det(I + DG), G = cᵀc − cᵀJΣJᵀc, u = cᵀr.

use super::diagnosis::grid;
use super::evidence::Posterior;
use super::parts::Parts;
use super::seen::Seen;
use crate::interpolation::Nodes;
use crate::modal_field::ModalField;
use crate::operator::Operator;
use crate::plane::{Position, Rectangle};
use crate::problem::Drive;
use crate::tolerances;
use chladni_frf::ModalModel;
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// The ground on which a load may sit.
pub(crate) struct LoadPlaces {
    nodes: Nodes,
    around: Rectangle,
    /// Mobility from every response to every other.
    between: Array2<Complex64>,
}

/// A load that may be there.
pub(super) struct LoadFound {
    /// Its part of the mobility, per N·s/m.
    pub(super) share: Array2<Complex64>,
    /// Number of places that were tried.
    pub(super) alternatives: f64,
}

impl LoadPlaces {
    /// Over the responses of `operator`; `None` where they carry no area.
    pub(super) fn new(model: &ModalModel, operator: &Operator) -> Option<Self> {
        let still = Drive::zeros(operator.references.len());
        Some(Self {
            nodes: Nodes::new(&operator.positions_m)?,
            around: Rectangle::around(&operator.positions_m)?,
            between: ModalField::new(model, operator, &still).between_responses(),
        })
    }
}

impl Parts {
    /// The same with one load more.
    pub(super) fn with_load(&self, share: Array2<Complex64>) -> Self {
        let mut with = self.clone();
        with.loads.push(share);
        with
    }

    /// The likeliest place of a load over a grid, then over finer ones around it.
    pub(super) fn likeliest_load(&self, best: &Posterior, fields: &[Seen]) -> Option<LoadFound> {
        let ground = self.places.as_ref()?;
        let moved = self.moved(&best.theta);
        let mut step_m = tolerances::LOAD_GRID_M;
        let mut places = grid(ground.around, step_m);
        let mut tried = places.len();
        let mut found: Option<(f64, Position, Array2<Complex64>)> = None;
        for _ in 0..tolerances::LOAD_GRIDS {
            let onto = ground.nodes.onto(&places)?;
            let from = onto.apply(ground.between.view());
            let to = onto.apply(moved.view());
            let evidence = self.evidence_of_loads(best, fields, &from, &to)?;
            let likeliest = evidence
                .iter()
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(b.1))
                .map(|(x, &evidence)| (evidence, x))?;
            if found.as_ref().is_none_or(|known| likeliest.0 > known.0) {
                let (evidence, x) = likeliest;
                let [y, h] = [from.row(x), to.row(x)].map(|row| row.insert_axis(Axis(0)));
                found = Some((evidence, places[x], -y.t().dot(&h)));
            }
            let (_, [x, y], _) = found.as_ref()?;
            let near = Rectangle {
                x_min: ground.around.x_min.max(x - step_m),
                y_min: ground.around.y_min.max(y - step_m),
                x_max: ground.around.x_max.min(x + step_m),
                y_max: ground.around.y_max.min(y + step_m),
            };
            step_m /= tolerances::LOAD_FINER;
            places = grid(near, step_m);
            tried += places.len();
        }
        found.map(|(_, _, share)| LoadFound {
            share,
            alternatives: tried as f64,
        })
    }

    /// ln of the evidence of a load at each place, by the mobilities `from` and `to` there.
    fn evidence_of_loads(
        &self,
        best: &Posterior,
        fields: &[Seen],
        from: &Array2<Complex64>,
        to: &Array2<Complex64>,
    ) -> Option<Vec<f64>> {
        let count = from.nrows();
        let mut own = vec![[[0.0; 2]; 2]; count];
        let mut toward = vec![[0.0; 2]; count];
        let mut through = Array2::<f64>::zeros((self.unknowns(), 2 * count));
        for seen in fields {
            let (field, slope) = self.field(&best.theta, &seen.drive);
            let variance = self.variance(seen, best.scales.unexplained);
            let left = seen.left(&field, variance);
            let rows = seen.stacked(&slope, &field, variance);
            let played: Drive = (0..self.actuators())
                .map(|i| seen.drive[i] * self.gain(&best.theta, i))
                .collect();
            let under: Array1<Complex64> = to.dot(&played);
            let changes = Array2::from_shape_fn((from.ncols(), 2 * count), |(row, c)| {
                let turn = [Complex64::ONE, Complex64::I][c % 2];
                -from[[c / 2, row]] * under[c / 2] * turn
            });
            let columns = seen.stacked(&changes, &field, variance);
            through += &chladni_linalg::matmul(rows.t(), columns.view());
            for x in 0..count {
                let pair = [2 * x, 2 * x + 1].map(|c| columns.column(c));
                for a in 0..2 {
                    toward[x][a] += pair[a].dot(&left);
                    for b in 0..2 {
                        own[x][a][b] += pair[a].dot(&pair[b]);
                    }
                }
            }
        }
        let explained = chladni_linalg::matmul(best.covariance.view(), through.view());
        let prior = 0.5 * tolerances::LOAD_IMPEDANCE.powi(2);
        let evidence = (0..count).map(|x| {
            let g = |a: usize, b: usize| {
                own[x][a][b] - through.column(2 * x + a).dot(&explained.column(2 * x + b))
            };
            let [m00, m01, m11] = [g(0, 0) + 1.0 / prior, g(0, 1), g(1, 1) + 1.0 / prior];
            let det = m00 * m11 - m01 * m01;
            let [u, v] = toward[x];
            let quadratic = (m11 * u * u - 2.0 * m01 * u * v + m00 * v * v) / det;
            0.5 * (quadratic - (det * prior * prior).ln())
        });
        let evidence: Vec<f64> = evidence.collect();
        evidence
            .iter()
            .all(|value| value.is_finite())
            .then_some(evidence)
    }
}
