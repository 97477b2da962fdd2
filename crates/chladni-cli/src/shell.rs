//! Completions and manual pages, made from the definitions of the options.

use chladni_console::Outcome;
use chladni_frf::{nearest_word, Error, ErrorKind, Result};
use clap::Command;
use clap_complete::Shell;
use clap_mangen::roff::{roman, Roff};
use serde_json::json;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni completions bash > ~/.local/share/bash-completion/completions/chladni
  chladni completions zsh > ~/.zfunc/_chladni")]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni man | man -l -
  chladni man fit > chladni-fit.1")]
pub struct ManArgs {
    /// The command; without it the page of chladni itself
    command: Option<String>,
}

/// Completions on stdout.
pub fn completions(args: &CompletionsArgs, mut program: Command) -> Outcome {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, "chladni", &mut text);
    let text = String::from_utf8_lossy(&text).into_owned();
    Outcome::shown(json!({"completions": text}), text)
}

/// A manual page on stdout.
///
/// # Errors
/// [`ErrorKind::Usage`] for a command that does not exist.
pub fn man(args: &ManArgs, mut program: Command) -> Result<Outcome> {
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => program.find_subcommand(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
            let error = Error::new(ErrorKind::Usage, "no such command")
                .found(name)
                .expected(known.join(", "));
            match nearest_word(name, &known) {
                Some(near) => error.help(format!("write `chladni man {near}`")),
                None => error,
            }
        })?,
    };
    let examples = page.get_before_help().map(ToString::to_string);
    let mut text = Vec::new();
    let written = clap_mangen::Man::new(page)
        .render(&mut text)
        .and_then(|()| match examples {
            Some(examples) => as_written("EXAMPLES", examples.trim_start_matches("Examples:\n"))
                .to_writer(&mut text),
            None => Ok(()),
        });
    written.map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))?;
    let text = String::from_utf8_lossy(&text).into_owned();
    Ok(Outcome::shown(json!({"man": text}), text))
}

/// A section of a manual page whose lines stay as they are.
fn as_written(heading: &str, lines: &str) -> Roff {
    let mut section = Roff::new();
    section.control("SH", [heading]).control("nf", []);
    for line in lines.lines() {
        section.text([roman(line)]);
    }
    section.control("fi", []);
    section
}
