//! Tests the page in a browser with mouse, fingers, keys and files, and compares its bits with the
//! command's.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::browser::{At, Browser};
use super::folder;
use super::server::Server;
use super::textured;
use crate::{Outcome, WITHOUT_GRAPHICS, cargo, root, run_to_end, target};

/// Scenes that must have the same bits in the page as in the command, and their number of steps.
const SAME: [(&str, u32); 8] = [
    ("hello", 120),
    ("stack:n=10", 240),
    ("pyramid:base=10", 240),
    ("ragdolls:n=4", 120),
    ("rings", 60),
    ("arch", 120),
    ("convex_pile", 30),
    ("convex_vs_mesh", 30),
];

/// Runs all parts, or the parts of these names. Each has its own page, so each can be run alone.
pub(super) fn run(names: &[&str]) -> Outcome {
    if !folder().join("drystone_bg.wasm").exists() {
        return Err(format!("{}: no page; `cargo xtask web build` makes it", folder().display()));
    }
    if let Some(unknown) = names.iter().find(|name| PARTS.iter().all(|part| part.name != **name)) {
        let known: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
        return Err(format!("{unknown}: no part of the test; there are {}", known.join(", ")));
    }
    let work = target().join("web-test");
    let _ = fs::remove_dir_all(&work);
    fs::create_dir_all(&work).map_err(|e| format!("{}: {e}", work.display()))?;
    let parts = || PARTS.iter().filter(|part| names.is_empty() || names.contains(&part.name));
    let built = std::env::var_os(COMMAND).is_some();
    if !built && parts().any(|part| WITH_COMMAND.contains(&part.name)) {
        // Built here, so that no part's time includes the compilation.
        let mut build = cargo();
        build.args(["build", "--quiet", "--release", "--package", "drystone-app"]);
        run_to_end(build.args(WITHOUT_GRAPHICS))?;
    }
    let server = Server::start(0, vec![folder(), work.clone()])?;
    let page = format!("http://{}/", server.address());
    let mut failures = Vec::new();
    for part in parts() {
        // Each part has its own browser, so that a hang affects no other part.
        let browser = Browser::start(&work.join(format!("profile-{}", part.name)))?;
        let mut test = Test { browser, work: work.clone(), page: page.clone() };
        let begin = Instant::now();
        let outcome = test.go_through(part);
        println!("   {}: {}, {:.0} s", part.name, part.what, begin.elapsed().as_secs_f64());
        if let Err(why) = outcome {
            println!("   FAILED: {why}");
            failures.push(part.name);
        }
    }
    println!("   pictures are in {}", work.display());
    if failures.is_empty() {
        Ok(())
    } else {
        let names = failures.join(" ");
        Err(format!("`cargo xtask web test {names}` runs what failed again"))
    }
}

/// Environment variable with the path of a command that is already built.
const COMMAND: &str = "DRYSTONE_COMMAND";

/// Environment variable with a factor on the time limits, for busy machines.
const PATIENCE: &str = "DRYSTONE_PATIENCE";

/// The parts that need the command in addition to the page.
const WITH_COMMAND: [&str; 4] = ["files", "textures", "film", "hashes"];

/// A part of the test.
struct Part {
    name: &'static str,
    /// The condition that holds if it passes.
    what: &'static str,
    /// Time limit [s]: many times the usual time, because pictures are drawn in software on a
    /// machine that may be busy. A part that hangs ends then, and the next part runs.
    seconds: u64,
    run: fn(&mut Test) -> Outcome,
}

const fn part(
    name: &'static str,
    seconds: u64,
    what: &'static str,
    run: fn(&mut Test) -> Outcome,
) -> Part {
    Part { name, what, seconds, run }
}

const PARTS: &[Part] = &[
    part("opens", 120, "the page shows a scene", opens),
    part("fingers", 240, "a finger pulls a body, two move the view", fingers),
    part("files", 400, "files that are dropped open, or say why not", files),
    part(
        "textures",
        300,
        "a file's meshes have their textures, and its broken image a note",
        textures,
    ),
    part("film", 300, "a film is played", film),
    part("hashes", 600, "hashes are those of the command", hashes),
    part("catalog", 180, "a click opens a scene of the catalog", catalog),
    part("time", 240, "buttons and keys stop, step and go back", time),
    part("mouse", 240, "the mouse pulls a body", pulls),
    part("method", 240, "the method changes as it runs", method),
    part("small", 180, "a small page has its panel aside", small),
];

