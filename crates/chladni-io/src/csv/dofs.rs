//! The DOFs among the words of a name, and their roles: response or reference.

use super::vocabulary::{is_in_front, is_measurement, role_of, words, Role, TO};
use chladni_frf::Dof;

/// Response and reference that a name gives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Dofs {
    pub(super) response: Option<Dof>,
    pub(super) reference: Option<Dof>,
    /// True where neither words nor order tell response from reference.
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

/// The words of a name that are DOFs or name their roles, in their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct DofWords {
    words: Vec<Word>,
    /// True where the last word was another one.
    is_behind_other: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Word {
    Role(Role, Place),
    One(Dof, Spelling),
    Pair(Dof, Dof),
}

/// The place where the word of a role may stand beside its DOF.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    InFront,
    /// In front or behind: `response 1Z`, `1Z response`.
    Either,
}

/// The spelling of a DOF, from the surest to the least sure.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Spelling {
    Firm,
    /// Lower case, and nothing but a DOF: `1z`.
    Lower,
    /// Lower case, and perhaps seconds or a multiple: `5s`, `10x`.
    Loose,
}

impl DofWords {
    /// Adds a word of a name; returns true where it is a DOF. A word after `/` or `per`
    /// (`is_below`) is a unit and names no role: `velocity per force`.
    pub(super) fn add(&mut self, token: &str, is_below: bool) -> bool {
        let is_behind_other = std::mem::replace(&mut self.is_behind_other, true);
        let first = words(token).next().unwrap_or_default().to_lowercase();
        self.drop_measured(&first);
        let role = role_of(token).filter(|_| !(is_below || first == TO && is_behind_other));
        let place = match is_in_front(&first) {
            true => Place::InFront,
            false => Place::Either,
        };
        self.words.extend(role.map(|role| Word::Role(role, place)));
        let dofs = match dof_pair(token) {
            Some((one, None)) => Word::One(one, spelling(token)),
            Some((response, Some(reference))) => Word::Pair(response, reference),
            None => {
                // `1Z/Force` of `Velocity 1Z/Force 101Z`
                if let Some((left, right)) = token.split_once('/') {
                    if let Some((one, None)) = dof_pair(left) {
                        self.words.push(Word::One(one, spelling(left)));
                        let role = role_of(right);
                        let role = role.map(|role| Word::Role(role, Place::InFront));
                        self.words.extend(role);
                    }
                }
                return false;
            }
        };
        self.is_behind_other = false;
        self.words.push(dofs);
        true
    }

    /// Takes out a loose DOF before a word about the measurement: `5s record`.
    fn drop_measured(&mut self, word: &str) {
        let is_loose = matches!(self.words.last(), Some(Word::One(_, Spelling::Loose)));
        if is_loose && is_measurement(word) {
            self.words.pop();
        }
    }

    /// Takes out the loose DOFs.
    pub(super) fn drop_loose(&mut self) {
        self.words
            .retain(|word| !matches!(word, Word::One(_, Spelling::Loose)));
    }

    /// The loose DOFs, in their order.
    pub(super) fn loose(&self) -> Vec<Dof> {
        let loose = self.words.iter().filter_map(|word| match word {
            Word::One(dof, Spelling::Loose) => Some(*dof),
            _ => None,
        });
        loose.collect()
    }

    pub(super) fn has_lower(&self) -> bool {
        let is_lower = |word: &Word| matches!(word, Word::One(_, Spelling::Lower));
        self.words.iter().any(is_lower)
    }

    pub(super) fn has_firm(&self) -> bool {
        let is_firm = |word: &Word| matches!(word, Word::One(_, Spelling::Firm) | Word::Pair(..));
        self.words.iter().any(is_firm)
    }

