//! The DOFs among the words of a name, and which of them is the response.

use super::vocabulary::{role_of, Role};
use chladni_frf::Dof;

/// Response and reference that a name gives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Dofs {
    pub(super) response: Option<Dof>,
    pub(super) reference: Option<Dof>,
    /// Words and order do not tell which is which.
    pub(super) is_unclear: bool,
}

impl Dofs {
    pub(super) fn is_empty(&self) -> bool {
        self.response.is_none() && self.reference.is_none()
    }
    fn pair(response: Dof, reference: Dof) -> Self {
        Self {
            response: Some(response),
            reference: Some(reference),
            is_unclear: false,
        }
    }
    fn swapped(self) -> Self {
        Self {
            response: self.reference,
            reference: self.response,
            ..self
        }
    }
}

/// The words of a name that tell its DOFs, in their order.
#[derive(Default)]
pub(super) struct DofWords(Vec<Word>);

#[derive(Clone, Copy, PartialEq)]
enum Word {
    Role(Role),
    One(Dof, Spelling),
    Pair(Dof, Dof),
}

/// The trust in a word such as `1z`.
#[derive(Clone, Copy, PartialEq)]
enum Spelling {
    Firm,
    /// Lower case, as nothing else is written: `1z`.
    Lower,
    /// Lower case, as seconds and multiples are written too: `5s`, `10x`.
    Loose,
}

impl DofWords {
    /// Adds a word of a name; true where it is a DOF. The lower side of a ratio is a unit,
    /// not the word of a DOF: `velocity per force`.
    pub(super) fn add(&mut self, token: &str, is_below: bool) -> bool {
        let role = role_of(token).filter(|_| !is_below);
        self.0.extend(role.map(Word::Role));
        let dofs = match dof_pair(token) {
            Some((one, None)) => Word::One(one, spelling(token)),
            Some((response, Some(reference))) => Word::Pair(response, reference),
            None => {
                // `1Z/Force` of `Velocity 1Z/Force 101Z`
                if let Some((left, right)) = token.split_once('/') {
                    if let Some((one, None)) = dof_pair(left) {
                        self.0.push(Word::One(one, spelling(left)));
                        self.0.extend(role_of(right).map(Word::Role));
                    }
                }
                return false;
            }
        };
        self.0.push(dofs);
        true
    }

    /// Takes out what describes a measurement: `5s record`, `10x avg`.
    pub(super) fn drop_loose(&mut self) {
        let lower = |word: &Word| matches!(word, Word::One(_, Spelling::Lower));
        if !self.0.iter().any(lower) {
            let is_loose = |word: &Word| matches!(word, Word::One(_, Spelling::Loose));
            self.0.retain(|word| !is_loose(word));
        }
    }

    /// The DOFs: those of a pair, else by the words in front of each or behind it, else
    /// the response first.
    pub(super) fn dofs(&self) -> Dofs {
        let pair = self.0.iter().enumerate().find_map(|(at, word)| match word {
            Word::Pair(response, reference) => Some((at, Dofs::pair(*response, *reference))),
            _ => None,
        });
        if let Some((at, dofs)) = pair {
            // `ref/rsp 101Z/1Z`
            let is_unclear = self.0[..at].first() == Some(&Word::Role(Role::Reference));
            return Dofs { is_unclear, ..dofs };
        }
        match self.with_roles().as_slice() {
            [] => Dofs::default(),
            [(one, roles)] => {
                let dofs = Dofs {
                    response: Some(*one),
                    ..Dofs::default()
                };
                match roles.last() {
                    Some(Role::Reference) => dofs.swapped(),
                    _ => dofs,
                }
            }
            [(first, roles), (second, others), ..] => {
                let (one, is_unclear) = match (roles.as_slice(), others.is_empty()) {
                    // the words stand in front of both
                    ([Role::Reference, rest @ ..], true) => {
                        (Some(&Role::Reference), rest.contains(&Role::Response))
                    }
                    (roles, true) => (roles.first(), false),
                    (roles, false) => (roles.last(), false),
                };
                let dofs = Dofs::pair(*first, *second);
                let dofs = Dofs { is_unclear, ..dofs };
                match (one, others.last()) {
                    (Some(Role::Reference), Some(Role::Reference)) => Dofs {
                        is_unclear: true,
                        ..dofs
                    },
                    (Some(Role::Reference), _) | (None, Some(Role::Response)) => dofs.swapped(),
                    _ => dofs,
                }
            }
        }
    }

