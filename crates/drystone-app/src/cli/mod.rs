//! The command line.

mod measure;
mod parse;
mod scene;
mod simulate;
mod source;

use clap::{Parser, Subcommand};

pub(crate) use self::measure::{Bench, Compare, Validate};
pub(crate) use self::parse::is_rate;
#[cfg(feature = "view")]
pub(crate) use self::scene::Overlay;
pub(crate) use self::scene::{Convert, Info, View};
pub(crate) use self::simulate::{Rendering, Replay, Simulate};
pub(crate) use self::source::{AutoColliders, Base, Length, Reading, Settings, Source, Workers};

const EXAMPLES: &str = "\
Examples:
  drystone simulate pyramid --bake pyramid.glb
  drystone simulate pyramid:base=40 --seconds 20 --threads 4
  drystone simulate scene.gltf --trace motion.csv --every 6 --report report.json
  drystone simulate scene.gltf --set gravity=0,-1.62,0 --set sleep.enabled=false
  drystone simulate wall:ball=1 --render wall.mp4
  drystone view wall:ball=1
  drystone info scene.gltf
  drystone bench --scene large_pyramid,washer --threads 1,2
  drystone compare stack --with soft-step --with sequential-impulses:method.sweeps=20
  drystone validate --short
  drystone convert robot.urdf robot.json
  drystone scenes";

/// A 3D rigid-body physics engine: simulates a scene and writes what happened.
#[derive(Debug, Parser)]
#[command(name = "drystone", version, about, after_help = EXAMPLES)]
pub(crate) struct Cli {
    /// The command.
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The commands of the program.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate a scene and report what happened
    Simulate(Box<Simulate>),
    /// Open a window on a scene: watch it, stop it, turn time back, pull and shoot at it
    View(View),
    /// Run a recording again, and report where the results differ
    Replay(Replay),
    /// Measure how long a step takes: the mean of each run, its median over runs
    Bench(Bench),
    /// Run one scene by several methods and settings, side by side
    Compare(Compare),
    /// List the built-in scenes: name, bodies, what each shows, its parameters
    Scenes,
    /// List the stepping methods
    Methods,
    /// Report what was read of a scene, and what was ignored and why
    Info(Info),
    /// Write a scene as a file: of the own format, or glTF with physics
    Convert(Convert),
    /// Run the tests with a known result and print how far off each is
    Validate(Validate),
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, Command};

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for bad in [
            "--hz 0",
            "--hz -1",
            "--hz nan",
            "--hz inf",
            "--hz 1e-30",
            "--seconds -1",
            "--seconds nan",
            "--seconds inf",
            "--steps -1",
            "--steps 1.5",
            "--every 0",
            "--threads 0",
            "--threads 257",
            "--substeps 0",
            "--substeps 257",
            "--set x",
            "--set =1",
            "--method x",
            "--simd x",
            "--bake x.obj",
            "--seconds 1 --steps 1",
            "--every 2 --snapshot",
        ] {
            let line = format!("drystone simulate hello {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
        for bad in
            ["--threads 0", "--threads 1,", "--threads 1,x", "--runs 0", "--steps 1", "hello"]
        {
            let line = format!("drystone bench {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
        let good = "drystone simulate hello --hz 0.5 --seconds 0 --every 3 --set a=b=c --set d=";
        let command = Cli::try_parse_from(good.split(' ')).unwrap().command;
        let expected = ("a".to_owned(), "b=c".to_owned());
        assert!(matches!(command, Command::Simulate(args) if args.settings.set[0] == expected));
    }

    #[cfg(feature = "render")]
    #[test]
    fn pictures_that_cannot_be_are_refused() {
        for bad in [
            "--render x.jpg",
            "--render x",
            "--render x.png --size 0x1",
            "--render x.png --size 10",
            "--render x.png --size 99999x1",
            "--render x.png --camera behind",
            "--render x.gif --fps 0",
            "--size 10x10",
            "--camera front",
        ] {
            let line = format!("drystone simulate hello {bad}");
            let result = Cli::try_parse_from(line.split(' '));
            assert_eq!(result.unwrap_err().exit_code(), 2, "{bad}");
        }
    }
}
