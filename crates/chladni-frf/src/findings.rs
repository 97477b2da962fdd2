//! The findings of a result, as its file holds them.

use crate::finding::{warnings, Finding};
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// Findings in the order they were made. Files hold them twice: `findings`, and in
/// `warnings` the sentences of cautions and faults for readers that know no codes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "FindingLists", into = "FindingLists")]
pub struct Findings(pub Vec<Finding>);

#[derive(Serialize, Deserialize)]
struct FindingLists {
    warnings: Vec<String>,
    findings: Option<Vec<Finding>>,
}

impl Findings {
    /// The sentences of cautions and faults, several of one code in one.
    pub fn warnings(&self) -> Vec<String> {
        warnings(self)
    }
}

impl Deref for Findings {
    type Target = Vec<Finding>;
    fn deref(&self) -> &Vec<Finding> {
        &self.0
    }
}

impl DerefMut for Findings {
    fn deref_mut(&mut self) -> &mut Vec<Finding> {
        &mut self.0
    }
}

impl From<Vec<Finding>> for Findings {
    fn from(findings: Vec<Finding>) -> Self {
        Self(findings)
    }
}

/// Files of earlier versions hold sentences alone.
impl From<FindingLists> for Findings {
    fn from(lists: FindingLists) -> Self {
        let uncoded = || lists.warnings.into_iter().map(Finding::from).collect();
        Self(lists.findings.unwrap_or_else(uncoded))
    }
}

impl From<Findings> for FindingLists {
    fn from(findings: Findings) -> Self {
        Self {
            warnings: findings.warnings(),
            findings: Some(findings.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_holds_findings_and_the_sentences_of_those_that_matter() {
        let findings = Findings(vec![
            Finding::note("a-note", "good to know"),
            Finding::caution("a-caution", "look here").value("share", 0.5),
        ]);
        let json = serde_json::to_value(&findings).unwrap();
        assert_eq!(json["warnings"], serde_json::json!(["look here"]));
        assert_eq!(serde_json::from_value::<Findings>(json).unwrap(), findings);
        let old: Findings = serde_json::from_str(r#"{"warnings": ["old words"]}"#).unwrap();
        assert_eq!(old.warnings(), ["old words"]);
    }
}