struct Test {
    browser: Browser,
    work: PathBuf,
    page: String,
}

impl Test {
    /// Runs a part on a fresh page, and saves a picture if it fails.
    fn go_through(&mut self, part: &Part) -> Outcome {
        let patience = std::env::var(PATIENCE).ok().and_then(|text| text.parse::<u64>().ok());
        let seconds = part.seconds.saturating_mul(patience.unwrap_or(1).clamp(1, 100));
        self.browser.limit(Duration::from_secs(seconds));
        let outcome = self.browser.resize(720, 480).and_then(|()| (part.run)(self));
        let complaints = self.browser.complaints();
        let outcome = outcome.and_then(|()| match complaints.as_slice() {
            [] => Ok(()),
            _ => Err(format!("the page complains: {complaints:?}")),
        });
        outcome.map_err(|why| {
            let picture = self.work.join(format!("{}-failed.png", part.name));
            self.browser.limit(Duration::from_secs(20));
            match self.browser.picture(&picture) {
                Ok(_) => format!("{why}\n{} shows it", picture.display()),
                Err(_) => why,
            }
        })
    }

    fn go_to(&mut self, address: &str) -> Outcome {
        self.browser.open(&format!("{}{address}", self.page))?;
        self.browser
            .wait_for("the first picture", |state| state["places"]["picture"].is_array())?;
        Ok(())
    }

    /// Opens a scene with the page's own function.
    fn scene(&mut self, name: &str) -> Outcome {
        self.browser.value("drystone_play(false)")?;
        self.browser.value(&format!("drystone_open({name:?})"))?;
        let is_there = |s: &Value| s["scene"] == name && s["step"] == 0 && s["playing"] == false;
        self.browser.wait_for(name, is_there).map(drop)
    }

    /// The hash of the page's scene after some steps.
    fn hash_after(&mut self, steps: u32) -> Result<String, String> {
        self.browser.value(&format!("drystone_seek({steps})"))?;
        let what = format!("step {steps}");
        let state = self.browser.wait_for(&what, |s| s["step"] == steps && hash(s).is_some())?;
        hash(&state).ok_or(what)
    }

    /// The hash from the command for a scene or a file after some steps.
    fn hash_of_command(&self, scene: &str, steps: u32, more: &[&str]) -> Result<String, String> {
        let report = self.work.join("report.json");
        let built = std::env::var_os(COMMAND).map(PathBuf::from);
        let mut command = Command::new(built.unwrap_or_else(|| target().join("release/drystone")));
        command.current_dir(root()).args(["simulate", scene, "--steps"]);
        command.arg(steps.to_string()).arg("--report").arg(&report).args(more);
        run_to_end(command.stdout(Stdio::null()))?;
        let text = fs::read_to_string(&report).map_err(|e| e.to_string())?;
        let report: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
        report["hash"]
            .as_str()
            .map(str::to_owned)
            .ok_or_else(|| "a report without a hash".to_owned())
    }

    /// Takes a picture, which must not be empty: a picture of one color has only some kilobytes.
    fn picture(&mut self, name: &str) -> Outcome {
        let size = self.browser.picture(&self.work.join(name))?;
        if size > 20_000 { Ok(()) } else { Err(format!("{name} has {size} bytes: it is empty")) }
    }

    /// Number of pixels of a picture whose red, green and blue are within these ranges.
    fn points(&mut self, name: &str, ranges: [[u8; 2]; 3]) -> Result<f64, String> {
        let script = format!(
            "fetch({name:?}).then(answer => answer.blob()).then(createImageBitmap).then(image => {{
                const pen = new OffscreenCanvas(image.width, image.height).getContext('2d');
                pen.drawImage(image, 0, 0);
                const {{ data }} = pen.getImageData(0, 0, image.width, image.height);
                const ranges = {ranges:?};
                let count = 0;
                for (let i = 0; i < data.length; i += 4)
                    count += ranges.every(([low, high], c) => low <= data[i + c] && data[i + c] <= high);
                return count;
            }})"
        );
        self.browser.value(&script)?.as_f64().ok_or_else(|| format!("{name}: no count of points"))
    }
}

fn hash(state: &Value) -> Option<String> {
    state["views"][0]["hash"].as_str().map(str::to_owned)
}

fn opens(test: &mut Test) -> Outcome {
    test.go_to("?scene=wall:ball=1&paused")?;
    let state = test.browser.state()?;
    check(state["scene"] == "wall:ball=1" && state["playing"] == false, &state)?;
    test.picture("wall.png")
}

