//! The words after the unit of a field, which tell peak values from others.
//!
//! A word for peak changes nothing, and neither does a remark in brackets, as long as it
//! names no other measure of an amplitude. `rms` alone is understood, too: the peak of a
//! sine is √2 times its rms value. Nothing else is guessed.

use std::f64::consts::SQRT_2;

const BRACKETS: [char; 6] = ['(', '[', '{', ')', ']', '}'];
const BETWEEN_WORDS: [char; 5] = [' ', '\t', ',', ';', ':'];

/// Words for peak, as [`letters`] gives them.
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
/// Words for other measures, as [`letters`] gives them.
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

/// The factor to peak values, by the text after the unit.
///
/// # Errors
/// The word that is not understood, or that names another measure.
pub(super) fn factor_to_peak(after_unit: &str) -> Result<f64, &str> {
    let words = words(after_unit);
    if matches!(&words[..], [word] if letters(word.text) == "rms") {
        return Ok(SQRT_2);
    }
    let all = letters(after_unit);
    if OTHER_IN_WORDS.iter().any(|&other| all.contains(other)) {
        return Err(after_unit.trim());
    }
    for word in words {
        let is_harmless = match word.in_brackets {
            true => !names_other(word.text),
            false => PEAK.contains(&letters(word.text).as_str()),
        };
        if !is_harmless {
            return Err(word.text);
        }
    }
    Ok(1.0)
}

/// A word of a text.
struct Word<'t> {
    text: &'t str,
    in_brackets: bool,
}

fn words(text: &str) -> Vec<Word<'_>> {
    let (mut words, mut depth) = (Vec::new(), 0usize);
    for piece in text.split_inclusive(BRACKETS) {
        let inside = piece.strip_suffix(BRACKETS).unwrap_or(piece);
        let texts = inside.split(BETWEEN_WORDS).filter(|text| !text.is_empty());
        words.extend(texts.map(|text| Word {
            text,
            in_brackets: depth > 0,
        }));
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

/// The letters and digits of a text, in lower case.
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
