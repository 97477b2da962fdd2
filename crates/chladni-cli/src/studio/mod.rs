//! `chladni studio`: the report, live, on a page that only this machine can open.
//!
//! `server.rs` answers the page, which is in `chladni-report` and shares the report's views.
//! `question.rs` holds the questions that it may ask, and `token.rs` distinguishes the owner
//! from other users of the machine. `session.rs` fits, on the lines of `draft.rs` while
//! something is dragged, and `progress.rs` holds the stages of the fit. `chosen.rs` adds and drops
//! modes as the commands on the page do. `scenes.rs` renders scenes, and `measured.rs` judges measured fields.

mod chosen;
mod draft;
mod measured;
mod progress;
mod question;
mod rendered;
mod scenes;
mod server;
mod session;
mod token;

use chladni_console::input::Reading;
use chladni_console::{print_line, whole_number, Console, Outcome};
use chladni_frf::{Error, ErrorKind, Result};
use serde_json::json;
use server::Door;
use session::Session;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use token::Token;

/// Arguments of `studio`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni studio measurement.uff                       fit, draw scenes and render, live
  chladni studio model.json                            the same with a model that is fitted already
  chladni studio scans/ --frf-kind mobility --port 8080

Prints the address of a page, and serves it until Ctrl-C. Only this machine can open it, and only who knows the address: the
token in it is new in every run (docs/security.md). On one screen: the FRFs with the band, the poles (drop them, add one at an empty peak), the
panel with its field, on which zones are drawn, moved and resized. The fit, the weights and the field follow at once: while anything
is being dragged by the methods `lean` and `fast`, afterwards by `auto` and `best`. A measured field (CSV) is compared with its prediction;
its likely causes are ranked, and a click corrects the drive. The page shows the commands and the TOML that do the same again, and offers
model, weights, drive signals, calibration and report as downloads. ? lists the keys.")]
pub struct Args {
    /// FRFs of any format that `chladni fit` reads, or a model
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Port to listen on; 0 takes any free one
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_port)]
    port: u16,
    #[command(flatten)]
    reading: Reading,
}

/// `--port` as a number.
fn parse_port(text: &str) -> Result<u16> {
    whole_number(text, 0..=u16::MAX, "", "no port")
        .map_err(|error| error.help("leave --port out to take any free one"))
}

/// Runs the command; it ends by an interruption only.
///
/// # Errors
/// Those of reading; a port that is taken.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let session = Session::open(&args.files, &args.reading, console)?;
    let wanted = SocketAddr::from((Ipv4Addr::LOCALHOST, args.port));
    let refused = |error: std::io::Error| {
        Error::new(
            ErrorKind::Io,
            format!("cannot listen on this machine: {error}"),
        )
        .field("--port")
        .found(args.port)
        .expected("a free port")
        .help("choose another port, or leave --port out to take any free one")
    };
    let listener = TcpListener::bind(wanted).map_err(refused)?;
    let address = listener.local_addr().map_err(refused)?;
    console.finish();
    console.tell();
    let door = Door {
        address,
        token: Token::random()?,
    };
    let url = door.url();
    match console.json {
        true => print_line(&json!({ "url": url }).to_string())?,
        false => print_line(&url)?,
    }
    console.note(
        "open this address in a browser on this machine, and show it to nobody: who knows it \
         may ask the studio; Ctrl-C ends the studio",
    );
    server::serve(Arc::new(session), listener, door).map_err(refused)?;
    Ok(Outcome::shown(json!({}), String::new()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_out_of_range_is_told_the_range() {
        assert_eq!(parse_port("65535"), Ok(u16::MAX));
        for text in ["65536", "-1", "80.5", "http"] {
            let expected = parse_port(text).unwrap_err().expected.unwrap();
            assert_eq!(expected, "a whole number from 0 to 65535");
        }
    }
}
