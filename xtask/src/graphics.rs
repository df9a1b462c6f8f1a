//! Pictures: the software renderer that tests draw with, and `cargo xtask gallery`.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, cargo, root, run_to_end};

/// Debian's packages: a Vulkan driver that needs no GPU, a display in memory, and what draws windows
/// and reads them.
const PACKAGES: [&str; 8] = [
    "mesa-vulkan-drivers",
    "libvulkan1",
    "xvfb",
    "ffmpeg",
    "libxcursor1",
    "libxi6",
    "libxrandr2",
    "libxkbcommon-x11-0",
];

/// Makes sure, where that can be done, that tests can draw. Without it they say that they are left
/// out, so this never fails.
pub fn prepare() -> Outcome {
    let drivers = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let found = drivers.iter().any(|folder| {
        std::fs::read_dir(Path::new(folder)).is_ok_and(|mut files| files.next().is_some())
    });
    let xvfb = Command::new("Xvfb").arg("-version").output().is_ok();
    if found && xvfb {
        return Ok(());
    }
    println!("   installing {}", PACKAGES.join(" "));
    let mut install = Command::new("apt-get");
    install.args(["install", "--yes", "--quiet", "--no-install-recommends"]).args(PACKAGES);
    if let Err(why) = run_to_end(&mut install) {
        println!("   {why}; tests of pictures and windows will be left out where they cannot run");
    }
    Ok(())
}

/// A picture of the gallery: file, scene, seconds, camera.
type Row = (&'static str, &'static str, &'static str, &'static str);

const GALLERY: [Row; 10] = [
    ("wall", "wall:ball=1", "1.6", "auto"),
    ("pyramid", "pyramid:base=20", "2", "auto"),
    ("arch", "arch", "4", "auto"),
    ("card_house", "card_house", "4", "auto"),
    ("jenga", "jenga", "3", "auto"),
    ("pile", "pile:n=200", "5", "auto"),
    ("washer", "washer", "4", "auto"),
    ("cradle", "cradle", "0.55", "auto"),
    ("bridge", "bridge", "4", "auto"),
    ("junkyard", "junkyard", "5", "auto"),
];

/// Draws the pictures of `docs/gallery`.
pub fn gallery() -> Outcome {
    let folder = root().join("docs/gallery");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, scene, seconds, camera) in GALLERY {
        println!("   {name}");
        let file = folder.join(format!("{name}.png"));
        let mut command = cargo();
        command.args(["run", "--quiet", "--release", "--package", "drystone-app", "--"]);
        command.args(["simulate", scene, "--seconds", seconds, "--size", "640x360"]);
        run_to_end(command.args(["--camera", camera, "--render"]).arg(file))?;
    }
    Ok(())
}
