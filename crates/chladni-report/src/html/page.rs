//! The page around the sections.

use crate::chart::Figure;
use crate::input::ReportInput;
use crate::sections::{contents, warnings, Block, Section};
use crate::text::{counted, escape};
use chladni_frf::CREATED_BY;
use std::fmt::Write;

const TEMPLATE: &str = include_str!("template.html");
const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// The whole page.
pub(crate) fn page(input: &ReportInput, sections: &[Section]) -> String {
    let title = if input.title.is_empty() { "Chladni report" } else { &input.title };
    let body: String = sections.iter().map(write_section).collect();
    fill(
        TEMPLATE,
        &[
            ("style", STYLE.trim()),
            ("script", SCRIPT.trim()),
            ("title", &escape(title)),
            ("created_by", &escape(CREATED_BY)),
            ("warnings", &warning_list(input)),
            ("contents", &contents(sections)),
            ("sections", &body),
        ],
    )
}

/// A page of figures alone, each with its title as a heading; `words` stand above them.
pub(crate) fn gallery(title: &str, words: &str, figures: &[Figure]) -> String {
    let section = |figure: &Figure| Section {
        id: figure.name.clone(),
        heading: figure.title.clone(),
        blocks: vec![Block::Figure(Box::new(figure.clone()))],
    };
    let sections: Vec<Section> = figures.iter().map(section).collect();
    let values = [
        ("style", STYLE.trim()),
        ("script", SCRIPT.trim()),
        ("title", &escape(title)),
        ("created_by", &escape(CREATED_BY)),
        ("warnings", &format!("<p class=\"calm\">{}</p>", escape(words))),
        ("contents", &contents(&sections)),
        ("sections", &sections.iter().map(write_section).collect::<String>()),
    ];
    fill(TEMPLATE, &values)
}

/// Puts each value in the place of its `{{name}}`, in one pass: what is put in is not looked at again.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, tail) = after.split_once("}}").unwrap_or((after, ""));
        out.push_str(before);
        out.push_str(values.iter().find(|value| value.0 == name).map_or("", |value| value.1));
        rest = tail;
    }
    out + rest
}

fn warning_list(input: &ReportInput) -> String {
    let warnings = warnings(input);
    if warnings.is_empty() {
        return "<p class=\"calm\">No warnings.</p>".into();
    }
    let items: String = warnings.iter().map(|(about, text)| format!("<li><b>{}:</b> {}</li>\n", escape(about), escape(text))).collect();
    format!(
        "<section class=\"warnings\" aria-label=\"Warnings\"><h2>{}</h2><ul>\n{items}</ul></section>",
        counted(warnings.len(), "warning")
    )
}

fn write_section(section: &Section) -> String {
    let mut out = String::new();
    let blocks: String = section.blocks.iter().map(write_block).collect();
    let (id, heading) = (escape(&section.id), escape(&section.heading));
    write!(out, "<section id=\"{id}\">\n<h2>{heading}</h2>\n{blocks}</section>\n").expect("writing to a string cannot fail");
    out
}

fn write_block(block: &Block) -> String {
    match block {
        Block::Html(html) => format!("{html}\n"),
        Block::Figure(figure) => write_figure(figure),
        Block::Gallery(figures) => format!("<div class=\"gallery\">\n{}</div>\n", figures.iter().map(write_figure).collect::<String>()),
        Block::Choice { label, figures } => {
            let options: String = figures.iter().map(|(text, _)| format!("<option>{}</option>", escape(text))).collect();
            let pictures: String = figures.iter().map(|(_, figure)| write_figure(figure)).collect();
            let label = escape(label);
            format!("<div class=\"choice\"><label hidden>{label} <select>{options}</select></label>\n{pictures}</div>\n")
        }
    }
}

fn write_figure(figure: &Figure) -> String {
    let caption = if figure.caption.is_empty() { String::new() } else { format!("<figcaption>{}</figcaption>", escape(&figure.caption)) };
    let drawing = figure.draw().to_inline_svg();
    format!("<figure id=\"figure-{}\"><div class=\"scroll\">{drawing}</div>{caption}</figure>\n", escape(&figure.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_not_filled_again() {
        assert_eq!(fill("a {{x}} b {{y}} c", &[("x", "{{y}}"), ("y", "1")]), "a {{y}} b 1 c");
        assert!(!fill(TEMPLATE, &[]).contains("{{"));
    }
}
