//! Completions and manual pages.

use crate::common::Folder;
use std::io::Write;
use std::process::{Command, Stdio};

#[test]
fn completions_know_commands_and_options_in_every_shell() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = folder.run(&format!("completions {shell}")).exits(0).stdout;
        for word in ["chladni", "render", "studio", "stress", "time-sign"] {
            assert!(text.contains(word), "{shell} does not complete {word}");
        }
    }
    let json = folder.run("completions bash --json").exits(0).json();
    assert!(json["completions"].as_str().unwrap().contains("chladni"));
}

/// Bash itself completes a half-written command and a half-written option.
#[test]
fn bash_completes_what_is_half_written() {
    let script = Folder::new().run("completions bash").exits(0).stdout;
    let ask = |words: &str, place: usize| {
        let line = format!(
            "{script}\nCOMP_WORDS=({words}); COMP_CWORD={place}; _chladni chladni \
                            \"${{COMP_WORDS[{place}]}}\" ''; echo \"${{COMPREPLY[*]}}\"\n"
        );
        let mut bash = Command::new("bash")
            .arg("--norc")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        bash.stdin
            .take()
            .unwrap()
            .write_all(line.as_bytes())
            .unwrap();
        let output = bash.wait_with_output().unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    assert_eq!(ask("chladni ren", 1), "render");
    assert_eq!(ask("chladni render --swe", 2), "--sweep");
}

#[test]
fn manual_pages_name_every_command_and_its_options() {
    let folder = Folder::new();
    let page = folder.run("man").exits(0).stdout;
    assert!(
        page.lines().any(|line| line.starts_with(".TH")),
        "{}",
        &page[..200]
    );
    for verb in ["demo", "info", "fit", "render", "report", "studio"] {
        assert!(page.contains(&format!("chladni\\-{verb}")), "{verb}");
        let own = folder.run(&format!("man {verb}")).exits(0).stdout;
        assert!(
            own.contains(".SH SYNOPSIS") && own.contains("chladni"),
            "{verb}"
        );
    }
    let render = folder.run("man render").exits(0).stdout;
    assert!(
        render.contains(".SH EXAMPLES") && render.contains("corner.toml \\-\\-method fast"),
        "{render}"
    );
    assert!(
        render.contains("\\-\\-stress") && render.contains("Try the weights on a panel"),
        "{render}"
    );
    let unknown = folder.run("man rendr").exits(2);
    assert!(
        unknown.stderr.contains("no such command") && unknown.stderr.contains("chladni man render"),
        "{}",
        unknown.stderr
    );
}
