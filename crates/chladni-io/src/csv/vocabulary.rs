//! Words that headers are made of, in the languages and spellings of analysers and
//! scripts.

/// The part of an FRF that a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Part {
    Re,
    Im,
    Magnitude,
    Phase,
    Coherence,
    /// The header does not say.
    Unknown,
}

const PARTS: [(Part, &[&str]); 5] = [
    (Part::Re, &["re", "real", "realpart", "realteil"]),
    (
        Part::Im,
        &[
            "im",
            "imag",
            "imaginary",
            "imagpart",
            "imaginarypart",
            "imaginärteil",
        ],
    ),
    (
        Part::Phase,
        &[
            "phase", "phas", "ph", "phi", "φ", "angle", "∠", "arg", "winkel",
        ],
    ),
    (
        Part::Coherence,
        &["coherence", "coh", "gamma", "γ", "kohärenz"],
    ),
    (
        Part::Magnitude,
        &[
            "mag",
            "magn",
            "magnitude",
            "abs",
            "absolute",
            "amp",
            "ampl",
            "amplitude",
            "modulus",
            "betrag",
            "gain",
            "level",
        ],
    ),
];
/// Words for a magnitude on a logarithmic scale.
const DECIBEL: [&str; 6] = ["db", "decibel", "decibels", "log", "log10", "20log10"];
/// Words for the square of a magnitude.
const SQUARED: [&str; 7] = [
    "squared",
    "square",
    "power",
    "psd",
    "quadrat",
    "betragsquadrat",
    "magsq",
];
/// Names that a frequency axis goes by.
const FREQUENCY: [&str; 15] = [
    "f",
    "fr",
    "freq",
    "freqs",
    "frequency",
    "frequencies",
    "frequenz",
    "frequence",
    "fréquence",
    "frecuencia",
    "frequenza",
    "frq",
    "faxis",
    "x",
    "hz",
];
/// Words of a header that say nothing: `Real part of the FRF`.
const FILLERS: [&str; 11] = [
    "part",
    "of",
    "the",
    "in",
    "axis",
    "value",
    "values",
    "component",
    "lin",
    "linear",
    "unit",
];

/// The part that a word names; numbers behind it count nothing (`re1`).
pub(super) fn part_of(word: &str) -> Option<Part> {
    let letters = word
        .trim_end_matches(|c: char| c.is_ascii_digit() || c == '²')
        .to_lowercase();
    PARTS
        .iter()
        .find(|(_, names)| names.contains(&letters.as_str()))
        .map(|(part, _)| *part)
        .or_else(|| is_decibel(word).then_some(Part::Magnitude))
}

/// True for a word that says decibels or another logarithm.
pub(super) fn is_decibel(word: &str) -> bool {
    DECIBEL.contains(&word.to_lowercase().as_str())
}

/// True for a word that says a square, or its sign behind a magnitude: `|H|²`, `mag^2`; the
/// square of a unit, m/s², is none.
pub(super) fn is_squared(text: &str) -> bool {
    let of_magnitude = |before: &str| {
        let word = words(before).last().unwrap_or_default().to_lowercase();
        before.ends_with(['|', ')'])
            || before.ends_with(char::is_alphanumeric) && part_of(&word) == Some(Part::Magnitude)
    };
    ["^2", "**2", "²"]
        .iter()
        .flat_map(|sign| text.match_indices(sign))
        .any(|(place, _)| of_magnitude(&text[..place]))
        || words(text).any(|word| SQUARED.contains(&word.to_lowercase().as_str()))
}

/// True for a name of a frequency axis, in lower case.
pub(super) fn is_frequency(word: &str) -> bool {
    FREQUENCY.contains(&word)
}

/// The name of a frequency that a word begins with, and the rest: `fkHz`.
pub(super) fn after_frequency(word: &str) -> Option<&str> {
    let lower = word.to_lowercase();
    FREQUENCY
        .iter()
        .filter(|name| lower.starts_with(*name))
        .max_by_key(|name| name.len())
        .and_then(|name| word.get(name.len()..))
        .filter(|rest| !rest.is_empty())
}

/// True for a word that says nothing, in lower case.
pub(super) fn is_filler(word: &str) -> bool {
    FILLERS.contains(&word)
}

/// Words of a text: runs of letters, digits and the signs of units and angles.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || "°º²∠".contains(c)))
        .filter(|word| !word.is_empty())
}

/// Number of words of the trade in a line: two or more make it a header.
pub(super) fn known_words(text: &str) -> usize {
    words(text)
        .filter(|word| part_of(word).is_some() || is_frequency(&word.to_lowercase()))
        .count()
}
