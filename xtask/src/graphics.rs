//! The software renderer for tests that draw.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, run_to_end};

/// Debian's packages: a Vulkan driver that needs no GPU, a virtual display, and the libraries and
/// tools that draw windows, capture them and move the mouse.
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

/// Installs the renderer if possible, so that tests can draw. Tests that cannot draw report that
/// they were skipped, so this never fails.
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
