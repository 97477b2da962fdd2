//! The examples of docs/formats.md are what the commands read.

mod common;

use common::Folder;

const PAGE: &str = include_str!("../../../docs/formats.md");

#[test]
fn the_examples_of_the_page_are_read() {
    let folder = Folder::new();
    let mut blocks = PAGE.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    folder.write("scene.toml", blocks.next().unwrap());
    // the axis is cut so that the test takes no time
    folder.write("panel.toml", blocks.next().unwrap().replace("step_hz = 0.5", "step_hz = 50.0"));
    folder.write("selection.toml", blocks.next().unwrap());
    assert!(blocks.next().is_none(), "a new example needs a line here");
    let written = folder.run("simulate panel.toml -o panel.h5 --truth truth.json --json").exits(0).json();
    assert_eq!((&written["responses"], &written["references"]), (&77.into(), &34.into()));
    let rendered = folder.run("render truth.json scene.toml --method fast --json");
    assert!(rendered.code <= 1, "{}", rendered.stderr);
    assert_eq!(rendered.json()["scene"], "scene.toml");
    folder.run("select truth.json selection.toml -o kept.json -q").exits(0);
}

#[test]
fn equations_of_the_theory_are_numbered_in_order() {
    let theory = include_str!("../../../docs/theory.md");
    let label = |line: &str| -> Option<usize> { line.trim_end().strip_suffix(')')?.rsplit_once('(')?.1.parse().ok() };
    let labels: Vec<usize> = theory.lines().filter(|line| line.starts_with("    ")).filter_map(label).collect();
    assert!(labels.len() > 30, "{labels:?}");
    assert_eq!(labels, (1..=labels.len()).collect::<Vec<_>>());
}
