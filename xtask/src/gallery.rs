//! `cargo xtask gallery`: the pictures and films of docs/gallery, and the page that shows them.

use std::fmt::Write;
use std::fs;
use std::process::{Command, Stdio};

use crate::{Outcome, cargo, root, run_to_end, target, write_whole};

/// A scene of the gallery: the name of its files, a caption, the arguments of the run except its
/// length, and the lengths of the picture's and the film's runs [s].
struct Exhibit {
    name: &'static str,
    what: &'static str,
    run: &'static str,
    picture: Option<f32>,
    film: Option<f32>,
}

const fn exhibit(
    name: &'static str,
    what: &'static str,
    run: &'static str,
    picture: Option<f32>,
    film: Option<f32>,
) -> Exhibit {
    Exhibit { name, what, run, picture, film }
}

const GALLERY: [Exhibit; 17] = [
    exhibit(
        "wall",
        "A ball through a wall of bricks",
        "wall:ball=1 --camera eye=3.6:2.9:8.6,at=-0.1:1.5:0",
        Some(1.6),
        Some(2.4),
    ),
    exhibit("cloth", "A cloth that a ball flies into", "cloth:hang=1,n=30", Some(0.75), Some(3.0)),
    exhibit("drape", "A cloth over a ball", "cloth:n=30", Some(2.0), None),
    exhibit("domino", "A spiral of dominoes", "domino", None, Some(4.0)),
    exhibit("bridge", "A bridge of planks on joints", "bridge", Some(4.0), Some(3.0)),
    exhibit("ragdolls", "Limp people of 23 parts", "ragdolls:n=8", None, Some(2.4)),
    exhibit("fracture", "What breaks", "fracture", None, Some(2.4)),
    exhibit("wrecking_ball", "A ball on a chain", "wrecking_ball", None, Some(3.0)),
    exhibit("rings", "Rings over pegs", "rings:rings=60", None, Some(3.0)),
    exhibit("cradle", "Newton's cradle", "cradle", Some(0.55), Some(2.4)),
    exhibit("arch", "An arch of stones without mortar", "arch", Some(4.0), None),
    exhibit("card_house", "A house of cards", "card_house", Some(4.0), None),
    exhibit("jenga", "A tower of planks", "jenga", Some(3.0), None),
    exhibit("pyramid", "A pyramid of 210 boxes", "pyramid:base=20", Some(2.0), None),
    exhibit("pile", "A heap of all shapes in a tray", "pile:n=500", Some(5.0), Some(3.0)),
    exhibit("washer", "8,000 cubes in a turning drum", "washer", Some(4.0), None),
    exhibit("junkyard", "10,584 rocks in a yard, stirred by a pillar", "junkyard", Some(5.0), None),
];

/// Sizes of pictures and films [px]; small, because the gallery is part of every clone.
const PICTURE: &str = "640x360";
const FILM: &str = "400x225";
/// Frames per second of a film: a GIF counts in hundredths of a second.
const FPS: &str = "12.5";
/// Maximum size of all files together [bytes].
const MOST_BYTES: u64 = 6_000_000;

/// Draws all pictures and films, or only the scenes with these names, and writes the page.
pub fn run(names: &[&str]) -> Outcome {
    if let Some(unknown) = names.iter().find(|n| GALLERY.iter().all(|e| e.name != **n)) {
        return Err(format!("{unknown}: the gallery has no such scene"));
    }
    let folder = root().join("docs/gallery");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut build = cargo();
    build.args(["build", "--quiet", "--release", "--package", "drystone-app"]);
    run_to_end(build.args(["--no-default-features", "--features", "render"]))?;
    let wanted = |e: &&Exhibit| names.is_empty() || names.contains(&e.name);
    for exhibit in GALLERY.iter().filter(wanted) {
        for (kind, seconds) in [("png", exhibit.picture), ("gif", exhibit.film)] {
            let Some(seconds) = seconds else { continue };
            let file = format!("{}.{kind}", exhibit.name);
            println!("   {file}");
            let size = if kind == "gif" { FILM } else { PICTURE };
            let mut command = Command::new(target().join("release/drystone"));
            command.current_dir(root()).arg("simulate").args(exhibit.run.split(' '));
            command.args(["--seconds", &seconds.to_string(), "--size", size]);
            if kind == "gif" {
                command.args(["--fps", FPS]);
            }
            run_to_end(command.arg("--render").arg(folder.join(file)).stdout(Stdio::null()))?;
        }
    }
    let file = folder.join("README.md");
    write_whole(&file, &page())?;
    let sizes = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let bytes: u64 = sizes.flatten().filter_map(|e| e.metadata().ok()).map(|m| m.len()).sum();
    println!("   {}: {} kB", folder.display(), bytes.div_ceil(1000));
    if bytes > MOST_BYTES {
        return Err(format!("the gallery has {bytes} bytes, the maximum is {MOST_BYTES}"));
    }
    Ok(())
}

/// The page of the gallery.
fn page() -> String {
    let mut page = "# Gallery\n\n\
        Drawn by `cargo xtask gallery`, which writes this page too; `cargo xtask gallery wall` draws one scene again. Each is a run of\n\
        `drystone simulate SCENE --render FILE`, with the camera that finds its place by itself where nothing is said of it.\n"
        .to_owned();
    for exhibit in &GALLERY {
        let files = [("gif", exhibit.film), ("png", exhibit.picture)];
        let files = files.into_iter().filter_map(|(kind, seconds)| seconds.map(|_| kind));
        let _ = write!(page, "\n{}: `{}`\n", exhibit.what, exhibit.run);
        for kind in files {
            let _ = write!(page, "\n![{}]({}.{kind})\n", exhibit.what, exhibit.name);
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{GALLERY, page};

    #[test]
    fn the_page_shows_each_scene_once_and_ten_move() {
        let names: BTreeSet<_> = GALLERY.iter().map(|e| e.name).collect();
        assert_eq!(names.len(), GALLERY.len());
        assert!(GALLERY.iter().all(|e| e.picture.is_some() || e.film.is_some()));
        assert_eq!(GALLERY.iter().filter(|e| e.film.is_some()).count(), 10);
        assert!(GALLERY.iter().all(|e| page().contains(&format!("({}.", e.name))));
    }
}
