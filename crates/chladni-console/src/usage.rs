//! Parsing of the arguments; errors of usage have the form of all other errors.

use crate::console::for_terminal;
use crate::input::DofFile;
use crate::numbers::in_range;
use crate::stdout::print_error;
use chladni_frf::{Error, ErrorKind};
use clap::error::{ContextKind, ContextValue, ErrorKind as ClapKind};
use clap::{Arg, ArgMatches, ColorChoice, Command, Parser};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

/// True where `option` is among the arguments, even if others are wrong.
pub fn asks_for(option: &str) -> bool {
    std::env::args_os()
        .take_while(|arg| arg != "--")
        .any(|arg| arg == option)
}

/// True where `option` has this value among the arguments.
pub fn says(option: &str, value: &str) -> bool {
    let args: Vec<_> = std::env::args_os().take_while(|arg| arg != "--").collect();
    let joined = format!("{option}={value}");
    args.iter().any(|arg| *arg == *joined)
        || args
            .windows(2)
            .any(|pair| pair[0] == option && pair[1] == value)
}

/// The reason why no command is run.
pub enum Answer {
    /// Help, version, or wrong arguments.
    Clap(clap::Error),
    /// Arguments that do not go together.
    Refused(Error),
}

/// The arguments of this process.
pub fn parse<C: Parser>() -> Result<C, Answer> {
    let colours = match asks_for("--no-color") {
        true => ColorChoice::Never,
        false => ColorChoice::Auto,
    };
    let matches = with_help_pages(C::command())
        .color(colours)
        .try_get_matches_from(arguments())
        .map_err(Answer::Clap)?;
    one_standard_input(&matches).map_err(Answer::Refused)?;
    C::from_arg_matches(&matches).map_err(Answer::Clap)
}

/// The arguments of this process; `help --help` is read as `help`.
fn arguments() -> impl Iterator<Item = OsString> {
    let is_help = std::env::args_os().nth(1).is_some_and(|arg| arg == "help");
    std::env::args_os().filter(move |arg| !(is_help && (arg == "--help" || arg == "-h")))
}

/// A help page: purpose, examples, options.
const HELP: &str = "{about-with-newline}
{before-help}{usage-heading} {usage}

{all-args}{after-help}";

/// Headings of options that many commands share: `--help` lists them, `-h` does not.
const SHARED: [&str; 2] = ["Common options", "Reading FRFs"];
/// One of these options that `-h` lists too, since many files need it.
const OFTEN_NEEDED: &str = "frf_kind";

/// The command and its subcommands with the help page [`HELP`]. Their short help leaves out
/// shared options. A negative number after an option is its value.
fn with_help_pages(command: Command) -> Command {
    let is_shared = |arg: &Arg| {
        let heading = arg.get_help_heading();
        arg.get_id().as_str() != OFTEN_NEEDED && heading.is_some_and(|name| SHARED.contains(&name))
    };
    command
        .help_template(HELP)
        .mut_args(|arg| {
            let hide = is_shared(&arg);
            let takes_value = arg.get_action().takes_values() && !arg.is_positional();
            arg.hide_short_help(hide)
                .allow_negative_numbers(takes_value)
        })
        .mut_subcommands(with_help_pages)
}

/// Options that name a file to write.
const WRITTEN: [&str; 4] = ["output", "truth", "wav", "calibration"];

/// Refuses the standard input as a second file, since it can be read only once.
fn one_standard_input(matches: &ArgMatches) -> Result<(), Error> {
    let Some((_, matches)) = matches.subcommand() else {
        return Ok(());
    };
    let files = matches
        .ids()
        .filter(|id| !WRITTEN.contains(&id.as_str()))
        .filter_map(|id| matches.try_get_many::<PathBuf>(id.as_str()).ok().flatten())
        .flatten();
    let lists = matches
        .ids()
        .filter_map(|id| matches.try_get_one::<DofFile>(id.as_str()).ok().flatten());
    let count = files.filter(|file| file.as_os_str() == "-").count()
        + lists.filter(|list| list.is_standard_input()).count();
    if count > 1 {
        return Err(
            Error::new(ErrorKind::Usage, "`-`, the standard input, is one file")
                .found(format!("{count} times `-`"))
                .expected("`-` once at most")
                .help("give the other files by their names"),
        );
    }
    one_standard_input(matches)
}

impl Answer {
    /// Help and version go to stdout (exit 0), errors to stderr (exit 2).
    pub fn report(&self, program: &Command, json: bool) -> ExitCode {
        match self {
            Self::Clap(answer) => report(answer, program, json),
            Self::Refused(error) => refuse(error, json),
        }
    }
}

