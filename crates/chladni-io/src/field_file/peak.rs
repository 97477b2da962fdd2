//! The words after the unit of a field: whether its values are peaks.
//!
//! A word for peak changes nothing, and neither does a remark in brackets, as long as it
//! names no other measure of an amplitude. `rms` alone is known, too: a sine has √2 of it
//! for peak. Nothing else is guessed.

use std::f64::consts::SQRT_2;

const BRACKETS: [char; 6] = ['(', '[', '{', ')', ']', '}'];
const BETWEEN_WORDS: [char; 5] = [' ', '\t', ',', ';', ':'];

/// Words for peak, as [`letters`].
const PEAK: [&str; 14] = [
    "peak",
    "pk",
    "amplitude",
    "0p",
    "zerop",
    "peakvalues",
    "0peak",
    "0pk",
    "0topeak",
    "0topk",
    "zeropeak",
    "zeropk",
    "zerotopeak",
    "zerotopk",
];
/// Words for other measures, likewise.
const OTHER: [&str; 13] = [
    "rms",
    "eff",
    "effective",
    "pp",
    "p2p",
    "ptp",
    "ptop",
    "pkpk",
    "pk2pk",
    "pktopk",
    "peakpeak",
    "peak2peak",
    "peaktopeak",
];
/// Words for levels.
const LEVEL: [&str; 5] = ["db", "decibel", "decibels", "dbv", "dbmps"];
/// Other measures in several words.
const OTHER_IN_WORDS: [&str; 3] = ["peaktopeak", "pktopk", "pkpk"];

/// The factor to peak values that `said`, all that follows the unit, asks for.
///
/// # Errors
/// The word that is not understood, or that names another measure.
pub(super) fn factor_to_peak(said: &str) -> Result<f64, &str> {
    let words = words(said);
    if matches!(words[..], [(word, _)] if letters(word) == "rms") {
        return Ok(SQRT_2);
    }
    let all = letters(said);
    if OTHER_IN_WORDS.iter().any(|&other| all.contains(other)) {
        return Err(said.trim());
    }
    for (word, in_brackets) in words {
        let is_harmless = match in_brackets {
            true => !names_other(word),
            false => PEAK.contains(&letters(word).as_str()),
        };
        if !is_harmless {
            return Err(word);
        }
    }
    Ok(1.0)
}

/// The words of a text, each with true where it stands in brackets.
fn words(text: &str) -> Vec<(&str, bool)> {
    let (mut words, mut depth) = (Vec::new(), 0usize);
    for piece in text.split_inclusive(BRACKETS) {
        let inside = piece.strip_suffix(BRACKETS).unwrap_or(piece);
        for word in inside.split(BETWEEN_WORDS).filter(|word| !word.is_empty()) {
            words.push((word, depth > 0));
        }
        if piece.ends_with(['(', '[', '{']) {
            depth += 1;
        } else if piece.ends_with([')', ']', '}']) {
            depth = depth.saturating_sub(1);
        }
    }
    words
}

/// True for a word that names another measure than peak, whole or in part (`pk-pk`,
/// `r.m.s.`, `mm/s-rms`).
fn names_other(word: &str) -> bool {
    let parts = word.split(|c: char| !c.is_alphanumeric());
    parts
        .map(letters)
        .chain([letters(word)])
        .any(|part| OTHER.contains(&part.as_str()) || LEVEL.contains(&part.as_str()))
}

/// Letters and digits alone, small.
fn letters(text: &str) -> String {
    text.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_for_peak_and_harmless_remarks_change_nothing() {
        for said in [
            "",
            "peak",
            "(peak)",
            "[peak]",
            "  pk",
            "0-pk",
            "0-p",
            "zero-to-peak",
            "amplitude",
            "Peak amplitude",
            "(velocity, along +Z)",
            "                      (or mm/s, um/s; peak; phase as e^{+jωt} against the drive signal)",
        ] {
            assert_eq!(factor_to_peak(said), Ok(1.0), "{said}");
        }
        for said in ["rms", "(rms)", "[RMS]", "r.m.s."] {
            assert_eq!(factor_to_peak(said), Ok(SQRT_2), "{said}");
        }
    }

    #[test]
    fn other_measures_and_unknown_words_are_refused_by_name() {
        for (said, word) in [
            ("peak-to-peak", "peak-to-peak"),
            ("(peak to peak)", "(peak to peak)"),
            ("pk-pk", "pk-pk"),
            ("(pk/pk)", "(pk/pk)"),
            ("p-p", "p-p"),
            ("[pp]", "pp"),
            ("dB", "dB"),
            ("(dB re 1)", "dB"),
            ("(decibel)", "decibel"),
            ("effective", "effective"),
            ("rms peak", "rms"),
            ("(peak; noise 1e-6 rms)", "rms"),
            ("(as mm/s-rms", "mm/s-rms"),
            ("/ N", "/"),
            ("furlongs", "furlongs"),
        ] {
            assert_eq!(factor_to_peak(said), Err(word), "{said}");
        }
    }
}
