//! The viewer in a web page: the functions that the page's script calls. `cargo xtask web` builds
//! it.

#![cfg(target_arch = "wasm32")]

mod files;
mod state;

use std::cell::RefCell;
use std::panic;

use drystone_view::Options;
use drystone_view::overlay::Overlays;
use drystone_view::sim::Command;
use drystone_view::web::{Page, show};
use js_sys::Function;
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};
use web_sys::HtmlCanvasElement;

thread_local! {
    static PAGE: RefCell<Option<Page>> = const { RefCell::new(None) };
    static FAILED: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// Shows a scene of the catalog, or the file that was dropped last, on a canvas. Returns the reason
/// if it cannot be opened. `failed` is called with a line of text when the viewer has to stop.
/// `panel` says whether the panel is visible at first; if undefined, it is visible if there is room
/// for it.
#[wasm_bindgen]
#[must_use]
pub fn start(
    canvas: HtmlCanvasElement,
    scene: &str,
    playing: bool,
    panel: Option<bool>,
    failed: Function,
) -> Option<String> {
    FAILED.with_borrow_mut(|f| *f = Some(failed));
    panic::set_hook(Box::new(|info| {
        fail(&format!(
            "drystone has a defect, please report it: {info}. Reload the page to go on."
        ));
    }));
    let opened = match files::open(scene) {
        Ok(opened) => opened,
        Err(why) => return Some(why),
    };
    let (open, overlays) = (Box::new(files::open), Overlays::default());
    let options = Options { opened, open, playing, overlays, panel };
    match show(options, canvas, Box::new(fail)) {
        Ok(page) => PAGE.with_borrow_mut(|p| *p = Some(page)),
        Err(why) => fail(&why.to_string()),
    }
    None
}

/// Reports to the page that the viewer has stopped.
fn fail(why: &str) {
    web_sys::console::error_1(&JsValue::from_str(why));
    // A second failure during the report of the first is not reported.
    let failed = FAILED.with(|f| f.try_borrow().ok().and_then(|f| f.clone()));
    if let Some(failed) = failed {
        let _ = failed.call1(&JsValue::NULL, &JsValue::from_str(why));
    }
}

fn send(command: Command) {
    PAGE.with_borrow(|page| {
        if let Some(page) = page {
            page.send(command);
        }
    });
}

/// The current state of the viewer as JSON; empty before the first picture. docs/web.md lists its
/// fields.
#[wasm_bindgen]
#[must_use]
pub fn drystone_state() -> String {
    PAGE.with_borrow(|page| page.as_ref().and_then(|p| p.look(state::json)).unwrap_or_default())
}

/// Opens a scene of the catalog: `pyramid`, `stack:n=20`.
#[wasm_bindgen]
pub fn drystone_open(scene: &str) {
    send(Command::Open(scene.to_owned()));
}

/// Opens a file that was dropped on the page; `film` plays its animations instead of simulating it.
#[wasm_bindgen]
pub fn drystone_open_file(name: &str, bytes: Vec<u8>, film: bool) {
    files::keep(name, Ok(bytes), film);
    send(Command::Open(name.to_owned()));
}

/// Stores the reason why a file that was dropped on the page cannot be opened.
#[wasm_bindgen]
pub fn drystone_refuse_file(name: &str, why: &str) {
    files::keep(name, Err(why.to_owned()), false);
    send(Command::Open(name.to_owned()));
}

/// Runs or pauses.
#[wasm_bindgen]
pub fn drystone_play(playing: bool) {
    send(Command::Play(playing));
}

/// Goes to a step, at most 600 beyond the furthest step so far, and pauses there.
#[wasm_bindgen]
pub fn drystone_seek(step: u32) {
    send(Command::Seek(u64::from(step)));
}

/// Sets the speed of time; 1 is real time.
#[wasm_bindgen]
pub fn drystone_speed(speed: f32) {
    send(Command::Speed(speed));
}