    /// Each single DOF with the words in front of it, or behind it where all words stand
    /// so: `1Z output 101Z input`.
    fn with_roles(&self) -> Vec<(Dof, Vec<Role>)> {
        use Word::{One, Role as Says};
        let are_behind = matches!(self.0[..], [One(..), Says(_), One(..), Says(_)]);
        let mut words = self.0.clone();
        if are_behind {
            words.reverse();
        }
        let (mut named, mut roles) = (Vec::new(), Vec::new());
        for word in words {
            match word {
                Says(role) => roles.push(role),
                One(dof, _) => named.push((dof, std::mem::take(&mut roles))),
                Word::Pair(..) => {}
            }
        }
        if are_behind {
            named.reverse();
        }
        named
    }
}

fn spelling(token: &str) -> Spelling {
    let letters = token.trim_start_matches(|c: char| c.is_ascii_digit());
    match letters {
        "s" | "x" => Spelling::Loose,
        _ if letters.bytes().all(|byte| byte.is_ascii_lowercase()) => Spelling::Lower,
        _ => Spelling::Firm,
    }
}

/// A response and perhaps its reference: `12:+Z`, `1Z:3Z`, `12:+Z:101:+Z`,
/// `12:+Z/101:+Z`.
pub(super) fn dof_pair(text: &str) -> Option<(Dof, Option<Dof>)> {
    let text = text.trim();
    if !text.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    if let Ok(dof) = text.parse() {
        return Some((dof, None));
    }
    text.match_indices([':', '/']).find_map(|(at, _)| {
        let response = text[..at].parse().ok()?;
        Some((response, Some(text[at + 1..].parse().ok()?)))
    })
}

#[cfg(test)]
mod tests {
    use super::super::head::Head;

    fn show(name: &str) -> String {
        let dofs = Head::parse(name, "").dofs;
        if dofs.is_unclear {
            return "unclear".into();
        }
        let text = |dof: Option<chladni_frf::Dof>| dof.map_or("-".into(), |dof| dof.to_string());
        format!("{} {}", text(dofs.response), text(dofs.reference))
    }

    #[test]
    fn dofs_in_headers() {
        for (name, dofs) in [
            ("1Z:3Z [2]", "1:+Z 3:+Z"),
            ("Re(12:-Z:101:+Z)", "12:-Z 101:+Z"),
            ("12:+Z_re", "12:+Z -"),
            ("re_1Z_3Z", "1:+Z 3:+Z"),
            ("Re(x)", "- -"),
        ] {
            assert_eq!(show(name), dofs, "{name}");
        }
    }

    #[test]
    fn words_tell_the_response_from_the_reference() {
        for name in [
            "Re 1Z 101Z",
            "Ref 101:+Z Rsp 1:+Z Re",
            "Re from 101Z to 1Z",
            "Re 101Z to 1Z",
            "Response 1Z Force 101Z Re",
            "Re response 1Z to force 101Z",
            "Re response 1Z to 101Z",
            "1Z output 101Z input Re",
            "101Z input 1Z output Re",
            "ref:101:+Z rsp:1:+Z re",
            "Exc=101Z, Rsp=1Z, Re",
            "Excitation 101Z 1Z Re",
            "Frequency response 1Z 101Z Re",
            "Re velocity/force 1Z/101Z",
            "Velocity 1Z/Force 101Z Re",
            "Re Ref 101:+Z/Rsp 1:+Z",
            "Re velocity per force 1Z 101Z",
            "Frequency response 1Z/101Z Re",
            "Output/Input 1Z/101Z Re",
            "Force response 101Z/1Z Re",
        ] {
            let expected = match name.contains("Force response") {
                true => "unclear",
                false => "1:+Z 101:+Z",
            };
            assert_eq!(show(name), expected, "{name}");
        }
        assert_eq!(show("Ref 101Z Re"), "- 101:+Z");
        assert_eq!(show("Re velocity/force 1Z"), "1:+Z -");
    }

    #[test]
    fn seconds_and_multiples_are_no_dofs() {
        for name in ["Re 5s record", "Re 10x avg", "Re T=5s"] {
            assert_eq!(show(name), "- -", "{name}");
        }
        assert_eq!(show("Re 12Z 5s record"), "12:+Z -");
        for name in ["re 1x", "H1 1x re", "re_1x", "Re(1x)", "1X of the plate re"] {
            assert_eq!(show(name), "1:+X -", "{name}");
        }
        assert_eq!(show("plate 1x 3z re"), "1:+X 3:+Z");
        assert_eq!(show("plate 1z re"), "1:+Z -");
        assert_eq!(show("p12 re"), "- -");
    }
}
