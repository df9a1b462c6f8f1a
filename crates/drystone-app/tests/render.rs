//! Pictures and windows as users of the command get them. Where there is no graphics device, no
//! display in memory or no ffmpeg a test says so and is left out.

#![cfg(feature = "render")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::folder;

fn drystone(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drystone"));
    command.args(line.split(' ')).current_dir(folder).stdin(Stdio::null());
    command
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs the command, which must succeed. None, and a line that says so, where nothing can draw.
fn drawn(folder: &Path, line: &str) -> Option<Output> {
    let output = drystone(folder, line).output().unwrap();
    if said(&output).contains("no graphics device") {
        eprintln!("SKIPPED, there is no graphics device: {}", said(&output));
        return None;
    }
    assert_eq!(output.status.code(), Some(0), "{line}: {}", said(&output));
    Some(output)
}

/// Size and points of a PNG.
fn read_png(path: &Path) -> (u32, u32, Vec<u8>) {
    let mut reader =
        png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut points = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut points).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (info.width, info.height, points)
}

/// Mean color of the points of a rectangle given in parts of the picture.
fn mean((width, height, points): &(u32, u32, Vec<u8>), x: [f64; 2], y: [f64; 2]) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for (i, point) in (0_u32..).zip(points.chunks_exact(3)) {
        let (px, py) =
            (f64::from(i % width) / f64::from(*width), f64::from(i / width) / f64::from(*height));
        if (x[0]..x[1]).contains(&px) && (y[0]..y[1]).contains(&py) {
            count += 1.0;
            for (sum, c) in sum.iter_mut().zip(point) {
                *sum += f64::from(*c);
            }
        }
    }
    sum.map(|s| s / count)
}

#[test]
fn a_picture_shows_the_scene_and_is_the_same_every_time() {
    let folder = folder("render_still");
    let line = "simulate stack:n=3 --steps 5 --size 160x120 --camera front --render";
    for name in ["a.png", "b.png"] {
        if drawn(&folder, &format!("{line} {name}")).is_none() {
            return;
        }
    }
    let (a, b) = (read_png(&folder.join("a.png")), read_png(&folder.join("b.png")));
    assert_eq!((a.0, a.1), (160, 120));
    assert_eq!(a, b);
    // Three boxes on each other fill 84 % of the height in the middle; beside them is sky, which is
    // bluer.
    let (boxes, sky) = (mean(&a, [0.45, 0.55], [0.1, 0.9]), mean(&a, [0.0, 0.2], [0.0, 0.3]));
    assert!(sky[2] > sky[0] && sky[2] > boxes[2] + 10.0, "boxes {boxes:?}, sky {sky:?}");
}

#[test]
fn what_is_drawn_does_not_change_the_hash() {
    let folder = folder("render_hash");
    let Some(drawn) = drawn(&folder, "simulate cradle --steps 40 --size 64x48 --render c.gif")
    else {
        return;
    };
    let plain = drystone(&folder, "simulate cradle --steps 40").output().unwrap();
    let hash = |o: &Output| {
        let text = String::from_utf8_lossy(&o.stdout).into_owned();
        text.lines().find(|l| l.starts_with("hash")).map(str::to_owned).unwrap()
    };
    assert_eq!(hash(&drawn), hash(&plain));
}