    /// The DOFs: those of a pair, else by the words before or after each, else the response
    /// first.
    pub(super) fn dofs(&self) -> Dofs {
        let pair = self
            .words
            .iter()
            .enumerate()
            .find_map(|(at, word)| match word {
                Word::Pair(response, reference) => Some((at, Dofs::pair(*response, *reference))),
                _ => None,
            });
        if let Some((at, dofs)) = pair {
            // `ref/rsp 101Z/1Z`
            let first = self.words[..at].first();
            let is_unclear = matches!(first, Some(Word::Role(Role::Reference, _)));
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
                    // both words come before both DOFs
                    ([Role::Reference, rest @ ..], true) => {
                        (Some(&Role::Reference), rest.contains(&Role::Response))
                    }
                    (roles, true) => (roles.first(), false),
                    (roles, false) => (roles.last(), false),
                };
                let dofs = Dofs::pair(*first, *second);
                let is_unclear = is_unclear || self.has_role_between();
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

    /// `1Z response 101Z`: the word may belong to either.
    fn has_role_between(&self) -> bool {
        use Word::{One, Role as Says};
        matches!(self.words[..], [One(..), Says(_, Place::Either), One(..)])
    }

    /// Each single DOF with the words before it, or after it where all words come after:
    /// `1Z output 101Z input`.
    fn with_roles(&self) -> Vec<(Dof, Vec<Role>)> {
        use Word::{One, Role as Says};
        let are_behind = matches!(self.words[..], [One(..), Says(..), One(..), Says(..)]);
        let mut words = self.words.clone();
        if are_behind {
            words.reverse();
        }
        let (mut named, mut roles) = (Vec::new(), Vec::new());
        for word in words {
            match word {
                Says(role, _) => roles.push(role),
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
    use super::super::column_header::ColumnHeader;

    fn show(name: &str) -> String {
        let dofs = ColumnHeader::parse(name, "").dofs;
        if dofs.is_unclear {
            return "unclear".into();
        }
        format!("{} {}", one(dofs.response), one(dofs.reference))
    }

    fn one(dof: Option<chladni_frf::Dof>) -> String {
        dof.map_or("-".into(), |dof| dof.to_string())
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
            "1Z relative to 101Z Re",
            "1Z due to 101Z Re",
            "H at 1Z with respect to 101Z Re",
            "1Z in to 101Z Re",
            "1Z to force 101Z Re",
            "1Z ref 101Z Re",
            "Re 1Z from 101Z",
            "to 1Z from 101Z Re",
            "Re to 1Z from 101Z",
            "Re_101Z_to_1Z",
        ] {
            assert_eq!(show(name), "1:+Z 101:+Z", "{name}");
        }
        for name in [
            "Force response 101Z/1Z Re",
            "1Z response 101Z Re",
            "101Z input 1Z Re",
        ] {
            assert_eq!(show(name), "unclear", "{name}");
        }
        assert_eq!(show("Ref 101Z Re"), "- 101:+Z");
        assert_eq!(show("Re velocity/force 1Z"), "1:+Z -");
    }

    #[test]
    fn seconds_and_multiples_are_no_dofs() {
        for name in ["Re 5s record", "Re 10x avg", "Re T=5s"] {
            assert_eq!(show(name), "- -", "{name}");
        }
        for (name, expected) in [
            ("Re 12Z 5s record", "12:+Z -"),
            ("Re 12Z 10x", "12:+Z 10:+X"),
            ("Acc 12z 5s record re", "12:+Z -"),
            ("Acc 5s re", "- -"),
            ("Record 10x re", "- -"),
            ("Acc 12Z 10x re", "12:+Z -"),
        ] {
            assert_eq!(show(name), expected, "{name}");
        }
        for name in ["Acc 1x Re", "vel 1x", "plate 1x re"] {
            assert_eq!(show(name), "1:+X -", "{name}");
        }
        for name in ["re 1x", "H1 1x re", "re_1x", "Re(1x)", "1X of the plate re"] {
            assert_eq!(show(name), "1:+X -", "{name}");
        }
        assert_eq!(show("plate 1x 3z re"), "1:+X 3:+Z");
        assert_eq!(show("plate 1z re"), "1:+Z -");
        assert_eq!(show("p12 re"), "- -");
    }

    #[test]
    fn loose_dofs_count_where_the_columns_tell_them_apart() {
        for (names, dofs) in [
            (&["Acc 1x", "Acc 2x"][..], "1:+X,2:+X"),
            (&["Acc 1x", "Acc 1y", "Acc 1z"], "1:+X,1:+Y,1:+Z"),
            (&["Acc 1x re", "Acc 1x im"], "1:+X,1:+X"),
            (&["Acc 1s", "Acc 2s", "Acc 3s"], "1:S,2:S,3:S"),
            (&["Acc 5s", "Vel 5s"], "-,-"),
            (&["Acc 10x", "Sum 10x", "Vel 10x"], "-,-,-"),
            (&["Acc 1Z 10x", "Acc 2Z 10x"], "1:+Z,2:+Z"),
            (&["Acc 1z 5s record", "Acc 2z 5s record"], "1:+Z,2:+Z"),
            (&["Acc 1z 5s", "Acc 2z 5s"], "1:+Z,2:+Z"),
        ] {
            let names: Vec<String> = names.iter().map(ToString::to_string).collect();
            let heads = ColumnHeader::of_columns(&names, &vec![String::new(); names.len()]);
            let shown: Vec<String> = heads.iter().map(|head| one(head.dofs.response)).collect();
            assert_eq!(shown.join(","), dofs, "{names:?}");
            assert!(heads.iter().all(|head| head.dofs.reference.is_none()));
        }
    }
}