fn catalog(test: &mut Test) -> Outcome {
    test.go_to("?scene=hello&paused")?;
    test.browser.click("scenes")?;
    let At(x, y) = test.browser.place("scenes")?;
    test.browser.scroll_to("scene stack", At(x, y + 200.0))?;
    test.picture("catalog.png")?;
    test.browser.click("scene stack")?;
    test.browser.wait_for("the scene stack", |s| s["scene"] == "stack")?;
    Ok(())
}

fn time(test: &mut Test) -> Outcome {
    test.go_to("?scene=hello&paused")?;
    let b = &mut test.browser;
    b.click("step")?;
    b.wait_for("a step by the button", |s| s["step"] == 1)?;
    b.key("ArrowRight", "ArrowRight", 39)?;
    b.wait_for("a step by the key", |s| s["step"] == 2)?;
    b.key("ArrowLeft", "ArrowLeft", 37)?;
    b.wait_for("a step back", |s| s["step"] == 1 && s["furthest"] == 2)?;
    b.click("play")?;
    b.wait_for("it runs", |s| s["playing"] == true && s["step"].as_u64() > Some(10))?;
    b.key(" ", "Space", 32)?;
    b.wait_for("it stands", |s| s["playing"] == false)?;
    b.click("first")?;
    b.wait_for("the beginning", |s| s["step"] == 0)?;
    b.value("drystone_speed(0.1); drystone_play(true)")?;
    // Pictures between steps: the step number stays while time advances.
    b.wait_for("slow motion", |s| s["step"].as_u64() > Some(3))?;
    b.value("drystone_speed(1); drystone_play(false)").map(drop)
}

/// Position of the single cube of `stack:n=1` in the picture, and the height at which it is held
/// [m].
fn middle(test: &mut Test) -> Result<At, String> {
    test.go_to("?scene=stack:n=1&paused")?;
    let at = test.browser.place("picture")?;
    test.browser.click_at(at)?;
    let is_cube = |s: &Value| s["picked"].as_str().is_some_and(|title| title.contains("cube 0"));
    test.browser.wait_for("the cube is picked", is_cube)?;
    test.browser.value("drystone_play(true)")?;
    Ok(at)
}

fn height(state: &Value, end: &str) -> f64 {
    state["held"][end][1].as_f64().unwrap_or(f64::NAN)
}

/// Waits until the held body has followed the pointer to within 0.1 m and is at least 0.2 m higher,
/// at least at its corner: 200 px are 0.4 m there.
fn follows(test: &mut Test, start: f64) -> Outcome {
    let near = |s: &Value| (height(s, "from") - height(s, "to")).abs() < 0.1;
    let up = |s: &Value| height(s, "from") > start + 0.2;
    test.browser.wait_for("the cube follows", |s| near(s) && up(s)).map(drop)
}

fn pulls(test: &mut Test) -> Outcome {
    let At(x, y) = middle(test)?;
    test.browser.mouse("mouseMoved", At(x, y), false)?;
    test.browser.mouse("mousePressed", At(x, y), true)?;
    test.browser.mouse("mouseMoved", At(x + 15.0, y), true)?;
    let state = test.browser.wait_for("the cube is held", |s| s["held"].is_object())?;
    let start = height(&state, "from");
    for i in 1..=5 {
        let i = f64::from(i);
        test.browser.mouse("mouseMoved", At(x + 30.0 * i, y - 40.0 * i), true)?;
    }
    follows(test, start)?;
    test.picture("held.png")?;
    test.browser.mouse("mouseReleased", At(x + 150.0, y - 200.0), false)?;
    test.browser.wait_for("the cube is let go", |s| s["held"].is_null()).map(drop)
}

fn fingers(test: &mut Test) -> Outcome {
    test.browser.fingers()?;
    let At(x, y) = middle(test)?;
    test.browser.touch("touchStart", &[At(x, y)])?;
    // The browser tolerates 15 px of motion for a finger that stands still.
    test.browser.touch("touchMove", &[At(x, y - 40.0)])?;
    let state = test.browser.wait_for("the cube is held", |s| s["held"].is_object())?;
    let start = height(&state, "from");
    for i in 1..=4 {
        test.browser.touch("touchMove", &[At(x, y - 40.0 - 40.0 * f64::from(i))])?;
    }
    follows(test, start)?;
    test.picture("finger.png")?;
    // A second finger moves the view and releases the cube.
    let second = At(x - 100.0, y);
    test.browser.touch("touchStart", &[At(x, y - 200.0), second])?;
    test.browser.touch("touchMove", &[At(x + 20.0, y - 220.0), At(x - 120.0, y + 20.0)])?;
    test.browser.wait_for("the cube is let go", |s| s["held"].is_null())?;
    test.picture("fingers.png")?;
    test.browser.touch("touchEnd", &[])
}

