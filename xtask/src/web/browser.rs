//! A headless browser, driven by its DevTools protocol.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};

use super::socket::Socket;
use crate::Outcome;

pub(super) const PROGRAM: &str = "chromium";

/// Maximum time for the browser to start.
const START: Duration = Duration::from_secs(60);

/// A position on the page [px].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct At(pub(super) f64, pub(super) f64);

/// A browser with one page.
pub(super) struct Browser {
    child: Child,
    socket: Socket,
    session: String,
    number: u64,
    /// Errors that the page reported by itself.
    complaints: Vec<String>,
    /// Deadline of the current calls.
    end: Instant,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Browser {
    /// Starts the browser, with its data in a folder.
    pub(super) fn start(folder: &Path) -> Result<Self, String> {
        let mut command = Command::new(PROGRAM);
        command.args(["--headless=new", "--no-sandbox", "--no-first-run", "--disable-extensions"]);
        command.args(["--remote-debugging-port=0", "--mute-audio", "--hide-scrollbars"]);
        // WebGL without a GPU.
        command.args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]);
        command.arg(format!("--user-data-dir={}", folder.display())).arg("about:blank");
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|e| format!("{PROGRAM}: {e}"))?;
        let errors = child.stderr.take().ok_or("no stderr")?;
        let mut lines = BufReader::new(errors).lines();
        let url = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("DevTools listening on ").map(str::to_owned));
        // Drains the remaining output, so that the browser does not block on it.
        thread::spawn(move || lines.for_each(drop));
        let Some(url) = url else {
            let _ = child.kill();
            let _ = child.wait();
            return Err(format!("{PROGRAM} does not start"));
        };
        let socket = Socket::open(&url).map_err(|e| e.to_string())?;
        let (session, complaints, end) = (String::new(), Vec::new(), Instant::now() + START);
        let mut browser = Self { child, socket, session, number: 0, complaints, end };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }))?;
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", attach)?;
        session["sessionId"].as_str().unwrap_or_default().clone_into(&mut browser.session);
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.call(domain, json!({}))?;
        }
        Ok(browser)
    }

    /// Sets a time limit for all following calls.
    pub(super) fn limit(&mut self, time: Duration) {
        self.end = Instant::now() + time;
    }

    /// Calls a method and waits for its result.
    pub(super) fn call(&mut self, method: &str, params: Value) -> Result<Value, String> {
        self.send(method, params)?;
        loop {
            let left = self.end.saturating_duration_since(Instant::now());
            let text = self.socket.receive(left).map_err(|e| format!("{method}: {e}"))?;
            let mut message: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
            if message["id"] == self.number {
                return match message.get("error") {
                    Some(error) => Err(format!("{method}: {error}")),
                    None => Ok(message["result"].take()),
                };
            }
            match message["method"].as_str() {
                Some("Runtime.exceptionThrown") => {
                    let details = &message["params"]["exceptionDetails"];
                    let about = details["exception"]["description"].as_str();
                    self.complaints.push(about.unwrap_or("an exception").to_owned());
                }
                Some("Runtime.consoleAPICalled") if message["params"]["type"] == "error" => {
                    self.complaints.push(message["params"]["args"].to_string());
                }
                Some("Log.entryAdded") if message["params"]["entry"]["level"] == "error" => {
                    self.complaints.push(message["params"]["entry"]["text"].to_string());
                }
                _ => {}
            }
        }
    }

    /// Calls a method without waiting; the next call that waits discards its result.
    fn send(&mut self, method: &str, params: Value) -> Outcome {
        self.number += 1;
        let mut message = json!({ "id": self.number, "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.socket.send(&message.to_string()).map_err(|e| format!("{method}: {e}"))
    }

    /// Errors that the page reported since the last call.
    pub(super) fn complaints(&mut self) -> Vec<String> {
        std::mem::take(&mut self.complaints)
    }

    /// Sets the size of the page [px].
    pub(super) fn resize(&mut self, width: u32, height: u32) -> Outcome {
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size).map(drop)
    }

    pub(super) fn open(&mut self, url: &str) -> Outcome {
        self.call("Page.navigate", json!({ "url": url })).map(drop)
    }

    /// The value of an expression of JavaScript.
    pub(super) fn value(&mut self, expression: &str) -> Result<Value, String> {
        let params =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut result = self.call("Runtime.evaluate", params)?;
        if result.get("exceptionDetails").is_some() {
            return Err(format!("{expression}: {}", result["exceptionDetails"]));
        }
        Ok(result["result"]["value"].take())
    }

    /// The viewer's state; null before its first picture.
    pub(super) fn state(&mut self) -> Result<Value, String> {
        let text = self.value("globalThis.drystone_state?.() ?? ''")?;
        Ok(text.as_str().and_then(|text| serde_json::from_str(text).ok()).unwrap_or(Value::Null))
    }

    /// Waits until the viewer's state satisfies a condition.
    pub(super) fn wait_for(
        &mut self,
        what: &str,
        mut is_so: impl FnMut(&Value) -> bool,
    ) -> Result<Value, String> {
        loop {
            let state = self.state().map_err(|why| format!("{what}: {why}"))?;
            if is_so(&state) {
                return Ok(state);
            }
            if Instant::now() > self.end {
                self.limit(Duration::from_secs(20));
                let note = self.value("document.getElementById('note')?.textContent")?;
                let (complaints, state) = (self.complaints(), short(&state.to_string()));
                return Err(format!("not in time: {what}\n{state}\n{note}\n{complaints:?}"));
            }
            thread::sleep(Duration::from_millis(30));
        }
    }

    /// Waits until the text of an expression satisfies a condition.
    pub(super) fn wait_until(&mut self, expression: &str, is_so: impl Fn(&str) -> bool) -> Outcome {
        loop {
            let text = self.value(expression)?;
            if text.as_str().is_some_and(&is_so) {
                return Ok(());
            }
            if Instant::now() > self.end {
                return Err(format!("not in time: {expression}: {text}"));
            }
            thread::sleep(Duration::from_millis(30));
        }
    }

    /// The middle of a clickable item, once it stops moving.
    pub(super) fn place(&mut self, name: &str) -> Result<At, String> {
        let mut last = None;
        let state = self.wait_for(name, |state| {
            let (now, before) = (place(state, name), last);
            last = now;
            now.is_some() && now == before
        })?;
        place(&state, name).ok_or_else(|| name.to_owned())
    }

    /// Clicks the item of this name.
    pub(super) fn click(&mut self, name: &str) -> Outcome {
        let at = self.place(name)?;
        self.click_at(at)
    }

    pub(super) fn click_at(&mut self, at: At) -> Outcome {
        self.mouse("mouseMoved", at, false)?;
        // A button held down for long is not a click, and a picture may take long.
        self.send("Input.dispatchMouseEvent", mouse("mousePressed", at, true))?;
        self.mouse("mouseReleased", at, false)
    }

    /// Sends a mouse event; `down` says whether the left button is down after it.
    pub(super) fn mouse(&mut self, kind: &str, at: At, down: bool) -> Outcome {
        self.call("Input.dispatchMouseEvent", mouse(kind, at, down))?;
        self.frame()
    }

    /// Turns the wheel over a position until the item of this name is visible.
    pub(super) fn scroll_to(&mut self, name: &str, at: At) -> Outcome {
        // The wheel scrolls the item under the pointer, and does not move the pointer itself.
        self.mouse("mouseMoved", at, false)?;
        let height = self.value("innerHeight")?.as_f64().unwrap_or(0.0);
        for _ in 0..60 {
            // Items below the visible part of the page also have a position.
            if place(&self.state()?, name).is_some_and(|At(_, y)| y < height - 20.0) {
                return Ok(());
            }
            self.wheel(at, 200.0)?;
        }
        Err(format!("{name}: nowhere in the list"))
    }

    fn wheel(&mut self, At(x, y): At, down: f64) -> Outcome {
        let event = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": down });
        // Its result may arrive only after the next wheel event.
        self.send("Input.dispatchMouseEvent", event)?;
        self.frame()
    }

    /// Emulates a touch screen.
    pub(super) fn fingers(&mut self) -> Outcome {
        let touch = json!({ "enabled": true, "maxTouchPoints": 5 });
        self.call("Emulation.setTouchEmulationEnabled", touch).map(drop)
    }

    /// Sends a touch event; `fingers` are the fingers that are down after it.
    pub(super) fn touch(&mut self, kind: &str, fingers: &[At]) -> Outcome {
        let points: Vec<Value> =
            (0..).zip(fingers).map(|(id, At(x, y))| json!({ "x": x, "y": y, "id": id })).collect();
        self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }))?;
        self.frame()
    }

    /// Presses and releases a key, given by its name, the code of its position, and its number.
    pub(super) fn key(&mut self, key: &str, code: &str, number: u32) -> Outcome {
        for kind in ["rawKeyDown", "keyUp"] {
            let event = json!({
                "type": kind, "key": key, "code": code, "windowsVirtualKeyCode": number
            });
            self.call("Input.dispatchKeyEvent", event)?;
        }
        self.frame()
    }

    /// Drops a file on the page.
    pub(super) fn drop_file(&mut self, file: &Path, At(x, y): At) -> Outcome {
        let data = json!({
            "items": [], "files": [file.display().to_string()], "dragOperationsMask": 1
        });
        for kind in ["dragEnter", "dragOver", "drop"] {
            let event = json!({ "type": kind, "x": x, "y": y, "data": data });
            self.call("Input.dispatchDragEvent", event)?;
        }
        Ok(())
    }

    /// Makes a script on the page drop a file of the server, under another name.
    pub(super) fn drop_by_script(&mut self, file: &str, name: &str) -> Outcome {
        let script = format!(
            "fetch({file:?}).then(answer => answer.arrayBuffer()).then(bytes => {{
                const data = new DataTransfer();
                data.items.add(new File([bytes], {name:?}));
                const options = {{ dataTransfer: data, bubbles: true, cancelable: true }};
                document.getElementById('canvas').dispatchEvent(new DragEvent('drop', options));
            }})"
        );
        self.value(&script).map(drop)
    }

    /// Waits until the page has drawn a picture.
    pub(super) fn frame(&mut self) -> Outcome {
        let wait = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))";
        self.value(wait).map(drop)
    }

    /// Writes a screenshot into a PNG file; returns its size [bytes].
    pub(super) fn picture(&mut self, file: &Path) -> Result<usize, String> {
        self.frame()?;
        let result = self.call("Page.captureScreenshot", json!({ "format": "png" }))?;
        let data = result["data"].as_str().unwrap_or_default();
        let bytes = base64::engine::general_purpose::STANDARD.decode(data);
        let bytes = bytes.map_err(|e| e.to_string())?;
        std::fs::write(file, &bytes).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(bytes.len())
    }
}

fn mouse(kind: &str, At(x, y): At, down: bool) -> Value {
    let button = if kind == "mouseMoved" && !down { "none" } else { "left" };
    let (buttons, clicks) = (u8::from(down), u8::from(kind != "mouseMoved"));
    json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": clicks })
}

/// The middle of a clickable item.
fn place(state: &Value, name: &str) -> Option<At> {
    let number = |i: usize| state["places"][name][i].as_f64();
    Some(At((number(0)? + number(2)?) / 2.0, (number(1)? + number(3)?) / 2.0))
}

fn short(text: &str) -> String {
    text.chars().take(2000).collect()
}
