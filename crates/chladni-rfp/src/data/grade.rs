//! Grades of poles. Files hold a grade as the list [trust, reasons].

use chladni_frf::{Reason, Trust};
use serde::{Deserialize, Serialize};

/// Grade of one pole with its reasons.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stored", into = "Stored")]
pub(crate) struct Grade {
    pub trust: Trust,
    pub reasons: Vec<Reason>,
}

/// A grade as files hold it.
type Stored = (Trust, Vec<Reason>);

impl Grade {
    /// Sure, without reasons.
    pub const SURE: Self = Self {
        trust: Trust::Sure,
        reasons: Vec::new(),
    };

    /// Weak for one reason.
    pub fn weak(reason: Reason) -> Self {
        Self {
            trust: Trust::Weak,
            reasons: vec![reason],
        }
    }

    /// Rejected for one reason.
    pub fn rejected(reason: Reason) -> Self {
        Self {
            trust: Trust::Rejected,
            reasons: vec![reason],
        }
    }
}

impl From<Stored> for Grade {
    fn from((trust, reasons): Stored) -> Self {
        Self { trust, reasons }
    }
}

impl From<Grade> for Stored {
    fn from(grade: Grade) -> Self {
        (grade.trust, grade.reasons)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_a_list_of_trust_and_reasons() {
        let grade = Grade::weak(Reason::new("faint", "hardly shows"));
        let text = serde_json::to_string(&[&grade]).unwrap();
        let list: Vec<Stored> = serde_json::from_str(&text).unwrap();
        assert_eq!(list, [(grade.trust, grade.reasons.clone())]);
        assert_eq!(serde_json::from_str::<Vec<Grade>>(&text).unwrap(), [grade]);
    }
}
