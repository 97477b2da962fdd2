//! The known word that a misspelt one may stand for.

use crate::limits::LONGEST;
use strsim::levenshtein;

/// The known word that `word` may stand for: one that begins with it (a name without its
/// unit or extension), else the one with the fewest letters to change, insert or delete
/// (Levenshtein 1966); the first of equals, `None` where none is known.
pub fn nearest_word<'w>(word: &str, known: &[&'w str]) -> Option<&'w str> {
    known
        .iter()
        .min_by_key(|candidate| (!candidate.starts_with(word), edits(word, candidate)))
        .copied()
}

/// True where `near` is close enough to `word` to be asked about.
pub(crate) fn is_near(word: &str, near: &str) -> bool {
    near.starts_with(word) || 3 * edits(word, near) <= word.chars().count()
}

/// Letters to change, insert or delete, of the first [`LONGEST`].
fn edits(a: &str, b: &str) -> usize {
    let start = |word: &str| word.chars().take(LONGEST).collect::<String>();
    levenshtein(&start(a), &start(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_its_unit_is_near_and_another_word_is_not() {
        assert_eq!(
            nearest_word("transition", &["grid", "transitions", "transition_m"]),
            Some("transitions")
        );
        assert_eq!(
            nearest_word("thicknes_m", &["length_m", "thickness_m"]),
            Some("thickness_m")
        );
        assert_eq!(nearest_word("x", &[]), None);
        assert!(
            is_near("pannel.h5", "panel.h5")
                && is_near("panel", "panel.h5")
                && !is_near("nowhere.uff", "panel.uff")
        );
    }
}
