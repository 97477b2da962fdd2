//! Choice of the method: one by name, or one along the front of speed against accuracy.

use crate::methods::effort::Effort;
use crate::methods::method::Method;
use crate::methods::solution::Solution;
use crate::problems::problem::Problem;
use crate::problems::setup::Setup;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Finding, ModalModel, Result};
use std::fmt;
use std::str::FromStr;

/// The choice of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum MethodChoice {
    /// `robust`; `mls` where that would take more than about a second and is not needed.
    #[default]
    Default,
    /// `pressure-matching`: below a millisecond.
    Fast,
    /// `robust` from every start that leads somewhere, and the certified ceiling beside
    /// it.
    Best,
    /// This method.
    Only(Method),
}

/// The method that will run.
pub(crate) struct Decision {
    pub(crate) method: Method,
    /// Its effort.
    pub(crate) effort: Effort,
    /// True where a quicker method runs because the problem is large: a scene that it
    /// leaves unmet is tried again by `robust`.
    pub(crate) quick: bool,
}

impl Decision {
    /// The drive, with the method that found it; the solution tells why it is not what the
    /// user might expect.
    pub(crate) fn run(
        &self,
        setup: &Setup,
        model: &ModalModel,
        cut: Option<f64>,
    ) -> Result<(Method, Solution)> {
        let unmet = |solution: &Solution| setup.problem.score(&solution.drive).min_ratio < 1.0;
        let mut solution = self.method.solve(setup, model, self.effort, cut)?;
        if !self.quick {
            return Ok((self.method, solution));
        }
        if unmet(&solution) {
            let thorough = Method::Robust.solve(setup, model, self.effort, cut)?;
            let [before, now] = [&solution, &thorough]
                .map(|solution| setup.problem.score(&solution.drive).min_ratio);
            if now >= before {
                return Ok((Method::Robust, thorough));
            }
        }
        let size = setup.problem.rows.mobility.dim();
        let words = format!(
            "method `{}` ran: {} responses for {} actuators would take `robust` more than about a \
             second",
            self.method, size.0, size.1
        );
        solution.findings.insert(
            0,
            Finding::note("quicker-method", words).help("ask for method `robust` if you can wait"),
        );
        Ok((self.method, solution))
    }
}

impl MethodChoice {
    const WORDS: [(&'static str, Self); 3] = [
        ("default", Self::Default),
        ("fast", Self::Fast),
        ("best", Self::Best),
    ];

    /// Every name on the command line, the default first.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::WORDS
            .iter()
            .map(|word| word.0)
            .chain(Method::ALL.map(Method::as_str))
    }

    /// The method for a problem of this size, and its effort where `effort` was asked
    /// for.
    pub(crate) fn decide(self, problem: &Problem, effort: Effort) -> Decision {
        let decision = |method| Decision {
            method,
            effort,
            quick: false,
        };
        match self {
            Self::Only(method) => decision(method),
            Self::Fast => decision(Method::PressureMatching),
            Self::Best => {
                let starts = effort.starts.max(tolerances::MOST_STARTS);
                Decision {
                    effort: Effort { starts, ..effort },
                    ..decision(Method::Robust)
                }
            }
            Self::Default => {
                let rows = problem.rows.mobility.nrows();
                let size = rows as f64 * (problem.rows.mobility.ncols() as f64).powi(2);
                if size <= tolerances::ROBUST_SIZE {
                    return decision(Method::Robust);
                }
                Decision {
                    quick: true,
                    ..decision(Method::Mls)
                }
            }
        }
    }
}

impl From<Method> for MethodChoice {
    fn from(method: Method) -> Self {
        Self::Only(method)
    }
}

impl fmt::Display for MethodChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Only(method) => method.fmt(f),
            word => f.write_str(
                Self::WORDS
                    .iter()
                    .find(|known| known.1 == *word)
                    .map_or("", |known| known.0),
            ),
        }
    }
}

impl FromStr for Method {
    type Err = Error;
    /// The names of [`Method::ALL`].
    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|method| method.as_str() == text)
            .ok_or_else(|| {
                let known: Vec<&str> = MethodChoice::names().collect();
                Error::new(ErrorKind::Usage, "no such rendering method")
                    .field("method")
                    .found(text)
                    .expected(known.join(", "))
            })
    }
}

impl FromStr for MethodChoice {
    type Err = Error;
    /// `default`, `fast`, `best`, or the name of a method.
    fn from_str(text: &str) -> Result<Self> {
        match Self::WORDS.iter().find(|word| word.0 == text) {
            Some(word) => Ok(word.1),
            None => text.parse().map(Self::Only),
        }
    }
}
