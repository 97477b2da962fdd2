//! ES modules as one script, since a page in one file cannot import others.
//!
//! Each module becomes a function that is called once and returns its exports, in the order of
//! the list. Only two forms are understood: whole lines `import { a, b } from "./name.js";` and
//! declarations that begin with `export `.

/// A module: its name and its text.
pub(crate) type Module = (&'static str, &'static str);

/// One script of all `modules`; each imports earlier ones only.
pub(crate) fn bundle(modules: &[Module]) -> String {
    let bodies: String = modules
        .iter()
        .map(|&(name, text)| wrapped(name, text))
        .collect();
    format!("\"use strict\";\n{bodies}")
}

fn wrapped(name: &str, text: &str) -> String {
    let (mut body, mut exported) = (String::new(), Vec::new());
    for line in text.lines() {
        if let Some((names, module)) = imported(line) {
            body += &format!("const {names} = module_{module};\n");
        } else if let Some(declaration) = line.strip_prefix("export ") {
            exported.extend(declared(declaration));
            body += &format!("{declaration}\n");
        } else {
            body += &format!("{line}\n");
        }
    }
    format!(
        "const module_{name} = (() => {{\n{body}return {{ {} }};\n}})();\n",
        exported.join(", ")
    )
}

/// `{ a, b }` and `name` of `import { a, b } from "./name.js";`.
fn imported(line: &str) -> Option<(&str, &str)> {
    let (names, rest) = line.strip_prefix("import ")?.split_once(" from \"./")?;
    Some((names, rest.strip_suffix(".js\";")?))
}

/// `name` of `function name(`, `const name =`, `class name {`.
fn declared(declaration: &str) -> Option<&str> {
    let rest = declaration.strip_prefix("async ").unwrap_or(declaration);
    let (_, name) = rest.split_once(' ')?;
    name.split(|letter: char| !letter.is_alphanumeric() && letter != '_')
        .next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::{REPORT_MODULES, STUDIO_MODULES};

    #[test]
    fn a_module_sees_what_it_imports() {
        let script = bundle(&[
            (
                "a",
                "export const one = 1;\nexport function two(x) {\n  return x;\n}\n",
            ),
            ("b", "import { one, two } from \"./a.js\";\ntwo(one);\n"),
        ]);
        assert!(script.contains("return { one, two };"));
        assert!(script.contains(
            "const module_b = (() => \
                                 {\nconst { one, two } = module_a;\ntwo(one);\nreturn {  };\n})();"
        ));
    }

    #[test]
    fn every_module_of_the_page_imports_earlier_ones_and_what_they_export() {
        let mut known: Vec<(&str, Vec<&str>)> = Vec::new();
        for (name, text) in [REPORT_MODULES, STUDIO_MODULES].concat() {
            for (names, module) in text.lines().filter_map(imported) {
                let exported = &known
                    .iter()
                    .find(|earlier| earlier.0 == module)
                    .unwrap_or_else(|| panic!("{name} imports {module}"))
                    .1;
                for wanted in names.trim_matches(['{', '}', ' ']).split(", ") {
                    assert!(
                        exported.contains(&wanted),
                        "{name} imports {wanted} from {module}"
                    );
                }
            }
            assert!(
                !text
                    .lines()
                    .any(|line| line.starts_with("import ") && imported(line).is_none()),
                "{name}"
            );
            known.push((
                name,
                text.lines()
                    .filter_map(|line| line.strip_prefix("export "))
                    .filter_map(declared)
                    .collect(),
            ));
        }
    }
}