#[test]
fn films_have_a_frame_for_their_times() {
    let folder = folder("render_film");
    let line = "simulate hello --seconds 0.4 --size 64x48 --render";
    if drawn(&folder, &format!("{line} f-%03d.png --fps 10 --camera turntable")).is_none() {
        return;
    }
    // At 0, 0.1, 0.2, 0.3 and 0.4 s.
    let frames = fs::read_dir(&folder).unwrap().count();
    assert_eq!(frames, 5);
    assert_ne!(read_png(&folder.join("f-001.png")), read_png(&folder.join("f-003.png")));

    drawn(&folder, &format!("{line} f.gif --fps 10"));
    let mut gif =
        gif::DecodeOptions::new().read_info(File::open(folder.join("f.gif")).unwrap()).unwrap();
    assert_eq!((gif.width(), gif.height()), (64, 48));
    let mut delays = Vec::new();
    while let Some(frame) = gif.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    assert_eq!(delays, [10; 5]);

    if Command::new("ffmpeg").arg("-version").output().is_err() {
        eprintln!("SKIPPED, there is no ffmpeg: films as .mp4 and .webm");
        return;
    }
    for name in ["f.mp4", "f.webm"] {
        // An odd size: most codecs need even ones.
        drawn(&folder, &format!("simulate hello --seconds 0.4 --size 65x49 --render {name}"));
        let mut head = [0; 12];
        File::open(folder.join(name)).unwrap().read_exact(&mut head).unwrap();
        assert!(
            head[4..8] == *b"ftyp" || head[..4] == [0x1A, 0x45, 0xDF, 0xA3],
            "{name}: {head:?}"
        );
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_in_a_line() {
    let folder = folder("render_refused");
    if drawn(&folder, "simulate hello --steps 1 --size 8x8 --render a.png").is_none() {
        return;
    }
    for (line, status, expected) in [
        ("simulate hello --steps 1 --render none/a.png", 1, "cannot be written"),
        ("simulate hello --steps 1 --render a.jpg", 2, "expected"),
        ("simulate hello --steps 1 --size 16384x16384 --render a.png", 1, "picture size must be"),
        ("simulate hello --steps 1 --trace a.png --render a.png", 2, "same file"),
    ] {
        let output = drystone(&folder, line).output().unwrap();
        let (code, text) = (output.status.code(), said(&output));
        assert!(code == Some(status) && text.contains(expected), "{line}: {code:?} {text}");
    }
    let no_ffmpeg = drystone(&folder, "simulate hello --steps 1 --render a.mp4")
        .env("PATH", &folder)
        .output()
        .unwrap();
    assert_eq!(no_ffmpeg.status.code(), Some(1));
    assert!(said(&no_ffmpeg).contains("apt-get install ffmpeg"), "{}", said(&no_ffmpeg));
    let no_driver = drystone(&folder, "simulate hello --steps 1 --render a.png")
        .env("VK_DRIVER_FILES", "/none")
        .env("VK_ICD_FILENAMES", "/none")
        .output()
        .unwrap();
    if no_driver.status.code() != Some(0) {
        assert!(said(&no_driver).contains("mesa-vulkan-drivers"), "{}", said(&no_driver));
        assert_eq!((no_driver.status.code(), said(&no_driver).lines().count()), (Some(1), 1));
    }
}

#[cfg(feature = "view")]
#[test]
fn without_a_display_the_window_says_what_to_do() {
    let folder = folder("view_no_display");
    let mut command = drystone(&folder, "view hello");
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    if !cfg!(target_os = "linux") {
        return;
    }
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let text = said(&output);
    assert!(text.contains("no display") && text.contains("--render"), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
}

#[cfg(feature = "view")]
#[test]
fn a_film_is_a_file_with_animations() {
    let folder = folder("view_film");
    let view = |line: &str| {
        let mut command = drystone(&folder, line);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let output = command.output().unwrap();
        (output.status.code(), said(&output))
    };
    let (code, text) = view("view hello --film");
    assert!(code == Some(2) && text.contains("--film is for glTF files"), "{text}");
    let bake = drystone(&folder, "simulate hello --steps 30 --bake film.glb").output().unwrap();
    assert_eq!(bake.status.code(), Some(0), "{}", said(&bake));
    let (code, text) = view("view film.glb --film");
    if cfg!(target_os = "linux") {
        assert!(code == Some(1) && text.contains("no display"), "{text}");
    }
    fs::write(folder.join("still.gltf"), STILL).unwrap();
    let (code, text) = view("view still.gltf --film");
    assert!(code == Some(1) && text.contains("no animation"), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
}

/// A ball that nothing moves.
#[cfg(feature = "view")]
const STILL: &str = r#"{"asset": {"version": "2.0"}, "nodes": [{"extensions": {"KHR_physics_rigid_bodies":
    {"motion": {}, "collider": {"geometry": {"shape": 0}}}}}],
    "extensionsUsed": ["KHR_physics_rigid_bodies", "KHR_implicit_shapes"],
    "extensions": {"KHR_implicit_shapes": {"shapes": [{"type": "sphere", "sphere": {"radius": 0.5}}]}}}"#;

