//! Pictures: the software renderer that tests draw with, and `cargo xtask gallery`.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::{Outcome, cargo, root, run_to_end};

/// Debian's packages: a Vulkan driver that needs no GPU, a display in memory, and what draws windows
/// reads them and moves their mouse.
const PACKAGES: [&str; 9] = [
    "mesa-vulkan-drivers",
    "libvulkan1",
    "xvfb",
    "xdotool",
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
    let runs = |program: &str, arg: &str| Command::new(program).arg(arg).output().is_ok();
    if found && runs("Xvfb", "-version") && runs("xdotool", "version") {
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

/// The gallery: file, and the run that it shows.
const GALLERY: [(&str, &str); 11] = [
    ("wall.png", "wall:ball=1 --seconds 1.6"),
    ("pyramid.png", "pyramid:base=20 --seconds 2"),
    ("arch.png", "arch --seconds 4"),
    ("card_house.png", "card_house --seconds 4"),
    ("jenga.png", "jenga --seconds 3"),
    ("pile.png", "pile:n=500 --seconds 5"),
    ("washer.png", "washer --seconds 4"),
    ("cradle.png", "cradle --seconds 0.55"),
    ("bridge.png", "bridge --seconds 4"),
    ("junkyard.png", "junkyard --seconds 5"),
    ("wall.gif", "wall:ball=1 --seconds 2.4 --fps 12.5 --camera eye=3.6:2.9:8.6,at=-0.1:1.5:0"),
];

/// Sizes of what the gallery holds [px]: it is part of every clone.
const PICTURE: &str = "640x360";
const FILM: &str = "400x225";

/// Draws the pictures of `docs/gallery`.
pub fn gallery() -> Outcome {
    let folder = root().join("docs/gallery");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, run) in GALLERY {
        println!("   {name}");
        let size = if name.ends_with(".gif") { FILM } else { PICTURE };
        let mut command = cargo();
        command.args(["run", "--quiet", "--release", "--package", "drystone-app", "--"]);
        command.arg("simulate").args(run.split(' ')).args(["--size", size, "--render"]);
        run_to_end(command.arg(folder.join(name)).stdout(Stdio::null()))?;
    }
    Ok(())
}