fn method(test: &mut Test) -> Outcome {
    test.go_to("?scene=pyramid:base=6&paused")?;
    // The settings are at the bottom, so the panel scrolls to them.
    let At(x, y) = test.browser.place("hide")?;
    test.browser.scroll_to("method", At(x, y + 300.0))?;
    test.browser.value("drystone_play(true)")?;
    let before = test.browser.wait_for("it runs", |s| s["step"].as_u64() > Some(10))?;
    test.browser.click("method")?;
    test.browser.place("method soft-step-relax")?;
    test.picture("method.png")?;
    test.browser.click("method soft-step-relax")?;
    let after = test.browser.wait_for("the other method", |s| {
        s["views"][0]["method"] == "soft-step-relax" && s["step"].as_u64() > before["step"].as_u64()
    })?;
    check(before["views"][0]["method"] == "soft-step", &before)?;
    check(after["playing"] == true, &after)?;
    test.browser.key("m", "KeyM", 77)?;
    test.browser
        .wait_for("the next method", |s| s["views"][0]["method"] != "soft-step-relax")
        .map(drop)
}

fn hashes(test: &mut Test) -> Outcome {
    test.go_to("?scene=hello&paused")?;
    for (scene, steps) in SAME {
        test.scene(scene)?;
        let page = test.hash_after(steps)?;
        let command = test.hash_of_command(scene, steps, &[])?;
        println!("     {scene}, {steps} steps: {page}");
        if page != command {
            return Err(format!(
                "{scene} after {steps} steps: the page has {page}, the command {command}"
            ));
        }
    }
    Ok(())
}

fn files(test: &mut Test) -> Outcome {
    test.go_to("?scene=wall&paused")?;
    let at = test.browser.place("picture")?;
    let file = |name: &str| test.work.join(name);
    let (broken, huge, good) = (file("broken.glb"), file("huge.glb"), file("good.glb"));
    let (cut, other) = (file("cut.glb"), file("other.txt"));
    let io = |e: std::io::Error| e.to_string();
    fs::write(&broken, b"glTF\x02\x00\x00\x00 nonsense").map_err(io)?;
    fs::write(&other, "nothing to see").map_err(io)?;
    File::create(&huge).and_then(|f| f.set_len(65 << 20)).map_err(io)?;
    let bake = good.display().to_string();
    test.hash_of_command("wall", 1, &["--bake", &bake])?;
    let whole = fs::read(&good).map_err(io)?;
    fs::write(&cut, &whole[..whole.len() / 2]).map_err(io)?;
    for (path, says) in
        [(&broken, "glb"), (&cut, "ends before"), (&other, "JSON"), (&huge, "the maximum is 64 MB")]
    {
        refused(test, path, says, at)?;
    }
    test.picture("refused.png")?;
    test.browser.drop_file(&good, at)?;
    let opened = |name: &'static str| {
        move |s: &Value| s["scene"] == name && s["message"].is_null() && s["step"] == 0
    };
    test.browser.wait_for("the file is open", opened("good.glb"))?;
    let page = test.hash_after(60)?;
    let command = test.hash_of_command(&bake, 60, &[])?;
    if page != command {
        return Err(format!("good.glb: the page has {page}, the command {command}"));
    }
    test.picture("dropped.png")?;
    // Files that the page's own scripts drop are accepted too, valid or broken.
    test.browser.drop_by_script("good.glb", "script.glb")?;
    test.browser.wait_for("the script's file is open", opened("script.glb"))?;
    test.browser.drop_by_script("broken.glb", "script-broken.glb")?;
    let told = |s: &Value| s["message"].as_str().is_some_and(|m| m.contains("script-broken.glb"));
    let state = test.browser.wait_for("the script's broken file is told of", told)?;
    check(state["scene"] == "script.glb", &state)
}