/// Ends a program when the test does, whatever becomes of it.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The display in memory: room for the whole window [px].
const SCREEN: &str = "1280x800";
const SCREEN_DEPTH: &str = "1280x800x24";

/// A display in memory, and its name.
fn display() -> Option<(Ended, String)> {
    let mut server = Command::new("Xvfb");
    server.args(["-displayfd", "1", "-screen", "0", SCREEN_DEPTH, "-nolisten", "tcp"]);
    let mut server = Ended(
        server.stdout(Stdio::piped()).stderr(Stdio::null()).stdin(Stdio::null()).spawn().ok()?,
    );
    let mut number = String::new();
    let mut pipe = server.0.stdout.take()?;
    let mut byte = [0];
    while pipe.read(&mut byte).ok()? == 1 && byte[0] != b'\n' {
        number.push(char::from(byte[0]));
    }
    (!number.is_empty()).then(|| (server, format!(":{number}")))
}

/// The content of the display.
fn screenshot(display: &str, path: &Path) -> Option<(u32, u32, Vec<u8>)> {
    let mut grab = Command::new("ffmpeg");
    grab.args(["-loglevel", "error", "-nostdin", "-y", "-f", "x11grab", "-video_size", SCREEN]);
    grab.args(["-i", display, "-frames:v", "1", "-pix_fmt", "rgb24"]).arg(path);
    grab.output().ok().filter(|o| o.status.success()).map(|_| read_png(path))
}

/// A window on a display in memory, and the hands of its user.
#[cfg(feature = "view")]
struct Driven {
    _server: Ended,
    display: String,
    window: Ended,
    folder: PathBuf,
}

