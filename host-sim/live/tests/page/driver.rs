//! Drives a browser through the protocol of `chromedriver` (W3C `WebDriver`), and serves the page's
//! folder.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// A browser that shows the page.
pub struct Browser {
    driver: Child,
    port: u16,
    session: String,
    calls: u32,
    profile: tempfile::TempDir,
}

impl Browser {
    /// Starts a browser without a page; `None` if there is no browser.
    pub fn start() -> Option<Self> {
        let port = TcpListener::bind("127.0.0.1:0").ok()?.local_addr().ok()?.port();
        let mut driver = Command::new("chromedriver");
        let driver = driver.arg(format!("--port={port}")).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()?;
        let profile = tempfile::tempdir().ok()?;
        let mut browser = Self { driver, port, session: String::new(), calls: 0, profile };
        let begun = Instant::now();
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            assert!(begun.elapsed() < crate::LONGEST, "chromedriver does not answer");
            std::thread::sleep(Duration::from_millis(50));
        }
        let data = format!("--user-data-dir={}", browser.profile.path().display());
        let arguments = [
            "--headless=new",
            "--no-sandbox",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--enable-precise-memory-info",
            "--window-size=1280,800",
            "--enable-unsafe-swiftshader",
            "--use-angle=swiftshader",
            &data,
        ];
        let wanted =
            json!({"capabilities": {"alwaysMatch": {"browserName": "chrome", "goog:chromeOptions": {"args": arguments}}}});
        let made = browser.call("POST", "/session", Some(&wanted));
        browser.session = made["sessionId"].as_str()?.to_owned();
        let rect = json!({"width": 1280, "height": 800});
        browser.command("POST", "/window/rect", Some(&rect));
        Some(browser)
    }

    /// Opens another page.
    pub fn go(&mut self, url: &str) {
        self.command("POST", "/url", Some(&json!({"url": url})));
    }

    /// Displayed state of the page, in numbers.
    pub fn shown(&mut self) -> Value {
        self.run("return window.palpate ? window.palpate.shown() : {said: document.body.innerText};")
    }

    /// Time since the page began to load [s].
    pub fn seconds_since_load(&mut self) -> f64 {
        self.run("return performance.now() * 1e-3;").as_f64().unwrap_or(f64::NAN)
    }

    /// The bytes of the last recording.
    pub fn trace(&mut self) -> Vec<u8> {
        let bytes = self.run("return Array.from(window.palpate.trace());");
        bytes.as_array().unwrap().iter().map(|b| b.as_u64().unwrap() as u8).collect()
    }

    /// Moves the mouse, and presses its button or releases it.
    pub fn mouse(&mut self, x: u32, y: u32, down: Option<bool>) {
        let mut steps = vec![json!({"type": "pointerMove", "duration": 50, "x": x, "y": y})];
        if let Some(down) = down {
            steps.push(json!({"type": if down { "pointerDown" } else { "pointerUp" }, "button": 0}));
        }
        let mouse = json!({"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": steps});
        self.command("POST", "/actions", Some(&json!({"actions": [mouse]})));
    }

    /// Sends a command of the browser's own protocol.
    pub fn devtools(&mut self, command: &str, parameters: &Value) -> Value {
        self.command("POST", "/goog/cdp/execute", Some(&json!({"cmd": command, "params": parameters})))
    }

    /// Puts another tab in front of the page for a number of seconds.
    pub fn behind_another_tab(&mut self, seconds: u64) {
        let page = self.command("GET", "/window", None);
        let other = self.command("POST", "/window/new", Some(&json!({"type": "tab"})));
        self.command("POST", "/window", Some(&json!({"handle": other["handle"]})));
        std::thread::sleep(Duration::from_secs(seconds));
        self.command("DELETE", "/window", None);
        self.command("POST", "/window", Some(&json!({"handle": page})));
    }

    /// Number of calls of the driver so far.
    pub fn calls(&self) -> u32 {
        self.calls
    }

    /// Resident memory of the processes that draw and compute the page [MB].
    pub fn resident_mb(&self) -> f64 {
        let mark = self.profile.path().display().to_string();
        let processes = std::fs::read_dir("/proc").unwrap().flatten();
        let one = |folder: PathBuf| {
            let command = std::fs::read(folder.join("cmdline")).ok()?;
            let command = String::from_utf8_lossy(&command).into_owned();
            if !command.contains(&mark) || !command.contains("--type=renderer") {
                return None;
            }
            let status = std::fs::read_to_string(folder.join("status")).ok()?;
            let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
            line.trim().trim_end_matches("kB").trim().parse::<f64>().ok()
        };
        processes.filter_map(|p| one(p.path())).sum::<f64>() * 1e-3
    }

    /// Drops a file on the picture.
    pub fn drop_file(&mut self, name: &str, bytes: &[u8]) {
        let script = "const files = new DataTransfer();
            files.items.add(new File([new Uint8Array(arguments[1])], arguments[0]));
            const on = document.getElementById('picture');
            for (const kind of ['dragenter', 'dragover', 'drop'])
                on.dispatchEvent(new DragEvent(kind, {dataTransfer: files, bubbles: true, cancelable: true}));";
        self.command("POST", "/execute/sync", Some(&json!({"script": script, "args": [name, bytes]})));
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str) {
        let steps = [
            json!({"type": "keyDown", "value": key}),
            json!({"type": "pause", "duration": 80}),
            json!({"type": "keyUp", "value": key}),
        ];
        self.command("POST", "/actions", Some(&json!({"actions": [{"type": "key", "id": "keys", "actions": steps}]})));
        std::thread::sleep(Duration::from_millis(200));
    }

    /// Screenshot of the page, as PNG.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let text = self.command("GET", "/screenshot", None);
        base64(text.as_str().unwrap())
    }

    /// Runs a script in the page and returns its value.
    pub fn run(&mut self, script: &str) -> Value {
        self.command("POST", "/execute/sync", Some(&json!({"script": script, "args": []})))
    }

    fn command(&mut self, method: &str, path: &str, body: Option<&Value>) -> Value {
        let path = format!("/session/{}{path}", self.session);
        self.call(method, &path, body)
    }

    fn call(&mut self, method: &str, path: &str, body: Option<&Value>) -> Value {
        self.calls += 1;
        let body = body.map(Value::to_string).unwrap_or_default();
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let length = body.len();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body.as_bytes()).unwrap();
        let answer = whole(&mut stream);
        let value: Value = serde_json::from_slice(&answer).unwrap_or_else(|e| panic!("{method} {path}: {e}"));
        let error = &value["value"]["error"];
        assert!(!error.is_string(), "{method} {path}: {}", value["value"]);
        value["value"].clone()
    }
}

