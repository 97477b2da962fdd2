//! A running studio, and requests to it.

use super::Folder;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

/// A studio that ends with the test.
pub struct Studio {
    process: Child,
    /// The address that it printed.
    pub url: String,
    /// Host and port.
    pub address: String,
    /// The token in the address of the page.
    pub token: String,
}

impl Studio {
    /// Starts a studio in `folder` with these arguments.
    pub fn start(folder: &Folder, args: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        command.arg("studio").args(args);
        Self::of_command(folder, command)
    }

    /// Starts it by any command.
    pub fn of_command(folder: &Folder, mut command: Command) -> Self {
        command
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut process = command.spawn().unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.take().unwrap())
            .read_line(&mut url)
            .unwrap();
        let url = url.trim().to_owned();
        let (address, token) = url
            .strip_prefix("http://")
            .and_then(|rest| rest.split_once("/?token="))
            .unwrap_or_else(|| panic!("no address with a token: {url:?}"));
        Self {
            address: address.to_owned(),
            token: token.to_owned(),
            process,
            url: url.clone(),
        }
    }

    /// Id of its process.
    pub fn id(&self) -> u32 {
        self.process.id()
    }

    /// The answer to a request; its lines contain HERE for the address and TOKEN for the token.
    pub fn asked(&self, head: &str, body: &str) -> String {
        String::from_utf8(self.asked_bytes(head, body)).unwrap()
    }

    /// The answer to a request, as bytes.
    pub fn asked_bytes(&self, head: &str, body: &str) -> Vec<u8> {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        let head = head
            .replace("HERE", &self.address)
            .replace("TOKEN", &self.token);
        write!(stream, "{head}\r\nConnection: close\r\n\r\n{body}").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        answer
    }

    /// The answer to a question of the page.
    pub fn asked_about(&self, what: &str, question: &str) -> Value {
        let answer = self.asked(&self.head(what, question), question);
        serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap())
            .unwrap_or_else(|error| panic!("{error}: {answer}"))
    }

    /// The head of a question of the page.
    pub fn head(&self, what: &str, question: &str) -> String {
        format!(
            "POST /api/{what} HTTP/1.1\r\nHost: HERE\r\nAuthorization: Bearer TOKEN\r\n\
             Content-Type: application/json\r\nContent-Length: {}",
            question.len()
        )
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}