#[cfg(feature = "view")]
impl Driven {
    /// Opens the window. None, and a line that says so, where something is missing.
    fn open(folder: &Path, line: &str) -> Option<Self> {
        drawn(folder, "simulate hello --steps 1 --size 8x8 --render a.png")?;
        let Some((server, display)) = display() else {
            eprintln!("SKIPPED, there is no Xvfb: the window");
            return None;
        };
        if screenshot(&display, &folder.join("window.png")).is_none() {
            eprintln!("SKIPPED, there is no ffmpeg that reads a display: the window");
            return None;
        }
        if Command::new("xdotool").arg("version").output().is_err() {
            eprintln!("SKIPPED, there is no xdotool: the window");
            return None;
        }
        let mut command = drystone(folder, line);
        command.env("DISPLAY", &display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let errors = File::create(folder.join("stderr")).unwrap();
        let window = Ended(command.stderr(errors).spawn().unwrap());
        Some(Self { _server: server, display, window, folder: folder.to_owned() })
    }

    /// Waits until something is so.
    fn wait(&mut self, what: &str, mut so: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        while !so(self) {
            let ended = self.window.0.try_wait().unwrap();
            let text = fs::read_to_string(self.folder.join("stderr")).unwrap();
            assert!(ended.is_none(), "the window closed: {ended:?} {text}");
            assert!(start.elapsed() < Duration::from_secs(90), "{what}: {}", self.title());
            sleep(Duration::from_millis(200));
        }
    }

    /// The window as it looks now; kept to be looked at.
    fn look(&self, name: &str) -> (u32, u32, Vec<u8>) {
        screenshot(&self.display, &self.folder.join(name)).unwrap()
    }

    /// Moves the hands.
    fn hands(&self, line: &str) -> String {
        let mut command = Command::new("xdotool");
        let output = command.args(line.split(' ')).env("DISPLAY", &self.display).output().unwrap();
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    fn title(&self) -> String {
        self.hands("search --name drystone getwindowname")
    }
}

/// How many points have nearly this color.
#[cfg(feature = "view")]
fn points_of(picture: &(u32, u32, Vec<u8>), color: [u8; 3]) -> usize {
    let near = |p: &&[u8]| p.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 12);
    picture.2.chunks_exact(3).filter(near).count()
}

#[cfg(feature = "view")]
#[test]
fn a_window_is_driven_by_mouse_and_keys_on_a_display_in_memory() {
    let folder = folder("view_window");
    let Some(mut w) = Driven::open(&folder, "view stack:n=1 --paused --threads 1") else { return };
    // The window stands at the corner of the screen: its sky, bright, and bluer than red.
    let sky = |w: &mut Driven| mean(&w.look("window.png"), [0.02, 0.1], [0.02, 0.1]);
    w.wait("nothing is drawn", |w| {
        let sky = sky(w);
        sky[2] > sky[0] && sky[0] > 80.0
    });
    w.wait("the title is another", |w| w.title() == "stack:n=1 - soft-step - drystone");

    // Take hold of the cube, in the middle of the picture: a line shows where it is pulled.
    let line = [255, 176, 0];
    assert_eq!(points_of(&w.look("before.png"), line), 0);
    w.hands("mousemove 485 400");
    w.hands("mousedown 1");
    for at in ["500 380", "560 330", "640 260"] {
        w.hands(&format!("mousemove {at}"));
    }
    w.wait("the cube is not held", |w| points_of(&w.look("held.png"), line) > 300);
    // Let time run: it follows, and the line is short.
    w.hands("search --name drystone windowfocus");
    w.hands("key space");
    w.wait("the cube does not follow", |w| points_of(&w.look("pulled.png"), line) < 150);
    let before = mean(&read_png(&folder.join("before.png")), [0.49, 0.51], [0.28, 0.36]);
    let after = mean(&read_png(&folder.join("pulled.png")), [0.49, 0.51], [0.28, 0.36]);
    assert!(before.iter().zip(after).any(|(b, a)| (b - a).abs() > 10.0), "{before:?} {after:?}");
    w.hands("mouseup 1");

    w.hands("key m");
    w.wait("the method stays", |w| w.title() == "stack:n=1 - soft-step-relax - drystone");
    w.hands("key v");
    w.wait("there is one half", |w| w.title().contains("soft-step-relax | soft-step-relax"));
    w.hands("key m");
    w.wait("both have one method", |w| {
        let title = w.title();
        title.ends_with(" | soft-step-relax - drystone") && !title.contains("relax | ")
    });

    // Other scenes by the menu: a broken file gives a message, and all stays; one with a broken
    // image opens, with a note.
    fs::write(folder.join("broken.glb"), b"glTF\x02\0\0\0 and then nothing").unwrap();
    let broken = plate(Some("data:image/png;base64,iVBORw0KGgo"), "");
    fs::write(folder.join("noted.gltf"), broken).unwrap();
    for (typed, expected, told) in [
        ("broken.glb", "stack:n=1 -", true),
        ("noted.gltf", "noted -", true),
        ("arch", "arch -", false),
    ] {
        w.hands("mousemove 1010 22");
        w.hands("click 1");
        w.look("menu.png");
        sleep(Duration::from_millis(1500));
        w.look("menu.png");
        w.hands("mousemove 900 49");
        w.hands("click 1");
        sleep(Duration::from_millis(500));
        w.hands("key ctrl+a");
        w.hands(&format!("type --delay 60 {typed}"));
        w.hands("key Return");
        let orange = [255, 140, 90];
        w.wait("no answer", |w| {
            let message = points_of(&w.look(&format!("{typed}.png")), orange) > 20;
            message == told && w.title().starts_with(expected)
        });
        // The message while it opens has the same color, and lasts no longer than that takes.
        sleep(Duration::from_millis(1000));
        let told_still = points_of(&w.look(&format!("{typed}.png")), orange) > 20;
        assert_eq!(told_still, told, "{typed}");
    }
}

fn base64_of(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0, |w, i| w << 8 | usize::from(*chunk.get(i).unwrap_or(&0)));
        for i in 0..=chunk.len() {
            text.push(char::from(LETTERS[word >> (18 - 6 * i) & 63]));
        }
    }
    text
}

