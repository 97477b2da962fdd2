//! DOFs of a foreign file: the lists of them beside the FRFs, else by position.

use super::super::tree::{Element, Entry, Values};
use super::super::values::wrong_type;
use super::{is_characters, length, Reader};
use chladni_frf::{Direction, Dof, Error, Finding, Result};

/// The words for the DOFs of one side of the FRFs.
pub(super) struct SideWords {
    /// Key in the caller's map, and word in messages.
    key: &'static str,
    /// Names of the list of DOFs.
    names: [&'static str; 5],
    /// Direction of a DOF that the file does not give one.
    direction: Direction,
}

pub(super) const RESPONSE: SideWords = SideWords {
    key: "response",
    names: [
        "response",
        "responses",
        "response_dof",
        "response_node",
        "output",
    ],
    direction: Direction::PLUS_Z,
};
pub(super) const REFERENCE: SideWords = SideWords {
    key: "reference",
    names: [
        "reference",
        "references",
        "reference_dof",
        "reference_node",
        "input",
    ],
    direction: Direction::SCALAR,
};

impl SideWords {
    /// True for an entry beside the FRFs with one of the names.
    fn is_beside(&self, entry: &Entry, frf: &Entry) -> bool {
        entry.folder() == frf.folder() && self.is_name(entry.name())
    }
    fn is_name(&self, name: &str) -> bool {
        (self.names.iter()).any(|known| name.eq_ignore_ascii_case(known))
    }
}

/// True for a name of a list of DOFs.
pub(super) fn is_name(name: &str) -> bool {
    RESPONSE.is_name(name) || REFERENCE.is_name(name)
}

impl<'a> Reader<'a> {
    /// Number of DOFs in the list beside the FRFs, where there is one.
    pub(super) fn dof_list(
        &self,
        side: &SideWords,
        frf: &Entry,
        lines: usize,
    ) -> Result<Option<usize>> {
        let is_list = |entry: &&Entry| match entry.element() {
            Some(Element::Text | Element::Dof | Element::Integer) => true,
            // a list of node numbers, not a level, spectrum or time record
            Some(Element::Real { .. }) => {
                let count = length(entry);
                count > 1
                    && count != lines
                    && frf.shape().contains(&count)
                    && (self.file.read(entry)).is_ok_and(|values| node_numbers(&values).is_some())
            }
            _ => false,
        };
        let beside = |entry: &&Entry| side.is_beside(entry, frf);
        let mapped = self.mapped(side.key)?;
        let found = mapped.or_else(|| self.datasets().filter(beside).find(is_list));
        Ok(found.map(length))
    }

    /// The dataset of DOFs: the mapped one, else one of that name and length beside the
    /// FRFs.
    pub(super) fn dof_entry(
        &self,
        side: &SideWords,
        frf: &Entry,
        count: usize,
    ) -> Result<Option<&'a Entry>> {
        let fits = |entry: &&Entry| side.is_beside(entry, frf) && length(entry) == count;
        let mapped = self.mapped(side.key)?;
        Ok(mapped.or_else(|| self.datasets().find(fits)))
    }

    /// DOFs of a dataset, else numbered by position.
    pub(super) fn dofs(
        &self,
        side: &SideWords,
        entry: Option<&Entry>,
        count: usize,
        warnings: &mut Vec<Finding>,
    ) -> Result<Vec<Dof>> {
        let (key, direction) = (side.key, side.direction);
        let Some(entry) = entry else {
            if self.options.dofs.rows.is_empty() {
                let named = match count {
                    1 => format!("1:{direction}"),
                    _ => format!("1:{direction} ... {count}:{direction}"),
                };
                warnings.push(Finding::caution(
                    "dofs-assumed",
                    format!("the file names no {key} DOFs; they are numbered {named}"),
                ));
            }
            let nodes = 1..=count as u64;
            return Ok(nodes.map(|node| Dof::new(node, direction)).collect());
        };
        let dofs = self.read_dofs(entry, direction, warnings)?;
        if dofs.len() != count {
            return Err(Error::bad_data("sizes disagree")
                .field(&entry.path)
                .found(dofs.len())
                .expected(format!("{count}, as long as the {key} axis of the FRFs")));
        }
        Ok(dofs)
    }

    /// DOFs of a dataset; node numbers get `direction`.
    fn read_dofs(
        &self,
        entry: &Entry,
        direction: Direction,
        warnings: &mut Vec<Finding>,
    ) -> Result<Vec<Dof>> {
        let values = match self.file.read(entry)? {
            _ if is_characters(entry) => Values::Text(self.texts(entry)?),
            values => values,
        };
        if let Some(nodes) = node_numbers(&values) {
            warnings.push(Finding::caution(
                "dofs-assumed",
                format!(
                    "{}: node numbers without a direction; {direction} is assumed",
                    entry.path
                ),
            ));
            let dof = |&node: &u64| Dof::new(node, direction);
            return Ok(nodes.iter().map(dof).collect());
        }
        match values {
            Values::Dofs(dofs) => Ok(dofs),
            Values::Text(texts) => {
                let dof = |text: &String| {
                    text.parse().map_err(|message: String| {
                        Error::bad_word(&message, text)
                            .field(&entry.path)
                            .help("write DOFs like 12:+Z, or whole node numbers")
                    })
                };
                texts.iter().map(dof).collect()
            }
            _ => Err(wrong_type(
                entry,
                "DOF texts like 12:+Z, whole node numbers or records {node, dir}",
            )),
        }
    }
}

/// Node numbers: whole numbers, not negative, of any type.
fn node_numbers(values: &Values<'_>) -> Option<Vec<u64>> {
    let whole = |value: f64| Some(value as u64).filter(|&node| node as f64 == value);
    match values {
        Values::Unsigned(nodes) => Some(nodes.to_vec()),
        Values::Signed(nodes) => nodes.iter().map(|&node| u64::try_from(node).ok()).collect(),
        Values::Real64(nodes) => nodes.iter().map(|&node| whole(node)).collect(),
        Values::Real32(nodes) => nodes.iter().map(|&node| whole(node.into())).collect(),
        _ => None,
    }
}
