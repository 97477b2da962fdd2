//! The files to read from the paths that a user gives: folders and patterns are expanded.

use super::detect::not_readable;
use crate::limits::PATHS_LISTED;
use chladni_frf::{Error, ErrorKind, Finding, Result};
use chladni_text::file_name;
use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};

/// The files that paths stand for, and the findings about files left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Inputs {
    /// Files to read, in order.
    pub files: Vec<PathBuf>,
    /// Findings about files of folders that no reader knows, by the reason.
    pub warnings: Vec<Finding>,
}

/// The files that paths stand for: a name with `*` or `?` for all files that fit; a folder for
/// all files in it that a reader knows, with a warning that names the others. Both are in
/// natural order (`point_2` before `point_10`), without hidden files.
///
/// # Errors
/// [`ErrorKind::NoInput`] for a folder without a file to read, or a pattern that nothing
/// fits.
pub fn expand_paths(paths: &[PathBuf]) -> Result<Inputs> {
    let mut inputs = Inputs::default();
    for path in paths {
        let name = file_name(path);
        if path.is_dir() {
            inputs.add_folder(path)?;
        } else if name.contains(['*', '?']) && !path.exists() {
            let folder = path
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty())
                .unwrap_or_else(|| Path::new("."));
            let found = files_in(folder, &name)?;
            if found.is_empty() {
                return Err(Error::new(ErrorKind::NoInput, "no file fits the pattern")
                    .file(path)
                    .found("none")
                    .expected("at least one file")
                    .help(
                        "`*` stands for any text, `?` for one character, in the last part of the \
                           path",
                    ));
            }
            inputs.files.extend(found);
        } else {
            inputs.files.push(path.clone());
        }
    }
    Ok(inputs)
}

impl Inputs {
    fn add_folder(&mut self, folder: &Path) -> Result<()> {
        let before = self.files.len();
        let mut strangers: Vec<(String, Vec<String>)> = Vec::new();
        for file in files_in(folder, "*")? {
            let Some(reason) = not_readable(&file)? else {
                self.files.push(file);
                continue;
            };
            let name = file_name(&file);
            match strangers.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, names)) => names.push(name),
                None => strangers.push((reason, vec![name])),
            }
        }
        let left_out = strangers.into_iter().map(|(reason, names)| {
            let words = format!(
                "left out of the folder: {} ({reason})",
                shortened(&names, PATHS_LISTED)
            );
            Finding::caution("not-read", words)
        });
        if self.files.len() == before {
            let texts: Vec<String> = left_out.map(|finding| finding.text).collect();
            let found = texts.join("; ");
            return Err(Error::new(
                ErrorKind::NoInput,
                "the folder has no file that can be read",
            )
            .file(folder)
            .found(if found.is_empty() { "no file" } else { &found })
            .expected("universal files, HDF5, text tables or models")
            .help("name the files themselves, or the folder that they are in"));
        }
        self.warnings.extend(left_out);
        Ok(())
    }
}

/// The first names, and the number of the others.
pub(super) fn shortened(names: &[String], most: usize) -> String {
    let listed = names[..names.len().min(most)].join(", ");
    match names.len().saturating_sub(most) {
        0 => listed,
        more => format!("{listed} and {more} more"),
    }
}

fn files_in(folder: &Path, pattern: &str) -> Result<Vec<PathBuf>> {
    let on_read = |error: std::io::Error| Error::from_read(&error, folder);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(on_read)? {
        let path = entry.map_err(on_read)?.path();
        let name = file_name(&path);
        if path.is_file() && !name.starts_with('.') && fits(&name, pattern) {
            found.push((name, path));
        }
    }
    found.sort_by(|(a, _), (b, _)| natural_order(a, b));
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// True where a name fits a pattern: `*` is any text, `?` one character.
fn fits(name: &str, pattern: &str) -> bool {
    let (name, pattern): (Vec<char>, Vec<char>) =
        (name.chars().collect(), pattern.chars().collect());
    // reachable[k]: the pattern up to here fits the first k characters
    let mut reachable = vec![false; name.len() + 1];
    reachable[0] = true;
    for symbol in pattern {
        if symbol == '*' {
            for k in 1..=name.len() {
                reachable[k] |= reachable[k - 1];
            }
        } else {
            for k in (1..=name.len()).rev() {
                reachable[k] = reachable[k - 1] && (symbol == '?' || symbol == name[k - 1]);
            }
            reachable[0] = false;
        }
    }
    reachable[name.len()]
}

/// Order of names in which runs of digits compare as numbers.
fn natural_order(a: &str, b: &str) -> Ordering {
    let key = |text: &str| {
        let mut parts: Vec<(bool, usize, String)> = Vec::new();
        for c in text.chars() {
            let digit = c.is_ascii_digit();
            match parts
                .last_mut()
                .filter(|(is_number, ..)| *is_number == digit)
            {
                Some((.., part)) => part.push(c),
                None => parts.push((digit, 0, c.to_string())),
            }
        }
        for (is_number, length, part) in &mut parts {
            if *is_number {
                *part = part.trim_start_matches('0').to_owned();
                *length = part.len();
            }
        }
        parts
    };
    key(a).cmp(&key(b)).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_as_in_a_shell() {
        for (name, pattern, expected) in [
            ("scan_1.uff", "*.uff", true),
            ("scan_1.uff", "scan_?.uff", true),
            ("scan_12.uff", "scan_?.uff", false),
            ("scan", "*a*", true),
            ("", "*", true),
            ("a", "", false),
        ] {
            assert_eq!(fits(name, pattern), expected, "{name} {pattern}");
        }
    }

    #[test]
    fn numbers_in_names_are_ordered_as_numbers() {
        let mut names = ["p10.csv", "p2.csv", "p1.csv", "q1.csv", "p02.csv"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["p1.csv", "p02.csv", "p2.csv", "p10.csv", "q1.csv"]);
    }
}
