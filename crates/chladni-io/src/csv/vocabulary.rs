//! The words of headers, in the languages and spellings of analysers and scripts.

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
/// The side of an FRF to which a DOF belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Response,
    Reference,
}

const ROLES: [(Role, &[&str]); 2] = [
    (
        Role::Response,
        &["response", "resp", "rsp", "output", "to", "antwort"],
    ),
    (
        Role::Reference,
        &[
            "reference",
            "ref",
            "excitation",
            "exc",
            "input",
            "force",
            "from",
            "referenz",
            "anregung",
        ],
    ),
];
/// A word before a response that has other meanings too: `relative to`, `due to`.
pub(super) const TO: &str = "to";
/// Words of a role that come before their DOF, never after it.
const IN_FRONT: [&str; 5] = [TO, "from", "ref", "reference", "referenz"];
/// Words beside a number of seconds or repetitions: `5s record`, `10x avg`.
const MEASUREMENT: [&str; 21] = [
    "record",
    "records",
    "rec",
    "recording",
    "avg",
    "avgs",
    "average",
    "averages",
    "averaged",
    "averaging",
    "mean",
    "window",
    "block",
    "blocks",
    "sweep",
    "sweeps",
    "duration",
    "length",
    "zoom",
    "time",
    "t",
];
/// Words beside a DOF: `H1 of point 1x`.
const PLACES: [&str; 12] = [
    "h", "h1", "h2", "hv", "frf", "point", "pt", "node", "dof", "at", "channel", "ch",
];
/// Signs before a part that negate it: `-Im`.
pub(super) const MINUS: [char; 3] = ['-', '\u{2212}', '\u{2013}'];
/// Words before a part that negate it.
pub(super) const NEGATIVE: [&str; 3] = ["negative", "neg", "minus"];
/// A word beside a phase that negates it.
pub(super) const LAG: &str = "lag";
/// Words for a magnitude on a logarithmic scale.
const DECIBEL: [&str; 9] = [
    "db", "decibel", "decibels", "log", "log10", "20log10", "ln", "neper", "nepers",
];
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
/// Names of a frequency axis.
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
/// Names of an angular frequency, which need their unit.
pub(super) const ANGULAR: [&str; 3] = ["omega", "ω", "w"];
/// Words of a header without information: `Real part of the FRF`.
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

/// The part that a word names; a number after it is ignored (`re1`).
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

/// True for a word for decibels or another logarithm.
pub(super) fn is_decibel(word: &str) -> bool {
    DECIBEL.contains(&word.to_lowercase().as_str())
}

/// True for a text with a word for a square, or with its sign after a magnitude (`|H|²`,
/// `mag^2`), but not after a unit (m/s²).
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

/// The rest of a word after the name of a frequency: `kHz` of `fkHz`.
pub(super) fn after_frequency(word: &str) -> Option<&str> {
    let lower = word.to_lowercase();
    FREQUENCY
        .iter()
        .filter(|name| lower.starts_with(*name))
        .max_by_key(|name| name.len())
        .and_then(|name| word.get(name.len()..))
        .filter(|rest| !rest.is_empty())
}

/// The side that the first word of a text names. Text after `/` or `per` belongs to the unit
/// of a ratio: `velocity/force`.
pub(super) fn role_of(text: &str) -> Option<Role> {
    let first = words(text).next().filter(|_| !text.starts_with('/'))?;
    let lower = first.to_lowercase();
    ROLES
        .iter()
        .find(|(_, names)| names.contains(&lower.as_str()))
        .map(|(role, _)| *role)
}

/// True for a word of a role, in lower case, that comes before its DOF.
pub(super) fn is_in_front(word: &str) -> bool {
    IN_FRONT.contains(&word)
}

/// True for a word about the measurement, in lower case.
pub(super) fn is_measurement(word: &str) -> bool {
    MEASUREMENT.contains(&word)
}

/// True for a word that describes nothing but the DOF beside it, in lower case.
pub(super) fn is_beside_dof(word: &str) -> bool {
    PLACES.contains(&word) || role_of(word).is_some()
}

/// True for a word without information, in lower case.
pub(super) fn is_filler(word: &str) -> bool {
    FILLERS.contains(&word)
}

/// Words of a text: runs of letters, digits and the signs of units and angles.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || "°º²∠".contains(c)))
        .filter(|word| !word.is_empty())
}

/// Number of known words in a line: two or more make it a header.
pub(super) fn known_words(text: &str) -> usize {
    words(text)
        .filter(|word| part_of(word).is_some() || is_frequency(&word.to_lowercase()))
        .count()
}