impl Drop for Browser {
    /// Makes the driver end its browser, which would otherwise go on drawing. Errors are ignored,
    /// since a panic during a panic would abort.
    fn drop(&mut self) {
        if let (false, Ok(mut stream)) = (self.session.is_empty(), TcpStream::connect(("127.0.0.1", self.port))) {
            let head = format!("DELETE /session/{} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", self.session);
            let mut answer = [0; 64];
            let _ended = stream.set_read_timeout(Some(Duration::from_secs(10)));
            let _asked = stream.write_all(head.as_bytes()).and_then(|()| stream.read(&mut answer));
        }
        let _ended = self.driver.kill();
        let _reaped = self.driver.wait();
    }
}

/// Body of a response, with the length that its header gives.
fn whole(stream: &mut TcpStream) -> Vec<u8> {
    let (mut all, mut part) = (Vec::new(), [0; 65536]);
    loop {
        if let Some(at) = all.windows(4).position(|w| w == b"\r\n\r\n") {
            let head = String::from_utf8_lossy(&all[..at]).to_lowercase();
            let length = head.lines().find_map(|l| l.strip_prefix("content-length:")?.trim().parse::<usize>().ok()).unwrap_or(0);
            if all.len() >= at + 4 + length {
                return all[at + 4..].to_vec();
            }
        }
        let read = stream.read(&mut part).unwrap();
        assert!(read > 0, "chromedriver hung up");
        all.extend(&part[..read]);
    }
}

fn base64(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => u32::from(c - b'A'),
        b'a'..=b'z' => u32::from(c - b'a') + 26,
        b'0'..=b'9' => u32::from(c - b'0') + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u32> = text.bytes().filter(|c| *c != b'=').map(value).collect();
    let bytes = |four: &[u32]| {
        let word = four.iter().enumerate().fold(0, |w, (k, d)| w | d << (18 - 6 * k));
        word.to_be_bytes()[1..four.len()].to_vec()
    };
    digits.chunks(4).flat_map(bytes).collect()
}

/// Serves a folder and returns its address. If `knows_gz` is set, the server sends the header of
/// compressed content for `.gz` files, and the browser unpacks them before the page receives them.
pub fn serve(folder: &Path, knows_gz: bool) -> String {
    let folder = folder.to_path_buf();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let folder = folder.clone();
            std::thread::spawn(move || answer(stream, &folder, knows_gz));
        }
    });
    address
}

fn answer(mut stream: TcpStream, folder: &Path, knows_gz: bool) -> std::io::Result<()> {
    let mut asked = [0; 4096];
    let read = stream.read(&mut asked)?;
    let line = String::from_utf8_lossy(&asked[..read]).into_owned();
    let name = line.split_whitespace().nth(1).unwrap_or("/").trim_start_matches('/');
    let name = if name.is_empty() { "index.html" } else { name };
    let kind = match name.rsplit('.').next() {
        Some("js") => "text/javascript",
        Some("gz") if knows_gz => "application/wasm\r\nContent-Encoding: gzip",
        Some("gz") => "application/gzip",
        _ => "text/html",
    };
    let body = std::fs::read(folder.join(name));
    let status = if body.is_ok() { "200 OK" } else { "404 Not Found" };
    let body = body.unwrap_or_default();
    let length = body.len();
    let head = format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n");
    stream.write_all(head.as_bytes())?;
    stream.write_all(&body)
}
