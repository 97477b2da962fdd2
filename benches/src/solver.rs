//! The registry: every method of identification and of rendering under one name and one
//! kind, over the back end that was built in.

use chladni_render::MethodChoice;
use chladni_rfp::Method;
use std::fmt;

/// The task of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// From FRFs to modes.
    Identify(Method),
    /// From modes and a scene to a drive.
    Render(MethodChoice),
}

impl Solver {
    /// Names of all methods: those of identification, then those of rendering, each
    /// kind's default first. No name stands for both.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Method::ALL
            .into_iter()
            .map(Method::as_str)
            .chain(MethodChoice::names())
    }

    /// All methods in the order of their names.
    pub fn all() -> Vec<Self> {
        Self::names().filter_map(Self::named).collect()
    }

    /// The method of that name.
    pub fn named(name: &str) -> Option<Self> {
        name.parse()
            .map(Self::Identify)
            .or_else(|_| name.parse().map(Self::Render))
            .ok()
    }

    /// True for what `fit` and `render` take unless told otherwise.
    pub fn is_default(self) -> bool {
        self == Self::Identify(Method::default()) || self == Self::Render(MethodChoice::default())
    }

    /// It identifies.
    pub fn identifies(self) -> bool {
        matches!(self, Self::Identify(_))
    }

    /// The linear algebra below it.
    pub fn backend(self) -> &'static str {
        chladni_linalg::BACKEND
    }
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Identify(method) => method.fmt(f),
            Self::Render(method) => method.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_are_complete_and_names_are_unique() {
        let all = Solver::all();
        let rendering = all.iter().filter(|solver| !solver.identifies()).count();
        assert!(all.len() - rendering >= 9 && rendering >= 8, "{all:?}");
        assert!(
            all.iter()
                .all(|solver| Solver::named(&solver.to_string()) == Some(*solver)),
            "{all:?}"
        );
        assert_eq!(
            all.iter()
                .filter(|solver| solver.is_default())
                .map(ToString::to_string)
                .collect::<Vec<_>>(),
            ["auto", "default"]
        );
    }
}
