//! Conic programs by the interior-point method of `clarabel`, which proves what has no
//! solution: the judge of programs that the steps of
//! [`interior_point`](super::interior_point) do not finish.

use super::cones::Cone;
use super::program::{ConicProgram, ConicSolution};
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Result};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Solves `program`; `None` where it has no solution, or none that the solver's own checks
/// pass.
///
/// # Errors
/// [`ErrorKind::Internal`] where the program is malformed: a bug.
pub(super) fn solve(program: &ConicProgram) -> Result<Option<ConicSolution>> {
    let columns = program.objective.len();
    let matrix = matrix(program);
    let right: Vec<f64> = program.rows.iter().map(|row| row.constant).collect();
    let cones: Vec<SupportedConeT<f64>> = program
        .cones
        .iter()
        .map(|cone| match cone {
            Cone::NotNegative(rows) => SupportedConeT::NonnegativeConeT(rows.len()),
            Cone::Norm(rows) => SupportedConeT::SecondOrderConeT(rows.len()),
        })
        .collect();
    let settings = DefaultSettings {
        verbose: false,
        max_threads: 1,
        max_iter: tolerances::CONIC_STEPS,
        tol_gap_abs: tolerances::CONIC_GAP,
        tol_gap_rel: tolerances::CONIC_GAP,
        tol_feas: tolerances::CONIC_GAP,
        iterative_refinement_reltol: tolerances::CONIC_REFINEMENT,
        iterative_refinement_abstol: tolerances::CONIC_REFINEMENT,
        ..DefaultSettings::default()
    };
    let quadratic = CscMatrix::zeros((columns, columns));
    let mut solver = DefaultSolver::new(
        &quadratic,
        &program.objective,
        &matrix,
        &right,
        &cones,
        settings,
    )
    .map_err(|error| {
        Error::new(
            ErrorKind::Internal,
            format!("malformed conic program: {error}"),
        )
    })?;
    solver.solve();
    let usable = matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved
    );
    let finite = solver.solution.x.iter().all(|value| value.is_finite());
    Ok((usable && finite).then(|| ConicSolution {
        x: std::mem::take(&mut solver.solution.x),
    }))
}

/// The negative coefficients of the rows: b − A·x must lie in the cones.
fn matrix(program: &ConicProgram) -> CscMatrix {
    let columns = program.objective.len();
    let mut by_column: Vec<Vec<(usize, f64)>> = vec![Vec::new(); columns];
    for (row, expression) in program.rows.iter().enumerate() {
        for &(column, coefficient) in &expression.terms {
            by_column[column].push((row, -coefficient));
        }
    }
    let mut starts = vec![0];
    let (mut places, mut values) = (Vec::new(), Vec::new());
    for column in &by_column {
        places.extend(column.iter().map(|entry| entry.0));
        values.extend(column.iter().map(|entry| entry.1));
        starts.push(places.len());
    }
    CscMatrix::new(program.rows.len(), columns, starts, places, values)
}