/// Drops a file that cannot be opened, and reads the message; the previous scene stays.
fn refused(test: &mut Test, path: &Path, says: &str, at: At) -> Outcome {
    let before = test.browser.state()?;
    test.browser.drop_file(path, at)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let told =
        |s: &Value| s["message"].as_str().is_some_and(|m| m.contains(&name) && m.contains(says));
    let state = test.browser.wait_for(&format!("{name}: a message with \"{says}\""), told)?;
    check(state["scene"] == before["scene"], &state)
}

/// Ranges of red, green and blue that count as red, green, blue, yellow and magenta pixels of a
/// picture.
const COLORS: [(&str, [[u8; 2]; 3]); 5] = [
    ("red", [[110, 255], [0, 80], [0, 80]]),
    ("green", [[0, 90], [90, 255], [0, 90]]),
    ("blue", [[0, 80], [0, 110], [110, 255]]),
    ("yellow", [[120, 255], [100, 255], [0, 90]]),
    ("magenta", [[120, 255], [0, 110], [120, 255]]),
];

fn textures(test: &mut Test) -> Outcome {
    let file = test.work.join("textured.gltf");
    fs::write(&file, textured::file()).map_err(|e| e.to_string())?;
    test.go_to("?scene=hello&paused&bare")?;
    let at = test.browser.place("picture")?;
    test.browser.drop_file(&file, at)?;
    let state = test.browser.wait_for("the file is open", |s| s["scene"] == "textured.gltf")?;
    let notes = state["notes"].to_string();
    check(state["message"].is_null() && notes.contains("images[2].uri: is a broken PNG"), &state)?;
    test.picture("textures-note.png")?;
    // The note covers the picture until it is closed.
    test.browser.click("close")?;
    test.browser.wait_for("the note is gone", |s| s["places"]["close"].is_null())?;
    let page = test.hash_after(60)?;
    let command = test.hash_of_command(&file.display().to_string(), 60, &[])?;
    if page != command {
        return Err(format!("textured.gltf: the page has {page}, the command {command}"));
    }
    test.picture("textures.png")?;
    for (name, ranges) in COLORS {
        let count = test.points("textures.png", ranges)?;
        println!("     {name}: {count} points");
        if count < 150.0 {
            return Err(format!(
                "{name}: {count} points of textures.png, expected are 150 or more"
            ));
        }
    }
    Ok(())
}

fn film(test: &mut Test) -> Outcome {
    let bake = test.work.join("film.glb").display().to_string();
    test.hash_of_command("wall:ball=1", 90, &["--bake", &bake])?;
    test.browser.open(&format!("{}player.html?film=film.glb", test.page))?;
    let runs = |s: &Value| s["film"] == 90 && s["playing"] == true && s["step"].as_u64() > Some(20);
    test.browser.wait_for("the film runs", runs)?;
    test.browser.value("drystone_seek(60)")?;
    test.browser.wait_for("the moment", |s| s["step"] == 60 && s["playing"] == false)?;
    test.picture("film.png")?;
    let at = test.browser.place("time")?;
    // A slider follows a button that was pressed in a picture.
    test.browser.mouse("mouseMoved", at, false)?;
    test.browser.mouse("mousePressed", at, true)?;
    test.browser.mouse("mouseReleased", at, false)?;
    let middle = |s: &Value| s["step"].as_u64().is_some_and(|step| (40..=50).contains(&step));
    test.browser.wait_for("half of the film by the time line", middle)?;
    test.browser.value("drystone_seek(90); drystone_play(true)")?;
    let again =
        |s: &Value| s["playing"] == true && s["step"].as_u64().is_some_and(|step| step < 45);
    test.browser.wait_for("it begins again", again)?;
    test.browser.open(&format!("{}player.html?film=nothing.glb", test.page))?;
    let note = "document.getElementById('note')?.textContent ?? ''";
    test.browser.wait_until(note, |text| text.contains("404"))?;
    // The browser reports this in its own log.
    test.browser.complaints();
    Ok(())
}

fn small(test: &mut Test) -> Outcome {
    test.browser.resize(400, 300)?;
    test.go_to("?scene=pyramid:base=6")?;
    test.browser.wait_for("it runs", |s| s["step"].as_u64() > Some(30))?;
    test.picture("small.png")?;
    test.browser.click("panel")?;
    test.browser.place("scenes")?;
    test.picture("small-panel.png")?;
    test.browser.click("hide")?;
    test.browser.place("panel")?;
    test.browser.resize(720, 480)?;
    test.picture("pyramid.png")
}

fn check(holds: bool, state: &Value) -> Outcome {
    if holds { Ok(()) } else { Err(format!("the state is {state}")) }
}
