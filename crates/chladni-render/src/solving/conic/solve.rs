//! The solver of a conic program: dense steps, and `clarabel` where they lead nowhere.

use super::interior_point::{self, Outcome};
use super::program::{ConicProgram, ConicSolution};
use super::sparse;
use chladni_frf::Result;

impl ConicProgram {
    /// Solves the program; `None` where it has no solution, or none that the solvers' own
    /// checks pass.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Internal`] where the program is malformed: a bug.
    pub(crate) fn solve(&self) -> Result<Option<ConicSolution>> {
        match interior_point::solve(&self.standard_form()) {
            Outcome::Solved(x) => Ok(Some(ConicSolution { x })),
            Outcome::Impossible => Ok(None),
            Outcome::Unsure => sparse::solve(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cones::Cones;
    use super::super::program::Affine;
    use super::*;
    use num_complex::Complex64;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_nearest_point_of_a_line_is_found() {
        // least t ≥ ‖(x, y)‖ on x + y ≥ 2: (1, 1), t = √2
        let mut program = ConicProgram::new(3);
        program.minimise(2, 1.0);
        program.not_negative(Affine::of(0, 1.0).plus(1, 1.0).plus_constant(-2.0));
        program.norm_at_most(Affine::of(2, 1.0), [Affine::of(0, 1.0), Affine::of(1, 1.0)]);
        let x = program.solve().unwrap().expect("a solution").x;
        for (found, expected) in x.iter().zip([1.0, 1.0, 2f64.sqrt()]) {
            assert!((found - expected).abs() < 1e-6, "{x:?}");
        }
    }

    #[test]
    fn what_cannot_be_met_has_no_solution() {
        let mut program = ConicProgram::new(1);
        program.not_negative(Affine::of(0, 1.0).plus_constant(-1.0));
        program.not_negative(Affine::of(0, -1.0));
        assert!(program.solve().unwrap().is_none());
    }

    /// Least ‖x‖ with rows that must reach far and complex ones that must stay small, both
    /// kept by a point drawn before.
    fn drawn(random: &mut ChaCha8Rng) -> ConicProgram {
        const VARIABLES: usize = 12;
        let mut draw = || random.random_range(-1.0..1.0);
        let known: Vec<f64> = (0..VARIABLES).map(|_| draw()).collect();
        let mut row = || {
            let terms = (0..VARIABLES).map(|k| (k, draw())).collect();
            Affine {
                terms,
                constant: 0.0,
            }
        };
        let mut program = ConicProgram::new(VARIABLES + 1);
        program.minimise(VARIABLES, 1.0);
        for _ in 0..20 {
            let hot = row();
            let least = hot.at(&known) - 0.1;
            program.not_negative(hot.plus_constant(-least));
            let cold = [row(), row()];
            let most = cold[0].at(&known).hypot(cold[1].at(&known)) + 0.1;
            program.norm_at_most(Affine::default().plus_constant(most), cold);
        }
        let every = (0..VARIABLES).map(|k| Affine::of(k, 1.0));
        program.norm_at_most(Affine::of(VARIABLES, 1.0), every);
        program
    }

    #[test]
    fn dense_steps_and_clarabel_find_the_same_least_cost() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for number in 0..100 {
            let program = drawn(&mut random);
            let Outcome::Solved(x) = interior_point::solve(&program.standard_form()) else {
                panic!("program {number}: the dense steps do not end");
            };
            let judge = sparse::solve(&program).unwrap().expect("a solution").x;
            let (found, expected) = (x[x.len() - 1], judge[judge.len() - 1]);
            assert!(
                (found - expected).abs() < 1e-6 * expected.max(1.0),
                "program {number}: {found}, clarabel {expected}"
            );
            let inside = program
                .rows
                .iter()
                .map(|row| row.at(&x))
                .collect::<Vec<_>>();
            let least = Cones(program.cones.clone()).least_eigenvalue(&inside);
            assert!(least > -1e-6, "program {number}: {least} outside the cones");
        }
    }

    #[test]
    fn a_complex_row_is_a_real_and_an_imaginary_one() {
        let row = ndarray::array![Complex64::new(1.0, 2.0), Complex64::new(0.0, -1.0)];
        let x = [3.0, 4.0, 5.0, 6.0];
        let expected: Complex64 =
            row[0] * Complex64::new(3.0, 5.0) + row[1] * Complex64::new(4.0, 6.0);
        let value = |part: &Affine| part.terms.iter().map(|&(i, c)| c * x[i]).sum::<f64>();
        let [re, im] = Affine::complex_row(row.view());
        assert_eq!((value(&re), value(&im)), (expected.re, expected.im));
    }
}
