//! A real headless Chromium, driven over its DevTools socket.

use base64::engine::general_purpose::STANDARD;
use base64::Engine;
use serde_json::{json, Value};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::{client, Message, WebSocket};

/// The browser's error where a navigation interrupts an evaluation.
const NAVIGATES: &str = "Inspected target navigated or closed";

const NAMES: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];
/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// One tab of a browser of its own; both are gone after the test.
pub struct Page {
    browser: Child,
    _profile: TempDir,
    socket: WebSocket<TcpStream>,
    session: String,
    last: u64,
    complaints: Vec<String>,
}

impl Page {
    /// A tab of the given size in px, light or dark. Without a browser `None`, and a line on
    /// stderr.
    pub fn new(width: u32, height: u32, dark: bool) -> Option<Self> {
        let profile = tempfile::tempdir().unwrap();
        let Some(mut browser) = NAMES.iter().find_map(|name| launch(name, profile.path())) else {
            super::skipped(&format!(
                "no browser found ({}); scripts/setup.sh installs one",
                NAMES.join(", ")
            ));
            return None;
        };
        let Some(url) = devtools_url(profile.path()) else {
            drop(browser.kill());
            panic!("the browser opened no DevTools port");
        };
        let address = url
            .trim_start_matches("ws://")
            .split('/')
            .next()
            .unwrap()
            .to_owned();
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = client(&url, stream).unwrap();
        let mut page = Self {
            browser,
            _profile: profile,
            socket,
            session: String::new(),
            last: 0,
            complaints: Vec::new(),
        };
        let target =
            page.send("Target.createTarget", json!({"url": "about:blank"}))["targetId"].clone();
        let session = page.send(
            "Target.attachToTarget",
            json!({"targetId": target, "flatten": true}),
        )["sessionId"]
            .clone();
        page.session = session.as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Log"] {
            page.send(&format!("{domain}.enable"), json!({}));
        }
        page.send("Performance.enable", json!({"timeDomain": "threadTicks"}));
        page.resize(width, height);
        let scheme = if dark { "dark" } else { "light" };
        page.send(
            "Emulation.setEmulatedMedia",
            json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]}),
        );
        Some(page)
    }

    pub fn resize(&mut self, width: u32, height: u32) {
        let size =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.send("Emulation.setDeviceMetricsOverride", size);
    }

    /// Shows the page as it is printed.
    pub fn on_paper(&mut self) {
        self.send("Emulation.setEmulatedMedia", json!({"media": "print"}));
        self.eval("dispatchEvent(new Event('beforeprint'))");
    }

    /// Opens an address and waits until the page is drawn; returns the time that this takes, ms.
    pub fn open(&mut self, url: &str) -> u64 {
        self.eval("delete document.documentElement?.dataset.drawn");
        self.send("Page.navigate", json!({ "url": url }));
        self.wait("document.documentElement?.dataset.drawn")
            .as_str()
            .unwrap()
            .parse()
            .unwrap()
    }

    /// Seconds of work of the page's thread so far, which other programs do not change.
    pub fn worked_s(&mut self) -> f64 {
        let metrics = self.send("Performance.getMetrics", json!({}))["metrics"].clone();
        let task = metrics
            .as_array()
            .unwrap()
            .iter()
            .find(|metric| metric["name"] == "TaskDuration")
            .unwrap();
        task["value"].as_f64().unwrap()
    }

    pub fn open_file(&mut self, path: &Path) -> u64 {
        self.open(&format!(
            "file://{}",
            path.canonicalize().unwrap().display()
        ))
    }

    /// Loads the page again and waits until it has drawn itself.
    pub fn reload(&mut self) {
        self.eval("document.documentElement.dataset.old = 'true'");
        self.send("Page.reload", json!({}));
        self.wait(
            "!document.documentElement?.dataset.old && document.documentElement?.dataset.drawn",
        );
    }

    /// The value of an expression in the page.
    pub fn eval(&mut self, expression: &str) -> Value {
        self.evaluated(expression)
            .unwrap_or_else(|error| panic!("{expression}: {error}"))
    }

    /// The value of an expression, or the error of the browser.
    fn evaluated(&mut self, expression: &str) -> Result<Value, Value> {
        let asked = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let answer = self.ask("Runtime.evaluate", asked)?;
        assert!(
            answer.get("exceptionDetails").is_none(),
            "{expression}: {answer}"
        );
        Ok(answer["result"]["value"].clone())
    }

    /// Waits until an expression is true, and returns its value. During a navigation there is
    /// none.
    pub fn wait(&mut self, expression: &str) -> Value {
        let start = Instant::now();
        loop {
            let value = match self.evaluated(expression) {
                Err(error) if error["message"] == NAVIGATES => Value::Null,
                other => other.unwrap_or_else(|error| panic!("{expression}: {error}")),
            };
            if !matches!(value, Value::Null | Value::Bool(false)) {
                return value;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "never true: {expression}; {:?}",
                self.complaints
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Text of an element, or the value of an input; of a button its text.
    pub fn text(&mut self, selector: &str) -> String {
        let value =
            self.eval(&format!("(() => {{ const e = document.querySelector({}); return e.matches('button') ? e.textContent : e.value ?? e.textContent; }})()", json!(selector)));
        value.as_str().unwrap().to_owned()
    }

    /// Brings an element into view, where it is drawn; returns its left upper corner in the window and
    /// its size.
    pub fn place(&mut self, selector: &str) -> [f64; 4] {
        let found = format!(
            "(async () => {{ const e = document.querySelector({}); \
             const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done))); \
             for (let k = 0; k < 2; k++) {{ e.scrollIntoView({{block: 'center'}}); await frame(); }} \
             const r = e.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; }})()",
            json!(selector)
        );
        serde_json::from_value(self.eval(&found)).unwrap()
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], buttons: u32) {
        let event = json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1});
        self.send("Input.dispatchMouseEvent", event);
    }

    pub fn hover(&mut self, at: [f64; 2]) {
        self.mouse("mouseMoved", at, 0);
    }

    pub fn click(&mut self, at: [f64; 2]) {
        self.drag(at, at);
    }

    /// Presses at one place, moves to another, and releases.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.drag_and_hold(from, to);
        self.release(to);
    }

    /// Presses at one place and moves to another.
    pub fn drag_and_hold(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.mouse("mouseMoved", from, 0);
        self.mouse("mousePressed", from, 1);
        for part in [0.3, 0.7, 1.0] {
            self.mouse(
                "mouseMoved",
                [0, 1].map(|k| from[k] + part * (to[k] - from[k])),
                1,
            );
        }
    }

    /// Moves on while the button is pressed.
    pub fn move_to(&mut self, to: [f64; 2]) {
        self.mouse("mouseMoved", to, 1);
    }

    /// Releases the button.
    pub fn release(&mut self, at: [f64; 2]) {
        self.mouse("mouseReleased", at, 0);
    }

    pub fn key(&mut self, key: &str) {
        self.keys(key, 1);
    }

    /// Presses a key several times.
    pub fn keys(&mut self, key: &str, times: usize) {
        for _ in 0..times {
            self.key_with(key, 0);
        }
    }

    /// Presses a key with modifiers held down: 2 is Ctrl, 8 is Shift.
    pub fn key_with(&mut self, key: &str, modifiers: u32) {
        for kind in ["keyDown", "keyUp"] {
            let event = json!({"type": kind, "key": key, "modifiers": modifiers});
            self.send("Input.dispatchKeyEvent", event);
        }
    }

    /// The view of the window, as PNG.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let data = self.send("Page.captureScreenshot", json!({"format": "png"}))["data"].clone();
        STANDARD.decode(data.as_str().unwrap()).unwrap()
    }

    /// Errors of scripts and refused loads so far.
    pub fn complaints(&mut self) -> Vec<String> {
        self.eval("1");
        self.complaints.clone()
    }

    fn send(&mut self, method: &str, params: Value) -> Value {
        self.ask(method, params)
            .unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// The answer of the browser, or its error.
    fn ask(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        self.last += 1;
        let id = self.last;
        let mut message = json!({"id": id, "method": method, "params": params});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else {
                continue;
            };
            let said: Value = serde_json::from_str(text.as_str()).unwrap();
            if said["id"] == id {
                return match said.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(said["result"].clone()),
                };
            }
            match said["method"].as_str() {
                Some("Runtime.exceptionThrown") => self
                    .complaints
                    .push(said["params"]["exceptionDetails"].to_string()),
                Some("Log.entryAdded") if said["params"]["entry"]["level"] == "error" => {
                    self.complaints.push(said["params"]["entry"].to_string())
                }
                _ => {}
            }
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        drop(self.browser.kill());
        drop(self.browser.wait());
    }
}

fn launch(name: &str, profile: &Path) -> Option<Child> {
    let data = format!("--user-data-dir={}", profile.display());
    let flags = [
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        "--no-first-run",
        "--remote-debugging-port=0",
        &data,
        "about:blank",
    ];
    Command::new(name)
        .args(flags)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()
}

/// Port and path of the browser's socket, from its profile.
fn devtools_url(profile: &Path) -> Option<String> {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        let text = std::fs::read_to_string(profile.join("DevToolsActivePort")).unwrap_or_default();
        if let Some((port, path)) = text.split_once('\n') {
            if !path.is_empty() {
                return Some(format!("ws://127.0.0.1:{port}{}", path.trim()));
            }
        }
        std::thread::sleep(Duration::from_millis(30));
    }
    None
}
