//! The page: a template with style, script and data in one file. Nothing is loaded from
//! elsewhere. The page's policy names its script by its hash, so that no other script runs.

mod bundle;
#[cfg(test)]
mod colour_vision;

use crate::chart::Figure;
use crate::text::{base64, escape};
use bundle::{bundle, Module};
use chladni_frf::CREATED_BY;
use serde_json::{json, Value};
use sha2::{Digest, Sha256};

const TEMPLATE: &str = include_str!("template.html");
const STYLE: &str = include_str!("style.css");
/// Style that the studio's page adds.
const STUDIO_STYLE: &str = include_str!("studio.css");
/// The content of a page before its script has run.
const WITHOUT_SCRIPT: &str = include_str!("without_script.html");

macro_rules! modules {
    ($($name:literal),*) => { &[$(($name, include_str!(concat!("modules/", $name, ".js")))),*] };
}

/// The report's script, one module per view. Each module imports earlier ones only.
const REPORT_MODULES: &[Module] = modules!(
    "dom",
    "numbers",
    "data",
    "store",
    "colour",
    "scale",
    "chart",
    "described",
    "synthesis",
    "surface",
    "panel_map",
    "selection",
    "facts",
    "frfs",
    "stabilization",
    "poles",
    "mac",
    "complexity",
    "structure",
    "space",
    "shapes",
    "field",
    "weights",
    "curves",
    "time",
    "scenes",
    "zone_shapes",
    "zone_editor",
    "zones",
    "tables",
    "page"
);

/// The modules that the studio adds.
const STUDIO_MODULES: &[Module] = modules!(
    "ask",
    "work",
    "pane_data",
    "pane_poles",
    "actuators",
    "board",
    "sweep",
    "measured",
    "pane_panel",
    "drawer",
    "downloads",
    "top",
    "studio"
);

/// The report with its data.
pub(crate) fn report(title: &str, data: &Value) -> String {
    let start = "module_page.show(module_data.embedded());";
    fill_page(
        title,
        STYLE.trim(),
        &format!("{}{start}\n", bundle(REPORT_MODULES)),
        WITHOUT_SCRIPT,
        &inert(data),
        "'none'",
    )
}

/// The studio's page, which asks its server for all data; `number` identifies it there.
pub(crate) fn studio(title: &str, number: u64) -> String {
    let start = "module_studio.start();";
    fill_page(
        title,
        &format!("{}\n{}", STYLE.trim(), STUDIO_STYLE.trim()),
        &format!(
            "{}{start}\n",
            bundle(&[REPORT_MODULES, STUDIO_MODULES].concat())
        ),
        WITHOUT_SCRIPT,
        &inert(&json!({ "page": number, "title": title })),
        "'self'",
    )
}

/// A page of figures alone, one section each, with `words` above them.
pub(crate) fn gallery(title: &str, words: &str, figures: &[Figure]) -> String {
    let link = |figure: &Figure| {
        format!(
            "<li><a href=\"#{}\">{}</a></li>",
            escape(&figure.name),
            escape(&figure.title)
        )
    };
    let section = |figure: &Figure| {
        let (name, title, caption) = (
            escape(&figure.name),
            escape(&figure.title),
            escape(&figure.caption),
        );
        let drawing = figure.draw().to_svg();
        format!("<section id=\"{name}\"><h2>{title}</h2><figure><div \
                 class=\"scroll\">{drawing}</div><figcaption>{caption}</figcaption></figure></section>\n")
    };
    let body = format!(
        "<header><h1>{}</h1><p>{}</p><nav \
         aria-label=\"Contents\"><ul>{}</ul></nav></header>\n<main>{}</main>",
        escape(title),
        escape(words),
        figures.iter().map(link).collect::<String>(),
        figures.iter().map(section).collect::<String>()
    );
    fill_page(title, STYLE.trim(), "", &body, "null", "'none'")
}

fn fill_page(
    title: &str,
    style: &str,
    script: &str,
    body: &str,
    data: &str,
    connect: &str,
) -> String {
    // the browser hashes everything between the tags, the first line break too
    let script = format!("\n{script}");
    let hash = base64(&Sha256::digest(script.as_bytes()));
    fill(
        TEMPLATE,
        &[
            ("style", style),
            ("script", &script),
            ("script_hash", &hash),
            ("connect", connect),
            (
                "title",
                &escape(if title.is_empty() {
                    "Chladni report"
                } else {
                    title
                }),
            ),
            ("created_by", &escape(CREATED_BY)),
            ("body", body),
            ("data", data),
        ],
    )
}

/// JSON that can neither end its `script` element nor begin a comment in it.
fn inert(data: &Value) -> String {
    data.to_string()
        .replace('<', "\\u003c")
        .replace('>', "\\u003e")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

/// Replaces each `{{name}}` by its value, in one pass: names inside values are not replaced.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, tail) = after.split_once("}}").unwrap_or((after, ""));
        out.push_str(before);
        out.push_str(
            values
                .iter()
                .find(|value| value.0 == name)
                .map_or("", |value| value.1),
        );
        rest = tail;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_not_filled_again() {
        assert_eq!(
            fill("a {{x}} b {{y}} c", &[("x", "{{y}}"), ("y", "1")]),
            "a {{y}} b 1 c"
        );
        assert!(!fill(TEMPLATE, &[]).contains("{{"));
    }

    #[test]
    fn data_cannot_leave_their_element() {
        let text = inert(&serde_json::json!(["</script><!--", "\u{2028}"]));
        assert_eq!(text, "[\"\\u003c/script\\u003e\\u003c!--\",\"\\u2028\"]");
    }
}