fn report(answer: &clap::Error, program: &Command, json: bool) -> ExitCode {
    let no_command = answer.kind() == ClapKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if !answer.use_stderr() || (no_command && !json) {
        // a pipe that its reader has closed is no error
        drop(answer.print());
        return ExitCode::from(
            u8::try_from(answer.exit_code()).unwrap_or(ErrorKind::Usage.exit_code()),
        );
    }
    refuse(&error_of(answer, program), json)
}

fn refuse(error: &Error, json: bool) -> ExitCode {
    eprintln!("error: {}", for_terminal(&error.to_string()));
    if json {
        print_error(error);
    }
    ExitCode::from(error.kind.exit_code())
}

fn error_of(answer: &clap::Error, program: &Command) -> Error {
    // a file of an option that cannot be read is not an error of usage
    if let Some(error) = reason(answer).filter(|error| error.file.is_some()) {
        return error.clone();
    }
    let context = |kind| context(answer, kind);
    let argument = context(ContextKind::InvalidArg);
    let error = Error::new(ErrorKind::Usage, message(answer));
    let error = match answer.kind() {
        ClapKind::UnknownArgument => error.found(argument.unwrap_or_default()).expected(
            match context(ContextKind::SuggestedArg) {
                Some(near) => format!("an option of this command, such as {near}"),
                None => "an option of this command".into(),
            },
        ),
        ClapKind::InvalidSubcommand => error
            .found(context(ContextKind::InvalidSubcommand).unwrap_or_default())
            .expected(match context(ContextKind::SuggestedSubcommand) {
                Some(near) => format!("a command, such as {near}"),
                None => "a command".into(),
            }),
        ClapKind::DisplayHelpOnMissingArgumentOrSubcommand | ClapKind::MissingSubcommand => {
            error.found("nothing").expected("a command")
        }
        ClapKind::MissingRequiredArgument => error
            .found("nothing")
            .expected(argument.unwrap_or_default()),
        ClapKind::ArgumentConflict if is_twice(answer) => error
            .field(argument.unwrap_or_default())
            .found("the option twice")
            .expected("it once"),
        ClapKind::ArgumentConflict => error
            .field(argument.unwrap_or_default())
            .found("both")
            .expected(match context(ContextKind::PriorArg) {
                Some(prior) => format!("either this or {prior}"),
                None => "it once".into(),
            }),
        _ => with_value(error, answer),
    };
    // for an unknown option clap gives the usage of the option that it guesses
    let usage = context(ContextKind::Usage)
        .filter(|_| answer.kind() != ClapKind::UnknownArgument)
        .map(|usage| usage.trim_start_matches("Usage: ").trim().to_owned());
    let see = format!("see `{} --help`", called(program));
    let advice = reason(answer).and_then(|reason| reason.help.clone());
    error.help(match (advice, usage) {
        (Some(advice), _) => format!("{advice}; {see}"),
        (None, Some(usage)) => format!("usage: {usage}; {see}"),
        (None, None) => see,
    })
}

/// The error of our own parser of a value, where that refused it.
fn reason(answer: &clap::Error) -> Option<&Error> {
    std::error::Error::source(answer).and_then(|reason| reason.downcast_ref())
}

/// Both ends of the range that clap's own parser of numbers asks for: `0 is not in 1..=20`.
fn range_of(answer: &clap::Error) -> Option<(String, String)> {
    let said = std::error::Error::source(answer)?.to_string();
    let (_, range) = said.split_once(" is not in ")?;
    let (low, high) = range.split_once("..=")?;
    Some((low.to_owned(), high.to_owned()))
}

/// True for an option that occurs twice, which clap calls a conflict with itself.
fn is_twice(answer: &clap::Error) -> bool {
    let of = |kind| context(answer, kind);
    let argument = of(ContextKind::InvalidArg);
    argument.is_some() && argument == of(ContextKind::PriorArg)
}

/// Clap's words for one kind of context; `None` where they are empty.
fn context(answer: &clap::Error, kind: ContextKind) -> Option<String> {
    answer.get(kind).map(words).filter(|text| !text.is_empty())
}

