//! `cargo xtask web`: the viewer for browsers, built into one folder and tested in one.

mod browser;
mod build;
mod server;
mod socket;
mod test;
mod textured;

use std::path::PathBuf;

use crate::{Outcome, ci, target};

/// Builds and tests, or does only one of them, or serves the folder.
pub fn run(words: &[&str]) -> Outcome {
    match words {
        [] => build::run().and_then(|()| test::run(&[])),
        ["build"] => build::run(),
        ["test", names @ ..] => test::run(names),
        ["serve"] => serve("8080"),
        ["serve", port] => serve(port),
        _ => Err(format!(
            "cargo xtask web {}: expected build, test [PART…], serve [PORT]",
            words.join(" ")
        )),
    }
}

/// The stage of `cargo xtask ci`. It runs only on request, by its name or by the environment:
/// without earlier builds it takes longer than all other stages together.
pub fn check() -> Outcome {
    if ci::wanted("web", "DRYSTONE_CI_WEB") {
        // Without a network the other stages can still be checked.
        if let Err(why) = build::prepare() {
            println!(
                "   SKIPPED: the viewer in a browser; what builds and tests it cannot be had: {why}"
            );
            return Ok(());
        }
        return run(&[]);
    }
    println!(
        "   SKIPPED: the viewer in a browser; `cargo xtask ci web` or DRYSTONE_CI_WEB=1 runs it"
    );
    Ok(())
}

fn serve(port: &str) -> Outcome {
    let port = port.parse().map_err(|e| format!("{port}: {e}"))?;
    let server = server::Server::start(port, vec![folder()])?;
    println!("http://{}/", server.address());
    server.wait();
    Ok(())
}

/// The folder for the web server.
fn folder() -> PathBuf {
    target().join("web")
}