/// A glTF file of a plate that stands at rest and faces +z. An image of four colors is on it: red,
/// green in the upper row, blue, white in the lower one. `image` is the image's URI, if it is to be
/// another one; `material` goes into the material.
fn plate(image: Option<&str>, material: &str) -> String {
    let numbers: [f32; 20] = [
        -1.0, 0.0, 0.5, 1.0, 0.0, 0.5, 1.0, 2.0, 0.5, -1.0, 2.0, 0.5, // places
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, // texture coordinates
    ];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3]);
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    let points = [200, 0, 0, 0, 200, 0, 0, 0, 200, 200, 200, 200];
    encoder.write_header().unwrap().write_image_data(&points).unwrap();
    let image =
        image.map_or_else(|| format!("data:image/png;base64,{}", base64_of(&png)), str::to_owned);
    let physics = "KHR_physics_rigid_bodies";
    format!(
        r#"{{"asset": {{"version": "2.0", "extras": {{"gravity": [0, 0, 0]}}}},
        "buffers": [{{"byteLength": 86, "uri": "data:a/b;base64,{}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 32}},
            {{"buffer": 0, "byteOffset": 80, "byteLength": 6}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}},
            {{"bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR"}}],
        "images": [{{"uri": "{image}"}}], "samplers": [{{"magFilter": 9728}}],
        "textures": [{{"source": 0, "sampler": 0}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}, "metallicFactor": 0}} {material}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
        "extensionsUsed": ["KHR_implicit_shapes", "{physics}"],
        "extensions": {{"KHR_implicit_shapes": {{"shapes": [{{"type": "box", "box": {{"size": [2, 2, 1]}}}}]}}, "{physics}": {{}}}},
        "nodes": [{{"mesh": 0, "children": [1], "extensions": {{"{physics}": {{"motion": {{}}}}}}}},
            {{"translation": [0, 1, 0], "extensions": {{"{physics}": {{"collider": {{"geometry": {{"shape": 0}}}}}}}}}}],
        "scene": 0, "scenes": [{{"nodes": [0]}}]}}"#,
        base64_of(&bytes)
    )
}

/// The middles of the quarters of the plate in a picture from its front: upper row first.
fn quarters(path: &Path) -> [[f64; 3]; 4] {
    let picture = read_png(path);
    [(0.46, 0.4), (0.54, 0.4), (0.46, 0.6), (0.54, 0.6)]
        .map(|(x, y)| mean(&picture, [x - 0.01, x + 0.01], [y - 0.02, y + 0.02]))
}

#[test]
fn a_gltf_scene_is_drawn_with_its_own_meshes_and_images() {
    let folder = folder("render_visuals");
    fs::write(folder.join("plate.gltf"), plate(None, "")).unwrap();
    let line = "simulate plate.gltf --steps 1 --size 320x180 --camera eye=0:1:8,at=0:1:0 --render";
    for name in ["a.png", "b.png"] {
        if drawn(&folder, &format!("{line} {name}")).is_none() {
            return;
        }
    }
    assert_eq!(read_png(&folder.join("a.png")), read_png(&folder.join("b.png")));
    let [red, green, blue, white] = quarters(&folder.join("a.png"));
    // Light is warm above and cold below, and never turns one of these into another.
    for (name, color, most) in [("red", red, 0), ("green", green, 1), ("blue", blue, 2)] {
        let others = color.iter().enumerate().filter(|(i, _)| *i != most).map(|(_, c)| *c);
        assert!(others.fold(0.0, f64::max) + 60.0 < color[most], "{name} is {color:?}");
    }
    let (low, high) =
        (white.iter().copied().fold(255.0, f64::min), white.iter().copied().fold(0.0, f64::max));
    assert!(low > 100.0 && high - low < 60.0, "white is {white:?}");
    // With its collision shape in place of the mesh there is one color.
    drawn(&folder, &format!("{line} c.png --colliders"));
    let shape = quarters(&folder.join("c.png"));
    let apart =
        |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
    assert!(shape.iter().all(|color| apart(color, &shape[0]) < 12.0), "{shape:?}");
}

