//! A headless Chromium over its DevTools protocol.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Names of the executable on different systems.
const PROGRAMS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Script that returns the bytes of the picture with id `view`, read from a copy: a canvas that is read often is slow.
pub const VIEW_BYTES: &str =
    "(() => { const copy = new OffscreenCanvas(640, 480).getContext('2d', { willReadFrequently: true });
    copy.drawImage(document.getElementById('view'), 0, 0);
    return copy.getImageData(0, 0, 640, 480).data; })()";

/// A browser with one page.
pub struct Browser {
    child: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    last: u64,
    /// Console messages of the page, and uncaught errors.
    pub console: Vec<String>,
    _profile: tempfile::TempDir,
}

/// Reports a skipped test, bypassing the test harness's capture; fails if outside programs are required.
fn untested(cause: &str) {
    let promised = std::env::var_os("ROBOFIN_REQUIRE_OUTSIDE").is_some_and(|value| value == "1");
    assert!(!promised, "ROBOFIN_REQUIRE_OUTSIDE=1, but the workbench cannot be opened: {cause}");
    writeln!(std::io::stderr(), "NOT TESTED: the workbench in a browser: {cause}").expect("standard error is open");
}

impl Browser {
    /// Starts a browser; `None` after reporting a skipped test.
    pub fn start() -> Option<Self> {
        let starts =
            |program: &&&str| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
        let Some(program) = PROGRAMS.iter().find(starts) else {
            untested("no chromium is installed (apt-get install chromium)");
            return None;
        };
        let profile = tempfile::tempdir().expect("a temporary folder");
        let mut child = Command::new(program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
            .args(["--remote-debugging-port=0", "--window-size=1280,1000", "about:blank"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("it ran before");
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let address = lines.find_map(|line| line.ok()?.strip_prefix("DevTools listening on ").map(str::to_owned));
        // Later output must be drained.
        std::thread::spawn(move || lines.for_each(drop));
        let (socket, _) = tungstenite::connect(address.expect("it says where it listens")).expect("it listens there");
        let mut browser =
            Self { child, socket, session: String::new(), last: 0, console: Vec::new(), _profile: profile };
        let page = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let session = browser.call("Target.attachToTarget", json!({ "targetId": page["targetId"], "flatten": true }));
        session["sessionId"].as_str().expect("a session").clone_into(&mut browser.session);
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.call(domain, json!({}));
        }
        Some(browser)
    }

    /// Calls a method, and collects console messages meanwhile.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        let mut said = self.ask(method, parameters);
        assert!(said.get("error").is_none(), "{method}: {said}");
        said["result"].take()
    }

    /// The answer to a call: its result or its error.
    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(message.to_string())).expect("the browser listens");
        loop {
            let Message::Text(text) = self.socket.read().expect("the browser answers") else { continue };
            let said: Value = serde_json::from_str(&text).expect("JSON");
            if said["id"] == self.last {
                return said;
            }
            self.note(&said);
        }
    }

    fn note(&mut self, said: &Value) {
        let is_told = ["Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"];
        if said["method"].as_str().is_some_and(|method| is_told.contains(&method)) {
            self.console.push(said["params"].to_string());
        }
    }

    /// Opens an address.
    pub fn open(&mut self, url: &str) {
        self.call("Page.navigate", json!({ "url": url }));
        self.until("document.readyState === 'complete'", 20);
    }

    /// Opens the address of a link.
    pub fn follow(&mut self, selector: &str) {
        let address = self.value(&format!("document.querySelector({})?.href", json!(selector)));
        let address = address.as_str().unwrap_or_else(|| panic!("{selector} is no link on the page"));
        self.open(address);
    }

    /// Evaluates an expression.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call("Runtime.evaluate", asked);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// True if an expression is; a page that is being left is asked again later.
    fn is_true(&mut self, expression: &str) -> bool {
        let asked = json!({ "expression": format!("Boolean({expression})"), "returnByValue": true });
        let said = self.ask("Runtime.evaluate", asked);
        let is_left = said["error"]["message"] == "Inspected target navigated or closed";
        assert!(is_left || said.get("error").is_none(), "{expression}: {said}");
        assert!(said["result"].get("exceptionDetails").is_none(), "{expression}: {said}");
        said["result"]["result"]["value"] == true
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, expression: &str, seconds: u64) {
        let end = Instant::now() + Duration::from_secs(seconds);
        while !self.is_true(expression) {
            assert!(
                Instant::now() < end,
                "not within {seconds} s: {expression}\n{}",
                self.value("document.body.innerText")
            );
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Clicks on the centre of an element.
    pub fn click(&mut self, selector: &str) {
        self.value(&format!("document.querySelector({}).scrollIntoView({{block: 'center'}})", json!(selector)));
        let [x, y] = self.middle(selector);
        self.pointer([x, y], [x, y]);
    }

    /// Returns the centre of an element [px].
    pub fn middle(&mut self, selector: &str) -> [f64; 2] {
        let found = self.value(&format!(
            "(() => {{ const b = document.querySelector({}).getBoundingClientRect(); \
             return [b.left + b.width / 2, b.top + b.height / 2]; }})()",
            json!(selector)
        ));
        [0, 1].map(|k| found[k].as_f64().unwrap_or_else(|| panic!("{selector} is not on the page")))
    }

    /// Presses the mouse button at one position, moves, and releases it at another.
    pub fn pointer(&mut self, from: [f64; 2], to: [f64; 2]) {
        let mut event = |kind: &str, [x, y]: [f64; 2], buttons: u32| {
            let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        };
        event("mousePressed", from, 1);
        if from != to {
            for k in 1..=8 {
                let share = f64::from(k) / 8.0;
                event("mouseMoved", [0, 1].map(|i| from[i] + share * (to[i] - from[i])), 1);
            }
        }
        event("mouseReleased", to, 0);
    }

    /// Takes a screenshot as PNG.
    pub fn screenshot(&mut self, file: &Path) {
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let data = answer["data"].as_str().expect("a picture");
        std::fs::write(file, STANDARD.decode(data).expect("base64")).expect("a place for pictures");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ended = self.child.kill();
        let _waited = self.child.wait();
    }
}