/// Adds the argument, its value, and the expected value.
fn with_value(error: Error, answer: &clap::Error) -> Error {
    let argument = context(answer, ContextKind::InvalidArg);
    let (name, placeholder) = argument.as_deref().map_or((None, None), split_argument);
    let error = match name {
        Some(name) => error.field(name),
        None => error,
    };
    let error = match context(answer, ContextKind::InvalidValue) {
        Some(value) => error.found(value),
        None => error.found("nothing"),
    };
    if let Some(expected) = reason(answer).and_then(|reason| reason.expected.as_deref()) {
        return error.expected(expected);
    }
    if let Some((low, high)) = range_of(answer) {
        return error.expected(in_range(low, high, ""));
    }
    match context(answer, ContextKind::ValidValue) {
        Some(valid) => error.expected(match context(answer, ContextKind::SuggestedValue) {
            Some(near) => format!("{near}, or another of {valid}"),
            None => format!("one of {valid}"),
        }),
        None => match placeholder {
            Some(placeholder) => error.expected(in_words(&placeholder)),
            None => error,
        },
    }
}

/// The program and its command, as in the arguments.
fn called(program: &Command) -> String {
    let name = program.get_bin_name().unwrap_or(program.get_name());
    let command = std::env::args()
        .skip(1)
        .find(|arg| program.find_subcommand(arg).is_some());
    match command {
        Some(command) => format!("{name} {command}"),
        None => name.to_owned(),
    }
}

/// Name and placeholder of `--band <LO:HI>`.
fn split_argument(argument: &str) -> (Option<String>, Option<String>) {
    match argument.split_once(' ') {
        Some((name, placeholder)) => (
            Some(name.to_owned()),
            Some(placeholder.trim_matches(['<', '>', '.']).to_owned()),
        ),
        None => (Some(argument.to_owned()), None),
    }
}

/// The meaning of a placeholder of one letter.
fn in_words(placeholder: &str) -> &str {
    match placeholder {
        "N" | "S" => "a whole number",
        "X" => "a number",
        "SIZE" => "a size such as 500M or 2G",
        other => other,
    }
}

fn message(answer: &clap::Error) -> String {
    if let Some(reason) = reason(answer) {
        return reason.message.clone();
    }
    if let Some(reason) = std::error::Error::source(answer) {
        // the words of number parsers are for programmers
        return match reason.is::<std::num::ParseIntError>() {
            true => "not a whole number, 0 or more".into(),
            false if range_of(answer).is_some() => "this number is out of its range".into(),
            false => reason.to_string(),
        };
    }
    match answer.kind() {
        ClapKind::UnknownArgument => "no such option".into(),
        ClapKind::InvalidSubcommand => "no such command".into(),
        ClapKind::DisplayHelpOnMissingArgumentOrSubcommand | ClapKind::MissingSubcommand => {
            "no command is given".into()
        }
        ClapKind::MissingRequiredArgument => "a required argument is missing".into(),
        ClapKind::ArgumentConflict if is_twice(answer) => "this option is given twice".into(),
        ClapKind::ArgumentConflict => "these options exclude each other".into(),
        ClapKind::InvalidValue
            if answer
                .get(ContextKind::InvalidValue)
                .map(words)
                .is_none_or(|value| value.is_empty()) =>
        {
            "the value is missing".into()
        }
        ClapKind::InvalidValue | ClapKind::ValueValidation => "this value is not allowed".into(),
        kind => kind.as_str().unwrap_or("wrong usage").into(),
    }
}

/// The text of clap's context, without colours.
fn words(value: &ContextValue) -> String {
    match value {
        ContextValue::String(text) => text.clone(),
        ContextValue::Strings(texts) => texts.join(", "),
        ContextValue::StyledStr(text) => text.to_string(),
        ContextValue::StyledStrs(texts) => texts
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("; "),
        ContextValue::Number(number) => number.to_string(),
        ContextValue::Bool(_) | ContextValue::None => String::new(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_the_parser_is_told_in_words() {
        let seeds = Arg::new("seeds")
            .long("seeds")
            .value_name("N")
            .value_parser(clap::value_parser!(u32).range(1..=20));
        let program = Command::new("rig").arg(seeds);
        let told = |value: &str| {
            let arguments = ["rig", "--seeds", value];
            let answer = program.clone().try_get_matches_from(arguments);
            error_of(&answer.unwrap_err(), &program)
        };
        let error = told("40");
        assert_eq!(error.message, "this number is out of its range");
        assert_eq!(error.field.as_deref(), Some("--seeds"));
        assert_eq!(error.found.as_deref(), Some("40"));
        let expected = error.expected.as_deref();
        assert_eq!(expected, Some("a whole number from 1 to 20"));
        let error = told("many");
        assert_eq!(error.message, "not a whole number, 0 or more");
        assert_eq!(error.expected.as_deref(), Some("a whole number"));
    }
}