#[test]
fn the_opacity_and_the_sides_of_materials_are_seen() {
    let folder = folder("render_opacity");
    let line = "--steps 1 --size 320x180 --render";
    let (front, back) = ("--camera eye=0:1:8,at=0:1:0", "--camera eye=0:1:-8,at=0:1:0");
    let mut pictures = Vec::new();
    for (name, material, camera) in [
        ("solid", "", front),
        (
            "masked",
            r#", "alphaMode": "MASK", "alphaCutoff": 1.0, "emissiveFactor": [0, 0, 0]"#,
            front,
        ),
        ("behind", "", back),
        ("both", r#", "doubleSided": true"#, back),
        ("bright", r#", "emissiveFactor": [1, 1, 1]"#, front),
    ] {
        fs::write(folder.join(format!("{name}.gltf")), plate(None, material)).unwrap();
        let png = format!("{name}.png");
        if drawn(&folder, &format!("simulate {name}.gltf {camera} {line} {png}")).is_none() {
            return;
        }
        pictures.push(quarters(&folder.join(png)));
    }
    let [solid, masked, behind, both, bright] = pictures.try_into().unwrap();
    let is_red = |c: [f64; 3]| c[0] > c[1] + 60.0 && c[0] > c[2] + 60.0;
    assert!(is_red(solid[0]) && is_red(masked[0]), "an opacity of 1 is not below 1");
    assert!(!is_red(behind[0]) && !is_red(behind[1]), "from behind there is nothing: {behind:?}");
    assert!(is_red(both[1]), "the other way around from behind: {both:?}");
    assert!(bright.iter().all(|c| c.iter().all(|c| *c > 240.0)), "it shines: {bright:?}");
}

#[test]
fn a_broken_image_is_told_of_and_the_plate_is_plain() {
    let folder = folder("render_broken_image");
    fs::write(folder.join("plate.gltf"), plate(Some("data:image/png;base64,iVBORw0KGgo"), ""))
        .unwrap();
    let info = drystone(&folder, "info plate.gltf").output().unwrap();
    let told = String::from_utf8_lossy(&info.stdout).into_owned();
    assert!(told.contains("images[0].uri: is a broken PNG image"), "{told}");
    let line =
        "simulate plate.gltf --steps 1 --size 320x180 --camera eye=0:1:8,at=0:1:0 --render a.png";
    if drawn(&folder, line).is_none() {
        return;
    }
    let plain = quarters(&folder.join("a.png"));
    assert!(plain.iter().flatten().all(|c| *c > 100.0), "white: {plain:?}");
}

#[test]
fn normal_textures_bend_the_light_and_occlusion_textures_keep_it_off() {
    let folder = folder("render_relief");
    // The sun stands at the front, to the left and above. How bright the plate is, of an image of
    // one color.
    let bright = |color: [u8; 3], material: &str| {
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&color).unwrap();
        let image = format!("data:image/png;base64,{}", base64_of(&png));
        fs::write(folder.join("plate.gltf"), plate(Some(&image), material)).unwrap();
        let line = "simulate plate.gltf --steps 1 --size 320x180 --camera eye=0:1:8,at=0:1:0 --render a.png";
        drawn(&folder, line)?;
        Some(quarters(&folder.join("a.png")).iter().flatten().sum::<f64>() / 12.0)
    };
    let normal = |scale: f32| format!(r#", "normalTexture": {{"index": 0, "scale": {scale}}}"#);
    for (what, color, toward) in [("right", [218, 128, 218], -1.0), ("up", [128, 218, 218], 1.0)] {
        let Some(plain) = bright(color, "") else { return };
        let [lit, unlit] = [toward, -toward].map(|scale| bright(color, &normal(scale)).unwrap());
        assert!(lit > unlit + 20.0 && lit > plain, "{what}: {lit} {plain} {unlit}");
    }
    let open = bright([100, 200, 200], "").unwrap();
    let kept_off = bright([100, 200, 200], r#", "occlusionTexture": {"index": 0}"#).unwrap();
    assert!(kept_off < open - 8.0 && kept_off > 0.5 * open, "{kept_off} {open}");
}
