//! Text that a terminal shows and does not obey, and counts in words.

/// A count with its noun: `1 mode`, `2 modes`.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Text for a terminal: control characters, which it would obey, and marks that turn the
/// direction of writing around are escaped, but for those in `kept`.
pub fn printable(text: &str, kept: &[char]) -> String {
    let is_obeyed = |c: char| {
        let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        (c.is_control() || turns) && !kept.contains(&c)
    };
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_obeyed(c) {
            true => shown.extend(c.escape_unicode()),
            false => shown.push(c),
        }
    }
    shown
}
