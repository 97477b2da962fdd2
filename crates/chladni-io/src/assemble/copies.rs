//! Files of the same content among those that hold FRFs.

use super::record::Record;
use crate::{Document, Duplicates};
use chladni_frf::{Checksum, Dof, Finding, Source};
use std::collections::{HashMap, HashSet};

/// The finding about files of FRFs with the content of another one.
pub fn same_files(sources: &[Source]) -> Option<Finding> {
    let words = format!(
        "{}: FRFs kept from both count as two measurements, and error bars are too small",
        Source::copies(sources)?
    );
    Some(Finding::caution("same-files", words).help("leave copies out"))
}

/// The same where `duplicates` may say which FRFs are kept: a note where none of a copy is kept
/// beside that of its original.
pub(super) fn told_copies(
    sources: &[Source],
    duplicates: Duplicates,
    records: &[Record],
    originals: &[usize],
) -> Option<Finding> {
    let finding = same_files(sources)?;
    let one_is_kept = matches!(duplicates, Duplicates::First | Duplicates::Last);
    if !(one_is_kept && have_pairs_of_originals(records, originals)) {
        return Some(finding);
    }
    let words = format!("{}: one FRF of each pair is kept", Source::copies(sources)?);
    Some(Finding::note("same-files", words))
}

/// For each document the number of the first one of the same content.
pub(super) fn originals(documents: &[Document]) -> Vec<usize> {
    let mut first: HashMap<&Checksum, usize> = HashMap::new();
    documents
        .iter()
        .enumerate()
        .map(|(number, document)| match &document.checksum {
            Some(checksum) => *first.entry(checksum).or_insert(number),
            None => number,
        })
        .collect()
}

/// True where each FRF of a copy has the DOFs of one of its original.
fn have_pairs_of_originals(records: &[Record], originals: &[usize]) -> bool {
    let pair = |record: &Record| {
        let original = originals.get(record.document).copied();
        (
            original.unwrap_or(record.document),
            record.response,
            record.reference,
        )
    };
    let of_documents: HashSet<(usize, Dof, Dof)> = records
        .iter()
        .map(|record| (record.document, record.response, record.reference))
        .collect();
    records
        .iter()
        .all(|record| of_documents.contains(&pair(record)))
}

/// Places of the first two of some records whose files are copies of each other.
pub(super) fn copies_among(records: &[Record], originals: &[usize]) -> Option<[usize; 2]> {
    let original = |place: usize| originals.get(records[place].document).copied();
    (1..records.len()).find_map(|later| {
        let is_copied = |&earlier: &usize| {
            let known = original(earlier);
            records[earlier].document != records[later].document
                && known.is_some()
                && known == original(later)
        };
        let earlier = (0..later).find(is_copied)?;
        Some([earlier, later])
    })
}
